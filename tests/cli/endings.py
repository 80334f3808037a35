"""A motion into a singularity ends soon, with time and place."""

import os
import re
import unittest

from _program import CONFIGS, Case, config, run


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

    def test_what_rolls_as_far_as_it_should_still_does(self):
        for name in ("rolling-cart.yaml", "sleigh.yaml"):
            self.assertEqual(run("simulate", os.path.join(CONFIGS, name)).returncode, 0, name)


if __name__ == "__main__":
    unittest.main()
