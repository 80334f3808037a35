"""Tables for notebooks: HTML as shown in a browser, LaTeX as used when a notebook is printed."""

from __future__ import annotations

import html
import math
import re
from typing import Any, List, NamedTuple, Sequence, Tuple

MAX_ROWS = 24  # more is not a summary; `to_pandas` has all of it

_LATEX = {"\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "%": r"\%", "#": r"\#", "_": r"\_",
          "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}", "²": "$^2$", "–": "--", "…": r"\ldots{}"}


class Table(NamedTuple):
    """A caption, heads and rows of texts, numbers, yes-or-no values, or None for what is unknown."""

    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[Any]]

    def shortened(self) -> List[Sequence[Any]]:
        """The rows, or the first of them and how many more there are."""
        rows = list(self.rows)
        if len(rows) <= MAX_ROWS:
            return rows
        more = f"… {len(rows) - MAX_ROWS + 1} more"
        return [*rows[:MAX_ROWS - 1], [more, *[""] * (len(self.heads) - 1)]]


def text_of(value: Any) -> str:
    """A cell's text: numbers with six digits."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        return ", ".join(map(text_of, value))
    number = float(value)
    return "–" if math.isnan(number) else f"{number:.6g}"


def unit_head(name: str, unit: str) -> str:
    """`peak [N m]`; a number without unit has none."""
    return f"{name} [{pretty_unit(unit)}]" if unit not in ("", "1") else name


def pretty_unit(unit: str) -> str:
    """`kg m²` for `kg m^2`."""
    return unit.replace("^2", "²")


def _is_number(value: Any) -> bool:
    return value is None or isinstance(value, (int, float)) and not isinstance(value, bool) or hasattr(value, "dtype")


def _is_numeric(table: Table) -> List[bool]:
    """Which columns hold nothing but numbers."""
    return [bool(table.rows) and all(_is_number(row[k]) for row in table.rows) for k in range(len(table.heads))]


def html_of(tables: Sequence[Table], notes: Sequence[str] = ()) -> str:
    """The tables below each other, all text escaped, then the notes as paragraphs."""
    parts = []
    for table in tables:
        aligned = [f' style="text-align: {"right" if numeric else "left"}"' for numeric in _is_numeric(table)]
        heads = "".join(f"<th{style}>{html.escape(head)}</th>" for style, head in zip(aligned, table.heads))
        rows = "\n".join("<tr>" + "".join(f"<td{style}>{html.escape(text_of(value))}</td>" for style, value in zip(aligned, row)) + "</tr>"
                         for row in table.shortened())
        head = f"<thead><tr>{heads}</tr></thead>\n" if any(table.heads) else ""
        parts.append(f'<table>\n<caption style="text-align: left">{html.escape(table.caption)}</caption>\n{head}<tbody>\n{rows}\n</tbody>\n</table>')
    return "\n".join(parts + [f"<p>{html.escape(note)}</p>" for note in notes])


def latex_text(text: str) -> str:
    """The text with LaTeX's special characters escaped."""
    return re.sub("[" + re.escape("".join(_LATEX)) + "]", lambda found: _LATEX[found.group()], text)


def latex_of(tables: Sequence[Table], notes: Sequence[str] = ()) -> str:
    """The tables as `tabular` environments with their captions above, then the notes; needs no package."""
    parts = []
    for table in tables:
        columns = "".join("r" if numeric else "l" for numeric in _is_numeric(table))
        heads = " & ".join(latex_text(head) for head in table.heads) + r" \\ \hline" + "\n" if any(table.heads) else ""
        rows = "\n".join(" & ".join(latex_text(text_of(value)) for value in row) + r" \\" for row in table.shortened())
        parts.append(f"\\noindent {latex_text(table.caption)}\n\n\\noindent\n\\begin{{tabular}}{{{columns}}}\n\\hline\n{heads}{rows}\n"
                     "\\hline\n\\end{tabular}")
    return "\n\n\\medskip\n".join(parts + [f"\\noindent {latex_text(note)}" for note in notes]) + "\n"


class Shown:
    """What a notebook shows of a class with `_summary`: tables and notes."""

    def _summary(self) -> Tuple[List[Table], List[str]]:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        return html_of(*self._summary())

    def _repr_latex_(self) -> str:
        return latex_of(*self._summary())
