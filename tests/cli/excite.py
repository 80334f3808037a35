"""`balance excite`: a pendulum and a two-link arm by hand, a five-bar, a real six-axis arm, and what is refused."""

import csv
import json
import math
import os
import unittest

import numpy

from _program import Case, run

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "identification", "data")
FIVE_BAR, SIX_AXES = os.path.join(DATA, "5r-spec.yaml"), os.path.join(DATA, "tx40.yaml")
ARM = """\
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 2, com: [0.25, 0], inertia: 0.05, points: {S: [0, 0], E: [0.5, 0]}}
  fore: {mass: 1, com: [0.2, 0], inertia: 0.02, points: {E: [0, 0]}}
joints:
  A1: {type: revolute, connects: [ground.O, upper.S]}
  A2: {type: revolute, connects: [upper.E, fore.E]}
actuators: [A1, A2]
trajectories:
  fast: {law: fastest, drive: joints, from: {joints: {A1: 0, A2: 0}}, to: {joints: {A1: 1, A2: 1}}, limits: {joint_velocity: 3, torque: 25}}
"""
ARM_LIMITS = ["--limit", "A1=-1.5:1,A2=-2:2,rate=3,acceleration=12,effort=25", "--noise", "A1=0.2,A2=0.05"]
BUDGET = ["--evaluations", "60", "--starts", "1"]


def series(answer, times, order):
    """Coordinates along the Fourier series of an answer, or their derivatives."""
    omega, values = 2 * math.pi / answer["period"], []
    for one in answer["series"]:
        value = numpy.full(len(times), one["offset"] if order == 0 else 0.0)
        for k, (sine, cosine) in enumerate(zip(one["sine"], one["cosine"]), 1):
            phase, shift = k * omega * times, order * math.pi / 2
            value += (k * omega) ** order * (sine * numpy.sin(phase + shift) + cosine * numpy.cos(phase + shift))
        values.append(value)
    return numpy.array(values)


def arm_regressor(q, dq, ddq):
    """Rows of A1 and A2 by the names of the unknowns, from Lagrange's equation by hand."""
    length, g = 0.5, 9.81
    (q1, q2), (w1, w2), (a1, a2) = q, dq, ddq
    c1, s1, c2, s2, c12, s12 = math.cos(q1), math.sin(q1), math.cos(q2), math.sin(q2), math.cos(q1 + q2), math.sin(q1 + q2)
    zero, a12 = 0.0, a1 + a2
    # the elbow's acceleration and weight, along the forearm's axes, times its moments mx and my
    x = length * (a1 * s2 - w1 * w1 * c2) + g * s12
    y = length * (a1 * c2 + w1 * w1 * s2) + g * c12
    w12 = w1 + w2
    columns = {
        "upper.mx": (g * c1, zero), "upper.my": (-g * s1, zero), "upper.J": (a1, zero),
        "fore.m": (length * length * a1 + g * length * c1, zero), "fore.J": (a12, a12),
        "fore.mx": (y + length * (a12 * c2 - w12 * w12 * s2), y), "fore.my": (-x + length * (-a12 * s2 - w12 * w12 * c2), -x),
    }
    for k, (name, rate) in enumerate((("A1", w1), ("A2", w2))):
        for word, value in (("viscous", rate), ("coulomb", math.copysign(1.0, rate)), ("offset", 1.0)):
            columns[f"{name}.{word}"] = tuple(value if row == k else 0.0 for row in range(2))
    return columns


class Excite(Case):
    def found(self, *arguments):
        done = run("excite", *arguments, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def refused(self, code, words, *arguments):
        done = run("excite", *arguments)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def assert_limits_kept(self, answer, orders=("", ".rate", ".acceleration")):
        """Between the samples that the search looked at, too; a sine of the highest harmonic rises by 5e-4 there."""
        times = numpy.linspace(0, answer["duration"], 3001)
        limits = {one["name"]: one for one in answer["limits"]}
        for order, word in enumerate(orders):
            for one, values in zip(answer["series"], series(answer, times, order)):
                limit = limits.get(one["coordinate"] + word)
                if limit is None:
                    continue
                margin = 1e-3 * (limit["upper"] - limit["lower"])
                self.assertLessEqual(values.max(), limit["upper"] + margin)
                self.assertGreaterEqual(values.min(), limit["lower"] - margin)
        for order in (1, 2):
            for values in series(answer, times, order):
                self.assertLess(max(abs(values[0]), abs(values[-1])), 1e-9 * max(1, abs(values).max()))


class TwoLinks(Excite):
    def setUp(self):
        super().setUp()
        self.spec = self.write("arm.yaml", ARM)

    def test_the_information_and_the_deviations_are_those_of_equations_by_hand(self):
        answer = self.found(self.spec, *ARM_LIMITS, *BUDGET)
        self.assert_limits_kept(answer)
        samples = 500  # those of the answer: a hundred for every harmonic
        times = answer["period"] * numpy.arange(samples) / samples
        motion = [series(answer, times, order) for order in range(3)]
        names = [one["name"] for one in answer["base_parameters"]]
        information = numpy.zeros((len(names), len(names)))
        for s in range(samples):
            columns = arm_regressor(*(values[:, s] for values in motion))
            for row, noise in enumerate((0.2, 0.05)):
                if abs(motion[1][row, s]) > 0.02:  # at rest dry friction can be anything
                    y = numpy.array([columns[name][row] for name in names]) / noise
                    information += numpy.outer(y, y)
        information *= 250 * answer["duration"] / samples
        # the same sums; a sample whose rate is 0.02 to round-off may count or not
        self.assertAlmostEqual(numpy.linalg.slogdet(information)[1], answer["information"]["log_det"], delta=1e-5)
        deviations = numpy.sqrt(numpy.diag(numpy.linalg.inv(information)))
        for one, deviation in zip(answer["base_parameters"], deviations):
            self.assertAlmostEqual(one["deviation"], deviation, delta=1e-5 * deviation)
        scaled = information / numpy.sqrt(numpy.outer(numpy.diag(information), numpy.diag(information)))
        self.assertAlmostEqual(answer["information"]["condition"], math.sqrt(numpy.linalg.cond(scaled)), delta=1e-5 * 10)

    def test_more_is_shown_than_by_random_series_and_some_limits_are_reached(self):
        answer = self.found(self.spec, *ARM_LIMITS, *BUDGET)
        self.assertEqual((answer["structural_rank"], answer["found_rank"]), (12, 12))
        self.assertGreater(answer["information"]["log_det"], answer["best_random"]["log_det"])
        self.assertGreater(answer["best_random"]["log_det"], answer["median_random"]["log_det"])
        self.assertGreater(answer["deviation_ratio"], 1.2)
        self.assertTrue(any(one["active"] for one in answer["limits"]))
        self.assertEqual(answer["hidden"], ["upper.m"])

    def test_a_budget_of_evaluations_gives_the_same_answer_again(self):
        self.assertEqual(self.found(self.spec, *ARM_LIMITS, *BUDGET), self.found(self.spec, *ARM_LIMITS, *BUDGET))
        other = self.found(self.spec, *ARM_LIMITS, *BUDGET, "--seed", "2")
        self.assertNotEqual(other["series"], self.found(self.spec, *ARM_LIMITS, *BUDGET)["series"])

    def test_the_written_trajectory_is_simulated_and_the_table_is_the_series(self):
        out, table = self.path("out.yaml"), self.path("motion.csv")
        answer = self.found(self.spec, *ARM_LIMITS, *BUDGET, "-o", out, "--csv", table, "--rate", "100", "--base-frequency", "0.2")
        self.assertEqual((answer["duration"], answer["period"]), (10, 5))
        self.assertLess(answer["trajectory"]["position_error"], 1e-5)  # 5/384 (2π/60)⁴ = 2e-6 within, more at the ends
        self.assertLess(answer["trajectory"]["acceleration_error"], 0.01)  # (2π/60)²/12 = 9e-4 within, more at the ends
        self.assertLess(answer["trajectory"]["effort_error"], 0.01)
        done = run("simulate", out, "-t", "excitation", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(table, encoding="utf-8") as file:
            rows = list(csv.reader(file))
        self.assertEqual(rows[0], ["time", "A1", "A2", "A1.rate", "A2.rate"])
        values = numpy.array(rows[1:], dtype=float)
        self.assertEqual(len(values), 1001)
        for order in range(2):  # nine digits of the time
            difference = values[:, 1 + 2 * order : 3 + 2 * order].T - series(answer, values[:, 0], order)
            self.assertLess(abs(difference).max(), 1e-7)
        with open(out, encoding="utf-8") as file:
            self.assertTrue(file.read().startswith(ARM[:200]))
        self.refused(2, ["--name", "excitation"], out, *ARM_LIMITS, *BUDGET, "-o", self.path("again.yaml"))

    def test_limits_of_a_trajectory_and_units_of_the_spec(self):
        answer = self.found(self.spec, "--limits-of", "fast", *BUDGET)
        limits = {one["name"]: one["upper"] for one in answer["limits"]}
        self.assertEqual([limits[name] for name in ("A1.rate", "A2.rate", "A1.effort", "A2.effort")], [3, 3, 25, 25])
        degrees = self.write("degrees.yaml", "units: {angle: deg}\n" + ARM.replace("joint_velocity: 3", "joint_velocity: 90"))
        answer = self.found(degrees, "--limit", "A1=-90:45,rate=180", *BUDGET)
        limits = {one["name"]: (one["lower"], one["upper"]) for one in answer["limits"]}
        self.assertAlmostEqual(limits["A1"][0], -math.pi / 2)
        self.assertAlmostEqual(limits["A2.rate"][1], math.pi)

    def test_misuse_is_named(self):
        spec, limit = self.spec, "--limit"
        self.refused(2, ["nothing limits the speed of A1 and A2"], spec)
        self.refused(2, ["nothing limits the speed of A2"], spec, limit, "A1.rate=2")
        self.refused(2, ["no coordinate", "A3", "A1"], spec, limit, "A3.rate=2")
        self.refused(2, ["NAME=BOUND"], spec, limit, "rate")
        self.refused(2, ["a number", "fast"], spec, limit, "rate=fast")
        self.refused(2, ["LEAST < MOST"], spec, limit, "A1=2:1")
        self.refused(2, ["both signs"], spec, limit, "A1.rate=1:2")
        self.refused(2, ["whole number of periods"], spec, limit, "rate=2", "--base-frequency", "0.25")
        self.refused(2, ["nothing is measured at", "A9"], spec, limit, "rate=2", "--noise", "A9=1")
        self.refused(2, ["--seconds"], spec, limit, "rate=2", "--seconds", "2", "--evaluations", "5")
        self.refused(4, ["at rest", "A1.effort"], spec, limit, "rate=2,A1.effort=0.01", *BUDGET)
        one_motor = self.write("passive.yaml", ARM.replace("actuators: [A1, A2]", "actuators: [A1]").split("trajectories")[0])
        self.refused(4, ["degrees of freedom"], one_motor, limit, "rate=2", *BUDGET)


class Loops(Excite):
    def test_a_five_bar_stays_away_from_singular_poses(self):
        """Twenty combinations as for `identify`; the mobility of `simulate` is that of the answer."""
        out = self.path("out.yaml")
        answer = self.found(FIVE_BAR, "--limit", "rate=6,acceleration=40,effort=8", *BUDGET, "-o", out)
        self.assert_limits_kept(answer)
        self.assertEqual((answer["structural_rank"], answer["found_rank"]), (20, 20))
        self.assertGreaterEqual(answer["mobility"], 0.1)
        self.assertGreater(answer["random_series"], 10)
        self.assertGreater(answer["deviation_ratio"], 1.2)
        done = run("simulate", out, "-t", "excitation", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        for channel in answer["channels"]:
            self.assertLessEqual(channel["peak"], 8 * 1.001)

    def test_a_horizontal_five_bar_hides_four_combinations_of_its_shaking_force(self):
        with open(FIVE_BAR, encoding="utf-8") as file:
            lines = ["gravity: [0, 0]" if line.startswith("gravity") else line for line in file.read().splitlines()]
        flat = self.write("flat.yaml", "\n".join(lines) + "\n")
        answer = self.found(flat, "--limit", "rate=6,acceleration=40", *BUDGET)
        missing = {one["name"]: len(one["missing"]) for one in answer["hidden_combinations"]}
        self.assertEqual(missing["shaking_force"], 4)
        answer = self.found(flat, "--limit", "rate=6,acceleration=40", *BUDGET, "--frame")
        self.assertEqual({one["name"]: len(one["missing"]) for one in answer["hidden_combinations"]}["shaking_force"], 0)


class SixAxes(Excite):
    def test_a_real_arm_is_shown_better_than_by_random_series(self):
        """Sixty combinations, as for `identify` with the arm's own record."""
        answer = self.found(SIX_AXES, "--limit", "joint_1=-3:3,joint_2=-2:2,joint_3=-2:2,rate=4,acceleration=15", "--noise",
                            "joint_1=0.5,joint_2=0.5,joint_3=0.3,joint_4=0.1,joint_5=0.1,joint_6=0.1", "--evaluations", "120", "--starts", "1")
        self.assertEqual((answer["structural_rank"], answer["found_rank"]), (60, 60))
        self.assertGreater(answer["deviation_ratio"], 1.3)
        self.assertGreater(answer["information"]["log_det"], answer["best_random"]["log_det"])
        self.assert_limits_kept(answer)


if __name__ == "__main__":
    unittest.main()
