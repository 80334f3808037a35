#!/usr/bin/env python3
"""The gallery of published cases: each has its page, its spec and its picture, and a design its figures before and after."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from _console import ROOT

sys.path.insert(0, str(ROOT / "docs/site"))

import program_answers  # noqa: E402  (found by the line above)
import published_cases  # noqa: E402

PROGRAM = os.environ["BALANCE"]
CONFIGS = ROOT / "configs"


class PublishedCases(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name) / "published"
        cls.specs = [CONFIGS / "spatial-rrr.yaml", CONFIGS / "5r-design.yaml", CONFIGS / "four-bar-front.yaml", cls.without_a_motion()]
        published_cases.write(PROGRAM, cls.specs, cls.folder, True)

    @classmethod
    def without_a_motion(cls):
        text = (CONFIGS / "four-bar.yaml").read_text(encoding="utf-8")
        spec = pathlib.Path(cls.temporary.name) / "still.yaml"
        spec.write_text(re.sub(r"^(motion|trajectories|design):.*?(?=^\w|\Z)", "", text, flags=re.MULTILINE | re.DOTALL), encoding="utf-8")
        return spec

    def page(self, name):
        return (self.folder / f"{name}.md").read_text(encoding="utf-8")

    def test_every_case_has_a_page_with_its_spec(self):
        index = (self.folder / "index.md").read_text(encoding="utf-8")
        for spec in self.specs:
            self.assertIn(f'href="{spec.stem}.html"', index)
            self.assertIn(f"]({spec.name})", self.page(spec.stem))
            self.assertEqual((self.folder / spec.name).read_bytes(), spec.read_bytes())

    @unittest.skipUnless(shutil.which("gnuplot"), "no gnuplot here")
    def test_every_case_has_a_picture(self):
        for spec in self.specs:
            picture = self.folder / f"published-{spec.stem}.svg"
            self.assertIn(f"]({picture.name})", self.page(spec.stem))
            self.assertIn("</svg>", picture.read_text(encoding="utf-8"))
        self.assertIn("isometric view", (self.folder / "published-spatial-rrr.svg").read_text(encoding="utf-8"))

    def test_a_design_has_its_figures_before_and_after(self):
        self.assertNotIn("Before and after", self.page("spatial-rrr"))
        page = self.page("5r-design")
        rows = {cells[0].strip(): cells[1:3] for cells in re.findall(r"^\| ([^|]+)\| ([^|]+)\| ([^|]+)\|", page, re.MULTILINE)}
        design = json.loads(subprocess.run([PROGRAM, "design", str(CONFIGS / "5r-design.yaml"), "--json"], capture_output=True, check=True).stdout)
        self.assertAlmostEqual(float(rows["added mass"][1]), design["objective"]["value"], delta=1e-5 * design["objective"]["value"])
        before, after = map(float, rows["peak shaking force, `cycloid`"])
        self.assertGreater(before, 1)
        self.assertEqual(after, 0)
        if shutil.which("gnuplot"):
            for picture in ("design", "figure"):
                self.assertTrue((self.folder / f"published-5r-design-{picture}.svg").is_file())

    def test_the_middle_of_a_trade_off_is_its_design(self):
        page = self.page("four-bar-front")
        self.assertRegex(page, r"point \d+ of its trade-off")
        before, after = map(float, re.search(r"peak shaking force, `steady` \| (\S+) \| (\S+) \|", page).groups())
        self.assertLess(after, before)

    def test_names_and_comments_become_plain_text(self):
        name, comment = program_answers.story("# a_b *c*\n#     x < y\nname: \"odd: [name]\"   # why\n")
        self.assertEqual((name, comment), ("odd: [name]", "a\\_b \\*c\\*\nx \\< y  "))
        self.assertEqual(program_answers.escape_cell("a|b_c `d_e`"), "a\\|b\\_c `d_e`")


if __name__ == "__main__":
    unittest.main()
