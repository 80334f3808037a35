"""Joints of the type `rolling` in the plane, held against closed forms."""

import json
import math
import os
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, run

DISC = os.path.join(CONFIGS, "rolling-disc.yaml")
R, E, M, SLOPE, INERTIA, G = 0.1, 0.04, 1.2, 0.2, 0.005, 9.81

# A carriage on two wheels of different inertias; a motor in the hub of the rear one.
CARRIAGE = """
space: planar
gravity: [0, -9.81]
parameters: {r: 0.2}
ground: {points: {A: [0, 0], B: [1, 0]}}
bodies:
  rear: {mass: 2, com: [0, 0], inertia: 0.05, points: {C: [0, 0]}}
  front: {mass: 1, com: [0, 0], inertia: 0.02, points: {C: [0, 0]}}
  carriage: {mass: 10, com: [0.4, 0.1], inertia: 1, points: {A: [0, 0], B: [1, 0]}}
joints:
  A: {type: rolling, connects: [ground.A, rear.C], radius: r}
  B: {type: rolling, connects: [ground.B, front.C], radius: r}
  hub: {type: revolute, connects: [carriage.A, rear.C]}
  axle: {type: revolute, connects: [carriage.B, front.C]}
actuators: [hub]
tool: carriage.A
motion: {duration: 1, samples: 41, from: {joints: {hub: 0}}, to: {joints: {hub: -3}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""

# The wheel turns twice as fast as the crank, by a belt.
BELT = """
space: planar
ground: {points: {O: [0, 1], P: [0, 0]}}
bodies:
  crank: {mass: 1, com: [0, 0], inertia: 0.3, points: {A: [0, 0]}}
  wheel: {mass: 2, com: [0, 0], inertia: 0.05, points: {C: [0, 0]}}
joints:
  J: {type: revolute, connects: [ground.O, crank.A]}
  W: {type: rolling, connects: [ground.P, wheel.C], radius: 0.2, axis: [0, -1], angle: 0.3}
couplings: [{joint: W.angle, follows: J, ratio: 2}]
actuators: [J]
motion: {duration: 1, samples: 21, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""


class Rolling(Case):
    def simulated(self, spec, trajectory):
        file = self.path("run.h5")
        done = run("simulate", spec, "-t", trajectory, "-o", file, "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file, "r") as results:
            found = {}
            results.visititems(lambda name, node: found.__setitem__(name.split("/")[-1], np.array(node))
                               if isinstance(node, h5py.Dataset) and node.dtype.kind == "f" else None)
        return found

    def close(self, found, expected, scale):
        self.assertLess(np.abs(np.asarray(found) - expected).max(), 1e-12 * scale)

    def agree(self, spec):
        """Tree and natural coordinates find the same."""
        done = run("check", spec, "--verify")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("both formulations agree", done.stdout)

    def test_a_disc_with_an_eccentric_mass_on_an_incline(self):
        """With s the slope, T = (I + m (r^2 + e^2 + 2 r e sin(q + s))) q'^2 / 2 and V = m g (r q sin s + e sin q)."""
        for trajectory in ("steady", "cycloid"):
            run_ = self.simulated(DISC, trajectory)
            q, dq, ddq = (run_[name][:, 1] for name in ("joint_position", "joint_velocity", "joint_acceleration"))
            inertia = INERTIA + M * (R**2 + E**2 + 2 * R * E * np.sin(q + SLOPE))
            half_slope = M * R * E * np.cos(q + SLOPE)
            torque = inertia * ddq + half_slope * dq**2 + M * G * (R * math.sin(SLOPE) + E * np.cos(q))
            self.close(run_["torque"].ravel(), torque, np.abs(torque).max())
            energy = inertia * dq**2 / 2
            self.close(run_["kinetic_energy"].ravel(), energy, energy.max())
            height = R * math.cos(SLOPE) + R * q * math.sin(SLOPE) + E * np.sin(q)
            self.close(run_["potential_energy"].ravel(), M * G * height, M * G)
            # d(T + V)/dt is the motor's power
            rate = inertia * dq * ddq + half_slope * dq**3 + M * G * (R * math.sin(SLOPE) + E * np.cos(q)) * dq
            self.close(run_["power"].ravel(), rate, np.abs(rate).max())

    def test_the_contact_force_acts_where_the_wheel_touches(self):
        """What the ground does beside the motor has no moment about the contact point, which has no velocity."""
        run_ = self.simulated(DISC, "cycloid")
        force, moment = run_["joint_force"].reshape(-1, 2), run_["joint_moment"].ravel()
        normal = np.array([math.sin(SLOPE), math.cos(SLOPE)])
        contact = -R * (normal[0] * force[:, 1] - normal[1] * force[:, 0])
        self.close(moment - run_["torque"].ravel(), contact, M * G * R)
        along = np.array([math.cos(SLOPE), -math.sin(SLOPE)])
        q, rate = run_["joint_position"][:, 1], run_["joint_velocity"][:, 1]
        from_com = np.column_stack([E * np.sin(q), -E * np.cos(q)]) + R * along  # the rim at the contact
        self.close(run_["com_velocity"].reshape(-1, 2) + rate[:, None] * from_com, 0, 1)

    def test_the_formulations_agree(self):
        self.agree(DISC)
        self.agree(self.write("carriage.yaml", CARRIAGE))
        self.agree(self.write("belt.yaml", BELT))

    def test_a_carriage_is_as_heavy_as_its_wheels_make_it(self):
        """u = -(m r + (I1 + I2) / r) a, wherever the carriage's centre of mass is."""
        run_ = self.simulated(self.write("carriage.yaml", CARRIAGE), "go")
        acceleration = run_["com_acceleration"][:, 0]
        torque = -(13 * 0.2 + 0.07 / 0.2) * acceleration
        self.close(run_["torque"].ravel(), torque, np.abs(torque).max())
        self.close(run_["tool_position"][:, 1], 0.2, 1)

    def test_a_belt_turns_a_wheel(self):
        """u = (I1 + 4 (I2 + m r^2)) q''; a wheel to the left of a line down lies to its right in the plane."""
        run_ = self.simulated(self.write("belt.yaml", BELT), "go")
        torque = (0.3 + 4 * (0.05 + 2 * 0.2**2)) * run_["joint_acceleration"][:, 0]
        self.close(run_["torque"].ravel(), torque, np.abs(torque).max())
        # down the line as it turns clockwise, so up here; its centre of mass is the wheel's with the crank's at rest
        travel = 0.2 * 2 * run_["joint_position"][:, 0]
        expected = np.column_stack([np.full_like(travel, 2 * 0.2 / 3), (1 + 2 * travel) / 3])
        self.close(run_["com_position"].reshape(-1, 2), expected, 1)

    def test_two_motors_of_one_freedom_share_the_work(self):
        """Of least norm, a force counting as its moment on the mechanism's length, which is r here: u2 = -u1 / r, in both formulations."""
        with open(DISC, encoding="utf-8") as file:
            spec = self.write("two.yaml", file.read().replace("[roll.angle]", "[roll.angle, roll.slide]"))
        self.agree(spec)
        run_ = self.simulated(spec, "cycloid")
        self.close(run_["torque"][:, 1], -run_["torque"][:, 0] / R, 10)

    def test_the_rank_of_its_conditions(self):
        """Static on level ground: the centre of mass in the centre; on a slope the mass does work, too. The force is zero without mass only."""
        for slope, goal, rank in ((0, "static", 2), (0.2, "static", 3), (0, "force", 3), (0.2, "force", 3)):
            done = run("conditions", DISC, "--goal", goal, "--set", f"slope={slope}", "--json")
            self.assertEqual(json.loads(done.stdout)["rank"], rank, (slope, goal))

    def test_formulas_are_those_of_the_disc(self):
        done = run("equations", DISC, "--only", "inertia,gravity")
        self.assert_quiet_success(done)
        self.assertIn("D11 = Jz1 + m (r^2 + e^2) - 2 m r e cos(alpha2) sin(alpha3 - roll_angle)", done.stdout)
        self.assertIn("r = 0.1", done.stdout)

    def test_a_free_radius_is_designed(self):
        """The least torque on the way is that of the least radius: there the inertia and the weight's arm are least."""
        with open(DISC, encoding="utf-8") as file:
            text = file.read().replace("r: 0.1,", "r: {free: [0.08, 0.2], start: 0.15},")
        text += "\ndesign:\n  minimize: {rms: torque, along: cycloid}\n"
        done = run("design", self.write("free.yaml", text), "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        number = json.loads(done.stdout)["free_numbers"][0]
        self.assertAlmostEqual(number["value"], 0.08, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
