"""A planar linkage has the same verdict in the plane and, with the same numbers and z = 0, in space, where its loops are over-constrained."""

import unittest

from _program import Case, run

# A linkage that is nearly a parallelogram and comes near its change point at A = 0: how near, `off` says.
SPEC = """\
name: nearly a parallelogram
space: {space}
gravity: [{zero}]
ground: {{points: {{P: [0, 0{z}], Q: [1, 0{z}]}}}}
bodies:
  a: {{mass: 1, com: [0.15, 0{z}], inertia: {inertia}, points: {{O: [0, 0{z}], E: [0.3, 0{z}]}}}}
  b: {{mass: 1, com: [0.5, 0.1{z}], inertia: {inertia}, points: {{O: [0, 0{z}], E: [{coupler}, 0{z}]}}}}
  c: {{mass: 1, com: [0.15, 0{z}], inertia: {inertia}, points: {{O: [0, 0{z}], E: [0.3, 0{z}]}}}}
joints:
  A: {{type: revolute, connects: [ground.P, a.O]{axis}}}
  B: {{type: revolute, connects: [a.E, b.O]{axis}}}
  C: {{type: revolute, connects: [ground.Q, c.O]{axis}}}
  D: {{type: revolute, connects: [b.E, c.E]{axis}}}
actuators: [A]
assembly: {{A: 1, B: -1, C: 1}}
motion: {{duration: 1, samples: 21, from: {{joints: {{A: 1}}}}, to: {{joints: {{A: -1}}}}}}
trajectories: {{go: {{law: cycloidal, drive: joints}}}}
"""


class Lifted(Case):
    def verdict(self, spatial, off):
        text = SPEC.format(space="spatial" if spatial else "planar", zero="0, 0, 0" if spatial else "0, 0", z=", 0" if spatial else "",
                           inertia="[0.02, 0.02, 0.02]" if spatial else "0.02", coupler=1 + off, axis=", axis: [0, 0, 1]" if spatial else "")
        done = run("simulate", self.write("lifted.yaml", text), "-q")
        return done.returncode

    def test_how_near_a_change_point_a_way_may_come_is_the_same_in_both_spaces(self):
        verdicts = set()
        for k in range(2, 13):
            for sign in (1, -1):
                off = sign * 10.0 ** -k
                with self.subTest(off=off):
                    plane, space = self.verdict(False, off), self.verdict(True, off)
                    self.assertEqual(plane, space)
                    verdicts.add(plane)
        self.assertEqual(verdicts, {0, 4})  # far enough, and too near


if __name__ == "__main__":
    unittest.main()
