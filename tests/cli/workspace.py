"""`workspace:` and `minimize: {rms: torque, over: workspace}`: figures at rest over a box of poses."""

import json
import math
import os
import unittest

from _program import CONFIGS, Case, run

SPEC = os.path.join(CONFIGS, "spring-balancer-workspace.yaml")

ARM = """space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0]}}}}
bodies:
  a: {{mass: 5, com: [0.25, 0], inertia: 0.1, points: {{O: [0, 0], E: [0.5, 0]}}}}
  b: {{mass: 3, com: [0.15, 0], inertia: 0.05, points: {{O: [0, 0], E: [0.3, 0]}}}}
joints:
  A: {{type: revolute, connects: [ground.O, a.O]}}
  B: {{type: revolute, connects: [a.E, b.O]}}
assembly: {{A: 0.2, B: 1}}
counterweights: {{c: {{body: a, at: [-0.2, 0], mass: {{free: [0, 20]}}}}}}
actuators: [A, B]
tool: b.E
workspace: {box}
design: {{{design}}}
"""
REACH = "{tool: [[0.3, 0.6], [0, 0.4]], samples: [4, 5]}"


def poses():
    """The angles of both links from the horizontal at the twenty poses, by the law of cosines; the elbow turns left."""
    for i in range(4):
        for j in range(5):
            x, y = 0.3 + 0.1 * i, 0.1 * j
            square = x * x + y * y
            bend = math.acos((square - 0.34) / 0.3)
            first = math.atan2(y, x) - math.atan2(0.3 * math.sin(bend), 0.5 + 0.3 * math.cos(bend))
            yield first, first + bend


def weight(first, second):
    """What motor A holds without the counterweight, and what a kilogram of that takes off."""
    return 9.81 * ((5 * 0.25 + 3 * 0.5) * math.cos(first) + 3 * 0.15 * math.cos(second)), 9.81 * 0.2 * math.cos(first)


class Workspace(Case):
    def design(self, spec, *arguments):
        done = run("design", spec, "--json", *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads(done.stdout)

    def arm(self, design, box=REACH):
        return self.write("arm.yaml", ARM.format(box=box, design=design))

    def test_a_stiffness_is_a_linear_least_squares_problem(self):
        """Every pose counts the same: k = Σ g t / Σ t², with the weight's torque g and the spring's t per unit of stiffness."""
        pairs = []
        for i in range(23):
            q = -1 + 2.2 * i / 22
            length = math.sqrt(0.3**2 + 0.1**2 - 2 * 0.3 * 0.1 * math.sin(q))
            pairs.append((2 * 9.81 * 0.2 * math.cos(q), (1 - 0.05 / length) * 0.3 * 0.1 * math.cos(q)))
        stiffness = sum(g * t for g, t in pairs) / sum(t * t for _, t in pairs)
        told = self.design(SPEC)
        self.assertEqual(told["optimality"], "proved-best")
        self.assertAlmostEqual(told["free_numbers"][0]["value"], stiffness, delta=1e-6 * stiffness)
        rms = math.sqrt(sum((g - stiffness * t) ** 2 for g, t in pairs) / len(pairs))
        self.assertAlmostEqual(told["objective"]["value"], rms, delta=1e-9)

    def test_a_counterweight_over_a_box_of_the_tool(self):
        pairs = [weight(*pose) for pose in poses()]
        mass = sum(g * t for g, t in pairs) / sum(t * t for _, t in pairs)
        told = self.design(self.arm('minimize: {rms: "torque[A]", over: workspace}'))
        self.assertEqual(told["optimality"], "proved-best")
        self.assertAlmostEqual(told["free_numbers"][0]["value"], mass, delta=1e-6 * mass)
        rms = math.sqrt(sum((g - mass * t) ** 2 for g, t in pairs) / 20)
        self.assertAlmostEqual(told["objective"]["value"], rms, delta=1e-8)

    def test_the_mean_and_the_peak_are_those_of_the_poses(self):
        torques = [abs(weight(*pose)[0]) for pose in poses()]
        for figure, value in (("mean", sum(torques) / 20), ("peak", max(torques))):
            spec = self.arm(f'minimize: {{{figure}: "torque[A]", over: workspace}}')
            with open(spec, encoding="utf-8") as file:
                text = file.read().replace("at: [-0.2, 0]", "at: [0, 0]")  # on the joint, where it changes nothing
            told = self.design(self.write("plain.yaml", text))
            self.assertAlmostEqual(told["objective"]["value"], value, delta=1e-8 * value)

    def test_a_limit_over_the_workspace(self):
        """At the least mass that keeps the peak, the worst pose is at the limit."""
        told = self.design(self.arm('minimize: added-mass, subject_to: "peak(torque[A], workspace) <= 12"'))
        pairs = [weight(*pose) for pose in poses()]
        mass = max((g - 12) / t for g, t in pairs)
        self.assertAlmostEqual(told["free_numbers"][0]["value"], mass, delta=1e-6 * mass)
        self.assertEqual(told["optimality"], "proved-best")

    def test_a_motion_that_takes_no_time_asks_for_no_more_than_rest(self):
        """Inertia, dry and viscous friction do not count at rest."""
        spec = self.arm('minimize: {rms: "torque[A]", over: workspace}')
        with open(spec, encoding="utf-8") as file:
            text = file.read()
        plain = self.design(spec)
        rubbing = self.design(self.write("rubbing.yaml", text.replace("inertia: 0.1", "inertia: 7") +
                                         "friction: {A: {coulomb: 3, viscous: 2}}\n"))
        self.assertAlmostEqual(plain["objective"]["value"], rubbing["objective"]["value"], delta=1e-9)

    def test_a_box_beyond_the_reach_is_refused_with_the_place(self):
        done = run("design", self.arm("minimize: {rms: torque, over: workspace}",
                                      "{tool: [[0.3, 0.9], [0, 0.4]], samples: [4, 5]}"))
        self.assertEqual(done.returncode, 4)
        self.assertIn("'workspace' cannot be followed", done.stderr)
        self.assertIn("configuration: A ", done.stderr)

    def test_attachments_and_a_free_length_are_searched(self):
        """The shorter the spring when free and the higher its end, the better: with a free length of zero balance is exact."""
        with open(SPEC, encoding="utf-8") as file:
            text = file.read()
        fixed = self.design(SPEC)["objective"]["value"]
        text = text.replace("S: [0, 0.3]", "S: [0, {free: [0.2, 0.5]}]").replace("0.05}", "{free: [0, 0.1]}}")
        told = self.design(self.write("free.yaml", text))
        self.assertLess(told["objective"]["value"], 1e-3 * fixed)

    def test_the_written_spec_says_the_same(self):
        written = self.path("out.yaml")
        told = self.design(SPEC, "-o", written)
        done = run("simulate", written, "--trajectory", "workspace", "--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        run_told = json.loads(done.stdout)
        rms = [m["rms"] for m in run_told["metrics"] if m["quantity"] == "torque[J]"]
        self.assertAlmostEqual(rms[0], told["objective"]["value"], delta=1e-9)


if __name__ == "__main__":
    unittest.main()
