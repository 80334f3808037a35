"""`balance equations --speeds --constraints`: quasi-velocities and rolling, held against closed forms and differences."""

import json
import math
import os
import unittest

import numpy as np

from _program import CONFIGS, Case, run

CART = os.path.join(CONFIGS, "poses", "cart-two-wheels.yaml")
FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")

# A disc on a plane: heading and place of the point that it touches, its lean, its spin. What has these is light: 1e-9 of the disc.
DISC = """
space: spatial
gravity: [0, 0, -9.81]
ground: {points: {O: [0, 0, 0]}}
bodies:
  contact: {mass: 1.0e-9, com: [0, 0, 0], inertia: [1.0e-11, 1.0e-11, 1.0e-11], points: {K: [0, 0, 0]}}
  frame: {mass: 1.0e-9, com: [0, 0, 0], inertia: [1.0e-11, 1.0e-11, 1.0e-11], points: {K: [0, 0, 0], C: [0, 0, 0.3]}}
  disc: {mass: 2, com: [0, 0, 0], inertia: [0.05, 0.09, 0.05], points: {C: [0, 0, 0]}}
joints:
  P: {type: planar, connects: [ground.O, contact.K]}
  T: {type: revolute, connects: [contact.K, frame.K], axis: [1, 0, 0]}
  S: {type: revolute, connects: [frame.C, disc.C], axis: [0, 1, 0]}
actuators: [S]
tool: contact.K
"""
ROLLS = ("--speeds", "P: tool.r, T: T, S: S", "--constraints", "roll: {tool.u: 1, S: -0.3}, side: tool.v")

PENDULUM = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  a: {mass: 2, com: [0.2, 0], inertia: 0.03, points: {A: [0, 0], B: [0.5, 0]}}
  b: {mass: 1, com: [0.15, 0], inertia: 0.01, points: {B: [0, 0], H: [0.4, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
actuators: [A, B]
tool: b.H
"""


def forms(terms, speeds):
    return np.einsum("krs,r,s->k", np.array(terms["D"]), speeds, speeds)


class Speeds(Case):
    def answer(self, spec, at, *call):
        done = run("equations", spec, "--at", at, "--only", "inertia,velocity,gravity", "--json", *call)
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def refused(self, code, words, *call):
        done = run("equations", *call)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertIn(words, done.stderr)

    def close(self, found, expected, scale=1):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * scale)

    def test_absolute_angles_of_a_pendulum(self):
        """m2 l1 c2 is between the links; no products of two speeds, as the textbooks have it."""
        q = 0.7
        found = self.answer(self.write("p.yaml", PENDULUM), f"A=0.3,B={q}", "--speeds", "f: A, s: {A: 1, B: 1}")["in_speeds"]
        between = 1 * 0.5 * 0.15
        first, second = 0.03 + 2 * 0.2**2 + 1 * 0.5**2, 0.01 + 1 * 0.15**2
        self.close(found["M"], [[first, between * math.cos(q)], [between * math.cos(q), second]])
        self.close(found["D"], [[[0, 0], [0, -between * math.sin(q)]], [[between * math.sin(q), 0], [0, 0]]])
        self.close(found["z"]["sum"], [9.81 * (2 * 0.2 + 0.5) * math.cos(0.3), 9.81 * 0.15 * math.cos(0.3 + q)], 10)
        self.close(found["input"], [[1, -1], [0, 1]])

    def test_the_tools_speeds_by_differences_of_its_jacobian(self):
        """w = V^T (D q' q' - M V W' q') with W' by differences, on loops and on an open arm, along the body's and the world's axes."""
        cases = [(self.write("p.yaml", PENDULUM), "AB", (0.3, 0.9), "x: tool.x, y: tool.y"),
                 (self.write("p.yaml", PENDULUM), "AB", (0.3, 0.9), "u: tool.u, v: {tool.v: 2, A: 0.1}"),
                 (FIVE_BAR, ("A1", "A2"), None, "x: tool.x, y: tool.y")]
        for spec, names, q, speeds in cases:
            def at(values, names=names, spec=spec, speeds=speeds):
                pose = ",".join(f"{name}={value!r}" for name, value in zip(names, values))
                return self.answer(spec, pose, "--speeds", speeds)
            start = at(q) if q else self.answer(spec, "start", "--speeds", speeds)
            q = np.array(start["q"])
            told = start["in_speeds"]
            W, V = np.array(told["rows"]), np.array(told["rates"])
            self.close(W @ V, np.eye(2))
            self.close(V.T @ start["M"] @ V, told["M"], np.abs(told["M"]).max())
            for sigma in ((1, 0), (0, 1), (0.7, -1.1)):
                rates, h = V @ sigma, 1e-3 / np.linalg.norm(V @ sigma)
                rows = [np.array(at(q + k * h * rates)["in_speeds"]["rows"]) for k in (-2, -1, 1, 2)]
                W_rate = (rows[0] - 8 * rows[1] + 8 * rows[2] - rows[3]) / (12 * h)
                expected = V.T @ (forms(start, rates) - np.array(start["M"]) @ V @ W_rate @ rates)
                # differences of fourth order: the step to the fourth, and round-off over the step
                np.testing.assert_allclose(forms(told, sigma), expected, rtol=1e-7, atol=1e-8 * np.abs(expected).max())

    def test_a_cart_that_rolls_is_a_unicycle(self):
        """F = m v' - m_c d w^2, M = I w' + m_c d v w; the side force is m v w + m_c d w'; wheels by hand."""
        mc, mw, d, b, r = 8, 0.7, 0.15, 0.2, 0.1
        spin, across = 0.0035, 0.002
        for heading in (0, 1.1):
            call = ("--independent", "P.x,P.y,P.angle,A,B", "--speeds", "v: tool.u, w: tool.r", "--constraints",
                    f"left: {{tool.u: 1, tool.r: -{b}, A: -{r}}}, right: {{tool.u: 1, tool.r: {b}, B: -{r}}}, side: tool.v")
            told = self.answer(CART, f"P.x=0.4,P.y=-1,P.angle={heading},A=0.3,B=2", *call)["in_speeds"]
            mass = mc + 2 * mw
            turning = 0.25 + mc * d**2 + 2 * (across + mw * b**2)
            self.close(told["M"], np.diag([mass + 2 * spin / r**2, turning + 2 * spin * b**2 / r**2]), 10)
            self.close(told["D"], [[[0, 0], [0, -mc * d]], [[0, mc * d / 2], [mc * d / 2, 0]]])
            self.close(told["input"], [[1 / r, 1 / r], [-b / r, b / r]], 10)
            self.close(told["z"]["sum"], [0, 0])
            left, right, side = (np.array(row) for row in told["held"]["M"])
            self.close(left, [-spin / r**2, spin * b / r**2])
            self.close(right, [-spin / r**2, -spin * b / r**2])
            self.close(side, [0, mc * d], 10)
            self.close(told["held"]["D"][2], [[0, mass / 2], [mass / 2, 0]], 10)
            self.close(told["held"]["input"], [[-1 / r, 0], [0, -1 / r], [0, 0]], 10)

    def test_a_cart_goes_along_arcs(self):
        """Rates of the coordinates are those of a unicycle: with v and w constant these are exact arcs."""
        told = self.answer(CART, "P.x=0,P.y=0,P.angle=0.6,A=0,B=0", "--independent", "P.x,P.y,P.angle,A,B", "--speeds",
                           "v: tool.u, w: tool.r", "--constraints",
                           "left: {tool.u: 1, tool.r: -0.2, A: -0.1}, right: {tool.u: 1, tool.r: 0.2, B: -0.1}, side: tool.v")
        v, w = 1.3, 0.7
        rates = np.array(told["in_speeds"]["rates"]) @ [v, w]
        self.close(rates, [v * math.cos(0.6), v * math.sin(0.6), w, (v - 0.2 * w) / 0.1, (v + 0.2 * w) / 0.1], 10)

    def test_a_disc_rolls_in_a_circle(self):
        """With the lean t, turning P and the spin S: A P^2 cos t sin t - (C + m r^2) P (S + P sin t) cos t = m g r sin t."""
        spec = self.write("disc.yaml", DISC)
        A, C, m, r, g = 0.05, 0.09, 2, 0.3, 9.81
        for lean, turning, heading in ((0.2, -1.5, 0), (0.5, -2, 0.8), (-0.3, 1, 2)):
            told = self.answer(spec, f"P.x=1,P.y=2,P.angle={heading},T={lean},S=0.4", "--independent", "P.x,P.y,P.angle,T,S",
                               *ROLLS)["in_speeds"]
            c, s = math.cos(lean), math.sin(lean)
            total = (A * turning**2 * c * s - m * g * r * s) / ((C + m * r**2) * turning * c)
            speeds = np.array([turning, 0, total - turning * s])
            self.close(forms(told, speeds) + told["z"]["sum"], [0, 0, 0], 1e3)
            # the ground pushes towards the circle's centre with m a
            side = forms(told["held"], speeds)[1] + told["held"]["z"]["sum"][1]
            self.close(side, m * turning * r * total, 1e3)

    def test_constraints_do_no_work(self):
        """The kinetic energy changes by the inertial forces' power: s w(s) = s M' s / 2 along the motion that rolls."""
        spec = self.write("disc.yaml", DISC)
        names = ("P.x", "P.y", "P.angle", "T", "S")

        def at(q):
            pose = ",".join(f"{name}={value!r}" for name, value in zip(names, q))
            return self.answer(spec, pose, "--independent", ",".join(names), *ROLLS)["in_speeds"]
        q, sigma, h = np.array([0.2, 0.1, 0.5, 0.4, 1.0]), np.array([0.9, 0.8, -1.7]), 1e-3
        here = at(q)
        way = np.array(here["rates"]) @ sigma
        M = [np.array(at(q + k * h * way)["M"]) for k in (-2, -1, 1, 2)]
        M_rate = (M[0] - 8 * M[1] + 8 * M[2] - M[3]) / (12 * h)
        power = sigma @ M_rate @ sigma / 2
        self.assertGreater(abs(power), 1e-3)
        self.assertAlmostEqual(sigma @ forms(here, sigma), power, delta=1e-9)

    def test_text_names_speeds_and_constraints(self):
        done = run("equations", self.write("disc.yaml", DISC), "--at", "P.x=0,P.y=0,P.angle=0,T=0.2,S=0", "--independent",
                   "P.x,P.y,P.angle,T,S", "--only", "inertia,velocity,gravity,torques", *ROLLS)
        self.assert_quiet_success(done)
        for words in ("in the speeds P, T, S; zero: roll, side", "freedoms: 5 of configuration, 3 of velocity", "forces of the constraints, efforts apart", "P^2", "P S"):
            self.assertIn(words, done.stdout)

    def test_formulas_share_no_name_with_parameters(self):
        """What the formulas name is called differently where a parameter has the name."""
        speeds = ("--only", "speeds", "--speeds", "x: {tool.x: 1, A: 0.3}, y: tool.y")
        for name in ("Delta", "V11", "M11", "D11"):
            named = PENDULUM.replace("ground:", f"parameters: {{{name}: 0.5}}\nground:").replace("B: [0.5, 0]", f"B: [{name}, 0]")
            done = run("equations", self.write("p.yaml", named), *speeds)
            self.assert_quiet_success(done)
            self.assertIn(f"{name}_ = ", done.stdout)

    def test_a_note_names_what_must_not_vanish(self):
        """The tool's speeds along x and y do not determine the motion of an arm that is stretched."""
        done = run("equations", self.write("p.yaml", PENDULUM), "--only", "speeds", "--speeds", "x: tool.x, y: tool.y")
        self.assert_quiet_success(done)
        note = "".join(line for line in done.stdout.splitlines() if line.startswith("note: where"))
        self.assertRegex(note, r"sin\(B\) vanishes|Delta vanishes")
        done = run("equations", self.write("p.yaml", PENDULUM), "--only", "speeds", "--speeds", "f: A, s: {A: 1, B: 1}")
        self.assertNotIn("note: where", done.stdout)

    def test_equal_factors_of_speeds_are_one_symbol(self):
        done = run("equations", self.write("p.yaml", PENDULUM), "--only", "speeds", "--speeds", "x: {A: 0.12345678, B: 0.12345678}, y: B")
        self.assert_quiet_success(done)
        self.assertIn("f = 0.123457", done.stdout)
        self.assertNotIn("f_", done.stdout)

    def test_what_cannot_be_is_refused(self):
        spec = self.write("p.yaml", PENDULUM)
        pose = (spec, "--at", "A=0.3,B=0.5")
        self.refused(2, "as many as the degrees of freedom, 2; they are 1 and 0", *pose, "--speeds", "x: tool.x")
        self.refused(2, "expected a joint coordinate, or a component (x, y, u, v or angle) of the motion of the tool", *pose, "--speeds", "x: tool.z, y: A")
        self.refused(2, "--speeds", *pose, "--speeds", "x: {A: 1")
        self.refused(2, "at least one speed", *pose, "--speeds", "{}")
        self.refused(2, "found an empty text", *pose, "--speeds", "")
        self.refused(2, "held must be fewer", *pose, "--speeds", "x: A, y: B", "--constraints", "z: tool.x, w: tool.y")
        self.refused(2, "'x'", *pose, "--speeds", "x: A", "--constraints", "x: B")
        self.refused(2, "expected a number", *pose, "--speeds", "x: {A: {free: [0, 1]}}, y: B")
        self.refused(4, "overflow", *pose, "--speeds", "x: {A: 1.0e-200}, y: B")
        self.refused(2, "--output and --speeds cannot be combined", *pose, "--speeds", "x: A, y: B", "-o", self.path("a.h5"))
        self.refused(2, "--at", spec, "--constraints", "x: A")
        self.refused(2, "at least one term", *pose, "--speeds", "x: {}, y: A")
        self.refused(2, "a number", *pose, "--speeds", "x: {A: oops}, y: A")
        self.refused(4, "do not determine the mechanism's motion there", *pose, "--speeds", "x: A, y: {A: 2}")
        self.refused(4, "do not determine the mechanism's motion there", spec, "--at", "A=0.3,B=0", "--speeds", "x: tool.x, y: tool.y")
        self.refused(2, "--speeds", *pose, "--speeds", "x: tool.x, y: tool.y", "--latex")
        self.refused(2, "--constraints", *pose, "--constraints", "x: tool.x")
        lame = self.write("lame.yaml", PENDULUM.replace("tool: b.H\n", ""))
        self.refused(2, "need a tool", lame, "--at", "A=0.3,B=0.5", "--speeds", "x: tool.x, y: tool.y")
        self.refused(2, "closes a loop", FIVE_BAR, "--at", "start", "--speeds", "x: P, y: A1")


if __name__ == "__main__":
    unittest.main()
