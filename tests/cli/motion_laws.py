#!/usr/bin/env python3
"""The suite of laws of motion makes the figures that docs/motion.md tells, each known from a second program."""

import json
import os
import unittest

from _program import CONFIGS, Case, run

SUITES = os.path.join(CONFIGS, "suites")
TOLERANCE = 1e-5  # of the figures that the documentation tells

# case: quantity, figure, value [SI]
FIGURES = {
    "guided": ("shaking_force", "peak", 549.2528818391),
    "force": ("shaking_force", "peak", 549.2528818391),
    "force-torque": ("torque", "peak", 74.2249),
    "force-moment": ("shaking_moment", "peak", 30),
    "torque": ("torque", "peak", 60),
    "moment": ("shaking_moment", "peak", 30),
    "gentle-force": ("shaking_force", "peak", 556.145680),
    "gentle-torque": ("torque", "peak", 61.741579),
    "gentle-moment": ("shaking_moment", "peak", 23.629943),
    "calm": ("shaking_moment", "rms", 7.615992),
    "heavy-guided": ("shaking_moment", "peak", 58.184),
    "redistributed": ("shaking_moment", "rms", 11.368726),
    "redistributed-calm": ("shaking_moment", "rms", 2.847631),
    "five-bar-torque": ("torque", "peak", 12),
    "five-bar-gentle-0.5": ("torque", "peak", 8.873157415),
    "five-bar-gentle-0.4": ("torque", "peak", 9.844587722),
    "four-bar-steady": ("shaking_moment", "peak", 9.604799),
    "four-bar-even": ("torque", "rms", 13.874490),
}
# spec, trajectory: duration [s]
DURATIONS = {
    ("3rrr", "force"): 0.100625514047,
    ("3rrr", "force-torque"): 0.100625514047,
    ("3rrr", "force-moment"): 0.1044812645,
    ("3rrr", "torque"): 0.101440934032,
    ("3rrr", "moment"): 0.0887504790,
    ("3rrr", "com-force"): 0.1,
    ("5r", "torque"): 0.301490853880,
    ("rr", "torque"): 0.382081023152,
}


class MotionLaws(Case):
    def assert_near(self, found, known, what):
        self.assertLessEqual(abs(found - known), TOLERANCE * abs(known), f"{what}: {found!r} instead of {known!r}")

    def test_figures(self):
        done = run("batch", os.path.join(SUITES, "motion-laws.yaml"), "-o", self.path("out"), "--metrics-only", "-q")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open(self.path("out/summary.json"), encoding="utf-8") as file:
            cases = {case["name"]: case for case in json.load(file)["cases"]}
        for name, (quantity, figure, known) in FIGURES.items():
            metrics = {metric["quantity"]: metric for metric in cases[name]["metrics"]}
            self.assert_near(metrics[quantity][figure], known, f"{figure} of {quantity}, {name}")

    def test_durations(self):
        for (spec, trajectory), known in DURATIONS.items():
            done = run("simulate", os.path.join(SUITES, "motion-laws", f"{spec}.yaml"), "-t", trajectory, "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assert_near(json.loads(done.stdout)["found_law"]["duration"], known, f"{spec}, {trajectory}")

    def test_phase_plane(self):
        """A spec in place of a result, its script the same from the result's file; a run without limits has its law alone."""
        spec = os.path.join(SUITES, "motion-laws", "3rrr.yaml")
        script = run("plot", f"{spec}:force-moment", "--phase", "--script")
        self.assert_quiet_success(script)
        done = run("simulate", spec, "-t", "force-moment", "-o", self.path("run.h5"), "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(run("plot", self.path("run.h5"), "--phase", "--script").stdout, script.stdout)
        self.assertIn("'shaking_moment'", script.stdout)
        alone = run("plot", f"{spec}:cycloid", "--phase", "--script")
        self.assert_quiet_success(alone)
        self.assertNotIn("within the limits", alone.stdout)
        self.assert_failure(run("plot", f"{spec}:nowhere", "--phase", "--script"), 2, "nowhere")


if __name__ == "__main__":
    unittest.main()
