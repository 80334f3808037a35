"""`design: front`: no point of a trade-off dominates another, each is what its spec does when it moves, bounds hold for designs drawn at
random, and fronts that a formula knows are found."""

import csv
import json
import math
import os
import random
import re
import unittest

from _program import CONFIGS, Case, run

FOUR_BAR = os.path.join(CONFIGS, "four-bar-front.yaml")

# a link of first moment 0.5 kg m and a counterweight at `at`, turning evenly against gravity: the torque is (0.5 - m a) g cos(angle)
LINK = """
name: link
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0]}}}}
bodies: {{link: {{mass: 1, com: [0.5, 0], inertia: 0.1, points: {{O: [0, 0], E: [1, 0]}}}}}}
counterweights: {{cw: {{body: link, at: [{at}, 0], mass: {mass}}}}}
joints: {{J: {{type: revolute, connects: [ground.O, link.O]}}}}
actuators: [J]
motion: {{duration: 1, samples: 201, from: {{joints: {{J: 0}}}}, to: {{joints: {{J: "2 * pi"}}}}}}
trajectories: {{even: {{law: uniform, drive: joints}}}}
design: {{front: {front}}}
"""


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def dominates(a, b):
    return all(x <= y for x, y in zip(a, b)) and a != b


class Fronts(Case):
    def front(self, text, *options, code=0):
        done = run("design", self.write("spec.yaml", text), "--json", *options)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        found = json.loads(done.stdout)
        values = [point["values"] for point in found["front"]["points"]]
        for a in values:
            self.assertFalse(any(dominates(a, b) for b in values if b is not a), values)
        return found

    def rms(self, path, quantity):
        done = run("simulate", path, "-t", "steady", "--json")
        return next(m["rms"] for m in json.loads(done.stdout)["metrics"] if m["quantity"] == quantity)

    def figures(self, path):
        return [self.rms(path, "shaking_force"), self.rms(path, "shaking_moment")]

    def test_points_are_proved_and_spread_over_the_front(self):
        found = self.front(text_of(FOUR_BAR))
        points = found["front"]["points"]
        self.assertEqual((len(points), found["optimality"]), (9, "proved-best"))
        values = [point["values"] for point in points]
        extent = [max(v[j] for v in values) - min(v[j] for v in values) for j in (0, 1)]
        for point in points:
            self.assertLessEqual(point["gap"], 1e-5 * extent[point["minimized"]])
        steps = [math.hypot(*((b[j] - a[j]) / extent[j] for j in (0, 1))) for a, b in zip(values, values[1:])]
        self.assertLess(max(steps), 2.5 * min(steps))  # halves of halves, on a bent front

    def test_bounds_hold_for_designs_drawn_at_random(self):
        points = self.front(text_of(FOUR_BAR))["front"]["points"]
        dice = random.Random(7)
        checked = 0
        for _ in range(12):
            fixed = re.sub(r"\{free: \[0, 5\], start: 0\}", lambda _: str(dice.uniform(0, 3)), text_of(FOUR_BAR))
            values = self.figures(self.write("fixed.yaml", re.sub(r"design:.*", "", fixed, flags=re.DOTALL)))
            self.assertFalse(any(dominates(values, point["values"]) for point in points))
            for point in points:
                other = 1 - point["minimized"]
                if values[other] <= point["limits"][other]:
                    checked += 1
                    self.assertGreaterEqual(values[point["minimized"]], point["lower_bound"])
        self.assertGreater(checked, 10)

    def test_a_point_is_written_and_moves_as_told(self):
        out, table = self.path("out.yaml"), self.path("front.csv")
        found = self.front(text_of(FOUR_BAR), "--point", "4", "-o", out, "--csv", table)
        point = found["front"]["points"][3]
        for told, moved in zip(point["values"], self.figures(out)):
            self.assertAlmostEqual(told, moved, delta=1e-9 * told)
        self.assertEqual([n["value"] for n in found["design"]["free_numbers"]], [n["value"] for n in point["free_numbers"]])
        with open(table, encoding="utf-8") as file:
            rows = list(csv.reader(file))
        self.assertEqual(rows[0][1], "rms of shaking_force along steady [N]")
        self.assertEqual([[float(x) for x in row[1:3]] for row in rows[1:]], [p["values"] for p in found["front"]["points"]])

    def test_scaling_a_figure_changes_nothing(self):
        # searches stop at parts of 1e-7 of a figure, so that their ends differ by that
        text = text_of(FOUR_BAR)
        plain = self.front(text)["front"]["points"]
        scaled = self.front(text.replace("{rms: shaking_moment, along: steady}", "{rms: shaking_moment, along: steady, weight: 1000}"))
        for a, b in zip(plain, scaled["front"]["points"]):
            self.assertAlmostEqual(a["values"][0], b["values"][0], delta=1e-3)
            self.assertAlmostEqual(1000 * a["values"][1], b["values"][1], delta=1)

    def test_torque_against_mass_is_a_straight_line(self):
        front = "[{rms: torque, along: even}, added-mass]"
        found = self.front(LINK.format(at=-0.25, mass="{free: [0, 5], start: 1}", front=front))
        self.assertEqual(found["optimality"], "proved-best")
        points = found["front"]["points"]
        self.assertEqual(len(points), 9)
        for torque, mass in (point["values"] for point in points):
            self.assertAlmostEqual(torque, (0.5 - 0.25 * mass) * 9.81 / math.sqrt(2), delta=1e-6)

    def test_torque_against_inertia_is_the_known_curve(self):
        # J = 1.5 a², so the torque is 0.5 - sqrt(1.5 J) times g / sqrt 2: bent, and not affine in the free number
        front = "[{rms: torque, along: even}, added-inertia]"
        found = self.front(LINK.format(at="{free: [-0.5, -0.01], start: -0.1}", mass=1.5, front=front))
        self.assertGreater(len(found["front"]["points"]), 6)
        for torque, inertia in (point["values"] for point in found["front"]["points"]):
            self.assertAlmostEqual(torque, (0.5 - math.sqrt(1.5 * inertia)) * 9.81 / math.sqrt(2), delta=1e-5)

    def test_figures_that_agree_have_one_best_design(self):
        found = self.front(LINK.format(at=-0.25, mass="{free: [0, 5], start: 1}", front="[added-mass, total-mass]"))
        self.assertEqual(len(found["front"]["points"]), 1)
        self.assertIn("no trade-off", found["notes"][0])

    def test_three_figures_have_a_front_too(self):
        text = text_of(FOUR_BAR).replace("of: [", "of: [added-mass, ")
        found = self.front(text)
        self.assertGreaterEqual(len(found["front"]["points"]), 6)

    def test_known_designs_of_the_starter_are_not_below_its_front(self):
        starter = run("new", "four-bar").stdout
        text = re.sub(r"design:.*", "design: {front: [{rms: shaking_force, along: steady}, {rms: shaking_moment, along: steady}]}", starter)
        points = [p["values"] for p in self.front(text)["front"]["points"]]
        for known in ((22.84, 0.97611), (9.717, 1.0028), (0, 5.1147)):
            self.assertFalse(any(dominates(known, point) for point in points if point[0] > 0.01))

    def test_time_is_for_all_points_together(self):
        found = self.front(text_of(FOUR_BAR), "--seconds", "0.02")
        self.assertTrue(found["front"]["stopped"])
        self.assertEqual(found["optimality"], "stopped")
        done = run("design", FOUR_BAR, "--seconds", "0.001")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertIn("front", done.stdout)

    def test_what_makes_no_sense_is_refused_at_once(self):
        for options, message in ((["-o", "x.yaml"], "--output writes one design"), (["--point", "0"], "expected the number"),
                                 (["--point", "nine"], "expected the number"),
                                 (["--minimize", "added-mass", "--point", "1"], "--point needs a spec with a front")):
            done = run("design", FOUR_BAR, *options)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(message, done.stderr)
        done = run("design", FOUR_BAR, "--point", "10")
        self.assertEqual(done.returncode, 2)
        self.assertIn("the front has 9 points", done.stderr)

    def test_a_suite_runs_one_design_and_says_so(self):
        spec = self.write("spec.yaml", text_of(FOUR_BAR))
        suite = self.write("suite.yaml", "name: s\ncases:\n  one: {spec: %s, design: true, trajectory: steady}\n" % os.path.basename(spec))
        done = run("batch", suite, "-o", self.path("out"))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("'minimize' is needed here", done.stdout + done.stderr)

    def test_a_goal_that_cannot_be_met_has_no_front(self):
        text = LINK.format(at=-0.25, mass="{free: [0, 1], start: 1}", front="[added-mass, {rms: torque, along: even}]")
        found = self.front(text.replace("front:", "goal: static, front:"), code=1)
        self.assertEqual((found["status"], found["front"]["points"]), ("impossible", []))
        self.assertTrue(found["reason"])


if __name__ == "__main__":
    unittest.main()
