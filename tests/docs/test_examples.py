#!/usr/bin/env python3
"""The commands that the reference pages show run, in the order of a page, in a folder that has nothing but what the clone has."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import yaml

from _console import ROOT, blocks, workplace

# Tutorials, how-tos, the README and ci.md have tests of their own, library.md is compiled by the test of the installation.
ELSEWHERE = {"README.md", "how-to.md", "ci.md", "library.md", "python.md"}
PAGES = sorted(page for page in (ROOT / "docs").glob("*.md") if page.name not in ELSEWHERE)
# A finding is what `import --strict` is asked for.
FINDS = {"balance import tests/import/cases/2f85.xml --strict --json": 1}


def commands(text):
    """Calls of the program in blocks of commands; a line that ends in a backslash goes on."""
    for language, block in blocks(text):
        if language in ("", "bash"):
            for line in block.replace("\\\n", " ").splitlines():
                if line.startswith("balance ") and "$" not in line:
                    yield re.sub(r"\s+# .*", "", line)


class Examples(unittest.TestCase):
    def test_every_command_of_every_page_runs(self):
        count = 0
        for page in PAGES:
            with tempfile.TemporaryDirectory() as temporary:
                folder, environment = workplace(temporary)
                for command in commands(page.read_text(encoding="utf-8")):
                    count += 1
                    with self.subTest(page=page.name, command=command):
                        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False)
                        self.assertEqual(done.returncode, FINDS.get(command, 0), done.stderr + done.stdout[-500:])
        self.assertGreaterEqual(count, 20)

    def test_every_fragment_of_a_spec_is_yaml(self):
        for page in PAGES:
            for language, block in blocks(page.read_text(encoding="utf-8")):
                if language == "yaml":
                    with self.subTest(page=page.name, block=block[:40]):
                        yaml.safe_load(block)


if __name__ == "__main__":
    unittest.main()
