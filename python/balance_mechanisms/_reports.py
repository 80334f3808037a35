"""Results of checks, conditions, designs, tolerances, comparisons and batches."""

from __future__ import annotations

import csv
import html
import io
import json
import os
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, NamedTuple, Tuple

import numpy

from balance_mechanisms import _native
from balance_mechanisms._display import Shown, Table, pretty_unit, unit_head
from balance_mechanisms._run import Run

if TYPE_CHECKING:
    import pandas

    from balance_mechanisms._spec import Spec


class Answer:
    """The output of a command: `to_dict()` is its JSON, `str()` its text, which a notebook shows if there is no table."""

    def __init__(self, document: str, text: str) -> None:
        self._json = document
        self._text = text

    def __str__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self._text)}</pre>"

    def to_json(self) -> str:
        """What the program prints with `--json`."""
        return self._json

    def to_dict(self) -> Dict[str, Any]:
        """The JSON as Python values; unknown values are None."""
        found: Dict[str, Any] = json.loads(self._json)
        return found


_SHOWN_FIGURES = ("torque", "shaking_force", "shaking_moment")


class Check(Answer):
    """The structure of a mechanism: degrees of freedom, loops, assembly modes."""

    @property
    def dof(self) -> int:
        """Degrees of freedom, by rank of the closures' derivatives."""
        return int(self.to_dict()["degrees_of_freedom"])


class Formula(NamedTuple):
    """One formula: the name of what it gives (``D12``, ``lg2``; empty: a sum that must vanish), and its text, in which adjacent
    factors are multiplied and ``^`` is a power."""

    name: str
    text: str


class Equations(Answer):
    """The equations of motion as formulas, checked against the engine."""

    def __init__(self, found: Mapping[str, str]) -> None:
        super().__init__(found["json"], found["text"])
        self._latex = found["latex"]

    @property
    def sections(self) -> Dict[str, List[Formula]]:
        """The formulas by section: `inertia`, `velocity`, `gravity`, `solutions`, …; those that vanish have the text `0`."""
        return {one["section"]: [*(Formula(each["name"], each["formula"]) for each in one["formulas"]),
                                 *(Formula(name, "0") for name in one["zero"])] for one in self.to_dict()["sections"]}

    @property
    def solution(self) -> Dict[str, str]:
        """The numbers that were solved for, by name."""
        return {one.name: one.text for one in self.sections.get("solutions", []) if one.name}

    @property
    def symbols(self) -> Dict[str, float]:
        """Values of all symbols in the spec [SI]."""
        found: Dict[str, float] = self.to_dict()["symbols"]
        return found

    @property
    def notes(self) -> List[str]:
        """What a user should know."""
        found: List[str] = self.to_dict()["notes"]
        return found

    def latex(self) -> str:
        """Displayed equations; needs amsmath."""
        return self._latex


class Condition(NamedTuple):
    """One balancing condition, a sum that vanishes: its text and LaTeX, the coefficients by parameter [SI], the residual relative to the
    size of the terms, whether it is met, and the paths of free numbers in it. A notebook shows the formula."""

    text: str
    latex: str
    terms: Dict[str, float]
    residual: float
    met: bool
    free: Tuple[str, ...]

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex}$"


class Conditions(Shown, Answer):
    """Necessary and sufficient conditions on masses, centres of mass, inertias and stiffnesses."""

    def __init__(self, found: Mapping[str, Any]) -> None:
        super().__init__(found["json"], found["text"])
        self._latex: str = found["latex"]
        self._impossible: str | None = found["impossible"]
        self._matrix: numpy.ndarray = found["matrix"]
        self._matrix.flags.writeable = False

    def __len__(self) -> int:
        return len(self.conditions)

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Conditions: {len(self)}>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        found = self.to_dict()
        names = [f"{one['name']} = {one['value']:.6g} {pretty_unit(one['unit'])}" for one in found["symbols"]]
        table = Table(f"{found['mechanism']}: {found['goal']} conditions: {'; '.join(found['meaning'])}", ["", "condition", "met", "residual (relative)", "depends on"],
                      [[k + 1, one.text, one.met, one.residual, list(one.free)] for k, one in enumerate(self.conditions)])
        impossible = [self.impossible] if self.impossible else []
        return [table], [*(["where " + ", ".join(names)] if names else []), *impossible, *found["notes"]]

    def _repr_latex_(self) -> str:
        return self.latex() if len(self) > 0 else super()._repr_latex_()  # TeX takes no empty align*

    @property
    def conditions(self) -> List[Condition]:
        """The conditions. `terms` are coefficients by parameter, `residual` is scaled, `free` lists the free numbers involved."""
        return [Condition(one["text"], one["latex"], {term["parameter"]: term["coefficient"] for term in one["terms"]},
                          one["residual"], one["met"], tuple(one["free"])) for one in self.to_dict()["conditions"]]

    @property
    def rank(self) -> int:
        """Number of conditions."""
        return int(self.to_dict()["rank"])

    @property
    def parameters(self) -> List[str]:
        """The parameters of the columns of `matrix`; columns of known terms follow them."""
        names: List[str] = self.to_dict()["parameters"]
        return names

    @property
    def matrix(self) -> numpy.ndarray:
        """R in R p = 0, reduced; one row per condition [SI]."""
        return self._matrix

    @property
    def orders(self) -> List[Dict[str, Any]]:
        """Cosine and sine of each order that a goal asks to vanish, with the present `amplitude`, in SI; without such goals empty."""
        rows: List[Dict[str, Any]] = self.to_dict().get("orders", {}).get("rows", [])
        return rows

    @property
    def impossible(self) -> str | None:
        """Why no masses can meet the conditions, if that is proved; else None."""
        return self._impossible

    @property
    def staying(self) -> List[Dict[str, Any]]:
        """What masses and springs cannot balance (friction, loads), with the remaining efforts."""
        left: List[Dict[str, Any]] = self.to_dict()["staying"]
        return left

    def latex(self) -> str:
        """An align* environment; needs amsmath."""
        return self._latex

    def to_pandas(self) -> pandas.DataFrame:
        """A row per condition: its text, relative residual, whether it is met, paths of free numbers in it.

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        columns = ["text", "residual", "met", "free"]
        return pandas.DataFrame([[getattr(one, name) for name in columns] for one in self.conditions], columns=columns)

    to_dataframe = to_pandas  # its older name


class Design(Shown, Answer):
    """Values that balance a mechanism, or the best compromise and the reason why there is no better one."""

    def __init__(self, native: _native.Design, spec: Spec) -> None:
        super().__init__(native.json(), native.text())
        self._native = native
        self._spec = spec

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Design: {self.status}>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        found = self.to_dict()
        units = self._spec._units()
        tables = [Table(str(self).split("\n", 1)[0], ["free number", "unit", "lower", "upper", "before", "value"],
                        [[one["path"], pretty_unit(units.get(one["path"], "")), one["lower"], one["upper"], one["before"], one["value"]]
                         for one in found["free_numbers"]])]
        notes: List[str] = []
        for along in found["trajectories"]:
            rows = [[one["quantity"], one["figure"], pretty_unit(one["unit"]), one["before"], one["after"], one["ratio"]] for one in along["changes"]
                    if one["quantity"] in _SHOWN_FIGURES]
            ended = [side["outcome"]["reason"] for side in (along["before"], along["after"]) if side and side["outcome"]["status"] != "done"]
            if ended:
                notes.append(f"{along['trajectory']}: {ended[0]}")
            elif rows:
                tables.append(Table(f"along {along['trajectory']}", ["quantity", "figure", "unit", "before", "after", "ratio"], rows))
        goal = found["objective"]
        reached = [f"{goal['name']}: {goal['value']:.6g} {pretty_unit(goal['unit'])}"] if goal["name"] and goal["value"] is not None else []
        return tables, [f"status: {self.status}; optimality: {self.optimality}", *reached, *([self.reason] if self.reason else []),
                        *notes]

    @property
    def status(self) -> str:
        """`balanced`, `compromise`, `impossible`, `not-found` or `not-asked` (there was no goal)."""
        return self._native.status

    @property
    def optimality(self) -> str:
        """`proved-best`, `local-best`, `stopped` or `not-asked`."""
        return self._native.optimality

    @property
    def reason(self) -> str:
        """Why there is no better design, in a sentence or two."""
        return self._native.reason

    @property
    def values(self) -> Dict[str, float]:
        """The free numbers by their path in the spec: SI, parameters as written."""
        return dict(self._native.values)

    @property
    def parts(self) -> Dict[str, Any] | None:
        """The parts from catalogues: `list` (each with `element`, `catalogue`, `sha256`, `part`, `count`, `mass`, `price`, `currency`), the
        sums `mass` and `price`, `combinations`, `proved`, `lower_bound`; None without catalogues."""
        parts: Dict[str, Any] | None = self.to_dict()["parts"]
        return parts

    @property
    def length_bound(self) -> Dict[str, Any] | None:
        """What is proved for all lengths: `lower_bound` and `best` in `unit`, `relative_gap`, `impossible`, `covers`, `not_covered`,
        `coverage`, `boxes`, `progress`; only `reason` if lengths are free but cannot be bounded; None without free lengths."""
        bound: Dict[str, Any] | None = self.to_dict()["length_bound"]
        return bound

    @property
    def load_cases(self) -> List[Dict[str, Any]]:
        """For each load of `design: for`, the residual conditions, efforts at rest and torques; empty without load cases."""
        cases: List[Dict[str, Any]] = self.to_dict()["load_cases"]
        return cases

    @property
    def adaptive(self) -> Dict[str, Any] | None:
        """How the numbers of `design: adapt` follow the load: laws or a table, ranges, work; None if there are none."""
        law: Dict[str, Any] | None = self.to_dict()["adaptive"]
        return law

    @property
    def spec_text(self) -> str:
        """The spec with its free numbers replaced by these values."""
        return self._native.spec_text

    @property
    def spec(self) -> Spec:
        """The spec with these values, loaded."""
        return self._spec._again(self.spec_text)

    @property
    def before(self) -> Dict[str, Run]:
        """Runs of the original mechanism, by trajectory."""
        return {name: Run(run) for name, run in self._native.runs(False).items()}

    @property
    def after(self) -> Dict[str, Run]:
        """Runs of the designed mechanism, by trajectory."""
        return {name: Run(run) for name, run in self._native.runs(True).items()}

    def write(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes the design file: numbers, conditions, all runs (docs/file-format.md); complete or not at all.

        :param force: overwrite an existing file
        :raises FileExistsError: if it exists and `force` is not set
        :raises OSError: if it cannot be written (PermissionError, IsADirectoryError, …), or would replace the spec
        """
        self._native.write(os.fspath(path), force)

    def to_pandas(self) -> pandas.DataFrame:
        """A row per free number, by its path: unit (none: a parameter as written), bounds, value before and after [SI], …

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        rows = self.to_dict()["free_numbers"]
        table = pandas.DataFrame(rows, columns=list(rows[0]) if rows else ["path", "lower", "upper", "before", "value"]).set_index("path")
        units = self._spec._units()
        table.insert(0, "unit", [units.get(path, "") for path in table.index])
        return table

    to_dataframe = to_pandas  # its older name


class Front(Shown, Answer):
    """A trade-off between two or three figures: designs of which none is better in all of them."""

    def __init__(self, native: _native.Front, spec: Spec) -> None:
        super().__init__(native.json(), native.text())
        self._native = native
        self._spec = spec

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Front: {len(self)}>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        figures = self.to_dict()["front"]["figures"]
        units = self._spec._units()
        paths = [one["path"] for one in self.points[0]["free_numbers"]] if self.points else []
        table = Table(str(self).split("\n", 1)[0],
                      ["index", *(unit_head(one["name"], one["unit"]) for one in figures), *(unit_head(path, units.get(path, "")) for path in paths),
                       "optimality"],
                      [[k, *one["values"], *(number["value"] for number in one["free_numbers"]), one["optimality"]]
                       for k, one in enumerate(self.points)])
        return [table], [f"index {self.middle} is nearest to the minima of all figures; design(index) is one of them"] if self.points else []

    def __len__(self) -> int:
        return len(self.points)

    @property
    def figures(self) -> List[str]:
        """Names of the figures, in the order of a point's values."""
        return [one["name"] for one in self.to_dict()["front"]["figures"]]

    @property
    def points(self) -> List[Dict[str, Any]]:
        """The points: `values`, `free_numbers`, `optimality`, `lower_bound`, … as in the program's JSON."""
        found: List[Dict[str, Any]] = self.to_dict()["front"]["points"]
        return found

    @property
    def middle(self) -> int:
        """Index of the point nearest to the minimum of all figures."""
        return int(self.to_dict()["front"]["middle"]) - 1

    def design(self, index: int) -> Design:
        """One of the points as a design of its own.

        :param index: from 0, as in `points`; negative ones count from the end
        :raises IndexError: if there is no such point
        """
        return Design(self._native.design(range(len(self))[index]), self._spec)

    def to_pandas(self) -> pandas.DataFrame:
        """A row per point, counted from 1: figures, bound and free numbers [SI]; `attrs["units"]` has the unit of each column.

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        table = pandas.read_csv(io.StringIO(self._native.csv()), float_precision="round_trip").set_index("point")
        units = self._spec._units()
        figures = {f"{one['name']} [{one['unit']}]": one["unit"] for one in self.to_dict()["front"]["figures"]}
        table.attrs["units"] = {name: figures.get(name, units.get(name, "")) for name in table.columns}
        return table

    to_dataframe = to_pandas  # its older name


class Modes(Answer):
    """Vibration modes of a mechanism, its response to orders, and both over a sweep."""

    def __init__(self, native: _native.Modes) -> None:
        super().__init__(native.json(), native.text())
        self._native = native

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Modes: {len(self.to_dict()['modes'])} modes, {self.stability}>"

    @property
    def stability(self) -> str:
        """`stable`, `marginal` (nothing grows) or `unstable`."""
        return str(self.to_dict()["stability"])

    @property
    def eigenvalues(self) -> numpy.ndarray:
        """All eigenvalues, by decreasing real part [1/s]."""
        return numpy.array([complex(*one) for one in self.to_dict()["eigenvalues"]])

    @property
    def frequencies(self) -> numpy.ndarray:
        """Of the damped oscillations, by increasing size of the eigenvalue [Hz]."""
        return numpy.array([mode["frequency"] for mode in self.to_dict()["modes"] if mode["frequency"] > 0])

    @property
    def stability_changes(self) -> List[Dict[str, Any]]:
        """Values of the sweep at which an oscillation or a divergence begins or ends; empty without a sweep."""
        sweep: Dict[str, Any] = self.to_dict()["sweep"] or {"stability_changes": []}
        changes: List[Dict[str, Any]] = sweep["stability_changes"]
        return changes

    def write(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes modes, response and sweep (docs/file-format.md); complete or not at all.

        :param force: overwrite an existing file
        :raises FileExistsError: if it exists and `force` is not set
        :raises OSError: if it cannot be written
        """
        self._native.write(os.fspath(path), force)


class ChannelSeries(NamedTuple):
    """A channel at all rows of its records: index of the record, time [s], what was measured (low-passed) and what the identified mechanism
    predicts [SI; currents in A], the part of it that is friction, rate of its coordinate, and whether that is not at rest."""

    record: numpy.ndarray
    time: numpy.ndarray
    measured: numpy.ndarray
    predicted: numpy.ndarray
    friction: numpy.ndarray
    rate: numpy.ndarray
    moving: numpy.ndarray


class Channel(NamedTuple):
    """A measured effort, current or force on the frame. `gain` is the effort per ampere of a current, its deviation None if it was given;
    `validation` is None without records, or spans of them, that were only predicted."""

    name: str
    unit: str
    gain: float | None
    gain_deviation: float | None
    training: ChannelSeries
    validation: ChannelSeries | None


class Identification(Answer):
    """What records of its motion say of a mechanism: base parameters, physically possible bodies, residuals."""

    def __init__(self, native: _native.Identification) -> None:
        super().__init__(native.json, native.text)
        self._native = native
        self._covariance = native.covariance
        self._covariance.flags.writeable = False

    def __repr__(self) -> str:
        found = self.to_dict()
        return f"<balance_mechanisms.Identification: {found['found_rank']} of {found['structural_rank']} base parameters>"

    @property
    def base_parameters(self) -> List[Dict[str, Any]]:
        """The combinations of unknowns that motion can determine: `name` of the unknown whose factor is one, `combination` of the others,
        `value`, `deviation` and `spec` [SI], `found`: by this motion."""
        rows: List[Dict[str, Any]] = self.to_dict()["base_parameters"]
        return rows

    @property
    def covariance(self) -> numpy.ndarray:
        """Covariance of the base parameters, in their order [SI]."""
        return self._covariance

    @property
    def channels(self) -> Dict[str, Channel]:
        """What was measured, by name, with the predictions as arrays."""
        found = {}
        for name, unit, gain, deviation, training, validation in self._native.channels:
            assert training is not None
            found[name] = Channel(name, unit, gain, deviation, ChannelSeries(*training), ChannelSeries(*validation) if validation else None)
        return found

    @property
    def bodies(self) -> List[Dict[str, Any]]:
        """As `Mechanism.bodies`, with the physically possible masses, centres and inertias that were found."""
        return self._native.mechanism.bodies

    @property
    def unknowns(self) -> List[Dict[str, Any]]:
        """Every unknown with its `value`, `deviation` and `spec` [SI], and `determination`: what the records say of it."""
        rows: List[Dict[str, Any]] = self.to_dict()["unknowns"]
        return rows

    @property
    def warnings(self) -> List[str]:
        """What should be checked: mistakes that the records seem to have, first."""
        found = self.to_dict()
        return [*(one["text"] for one in found["suspicions"]), *found["warnings"]]

    def write_spec(self, path: str | os.PathLike[str], *, force: bool = False) -> List[str]:
        """Writes the spec with the numbers that were found; complete or not at all.

        :param force: overwrite an existing file
        :returns: what it cannot say, such as friction that came out negative
        :raises SpecError: if the form of the spec does not allow it: bodies from parts, anchors, shapes
        :raises FileExistsError: if the file exists and `force` is not set
        :raises OSError: if it cannot be written, or is the spec or a record
        """
        return self._native.write_spec(os.fspath(path), force)

    def write(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes base parameters with their covariance, unknowns and channels as HDF5 (docs/file-format.md); complete or not at all.

        :param force: overwrite an existing file
        :raises FileExistsError: if it exists and `force` is not set
        :raises OSError: if it cannot be written, or is the spec or a record
        """
        self._native.write(os.fspath(path), force)


class Tolerance(Answer):
    """Deviations of torques, forces and moments due to the tolerances of a mechanism."""

    def __init__(self, native: _native.Tolerance) -> None:
        super().__init__(native.json(), native.text())
        self._native = native

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Tolerance: {len(self.to_dict()['numbers'])} numbers>"

    @property
    def quantities(self) -> Dict[str, Dict[str, Any]]:
        """Figures with their deviations, the worst sample and the numbers' shares, by quantity; empty at rest."""
        along: Dict[str, Any] = self.to_dict()["first_order"] or {"quantities": []}
        return {one["quantity"]: one for one in along["quantities"]}

    @property
    def actuators(self) -> Dict[str, Dict[str, Any]]:
        """The pose at rest with the largest deviation of an actuator's effort, by actuator; empty along a trajectory."""
        rest: Dict[str, Any] = self.to_dict()["at_rest"] or {"actuators": []}
        return {one["actuator"]: one for one in rest["actuators"]}

    @property
    def openings(self) -> List[Dict[str, Any]]:
        """Numbers that over-constrained loops cannot follow, which contribute to no deviation: `number`, the `joint` that it opens, the
        `gap` and its `unit`."""
        openings: List[Dict[str, Any]] = self.to_dict()["openings"]
        return openings

    def write(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes the run and the deviation of every sample (docs/file-format.md); complete or not at all.

        :param force: overwrite an existing file
        :raises ValueError: of efforts at rest, which have no samples
        :raises FileExistsError: if it exists and `force` is not set
        :raises OSError: if it cannot be written
        """
        self._native.write(os.fspath(path), force)

    def to_pandas(self) -> pandas.DataFrame:
        """A row per quantity: unit, the figures' deviations, the expected rms, all in that unit; at rest a row per actuator.

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        if self.actuators:
            return pandas.DataFrame(list(self.actuators.values())).set_index("actuator")
        figures = ("peak", "rms", "mean", "range")
        rows = [{"quantity": name, "unit": one["unit"], **{figure: one[figure]["deviation"] for figure in figures},
                 "expected_rms": one["expected_rms"]} for name, one in self.quantities.items()]
        return pandas.DataFrame(rows).set_index("quantity")

    to_dataframe = to_pandas  # its older name


class Comparison(Answer):
    """Runs side by side, and whether requirements hold."""

    def __init__(self, found: Mapping[str, Any]) -> None:
        super().__init__(found["json"], found["text"])
        self._csv: str = found["csv"]
        self._markdown: str = found["markdown"]
        self._holds: bool = found["holds"]

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Comparison: {'holds' if self.holds else 'does not hold'}>"

    @property
    def holds(self) -> bool:
        """Whether all requirements hold."""
        return self._holds

    @property
    def requirements(self) -> List[Dict[str, Any]]:
        """The verdict on each requirement."""
        judged: List[Dict[str, Any]] = self.to_dict()["requirements"]
        return judged

    def to_markdown(self) -> str:
        """The comparison as Markdown tables."""
        return self._markdown

    def to_pandas(self) -> pandas.DataFrame:
        """A row per quantity, figure and run: unit, value in it, ratio to the base.

        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        rows = pandas.DataFrame(list(csv.DictReader(io.StringIO(self._csv))))
        return rows.assign(**{name: [float(text or "nan") for text in rows[name]] for name in ("value", "ratio")})

    to_dataframe = to_pandas  # its older name


class Batch(Answer):
    """The results of a suite."""

    def __init__(self, found: Mapping[str, Any], folder: str) -> None:
        super().__init__(found["json"], found["text"])
        self._found = found
        self._folder = folder

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Batch in {self._folder!r}: {len(self.cases)} cases, exit code {self.exit_code}>"

    @property
    def exit_code(self) -> int:
        """0: all cases are done and the requirements hold; 1: a requirement is missed or a design is only a compromise; else 3, 4, 5."""
        return int(self._found["exit_code"])

    @property
    def holds(self) -> bool:
        """Whether everything is done and all requirements hold."""
        return self.exit_code == 0

    @property
    def folder(self) -> str:
        """Where the results are."""
        return self._folder

    @property
    def cases(self) -> Dict[str, str]:
        """Status of every case, by name."""
        return {name: status for name, status, _ in self._found["cases"]}

    @property
    def messages(self) -> Dict[str, str]:
        """Messages of the cases that have one, by name."""
        return {name: message for name, _, message in self._found["cases"] if message}

    def run(self, case: str) -> Run:
        """The result of a case.

        :raises KeyError: if the suite has no such case
        :raises FileNotFoundError: if the case has no result: it failed, or only metrics were written
        """
        if case not in self.cases:
            raise KeyError(f"{case!r}: the suite has {', '.join(self.cases)}")
        return Run(_native.read_result(os.path.join(self._folder, case + ".h5")))

    def to_pandas(self) -> pandas.DataFrame:
        """The table summary.csv: a row per case and quantity.

        :raises FileNotFoundError: of a shard, which has none
        :raises ModuleNotFoundError: without pandas
        """
        import pandas

        return pandas.read_csv(os.path.join(self._folder, "summary.csv"), float_precision="round_trip")

    to_dataframe = to_pandas  # its older name
