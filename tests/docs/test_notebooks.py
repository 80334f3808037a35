#!/usr/bin/env python3
"""The notebooks run from beginning to end, what they assert included, and are kept without outputs."""

import os
import sys
import unittest

from _console import ROOT

sys.path.insert(0, str(ROOT / "docs/site"))

import nbformat  # noqa: E402
import notebooks  # noqa: E402  (found by the line above)

PAGES = sorted((ROOT / "docs/notebooks").glob("*.ipynb"))


class Notebooks(unittest.TestCase):
    def test_they_are_kept_without_outputs(self):
        self.assertGreaterEqual(len(PAGES), 3)
        for page in PAGES:
            for cell in nbformat.read(page, as_version=4).cells:
                self.assertFalse(cell.get("outputs"), page.name)
                self.assertIsNone(cell.get("execution_count"), page.name)

    def test_they_run(self):
        for page in PAGES:
            with self.subTest(notebook=page.name):
                if not notebooks.can_run(page, os.environ["BALANCE"]):
                    self.skipTest(f"{page.name} needs the module balance_mechanisms, which this build has not")
                executed = notebooks.execute(page, page.parent, notebooks.surroundings(os.environ["BALANCE"]))
                self.assertTrue(any(cell.get("outputs") for cell in executed.cells))


if __name__ == "__main__":
    unittest.main()
