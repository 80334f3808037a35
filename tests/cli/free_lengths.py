"""`balance design` with free lengths: special lengths are found from anywhere, and no lengths next to the best are better."""

import json
import math
import random
import unittest

from _program import Case, run
from design_claims import COM, FOUR_BAR, FREE_LENGTHS, INERTIA, links

LENGTHS = (0.1, 0.6)


def pose(crank, coupler, rocker, base, side, angle):
    """Joint angles B and D of the four-bar, or nothing if it cannot be assembled with a margin."""
    x, y = crank * math.cos(angle), crank * math.sin(angle)
    far = math.hypot(base - x, y)
    if not abs(coupler - rocker) + 0.01 < far < coupler + rocker - 0.01:
        return None
    along = (far**2 + coupler**2 - rocker**2) / (2 * far)
    beside = side * math.sqrt(coupler**2 - along**2)
    ux, uy = (base - x) / far, -y / far
    cx, cy = x + along * ux - beside * uy, y + along * uy + beside * ux
    return math.atan2(cy - y, cx - x) - angle, math.atan2(cy, cx - base)


def four_bar(seed):
    """All three moving lengths free, from a random start that makes its motion."""
    dice, side = random.Random(seed), 1 if seed % 2 else -1
    while True:
        values = [dice.uniform(*LENGTHS) for _ in range(3)]
        poses = [pose(*values, 0.5, side, 1 + k / 20) for k in range(11)]
        if all(poses):
            break
    free = [f"{{free: {list(LENGTHS)}, start: {value!r}}}" for value in values]
    assembly = f"A: 1.0, B: {poses[0][0]!r}, D: {poses[0][1]!r}"
    return FOUR_BAR.format(l1=free[0], l2=free[1], l3=free[2], mass="{free: [0.2, 5], start: 1}", com=COM,
                           inertia=INERTIA, assembly=assembly)


class FreeLengths(Case):
    def design(self, spec, *options):
        done = run("design", spec, "--json", *options)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return json.loads(done.stdout)

    def peaks(self, spec):
        done = run("simulate", spec, "--json", "-t", "swing")
        self.assert_quiet_success(done)
        return {metric["quantity"]: metric["peak"] for metric in json.loads(done.stdout)["metrics"]}

    def test_reactionless_four_bars_are_found_from_anywhere(self):
        for seed in (3, 8):
            with self.subTest(seed=seed):
                before, after = self.write(f"{seed}.yaml", four_bar(seed)), self.path(f"{seed}-balanced.yaml")
                self.assertEqual(self.design(before, "-o", after)["status"], "balanced")
                # the judge is a run; conditions count as met at 1e-10 of their terms
                was, left = self.peaks(before), self.peaks(after)
                for quantity in ("shaking_force", "shaking_moment"):
                    self.assertLess(left[quantity], 1e-8 * was[quantity])

    def test_no_lengths_next_to_the_lightest_are_lighter(self):
        answer = self.design(self.write("free.yaml", links(FREE_LENGTHS)))
        self.assertEqual((answer["status"], answer["optimality"]), ("balanced", "proved-best"))
        numbers = [n for n in answer["free_numbers"] if n["path"].startswith("parameters.")]
        names = [n["path"].split(".")[1] for n in numbers]
        fixed = lambda values: ", ".join(f"{name}: {value!r}" for name, value in zip(names, values))
        best = [n["value"] for n in numbers]
        for k in range(len(best)):
            for step in (-1e-3, 1e-3):
                values = list(best)
                values[k] = min(max(values[k] + step, numbers[k]["lower"]), numbers[k]["upper"])
                other = self.design(self.write("fixed.yaml", links(fixed(values))))
                self.assertEqual(other["optimality"], "proved-best")
                self.assertLess(answer["objective"]["value"], other["objective"]["value"] * (1 + 1e-9))


if __name__ == "__main__":
    unittest.main()
