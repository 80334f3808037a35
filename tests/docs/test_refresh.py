#!/usr/bin/env python3
"""scripts/refresh-docs puts outputs of now into pages and leaves everything else as it is."""

import os
import pathlib
import subprocess
import tempfile
import unittest

from _console import ROOT, agrees
from _refresh import refreshed_output

PRINTED = ["a title", "", "quantity  unit   peak", "torque     N m  3.25", "power        W  1.50", "force        N  7.00", "written: a.h5"]


class Outputs(unittest.TestCase):
    def test_an_output_that_is_right_stays(self):
        self.assertEqual(refreshed_output(["...", PRINTED[3], "..."], PRINTED), ["...", PRINTED[3], "..."])

    def test_without_gaps_all_is_replaced(self):
        self.assertEqual(refreshed_output(["a title", "torque N m 1"], PRINTED), PRINTED)

    def test_lines_are_found_again_by_their_words(self):
        for expected, refreshed in (
                (["...", "torque  N m  99.0", "..."], ["...", PRINTED[3], "..."]),
                (["a title", "...", "torque  N m  99.0", "force  N  98.0", "..."], [PRINTED[0], "...", *PRINTED[3:6], "..."]),
                (["...", "power  W  2", "written: b.h5"], ["...", *PRINTED[4:]]),
                (["...", "a line that is gone", "...", "force  N  1", "..."], ["...", PRINTED[5], "..."])):
            with self.subTest(expected=expected):
                lines = refreshed_output(expected, PRINTED)
                self.assertEqual(lines, refreshed)
                self.assertTrue(agrees(lines, PRINTED))


class Script(unittest.TestCase):
    def run_script(self, *words):
        return subprocess.run([str(ROOT / "scripts/refresh-docs"), *words], capture_output=True, text=True, check=False, env=dict(os.environ))

    def test_a_page_is_refreshed_once(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            right = "# A page\n\n```yaml\n# name.yaml\na: 1\n```\n\n```console\n$ cat name.yaml | tail -1\na: 1\n```\n\n```\nnot run\n```\n"
            wrong = right.replace("tail -1\na: 1", "tail -1\na: 2")
            page.write_text(wrong, encoding="utf-8")
            self.assertEqual(self.run_script("--check", str(page)).returncode, 1)
            self.assertEqual(page.read_text(encoding="utf-8"), wrong)
            done = self.run_script(str(page))
            self.assertEqual((done.returncode, done.stdout), (0, f"{page}: changed\n1 pages, 0 commands failed\n"))
            self.assertEqual(page.read_text(encoding="utf-8"), right)
            self.assertEqual(self.run_script("--check", str(page)).returncode, 0)

    def test_a_command_that_fails_leaves_its_output(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            text = "```console\n$ false\nsomething\n```\n"
            page.write_text(text, encoding="utf-8")
            done = self.run_script(str(page))
            self.assertEqual(done.returncode, 1)
            self.assertIn("$ false\nexit code 1", done.stderr)
            self.assertEqual(page.read_text(encoding="utf-8"), text)


if __name__ == "__main__":
    unittest.main()
