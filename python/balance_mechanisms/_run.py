"""Runs: samples as read-only views of the library's memory, metrics, files."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Tuple

import numpy

from balance_mechanisms import _native
from balance_mechanisms._display import Shown, Table, pretty_unit

if TYPE_CHECKING:
    import pandas
    import xarray


class Metric(NamedTuple):
    """The metrics of one quantity's magnitude, in `unit`: its peak and when that is [s], root mean square and mean over time, and range
    (largest minus smallest value; of a vector, of its magnitude). Values up to `round_off` count as 0."""

    quantity: str
    unit: str
    peak: float
    peak_time: float
    rms: float
    mean: float
    range: float
    round_off: float


class PayloadChange(NamedTuple):
    """A payload `taken up` or `set down` during the run, at `time` [s]. Its position then moves at `speed` [m/s] and its body turns
    at `turning` [rad/s]. Actuator efforts before and after [N m or N]. `impact_loss`: the energy that the impact takes [J]; None where
    the motion is prescribed, and no metric includes the impact."""

    payload: str
    change: str
    time: float
    speed: float
    turning: float
    torque_before: numpy.ndarray
    torque_after: numpy.ndarray
    impact_loss: Optional[float] = None


class AdaptationMove(NamedTuple):
    """A counterweight that its motor moved along its body, `start` to `end` [s], `from_` one distance from its place in the spec `to`
    another [m]. Work of the motor and energy that it moved back and forth [J]; peak effort of every actuator meanwhile [N m or N]."""

    counterweight: str
    start: float
    end: float
    from_: float
    to: float
    work: float
    energy: float
    peak_torque: numpy.ndarray


class Quantity(NamedTuple):
    """Description of a sampled quantity: its name, its unit (`mixed`: see `units`, one per joint, actuator, …), its dimensions after `time`.

    `round_off` is what counts as 0, for all or by column; `about` the reference point of a moment [m], or None."""

    name: str
    long_name: str
    unit: str
    units: Tuple[str, ...]
    dimensions: Tuple[str, ...]
    round_off: Tuple[float, ...]
    about: Tuple[float, ...] | None


FIGURES = {"peak": "largest magnitude", "peak_time": "time of the largest magnitude",
           "rms": "root of the time average of the squared magnitude", "mean": "time average of the magnitude",
           "range": "largest minus smallest value (vectors: magnitude)",
           "round_off": "values up to this count as 0 in the figures"}

DIMENSIONS = {"coordinate": "joint coordinate", "joint": "joint", "actuator": "actuated joint coordinate",
              "axis": "axis of the world", "quaternion": "component of the quaternion",
              "sliding": "joint coordinate with a sliding variable", "body": "moving body"}

UNITS = {"coordinate_unit": ("coordinate", "unit of the joint coordinate"),
         "actuator_unit": ("actuator", "unit of the actuator's torque or force"),
         "sliding_unit": ("sliding", "unit of the sliding variable")}


def common_unit(units: List[str]) -> str:
    return "1" if not units else units[0] if len(set(units)) == 1 else "mixed"


class Run(Shown, Mapping[str, numpy.ndarray]):
    """One run along one trajectory: `run.torque` or `run["torque"]`, rows at `run.time`, names and units as in the result file.

    Arrays are read-only views of the library's memory, which is freed with the last of them. World axes, SI units. A notebook shows its
    figures.
    """

    def __init__(self, native: _native.Run) -> None:
        self._native = native

    def __getitem__(self, name: str) -> numpy.ndarray:
        """The samples of a quantity, of one of its columns, named as in `to_dataframe` (`torque[A1]`), or `time`."""
        values = self._native.values(name) if isinstance(name, str) else None
        if values is None and isinstance(name, str):
            values = self._column(name)
        if values is None:
            raise KeyError(f"{name!r}: the run has {', '.join(self)}")
        return values

    def _columns(self) -> Iterator[Tuple[str, str, int]]:
        """Name of every column, its quantity and its place there."""
        for name, one in self.quantities.items():
            units = one.units if one.dimensions == ("actuator",) else ()
            for k, label in enumerate(_column_labels(one.dimensions, self.labels)):
                force = name.startswith("torque") and units and units[k % len(units)] == "N"
                yield (f"force{name[6:]}{label}" if force else name + label), name, k

    def _column(self, wanted: str) -> numpy.ndarray | None:
        names = {wanted, _force_name(wanted)}
        for column, name, k in self._columns():
            if column in names:
                return self[name].reshape(len(self["time"]), -1)[:, k]
        return None

    def __getattr__(self, name: str) -> numpy.ndarray:
        values = None if name.startswith("_") else self._native.values(name)
        if values is None:
            raise AttributeError(f"the run has no {name!r}")
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(["time", *self._native.quantities])

    def __len__(self) -> int:
        return 1 + len(self._native.quantities)

    def __dir__(self) -> List[str]:
        return sorted({*super().__dir__(), *self})

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    def __repr__(self) -> str:
        about = self._native.description
        name = f"{about['title']!r}" + (f" along {about['trajectory']!r}" if about["trajectory"] else "")
        return f"<balance_mechanisms.Run of {name}: {self._native.rows} samples>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        about, time = self.description, self["time"]
        rows, span = len(time), float(time[-1] - time[0]) if len(time) else 0.0
        title = about["title"] + (f" along {about['trajectory']}" if about["trajectory"] else "")
        if self.metrics:
            def shown(one: Metric, value: float) -> float:
                return 0.0 if abs(value) <= one.round_off else value

            table = Table(f"{title}: {rows} samples in {span:.6g} s, {self.energy:.6g} J moved by the actuators",
                          ["quantity", "unit", "peak", "at [s]", "rms", "mean", "range"],
                          [[one.quantity, pretty_unit(one.unit), shown(one, one.peak), one.peak_time, shown(one, one.rms), shown(one, one.mean),
                            shown(one, one.range)] for one in self.metrics.values()])
        elif rows == 1:
            units = self._column_units()
            table = Table(f"{title}: the state at {time[0]:.6g} s", ["quantity", "unit", "value"],
                          [[column, pretty_unit(units[column]), self[name].reshape(-1)[k]] for column, name, k in self._columns()])
        else:
            table = Table(f"{title}: {rows} samples", ["quantity", "unit", "for each"],
                          [[one.long_name, pretty_unit(one.unit), ", ".join(one.dimensions)] for one in self.quantities.values()])
        return [table], list(self.notes)

    @property
    def status(self) -> str:
        """`done`, or a word for why the run ended early."""
        return self._native.status

    @property
    def notes(self) -> List[str]:
        """Notes on the numbers, for people: torques that are not unique, accelerations that jump, …"""
        return self._native.notes

    @property
    def description(self) -> Dict[str, str]:
        """Origin of the run: title, trajectory, law, drive, spec, and the command that reproduces it."""
        return self._native.description

    @property
    def labels(self) -> Dict[str, List[str]]:
        """Names along every dimension except `time`: of joints, actuators, bodies, axes, …"""
        return self._native.labels

    @property
    def quantities(self) -> Dict[str, Quantity]:
        """Descriptions of the sampled quantities."""
        return {name: Quantity(name, one["long_name"], one["unit"], tuple(one["units"]), tuple(one["dimensions"]),
                               tuple(one["round_off"]), tuple(one["about"]) if "about" in one else None)
                for name, one in self._native.quantities.items()}

    @property
    def metrics(self) -> Dict[str, Metric]:
        """Peak, rms, mean and range of every quantity, by its name: `run.metrics["torque[A1]"].peak`, for a slide `force[S]`."""
        return _Metrics((one[0], Metric(*one)) for one in self._native.metrics)

    @property
    def payload_changes(self) -> List[PayloadChange]:
        """Payloads taken up and set down during the run; empty for a run read from a file."""
        return [PayloadChange(*one) for one in self._native.payload_changes]

    @property
    def adaptation_moves(self) -> List[AdaptationMove]:
        """Moves of counterweights (`adapt` in the spec) during the run; empty for a run read from a file."""
        return [AdaptationMove(*one) for one in self._native.adaptation_moves]

    def orders(self, highest: int, fluctuation: float | None = None) -> Dict[str, Any]:
        """Orders of every quantity up to `highest`, for a run in which a joint makes whole turns at constant speed: what `balance simulate
        --orders N --json` prints as `orders`, with a list `rows`.

        :param fluctuation: coefficient of fluctuation of the speed for which a flywheel is wanted
        :raises ValueError: if no joint does, or the motion does not repeat, or there are too few samples
        """
        return json.loads(self._native.orders_json(highest, fluctuation))

    @property
    def energy(self) -> float:
        """Energy moved by the actuators, the integral of the sum of |power| [J]."""
        return self._native.energy

    def text(self) -> str:
        """What `balance simulate` prints."""
        return self._native.text()

    def to_json(self) -> str:
        """What `balance simulate --json` prints."""
        return self._native.json()

    def write(self, path: str | os.PathLike[str], *, force: bool = False, compress: bool = False) -> None:
        """Writes the result file (docs/file-format.md), or a table if the name ends in `.csv`; complete or not at all.

        :param force: overwrite an existing file
        :param compress: compress the HDF5 file (slow)
        :raises FileExistsError: if it exists and `force` is not set
        :raises OSError: if it cannot be written (PermissionError, IsADirectoryError, …), or would replace the spec
        """
        name = os.fspath(path)
        if name.endswith(".csv"):
            if compress:
                raise ValueError("compress: applies only to HDF5 files")
            self._native.write_csv(name, force)
        else:
            self._native.write_hdf5(name, force, compress)

    def to_xarray(self) -> xarray.Dataset:
        """The samples as an `xarray.Dataset`, with names, dimensions, units (`attrs["units"]` of a variable) and attributes as in the
        result file. Nothing is copied.

        :raises ModuleNotFoundError: without xarray
        """
        import xarray

        own = self._native
        coordinates: Dict[str, Any] = {"time": ("time", self["time"], {"units": "s", "long_name": "time"})}
        for dimension, names in own.labels.items():
            coordinates[dimension] = (dimension, numpy.array(names, dtype=object),
                                      {"units": "1", "long_name": DIMENSIONS[dimension]})
        variables: Dict[str, Any] = {}
        for name, one in self.quantities.items():
            attributes: Dict[str, Any] = {"units": one.unit, "long_name": one.long_name}
            if one.about is not None:
                attributes["about"] = numpy.array(one.about)
            if one.round_off:
                attributes["round_off"] = one.round_off[0] if len(one.round_off) == 1 else numpy.array(one.round_off)
            variables[name] = (("time", *one.dimensions), self[name], attributes)
        for name, (dimension, long_name) in UNITS.items():
            units = getattr(own, f"{dimension}_units")
            if common_unit(units) == "mixed":
                variables[name] = (dimension, numpy.array(units, dtype=object), {"units": "1", "long_name": long_name})
        efforts = [column for column, name, _ in self._columns() if name == "torque"]
        if any(column.startswith("force") for column in efforts):
            variables["effort"] = ("actuator", numpy.array(efforts, dtype=object),
                                   {"units": "1", "long_name": "name of the actuator's torque or force"})
        iterations = own.values("newton_iterations")
        if iterations is not None:
            variables["newton_iterations"] = ("time", iterations,
                                              {"units": "1", "long_name": "Newton iterations for the position"})
        attributes = {"Conventions": "balance-1", **self.description}
        return xarray.Dataset(variables, coordinates, attributes)

    def metrics_to_xarray(self) -> xarray.Dataset:
        """The figures as in the result file's group `metrics`, by `quantity`.

        :raises ModuleNotFoundError: without xarray
        """
        import xarray

        rows = list(self.metrics.values())
        units = [one.unit for one in rows]
        unit = common_unit(units)
        variables: Dict[str, Any] = {
            "energy": ((), self.energy,
                       {"units": "J", "long_name": "energy moved by the actuators, the integral of the sum of |power|"}),
            "unit": ("quantity", numpy.array(units, dtype=object), {"units": "1", "long_name": "unit of the quantity"})}
        for figure, long_name in FIGURES.items():
            variables[figure] = ("quantity", numpy.array([getattr(one, figure) for one in rows]),
                                 {"units": "s" if figure == "peak_time" else unit, "long_name": long_name})
        names = numpy.array([one.quantity for one in rows], dtype=object)
        return xarray.Dataset(variables, {"quantity": ("quantity", names, {"units": "1", "long_name": "quantity"})})

    def _column_units(self) -> Dict[str, str]:
        """The unit of every column of `to_pandas`, and of its index."""
        columns = list(self._columns())
        counts: Dict[str, int] = {}
        for _, name, _ in columns:
            counts[name] = counts.get(name, 0) + 1
        quantities = self.quantities
        units = {"time": "s"}
        for column, name, k in columns:
            # one unit for all, or one per joint, actuator, …, which may have several columns
            own = quantities[name].units
            units[column] = own[k * len(own) // counts[name]] if own else quantities[name].unit
        return units

    def to_pandas(self) -> pandas.DataFrame:
        """The samples as a table, indexed by `time` [s].

        Columns are `torque[A1]` (of a slide `force[S]`), `joint_force[B1].x`, `shaking_force.y`, …; `attrs["units"]` has the unit of each,
        the other attributes are those of `description`, without the spec's text.

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        columns = {column: self[name].reshape(len(self["time"]), -1)[:, k] for column, name, k in self._columns()}
        table = pandas.DataFrame(columns, index=pandas.Index(self["time"], name="time"))
        table.attrs.update({name: value for name, value in self.description.items() if name != "spec"}, units=self._column_units())
        return table

    to_dataframe = to_pandas  # its older name

    def metrics_to_pandas(self) -> pandas.DataFrame:
        """The figures as a table: a row per quantity, the columns of `Metric`.

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        return pandas.DataFrame(list(self.metrics.values()), columns=Metric._fields).set_index("quantity")

    metrics_to_dataframe = metrics_to_pandas  # its older name


def _force_name(name: str) -> str:
    """`force[S]` for `torque[S]`, the older name of a slide's force."""
    return f"force{name[6:]}" if name.startswith("torque") and "[" in name else name


class _Metrics(Dict[str, Metric]):
    """Figures by name; a slide's force is found by its older name, too."""

    def __missing__(self, name: str) -> Metric:
        if _force_name(name) != name and _force_name(name) in self:
            return self[_force_name(name)]
        raise KeyError(name)


def _column_labels(dimensions: Tuple[str, ...], labels: Mapping[str, List[str]]) -> List[str]:
    all_labels = [""]
    for dimension in dimensions:
        dotted = dimension in ("axis", "quaternion")
        all_labels = [label + (f".{name}" if dotted else f"[{name}]") for label in all_labels for name in labels[dimension]]
    return all_labels
