"""Coefficients of links whose frames are turned against their joints: by name all the same."""

import json
import math
import re
import unittest

from _program import Case, run

# A four-bar whose coupler and rocker have their joints aside of their frames' axes.
TURNED = """\
space: planar
gravity: [0, -9.81]
ground: {points: {A: [0, 0], D: [0.5, 0]}}
bodies:
  crank: {mass: 1, com: [0.05, 0], inertia: 0.01, points: {A: [0, 0], B: [0.1, 0]}}
  coupler: {mass: 1, com: [0.2, 0.1], inertia: 0.01, points: {B: [0, 0], C: [0.35, 0.21]}}
  rocker: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {D: [0, 0], C: [0.24, 0.17]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
  B: {type: revolute, connects: [crank.B, coupler.B]}
  C: {type: revolute, connects: [coupler.C, rocker.C]}
  D: {type: revolute, connects: [ground.D, rocker.D]}
actuators: [A]
"""


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
        self.assertRegex(run("conditions", spec, "--goal", "force", "--latex").stdout, r"\\(cos|sin)\\left\(")

    def test_straight_frames_keep_their_words(self):
        """(B14) No angle where lengths explain everything."""
        straight = TURNED.replace("[0.35, 0.21]", "[0.4, 0]").replace("[0.24, 0.17]", "[0.3, 0]")
        text = run("conditions", self.write("straight.yaml", straight), "--goal", "force").stdout
        self.assertNotIn("angle", text)
        self.assertIn("(crank.B.x/coupler.C.x)", text)


if __name__ == "__main__":
    unittest.main()
