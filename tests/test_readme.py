#!/usr/bin/env python3
"""Runs the commands that README.md shows and compares what they print with what it says they print.

A block begins with ```console; a line `$ command` runs; the lines below it are its output, and `...` stands for any
number of lines."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def sessions(text):
    """(command, expected lines) of every console block."""
    for block in re.findall(r"^```console\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        command, expected = None, []
        for line in block.splitlines():
            if line.startswith("$ "):
                if command:
                    yield command, expected
                command, expected = line[2:], []
            else:
                expected.append(line)
        yield command, expected


def agrees(expected, printed):
    parts = [".*" if line == "..." else re.escape(line) for line in expected]
    return re.fullmatch("\n".join(parts), "\n".join(printed), re.DOTALL) is not None


def workplace(folder):
    """A folder in which the commands find the mechanisms and the programs by the names that a user types."""
    folder = pathlib.Path(folder)
    for name in ("bin", "out"):
        (folder / name).mkdir()
    (folder / "configs").symlink_to(os.environ["CONFIGS"])
    (folder / "bin" / "balance").symlink_to(os.environ["BALANCE"])
    (folder / "bin" / "python3").symlink_to(sys.executable)
    return folder, {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}


def main():
    failed, count = False, 0
    with tempfile.TemporaryDirectory() as temporary:
        folder, environment = workplace(temporary)
        for command, expected in sessions((ROOT / "README.md").read_text(encoding="utf-8")):
            count += 1
            done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True,
                                  check=False)
            printed = [line.rstrip() for line in done.stdout.splitlines()]
            if done.returncode != 0 or not agrees(expected, printed):
                failed = True
                print(f"README.md says otherwise than the program: $ {command}\nexit code {done.returncode}")
                print("\n".join(printed), done.stderr)
    print(f"{count} commands of README.md")
    return 1 if failed or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
