"""Runs what a page of documentation shows. A block ```console holds sessions: a line `$ command` runs (with the next line, where it ends in a
backslash), the lines below it are its output, and `...` stands for any number of lines. A block whose first line is `# NAME` with a suffix is a file of that name."""

import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w.-]+\.(?:yaml|py|csv))$")


def blocks(text):
    """(language, content) of every fenced block."""
    yield from BLOCK.findall(text)


def prose(text):
    """The page without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


def sessions(block):
    """(command, expected lines) of a console block."""
    command, expected = None, []
    for line in block.splitlines():
        if command and command.endswith("\\"):
            command += f"\n{line}"
        elif line.startswith("$ "):
            if command:
                yield command, expected
            command, expected = line[2:], []
        else:
            expected.append(line)
    yield command, expected


def write_file(block, folder):
    """The file that a block is, if it is one."""
    name = FILE.match(block.split("\n", 1)[0])
    if name:
        (folder / name.group(1)).write_text(block, encoding="utf-8")


def execute(command, folder, environment):
    """(exit code, printed lines, standard error) of a command."""
    done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, [line.rstrip() for line in done.stdout.splitlines()], done.stderr


def agrees(expected, printed):
    parts = [".*" if line == "..." else re.escape(line) for line in expected]
    return re.fullmatch("\n".join(parts), "\n".join(printed), re.DOTALL) is not None


def workplace(folder):
    """A folder in which the commands find the mechanisms and the programs by the names that a user types in the clone."""
    folder = pathlib.Path(folder)
    for name in ("bin", "out"):
        (folder / name).mkdir()
    (folder / "configs").symlink_to(os.environ["CONFIGS"])
    for name in ("tests", "scripts"):
        (folder / name).symlink_to(ROOT / name)
    (folder / "bin" / "balance").symlink_to(os.environ["BALANCE"])
    (folder / "bin" / "python3").symlink_to(sys.executable)
    return folder, {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}


def run_page(text, folder, environment):
    """What differs, the number of commands, and what the last one printed."""
    differing, count, printed = [], 0, []
    for language, block in blocks(text):
        write_file(block, folder)
        for command, expected in sessions(block) if language == "console" else ():
            count += 1
            code, printed, errors = execute(command, folder, environment)
            if code != 0 or not agrees(expected, printed):
                differing.append(f"$ {command}\nexit code {code}\n" + "\n".join(printed) + errors)
    return differing, count, printed
