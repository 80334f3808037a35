"""Mechanisms as files of simulators."""

from __future__ import annotations

import os
from typing import List, NamedTuple, Union

from balance_mechanisms import _native

Path = Union[str, "os.PathLike[str]"]

_formats = {".xml": "mjcf", ".mjcf": "mjcf", ".sdf": "sdf", ".world": "sdf", ".urdf": "urdf"}


class ModelFile(NamedTuple):
    """A mechanism for simulators: the text of the file, notes on how it says things, and what its format cannot express."""

    text: str
    notes: List[str]
    missing: List[str]


def choose_format(path: Path | None, format: str) -> str:
    """That of the path if none is given. :raises ValueError: if neither tells"""
    chosen = format or _formats.get(os.path.splitext(os.fspath(path))[1] if path is not None else "", "")
    if chosen not in _formats.values():
        raise ValueError("format: expected mjcf, sdf or urdf, or a path that ends in "
                         f"{', '.join(_formats)}; got {format or path!r}")
    return chosen


def write_model(spec: _native.Spec, spec_file: str, path: Path | None, format: str, trajectory: str) -> ModelFile:
    """See `Spec.export`."""
    chosen = choose_format(path, format)
    if path is not None and os.path.exists(path) and os.path.exists(spec_file) and os.path.samefile(path, spec_file):
        raise ValueError(f"{os.fspath(path)} is the spec itself")
    model = ModelFile(*_native.export_model(spec, chosen, trajectory))
    if path is not None:
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(model.text)
    return model
