#!/usr/bin/env python3
"""The page "Validation" says of every row what the summary says, and of a row that does not hold that it does not."""

import json
import pathlib
import re
import sys
import tempfile
import unittest

from _console import ROOT

sys.path.insert(0, str(ROOT / "docs/site"))

import validation  # noqa: E402  (found by the line above)


def row(**changes):
    return {"what": "piston speed", "unit": "m/s^2", "printed": 6.833, "exact": 6.90536, "tolerance": 5e-6, "ours": 6.905361, "deviation": 0.01059,
            "verdict": "drawn", "note": None, "holds": True, **changes}


def case(name, *rows, waits=(), **changes):
    return {"name": name, "spec": f"../published/{name}.yaml", "source": "A book, ch. 1", "page": "12", "published": list(rows), "waits": list(waits), **changes}


def page(*cases):
    return validation.page({"cases": list(cases)}, {}, "balance 1")


class Validation(unittest.TestCase):
    def test_a_row_has_the_printed_number_ours_the_deviation_and_the_verdict(self):
        text = page(case("K15-2", row(note="a < b")))
        cells = re.findall(r'<td data-label="(\w+)">(.*?)</td>', text)
        self.assertEqual([label for label, _ in cells], ["what", "printed", "ours", "deviation", "verdict"])
        self.assertEqual([content for _, content in cells[:4]], ["piston speed<br><small>a &lt; b</small>", "6.833 m/s<sup>2</sup>",
                                                                 "6.90536 m/s<sup>2</sup>", "+1.06\N{NO-BREAK SPACE}%"])
        self.assertIn(">drawn<", cells[4][1])
        self.assertIn('<h3 id="K15-2"><a href="specs/K15-2.yaml">K15-2</a> <small>A book, ch. 1, p. 12</small></h3>', text)

    def test_the_header_counts_every_verdict_and_what_waits(self):
        waiting = {"what": "flywheel speed", "unit": None, "printed": "121", "reason": "needs flywheels"}
        text = page(case("a", row(), row(), row(verdict="misprint"), waits=[waiting]), case("b", row(verdict="improved")), case("c", source=None, published=[], waits=[]))
        self.assertIn("balance 1 has computed 4 printed numbers of 2 cases", text)
        for line in ("| 2 | were drawn", "| 1 | are misprints", "| 1 | belong to a design that is improved here, with proof", "| 1 more | wait"):
            self.assertIn(line, text)
        self.assertIn("flywheel speed (printed 121): needs flywheels", text)
        self.assertIn("## Published designs, improved", text)

    def test_a_row_that_does_not_hold_is_no_success(self):
        text = page(case("a", row(holds=False, verdict="improved"), row()))
        self.assertIn("does not hold (improved, with proof)", text)
        self.assertIn("| 1 | **do not hold** |", text)
        self.assertNotIn("| belong to a design", text)
        self.assertNotIn("## Published designs", text)

    def test_many_rows_and_the_states_of_one_mechanism_are_folded(self):
        text = page(*(case(f"arm-{i:03}", *[row(unit=None, printed=0, exact=0, deviation=None, ours=1e-12, verdict="reproduced")] * 5) for i in range(1, 4)))
        self.assertEqual(text.count("<h3"), 1)
        self.assertIn("<summary>3 states: 15 numbers, all hold", text)
        self.assertIn("1 · 10<sup>−12</sup>", text)

    def test_numbers_keep_their_printed_digits(self):
        self.assertEqual(validation.as_printed(-1.5e-7), "−1.5 · 10<sup>−7</sup>")
        self.assertEqual(validation.as_printed(2880.0), "2880")
        self.assertEqual(validation.as_printed(63.28895136818723), "63.28895136818723")

    def test_the_specs_lie_where_the_page_looks_for_them(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "gallery").mkdir()
            (folder / "gallery/K15-1.md").write_text("# K15-1", encoding="utf-8")
            (folder / "summary.json").write_text(json.dumps({"cases": [case("K15-1", row()), case("K15-2", row())]}), encoding="utf-8")
            validation.write(folder / "summary.json", folder, folder / "html", "balance 1")
            text = (folder / "validation.md").read_text(encoding="utf-8")
            self.assertIn('<a href="gallery/K15-1.html">K15-1</a>', text)
            self.assertIn('<a href="specs/K15-2.yaml">K15-2</a>', text)
            self.assertTrue((folder / "html/specs/K15-2.yaml").is_file())


if __name__ == "__main__":
    unittest.main()
