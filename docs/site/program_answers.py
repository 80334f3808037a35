"""What the pages of the gallery ask the program, and what they take from a spec."""

import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


def ask(program, *words):
    """What a command prints with --json; nothing if the mechanism cannot do it."""
    done = subprocess.run([program, *words, "--json"], capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else None


def escape_markdown(text):
    return re.sub(r"([*_<>\[\]`])", r"\\\1", text)


def escape_cell(text):
    """A table's cell: what stands between backticks is code, and a bar does not end the cell."""
    parts = text.split("`")
    return "`".join(part if i % 2 else escape_markdown(part) for i, part in enumerate(parts)).replace("|", "\\|")


def story(text):
    """(name, comment at its head as Markdown) of a spec."""
    name = re.search(r"^name: *(.*?) *(?:#.*)?$", text, re.MULTILINE)
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line[1:].removeprefix(" "))
    # Formulas are indented and must not become Markdown's quotes or emphasis.
    escaped = [escape_markdown(line.strip()) + ("  " if line.startswith("    ") else "") for line in lines]
    return name.group(1).strip("\"'") if name else "", "\n".join(escaped)
