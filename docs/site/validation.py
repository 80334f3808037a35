"""The page "Validation": printed numbers beside ours, made from the summary of configs/suites/published.yaml."""

import html
import json
import math
import pathlib
import re
import shutil

from program_answers import ROOT

SUITE = ROOT / "configs/suites/published.yaml"
MANY_ROWS = 8  # a case with more of them is folded

# Verdicts of the suite's language in the order of the counts: (word, what the page calls one, what it calls many).
VERDICTS = (
    ("reproduced", "reproduced", "are reproduced to their printed digits"),
    ("improved", "improved, with proof", "belong to a design that is improved here, with proof"),
    ("best-known", "improved", "belong to a design that is improved here, without proof"),
    ("first-approximation", "first approximation", "are first approximations; the exact number is reproduced"),
    ("drawn", "drawn", "were drawn or measured on paper; the exact number is reproduced"),
    ("rounded", "rounded", "are rounded on the way; the exact number is reproduced"),
    ("misprint", "source's misprint", "are misprints; the right number is reproduced"),
    ("source-wrong", "source wrong", "are wrong in the source; the right number is reproduced"),
)
NAMES = {word: name for word, name, _ in VERDICTS}


def text(value):
    return html.escape(str(value), quote=False)


def significant_digits(number):
    """How many digits a number is written with: 6.90536 has six."""
    digits = re.sub(r"[eE].*", "", str(number)).replace("-", "").replace(".", "").lstrip("0")
    return len(digits)


def shown(value, digits):
    """A number with so many digits, with a typographic minus sign and powers of ten."""
    if value is None or not math.isfinite(value):
        return "–"
    written = f"{value:.{digits}g}".replace("-", "−")
    return re.sub(r"e(−?)\+?0*(\d+)$", r" · 10<sup>\1\2</sup>", written)


def as_printed(value):
    return "–" if value is None else shown(float(value), max(1, significant_digits(value)))


def deviation(row):
    """Ours against the printed number, as a text: +1.06 %."""
    value = row.get("deviation")
    if value is None or not math.isfinite(value):
        return "–"
    if abs(value) < 5e-6:
        return "0" if value == 0 else f"{shown(100 * value, 1)}\N{NO-BREAK SPACE}%"
    return f"{100 * value:+.3g}\N{NO-BREAK SPACE}%".replace("-", "−")


def with_unit(number, row):
    if number == "–" or not row.get("unit"):
        return number
    return f"{number} " + re.sub(r"\^(\d+)", r"<sup>\1</sup>", text(row["unit"]))


def cells(row):
    """What the columns say of one printed number."""
    digits = min(16, max(6, significant_digits(row["printed"]) + 1, significant_digits(row.get("exact") or 0)))
    verdict = NAMES.get(row["verdict"], text(row["verdict"]))
    if not row["holds"]:
        verdict = f"does not hold ({verdict})"
    note = f'<br><small>{text(row["note"])}</small>' if row.get("note") else ""
    return (text(row["what"]) + note, with_unit(as_printed(row["printed"]), row), with_unit(shown(row.get("ours"), digits), row), deviation(row),
            f'<span class="verdict {text(row["verdict"]) if row["holds"] else "missed"}">{verdict}</span>')


def table_of(labels, lines):
    """A table whose cells know their column's label, which a narrow screen shows beside them."""
    head = "".join(f"<th>{label}</th>" for label in labels)
    rows = ("<tr>" + "".join(f'<td data-label="{label}">{content}</td>' for label, content in zip(labels, line)) + "</tr>\n" for line in lines)
    return f'<table class="validation"><thead><tr>{head}</tr></thead><tbody>\n{"".join(rows)}</tbody></table>\n'


def table(rows):
    return table_of(("what", "printed", "ours", "deviation", "verdict"), [cells(row) for row in rows])


def improvements(cases):
    """The designs that are better than the published ones."""
    lines = [(f'<a href="#{text(case["name"])}">{text(case["name"])}</a>: {text(row["what"])}<br><small>{text(case["source"])}</small>', with_unit(as_printed(row["printed"]), row),
              with_unit(shown(row.get("ours"), 6), row), deviation(row), "proved" if row["verdict"] == "improved" else "best known")
             for case in cases for row in case["published"] if row["verdict"] in ("improved", "best-known") and row["holds"]]
    return "## Published designs, improved\n\n" + table_of(("what", "published design", "ours", "change", "optimality"), lines) if lines else ""


def counted(number, singular, plural):
    return f"{number} {singular if number == 1 else plural}"


def folded(name, rows):
    """A table of many numbers behind one line that sums them up."""
    missed = sum(not row["holds"] for row in rows)
    largest = max((abs(row["ours"] - row["exact"]) / abs(row["exact"]) for row in rows if row.get("exact") and row.get("ours") is not None), default=0)
    verdict = f"{missed} do not hold" if missed else f"all hold, the largest relative deviation from an exact number is {shown(largest, 2)}"
    return f"<details><summary>{text(name)}: {counted(len(rows), 'number', 'numbers')}, {verdict}</summary>\n{table(rows)}</details>\n"


def family(name):
    """Cases that differ by a number of three digits at the end are the states of one: lcc-ur5-001."""
    return re.sub(r"-\d{3}$", "", name)


def spec_link(case, pages):
    """Where a reader sees the spec: its page in the gallery, or the file."""
    stem = pathlib.PurePosixPath(case["spec"]).stem
    return pages.get(stem, f"specs/{stem}.yaml")


def case_html(name, cases, pages):
    source = text(cases[0]["source"]) + (f', p. {text(cases[0]["page"])}' if cases[0].get("page") else "")
    link = f'<a href="{html.escape(spec_link(cases[0], pages))}">{text(name)}</a>'
    rows = [row for case in cases for row in case["published"]]
    waits = [wait for case in cases for wait in case["waits"]]
    parts = [f'<h3 id="{text(name)}">{link} <small>{source}</small></h3>\n']
    if rows:
        parts.append(folded(f"{len(cases)} states" if len(cases) > 1 else "the state", rows) if len(rows) > MANY_ROWS else table(rows))
    if waits:
        parts.append('<p class="waits">waits: ' + "; ".join(
            text(wait["what"]) + (f' (printed {text(wait["printed"])})' if wait["printed"] is not None else "") + f': {text(wait["reason"])}'
            for wait in waits) + "</p>\n")
    return "".join(parts)


def header(rows, cases, waits, version):
    lines = []
    for word, _, many in VERDICTS:
        number = sum(row["verdict"] == word and row["holds"] for row in rows)
        if number:
            lines.append(f"| {number} | {many} |\n")
    missed = sum(not row["holds"] for row in rows)
    if missed:
        lines.append(f"| {missed} | **do not hold** |\n")
    if waits:
        lines.append(f"| {len(waits)} more | wait for a capability; the reason stands beside them |\n")
    return (f"{version} has computed {counted(len(rows), 'printed number', 'printed numbers')} of {counted(cases, 'case', 'cases')} while this page "
            "was built: textbooks, papers, and the tests of other programs. Where a printed number is not exact, a requirement asks for the exact one, which an "
            "independent computation has found. `balance batch configs/suites/published.yaml` does the same on any machine.\n\n"
            "| numbers | |\n| --- | --- |\n" + "".join(lines))


def chapter_of(case):
    """The book, paper or program that a case is from."""
    return case["source"].split(", ")[0]


def page(summary, pages, version):
    """The page's Markdown, with tables in HTML that a phone shows row by row."""
    cases = [case for case in summary["cases"] if case.get("published") or case.get("waits")]
    for case in cases:
        case["published"], case["waits"] = case.get("published") or [], case.get("waits") or []
    rows = [row for case in cases for row in case["published"]]
    waits = [wait for case in cases for wait in case["waits"]]
    parts = ["# Validation\n", header(rows, len({family(case["name"]) for case in cases}), waits, version)]
    parts.append(improvements(cases))
    chapters = {}
    for case in cases:
        chapters.setdefault(chapter_of(case), {}).setdefault(family(case["name"]), []).append(case)
    for chapter, families in chapters.items():
        parts.append(f"## {chapter}\n\n" + "".join(case_html(name, of_it, pages) for name, of_it in families.items()))
    return "\n".join(parts)


def write(summary_file, folder, built, version):
    """validation.md into `folder`; the specs, which it links to, where the built site will find them."""
    summary = json.loads(pathlib.Path(summary_file).read_text(encoding="utf-8"))
    pages = {path.stem: f"{path.relative_to(folder).with_suffix('.html').as_posix()}" for path in (folder / "gallery").rglob("*.md") if path.stem != "index"}
    specs = built / "specs"
    specs.mkdir(parents=True, exist_ok=True)
    for case in summary["cases"]:
        spec = (SUITE.parent / case["spec"]).resolve()
        if spec.is_file():
            shutil.copyfile(spec, specs / spec.name)
    (folder / "validation.md").write_text(page(summary, pages, version), encoding="utf-8")
