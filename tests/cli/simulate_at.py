"""`balance simulate --at`: a single state has what a run has at the moment at which it moves like that."""

import csv
import json
import os
import random
import unittest

import h5py
import numpy

from _program import CONFIGS, Case, run

# Of the largest value of the column: a state on the command line has 17 digits, its loops are closed to 1e-12 anew.
TOLERANCE = 1e-9


class States(Case):
    def rows(self, spec, *options):
        """A run's columns by name, without their units."""
        table = self.path("run.csv")
        done = run("simulate", spec, *options, "--samples", "11", "--csv", table, "--force", "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(table, encoding="utf-8", newline="") as file:
            heading, *rows = csv.reader(file)
        return {name.split(" [")[0]: numpy.array([float(row[k]) for row in rows]) for k, name in enumerate(heading)}

    def answer(self, spec, at, *options):
        done = run("simulate", spec, "--at", at, *options, "--json", "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
        return {one["quantity"]: one["value"] for one in found["values"]}, found

    def compare(self, name, trajectory, independent):
        spec = os.path.join(CONFIGS, name)
        columns = self.rows(spec, "-t", trajectory)
        k = random.Random(name).randrange(10)
        coordinates = [one[:-len(".position")] for one in columns
                       if one.endswith(".position") and not one.startswith(("com", "tool"))]

        def stated(names, what):
            return ",".join(f"{joint}={float(columns[f'{joint}.{what}'][k])!r}" for joint in names)

        found, _ = self.answer(spec, stated(coordinates, "position"), "--rates", stated(independent, "velocity"),
                               "--accelerations", stated(independent, "acceleration"),
                               "--time", repr(float(columns["time"][k])), "-t", trajectory)
        for joint in coordinates:
            scale = max(1, numpy.abs(columns[f"{joint}.acceleration"]).max())
            self.assertLess(abs(found[f"joint_acceleration[{joint}]"] - columns[f"{joint}.acceleration"][k]),
                            TOLERANCE * scale, (name, joint))
        for axis, label in enumerate("xy"):
            force = columns[f"shaking_force.{label}"]
            self.assertLess(abs(found["shaking_force"][axis] - force[k]), TOLERANCE * max(1, numpy.abs(force).max()), name)

    def test_a_state_has_what_a_run_has_there(self):
        for name, trajectory, independent in (("3rrr.yaml", "cycloid", ("A1", "A2", "A3")),
                                              ("5r.yaml", "bang-bang", ("A1", "A2"))):
            with self.subTest(name):
                self.compare(name, trajectory, independent)

    def test_the_text_tells_the_torques_of_the_equation(self):
        spec = os.path.join(CONFIGS, "5r.yaml")
        state = ("--at", "start", "--rates", "A1=2,A2=-1", "--accelerations", "A1=3")
        done = run("equations", spec, *state, "--json")
        torques = {name: parts["sum"] for name, parts in json.loads(done.stdout)["torques"].items()}
        found, _ = self.answer(spec, *state[1:])
        for name, torque in torques.items():
            self.assertAlmostEqual(found[f"torque[{name}]"], torque, delta=1e-12 * (1 + abs(torque)))
        text = run("simulate", spec, *state)
        self.assert_quiet_success(text)
        self.assertIn("torque[A1]", text.stdout)
        self.assertIn("shaking_force", text.stdout)

    def test_files_have_one_row(self):
        file = self.path("state.h5")
        done = run("simulate", os.path.join(CONFIGS, "5r.yaml"), "--at", "start", "--rates", "A1=1", "-o", file,
                   "--poses", "-q")
        self.assert_quiet_success(done)
        with h5py.File(file) as read:
            self.assertEqual(read["torque"].shape, (1, 2))
            self.assertEqual(read["body_position"].shape[0], 1)
            self.assertEqual(read.attrs["at"], "start")
            self.assertNotIn("trajectory", read.attrs)

    def test_a_mechanism_without_motors_has_the_rest(self):
        text = run("new", "four-bar").stdout
        spec = self.write("free.yaml", "\n".join(line for line in text.splitlines()
                                                 if not line.startswith("actuators:")).split("\nmotion:")[0])
        found, whole = self.answer(spec, "A=0.5")
        self.assertNotIn("torque", " ".join(found))
        self.assertIn("shaking_force", found)
        self.assertTrue(any(note.startswith("no torques: ") for note in whole["notes"]), whole["notes"])

    def test_what_goes_with_a_run_alone_is_refused(self):
        spec = os.path.join(CONFIGS, "5r.yaml")
        for option in (("--samples", "5"), ("--duration", "1"), ("--split",), ("--formulation", "natural")):
            done = run("simulate", spec, "--at", "start", *option)
            self.assertEqual(done.returncode, 2, (option, done.stderr))
        done = run("simulate", spec, "--rates", "A1=1")
        self.assertEqual(done.returncode, 2)
        done = run("simulate", spec, "--at", "start", "--rates", "B1=1")
        self.assert_failure(done, 2, "B1")


if __name__ == "__main__":
    unittest.main()
