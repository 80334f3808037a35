"""`balance design` with free lengths says how good its design is, for which lengths that is proved, and why not."""

import json
import os
import random
import re
import unittest

import h5py

from _program import Case, run, unwrapped

SPECS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "certificate", "specs")

# optimum [kg], and the gap that ten seconds must reach
KNOWN = {"four_hi_4": (1.43994, 1e-6), "four_box_1": (0.879082, 1e-6), "four_fix21": (1.62062, 1e-6), "five_box_1": (7.34350, 1e-4),
         "watt_box_1": (3.08961, 1e-4)}


def spec(name):
    return os.path.join(SPECS, f"{name}.yaml")


class LengthBounds(Case):
    def design(self, path, *options, code=0, seconds=10):
        done = run("design", path, "--json", "--seconds", str(seconds), *options)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def test_published_optima_are_reached_and_the_bound_says_so(self):
        for name, (optimum, gap) in KNOWN.items():
            with self.subTest(name):
                found = self.design(spec(name))
                bound = found["length_bound"]
                self.assertAlmostEqual(found["objective"]["value"], optimum, delta=1e-5 * optimum)
                self.assertLessEqual(bound["relative_gap"], gap)
                self.assertLessEqual(found["objective"]["lower_bound"], found["objective"]["value"])
                self.assertEqual(found["optimality"], "proved-best")
                self.assertIn(bound["coverage"], unwrapped(run("design", spec(name), "--seconds", "10").stdout))

    def test_no_other_lengths_are_better(self):
        for name in KNOWN:
            found = self.design(spec(name))
            lengths = [n for n in found["free_numbers"] if n["path"].startswith("parameters.")]
            dice = random.Random(name)
            for _ in range(3):
                fixed = [f"{n['path'].split('.')[1]}={dice.uniform(n['lower'], n['upper'])!r}" for n in lengths]
                there = run("design", spec(name), "--json", *(word for one in fixed for word in ("--set", one)))
                if there.returncode == 0 and json.loads(there.stdout)["status"] == "balanced":
                    value = json.loads(there.stdout)["objective"]["value"]
                    self.assertGreaterEqual(value, found["length_bound"]["lower_bound"] * (1 - 1e-9), fixed)

    def test_mass_limits_that_no_lengths_can_keep_are_impossible(self):
        for name in ("five_hi_3", "watt_hi_3"):
            found = self.design(spec(name), code=1)
            self.assertEqual((found["status"], found["proved"]), ("impossible", True))
            self.assertTrue(found["length_bound"]["impossible"])
            self.assertIn("at any lengths", found["reason"])

    def test_it_says_what_it_does_not_cover_and_why_there_is_no_bound(self):
        self.assertEqual(self.design(spec("five_box_1"))["length_bound"]["not_covered"], [])
        self.assertNotEqual(self.design(spec("watt_box_1"))["length_bound"]["not_covered"], [])
        with open(spec("four_box_1"), encoding="utf-8") as file:
            text = file.read()
        simple = self.write("simple.yaml", text.replace("minimize: added-mass", "minimize: added-inertia"))
        bound = self.design(simple, "--starts", "1")["length_bound"]
        self.assertEqual(list(bound), ["reason"])
        self.assertIn("added mass", bound["reason"])

    def test_figures_along_a_motion_have_a_bound(self):
        # the optimum at b = 0.33 by an independent program
        found = self.design(spec("shaking_four_bar"))
        bound = found["length_bound"]
        self.assertAlmostEqual(found["objective"]["value"], 10.816371, delta=1e-5)
        self.assertLessEqual(bound["relative_gap"], 1e-3)
        self.assertLessEqual(bound["lower_bound"], 10.816371)
        self.assertEqual(bound["unit"], "N")
        for word in ("turn can be followed", "the motion's samples", "the assembly mode of the start values"):
            self.assertIn(word, bound["coverage"])
        lower = [one["lower_bound"] for one in bound["progress"]]
        self.assertEqual(lower, sorted(lower))
        dice = random.Random(1)
        for _ in range(3):
            there = run("design", spec("shaking_four_bar"), "--json", "--seconds", "2", "--set", f"b={dice.uniform(0.33, 0.4)!r}")
            self.assertGreaterEqual(json.loads(there.stdout)["objective"]["value"], bound["lower_bound"])

    def test_a_figure_without_a_bound_says_why(self):
        with open(spec("shaking_four_bar"), encoding="utf-8") as file:
            text = file.read()
        mean = self.write("mean.yaml", text.replace("rms: shaking_force", "mean: shaking_force"))
        self.assertIn("rms and peak", self.design(mean, "--starts", "1")["length_bound"]["reason"])

    def test_another_assembly_mode_is_allowed_where_only_masses_are_asked_for(self):
        with open(spec("steph_box_1"), encoding="utf-8") as file:
            text = file.read()
        free = ("ey", "f", "g")
        text = re.sub(r"(\w+): \{free: \[[^]]*\], start: ([\d.]+)\}", lambda m: m[0] if m[1] in free else f"{m[1]}: {m[2]}", text)
        anywhere = self.write("any.yaml", text)
        kept = self.write("kept.yaml", text.replace("minimize: added-mass", "minimize: added-mass, assembly_mode: start"))
        done = run("design", anywhere, "--json", "--seconds", "10", "-o", self.path("best.yaml"))
        best = json.loads(done.stdout)
        self.assertEqual(best["optimality"], "proved-best")
        self.assertTrue(any("in another assembly mode than the start values" in note for note in best["notes"]), best["notes"])
        self.assertEqual(run("simulate", self.path("best.yaml")).returncode, 0)
        mass = best["objective"]["value"]
        same = self.design(kept, seconds=3)
        self.assertGreater(same["objective"]["value"], mass * 1.005)
        self.assertTrue(any(f"another assembly mode needs only {mass:.6g} kg" in note for note in same["notes"]), same["notes"])
        # a figure along a motion depends on the mode
        moved = self.write("moved.yaml", text.replace("minimize: added-mass", "minimize: added-mass, subject_to: [peak(torque) <= 1e6]"))
        self.assertGreater(self.design(moved, seconds=2)["objective"]["value"], mass * 1.005)

    def test_bound_and_best_approach_each_other(self):
        progress = self.design(spec("five_box_1"))["length_bound"]["progress"]
        for before, after in zip(progress, progress[1:]):
            self.assertLessEqual(before["seconds"], after["seconds"])
            self.assertLessEqual(before["lower_bound"], after["lower_bound"] * (1 + 1e-12))
            if before["best"] is not None:
                self.assertLessEqual(after["best"], before["best"])

    def test_points_of_a_front_have_the_bound_of_their_mass(self):
        with open(spec("four_box_1"), encoding="utf-8") as file:
            text = file.read()
        request = "design: {goal: force, front: {of: [added-mass, added-inertia], points: 3}, search: {starts: 1}}"
        file = self.write("front.yaml", text.replace("design: {goal: force, minimize: added-mass}", request))
        done = run("design", file, "--json")
        front = json.loads(done.stdout)["front"]
        best = self.design(spec("four_box_1"))["objective"]["value"]
        self.assertAlmostEqual(front["figures"][0]["lower_bound"], best, delta=1e-6 * best)
        self.assertIn("the proof covers", front["figures"][0]["coverage"])
        for point in front["points"]:
            self.assertGreaterEqual(point["values"][0], front["figures"][0]["lower_bound"] * (1 - 1e-9))
            if point["minimized"] == 0:
                self.assertGreaterEqual(point["lower_bound"], front["figures"][0]["lower_bound"] * (1 - 1e-9))
                self.assertLessEqual(point["lower_bound"], point["values"][0] * (1 + 1e-9))
        self.assertIn("bound of a: the proof covers", run("design", file).stdout)

    def test_the_design_file_has_what_json_has(self):
        for name in ("four_hi_4", "shaking_four_bar"):
            file = self.path(f"{name}.h5")
            done = run("design", spec(name), "--h5", file, "--json")
            told = json.loads(done.stdout)["length_bound"]
            with h5py.File(file) as written:
                bound = written["length_bound"]
                self.assertEqual(list(bound.attrs["covers"]), told["covers"])
                self.assertEqual(bound.attrs["coverage"], told["coverage"])
                self.assertEqual(bound["lower_bound"][-1], told["lower_bound"])
                self.assertEqual(bound["best"][-1], told["best"])
                self.assertEqual(bound["lower_bound"].attrs["units"], told["unit"])
                self.assertEqual(bound["boxes"][()], told["boxes"])


if __name__ == "__main__":
    unittest.main()
