#!/usr/bin/env python3
"""Every command of the tutorials and the how-tos prints what the page says, and the number that a tutorial ends in is one that was printed."""

import json
import re
import subprocess
import tempfile
import unittest

from _console import ROOT, blocks, prose, run_page, workplace

PAGES = sorted((ROOT / "docs/tutorials").glob("[0-9]*.md"), key=lambda page: int(page.name.split("-")[0]))
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.])")
# Numbers that the second formulation gives, too: page, quantity, command.
PLANAR = [(0, "shaking_moment", "shaking.yaml -t steady --set behind_crank=0.9 --set behind_rocker=3"), (4, "shaking_force", "laws.yaml -t gentle")]


def number_of(text):
    """What the page ends in."""
    (number,) = re.findall(r"\*\*([\d.]+) [^*]+\*\*", text[text.index("\n## The number\n"):])
    return float(number)


class Tutorials(unittest.TestCase):
    def test_there_are_eleven_and_the_list_names_them(self):
        listed = re.findall(r"\]\((\d[^)]*\.md)\)", (ROOT / "docs/tutorials/README.md").read_text(encoding="utf-8"))
        self.assertEqual([page.name for page in PAGES], listed)
        self.assertEqual(len(PAGES), 11)

    def test_every_command_prints_what_the_page_says(self):
        for page in [*PAGES, ROOT / "docs/how-to.md"]:
            with self.subTest(page=page.name), tempfile.TemporaryDirectory() as temporary:
                text = page.read_text(encoding="utf-8")
                differing, count, _ = run_page(text, *workplace(temporary))
                self.assertFalse(differing, "\n".join(differing))
                self.assertGreaterEqual(count, 4)

    def test_numbers_of_planar_motions_are_those_of_the_second_formulation(self):
        for number, quantity, words in PLANAR:
            with self.subTest(page=PAGES[number].name), tempfile.TemporaryDirectory() as temporary:
                folder, environment = workplace(temporary)
                text = PAGES[number].read_text(encoding="utf-8")
                run_page(text, folder, environment)
                done = subprocess.run([environment["BALANCE"], "simulate", *words.split(), "--formulation", "natural", "--json"], cwd=folder,
                                      capture_output=True, check=True)
                peak = next(m["peak"] for m in json.loads(done.stdout)["metrics"] if m["quantity"] == quantity)
                self.assertAlmostEqual(peak, number_of(text), delta=1e-6 * peak)  # seven digits are shown

    def test_the_number_at_the_end_was_printed(self):
        for page in PAGES:
            with self.subTest(page=page.name):
                text = page.read_text(encoding="utf-8")
                shown = "".join(block for language, block in blocks(text) if language == "console")
                self.assertIn(number_of(text), [float(x) for x in NUMBER.findall(shown)])

    def test_numbers_of_tables_are_roundings_of_printed_ones(self):
        count = 0
        for page in PAGES:
            text = page.read_text(encoding="utf-8")
            printed = [float(x) for block in (b for language, b in blocks(text) if language == "console") for x in NUMBER.findall(block)]
            for row in re.findall(r"^\| (?!---)(.*) \|$", prose(text), re.MULTILINE):
                for number in (x for cell in row.split(" | ")[1:] for x in NUMBER.findall(cell) if len(x.replace(".", "")) >= 3):
                    count += 1
                    with self.subTest(page=page.name, row=row, number=number):
                        digits = len(number.partition(".")[2])
                        self.assertIn(float(number), [round(x, digits) for x in printed])
        self.assertGreater(count, 8)


if __name__ == "__main__":
    unittest.main()
