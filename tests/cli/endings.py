"""A motion into a singularity ends soon, with time and place."""

import os
import re
import unittest

from _program import CONFIGS, Case, config, run

FOLDED = """
space: planar
parameters: {l: 79036.89932195916}
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0], B: [l, 0]}}
  lower: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {B: [0, 0], E: [l, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
actuators: [J1, J2]
tool: lower.E
counterweights: {cw: {body: upper, at: [-0.1, 0], mass: {free: [0, 5]}}}
motion: {duration: 0.5, samples: 41, from: {tool: [0.3, 0.3]}, to: {tool: [0, -0.1]}}
assembly: {J2: -1}
trajectories:
  fast: {law: fastest, drive: tool, limits: {shaking_force: 80, torque: 20, 'torque[J1]': [-10, 15], joint_velocity: 20}}
  arc: {law: 4-5-6-7, drive: tool, path: {arc: {via: [0.4, 0.1]}}}
"""


class Endings(Case):
    def test_a_bicycle_steered_across_its_way_ends_in_a_singularity(self):
        """Steered beyond a right angle, the front wheel lies across the way that the rear wheel's rate prescribes."""
        motion = ("\nmotion:\n  duration: 3\n  samples: 301\n"
                  "  from: {joints: {L.angle: 0, L.lean: lean, S: 0}}\n"
                  "  to: {joints: {L.angle: 3 * v / 0.3, L.lean: lean, S: 3}}\n"
                  "trajectories:\n  ride: {law: uniform, drive: joints}\n")
        text = config("bicycle.yaml")
        text = re.sub(r"^(motion|trajectories|controllers|design):.*?(?=^\w|\Z)", "", text, flags=re.DOTALL | re.MULTILINE)
        done = run("simulate", self.write("bicycle.yaml", text + motion))
        self.assert_failure(done, 4, "drive singularity", "; configuration: L.x ", "S 1.59")
        self.assertTrue(re.search(r"at t = 1\.59\d* s: ", done.stderr), done.stderr)

    def test_steps_beside_a_singularity_are_counted(self):
        """Arms of 79 km and a tool that moves by decimetres: they are folded within 1e-6 rad all the way."""
        done = run("simulate", self.write("folded.yaml", FOLDED), "-t", "fast")
        self.assert_failure(done, 4, "drive singularity", "upper and lower are in line at J2")

    def test_what_rolls_as_far_as_it_should_still_does(self):
        for name in ("rolling-cart.yaml", "sleigh.yaml"):
            self.assertEqual(run("simulate", os.path.join(CONFIGS, name)).returncode, 0, name)


if __name__ == "__main__":
    unittest.main()
