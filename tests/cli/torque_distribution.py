"""Redundant actuators: efforts of every method against linear programs of hand-written kinematics."""

import json
import math
import re
import unittest

import h5py
import numpy as np
from scipy.optimize import linprog

from _program import Case, config, run

SAMPLES = 41


def five_bar_rates(q):
    """Rates of A1, A2, B1 per velocity of the tip, from the joint angles q = A1, B1, A2, B2 of 5r.yaml."""

    def chain(first, second, length1, length2):  # d(x, y)/d(first, second)
        s, c = math.sin(first), math.cos(first)
        s2, c2 = math.sin(first + second), math.cos(first + second)
        return np.array([[-length1 * s - length2 * s2, -length2 * s2], [length1 * c + length2 * c2, length2 * c2]])

    left, right = np.linalg.inv(chain(q[0], q[1], 0.3, 0.45)), np.linalg.inv(chain(q[2], q[3], 0.32, 0.42))
    return np.array([left[0], right[0], left[1]])


def three_leg_rates(q, platform):
    """Rates of A1, B1, A2, B2, A3, B3 of 3rrr.yaml per velocity of the tool and rate of its angle."""
    length, side = 0.18, 0.15
    yg = side / (2 * math.sqrt(3))
    corners = [np.array([side / 2, -yg]), np.array([-side / 2, -yg]), np.array([0, 2 * yg])]
    rows = []
    for leg, corner in enumerate(corners):
        first, second = q[2 * leg], q[2 * leg + 1]
        s, c, s2, c2 = math.sin(first), math.cos(first), math.sin(first + second), math.cos(first + second)
        chain = np.array([[-length * (s + s2), -length * s2], [length * (c + c2), length * c2]])
        arm = np.array([[math.cos(platform), -math.sin(platform)], [math.sin(platform), math.cos(platform)]]) @ corner
        rows += list(np.linalg.inv(chain) @ np.array([[1, 0, -arm[1]], [0, 1, arm[0]]]))
    return np.array(rows)


def least_peak(rates, forces, lower, upper):
    """The least largest torque with ratesᵀ u = forces within the bounds; None if there is none."""
    motors = len(rates)
    bounded = linprog(
        np.r_[np.zeros(motors), 1],
        A_ub=np.vstack([np.c_[np.eye(motors), -np.ones(motors)], np.c_[-np.eye(motors), -np.ones(motors)]]),
        b_ub=np.zeros(2 * motors),
        A_eq=np.c_[rates.T, np.zeros(len(forces))],
        b_eq=forces,
        bounds=[*zip(lower, upper), (0, None)],
        method="highs",
    )
    return bounded.x[-1] if bounded.status == 0 else None


def least_excess(rates, forces, lower, upper):
    motors = len(rates)
    has_lower, has_upper = np.isfinite(lower), np.isfinite(upper)
    rows = np.vstack([np.c_[-np.eye(motors), -np.ones(motors)][has_lower], np.c_[np.eye(motors), -np.ones(motors)][has_upper]])
    return linprog(
        np.r_[np.zeros(motors), 1],
        A_ub=rows,
        b_ub=np.r_[-lower[has_lower], upper[has_upper]],
        A_eq=np.c_[rates.T, np.zeros(len(forces))],
        b_eq=forces,
        bounds=[(None, None)] * motors + [(0, None)],
        method="highs",
    ).x[-1]


class Mechanism:
    """One of the project's mechanisms with other actuators, and what its motors must add up to."""

    def __init__(self, name, independent, joints, rates):
        self.name, self.independent, self.joints, self.rates = name, independent, joints, rates

    def spec(self, actuators, distribution):
        """With as many motors as freedoms it is what the motion requires, without any choice."""
        text = config(self.name, (r"actuators: [^\n]*\n", f"actuators: [{', '.join(actuators)}]\n"))
        text = re.sub(r"torque_distribution: [^\n]*\n", "", text)
        return text + (f"torque_distribution: {distribution}\n" if distribution else "")


def five_bar(sample):
    rates = dict(zip(("A1", "A2", "B1"), five_bar_rates([sample[joint] for joint in ("A1", "B1", "A2", "B2")])))
    return rates


def three_legs(sample):
    names = ("A1", "B1", "A2", "B2", "A3", "B3")
    return dict(zip(names, three_leg_rates([sample[joint] for joint in names], sample["tool"])))


FIVE_BAR = Mechanism("5r.yaml", ("A1", "A2"), ("A1", "A2", "B1"), five_bar)
THREE_LEGS = Mechanism("3rrr.yaml", ("A1", "A2", "A3"), ("A1", "A2", "A3", "B1", "B2"), three_legs)


class Distribution(Case):
    samples = SAMPLES

    def simulated(self, mechanism, actuators, distribution=None, options=(), command="simulate", more=""):
        spec = self.write("spec.yaml", mechanism.spec(actuators, distribution) + more)
        output = self.path("out.h5")
        done = run(command, spec, "-t", "cycloid", "--samples", str(self.samples), "-o", output, "--force", "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(output) as file:
            data = {name: file[name][()] for name in ("torque", "power", "joint_position", "shaking_force")}
            coordinates = [name.decode() for name in file["coordinate"][()]]
            stated = file.attrs.get("torque_distribution")
            data["stated"] = stated and json.loads(stated)
            angle = np.ravel(file["tool_orientation"])
        data["poses"] = [dict(zip(coordinates, q), tool=a) for q, a in zip(data["joint_position"], angle)]
        data["answer"] = json.loads(done.stdout)
        return data

    def problems(self, mechanism):
        """For every sample the rates of all motors, and the forces that they must add up to."""
        alone = self.simulated(mechanism, mechanism.independent)
        for pose, torque in zip(alone["poses"], alone["torque"]):
            rates = mechanism.rates(pose)
            forces = np.array([rates[joint] for joint in mechanism.independent]).T @ torque
            yield np.array([rates[joint] for joint in mechanism.joints]), forces

    def assert_equation_of_motion(self, mechanism, found):
        """The efforts make the same motion: equal generalised forces and power."""
        alone = self.simulated(mechanism, mechanism.independent)
        scale = np.abs(found["torque"]).max()
        for (rates, forces), torque in zip(self.problems(mechanism), found["torque"]):
            self.assertLess(np.abs(rates.T @ torque - forces).max(), 1e-9 * scale * np.abs(rates).max())
        self.assertLess(np.abs(found["power"].sum(1) - alone["power"].sum(1)).max(), 1e-9 * scale * 100)

    def test_least_peak_is_that_of_a_linear_program(self):
        for mechanism in (FIVE_BAR, THREE_LEGS):
            found = self.simulated(mechanism, mechanism.joints, "{method: least-peak}")
            self.assert_equation_of_motion(mechanism, found)
            unbounded = np.full(len(mechanism.joints), np.inf)
            expected = [least_peak(*problem, -unbounded, unbounded) for problem in self.problems(mechanism)]
            scale = max(expected)
            np.testing.assert_allclose(np.abs(found["torque"]).max(1), expected, rtol=0, atol=1e-7 * scale)
            least_norm = self.simulated(mechanism, mechanism.joints)
            self.assertLess(np.abs(found["torque"]).max(), 0.999 * np.abs(least_norm["torque"]).max())

    def test_the_least_peak_of_all_masses_is_that_of_one_linear_program(self):
        """In masses and efforts together: the forces are linear in the counterweights' masses. Other distributions have no smaller peak."""
        names = ("cw11", "cw12", "cw21", "cw22")
        self.samples = 401  # those of the program's figures

        def forces_with(masses):
            text = FIVE_BAR.spec(FIVE_BAR.independent, None)
            for name, mass in masses.items():
                text = re.sub(rf"({name}: .*mass: ){{.*}}}}", rf"\g<1>{mass}}}", text)
            mechanism = Mechanism("5r.yaml", FIVE_BAR.independent, FIVE_BAR.joints, five_bar)
            mechanism.spec = lambda *_: text
            return list(self.problems(mechanism))

        none = forces_with(dict.fromkeys(names, 0))
        columns = [forces_with({**dict.fromkeys(names, 0), name: 1}) for name in names]
        motors, samples = 3, len(none)
        size = len(names) + 1 + motors * samples  # masses, the peak, efforts
        equations, right, rows = [], [], []
        for k, (rates, constant) in enumerate(none):
            place = len(names) + 1 + motors * k
            block = np.zeros((2, size))
            block[:, place : place + motors] = rates.T
            for m, column in enumerate(columns):
                block[:, m] = constant - column[k][1]
            equations.append(block)
            right.append(constant)
            for sign in (1, -1):
                row = np.zeros((motors, size))
                row[:, place : place + motors] = sign * np.eye(motors)
                row[:, len(names)] = -1
                rows.append(row)
        cost = np.zeros(size)
        cost[len(names)] = 1
        rows = np.vstack(rows)
        best = linprog(cost, A_ub=rows, b_ub=np.zeros(len(rows)), A_eq=np.vstack(equations), b_eq=np.hstack(right),
                       bounds=[(0, 60)] * len(names) + [(0, None)] + [(None, None)] * (motors * samples), method="highs")
        self.assertEqual(best.status, 0)

        def designed(distribution, seconds):
            text = re.sub(r"samples: \d+", f"samples: {self.samples}", FIVE_BAR.spec(FIVE_BAR.joints, distribution))
            text = re.sub(r"design: [^\n]*", "design: {minimize: {peak: torque, along: cycloid}}", text)
            done = run("design", self.write("d.yaml", text), "--json", "--seconds", str(seconds))
            self.assertEqual(done.returncode, 0, done.stderr)
            return json.loads(done.stdout)

        found = designed("{method: least-peak}", 10)
        self.assertEqual(found["optimality"], "proved-best")
        # the least of the same samples, to the tolerances of both programs
        self.assertAlmostEqual(found["objective"]["value"], best.fun, delta=1e-6 * best.fun)
        other = designed("{method: least-norm, limits: {B1: 1}}", 2)
        self.assertIn(other["optimality"], ("local-best", "stopped"))
        self.assertAlmostEqual(other["objective"]["lower_bound"], found["objective"]["value"], delta=1e-6 * best.fun)
        self.assertGreater(other["objective"]["value"], other["objective"]["lower_bound"])
        self.assertIn("the bound is that of all distributions of the efforts together", other["notes"])

    def test_least_norm_is_the_pseudo_inverse_and_weights_scale_it(self):
        weights = {"A1": 1, "A2": 4, "B1": 0.25}
        for mechanism, text, weight in (
            (FIVE_BAR, None, [1, 1, 1]),
            (FIVE_BAR, "{weights: {A2: 4, B1: 0.25}}", list(weights.values())),
            (THREE_LEGS, "{weights: [1, 2, 3, 4, 5]}", [1, 2, 3, 4, 5]),
        ):
            found = self.simulated(mechanism, mechanism.joints, text)
            self.assert_equation_of_motion(mechanism, found)
            root = np.sqrt(weight)
            expected = [np.linalg.pinv((rates / root[:, None]).T) @ forces / root for rates, forces in self.problems(mechanism)]
            np.testing.assert_allclose(found["torque"], expected, rtol=0, atol=1e-8 * np.abs(expected).max())

    def test_a_motor_of_great_weight_is_as_good_as_absent(self):
        for method in ("least-norm", "least-peak"):
            found = self.simulated(FIVE_BAR, FIVE_BAR.joints, f"{{method: {method}, weights: {{B1: 1e9}}}}")
            alone = self.simulated(FIVE_BAR, FIVE_BAR.independent)
            np.testing.assert_allclose(found["torque"][:, :2], alone["torque"], rtol=0, atol=1e-6)

    def test_limits_hold_where_they_can_and_the_excess_is_the_least(self):
        for mechanism, text, limit in (
            (FIVE_BAR, "{limits: {B1: 1, A1: 4}}", [4, np.inf, 1]),
            (FIVE_BAR, "{method: least-peak, limits: {A1: 2.5, A2: 2.5, B1: 0.5}}", [2.5, 2.5, 0.5]),
            (THREE_LEGS, "{limits: [5, 5, 5, 2, 2]}", [5, 5, 5, 2, 2]),
            (THREE_LEGS, "{method: least-peak, limits: {B1: 1, B2: [-0.5, 3]}}", None),
        ):
            upper = np.array(limit or [np.inf, np.inf, np.inf, 1, 3], dtype=float)
            lower = -upper if limit else np.array([-np.inf, -np.inf, -np.inf, -1, -0.5])
            found = self.simulated(mechanism, mechanism.joints, text)
            self.assert_equation_of_motion(mechanism, found)
            excess = np.maximum(0, np.maximum(lower - found["torque"], found["torque"] - upper).max(1))
            expected = [least_excess(*problem, lower, upper) for problem in self.problems(mechanism)]
            expected = np.maximum(0, expected)
            np.testing.assert_allclose(excess, expected, rtol=0, atol=1e-7 * np.abs(found["torque"]).max())
            stated = max((one["excess"] for one in found["stated"]["excesses"]), default=0)
            self.assertGreaterEqual(stated, excess.max() - 1e-9)
            self.assertEqual(any("exceeds its bound" in note for note in found["answer"]["notes"]), stated > 0)
            if "least-peak" not in text:
                continue
            for problem, torque, e in zip(self.problems(mechanism), found["torque"], expected):
                if e < 1e-9:
                    self.assertAlmostEqual(np.abs(torque).max(), least_peak(*problem, lower - 1e-9, upper + 1e-9), delta=1e-6)

    def test_a_preload_keeps_signs(self):
        # the rates' null space of the first sample has these signs
        rates, _ = next(self.problems(FIVE_BAR))
        null = np.linalg.svd(rates.T)[2][-1]
        signs = np.sign(null)
        text = f"{{preload: {{A1: {2 * signs[0]}, A2: {signs[1]}}}}}"
        found = self.simulated(FIVE_BAR, FIVE_BAR.joints, text)
        self.assert_equation_of_motion(FIVE_BAR, found)
        self.assertEqual(found["stated"]["excesses"], [])
        self.assertGreaterEqual((found["torque"][:, 0] * signs[0]).min(), 2 - 1e-9)
        self.assertGreaterEqual((found["torque"][:, 1] * signs[1]).min(), 1 - 1e-9)

    def test_both_formulations_agree(self):
        for mechanism in (FIVE_BAR, THREE_LEGS):
            for text in ("{method: least-peak}", "{weights: {A1: 3}, limits: {B1: 0.5}}", "{method: least-peak, limits: {A2: 1}, preload: {B1: -0.2}}"):
                tree = self.simulated(mechanism, mechanism.joints, text)
                natural = self.simulated(mechanism, mechanism.joints, text, ("--formulation", "natural"))
                np.testing.assert_allclose(natural["torque"], tree["torque"], rtol=0, atol=1e-7 * np.abs(tree["torque"]).max())

    def test_a_controller_distributes_what_its_model_asks_for(self):
        """Every distribution makes the same motion, but for what held efforts do while the mechanism moves on."""
        laws = "\ncontrollers: {once: {type: computed-torque, bandwidth: 10, rate: 1000}, often: {type: computed-torque, bandwidth: 10, rate: 4000}}\n"
        text = "{method: least-peak, limits: {B1: 0.5}}"
        difference = {}
        for controller in ("once", "often"):
            found, default = (
                self.simulated(FIVE_BAR, FIVE_BAR.joints, one, ("-c", controller), "control", laws) for one in (text, "{}")
            )
            self.assertEqual(found["stated"]["method"], "least-peak")
            self.assertTrue(any("least peak within limits" in note for note in found["answer"]["notes"]))
            self.assertLess(np.abs(found["torque"][:, 2]).max(), 0.5 + 1e-9)
            self.assertGreater(np.abs(default["torque"][:, 2]).max(), 0.5)
            difference[controller] = np.abs(found["joint_position"] - default["joint_position"]).max()
        self.assertLess(difference["often"], difference["once"] / 3)
        self.assertLess(difference["once"], 2e-3)

    def test_without_redundant_actuators_there_is_no_choice(self):
        found = self.simulated(FIVE_BAR, FIVE_BAR.independent, "{method: least-peak, limits: {A1: 1}}")
        alone = self.simulated(FIVE_BAR, FIVE_BAR.independent)
        np.testing.assert_array_equal(found["torque"], alone["torque"])
        self.assertTrue(any("leave no choice" in note for note in found["answer"]["notes"]))
        self.assertEqual([one["actuator"] for one in found["stated"]["excesses"]], ["A1"])

    def test_with_too_few_actuators_nothing_is_said_of_a_distribution(self):
        spec = self.write("rr.yaml", config("rr.yaml", (r"actuators: \[R1, R2\]",
                                                        "actuators: [R1]\ntorque_distribution: {method: least-peak, limits: {R1: 5}}")))
        done = run("check", spec, "--json")
        self.assertNotIn("leave no choice", done.stdout)

    def test_what_needs_linear_efforts_is_refused_in_words(self):
        spec = self.write("spec.yaml", FIVE_BAR.spec(FIVE_BAR.joints, "{method: least-peak}"))
        done = run("simulate", spec, "-t", "cycloid", "--split", "-o", self.path("split.h5"))
        self.assert_failure(done, 4, "torque_distribution", "least-norm without limits and preload")
        done = run("equations", spec, "--at", "start")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("no torques: torque_distribution", done.stdout.replace("\n ", ""))
        fastest = self.write(
            "fastest.yaml",
            FIVE_BAR.spec(FIVE_BAR.joints, "{method: least-peak}").replace(
                "trajectories:\n", "trajectories:\n  quick: {law: fastest, drive: tool, limits: {torque: 20}}\n"
            ),
        )
        done = run("simulate", fastest, "-t", "quick")
        self.assert_failure(done, 4, "torque_distribution", "'torque")

    def test_mistakes_are_reported_with_their_place(self):
        for text, key, expected in (
            ("{method: least}", "method", "expected a method (least-norm or least-peak)"),
            ("{weights: {A1: 0}}", "weights.A1", "a number > 0"),
            ("{weights: {A9: 1}}", "weights.A9", "nearest is 'A1'"),
            ("{weights: [1, 2]}", "weights", "one for each of the 3 actuators"),
            ("{limits: {A1: -1}}", "limits.A1", "≥ 0"),
            ("{limits: {A1: [2, 1]}}", "limits.A1", "[lowest, highest], the lower first"),
            ("{preload: {A1: 0}}", "preload.A1", "a number other than 0"),
            ("{limits: {A1: 1}, preload: {A1: 2}}", "torque_distribution", "a preload of 'A1' within its limits"),
            ("{limit: 3}", "limit", "nearest is 'limits'"),
        ):
            spec = self.write("spec.yaml", FIVE_BAR.spec(FIVE_BAR.joints, text))
            done = run("check", spec)
            self.assert_failure(done, 3, "torque_distribution", key, expected)
        self.write("spec.yaml", config("rr.yaml", (r"actuators: [^\n]*\n", "")) + "torque_distribution: {method: least-peak}\n")
        self.assertIn("'actuators'", run("check", self.path("spec.yaml")).stderr)


if __name__ == "__main__":
    unittest.main()
