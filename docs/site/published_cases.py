"""Gallery of the published cases: a page for each spec of configs/published, drawn by `balance plot`, and of a design before and after."""

import pathlib
import shutil
import subprocess
import tempfile

from program_answers import ask, escape_cell, story

FIGURES = ("torque", "force", "shaking_force", "shaking_moment")
SECONDS = "3"  # of a search: the optimum of most is proved within one


def can_draw():
    return shutil.which("gnuplot") is not None


def plot(program, picture, *arguments):
    """The picture's name, or nothing if what it shows does not exist."""
    done = subprocess.run([program, "plot", *map(str, arguments), "-o", str(picture), "--quiet"], capture_output=True, text=True, check=False)
    return picture.name if done.returncode == 0 else ""


def view(check):
    return ["--plane", "isometric"] if check["space"] == "spatial" else []


def peak_changes(run):
    """Peaks of a designed run before and after."""
    return [change for change in run["changes"] if change["figure"] == "peak" and change["quantity"] in FIGURES]


def peak_rows(peaks, trajectory):
    return [(f"peak {peak['quantity'].replace('_', ' ')}, `{trajectory}`", peak["unit"], peak["before"], peak["after"]) for peak in peaks]


def most_reduced(peaks):
    """The quantity whose peak fell most; nothing without one."""
    return min((peak for peak in peaks if peak["before"]), key=lambda peak: peak["after"] / peak["before"], default={"quantity": ""})["quantity"]


def changes(design):
    """Rows of a table: what the design was asked to minimize and the peaks of its runs, before and after."""
    rows = []
    objective = design.get("objective")
    if objective:
        rows.append((objective["name"], objective["unit"], objective["start"], objective["value"]))
    for run in design["trajectories"]:
        rows += peak_rows(peak_changes(run), run["trajectory"])
    return rows


def number(value):
    return "–" if value is None else f"{value:.6g}"


def words(*statuses):
    return ", ".join(word.replace("-", " ") for word in statuses if word != "not-asked")


def designed_runs(program, spec, scratch):
    """(what was reached, rows of the table, runs before and after to draw, quantity to draw) of a design; nothing without one."""
    file = scratch / "design.h5"
    design = ask(program, "design", str(spec), "--seconds", SECONDS, "--h5", str(file))
    if not design:
        return None
    if "front" in design:
        return middle_of_front(program, spec, scratch, design["front"]["middle"])
    runs, quantity = [], ""
    if design["trajectories"]:
        first = design["trajectories"][0]
        runs = [f"{file}:{side}/{first['trajectory'].replace('/', '_')}" for side in ("before", "after")]
        quantity = most_reduced(peak_changes(first))
    return words(design["status"], design["optimality"]), changes(design), runs, quantity


def middle_of_front(program, spec, scratch, point):
    """The same of a trade-off, whose middle point is taken as the design. It has no runs of its own."""
    file = scratch / "after.yaml"
    ask(program, "design", str(spec), "--seconds", SECONDS, "--point", str(point), "-o", str(file))
    runs = [ask(program, "simulate", str(one), "--quiet") for one in (spec, file)] if file.exists() else [None]
    if None in runs:
        return None
    before, after = ({metric["quantity"]: metric for metric in run["metrics"]} for run in runs)
    peaks = [{"quantity": quantity, "unit": before[quantity]["unit"], "before": before[quantity]["peak"], "after": after[quantity]["peak"]}
             for quantity in FIGURES if quantity in before and quantity in after]
    return f"point {point} of its trade-off", peak_rows(peaks, runs[0]["trajectory"]), [str(spec), str(file)], most_reduced(peaks)


def before_and_after(program, spec, check, folder, draws):
    """Markdown of a design: its figures, the mechanism and one quantity, before and after."""
    with tempfile.TemporaryDirectory() as scratch:
        design = designed_runs(program, spec, pathlib.Path(scratch))
        if not design:
            return ""
        reached, rows, runs, quantity = design
        parts = ["## Before and after\n", f"`balance design {spec.name}`: {reached}.\n",
                 "| | before | after | |\n| --- | ---: | ---: | --- |\n"
                 + "".join(f"| {escape_cell(name)} | {number(before)} | {number(after)} | {unit or ''} |\n" for name, unit, before, after in rows if before or after)]
        if draws and runs:
            runs = [*runs, "--label", "before", "--label", "after"]
            poses = plot(program, folder / f"published-{spec.stem}-design.svg", *runs, "--path", "--poses", "1", "--side-by-side", *view(check))
            curve = quantity and plot(program, folder / f"published-{spec.stem}-figure.svg", *runs, "--quantity", quantity)
            parts += [f"![The mechanism before and after the design]({poses})\n"] if poses else []
            parts += [f"![{quantity.replace('_', ' ')} before and after the design]({curve})\n"] if curve else []
    return "\n".join(parts)


def page(program, spec, folder, draws):
    """Writes the page of a case. @return (name, name of its picture, empty without one)"""
    text = spec.read_text(encoding="utf-8")
    name, comment = story(text)
    check = ask(program, "check", str(spec))
    shutil.copyfile(spec, folder / spec.name)
    picture = ""
    if check and draws:
        picture = plot(program, folder / f"published-{spec.stem}.svg", spec, "--path", "--poses", "4", *view(check))
    parts = [f"# {name or spec.stem}\n", comment + "\n", f"The spec: [`configs/published/{spec.name}`]({spec.name})\n"]
    if picture:
        parts.append(f"![{name}: its paths and poses]({picture})\n")
    if check and "\ndesign:" in text:
        parts.append(before_and_after(program, spec, check, folder, draws))
    (folder / f"{spec.stem}.md").write_text("\n".join(parts), encoding="utf-8")
    return name or spec.stem, picture


def write(program, specs, folder, draws):
    """A page for each spec, and one with all of them. @param folder where the gallery's Markdown is"""
    folder.mkdir(parents=True)
    cases = {spec.stem: page(program, spec, folder, draws and can_draw()) for spec in specs}
    cards = "".join(f'<figure><a href="{stem}.html">' + (f'<img src="../../_images/{picture}" alt="" loading="lazy">' if picture else "")
                    + f"<figcaption>{stem}: {name}</figcaption></a></figure>\n" for stem, (name, picture) in cases.items())
    contents = "\n".join(cases)
    (folder / "index.md").write_text(
        "# Published cases\n\nMechanisms of papers, of textbooks and of other programs' tests, as specs in `configs/published`, drawn by "
        "`balance plot --path --poses`. Designs are shown before and after.\n\n"
        f'<div class="gallery">\n{cards}</div>\n\n```{{toctree}}\n:hidden:\n\n{contents}\n```\n', encoding="utf-8")
