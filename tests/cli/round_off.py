"""Round-off is 0 in everything that shows it, and in the columns of a file that are nothing else (D2)."""

import json
import os
import re
import unittest

import h5py
import numpy

from _program import CONFIGS, Case, run

BALANCED = os.path.join(CONFIGS, "planar-rrr.yaml")
ZEROS = ("shaking_force", "com_velocity", "com_acceleration")
NOISE = re.compile(r"[0-9]e-(1[2-9]|[2-9][0-9])")  # nothing in these mechanisms is that small


def numbers_of(answer):
    """All numbers in a part of a JSON answer."""
    if isinstance(answer, dict):
        answer = list(answer.values())
    if isinstance(answer, list):
        return [number for part in answer for number in numbers_of(part)]
    return [answer] if isinstance(answer, (int, float)) and not isinstance(answer, bool) else []


class RoundOff(Case):
    def simulated(self, name="run.h5", *arguments):
        file = self.path(name)
        self.assert_quiet_success(run("simulate", BALANCED, "-t", "cycloid", "-q", "-o", file, *arguments))
        return file

    def assert_zeros(self, metrics):
        for metric in metrics:
            if metric["quantity"] in ZEROS:
                self.assertEqual([metric[k] for k in ("peak", "rms", "mean", "range")], [0, 0, 0, 0], metric)
            if metric["quantity"] == "shaking_moment":
                self.assertGreater(metric["peak"], 1)

    def test_tables_and_json_of_a_run_have_zeros(self):
        for formulation in ("tree", "natural"):
            done = run("simulate", BALANCED, "-t", "cycloid", "--formulation", formulation)
            self.assertEqual(done.returncode, 0)
            self.assertNotRegex(done.stdout, NOISE)
            done = run("simulate", BALANCED, "-t", "cycloid", "--formulation", formulation, "--json")
            self.assert_zeros(json.loads(done.stdout)["metrics"])

    def test_the_file_says_what_its_samples_are_worth(self):
        with h5py.File(self.simulated()) as file:
            force = file["shaking_force"]
            self.assertEqual(abs(force[:]).max(), 0)
            self.assertGreater(float(numpy.max(force.attrs["round_off"])), 0)
            self.assertEqual(len(numpy.atleast_1d(file["torque"].attrs["round_off"])), 3)
            self.assertNotIn("round_off", file["mobility"].attrs)
            at = [name.decode() for name in file["metrics/quantity"][:]].index("shaking_force")
            self.assertEqual(file["metrics/peak"][at], 0)
            self.assertGreater(file["metrics/round_off"][at], 0)
            self.assertEqual(file["metrics/round_off"].attrs["units"], file["metrics/peak"].attrs["units"])

    def test_comparisons_have_neither_noise_nor_ratios_of_noise(self):
        one, other = self.simulated("one.h5"), self.simulated("other.h5", "--samples", "333")
        for kind in ([], ["--all"]):
            done = run("compare", one, other, *kind)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotRegex(done.stdout.lower(), r"inf|nan")
            lines = [line for line in done.stdout.splitlines() if line.startswith("shaking_force")]
            self.assertGreater(len(lines), 3)
            for line in lines:
                self.assertNotRegex(line, NOISE)
        for wish in ("peak(shaking_force) <= 1e-9", "peak(shaking_force) == 0", "peak(shaking_force) <= base"):
            self.assertEqual(run("compare", one, other, "--require", wish).returncode, 0, wish)
        # Nothing over nothing is no number: the requirement is missed, and says why.
        done = run("compare", one, other, "--require", "peak(shaking_force) / base <= 2")
        self.assertEqual(done.returncode, 1)
        self.assertIn("cannot be decided", done.stdout)

    def test_a_file_without_the_attribute_is_read_as_before(self):
        file = self.simulated()
        with h5py.File(file, "r+") as stored:
            for name in list(stored):
                if "round_off" in stored[name].attrs:
                    del stored[name].attrs["round_off"]
            del stored["metrics/round_off"]
        done = run("compare", file, self.simulated("other.h5"), "--all")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("shaking_force", done.stdout)

    def test_a_wrong_attribute_is_damage(self):
        file = self.simulated()
        with h5py.File(file, "r+") as stored:
            stored["torque"].attrs["round_off"] = [1.0, 2.0]
        self.assert_failure(run("compare", file, self.simulated("other.h5")), 5, "'torque'", "damaged")

    def test_a_batch_has_zeros(self):
        suite = self.write("suite.yaml", f"cases:\n  balanced: {{spec: {BALANCED}, trajectory: cycloid}}\n")
        done = run("batch", suite, "-o", self.path("out"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotRegex(done.stdout, NOISE)
        with open(self.path("out/summary.csv"), encoding="utf-8") as summary:
            lines = [line for line in summary if ",shaking_force," in line]
        self.assertEqual(len(lines), 1)
        self.assertNotRegex(lines[0], NOISE)

    def test_poses_and_equations_of_every_config_have_zeros(self):
        """What is said of a pose is 0 or more than a part in 1e12 of a radian or of the mechanism."""
        for name in sorted(os.listdir(CONFIGS)):
            if not name.endswith(".yaml"):
                continue
            checked = run("check", os.path.join(CONFIGS, name), "--json")
            if checked.returncode != 0:
                continue
            with self.subTest(name):
                pose = json.loads(checked.stdout)
                for value in [*numbers_of(pose["start"]), *numbers_of(pose["modes"]), *pose["com"]]:
                    self.assertTrue(value == 0 or abs(value) > 1e-14, value)
                at = run("equations", os.path.join(CONFIGS, name), "--at", "start", "--json")
                if at.returncode == 0:
                    equations = json.loads(at.stdout)
                    for part in ("configuration", "q", "M", "D", "B", "z", "input"):
                        for value in numbers_of(equations.get(part, [])):
                            self.assertTrue(value == 0 or abs(value) > 1e-14, (part, value))

    def test_a_controlled_run_has_zeros(self):
        done = run("control", BALANCED, "-t", "cycloid", "-c", "computed-torque", "--samples", "51", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_zeros([m for m in json.loads(done.stdout)["metrics"] if m["quantity"] != "shaking_moment"])


if __name__ == "__main__":
    unittest.main()
