#!/usr/bin/env python3
"""README.md is a page of at most 120 lines; the commands that it shows print what it says, and its table of published cases is that of the suite
that recomputes them (configs/suites/published.yaml)."""

import decimal
import os
import pathlib
import re
import tempfile
import unittest

import yaml

from docs._console import ROOT, run_page, workplace

README = (ROOT / "README.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| \[[^\]]*\]\(configs/published/([\w.-]+)\)[^|]* \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def is_rounding_of(shown, number):
    """Whether a cell's number is the other one, to half a unit of its last digit."""
    text = NUMBER.search(shown).group()
    return abs(float(text) - float(number)) <= float(decimal.Decimal(1).scaleb(decimal.Decimal(text).as_tuple().exponent)) / 2


class Readme(unittest.TestCase):
    def test_commands_print_what_it_says(self):
        with tempfile.TemporaryDirectory() as temporary:
            differing, count, _ = run_page(README, *workplace(temporary))
        self.assertFalse(differing, "\n".join(differing))
        self.assertGreaterEqual(count, 4)

    def test_it_fits_on_a_page(self):
        self.assertLessEqual(len(README.splitlines()), 120)

    def test_its_published_cases_are_those_of_the_suite(self):
        suite = pathlib.Path(os.environ["CONFIGS"]) / "suites/published.yaml"
        cases = yaml.load(suite.read_text(encoding="utf-8"), yaml.BaseLoader)["cases"].values()
        rows = ROW.findall(README)
        self.assertEqual(len(rows), 5)
        for spec, printed, ours, verdict in rows:
            with self.subTest(spec=spec):
                recomputed = [row for case in cases if pathlib.PurePath(case.get("spec", "")).name == spec for row in case.get("published", [])]
                self.assertTrue(recomputed, "the suite has no such case")
                named = verdict.partition(",")[0].strip().replace(" ", "-")
                self.assertTrue(any(row["verdict"] == named and is_rounding_of(printed, row["printed"])
                                    and is_rounding_of(ours, row.get("exact", row["printed"])) for row in recomputed if "printed" in row),
                                f"no row says {printed}, {ours}, {verdict}: {recomputed}")


if __name__ == "__main__":
    unittest.main()
