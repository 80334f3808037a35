"""Mechanisms, and inverse dynamics at states."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Sequence, Tuple, Union

import numpy

from balance_mechanisms import _native
from balance_mechanisms._display import Shown, Table
from balance_mechanisms._errors import MotionError
from balance_mechanisms._run import Run

if TYPE_CHECKING:
    from balance_mechanisms._spec import Spec

Numbers = Union[numpy.ndarray, Sequence[Any], float]
State = Union[Numbers, Mapping[str, Numbers]]


def _raise(outcome: Tuple[str, float, str]) -> None:
    status, time, reason = outcome
    if status != "done":
        raise MotionError(reason, status, time)


def _stack(what: str, state: State, names: Sequence[str]) -> numpy.ndarray:
    """Numbers with the coordinates along the last axis. Raises ValueError for another shape or other names."""
    if isinstance(state, Mapping):
        missing = [name for name in names if name not in state]
        unknown = [name for name in state if name not in names]
        if missing or unknown:
            raise ValueError(f"{what}: expected {', '.join(names)}; "
                             + (f"{', '.join(missing)} is missing" if missing else f"there is no {', '.join(unknown)}"))
        return numpy.stack(numpy.broadcast_arrays(*(numpy.asarray(state[name], float) for name in names)), axis=-1)
    numbers = numpy.asarray(state, float)
    if numbers.ndim == 0 or numbers.shape[-1] != len(names):
        shape = "(" + ", ".join(map(str, numbers.shape)) + ("," if numbers.ndim == 1 else "") + ")"
        raise ValueError(f"{what}: expected (…, {len(names)}) for {', '.join(names)}; got {shape}")
    return numbers


def _states(names: Sequence[str], time: Numbers | None,
            **given: State) -> Tuple[List[numpy.ndarray], numpy.ndarray, Tuple[int, ...]]:
    """Rows for the library, times, and the shape of the states."""
    stacked = [_stack(what, state, names) for what, state in given.items()]
    try:
        lead = numpy.broadcast_shapes(*(one.shape[:-1] for one in stacked))
    except ValueError:
        shapes = ", ".join(f"{what} {one.shape}" for what, one in zip(given, stacked))
        raise ValueError(f"the states' shapes do not match: {shapes}") from None
    rows = [numpy.broadcast_to(one, (*lead, len(names))).reshape(-1, len(names)) for one in stacked]
    if time is None:
        times = numpy.empty(0)
    else:
        try:
            times = numpy.broadcast_to(numpy.asarray(time, float), lead).reshape(-1)
        except ValueError:
            raise ValueError(f"time: expected shape {lead}, got {numpy.shape(time)}") from None
    return rows, times, lead


class Mechanism(Shown):
    """A mechanism: bodies, joints, motors. Immutable and thread-safe. Pickled as the text of its spec.

    Obtained from `load(...).mechanism`.
    """

    def __init__(self, native: _native.Mechanism, spec: Spec) -> None:
        self._native = native
        self._spec = spec
        self._doors: Dict[Tuple[str, ...], Tuple[List[str], List[str], int]] = {}

    def __reduce__(self) -> Tuple[Any, ...]:
        return _mechanism_of, (self._spec,)

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Mechanism {self.name!r}: {', '.join(self.coordinates)}>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        planar = self.planar
        axes = 2 if planar else 3
        bodies = [[one["name"], one["mass"], [*one["com"][:axes]], one["inertia"][2, 2] if planar else [*numpy.diagonal(one["inertia"])]]
                  for one in self.bodies[1:]]
        tables = [Table(f"{self.name}: {'planar' if planar else 'spatial'}, {len(bodies)} bodies, {len(self.joints)} joints, "
                        f"{self.total_mass:.6g} kg; moved by {', '.join(self.actuators) or 'nothing'}",
                        ["body", "mass [kg]", "centre of mass [m]", "inertia [kg m²]" if planar else "inertia xx, yy, zz [kg m²]"], bodies)]
        if self.attachments:
            tables.append(Table("attached", ["name", "kind", "body", "at [m]", "mass [kg]"],
                                [[one["name"], one["kind"], one["body"], [*one["position"][:axes]], one["mass"]] for one in self.attachments]))
        return tables, []

    def _known(self, independent: Sequence[str]) -> Tuple[List[str], List[str], int]:
        """Names of the independent coordinates, notes and degrees of freedom."""
        key = tuple(independent)
        if key not in self._doors:
            door = _native.Door(self._native, list(key), [])
            self._doors[key] = (door.independent, door.notes, door.dof)
        return self._doors[key]

    @property
    def name(self) -> str:
        """The mechanism's title."""
        return self._native.name

    @property
    def spec(self) -> Spec:
        """The spec that describes it."""
        return self._spec

    @property
    def planar(self) -> bool:
        """Whether it is planar."""
        return self._native.planar

    @property
    def gravity(self) -> numpy.ndarray:
        """Gravitational acceleration in world axes [m/s^2]."""
        return self._native.gravity

    @property
    def coordinates(self) -> List[str]:
        """Names of all joint coordinates."""
        return [name for name, _ in self._native.coordinates]

    @property
    def units(self) -> Dict[str, str]:
        """`rad` or `m` of every coordinate."""
        return dict(self._native.coordinates)

    @property
    def actuators(self) -> List[str]:
        """Names of the actuated coordinates."""
        return self._native.actuators

    @property
    def dof(self) -> int:
        """Degrees of freedom, by rank."""
        return self._known(())[2]

    @property
    def independent(self) -> List[str]:
        """The coordinates that states are given in: the actuated ones, if their number equals the degrees of freedom."""
        return list(self._known(())[0])

    @property
    def notes(self) -> List[str]:
        """Notes for users: which coordinates were chosen, efforts of least norm, spins that are held."""
        return list(self._known(())[1])

    @property
    def bodies(self) -> List[Dict[str, Any]]:
        """Name, mass [kg], com [m], inertia about it [kg m^2] and points [m] of every body, in its own axes; the ground is the first."""
        return self._native.bodies

    @property
    def joints(self) -> List[Dict[str, Any]]:
        """Name, type, the two bodies and the joint's place on each [m]."""
        return self._native.joints

    @property
    def attachments(self) -> List[Dict[str, Any]]:
        """Counterweights and payloads: name, kind, body, position of the centre of mass [m], mass [kg], inertia [kg m^2]."""
        return self._native.attachments

    @property
    def parameters(self) -> Dict[str, float]:
        """The numbers that forces are linear in, by name [SI]."""
        names, values = self._native.parameters
        return dict(zip(names, values.tolist()))

    @property
    def total_mass(self) -> float:
        """Total mass of everything that moves [kg]."""
        return self._native.total_mass

    @property
    def characteristic_length(self) -> float:
        """A typical length of the mechanism [m]."""
        return self._native.characteristic_length

    def inverse_dynamics(self, q: State, dq: State, ddq: State, *, time: Numbers | None = None,
                         independent: Sequence[str] = (), threads: int = 1, failures: str = "warn") -> Any:
        """The actuator efforts required at these coordinates, rates and accelerations.

        :param q: array (…, n), the columns as in `independent`, or a dict of arrays by name; likewise `dq`, `ddq` [rad or m, …/s, …/s^2]
        :param time: for time-dependent loads [s]
        :param independent: other coordinates than `Mechanism.independent`
        :param threads: number of threads; does not affect the results
        :param failures: how to treat states without a solution, whose efforts are NaN: `warn`, `raise` (MotionError) or `ignore`
        :returns: efforts [N m or N], array (…, actuators), or a dict by the actuators' names if `q` is a dict
        """
        if failures not in ("warn", "raise", "ignore"):
            raise ValueError(f"failures: must be warn, raise or ignore, is {failures!r}")
        if threads < 1:
            raise ValueError(f"threads: must be positive, is {threads}")
        names = self._known(independent)[0]
        rows, times, lead = _states(names, time, q=q, dq=dq, ddq=ddq)
        efforts, failed = _native.efforts(self._native, list(independent), rows[0], rows[1], rows[2], times, threads)
        if failed and failures != "ignore":
            row, (status, when, reason) = failed[0]
            if failures == "raise":
                raise MotionError(f"state {row}: {reason}", status, when)
            warnings.warn(f"{len(failed)} of {len(rows[0])} states have no solution; the first, {row}: {reason}",
                          RuntimeWarning, stacklevel=2)
        efforts = efforts.reshape(*lead, len(self.actuators))
        if isinstance(q, Mapping):
            return {name: efforts[..., k] for k, name in enumerate(self.actuators)}
        return efforts


def _mechanism_of(spec: Spec) -> Mechanism:
    return spec.mechanism


class InverseDynamics:
    """Inverse dynamics that continues from state to state: loops stay in their assembly mode. Threads use it one at a time.

    :param independent: coordinates that states are given in; empty: as `Mechanism.independent`
    :param about: reference point of moments [m]
    """

    def __init__(self, mechanism: Mechanism, *, independent: Sequence[str] = (), about: Sequence[float] = ()) -> None:
        self._native = _native.Door(mechanism._native, list(independent), list(about))
        self._mechanism = mechanism

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism that it analyses."""
        return self._mechanism

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        return self._native.dof

    @property
    def independent(self) -> List[str]:
        """Names of the coordinates that states are given in."""
        return self._native.independent

    @property
    def actuators(self) -> List[str]:
        """Names of the actuated coordinates."""
        return self._native.actuators

    @property
    def notes(self) -> List[str]:
        """Notes for users."""
        return self._native.notes

    def _one(self, **given: State) -> List[numpy.ndarray]:
        rows, _, lead = _states(self.independent, None, **given)
        if lead not in ((), (1,)):
            raise ValueError(f"expected one state, got shape {lead}; `rows` accepts several")
        return rows

    def assemble(self, q: State, near: Mapping[str, float] | None = None) -> Dict[str, float]:
        """All coordinates [rad or m] that close the loops at `q`, by name; later states continue from there.

        :param q: the independent coordinates [rad or m], an array or a dict by name
        :param near: coordinates of the assembly mode wanted, [rad or m] by name; None: that of the spec, or of the state before
        :raises MotionError: if the loops cannot be closed there
        """
        outcome, values = self._native.assemble(self._one(q=q)[0], list((near or {}).items()))
        _raise(outcome)
        return dict(zip(self._mechanism.coordinates, values.tolist()))

    def at(self, q: State, dq: State, ddq: State, *, time: float = 0) -> Dict[str, numpy.ndarray]:
        """All quantities of one state [SI], named as in a run: efforts are `torque`.

        :param q: the independent coordinates [rad or m], an array or a dict by name; likewise their rates `dq` and accelerations `ddq`
        :param time: for time-dependent loads [s]
        :raises MotionError: if the state cannot be reached, or its efforts are not determined
        :raises ValueError: for another shape or other names
        """
        failed: List[Tuple[int, Tuple[str, float, str]]] = []
        one = self._one(q=q, dq=dq, ddq=ddq)
        run = Run(self._native.rows(one[0], one[1], one[2], numpy.array([time]), failed))
        if failed:
            _raise(failed[0][1])
        return {name: values[0] for name, values in run.items() if name != "time"}

    def rows(self, q: State, dq: State, ddq: State, *, time: Numbers | None = None) -> Run:
        """All quantities of several states, one row each, as a run without metrics. Rows without a solution are NaN, with a RuntimeWarning.

        :param q: array (…, n), or a dict of arrays by name, as for `Mechanism.inverse_dynamics`; likewise `dq`, `ddq`
        :param time: one for all rows, or one for each [s]
        :raises ValueError: for shapes that do not match, or other names
        """
        rows, times, _ = _states(self.independent, time, q=q, dq=dq, ddq=ddq)
        failed: List[Tuple[int, Tuple[str, float, str]]] = []
        run = Run(self._native.rows(rows[0], rows[1], rows[2], times, failed))
        if failed:
            warnings.warn(f"{len(failed)} of {len(rows[0])} states have no solution; the first, {failed[0][0]}: "
                          f"{failed[0][1][2]}", RuntimeWarning, stacklevel=2)
        return run

    def mass_matrix(self, q: State) -> numpy.ndarray:
        """M in M ddq + h = actuator efforts, (n, n) in the independent coordinates [kg, kg m or kg m^2].

        :raises MotionError: if the loops cannot be closed at `q`
        """
        outcome, matrix = self._native.mass_matrix(self._one(q=q)[0])
        _raise(outcome)
        return matrix

    def bias(self, q: State, dq: State, *, time: float = 0) -> numpy.ndarray:
        """h in M ddq + h = actuator efforts: velocity terms, weight, springs, loads and friction, (n) [N m or N].

        :raises MotionError: if the loops cannot be closed at `q`
        """
        one = self._one(q=q, dq=dq)
        outcome, vector = self._native.bias(one[0], one[1], time)
        _raise(outcome)
        return vector

    def regressor(self, q: State, dq: State, ddq: State, *, time: float = 0) -> Dict[str, Any]:
        """Efforts, shaking force and moment as matrices times the inertial parameters [SI]: effort @ values + other.

        :returns: `parameters` (names), `values`, `effort`, `shaking_force`, `shaking_moment`, `other`
        :raises MotionError: if the loops cannot be closed at `q`
        """
        one = self._one(q=q, dq=dq, ddq=ddq)
        outcome, found = self._native.regressor(one[0], one[1], one[2], time)
        _raise(outcome)
        return found
