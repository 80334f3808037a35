"""The gallery: a page for every mechanism of configs, with its picture and its page, both made by the program."""

import os
import pathlib
import shutil
import subprocess
import tempfile

import published_cases
from program_answers import ROOT, ask, story

FIGURES = {"torque": "Peak torque", "shaking_force": "Peak shaking force", "shaking_moment": "Peak shaking moment"}


def facts(program, spec):
    """Rows of a table: what it is, and the peaks of its first trajectory."""
    what = ask(program, "check", str(spec))
    rows = []
    if what:
        rows = [("Space", what["space"]), ("Moving bodies", what["bodies"]), ("Joints", what["joints"]), ("Loops", len(what["loops"])),
                ("Degrees of freedom", what["degrees_of_freedom"])]
    run = ask(program, "simulate", str(spec), "--quiet")
    for metric in run["metrics"] if run else []:
        if metric["quantity"] in FIGURES:
            rows.append((f"{FIGURES[metric['quantity']]}, along `{run['trajectory']}`", f"{metric['peak']:.6g} {metric['unit']}"))
    return "| | |\n| --- | --- |\n" + "".join(f"| {name} | {value} |\n" for name, value in rows)


def page(program, spec, folder, drawn):
    text = spec.read_text(encoding="utf-8")
    name, comment = story(text)
    parts = [f"# {name or spec.stem}\n"]
    if drawn:
        parts.append(f"![{name}]({spec.stem}.png)\n\n<a href=\"pages/{spec.stem}.html\">See it move</a>: its page, made by `balance report`.\n")
    parts += [comment + "\n", facts(program, spec), f"The spec, `configs/{spec.name}`:\n\n````yaml\n{text.rstrip()}\n````\n"]
    (folder / f"{spec.stem}.md").write_text("\n".join(parts), encoding="utf-8")
    return name or spec.stem


def packages():
    return os.environ.get("PAGE_PACKAGES", str(ROOT / "build/release/web"))


def browser():
    return os.environ.get("CHROMIUM") or shutil.which("chromium")


def lacking():
    """What drawing takes and is not there; nothing if all is."""
    if not browser() or not shutil.which("node"):
        return "drawing takes node and Chromium; scripts/setup installs them, --without-pictures does without"
    if not (pathlib.Path(packages()) / "node_modules/playwright-core").is_dir():
        return f"drawing takes the packages of the page's tests, which are not in {packages()}; --without-pictures does without"
    return ""


def draw(program, specs, folder, pages):
    """Pictures into `folder`, pages of `balance report` into `pages`. The mechanisms that were drawn."""
    pages.mkdir(parents=True)
    for spec in specs:
        subprocess.run([program, "report", str(spec), "-o", str(pages / f"{spec.stem}.html"), "--quiet"], check=True)
    environment = {**os.environ, "PAGE_PACKAGES": packages(), "CHROMIUM": browser()}
    with tempfile.TemporaryDirectory() as home:
        subprocess.run(["node", str(ROOT / "docs/site/pictures.mjs"), str(pages), str(folder)], check=True, env={**environment, "HOME": home})


def write(program, specs, published, folder, built, draw_them):
    """Markdown and pictures into `folder`; pages of `balance report` where the built site will find them.
    @param published specs of configs/published, which have a gallery of their own below"""
    folder.mkdir(parents=True)
    if draw_them:
        draw(program, specs, folder, built / "pages")
    names = {spec.stem: page(program, spec, folder, draw_them) for spec in specs}
    cards = "".join(f'<figure><a href="{stem}.html">' + (f'<img src="../_images/{stem}.png" alt="">' if draw_them else "")
                    + f"<figcaption>{name}</figcaption></a></figure>\n" for stem, name in names.items())
    contents = "\n".join(names)
    lead = "Every mechanism in `configs`, drawn by the program."
    if published:
        published_cases.write(program, published, folder / "published", draw_them)
        contents = "published/index\n" + contents
        lead += " Mechanisms of papers, textbooks and other programs are among the [published cases](published/index.md)."
    (folder / "index.md").write_text(
        f"# Gallery\n\n{lead}\n\n"
        f'<div class="gallery">\n{cards}</div>\n\n```{{toctree}}\n:hidden:\n\n{contents}\n```\n', encoding="utf-8")
