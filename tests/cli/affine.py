"""The goal of P3 (eq. 53-61), `affine`, beside the stricter `proportional`."""

import json
import math
import os
import unittest

from _program import CONFIGS, Case, run

DESIGN = os.path.join(CONFIGS, "3rrr-proportional.yaml")
# The platform's CoM off the tool, as a tool mounted aside would have it.
CENTRED, OFF = 'com: ["side / 2", yg], inertia: 0.0056', "com: [0.09, 0.02], inertia: 0.0056"
BARE = """\
space: planar
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 1, com: [0.1, 0.05], inertia: 0.01, points: {A: [0, 0], T: [0.3, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
"""


class Affine(Case):
    def off_centre(self, **changes):
        with open(DESIGN, encoding="utf-8") as file:
            text = file.read()
        self.assertIn(CENTRED, text)
        text = text.replace(CENTRED, OFF)
        for old, new in changes.items():
            text = text.replace(old, new)
        return self.write("off.yaml", text)

    def conditions(self, spec, goal):
        done = run("conditions", spec, "--goal", goal, "--json")
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def test_what_both_goals_ask_of_the_3rrr(self):
        """(B3) Limb by limb (P3 eq. 54-59): six; that the platform's rotation does not matter: two more."""
        affine, strict = self.conditions(DESIGN, "affine"), self.conditions(DESIGN, "proportional")
        self.assertEqual((affine["rank"], strict["rank"]), (6, 8))
        # (1 - x2/l) m2 + x1/l m1 = 0, with first moments: crank.mx + l coupler.m - coupler.mx = 0; eq. 55 the same with y
        for leg in "123":
            terms = {t["parameter"]: t["coefficient"] for c in affine["conditions"] for t in c["terms"]
                     if c["terms"][0]["parameter"] == f"crank{leg}.mx"}
            self.assertEqual(set(terms), {f"crank{leg}.mx", f"coupler{leg}.m", f"coupler{leg}.mx"})
            self.assertAlmostEqual(terms[f"coupler{leg}.m"], 0.18, places=9)
            self.assertAlmostEqual(terms[f"coupler{leg}.mx"], -1, places=9)
            terms = {t["parameter"]: t["coefficient"] for c in affine["conditions"] for t in c["terms"]
                     if c["terms"][0]["parameter"] == f"crank{leg}.my"}
            self.assertEqual(set(terms), {f"crank{leg}.my", f"coupler{leg}.my"})

    def test_the_cranks_of_eq_61_balance_a_platform_that_is_heavy_aside(self):
        """(B3) x = -0.09 m; the tool's bang-bang then gives a constant force of 180 sqrt(5) N."""
        spec = self.off_centre()
        done = run("design", spec, "--goal", "proportional", "--json")
        self.assertEqual(json.loads(done.stdout)["status"], "impossible")
        out = self.path("balanced.yaml")
        done = run("design", spec, "--goal", "affine", "--json", "-o", out)
        self.assert_quiet_success(done)
        result = json.loads(done.stdout)
        self.assertAlmostEqual(result["free_numbers"][0]["value"], -0.09, places=9)
        self.assertTrue(any("0.5 times the tool's displacement, and by" in note for note in result["notes"]))
        for trajectory in ("bang-bang", "tool-bang"):
            metrics = json.loads(run("simulate", out, "-t", trajectory, "--json").stdout)["metrics"]
            force = next(m for m in metrics if m["quantity"] == "shaking_force")
            self.assertAlmostEqual(force["peak"], 180 * math.sqrt(5), places=6)
            self.assertLess(force["range"], 1e-6)

    def test_a_tool_on_a_body_that_does_not_turn_or_turns_alone(self):
        """(B3) One link: its CoM is always an affine function of its rotation. Without a tool there is nothing to follow."""
        with_tool = self.write("link.yaml", BARE + "tool: link.T\n")
        self.assertEqual(self.conditions(with_tool, "affine")["rank"], 0)
        done = run("conditions", self.write("bare.yaml", BARE), "--goal", "affine", "--json")
        self.assert_failure(done, 4, "the goal affine compares the centre of mass with the tool")

    def test_affine_asks_no_more_than_proportional(self):
        """(B3) Whatever is proportional is affine: the rows lie in the other goal's row space."""
        for name in ("planar-rrr", "spatial-rrr", "scara", "delta"):
            spec = os.path.join(CONFIGS, name + ".yaml")
            both = self.conditions(spec, "proportional")["rank"]
            done = run("conditions", spec, "--goal", "proportional", "--goal", "affine", "--json")
            self.assertEqual(json.loads(done.stdout)["rank"], both, name)
            self.assertLessEqual(self.conditions(spec, "affine")["rank"], both, name)


if __name__ == "__main__":
    unittest.main()
