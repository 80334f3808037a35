"""Notebooks are kept without outputs: here they are run, and become Markdown with what they printed and drew."""

import base64
import os
import pathlib
import subprocess
import sys

import nbclient
import nbformat


def execute(path, folder, environment):
    """The notebook with its outputs, run in a folder. Raises what a cell raises."""
    notebook = nbformat.read(path, as_version=4)
    saved = dict(os.environ)
    os.environ.update(environment)
    try:
        nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()
    finally:
        os.environ.clear()
        os.environ.update(saved)
    return notebook


def outputs(cell, stem, folder, number):
    for k, output in enumerate(cell.get("outputs", [])):
        data = output.get("data", {})
        binary = next((kind for kind in ("png", "gif") if f"image/{kind}" in data), None)
        if binary:
            name = f"{stem}-{number}-{k}.{binary}"
            (folder / name).write_bytes(base64.b64decode(data[f"image/{binary}"]))
            yield f"![Figure]({name})\n"
        elif "image/svg+xml" in data:
            name = f"{stem}-{number}-{k}.svg"
            (folder / name).write_text(data["image/svg+xml"], encoding="utf-8")
            yield f"![Figure]({name})\n"
        elif "text/html" in data:
            yield f"```{{raw}} html\n{data['text/html'].strip()}\n```\n"
        elif text := output.get("text") or data.get("text/plain"):
            yield f"```\n{text.rstrip()}\n```\n"


def markdown(notebook, stem, folder):
    parts = []
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            parts.append(cell.source + "\n")
        elif cell.cell_type == "code":
            parts += [f"```python\n{cell.source}\n```\n", *outputs(cell, stem, folder, number)]
    return "\n".join(parts)


def surroundings(program):
    """So that a cell finds the program by its name, and the Python module of the same build."""
    folder = pathlib.Path(program).resolve().parent
    modules = [str(folder / "python"), os.environ.get("PYTHONPATH", "")]
    return {"PATH": f"{folder}:{os.environ['PATH']}", "PYTHONPATH": ":".join(filter(None, modules)),
            "PYDEVD_DISABLE_FILE_VALIDATION": "1"}  # a kernel is started without a word


def can_run(path, program):
    """Whether this build has what the notebook imports: the Python module may be left out of one."""
    if "import balance_mechanisms" not in path.read_text(encoding="utf-8"):
        return True
    tried = subprocess.run([sys.executable, "-c", "import balance_mechanisms"], env={**os.environ, **surroundings(program)}, check=False,
                           capture_output=True)
    return tried.returncode == 0


def write(source, folder, program):
    folder.mkdir(parents=True, exist_ok=True)
    contents = []
    for path in sorted(source.glob("*.ipynb")):
        ran = can_run(path, program)
        notebook = execute(path, source, surroundings(program)) if ran else nbformat.read(path, as_version=4)
        (folder / f"{path.stem}.md").write_text(markdown(notebook, path.stem, folder), encoding="utf-8")
        contents.append(path.stem)
    readme = folder / "README.md"
    if readme.exists() and contents:
        text = readme.read_text(encoding="utf-8").replace(".ipynb)", ".md)")
        readme.write_text(text + "\n```{toctree}\n:hidden:\n\n" + "\n".join(contents) + "\n```\n", encoding="utf-8")
