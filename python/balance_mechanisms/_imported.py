"""The result of an import."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Tuple

from balance_mechanisms._display import Shown, Table

if TYPE_CHECKING:
    from balance_mechanisms._spec import Spec


class Imported(Shown):
    """A spec made from a foreign file, with findings about that file."""

    def __init__(self, found: Mapping[str, Any], file: str) -> None:
        self._found = dict(found)
        self._file = file

    def __repr__(self) -> str:
        return f"<balance_mechanisms.Imported from {self._file!r}: {self.format}>"

    def _summary(self) -> Tuple[List[Table], List[str]]:
        found = self._found
        table = Table(f"{self._file} ({self.format}): {found['bodies']} bodies, {found['joints']} joints, {found['loops']} loops, "
                      f"{found['total_mass']:.6g} kg", ["", "place", "subject", "finding"],
                      [[one["level"], os.path.basename(one["file"]) + (f":{one['line']}" if one["line"] else ""), one["subject"], one["message"]] for one in self.findings])
        return [table], [found["not_assembled"]] if found["not_assembled"] else []

    @property
    def format(self) -> str:
        """`URDF`, `MJCF`, `MBSE` or `Chrono`."""
        return str(self._found["format"])

    @property
    def spec_text(self) -> str:
        """The spec, with comments that name the lines it was made from."""
        return str(self._found["spec_text"])

    @property
    def spec(self) -> Spec:
        """The spec, loaded."""
        from balance_mechanisms._spec import load

        return load(self.spec_text, file=os.path.splitext(self._file)[0] + ".yaml")

    @property
    def findings(self) -> List[Dict[str, Any]]:
        """Warnings and notes: level, code, file, line, subject, message."""
        return list(self._found["findings"])

    @property
    def warnings(self) -> List[str]:
        """The warnings as text, including one if the loops could not be closed."""
        texts = [f"{one['file']}:{one['line']}: {one['subject']}: {one['message']}" for one in self.findings
                 if one["level"] == "warning"]
        return texts + ([self._found["not_assembled"]] if self._found["not_assembled"] else [])

    def to_dict(self) -> Dict[str, Any]:
        """Everything: format, findings, ignored, renamed, bodies, joints, loops, total_mass, dof, actuators, assembly, spec_text."""
        return dict(self._found)
