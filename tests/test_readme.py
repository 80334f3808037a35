#!/usr/bin/env python3
"""Runs the commands that README.md shows and compares what they print with what it says they print."""

import sys
import tempfile

from docs._console import ROOT, run_page, workplace


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder, environment = workplace(temporary)
        differing, count, _ = run_page((ROOT / "README.md").read_text(encoding="utf-8"), folder, environment)
    for text in differing:
        print(f"README.md says otherwise than the program: {text}")
    print(f"{count} commands of README.md")
    return 1 if differing or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
