"""A design exists: what `balance design -o` writes passes `check` and has the figures that were claimed, whatever the way it was found."""

import json
import os
import random
import unittest

from _designed import complaints_about
from _program import CONFIGS, Case, run

# One for every way of searching; all of configs with five seeds: scripts/soak designs.
SAMPLE = {
    "5r-design.yaml": (),
    "5r-impossible.yaml": (),
    "rr-adaptive.yaml": (),
    "rr-design.yaml": (),
    "scara-design.yaml": (),
    "slider-crank-force-balance.yaml": (),
    "spatial-rrr-design.yaml": (),
    "spring-balancer-one-link.yaml": (),
    "torsion-spring-arm.yaml": (),
}

# A wrist whose middle body is inertia to be chosen, a disc's ratio besides: no numbers decouple it.
WRIST = """
name: wrist
space: spatial
gravity: [0, 0, -9.81]
parameters: {{Jy: {{free: [0.01, 1], start: {start}}}, x: {{free: [-1, 1], start: 0.1}}, r: {{free: [-20, -1]}}}}
ground: {{points: {{O: [0, 0, 0]}}}}
bodies:
  b1: {{mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1], points: {{A: [0, 0, 0]}}}}
  b2: {{mass: {mass}, com: [0, x, 0], inertia: [{Jx}, Jy, {Jz}], points: {{A: [0, 0, 0], B: [0, 0.4, 0]}}}}
  b3: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.017, 0.017], points: {{A: [0, 0, 0]}}}}
joints:
  T1: {{type: revolute, connects: [ground.O, b1.A], axis: [0, 0, 1]}}
  T2: {{type: revolute, connects: [b1.A, b2.A], axis: [1, 0, 0]}}
  T3: {{type: revolute, connects: [b2.B, b3.A], axis: [1, 0, 0]}}
discs: {{d: {{body: b2, at: A, follows: T3, ratio: r, inertia: {{axial: 0.004, transverse: 0.002}}}}}}
actuators: [T1, T2, T3]
tool: b3.A
motion: {{duration: 1, samples: 21, from: {{joints: {{T1: 0, T2: 0.3, T3: 0}}}}, to: {{joints: {{T1: 1, T2: -0.8, T3: 1}}}}}}
design: {{goal: {goal}}}
"""

# A rotor with two planes of correction, which meet the goal and leave no moment.
ROTOR = """
name: rotor
space: spatial
ground: {points: {O: [0, 0, 0]}}
bodies: {shaft: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1], points: {O: [0, 0, 0]}}}
joints: {S: {type: revolute, connects: [ground.O, shaft.O], axis: [0, 0, 1]}}
actuators: [S]
payloads: {W: {body: shaft, at: [9, 0, -10], mass: 200}}
counterweights:
  B1: {body: shaft, at: [-15, 0, 0], mass: {free: [0, 500]}}
  Bm: {body: shaft, at: [15, 0, 50], mass: {free: [0, 500]}}
motion: {duration: 0.2, samples: 201}
trajectories: {turn: {law: uniform, drive: joints, from: {joints: {S: 0}}, to: {joints: {S: 6.283185307179586}}}}
design: {goal: force, minimize: {rms: shaking_moment, along: turn}}
"""

ARM = """
name: arm
space: planar
gravity: [0, -9.81]
parameters: PARAMETERS
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 2, com: [0.3, 0], inertia: 0.05, points: {A: [0, 0], B: [0.6, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
counterweights: {cw: {body: link, at: [PLACE, 0], mass: MASS}}
actuators: [J]
tool: link.B
design: DESIGN
"""


def arm(parameters="{}", place="-0.2", mass="{free: [0, 50]}", design="{goal: static}"):
    return ARM.replace("PARAMETERS", parameters).replace("PLACE", place).replace("MASS", mass).replace("DESIGN", design)


class Written(Case):
    def assert_exists(self, spec, *options):
        self.assertEqual(complaints_about(spec, self.path("designed.yaml"), *options), [], spec)

    def design(self, text, *options, code=0):
        done = run("design", self.write("spec.yaml", text), "--json", *options)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout[:300])
        return json.loads(done.stdout)

    def before(self, text):
        return {n["path"]: (n["before"], n["before_from"]) for n in self.design(text)["free_numbers"]}

    def test_what_is_written_is_what_was_claimed(self):
        for name, options in SAMPLE.items():
            with self.subTest(name):
                self.assert_exists(os.path.join(CONFIGS, name), "--seed", "2", *options)

    def test_the_middle_of_a_front_too(self):
        self.assert_exists(os.path.join(CONFIGS, "four-bar-front.yaml"), "--point", "middle", "--seconds", "2")

    def test_compromises_are_bodies_that_can_be_made(self):
        draw = random.Random(31)
        for goal in ("decoupled", "gyroscopic", "static"):
            values = {"goal": goal, "mass": round(draw.uniform(0.5, 3), 3), "Jx": round(draw.uniform(0.2, 0.6), 3)}
            values["Jz"] = round(draw.uniform(0.02, 0.2), 3)
            values["start"] = round(values["Jx"] + draw.uniform(-0.9, 0.9) * values["Jz"], 4)
            with self.subTest(**values):
                self.assert_exists(self.write("wrist.yaml", WRIST.format(**values)), "--seconds", "2")

    def test_a_figure_that_cannot_be_negative_has_no_negative_bound(self):
        answer = self.design(ROTOR)
        # of 200 kg at 10 m: what cancels is round-off, and no rms is below none
        self.assertEqual(answer["objective"]["value"], 0)
        self.assertEqual(answer["objective"]["lower_bound"], 0)
        self.assertEqual(answer["optimality"], "proved-best")

    def test_where_nothing_is_to_be_balanced_nothing_changes(self):
        done = run("design", os.path.join(CONFIGS, "four-bar-dynamic.yaml"), "-g", "static", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        for number in json.loads(done.stdout)["free_numbers"]:
            self.assertEqual(number["value"], number["before"], number)

    # what "before" is

    def test_a_ratio_may_start_at_zero_where_a_free_parameter_changes_it(self):
        text = ("space: planar\nparameters: {r: {free: [-3, 3]}}\nground: {points: {O: [0, 0]}}\n"
                "bodies: {link: {mass: 2, com: [0.3, 0], inertia: 0.05, points: {A: [0, 0]}}}\n"
                "joints: {J: {type: revolute, connects: [ground.O, link.A]}}\nactuators: [J]\n"
                "discs: {d: {body: ground, at: O, follows: J, ratio: RATIO, inertia: 0.01}}\n")
        self.assertEqual(run("check", self.write("free.yaml", text.replace("RATIO", "r"))).returncode, 0)
        self.assert_failure(run("check", self.write("zero.yaml", text.replace("RATIO", "0"))), 3, "a ratio other than 0")

    def test_a_parameter_that_feeds_added_amounts_alone_starts_at_none(self):
        for mass in ("m", "2 * m", "half"):
            with self.subTest(mass):
                text = arm("{m: {free: [0, 50]}, half: m / 2}", mass=mass)
                self.assertEqual(self.before(text)["parameters.m"], (0, "none"))
        self.assertEqual(self.before(arm("{m: {free: [0, 50], start: 3}}", mass="m"))["parameters.m"], (3, "start"))

    def test_another_parameter_starts_in_the_middle_and_that_is_said(self):
        text = arm("{m: {free: [0, 50]}}", place="-0.2 - m / 1000", mass="m")
        self.assertEqual(self.before(text)["parameters.m"], (25, "middle"))
        told = run("design", self.write("spec.yaml", text)).stdout
        self.assertIn("before: in the middle of the bounds, without a 'start': parameters.m\n", told)
        # at 0 the other expression has no value
        text = arm("{m: {free: [0, 50]}}", mass="m + 0 / m")
        self.assertEqual(self.before(text)["parameters.m"], (25, "middle"))

    # designs without a motion, and without a goal

    def test_a_batch_ends_with_the_design_of_a_mechanism_without_a_motion(self):
        self.write("arm.yaml", arm())
        suite = self.write("suite.yaml", "name: s\ncases: {one: {spec: arm.yaml, design: true}}\n")
        done = run("batch", suite, "-o", self.path("out"))
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path("out/summary.json"), encoding="utf-8") as file:
            case = json.load(file)["cases"][0]
        self.assertEqual((case["status"], case["design"]["status"]), ("done", "balanced"))

    def test_a_report_shows_a_design_without_a_goal(self):
        motion = ("motion: {duration: 1, samples: 21, from: {joints: {J: 0}}, to: {joints: {J: 1}}}\n"
                  "trajectories: {t: {law: cycloidal, drive: joints}}\n")
        spec = self.write("arm.yaml", arm(design="{minimize: {rms: torque}}") + motion)
        done = run("report", spec, "-o", self.path("arm.html"), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(json.loads(done.stdout)["design"])


if __name__ == "__main__":
    unittest.main()
