"""Dry friction that differs between directions: each one resists with its own, in every command that knows friction."""

import json
import math
import unittest

from _program import Case, run

FORTH, BACK, INERTIA = 0.7, 0.3, 0.5

SPEC = """\
space: planar
ground: {points: {O: [0, 0]}}
bodies: {wheel: {mass: 2, com: [0, 0], inertia: 0.5, points: {H: [0, 0]}}}
joints: {A: {type: revolute, connects: [ground.O, wheel.H]}}
friction: {A: {coulomb: {forward: 0.7, backward: 0.3}}}
actuators: [A]
motion: {duration: 1, samples: 101, from: {joints: {A: 0}}, to: {joints: {A: 1}}}
trajectories:
  forth: {law: cycloidal, drive: joints}
  back: {law: cycloidal, drive: joints, from: {joints: {A: 1}}, to: {joints: {A: 0}}}
  fast-forth: {law: fastest, drive: joints, limits: {torque: 2}}
  fast-back: {law: fastest, drive: joints, limits: {torque: 2}, from: {joints: {A: 1}}, to: {joints: {A: 0}}}
tolerances: {friction.A.coulomb.forward: 0.01, friction.A.coulomb.backward: 0.02}
"""


class DirectionalFriction(Case):
    def answer(self, *call):
        done = run(*call, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_each_direction_resists_with_its_own(self):
        spec = self.write("spec.yaml", SPEC)
        for rate, torque in ((1, FORTH), (-2, -BACK), (0, 0)):
            found = self.answer("simulate", spec, "--at", "A=0.2", "--rates", f"A={rate}", "-q")
            values = {one["quantity"]: one["value"] for one in found["values"]}
            self.assertEqual(values["torque[A]"], torque)

    def test_both_formulations_agree(self):
        done = run("check", "--verify", self.write("spec.yaml", SPEC))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_fastest_law_pays_for_its_direction(self):
        spec = self.write("spec.yaml", SPEC)
        for trajectory, resists in (("fast-forth", FORTH), ("fast-back", BACK)):
            up, down = (2 - resists) / INERTIA, (2 + resists) / INERTIA
            found = self.answer("simulate", spec, "-t", trajectory, "-q")
            # a way of 1 rad by constant accelerations; laws are found to 1e-6 of their time
            self.assertAlmostEqual(found["duration"], math.sqrt(2 * (1 / up + 1 / down)), delta=1e-5)

    def test_each_number_is_toleranced_by_name(self):
        spec = self.write("spec.yaml", SPEC)
        for trajectory, deviation in (("forth", 0.01), ("back", 0.02)):
            found = self.answer("tolerance", spec, "-t", trajectory, "--of", "torque[A]")
            self.assertAlmostEqual(found["first_order"]["quantities"][0]["peak"]["deviation"], deviation, places=9)

    def test_conditions_name_both(self):
        done = run("conditions", self.write("spec.yaml", SPEC), "--goal", "gyroscopic")
        self.assertIn("friction in A (0.7 N m dry forwards, 0.3 N m dry backwards)", done.stdout)
        self.assertIn("up to 0.7 N m at A along forth\n", done.stdout)
        self.assertIn("up to 0.3 N m at A along back\n", done.stdout)

    def test_wrong_numbers_are_told(self):
        for text, words in (("{forward: 0.7}", "'backward'"), ("{forward: -1, backward: 1}", "must not be negative"),
                            ("{forward: 1, backward: 1, sideways: 2}", "sideways")):
            done = run("check", self.write("bad.yaml", SPEC.replace("{forward: 0.7, backward: 0.3}", text)))
            self.assert_failure(done, 3, words)
        done = run("check", self.write("bad.yaml", SPEC.replace("backward: 0.3}}}", "backward: 0.3}, static: 0.5}}")))
        self.assert_failure(done, 3, "at least as much as 'coulomb'")


if __name__ == "__main__":
    unittest.main()
