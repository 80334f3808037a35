"""Exceptions: errors of a spec, and requests that a mechanism cannot satisfy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from balance_mechanisms._run import Run


class SpecError(ValueError):
    """A spec, a suite or a foreign file is invalid; the message has one line per mistake.

    `file`, `line`, `column` (from 1; 0: no position) and `key` are those of the first mistake; `mistakes` lists all of them, each with
    file, line, column, key, message, expected, found and hint.
    """

    def __init__(self, message: str, mistakes: list[dict[str, Any]]) -> None:
        super().__init__(message)
        self.mistakes = mistakes
        first = mistakes[0]
        self.file: str = first["file"]
        self.line: int = first["line"]
        self.column: int = first["column"]
        self.key: str = first["key"]

    def __reduce__(self) -> tuple[Any, ...]:
        return SpecError, (str(self), self.mistakes)


class MechanismError(RuntimeError):
    """The mechanism does not allow what was requested: no conditions, no design, no assembly. `status` is one word, `reason` a sentence."""

    def __init__(self, reason: str, status: str) -> None:
        super().__init__(reason)
        self.reason = reason
        self.status = status

    def __reduce__(self) -> tuple[Any, ...]:
        return MechanismError, (self.reason, self.status)


class MotionError(MechanismError):
    """The mechanism cannot perform a motion. `time` is when it stopped [s]; `run` is the run up to that time, or None."""

    def __init__(self, reason: str, status: str, time: float, run: Run | None = None) -> None:
        super().__init__(reason, status)
        self.time = time
        self.run = run

    def __reduce__(self) -> tuple[Any, ...]:
        return MotionError, (self.reason, self.status, self.time)  # runs do not travel
