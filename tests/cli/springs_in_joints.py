"""Springs in joint coordinates: `springs: {t: {joint: J, stiffness: 3, rest: 0.2}}`."""

import json
import math
import os
import unittest

import h5py
import numpy

from _program import CONFIGS, Case, run

G = 9.81
PENDULUM = """\
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0]}}}}
bodies: {{link: {{mass: 2, com: [0.3, 0], inertia: 0.05, points: {{A: [0, 0]}}}}}}
joints: {{J: {{type: revolute, connects: [ground.O, link.A]}}}}
springs: {{t: {spring}}}
actuators: [J]
trajectories:
  turns: {{law: cycloidal, drive: joints, duration: 1, samples: 401, from: {{joints: {{J: -0.5}}}}, to: {{joints: {{J: 13}}}}}}
{tail}
"""
SLIDE = """\
space: planar
units: {{length: mm, angle: deg}}
ground: {{points: {{O: [0, 0]}}}}
bodies: {{block: {{mass: 3, com: [0, 0], inertia: 1, points: {{A: [0, 0]}}}}}}
joints: {{S: {{type: prismatic, connects: [ground.O, block.A], axis: [1, 0]}}}}
springs: {{t: {spring}}}
actuators: [S]
trajectories:
  there: {{law: cycloidal, drive: joints, duration: 1, samples: 401, from: {{joints: {{S: -50}}}}, to: {{joints: {{S: 150}}}}}}
"""


class SpringsInJoints(Case):
    def simulate(self, text, *arguments):
        spec, out = self.write("spec.yaml", text), self.path("out.h5")
        done = run("simulate", spec, "-o", out, "--force", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(out) as file:
            return {name: numpy.array(file[name]) for name in file if isinstance(file[name], h5py.Dataset)}

    def design(self, spec, *arguments):
        done = run("design", spec, "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_a_torsion_spring_pulls_back_over_several_turns(self):
        """J q'' + m g c cos q + k (q - rest), in both formulations; twice round, no angle is taken for a smaller one."""
        for formulation in ("tree", "natural"):
            got = self.simulate(PENDULUM.format(spring="{joint: J, stiffness: 3, rest: 0.2}", tail=""),
                                "--formulation", formulation)
            q, ddq = got["joint_position"][:, 0], got["joint_acceleration"][:, 0]
            expected = (0.05 + 2 * 0.3**2) * ddq + 2 * G * 0.3 * numpy.cos(q) + 3 * (q - 0.2)
            self.assertLess(abs(got["torque"][:, 0] - expected).max(), 1e-11 * abs(expected).max())
            stored = 2 * G * 0.3 * numpy.sin(q) + 1.5 * q**2 - 0.6 * q
            self.assertLess(abs(got["potential_energy"] - stored).max(), 1e-12 * abs(stored).max())

    def test_a_preload_is_the_stiffness_times_the_rest(self):
        by_rest, by_preload = (self.simulate(PENDULUM.format(spring=spring, tail=""))["torque"] for spring in (
            "{joint: J, stiffness: 3, rest: 0.2}", "{joint: J, stiffness: 3, preload: 0.6}"))
        self.assertLess(abs(by_rest - by_preload).max(), 1e-13 * abs(by_rest).max())

    def test_units_are_those_of_the_coordinate(self):
        """In millimetres and degrees: 2 per millimetre are 2000 N/m as forces are kg mm/s^2 = 1e-3 N, so 2 N/m."""
        got = self.simulate(SLIDE.format(spring="{joint: S, stiffness: 2, rest: 30}"))
        q, ddq = got["joint_position"][:, 0], got["joint_acceleration"][:, 0]
        self.assertLess(abs(got["torque"][:, 0] - 3 * ddq - 2 * (q - 0.03)).max(), 1e-11)
        turned = PENDULUM.format(spring="{joint: J, stiffness: 2, rest: 30}", tail="units: {angle: deg}")
        turned = turned.replace("-0.5", "-30").replace("13}", "700}")
        got = self.simulate(turned)
        q, ddq = got["joint_position"][:, 0], got["joint_acceleration"][:, 0]
        expected = (0.05 + 2 * 0.3**2) * ddq + 2 * G * 0.3 * numpy.cos(q) + math.degrees(2) * (q - math.radians(30))
        self.assertLess(abs(got["torque"][:, 0] - expected).max(), 1e-11 * abs(expected).max())

    def test_both_formulations_agree_on_loops_with_springs_in_every_joint(self):
        for name, springs in (("four-bar.yaml", "AB"), ("slider-crank.yaml", "AB"), ("5r.yaml", "ABC")):
            with open(os.path.join(CONFIGS, name), encoding="utf-8") as file:
                text = file.read()
            joints = [line.split(":")[0].strip() for line in text[text.index("joints:"):].splitlines()[1:]
                      if "connects" in line]
            entries = ", ".join(f"t{k}: {{joint: {joint}, stiffness: {2 + k}, preload: {0.5 - k}}}"
                                for k, joint in enumerate(joints))
            spec = self.write(name, text + f"\nsprings: {{{entries}}}\n")
            done = run("check", spec, "--verify")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_parts_of_a_torque_name_the_spring(self):
        got = self.simulate(PENDULUM.format(spring="{joint: J, stiffness: 3, rest: 0.2}", tail=""), "--split")
        expected = 3 * (got["joint_position"] - 0.2)
        self.assertLess(abs(got["torque_spring"] - expected).max(), 1e-12 * abs(expected).max())

    def test_stiffness_and_preload_of_an_arm_are_lines_through_its_weight(self):
        """Of either joint the best line through the weight's torques over the poses; the design proves it is the best."""
        told = self.design(os.path.join(CONFIGS, "torsion-spring-arm.yaml"))
        self.assertEqual(told["optimality"], "proved-best")
        found = {number["path"]: number["value"] for number in told["free_numbers"]}
        left = 0
        for joint, angles, weight in self.arm():
            slope, at_zero = numpy.polyfit(angles, weight, 1)
            self.assertAlmostEqual(found[f"springs.{joint}.stiffness"], -slope, delta=2e-6 * abs(slope))
            self.assertAlmostEqual(found[f"springs.{joint}.preload"], at_zero, delta=2e-6 * abs(at_zero))
            left += math.sqrt(numpy.mean((weight - slope * angles - at_zero)**2))
        self.assertAlmostEqual(told["objective"]["value"], left, delta=1e-9 * left)

    def test_of_two_springs_the_better_one_is_kept(self):
        """The other one goes with its preload."""
        with open(os.path.join(CONFIGS, "torsion-spring-arm.yaml"), encoding="utf-8") as file:
            spec = self.write("choose.yaml", file.read() + "  choose: {springs: 1}\n")
        told, out = self.design(spec, "-o", self.path("out.yaml")), self.path("out.yaml")
        with_none, with_own = [], []
        for _, angles, weight in self.arm():
            slope, at_zero = numpy.polyfit(angles, weight, 1)
            with_own.append(math.sqrt(numpy.mean((weight - slope * angles - at_zero)**2)))
            with_none.append(math.sqrt(numpy.mean(weight**2)))
        best = min(with_own[0] + with_none[1], with_none[0] + with_own[1])
        self.assertEqual(told["optimality"], "proved-best")
        self.assertAlmostEqual(told["objective"]["value"], best, delta=1e-7 * best)
        with open(out, encoding="utf-8") as file:
            self.assertNotIn("t2:", file.read())

    def arm(self):
        """Of each spring: the joint's angles and what the weight asks of it, over the poses of the workspace."""
        first, second = numpy.meshgrid(numpy.linspace(0.2, 2, 10), numpy.linspace(0, 1.2, 7), indexing="ij")
        fore = 1.4 * G * 0.12 * numpy.cos(first + second)
        upper = (2.1 * 0.14 + 1.4 * 0.3) * G * numpy.cos(first) + fore
        return ("t1", first.ravel(), upper.ravel()), ("t2", second.ravel(), fore.ravel())

    def test_conditions_ask_a_spring_in_a_joint_to_vanish(self):
        """No line in an angle is a cosine of it; a scotch yoke's slide is one, and springs balance each other there."""
        spec = self.write("pendulum.yaml", PENDULUM.format(spring="{joint: J, stiffness: 3, rest: 0.2}", tail=""))
        done = run("conditions", spec, "--goal", "static", "--json")
        rows = json.loads(done.stdout)["conditions"]
        self.assertEqual(len(rows), 4)  # the weight's sine and cosine, stiffness and preload

    def test_a_parts_springs_are_in_the_parts_joints(self):
        self.write("leg.yaml", PENDULUM.format(spring="{joint: J, stiffness: 3, rest: 0.2}", tail=""))
        whole = self.write("whole.yaml", """\
space: planar
gravity: [0, -9.81]
include:
  - {file: leg.yaml, as: [L1, L2]}
trajectories:
  both: {law: cycloidal, drive: joints, duration: 1, samples: 11, from: {joints: {L1.J: 0, L2.J: 0}}, to: {joints: {L1.J: 1, L2.J: 1}}}
""")
        done = run("simulate", whole, "-o", self.path("whole.h5"), "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(self.path("whole.h5")) as file:
            torque = numpy.array(file["torque"])
        alone = self.simulate(PENDULUM.format(spring="{joint: J, stiffness: 3, rest: 0.2}", tail="").replace(
            "-0.5}", "0}").replace("13}", "1}").replace("401", "11"))["torque"]
        for k in range(2):
            self.assertLess(abs(torque[:, k] - alone[:, 0]).max(), 1e-12 * abs(alone).max())

    def test_conditions_give_stiffness_and_preload_in_their_units(self):
        """What a torsion spring leaves: k in N m/rad, but its preload k rest is a moment."""
        spec = self.write("spring.yaml", PENDULUM.format(spring="{joint: J, stiffness: 3, rest: 0.2}", tail=""))
        text = " ".join(run("conditions", spec, "--goal", "static").stdout.split())
        self.assertIn("spring t (k = 3 N m/rad, preload = 0.6 N m)", text)
        spec = self.write("slide.yaml", SLIDE.format(spring="{joint: S, stiffness: 2, preload: 40}"))
        text = " ".join(run("conditions", spec, "--goal", "static", "--units", "si").stdout.split())
        self.assertRegex(text, r"spring t \(k = [^ ]+ N/m, preload = [^ ]+ N\)")


if __name__ == "__main__":
    unittest.main()
