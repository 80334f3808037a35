"""Files: results, suites, robots."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple, Union

from balance_mechanisms import _native
from balance_mechanisms._reports import Batch, Comparison
from balance_mechanisms._imported import Imported
from balance_mechanisms._run import Run
from balance_mechanisms._spec import Path, Progress, Spec

Runs = Union[Mapping[str, Union[Run, Path]], Sequence[Union[Run, Path]]]


def read(path: Path) -> Run:
    """Reads a result file; `design.h5:after/cycloid` is one run of a design file.

    :raises FileNotFoundError: if there is no such file; IsADirectoryError, PermissionError likewise
    :raises OSError: if it was not written by this program, or is damaged
    """
    return Run(_native.read_result(os.fspath(path)))


def _named(runs: Runs) -> List[Tuple[str, Run]]:
    if isinstance(runs, Mapping) and not isinstance(runs, Run):
        return [(name, one if isinstance(one, Run) else read(one)) for name, one in runs.items()]
    all_runs: List[Tuple[str, Run]] = []
    for k, one in enumerate(runs):
        if isinstance(one, Run):
            name = "base" if k == 0 else one.description["trajectory"] or f"run {k}"
        else:
            name, one = os.path.splitext(os.path.basename(os.fspath(one)))[0], read(one)
        taken = {other for other, _ in all_runs}
        all_runs.append((name if name not in taken else f"{name} {k}", one))
    return all_runs


def compare(runs: Runs, require: Union[str, Sequence[str]] = ()) -> Comparison:
    """Compares runs with the first one, the base (docs/compare.md).

    :param runs: runs or paths of result files; in a dict, by the names used in requirements
    :param require: requirements such as `peak(shaking_force) <= 0.9 * base`; values are SI
    :raises ValueError: if a requirement is not understood, or names what no run has; if there are no runs
    :raises FileNotFoundError: if there is no such file; IsADirectoryError, PermissionError likewise
    """
    texts = [require] if isinstance(require, str) else list(require)
    return Comparison(_native.compare([(name, run._native) for name, run in _named(runs)], texts))


def batch(suite: Path, *, jobs: int = 1, folder: Path | None = None, shard: Tuple[int, int] | None = None,
          force: bool = False, metrics_only: bool = False, retry_failed: bool = False, case_timeout: float = 3600,
          progress: Progress | None = None) -> Batch:
    """Runs the cases of a suite (docs/suite.md), each in a process of its own; continues an interrupted batch.

    :param jobs: number of cases run at once
    :param folder: for the results; default: `<suite>-results` in the working folder
    :param shard: (index, count): run only this part of the cases
    :param force: use a folder with other contents
    :param metrics_only: write only metrics, no samples
    :param retry_failed: compute cases again that failed before
    :param case_timeout: time limit per case [s]; 0: none
    :param progress: called from time to time with the completed fraction, 0 to 1
    :returns: what was computed; cases that failed are in it, with their messages
    :raises SpecError: if the suite is wrong; mistakes in a case's spec are that case's
    :raises FileNotFoundError: if there is no such suite; IsADirectoryError, PermissionError likewise
    :raises OSError: if the folder cannot be used: it has other contents, or another batch runs in it
    """
    name = os.fspath(suite)
    place = os.fspath(folder) if folder is not None else os.path.splitext(os.path.basename(name))[0] + "-results"
    return Batch(_native.batch(name, place, jobs, shard, force, metrics_only, retry_failed, case_timeout, progress), place)


def import_(path: Path, *, loops: Path | None = None, base: str = "", actuate: Sequence[str] = ()) -> Imported:
    """Makes a spec from a file of another program: URDF, MJCF, MBSE, Chrono (docs/import.md).

    :param loops: file with the loop closures of a URDF
    :param base: `fixed`: hold a floating base where it is
    :param actuate: joints that have motors, named as in the file
    :raises SpecError: if the file is wrong, or has what no spec can say; with its lines
    :raises FileNotFoundError: if there is no such file; IsADirectoryError, PermissionError likewise
    """
    found = _native.import_robot(os.fspath(path), "" if loops is None else os.fspath(loops), _is_fixed(base),
                                 list(actuate))
    return Imported(found, os.fspath(path))


class Exported(NamedTuple):
    """A foreign file with new masses: its text, what changed, and notes on what its format cannot express."""

    text: str
    changed: List[str]
    notes: List[str]


def export(spec: Spec, path: Path, *, loops: Path | None = None, base: str = "",
           actuate: Sequence[str] = ()) -> Exported:
    """The file that the spec was imported from, with the masses of the spec; nothing else of its text changes.

    :param path: of that file; `loops`, `base` and `actuate` as in the import
    :raises SpecError: if the file is wrong, or its bodies are not those of the spec
    :raises FileNotFoundError: if there is no such file; IsADirectoryError, PermissionError likewise
    """
    name = os.fspath(path)
    return Exported(*_native.export_robot(spec._native, _native.read_text(name), name,
                                          "" if loops is None else os.fspath(loops), _is_fixed(base), list(actuate)))


def parts(spec: Spec) -> str:
    """Counterweights and discs as CSV: name, kind, body, place in the body [m], mass [kg], inertia [kg m^2]."""
    return _native.parts_csv(spec._native)


def _is_fixed(base: str) -> bool:
    if base not in ("", "fixed"):
        raise ValueError(f"base: must be fixed, is {base!r}")
    return base == "fixed"


def kinds() -> Dict[str, str]:
    """The kinds of specs to start from (`new`), with a description of each."""
    return {kind: text.split("\n", 1)[0].lstrip("# ") for kind, text in _native.starters}


def new(kind: str) -> str:
    """The text of a commented spec to start from.

    :param kind: one of `kinds()`
    :raises ValueError: if there is no such kind
    """
    found: Any = dict(_native.starters).get(kind)
    if found is None:
        raise ValueError(f"there is no starter {kind!r}: expected {', '.join(kinds())}")
    return str(found)
