#!/usr/bin/env python3
"""The second formulation at the command line: simulate --formulation natural and check --verify."""

import json
import os
import unittest

import h5py
import numpy

from _program import CONFIGS, SPEC, Case, run

SPATIAL = os.path.join(CONFIGS, "delta.yaml")


class Simulate(Case):
    def simulate(self, formulation, name):
        file = self.path(name)
        self.assert_quiet_success(
            run("simulate", SPEC, "-t", "cycloid", "--samples", "51", "-q", "-o", file, "--formulation", formulation)
        )
        return h5py.File(file)

    def test_same_layout_same_numbers(self):
        tree, natural = self.simulate("tree", "tree.h5"), self.simulate("natural", "natural.h5")
        self.assertEqual((tree.attrs["formulation"], natural.attrs["formulation"]), ("tree", "natural"))
        self.assertEqual(set(tree) - set(natural), {"joint_force", "joint_moment", "mobility"})
        for name in set(natural) - {"newton_iterations", "metrics"}:
            self.assertEqual((tree[name].shape, tree[name].dtype), (natural[name].shape, natural[name].dtype))
            if natural[name].dtype.kind == "f":
                scale = max(1, numpy.abs(tree[name][...]).max())
                self.assertLess(numpy.abs(tree[name][...] - natural[name][...]).max() / scale, 1e-9, name)
        self.assertIn("--formulation natural", natural.attrs["command_line"])

    def test_refusals(self):
        self.assert_failure(run("simulate", SPATIAL, "--formulation", "natural"), 2, "spatial", "planar")
        self.assert_failure(run("simulate", SPEC, "--formulation", "natual"), 2, "nearest is 'natural'")


class Verify(Case):
    def test_agreement(self):
        done = run("check", os.path.join(CONFIGS, "scotch-yoke.yaml"), "--verify")
        self.assert_quiet_success(done)
        for text in ("trajectory steady, 401 samples: agree", "shaking_moment", "both formulations agree",
                     "force conditions: 3 by sampling, 3 from the coefficient matrices; the same space"):
            self.assertIn(text, " ".join(done.stdout.split()))

    def test_json(self):
        done = run("check", os.path.join(CONFIGS, "5r.yaml"), "--verify", "--json")
        self.assert_quiet_success(done)
        found = json.loads(done.stdout)["verification"]
        self.assertTrue(found["agree"])
        self.assertEqual(found["force_conditions"]["by_sampling"], 6)
        self.assertEqual([run["trajectory"] for run in found["trajectories"]], ["cycloid", "bang-bang", "circle"])
        for trajectory in found["trajectories"]:
            self.assertLess(max(d["relative"] for d in trajectory["differences"]), 1e-9)

    def test_a_law_that_depends_on_the_mechanism_is_found_first(self):
        done = run("check", os.path.join(CONFIGS, "published", "topp-two_points_1.yaml"), "--verify")
        self.assert_quiet_success(done)
        for text in ("trajectory fast, 101 samples: agree", "force conditions: 6 by sampling", "both formulations agree"):
            self.assertIn(text, done.stdout)

    def test_what_cancels_is_no_disagreement(self):
        """(A9) At both ends of a cycloidal motion nothing accelerates; round-off of what cancels there is not compared with itself."""
        spec = self.write("spring.yaml", """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0], S: [0, 0.3]}}
bodies:
  link: {mass: 2, com: [0.2, 0.1097487096825364], inertia: 0.03, points: {A: [0, 0], P: [0.1, 0], E: [0.4, 0]}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
springs: {s: {between: [ground.S, link.P], stiffness: 300}}
actuators: [J]
tool: link.E
motion: {duration: 1, samples: 2, from: {joints: {J: -1}}, to: {joints: {J: 1.2}}}
trajectories:
  cycloid: {law: cycloidal, drive: joints}
  bang-bang: {law: bang-bang, drive: joints}
""")
        for samples in (2, 3, 5, 41):
            text = open(spec, encoding="utf-8").read().replace("samples: 2", f"samples: {samples}")
            self.assert_quiet_success(run("check", self.write("more.yaml", text), "--verify"))

    def test_spatial_mechanisms_have_no_second_formulation(self):
        self.assert_failure(run("check", SPATIAL, "--verify"), 2, "delta.yaml is spatial", "two formulations")

    def test_both_refuse_what_cannot_be_driven(self):
        with open(os.path.join(CONFIGS, "four-bar.yaml"), encoding="utf-8") as file:
            text = file.read().replace("actuators: [A]", "actuators: []")
        self.assertIn("actuators: []", text)
        done = run("check", self.write("loose.yaml", text), "--verify")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("both formulations reject it", done.stdout)
        self.assertIn("under-actuated", done.stderr)


if __name__ == "__main__":
    unittest.main()
