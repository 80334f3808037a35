"""Mechanisms as files of simulators."""

from __future__ import annotations

import os
from typing import List, NamedTuple, Union

from balance_mechanisms import _native

Path = Union[str, "os.PathLike[str]"]

class ModelFile(NamedTuple):
    """A mechanism for simulators: the text of the file, notes on how it says things, and what its format cannot express."""

    text: str
    notes: List[str]
    missing: List[str]


def write_model(spec: _native.Spec, spec_file: str, path: Path | None, format: str, trajectory: str) -> ModelFile:
    """See `Spec.export`."""
    if path is not None and os.path.exists(path) and os.path.exists(spec_file) and os.path.samefile(path, spec_file):
        raise ValueError(f"{os.fspath(path)} is the spec itself")
    model = ModelFile(*_native.export_model(spec, format, "" if path is None else os.fspath(path), trajectory))
    if path is not None:
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(model.text)
    return model
