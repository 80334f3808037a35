"""Specs that are made of parts: they are the mechanism that is written out in one file, for every command."""

import json
import os
import shutil
import unittest

import h5py
import numpy
import yaml
from _program import CONFIGS, Case, run, unwrapped

LEG = """space: planar
parameters: {l: 0.3, c: 0.15, cw1: {free: [0, 60]}, cw2: {free: [0, 60]}}
ground: {points: {A: [0, 0]}}
bodies:
  crank:   {mass: 1.2, com: [c, 0], inertia: 0.01, points: {A: [0, 0], B: [l, 0]}}
  coupler: {mass: 0.9, com: [0.2, 0], inertia: 0.016, points: {B: [0, 0], P: [0.45, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
  B: {type: revolute, connects: [crank.B, coupler.B]}
actuators: [A]
counterweights:
  cw1: {body: crank, at: [-0.12, 0], mass: cw1}
  cw2: {body: coupler, at: [-0.15, 0], mass: cw2}
"""

PAIR = """space: planar
gravity: [0, -9.81]
include:
  - {file: parts/leg.yaml, as: [one, two], at: {two: [0.4, 0]}, set: {l: {two: 0.32}}}
joints:
  P: {type: revolute, connects: [one.coupler.P, two.coupler.P]}
payloads:
  cargo: {body: one.coupler, at: P, mass: 0.6}
tool: one.coupler.P
assembly: {one.A: 2.3, one.B: -1.5, two.A: 0.8, two.B: 1.4}
motion: {duration: 0.5, samples: 51, from: {tool: [0.1, 0.5]}, to: {tool: [0.32, 0.42]}}
design: {goal: static, minimize: added-mass}
"""


def conditions(*arguments):
    """The matrix of the conditions and the names of its columns."""
    found = json.loads(run("conditions", *arguments, "--json").stdout)
    names = found["parameters"]
    rows = numpy.zeros((len(found["conditions"]), len(names)))
    for row, condition in zip(rows, found["conditions"]):
        for term in condition["terms"]:
            row[names.index(term["parameter"])] = term["coefficient"]
    return rows, names


class Include(Case):
    def pair(self):
        os.mkdir(self.path("parts"))
        self.write("parts/leg.yaml", LEG)
        return self.write("pair.yaml", PAIR)

    def arrays(self, spec, trajectory, *wanted):
        result = self.path("result.h5")
        self.assert_quiet_success(run("simulate", spec, "--trajectory", trajectory, "-o", result, "--force"))
        with h5py.File(result) as file:
            return [file[name][...] for name in wanted]

    def assert_same_motion(self, legs, whole, trajectories, tolerance):
        for trajectory in trajectories:
            wanted = ("torque", "shaking_force", "shaking_moment", "kinetic_energy")
            found = self.arrays(os.path.join(CONFIGS, legs), trajectory, *wanted)
            expected = self.arrays(os.path.join(CONFIGS, whole), trajectory, *wanted)
            for name, a, b in zip(wanted, found, expected):
                scale = numpy.abs(b).max()
                self.assertGreater(scale, 0)
                self.assertLess(numpy.abs(a - b).max(), tolerance * scale, f"{legs} {trajectory} {name}")

    def test_legs_put_together_are_the_manipulator_that_is_written_out(self):
        # Positions are solved to 1e-13 on either way; forces lose up to the condition number of the closures.
        self.assert_same_motion("3rrr-legs.yaml", "3rrr.yaml", ("cycloid", "bang-bang", "tool-bang"), 1e-11)
        self.assert_same_motion("delta-legs.yaml", "delta.yaml", ("cycloid", "circle"), 1e-11)

    def test_the_conditions_are_those_of_the_mechanism_in_one_file(self):
        spec = os.path.join(CONFIGS, "3rrr-legs.yaml")
        for goal in ("force", "dynamic", "static"):
            found, expected = (run("conditions", os.path.join(CONFIGS, name), "--goal", goal, "--json") for name in
                               ("3rrr-legs.yaml", "3rrr.yaml"))
            self.assertEqual(json.loads(found.stdout)["rank"], json.loads(expected.stdout)["rank"], goal)
        self.assertIn("L1.crank.mx", run("conditions", spec, "--goal", "force").stdout)

    def test_balanced_parts_make_a_balanced_whole(self):
        """P0 Propositions 2.2 and 2.3: the conditions of the parts imply those of the whole."""
        for spec in (self.pair(), os.path.join(CONFIGS, "3rrr-legs.yaml")):
            parts, names = conditions(spec, "--goal", "static", "--strategy", "modular")
            whole, same = conditions(spec, "--goal", "static")
            self.assertEqual(names, same)
            rank = numpy.linalg.matrix_rank
            if whole.size:
                self.assertEqual(rank(numpy.vstack([parts, whole])), rank(parts))
        text = run("conditions", self.path("pair.yaml"), "--goal", "static", "--strategy", "modular").stdout
        self.assertIn("split at joint P into the chains (one.crank, one.coupler), (two.crank, two.coupler", unwrapped(text))

    def test_shares_of_a_payload_are_free_where_both_parts_carry_some_of_it(self):
        """Whatever the shares, the parts' conditions imply the whole's; a free share is chosen with the counterweights."""
        self.pair()
        shared = PAIR.replace("  cargo: {body: one.coupler, at: P, mass: 0.6}",
                              '  mine: {body: one.coupler, at: P, mass: "s * 0.6"}\n'
                              '  yours: {body: two.coupler, at: P, mass: "(1 - s) * 0.6"}')
        added = {}
        for share in ("0", "0.3", "0.5", "1", "{free: [0, 1]}"):
            spec = self.write("shared.yaml", shared.replace("include:", f"parameters: {{s: {share}}}\ninclude:"))
            done = run("design", spec, "--strategy", "modular", "-o", self.path("out.yaml"), "--force", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            design = json.loads(done.stdout)
            self.assert_quiet_success(run("conditions", self.path("out.yaml"), "--goal", "static"))
            added[share] = self.added_mass(self.path("out.yaml"))
            self.assertEqual(design["status"], "balanced")
        halves = self.write("halves.yaml", PAIR)
        self.assert_quiet_success(run("design", halves, "--strategy", "modular", "-o", self.path("out.yaml"), "--force"))
        self.assertAlmostEqual(added["0.5"], self.added_mass(self.path("out.yaml")), places=9)
        self.assertGreater(abs(added["0"] - added["1"]), 0.1)
        self.assertLess(added["{free: [0, 1]}"], min(added["0"], added["0.5"], added["1"]) + 1e-9)

    def added_mass(self, spec):
        with open(spec, encoding="utf-8") as file:
            parameters = yaml.safe_load(file)["parameters"]
        return sum(value for name, value in parameters.items() if ".cw" in name)

    def test_a_design_is_written_as_one_document_that_runs_by_itself(self):
        spec = self.pair()
        for strategy in ("complete", "modular"):
            balanced = self.path(f"{strategy}.yaml")
            self.assert_quiet_success(run("design", spec, "--strategy", strategy, "-o", balanced))
            shutil.rmtree(self.path("away"), ignore_errors=True)
            os.mkdir(self.path("away"))
            moved = shutil.move(balanced, self.path("away"))
            with open(moved, encoding="utf-8") as file:
                text = file.read()
            self.assertNotIn("include", text)
            self.assertNotIn("free", text)
            done = run("conditions", moved, "--goal", "static")
            self.assert_quiet_success(done)

    def test_a_result_holds_everything_that_it_was_made_from(self):
        spec = self.pair()
        first = self.path("first.h5")
        self.assert_quiet_success(run("simulate", spec, "--set", "one.l=0.31", "--trajectory", "cycloid", "-o", first))
        with h5py.File(first) as file:
            text = file.attrs["spec"]
            torque = file["torque"][...]
        text = text.decode() if isinstance(text, bytes) else text
        alone = self.write("alone.yaml", text)
        shutil.rmtree(self.path("parts"))
        second = self.path("second.h5")
        self.assert_quiet_success(run("simulate", alone, "--set", "one.l=0.31", "--trajectory", "cycloid", "-o", second))
        with h5py.File(second) as file:
            self.assertTrue((file["torque"][...] == torque).all())

    def test_a_batch_computes_again_when_a_part_has_changed(self):
        self.pair()
        suite = self.write("suite.yaml", "cases: [{name: a, spec: pair.yaml, trajectory: cycloid, set: {one.c: 0.14}}]\n")
        peaks = []
        for leg in (LEG, LEG, LEG.replace("mass: 0.9", "mass: 1.9")):
            self.write("parts/leg.yaml", leg)
            done = run("batch", suite, "-o", self.path("out"))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual("finished already" in done.stderr, len(peaks) == 1)
            with open(self.path("out/summary.json"), encoding="utf-8") as file:
                metrics = json.load(file)["cases"][0]["metrics"]
            peaks.append(next(m["peak"] for m in metrics if m["quantity"] == "torque[one.A]"))
        self.assertEqual(peaks[0], peaks[1])
        self.assertGreater(abs(peaks[2] - peaks[0]), 1e-3 * abs(peaks[0]))

    def test_names_of_parts_stand_wherever_names_do(self):
        spec = self.pair()
        result = self.path("result.h5")
        self.assert_quiet_success(run("simulate", spec, "--trajectory", "cycloid", "-o", result))
        self.assert_quiet_success(run("compare", result, result, "--require", "peak(torque[two.A]) <= 1000"))
        self.assert_quiet_success(run("equations", spec, "--at", "one.A=2.3,two.A=0.8"))
        self.assert_quiet_success(run("check", spec))
        self.assertIn("one_l", run("equations", os.path.join(self.folder, "pair.yaml"), "--code", "c").stdout)

    def test_odd_files_are_told_and_nothing_hangs(self):
        spec = self.pair()
        leg = self.path("parts/leg.yaml")
        self.assert_failure(run("design", spec, "-o", leg, "--force"), 2, "would replace a table or a part of the spec")
        os.remove(leg)
        self.assert_failure(run("check", spec), 3, "pair.yaml:4:12: include[0].file: expected the file of a part, found none at")
        os.mkfifo(leg)
        self.assert_failure(run("check", spec), 3, "found a pipe or a device at")
        suite = self.write("suite.yaml", "cases: [{name: a, spec: pair.yaml, trajectory: cycloid}]\n")
        self.assertNotEqual(run("batch", suite, "-o", self.path("out")).returncode, 0)
        os.remove(leg)
        os.symlink("/dev/zero", leg)
        self.assert_failure(run("check", spec), 3, "found a pipe or a device at")
        os.remove(leg)
        self.write("parts/leg.yaml", "#" * (5 << 20))
        self.assert_failure(run("check", spec), 3, "leg.yaml:1:1: expected a document of at most 4 MiB")


if __name__ == "__main__":
    unittest.main()
