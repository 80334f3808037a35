#!/usr/bin/env python3
"""balance control: files, seeds, early ends, what other commands make of its results."""

import json
import math
import os
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from _program import CONFIGS, PROGRAM, Case, run

FIVE_BAR = os.path.join(CONFIGS, "control-5r.yaml")
ARM = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {arm: {mass: 2, com: [0.4, 0], inertia: 0.1, points: {A: [0, 0], E: [0.8, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, arm.A]}}
payloads: {cargo: {on: arm, at: E, mass: 0.5}}
actuators: [J]
tool: arm.E
motion: {duration: 0.3, samples: 31, from: {joints: {J: 0.2}}, to: {joints: {J: 1.2}}}
controllers:
  noisy: {type: computed-torque, measurement: {position_noise: 0.001, velocity: difference}}
  other: {type: computed-torque, measurement: {position_noise: 0.001, velocity: difference, seed: 2}}
  weak:  {type: sliding-mode, torque_limit: 12}
"""
# A four-bar whose crank is pushed harder than its motor can hold, up to the dead point in which coupler and rocker are in line and the
# crank turns back: |BD| = 1.2 at cos A = (0.8² + 1 − 1.2²) / (2 · 0.8) = 0.125.
DEAD_POINT = """
space: planar
gravity: [0, -9.81]
ground: {points: {A: [0, 0], D: [1, 0]}}
bodies:
  crank:   {mass: 1, com: [0.4, 0], inertia: 0.05, points: {A: [0, 0], B: [0.8, 0]}}
  coupler: {mass: 1, com: [0.3, 0], inertia: 0.05, points: {B: [0, 0], C: [0.6, 0]}}
  rocker:  {mass: 1, com: [0.3, 0], inertia: 0.05, points: {D: [0, 0], C: [0.6, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
  B: {type: revolute, connects: [crank.B, coupler.B]}
  C: {type: revolute, connects: [coupler.C, rocker.C]}
  D: {type: revolute, connects: [ground.D, rocker.D]}
actuators: [A]
tool: crank.B
assembly: {A: 1.0, D: 1.6}
motion: {duration: 1, samples: 101, from: {joints: {A: 1.0}}, to: {joints: {A: 0.9}}}
loads: {push: {on: crank, moment: 60}}
controllers:
  weak: {type: computed-torque, torque_limit: 5}
"""


class Control(Case):
    def arm(self):
        return self.write("arm.yaml", ARM)

    def control(self, spec, controller, *arguments):
        return run("control", spec, "-t", "cycloid", "-c", controller, *arguments)

    def test_the_summary_names_errors_and_the_file_holds_them(self):
        out = self.path("out.h5")
        done = self.control(FIVE_BAR, "sliding", "-o", out, "--samples", "101")
        self.assert_quiet_success(done)
        self.assertIn("controller sliding (sliding-mode)", done.stdout)
        for quantity in ("tracking_error[A1]", "tool_error", "sliding_variable[A2]", "torque_variation", "saturation"):
            self.assertIn(quantity, done.stdout)
        with h5py.File(out) as file:
            self.assertEqual(file.attrs["controller"], "sliding")
            self.assertEqual(file.attrs["controller_type"], "sliding-mode")
            self.assertEqual(file.attrs["status"], "done")
            self.assertIn("balance control control-5r.yaml --trajectory cycloid --controller sliding --samples 101",
                          file.attrs["command_line"])
            numpy.testing.assert_allclose(file["tracking_error"][:], file["desired_position"][:] - file["joint_position"][:],
                                          atol=1e-12)
            self.assertEqual(file["sliding_variable"].shape, (101, 2))
            self.assertEqual(list(file["sliding"].asstr()), ["A1", "A2"])
            self.assertGreater(file["torque_variation"][-1, 0], 0)
            self.assertTrue(numpy.all(numpy.diff(file["torque_variation"][:], axis=0) >= 0))

    def test_the_same_seed_gives_the_same_bytes_and_another_one_others(self):
        spec = self.arm()
        for name, controller in (("a", "noisy"), ("b", "noisy"), ("c", "other")):
            self.assert_quiet_success(self.control(spec, controller, "-o", self.path(name + ".h5"), "-q"))
        contents = {}
        for name in "abc":
            with open(self.path(name + ".h5"), "rb") as file:
                contents[name] = file.read()
        self.assertEqual(contents["a"], contents["b"])
        self.assertNotEqual(contents["a"], contents["c"])

    def test_other_commands_take_the_files(self):
        spec = self.arm()
        for controller in ("computed-torque", "weak"):
            self.assert_quiet_success(self.control(spec, controller, "-o", self.path(controller + ".h5"), "-q"))
        files = [self.path("computed-torque.h5"), self.path("weak.h5")]
        done = run("compare", *files, "--require", "rms(tracking_error) <= 0.5 * base", "--json")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("torque_variation", done.stdout)
        done = run("compare", *files, "--require", "mean(saturation) >= 0", "--require", "peak(torque) <= 12.001")
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        for quantity in ("tracking_error", "sliding_variable", "saturation", "tool_error"):
            done = run("plot", files[1], "--quantity", quantity, "-o", self.path(quantity + ".svg"))
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_suites_run_controllers(self):
        self.arm()
        suite = self.write("suite.yaml", """
defaults: {spec: arm.yaml, trajectory: cycloid}
cases:
  wished: {}
  exact: {controller: computed-torque}
matrix: {controller: [weak, noisy], samples: 11}
baseline: exact
require: ["rms(tracking_error, weak) <= 1", "peak(torque, weak) <= 12.001"]
""")
        done = run("batch", suite, "-o", self.path("out"))
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        direct = self.path("direct.h5")
        self.assert_quiet_success(self.control(self.path("arm.yaml"), "weak", "--samples", "11", "-o", direct, "-q"))
        with open(direct, "rb") as one, open(os.path.join(self.path("out"), "weak.h5"), "rb") as other:
            self.assertEqual(one.read(), other.read())
        wrong = self.write("wrong.yaml", "cases: {a: {spec: arm.yaml, controller: waek}}\n")
        done = run("batch", wrong, "-o", self.path("wrong"))
        self.assertEqual(done.returncode, 3)
        self.assertIn("nearest is 'weak'", done.stdout + done.stderr)

    def test_a_name_that_is_not_there_is_told(self):
        self.assert_failure(self.control(self.arm(), "waek"), 2, "has no controller 'waek'", "nearest is 'weak'")
        self.assert_failure(self.control(self.arm(), "weak", "--settle", "-1"), 2, "--settle")

    def test_settling_holds_the_last_pose(self):
        out = self.path("out.h5")
        self.assert_quiet_success(self.control(self.arm(), "computed-torque", "--settle", "0.2", "-o", out, "-q"))
        with h5py.File(out) as file:
            self.assertAlmostEqual(file["time"][-1], 0.5)
            self.assertAlmostEqual(file["desired_position"][-1, 0], 1.2)
            self.assertEqual(len(file["time"]), 51)

    def test_json_names_the_controller(self):
        done = self.control(self.arm(), "computed-torque", "--json")
        self.assert_quiet_success(done)
        told = json.loads(done.stdout)
        self.assertEqual(told["controller_type"], "computed-torque")
        self.assertIn("tracking_error", [metric["quantity"] for metric in told["metrics"]])

    def test_a_singular_configuration_ends_the_run_and_keeps_what_was_computed(self):
        spec = self.write("dead.yaml", DEAD_POINT)
        out = self.path("out.h5")
        done = self.control(spec, "weak", "-o", out)
        self.assert_failure(done, 4, "actuation singularity", "at t = ", "written up to where the run ended: " + out)
        with h5py.File(out) as file:
            self.assertEqual(file.attrs["status"], "actuation-singularity")
            self.assertIn("at t = ", file.attrs["reason"])
            self.assertLess(len(file["time"]), 101)
            self.assertLess(abs(file["joint_position"][-1, 0] - math.acos(0.125)), 0.05)
            self.assertIn("torque", file["metrics/quantity"].asstr()[:])
        done = run("compare", out, out)
        self.assertIn("ended early", done.stderr)
        told = json.loads(self.control(spec, "weak", "--json").stdout)
        self.assertEqual(told["error"]["status"], "actuation-singularity")
        # without a controller it swings through
        self.assert_quiet_success(self.control(spec, "none", "-q"))

    def test_an_interrupted_run_leaves_no_file(self):
        out = self.path("out.h5")
        with subprocess.Popen([PROGRAM, "control", self.arm(), "-t", "cycloid", "-c", "noisy", "--settle", "3000", "-o", out],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            self.assertNotEqual(process.wait(30), 0)
        self.assertEqual([name for name in os.listdir(self.folder) if name != "arm.yaml"], [])


if __name__ == "__main__":
    unittest.main()
