#!/usr/bin/env python3
"""The reference against what is known by hand: numbers and closed forms of the papers and of the textbooks."""
import functools
import math
import os
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "cli")]

import numpy as np

from conditions import configurations, derive, every_name, values
from drive import Drive, follow, jacobian
from mechanism import Mechanism
from reference import Balance, at_indices
from _sampling import draw, traits_of

CONFIGS = os.path.join(HERE, "..", "..", "configs")


@functools.cache
def follow_once(config, trajectory, indices):
    return at_indices(os.path.join(CONFIGS, config + ".yaml"), trajectory, indices)["samples"]


def run(config, trajectory, indices=None):
    return follow_once(config, trajectory, indices and tuple(indices))


def numbers(config, *expressions):
    spec = Mechanism(os.path.join(CONFIGS, config + ".yaml")).spec
    return [spec.number(e) for e in expressions]


class Published(unittest.TestCase):
    def near(self, found, expected, tolerance):
        np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance)

    def test_the_3rrr_meets_the_numbers_of_two_earlier_formulations(self):
        start, middle, end = run("3rrr", "cycloid", [0, 300, 1000])
        self.near(start["com_position"], [-0.0669026392, -0.0386231395], 1e-10)   # ten digits are known
        self.near(end["com_position"], [0.0564875650, 0.0511127906], 1e-10)
        self.near(middle["torque"], [-64.97649026082, -32.09674328625, 103.2428123385], 1e-9)
        self.near(middle["shaking_force"], [661.6027130426, 433.8951170309], 1e-9)
        self.near(middle["shaking_moment"], [-4.490699595200], 1e-9)

    def test_a_bang_bang_centre_of_mass_gives_the_3rrr_a_constant_force(self):
        for sample in run("3rrr", "bang-bang"):
            self.near(np.linalg.norm(sample["shaking_force"]), 549.2528818391, 1e-8)

    def test_the_centre_of_mass_of_the_redistributed_3rrr_moves_half_as_far_as_the_tool(self):
        samples = run("3rrr-redistributed", "tool-bang")
        for sample in samples:
            self.near(np.linalg.norm(sample["shaking_force"]), 360 * math.sqrt(1.25), 1e-8)
            moved = np.subtract(sample["com_position"], samples[0]["com_position"])
            self.near(moved, np.subtract(sample["tool_position"], samples[0]["tool_position"]) / 2, 1e-12)

    def test_redistributing_the_cranks_leaves_the_torques_alone(self):
        for one, other in zip(run("3rrr", "tool-bang"), run("3rrr-redistributed", "tool-bang")):
            self.near(one["torque"], other["torque"], 1e-9)

    def proportional(self, config, k, trajectories=("cycloid", "bang-bang")):
        for trajectory in draw(f"trajectories of {config}", trajectories, 0.5):
            for sample in run(config, trajectory):
                self.near(sample["torque"], np.multiply(k, sample["joint_acceleration"][:len(k)]), 1e-9)

    def test_the_balanced_planar_arm_feels_constant_inertias(self):
        # P1 eq. 28; discs 6 and 7 ride on link 1 at l1
        X2 = "(J2 + J3 + J4 + J6 + J7 + m3 * l2^2 * (1 + m3 / m2))"
        k = numbers("planar-rrr", "0.08 + J2 + J3 + J4 + J5 + J6 + J7 + (m2 + m6 + m7) * l1^2 + m3 * (l1^2 + l2^2)"
                    " + l1^2 * (m2 + m3 + m6 + m7)^2 / m1 + l2^2 * m3^2 / m2", f"{X2} + {X2}^2 / J5",
                    "(J3 + J6) * (J3 + J6 + J7) / J7")
        self.proportional("planar-rrr", k)

    def test_the_balanced_spatial_arm_feels_constant_inertias(self):
        # P1 eq. 39, corrected
        k = numbers("spatial-rrr", "0.03 + Jz2 + 0.008 + 0.0011 + 0.0026 + (m2 + 1.3) * l1^2 + m3 * (l1^2 + l2^2)"
                    " + l2^2 * m3^2 / m2",
                    "0.25 + Jx3 + Jx4 + Jx5 + m3 * l2^2 * (1 + m3 / m2)", "(Jx3 + Jx4) * (Jx3 + Jx4 + Jx5) / Jx5")
        self.proportional("spatial-rrr", k)

    def test_the_balanced_scara_feels_constant_inertias(self):
        # P1 eq. 49 with the slider at l2
        k = numbers("scara", "0.11 + J2 + J3 + J4 + J5 + X + (m2 + m3) * l1^2 + l1^2 * (m2 + m3)^2 / m1",
                    "(J2 + J3 + J4 + X) * (J2 + J3 + J4 + J5 + X) / J5", "m3")
        self.proportional("scara", k)

    def test_the_unbalanced_rr_arm_has_the_torques_of_p0(self):
        # P0 eq. 90, 92-94
        def p(e):
            return numbers("rr", e)[0]
        I1 = p("a2^2 * (1.5 * gamma2^2 + 0.5 + 0.5 * gamma4^2) + 0.02")
        I2 = p("a1^2 * (2 * gamma1^2 + 1 * gamma3^2 + 1.5 + 0.5 + 0.5) + 0.042")
        I3 = p("a1 * a2 * (1.5 * gamma2 - 0.5 * gamma4 + 0.5)")
        u1 = p("9.81 * a1 * (2 * gamma1 - 1 * gamma3 + 1.5 + 0.5 + 0.5)")
        u2 = p("9.81 * a2 * (1.5 * gamma2 - 0.5 * gamma4 + 0.5)")
        for trajectory in draw("trajectories of rr", ("cycloid", "joint-345", "bang-bang"), 0.3):
            for s in run("rr", trajectory):
                (q1, q2), (v1, v2), (a1, a2) = s["joint_position"], s["joint_velocity"], s["joint_acceleration"]
                c, n = math.cos(q2), math.sin(q2)
                weight2 = u2 * math.cos(q1 + q2)
                self.near(s["torque"], [
                    (I1 + I2 + 2 * c * I3) * a1 + (I1 + c * I3) * a2 - I3 * n * (v2 * v2 + 2 * v1 * v2)
                    + u1 * math.cos(q1) + weight2,
                    (I1 + c * I3) * a1 + I1 * a2 + I3 * n * v1 * v1 + weight2], 1e-9)

    def test_the_balanced_rr_arm_has_a_constant_inertia_matrix(self):
        # P0 eq. 96, 98
        I1, I2 = numbers("rr-balanced", "a2^2 * (m2 * gamma2^2 + cw2 * gamma4^2 + cargo) + 0.02",
                         "a1^2 * (m1 * gamma1^2 + cw1 * gamma3^2 + m2 + cargo + cw2) + 0.042")
        for trajectory in draw("trajectories of rr-balanced", ("cycloid", "bang-bang"), 0.5):
            for s in run("rr-balanced", trajectory):
                a1, a2 = s["joint_acceleration"]
                self.near(s["torque"], [(I1 + I2) * a1 + I1 * a2, I1 * (a1 + a2)], 1e-9)
                self.near(s["shaking_force"], [0, 0], 1e-9)

    def test_the_balanced_5r_has_no_gravity_and_no_velocity_terms(self):
        # P0 eq. 98 for each leg, projected with eq. 105's meaning: u = C^T M q'' with C from the closure
        legs = [numbers("5r-balanced", f"{a2}^2 * share + {m2} * {a2}^2 / 4 + {w2} * r2^2 + {J2}",
                        f"{m1} * {a1}^2 / 4 + {w1} * r1^2 + {a1}^2 * ({m2} + share + {w2}) + {J1}")
                for a1, a2, m1, m2, J1, J2, w1, w2 in (("a11", "a12", "1.2", "0.9", "0.01", "0.016", "cw11", "cw12"),
                                                      ("a21", "a22", "1.3", "0.8", "0.012", "0.013", "cw21", "cw22"))]
        lengths = [numbers("5r-balanced", "a11", "a12"), numbers("5r-balanced", "a21", "a22")]
        for trajectory in draw("trajectories of 5r-balanced", ("cycloid", "bang-bang"), 0.5):
            for s in run("5r-balanced", trajectory):
                q, a = np.array(s["joint_position"][:4]), np.array(s["joint_acceleration"][:4])
                inner = np.concatenate([[(I1 + I2) * x + I1 * y, I1 * (x + y)]
                                        for (I1, I2), x, y in zip(legs, a[::2], a[1::2])])
                tips = []
                for (l1, l2), (x, y) in zip(lengths, (q[:2], q[2:])):
                    far = l2 * np.array([-math.sin(x + y), math.cos(x + y)])
                    tips.append(np.column_stack([l1 * np.array([-math.sin(x), math.cos(x)]) + far, far]))
                A = np.hstack([tips[0], -tips[1]])
                C = np.zeros((4, 2))
                C[[0, 2]] = np.eye(2)
                C[[1, 3]] = -np.linalg.solve(A[:, [1, 3]], A[:, [0, 2]])
                self.near(s["torque"], C.T @ inner, 1e-9)
                self.near(s["shaking_force"], [0, 0], 1e-9)

    def test_the_four_bar_in_space_is_the_planar_one(self):
        for flat, space in zip(run("four-bar", "cycloid"), run("four-bar-in-space", "cycloid")):
            self.near(space["torque"], flat["torque"], 1e-10)
            self.near(np.array(space["shaking_force"])[:2], flat["shaking_force"], 1e-10)
            self.near(np.array(space["shaking_moment"])[2], flat["shaking_moment"][0], 1e-10)
            self.near(np.array(space["joint_force"])[:, :2], flat["joint_force"], 1e-9)

    def test_the_hanging_four_bar_rests_where_its_links_make_atan_sqrt_15(self):
        rest = run("static-four-bar", "cycloid", [0])[0]
        self.near(rest["joint_position"][0], math.atan(math.sqrt(15)) - math.pi, 1e-12)
        self.near(rest["torque"], [0], 1e-10)   # of 4 links' weights of 39 N at 2 m

    def test_the_scotch_yoke_moves_harmonically(self):
        for s in run("scotch-yoke", "steady"):
            x = s["joint_position"][-1]
            self.near(x, 0.08 * math.cos(s["joint_position"][0]), 1e-13)
            self.near(s["joint_acceleration"][-1], -x * (2 * math.pi / 0.2)**2, 1e-9)

    def test_the_slider_follows_the_crank_by_pythagoras(self):
        for s in run("slider-crank", "cycloid"):
            A = s["joint_position"][0]
            self.near(s["tool_position"], [0.1 * math.cos(A) + math.sqrt(0.09 - (0.1 * math.sin(A))**2), 0], 1e-13)


class Consistent(unittest.TestCase):
    def test_jacobians_are_the_derivatives_of_the_constraints(self):
        """Central differences of 1e-5: their error is about 1e-10 of the curvature, which is of the order of one."""
        configs = ("delta", "rccc", "spring-press", "bricard", "stewart", "whitworth", "scara")
        for config in draw("derivatives of constraints", configs, 0.3):
            mechanism = Mechanism(os.path.join(CONFIGS, config + ".yaml"))
            drive = Drive(mechanism, "cycloid")
            step = np.random.default_rng(5).normal(size=len(mechanism.columns))
            ahead, behind = (mechanism.move(drive.p0, drive.R0, s * 1e-5 * step) for s in (1, -1))
            change = (mechanism.constraints(*ahead)[0] - mechanism.constraints(*behind)[0]) / 2e-5
            rows = mechanism.constraints(drive.p0, drive.R0)[1].real[:, mechanism.columns]
            np.testing.assert_allclose(change, rows @ step, atol=1e-7, err_msg=config)
            # coordinates are read off exactly only where the joints are closed: move along the mechanism's freedom
            closed = jacobian(drive, drive.p0, drive.R0).real[:, mechanism.columns]
            rate = np.zeros(len(closed))
            rate[-1] = 1
            step = np.linalg.lstsq(closed, rate, rcond=1e-11)[0]
            ahead, behind = (mechanism.move(drive.p0, drive.R0, s * 1e-5 * step) for s in (1, -1))
            change = (mechanism.coordinates(*ahead, drive.q0) - mechanism.coordinates(*behind, drive.q0)) / 2e-5
            rows = mechanism.rates(drive.p0, drive.R0).real[:, mechanism.columns]
            np.testing.assert_allclose(change, rows @ step, atol=1e-6 * max(1, np.abs(step).max())**3, err_msg=config)

    def test_motors_and_surroundings_feed_the_kinetic_energy(self):
        """The power of motors, weight, loads, springs and friction is the rate of the kinetic energy: all that joints,
        gears and discs exchange cancels. Central differences over one sample of hundreds: their error is a few
        (dt / T)^2 of the curvature."""
        names = ("stewart", "rccc", "bricard", "spatial-slider-crank", "planar-rrr", "geared-five-bar", "whitworth",
                 "spring-press", "../tests/reference_implementation/specs/every-planar-joint", "../tests/reference_implementation/specs/every-spatial-joint")
        for name in draw("rates of energy", names, 0.3, lambda name: traits_of(os.path.join(CONFIGS, name + ".yaml"))):
            drive = Drive(Mechanism(os.path.join(CONFIGS, name + ".yaml")), "cycloid")
            middle = (drive.samples - 1) * 3 // 8
            before, here, after = (Balance(drive, state) for state in follow(drive, [middle - 1, middle, middle + 1]))
            rate = (after.kinetic - before.kinetic) / (after.state["time"] - before.state["time"])
            friction = sum(-viscous * here.rates[c]**2 - coulomb * abs(here.rates[c])
                           for c, viscous, coulomb in drive.mechanism.friction)
            motors = here.torque @ here.rates[drive.mechanism.actuators]
            springs = sum((s["preload"] - s["stiffness"] * here.state["q"][s["joint"]]) * here.rates[s["joint"]]
                          for s in drive.mechanism.springs if "joint" in s)
            fed = motors + here.external.ravel() @ here.state["velocity"] + friction + springs
            self.assertAlmostEqual(fed, rate, delta=2e-3 * max(abs(rate), abs(motors)), msg=name)


def conditions(config, goal, tree_joints=None):
    """Number of conditions, and how far the config's own numbers are from meeting them, its parameters' size being 1."""
    mechanism = Mechanism(os.path.join(CONFIGS, config + ".yaml"))
    names = every_name(mechanism)
    basis, _, units = derive(mechanism, goal, names, configurations(mechanism), tree_joints)
    size = values(mechanism, names) / units
    return len(basis), np.linalg.norm(basis @ size) / np.linalg.norm(size)


class Conditions(unittest.TestCase):
    def test_the_5r_has_the_numbers_of_conditions_that_are_known(self):
        """Static, gyroscopic in the accelerations of both legs' joints, in the motors' own, dynamic: 6, 8, 9, 11 (what a
        link carries adds none)."""
        legs = ["A1", "B1", "A2", "B2"]
        found = [conditions("5r-impossible", goal, legs)[0]
                 for goal in ("static", "gyroscopic", "gyroscopic-independent", "dynamic")]
        self.assertEqual(found, [6, 8, 9, 11])

    def test_balanced_mechanisms_of_the_papers_meet_their_conditions(self):
        """To round-off of values about 1; the same before balancing: far from it."""
        balanced = (("planar-rrr", "decoupled", None), ("spatial-rrr", "decoupled", None), ("scara", "decoupled", None),
                    ("rr-balanced", "fully-gyroscopic", None), ("5r-balanced", "static", None),
                    ("3rrr-redistributed", "proportional", None))
        for config, goal, joints in draw("balanced mechanisms", balanced, 0.3, lambda case: {case[1]}):
            self.assertLess(conditions(config, goal, joints)[1], 1e-13, (config, goal))
        others = (("planar-rrr-design", "decoupled", None), ("scara-design", "decoupled", None), ("spatial-rrr-design", "decoupled", None),
                  ("rr", "gyroscopic", None), ("5r", "static", None), ("3rrr", "proportional", None))
        for config, goal, joints in draw("mechanisms before balancing", others, 0.3, lambda case: {case[1]}):
            self.assertGreater(conditions(config, goal, joints)[1], 0.02, (config, goal))


if __name__ == "__main__":
    unittest.main()
