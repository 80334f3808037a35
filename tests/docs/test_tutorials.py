#!/usr/bin/env python3
"""Every command of the tutorials and the how-tos prints what the page says, and the number that a tutorial ends in is one that was printed."""

import re
import tempfile
import unittest

from _console import ROOT, blocks, run_page, workplace

PAGES = sorted((ROOT / "docs/tutorials").glob("[0-9]*.md"))


class Tutorials(unittest.TestCase):
    def test_there_are_six_and_the_list_names_them(self):
        listed = re.findall(r"\]\((\d[^)]*\.md)\)", (ROOT / "docs/tutorials/README.md").read_text(encoding="utf-8"))
        self.assertEqual([page.name for page in PAGES], listed)
        self.assertEqual(len(PAGES), 6)

    def test_every_command_prints_what_the_page_says(self):
        for page in [*PAGES, ROOT / "docs/how-to.md"]:
            with self.subTest(page=page.name), tempfile.TemporaryDirectory() as temporary:
                text = page.read_text(encoding="utf-8")
                differing, count, _ = run_page(text, *workplace(temporary))
                self.assertFalse(differing, "\n".join(differing))
                self.assertGreaterEqual(count, 4)

    def test_the_number_at_the_end_was_printed(self):
        for page in PAGES:
            with self.subTest(page=page.name):
                text = page.read_text(encoding="utf-8")
                numbers = re.findall(r"\*\*([\d.]+) [^*]+\*\*", text[text.index("\n## The number\n"):])
                self.assertEqual(len(numbers), 1)
                shown = "".join(block for language, block in blocks(text) if language == "console")
                self.assertRegex(shown, rf"(?<![\d.]){re.escape(numbers[0])}(?![\d.])")


if __name__ == "__main__":
    unittest.main()
