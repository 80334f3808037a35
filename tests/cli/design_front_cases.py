"""`design: front` beside `design: for`: fronts over load cases that a formula knows."""

import csv
import json
import math
import unittest

import h5py

from _program import Case, run

G = 9.81
PLACE = "counterweights.cw.at[0]"
# A link of first moment 0.5 kg m that carries `cargo` at 1 m, and a counterweight: it turns evenly against gravity, so that the torque's
# rms is g / sqrt(2) times the size of the first moment.
LINK = """
name: link
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0]}}}}
bodies: {{link: {{mass: 1, com: [0.5, 0], inertia: 0.1, points: {{O: [0, 0], E: [1, 0]}}}}}}
payloads: {{cargo: {{body: link, at: E, mass: {own}}}}}
counterweights: {{cw: {{body: link, at: [{at}, 0], mass: {{free: [0, 2]}}}}}}
joints: {{J: {{type: revolute, connects: [ground.O, link.O]}}}}
actuators: [J]
motion: {{duration: 1, samples: 201, from: {{joints: {{J: 0}}}}, to: {{joints: {{J: "2 * pi"}}}}}}
trajectories: {{even: {{law: uniform, drive: joints}}}}
design:
  front: {{of: [added-mass, {{rms: torque, along: even}}], points: 5}}
{cases}
"""


class FrontsOverLoads(Case):
    def front(self, cases, *options, at=-1, own=0):
        spec = self.write("link.yaml", LINK.format(cases=cases, at=at, own=own))
        done = run("design", spec, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        return json.loads(done.stdout)

    def check(self, found, most, torque):
        """Points from no added mass to `most`, with a torque that falls by a kilogram metre for each kilogram."""
        points = found["front"]["points"]
        self.assertEqual(len(points), 5)
        self.assertEqual(found["optimality"], "proved-best")
        for point in points:
            mass, rms = point["values"]
            self.assertAlmostEqual(rms, (torque - mass) * G / math.sqrt(2), delta=1e-5 * torque * G)
        self.assertAlmostEqual(points[0]["values"][0], 0, delta=1e-4 * most)
        self.assertAlmostEqual(points[-1]["values"][0], most, delta=1e-4 * most)

    def test_the_worst_load_counts(self):
        """Without cargo 0.5 kg m, with 1 kg of it 1.5: the worst is 1.5 - m up to m = 1, halfway between both."""
        self.check(self.front("  for: {cargo.mass: [0, 1]}"), 1, 1.5)

    def test_the_mean_of_all_loads_counts_and_is_what_is_limited(self):
        """(|0.5 - m| + |1.5 - m|) / 2 is 1 - m up to m = 0.5 and does not fall after that."""
        self.check(self.front("  for: {cargo.mass: [0, 1]}\n  across: mean"), 0.5, 1)

    def test_loads_that_are_alike_make_the_front_of_one(self):
        alone, alike = self.front("", own=1), self.front("  for: {cargo.mass: [0.999999999, 1]}", own=1)
        self.check(alone, 1.5, 1.5)
        self.check(alike, 1.5, 1.5)

    def test_a_counterweight_that_is_moved_for_each_load_trades_further(self):
        """At its farthest for the heavier load, at (0.5 kg m) / m for none: nothing is left at m = 1.5."""
        csv_path, h5_path, out = self.path("front.csv"), self.path("front.h5"), self.path("one.yaml")
        found = self.front("  for: {cargo.mass: [0, 1]}\n  adapt: [\"cw.at[0]\"]", "--csv", csv_path, "--h5", h5_path,
                           "--point", "3", "-o", out, at="{free: [-1, 0]}")
        self.assertEqual(found["optimality"], "proved-best")
        points = found["front"]["points"]
        for point in points:
            mass, rms = point["values"]
            self.assertAlmostEqual(rms, (1.5 - mass) * G / math.sqrt(2), delta=1e-4 * G)
            light, heavy = (case["free_numbers"] for case in point["load_cases"])
            places = [numbers[PLACE] for numbers in (light, heavy)]
            self.assertLessEqual(abs(0.5 + mass * places[0]) * G / math.sqrt(2), rms * (1 + 1e-6) + 1e-9)
            self.assertAlmostEqual(abs(1.5 + mass * places[1]), 1.5 - mass, delta=1e-4)
        with open(csv_path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        with h5py.File(h5_path) as file:
            in_case = file["free_numbers_in_case"][:]
        for k, point in enumerate(points):
            for c, case in enumerate(point["load_cases"]):
                self.assertEqual(sorted(in_case[k, c]), sorted(case["free_numbers"].values()))
                self.assertEqual(float(rows[k][f"{PLACE} (case {c + 1})"]), case["free_numbers"][PLACE])
        written = run("check", out)
        self.assertEqual(written.returncode, 0, written.stderr)

    def test_every_point_is_the_best_design_within_its_limit(self):
        found = self.front("  for: {cargo.mass: [0, 0.4, 1]}")
        for point in found["front"]["points"][1:-1]:
            mass, rms = point["values"]
            text = LINK.format(cases="  for: {cargo.mass: [0, 0.4, 1]}", at=-1, own=0).replace(
                "front: {of: [added-mass, {rms: torque, along: even}], points: 5}",
                f"minimize: {{rms: torque, along: even}}\n  subject_to: [\"added_mass <= {mass!r}\"]")
            done = run("design", self.write("one.yaml", text), "--json")
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            self.assertAlmostEqual(json.loads(done.stdout)["objective"]["value"], rms, delta=1e-5 * rms)


if __name__ == "__main__":
    unittest.main()
