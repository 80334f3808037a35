"""Coefficients of links whose frames are turned against their joints: by name all the same."""

import json
import math
import re
import unittest

from _four_bar import four_bar
from _program import Case, run

# A four-bar whose coupler and rocker have their joints aside of their frames' axes.
TURNED = four_bar(0.5, 0.1, [0.35, 0.21], [0.24, 0.17], coupler_com=[0.2, 0.1], gravity=True)


class TurnedFrames(Case):
    def test_lengths_and_angles_name_every_coefficient(self):
        """(B14) Each formula has the value of its coefficient, and none is a bare number."""
        spec = self.write("turned.yaml", TURNED)
        for goal in ("force", "static"):
            done = run("conditions", spec, "--goal", goal, "--json")
            self.assert_quiet_success(done)
            result = json.loads(done.stdout)
            symbols = {s["name"].replace(".", "_"): s["value"] for s in result["symbols"]}
            waves = 0
            for term in (t for c in result["conditions"] for t in c["terms"]):
                self.assertIn("name", term, f"{goal}: {term}")
                name = re.sub(r"(?<=\w)\.(?=[A-Za-z])", "_", term["name"]).replace("^", "**")
                name = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", name)
                value = eval(name, {"cos": math.cos, "sin": math.sin}, symbols)  # pylint: disable=eval-used
                self.assertAlmostEqual(value, term["coefficient"], delta=1e-6 * max(1, abs(value)))
                waves += "cos(" in name or "sin(" in name
            self.assertGreater(waves, 3, goal)
            self.assertIn("rad", {s["unit"] for s in result["symbols"]})
        text = run("conditions", spec, "--goal", "force").stdout
        self.assertRegex(text, r"(cos|sin)\((coupler|rocker)\.C\.angle( - (coupler|rocker)\.C\.angle)?\)")
        self.assertRegex(run("conditions", spec, "--goal", "force", "--latex").stdout, r"\\(cos|sin)\\(left|bigl)\(")

    def test_the_same_four_bar_in_space_has_the_same_words(self):
        """(B14) Across z, and across the other axes of all bodies: every coefficient is named, lengths and angles among them."""
        lengths = re.compile(r"\[(-?[\d.]+), (-?[\d.]+)\]")
        for order, axis in (("{0}, {1}, 0", "[0, 0, 1]"), ("0, {0}, {1}", "[1, 0, 0]"), ("{1}, 0, {0}", "[0, 1, 0]")):
            spatial = lengths.sub(lambda m: "[" + order.format(m[1], m[2]) + "]", TURNED)  # pylint: disable=cell-var-from-loop
            spatial = spatial.replace("space: planar", "space: spatial").replace("inertia: 0.01", "inertia: [0.01, 0.01, 0.01]")
            spatial = spatial.replace("type: revolute,", f"type: revolute, axis: {axis},")
            done = run("conditions", self.write("space.yaml", spatial), "--goal", "force", "--json")
            self.assert_quiet_success(done)
            result = json.loads(done.stdout)
            self.assertEqual([t for c in result["conditions"] for t in c["terms"] if "name" not in t], [], axis)
            names = " ".join(t["name"] for c in result["conditions"] for t in c["terms"])
            self.assertRegex(names, r"(cos|sin)\((coupler|rocker)\.C\.angle")

    def test_straight_frames_keep_their_words(self):
        """(B14) No angle where lengths explain everything."""
        straight = TURNED.replace("[0.35, 0.21]", "[0.4, 0]").replace("[0.24, 0.17]", "[0.3, 0]")
        text = run("conditions", self.write("straight.yaml", straight), "--goal", "force").stdout
        self.assertNotIn("angle", text)
        self.assertIn("(crank.B.x/coupler.C.x)", text)


if __name__ == "__main__":
    unittest.main()
