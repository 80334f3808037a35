"""Specs: reading them, and the analyses they offer."""

from __future__ import annotations

import json
import os
import shlex
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple, Union

from balance_mechanisms import _native
from balance_mechanisms._display import Shown, Table, pretty_unit
from balance_mechanisms._reports import Check, Conditions, Design, Equations, Front, Identification, Modes, Tolerance
from balance_mechanisms._errors import MechanismError, MotionError
from balance_mechanisms._mechanism import Mechanism
from balance_mechanisms._model_file import ModelFile, write_model
from balance_mechanisms._run import Run

Path = Union[str, "os.PathLike[str]"]
Goals = Union[str, Sequence[str], None]
Progress = Callable[[float], Any]


def _words(names: Goals) -> List[str]:
    return [] if names is None else [names] if isinstance(names, str) else list(names)


def _paths(files: Path | Sequence[Path]) -> List[str]:
    return [os.fspath(files)] if isinstance(files, (str, os.PathLike)) else [os.fspath(file) for file in files]


class Spec(Shown):
    """A loaded spec (docs/spec.md). Immutable and thread-safe. Pickled as its text, overrides and path.

    Created by `load`. A notebook shows its bodies, trajectories and free numbers.
    """

    def __init__(self, native: _native.Spec) -> None:
        self._native = native
        self._mechanism = Mechanism(native.mechanism, self)

    def __reduce__(self) -> Tuple[Any, ...]:
        # Files that the text names lie in its folder, wherever another process works.
        return _read, (self.text, os.path.abspath(self.file), self._native.set)

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Spec {self.file!r}: {self.name!r}>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        tables, _ = self.mechanism._summary()
        if self.trajectories:
            tables.append(Table("trajectories", ["name", "law", "moves", "duration [s]", "samples"],
                                [[one["name"], one["law"], one["drive"], one["duration"], one["samples"]] for one in self.trajectories]))
        if self.free_numbers:
            goal = f" for {', '.join(self.goals)}" if self.goals else ""
            tables.append(Table(f"free numbers of the design{goal}", ["path", "unit", "lower", "upper", "start"],
                                [[one["path"], pretty_unit(one["si_unit"]), one["lower"], one["upper"], one["start"]] for one in self.free_numbers]))
        changed = [f"set: {', '.join(f'{name} = {value}' for name, value in self.set.items())}"] if self.set else []
        return tables, [f"file: {self.file}", *changed, *(f"warning: {warning}" for warning in self.warnings)]

    def _units(self) -> Dict[str, str]:
        """The SI unit of every free number by its path; "" for parameters, which are as written."""
        return {one["path"]: one["si_unit"] for one in self.free_numbers}

    def _again(self, text: str) -> Spec:
        """Another text in the place of this one, with nothing overridden."""
        return _read(text, self.file, [])

    @property
    def name(self) -> str:
        """The mechanism's title."""
        return self._native.name

    @property
    def file(self) -> str:
        """The name of the spec in messages."""
        return self._native.file

    @property
    def text(self) -> str:
        """The text as read, without the changes of `set`."""
        return self._native.text

    @property
    def set(self) -> Dict[str, str]:
        """Overridden parameters: the expressions by name."""
        return dict(self._native.set)

    @property
    def warnings(self) -> List[str]:
        """What is legal but suspicious."""
        return self._native.warnings

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, with the start values of free numbers."""
        return self._mechanism

    @property
    def trajectories(self) -> List[Dict[str, Any]]:
        """Name, law, drive, duration [s] and samples of each."""
        return self._native.trajectories

    @property
    def controllers(self) -> List[Dict[str, Any]]:
        """Name, type and period [s] of each."""
        return self._native.controllers

    @property
    def free_numbers(self) -> List[Dict[str, Any]]:
        """Path, lower, upper, start (SI; parameters as written) and `si_unit` ("": a parameter or without unit) of each free number."""
        return self._native.free_numbers

    @property
    def goals(self) -> List[str]:
        """The goals of `design: goal`."""
        return self._native.goals

    def check(self, *, verify: bool = False, progress: Progress | None = None) -> Check:
        """Checks the mechanism: degrees of freedom, loops, redundant constraints, assembly modes.

        :param verify: also run all trajectories with both formulations (planar mechanisms)
        :param progress: called from time to time with the completed fraction, 0 to 1
        :raises MotionError: if the loops cannot be closed
        """
        status, reason, document, text = self._native.check(verify, progress)
        if status != "done":
            raise MotionError(reason, status, 0)
        return Check(document, text)

    def conditions(self, goal: Goals = None, *, strategy: str = "complete", without: Goals = None,
                   seed: int | None = None, named: bool = True, speeds: str = "") -> Conditions:
        """The complete balancing conditions.

        :param goal: one of `GOALS`, or several that must hold together; None: those of the spec
        :param strategy: `complete`, or `modular`: each chain separately
        :param without: what the goals ignore: friction, loads, springs, payloads, … or names of elements
        :param seed: for random configurations
        :param named: write coefficients in terms of named lengths
        :param speeds: `"x: tool.x, y: tool.y"`: velocity terms and inertia in the derivatives of these, as `balance conditions --speeds`
        :raises MechanismError: if there are none (the loops cannot be closed, the goal needs actuators, …)
        """
        return Conditions(_native.conditions(self._native, _words(goal), _words(without), strategy, seed, named, speeds))

    def equations(self, *, only: Goals = None, solve: Goals = None, goal: Goals = None, strategy: str = "complete",
                  without: Goals = None, seed: int | None = None, collect: Goals = None, independent: Goals = None,
                  speeds: str = "", expand: bool = False, numbers: bool = False, all: bool = False) -> Equations:
        """The equations of motion as formulas, as `balance equations` prints them.

        :param only: sections: `inertia`, `velocity`, `gravity`, `closures`, `solved`, `conditions`, `regressor`, `natural`, `efforts`,
            `reduced`, `speeds`; None: those that the mechanism has
        :param solve: numbers for which the conditions of the goal are solved: parameters, symbols or paths of the spec
        :param goal: of `solve`, as for `conditions`; None: those of the spec; likewise `strategy`, `without` and `seed`
        :param collect: symbols by whose powers sums are grouped
        :param independent: coordinates; None: the actuated ones if they determine the motion
        :param speeds: `"v: tool.u, w: A"`; "": those of the spec
        :param expand: replace parameters that depend on others by their expressions
        :param numbers: numbers in place of symbols
        :param all: sections of any length
        :raises MechanismError: if there are no formulas
        """
        return Equations(_native.equations(self._native, _words(only), _words(solve), _words(collect), _words(independent),
                                           speeds, expand, numbers, all, _words(goal), _words(without), strategy, seed))

    def program(self, language: str = "python", *, coordinates: str = "independent", independent: Goals = None) -> str:
        """A program for the torques, as `balance equations --code` prints it.

        :param language: `python` or `c`
        :param coordinates: of a mechanism with loops: `independent`, and the program closes the loops, or `all`
        :param independent: coordinates; None: the actuated ones if they determine the motion
        :raises MechanismError: if there is none
        """
        return _native.program(self._native, language, coordinates, _words(independent))

    def design(self, goal: Goals = None, *, minimize: Any = None, seed: int | None = None, strategy: str = "complete",
               without: Goals = None, algorithm: str = "", trajectories: bool = True) -> Design:
        """Values for the free numbers that meet all conditions of the goal, the best ones if there is an objective.

        :param goal: as for `conditions`
        :param minimize: as in the spec: `added-mass`, `{"rms": "torque", "along": "cycloid"}`, a list of these; None: as in the spec
        :param seed: for random configurations and searches
        :param strategy: as for `conditions`, likewise `without`
        :param algorithm: of the search; "": as in the spec
        :param trajectories: run every trajectory with the given and the designed mechanism
        :returns: the design; a compromise is one, too, and so is the proof that there is none: see its `status`
        :raises MechanismError: if there is no result at all (the loops cannot be closed, …)
        :raises TimeoutError: if the time that the spec allows ends before the first design
        """
        wish = "" if minimize is None else minimize if isinstance(minimize, str) else json.dumps(minimize)
        words = ["balance", "design", os.path.basename(self.file)]
        for option, values in (("--goal", _words(goal)), ("--minimize", [wish] if wish else []),
                               ("--strategy", [strategy] if strategy != "complete" else []),
                               ("--without", _words(without)), ("--algorithm", [algorithm] if algorithm else []),
                               ("--seed", [] if seed is None else [str(seed)]),
                               ("--set", [f"{name}={value}" for name, value in self._native.set])):
            words += [word for value in values for word in (option, value)]
        native = _native.design(self._native, _words(goal), _words(without), strategy, seed, wish, algorithm,
                                trajectories, shlex.join(words))
        return Design(native, self)

    def front(self, goal: Goals = None, *, seed: int | None = None, strategy: str = "complete", without: Goals = None,
              algorithm: str = "") -> Front:
        """The trade-off between the figures of the spec's `design: front`; arguments as for `design`.

        :raises ValueError: if the spec has no front
        :raises MechanismError: if there is no result at all; a front without points is a result, with its reason
        """
        words = ["balance", "design", os.path.basename(self.file)]
        for option, values in (("--goal", _words(goal)), ("--strategy", [strategy] if strategy != "complete" else []),
                               ("--without", _words(without)), ("--algorithm", [algorithm] if algorithm else []),
                               ("--seed", [] if seed is None else [str(seed)]),
                               ("--set", [f"{name}={value}" for name, value in self._native.set])):
            words += [word for value in values for word in (option, value)]
        native = _native.front(self._native, _words(goal), _words(without), strategy, seed, algorithm, shlex.join(words))
        return Front(native, self)

    def modes(self, trajectory: str | None = None, *, sweep: str = "", orders: int = 4, exact: int = 5,
              progress: Progress | None = None) -> Modes:
        """Vibration modes of the coordinates that a trajectory leaves free, and their response to a joint that turns.

        :param trajectory: name in the spec; None: the first one with free coordinates, else the first one
        :param sweep: `NAME=FROM:TO:COUNT`, over a parameter of the spec or the speed of the joint that turns
        :param orders: highest order of the response
        :param exact: values of the sweep at which the response is also computed exactly; 0: nowhere
        :param progress: called from time to time with the completed fraction of the sweep, 0 to 1
        :raises SpecError: if the trajectory does not go with free coordinates, or the spec has no such parameter
        :raises MotionError: if there is no equilibrium or steady motion
        :raises ValueError: if the sweep is not of that form
        """
        native = _native.modes(self._native, trajectory or "", sweep, orders, exact, progress)
        if native.status != "done":
            raise MotionError(native.reason, native.status, native.end)
        return Modes(native)

    def tolerance(self, trajectory: str | None = None, *, of: Goals = None, samples: int | None = None,
                  monte_carlo: int = 0, seed: int | None = None, at_rest: bool = False,
                  progress: Progress | None = None) -> Tolerance:
        """Deviation of a run due to the spec's `tolerances`: to first order, by exact derivatives.

        :param trajectory: name in the spec; None: the first one
        :param of: quantities: `torque`, `torque[A1]`, `shaking_force`; None: all
        :param samples: both ends included
        :param monte_carlo: also run this many mechanisms with randomly drawn numbers
        :param seed: of the draws (default: 1); only with monte_carlo
        :param at_rest: efforts at rest in all poses instead of a trajectory
        :param progress: called from time to time with the completed fraction of the draws, 0 to 1
        :raises SpecError: if the spec has no `tolerances`, or they do not suit the trajectory
        :raises MotionError: if the mechanism cannot perform the motion
        :raises MechanismError: if no pose at rest can be reached and held
        """
        native = _native.tolerance(self._native, trajectory or "", _words(of), samples, monte_carlo, seed, at_rest,
                                   progress)
        if native.status != "done" and at_rest:
            raise MechanismError(native.reason, native.status)
        if native.status != "done":
            raise MotionError(native.reason, native.status, native.end)
        return Tolerance(native)

    def export(self, path: Path | None = None, *, format: str = "", trajectory: str = "") -> ModelFile:
        """The mechanism as a file of simulators: MJCF (MuJoCo), SDF or URDF (docs/import.md).

        :param path: file to write, replacing any; None: none
        :param format: `mjcf`, `sdf` or `urdf`; "": as the path's extension says
        :param trajectory: whose start is the start pose; "": the first one
        :raises ValueError: if there is no such format or trajectory, or if the path is the spec's
        :raises SpecError: if the loops cannot be closed
        :raises OSError: if the file cannot be written
        """
        return write_model(self._native, self.file, path, format, trajectory)

    def identify(self, records: Path | Sequence[Path], *, validate: Path | Sequence[Path] = (),
                 columns: Mapping[str, str | int] | None = None, rows: Tuple[int, int] | None = None,
                 time: Tuple[float, float] | None = None, cutoff: float = 0, rest: float = 0.02,
                 gain: Mapping[str, float] | None = None, find_gains: bool = False,
                 loaded: Mapping[str, Path | Sequence[Path]] | None = None, find_payload: Goals = None, passive_friction: str = "viscous", prior_weight: float = 1,
                 correlation: float = 1, hold_out: float = 0) -> Identification:
        """Masses, inertia and friction from records of the machine's motion, as `balance identify` finds them.

        :param records: files, CSV or HDF5, all with the same columns
        :param validate: files that are only predicted
        :param columns: what columns with other names are, by name or by number from 1: `{"A1": "q1", "A1.effort": 7}`
        :param rows: first and last row of numbers to use, from 1
        :param time: first and last time to use, in the spec's unit
        :param cutoff: of the low-pass filter [Hz]; 0: from the motion
        :param rest: rate below which a joint is at rest [rad/s or m/s]
        :param gain: effort per ampere of actuators whose current was measured, by actuator [N m/A or N/A]; the others are
            those of the spec's `current_gains`, or found
        :param find_gains: find the gains that the spec states as well
        :param loaded: the records, out of those named, in which a payload of the spec is carried; by payload
        :param find_payload: payloads whose mass, centre of mass and inertia are to be found
        :param passive_friction: `none`, `viscous` or `dry`: to be found in passive joints that have none in the spec
        :param prior_weight: weight of the spec's bodies
        :param correlation: time within which residuals are correlated, for deviations [s]
        :param hold_out: of every two spans of this duration the second is only predicted [s]; 0: all are fitted
        :raises MechanismError: if the records do not go with the mechanism, or determine nothing
        :raises OSError: for a file that is no record of this mechanism, with its row and column
        :raises SpecError: if the spec has something in which the equation of motion is not linear
        :raises ValueError: if an argument has no such value
        """
        numbers = {"cutoff": float(cutoff), "rest": float(rest), "prior_weight": float(prior_weight), "correlation": float(correlation),
                   "hold_out": float(hold_out)}
        carried = [(name, file) for name, files in (loaded or {}).items() for file in _paths(files)]
        return Identification(_native.identify(
            self._native, _paths(records), _paths(validate), [(name, str(column)) for name, column in (columns or {}).items()], rows, time,
            numbers, _numbers(gain or {}), find_gains, carried, _words(find_payload), passive_friction))

    def simulate(self, trajectory: str = "", *, samples: int | None = None, duration: float | None = None,
                 about: Sequence[float] | None = None, formulation: str = "tree", poses: bool = False,
                 progress: Progress | None = None) -> Run:
        """Moves the mechanism along a trajectory: torques, reactions, shaking forces.

        :param trajectory: name in the spec; "": the first one
        :param samples: both ends included
        :param duration: [s]
        :param about: reference point of moments [m]
        :param formulation: `tree`, or `natural`: the second, independent one (planar mechanisms)
        :param poses: include the poses of all bodies: `body_position` [m], of their origins, and `body_orientation` [rad; in space a
            quaternion]
        :param progress: called from time to time with the completed fraction, 0 to 1
        :raises MotionError: unreachable, singular, …
        :raises ValueError: if the spec has no such trajectory, or an option does not suit it
        """
        return _moved(_native.simulate(self._native, trajectory, samples, duration, _point(about), formulation, poses,
                                       progress))

    def state(self, at: str | Mapping[str, float], *, rates: Mapping[str, float] | None = None,
              accelerations: Mapping[str, float] | None = None, time: float = 0, independent: Sequence[str] = (),
              about: Sequence[float] | None = None, trajectory: str = "", poses: bool = False) -> Run:
        """Everything at a single state: torques, reactions, shaking forces; a run of one sample without metrics.

        :param at: joint coordinates that determine the pose [rad or m]; or, as for the option `--at`, `start`, `end` or a pose as
            text in the spec's units: `tool: [0.1, 0.2]`
        :param rates: of the independent coordinates [rad/s or m/s]; those not named are 0; likewise `accelerations`
        :param time: for time-dependent loads and payloads [s]
        :param independent: other coordinates than `Mechanism.independent`
        :param about: reference point of moments [m]; None: the trajectory's
        :param trajectory: that start, end and reference point refer to; "": the spec's first
        :param poses: include the poses of all bodies
        :raises MotionError: unreachable, singular, …; if only the torques cannot be determined, `torque` is missing and `notes` says why
        """
        joints = [] if isinstance(at, str) else _numbers(at)
        if not isinstance(at, str) and not joints:
            raise ValueError("at: must name at least one coordinate")
        return _moved(_native.observe(self._native, trajectory, at if isinstance(at, str) else "", joints,
                                      _numbers(rates or {}), _numbers(accelerations or {}), time, list(independent),
                                      _point(about), poses))

    def control(self, controller: str = "", trajectory: str = "", *, samples: int | None = None,
                duration: float | None = None, about: Sequence[float] | None = None, settle: float = 0, steps: int = 0,
                poses: bool = False, progress: Progress | None = None) -> Run:
        """Simulates the mechanism, moving by its own dynamics, under a controller that follows a trajectory.

        :param controller: of the spec, or a built-in one; "": the spec's first, else computed-torque
        :param trajectory: name in the spec; "": the first one
        :param samples: both ends included
        :param duration: [s]
        :param about: reference point of moments [m]
        :param settle: time to hold the last pose [s]
        :param steps: limit of integration steps; 0: the default
        :param poses: include the poses of all bodies
        :param progress: called from time to time with the completed fraction, 0 to 1
        :raises MotionError: if the run ends early; its `run` then contains the samples up to that time
        """
        return _moved(_native.control(self._native, controller, trajectory, samples, duration, _point(about), settle,
                                      steps, poses, progress))


def _numbers(values: Mapping[str, float]) -> List[Tuple[str, float]]:
    return [(name, float(value)) for name, value in values.items()]


def _point(about: Sequence[float] | None) -> List[float] | None:
    return None if about is None else [float(number) for number in about]


def _moved(native: _native.Run) -> Run:
    run = Run(native)
    if native.status != "done":
        raise MotionError(native.reason, native.status, native.end, run if native.rows > 0 else None)
    return run


def _read(text: str, file: str, overrides: Sequence[Tuple[str, str]]) -> Spec:
    return Spec(_native.Spec(text, file, list(overrides)))


def load(source: Path, set: Mapping[str, Any] | None = None, *, file: str | None = None) -> Spec:
    """Reads a spec.

    :param source: path of the spec; or its text, if it has more than one line
    :param set: parameters to override: numbers, or expressions over the other parameters
    :param file: name of a text in messages; relative paths in the text refer to the folder of this name
    :returns: the spec, checked
    :raises SpecError: with all mistakes in the spec
    :raises FileNotFoundError: if there is no such file; IsADirectoryError, PermissionError likewise
    """
    overrides = [(name, value if isinstance(value, str) else repr(float(value)) if isinstance(value, float)
                  else str(value)) for name, value in (set or {}).items()]
    if isinstance(source, str) and "\n" in source:
        return _read(source, file or "spec.yaml", overrides)
    if file is not None:
        raise ValueError("file: applies only to a spec given as text")
    name = os.fspath(source)
    return _read(_native.read_text(name), name, overrides)
