"""`balance equations --solve` and `--only torques`: the papers' solved forms, corrected as in docs/errata.md, are what is printed.

Every formula is parsed by sympy, which simplifies the difference from the paper's to zero."""

import os
import unittest

import sympy
from _formulas import NAMES, equations, parse
from _program import CONFIGS, Case, config, run, unwrapped

# P1 section 3.1: discs on the base, which load nothing, and a third link whose CoM may be anywhere on its axis.
PLANAR = ("planar-rrr-belts.yaml", (r"inertia: 0\.08", "inertia: J1"), (r"parameters:\n", "parameters:\n  J1: 0.08\n"))
# P1 section 3.2: the discs' masses belong to link 1, and their inertia has three moments.
SPATIAL = (
    "spatial-rrr.yaml",
    (r"  d4: .*?\n  d5: .*?\n", """  d4: {body: link2, at: [0, 0, 0], follows: J3, ratio: 1, mass: 0.5, inertia: [Jx4, 0.0011, 0.0012]}
  d5: {body: link2, at: [0, 0, 0], follows: J3, ratio: beta, mass: 0.8, inertia: [Jx5, 0.0026, 0.0027]}
"""),
)  # fmt: skip


def e(text):
    return parse(text)


class Forms(Case):
    def solve(self, spec, goal, *names, options=()):
        found, answer = equations(spec, "--solve", ",".join(names), "--goal", goal, *options)
        self.assertGreater(answer["solution_checked"]["states"], 0, answer["notes"])
        self.assertLess(answer["solution_checked"]["error"], 1e-9)
        return found, answer

    def assert_same(self, printed, paper, name=""):
        self.assertEqual(sympy.simplify(printed - paper), 0, f"{name}: {printed} is not {paper}")

    def assert_forms(self, found, papers):
        for name, paper in papers.items():
            self.assert_same(found[name], e(paper), name)

    # P1, planar arm

    def planar(self):
        return self.write("planar.yaml", config(*PLANAR))

    def test_P1_eq_20(self):
        found, answer = self.solve(self.planar(), "static", "lg1", "lg2", "lg3")
        self.assert_forms(found["solutions"], {"lg1": "-l1 (m2 + m3)/m1", "lg2": "-l2 m3/m2", "lg3": "0"})
        self.assertEqual(found["solutions"][""], [])
        self.assertEqual(sorted(answer["sections"][0]["nonzero"]), ["m1", "m2", "m3"])

    def test_P1_eq_26_and_28(self):
        found, _ = self.solve(self.planar(), "decoupled", "lg1", "lg2", "lg3", "beta", "gamma")
        X = "(J2 + J3 + J4 + J6 + J7 + m3 l2^2 + m3^2 l2^2/m2)"
        self.assert_forms(found["solutions"], {"beta": f"-{X}/J5", "gamma": "-(J3 + J6)/J7"})
        self.assert_forms(
            found["balanced"],
            {
                "k1": "J1 + J2 + J3 + J4 + J5 + J6 + J7 + m2 l1^2 + m3 (l1^2 + l2^2) + l1^2 (m2 + m3)^2/m1 + l2^2 m3^2/m2",
                "k2": f"{X} + {X}^2/J5",
                "k3": "(J3 + J6) (J3 + J6 + J7)/J7",
            },
        )

    # P1, spatial arm; eq. 37 and 39 as corrected

    def test_P1_eq_30_37_and_39(self):
        names = ("lg2", "xg3", "yg3", "zg3", "beta", "Jy2", "Jy3", "Jy_d4", "Jy_d5")
        found, answer = self.solve(self.write("spatial.yaml", config(*SPATIAL)), "decoupled", *names)
        X = "m3 l2^2 (1 + m3/m2)"
        self.assert_forms(
            found["solutions"],
            {
                "lg2": "-l2 m3/m2",
                "yg3": "0",
                "zg3": "0",
                "beta": "-(Jx3 + Jx4)/Jx5",
                "Jy2": f"Jz2 + {X}",
                "Jy3": "Jz3",
                "Jy_d4": "Jz_d4",
                "Jy_d5": "Jz_d5",
            },
        )
        # the discs' own masses load link 1, which P1 counts there
        self.assert_forms(
            found["balanced"],
            {
                "k1": f"Jz1 + Jz2 + Jz3 + Jz_d4 + Jz_d5 + m2 l1^2 + m3 l1^2 + {X} + (m_d4 + m_d5) l1^2",
                "k2": f"Jx2 + Jx3 + Jx4 + Jx5 + {X}",
                "k3": "(Jx3 + Jx4) (Jx3 + Jx4 + Jx5)/Jx5",
            },
        )

    # P1, SCARA: the slider on joint 2's axis as printed, and at l2 as corrected

    def test_P1_eq_41_47_and_49(self):
        for X, changes in (("m3 l2^2 (1 + m3/m2)", ()), ("0", ((r"l2: 0\.3", "l2: 0"),))):
            spec = self.write("scara.yaml", config("scara.yaml", *changes))
            found, _ = self.solve(spec, "decoupled", "lg1", "lg2", "beta")
            lg2 = "-l2 m3/m2"
            at = {NAMES["l2"]: 0} if X == "0" else {}
            papers = {"lg1": "-l1 (m2 + m3)/m1", "lg2": lg2, "beta": f"-(J2 + J3 + J4 + {X})/J5"}
            for name, paper in papers.items():
                self.assert_same(found["solutions"][name].subs(at), e(paper).subs(at), name)
            constants = {
                "k1": f"Jz1 + J2 + J3 + J4 + J5 + {X} + (m2 + m3) l1^2 + l1^2 (m2 + m3)^2/m1",
                "k2": f"(J2 + J3 + J4 + {X}) (J2 + J3 + J4 + J5 + {X})/J5",
                "k3": "m3",
            }
            for name, paper in constants.items():
                self.assert_same(found["balanced"][name].subs(at), e(paper), name)

    # P0

    def test_P0_eq_95_and_the_adaptive_law_of_the_RR_arm(self):
        changes = (
            (r"parameters: {a1: 0.5, a2: 0.4, mp: 0.5}",
             "parameters: {a1: 0.5, a2: 0.4, mp: 0.5, m1: 2, m2: 1.5, c1: 0.5, c2: 0.5, M3: 12, M4: 4, x3: -0.5, x4: -0.5}"),
            (r"mass: 2, com: \[\"a1 / 2\"", 'mass: m1, com: ["c1 * a1"'),
            (r"mass: 1.5, com: \[\"a2 / 2\"", 'mass: m2, com: ["c2 * a2"'),
            (r"at: \[{free: \[-1, -0.05\]}, 0\], mass: 12", "at: [x3, 0], mass: M3"),
            (r"at: \[{free: \[-1, -0.05\]}, 0\], mass: 4", "at: [x4, 0], mass: M4"),
            (r"\ndesign:.*", "\ndesign: {goal: static}\n"),
        )  # fmt: skip
        spec = self.write("adaptive.yaml", config("rr-adaptive.yaml", *changes))
        found, _ = self.solve(spec, "static", "x3", "x4")
        law = {"x4": "-a2 (m2 c2 + mp)/M4", "x3": "-a1 (m1 c1 + m2 + mp + M4)/M3"}
        self.assert_forms(found["solutions"], law)
        # eq. 96, 98: with gamma_3 = -x3 / a1 and gamma_4 = -x4 / a2
        found, _ = self.solve(spec, "gyroscopic", "x3", "x4")
        I1 = f"(a2^2 (m2 c2^2 + mp) + M4 ({law['x4']})^2 + Jz2)"
        I2 = f"(a1^2 (m1 c1^2 + m2 + mp + M4) + M3 ({law['x3']})^2 + Jz1)"
        self.assert_forms(found["balanced"], {"D11": f"{I1} + {I2}", "D12": I1, "D22": I1, "D112": "0", "D1": "0", "D2": "0"})

    def rational(self, expression):
        """Without circular functions: cos = (1 - t^2)/(1 + t^2), sin = 2 t/(1 + t^2), with P = -A1 + A2 + B2 - B1."""
        t = {name: sympy.Symbol("t_" + name) for name in ("A1", "B1", "A2", "P")}
        B2 = NAMES["P"] + NAMES["A1"] + NAMES["B1"] - NAMES["A2"]
        expression = sympy.expand_trig(sympy.expand(expression.subs(NAMES["B2"], B2), trig=False))
        values = {}
        for name, half in t.items():
            values[sympy.sin(NAMES[name])] = 2 * half / (1 + half**2)
            values[sympy.cos(NAMES[name])] = (1 - half**2) / (1 + half**2)
        return expression.subs(values)

    def assert_same_at_poses(self, printed, paper, name):
        self.assertEqual(sympy.cancel(sympy.together(self.rational(printed - paper))), 0, name)

    def test_P0_eq_108_and_109(self):
        found, _ = equations(os.path.join(CONFIGS, "5r.yaml"), "--only", "inertia,gravity,torques")
        U, D = found["torques"], found["inertia"] | found["gravity"]
        # the legs' own numbers, eq. 90: M = [[I1 + I2 + 2 cos I3, I1 + cos I3], [., I1]], z = [mu1 cos + mu2 cos(+), mu2 cos(+)]
        I11, I21 = D["D22"], D["D44"]
        cos, sin = sympy.cos, sympy.sin
        A1, B1, A2, B2, P = (NAMES[n] for n in ("A1", "B1", "A2", "B2", "P"))
        I13, I23 = ((D[d] - one) / cos(q) for d, one, q in (("D12", I11, B1), ("D34", I21, B2)))
        I12, I22 = (D[d] - one - 2 * cos(q) * three for d, one, q, three in (("D11", I11, B1, I13), ("D33", I21, B2, I23)))
        mu12, mu22 = D["D2"] / cos(A1 + B1), D["D4"] / cos(A2 + B2)
        mu11, mu21 = (D["D1"] - D["D2"]) / cos(A1), (D["D3"] - D["D4"]) / cos(A2)
        a11, a12, a21, a22 = (NAMES[n] for n in ("a11", "a12", "a21", "a22"))
        csc = 1 / sin(P)
        first = {
            "U11": I12 + cos(B1) * I13 - csc * sin(B1 + P) * a11 * (I11 + cos(B1) * I13) / a12,
            "U12": cos(B1) * I13 - csc * sin(B1 + P) * a11 * I11 / a12,
            "U13": -csc * sin(B1) * a11 * (I21 + cos(B2) * I23) / a22,
            "U14": -csc * sin(B1) * a11 * I21 / a22,
            # the brackets behind 1/(a12 a22), as corrected: velocities and weight
            "U111": -I13 * sin(B1) - csc * a11 * sin(P + B1) * I13 * sin(B1) / a12,
            "U112": -I13 * sin(B1),
            "U122": -I13 * sin(B1),
            "U133": -a11 * sin(B1) * csc * I23 * sin(B2) / a22,
            "U1": mu11 * cos(A1) - a11 * sin(B1) * csc * mu22 * cos(A2 + B2) / a22
            - a11 * sin(P + B1) * csc * mu12 * cos(A1 + B1) / a12,
        }
        second = {
            "U21": csc * sin(B2) * a21 * (I11 + cos(B1) * I13) / a12,
            "U22": csc * sin(B2) * a21 * I11 / a12,
            "U23": csc * sin(B2 - P) * a21 * (I21 + cos(B2) * I23) / a22 + I22 + cos(B2) * I23,
            "U24": csc * sin(B2 - P) * a21 * I21 / a22 + cos(B2) * I23,
            "U211": a21 * csc * sin(B2) * I13 * sin(B1) / a12,
            "U233": -I23 * sin(B2) + a21 * csc * sin(B2 - P) * I23 * sin(B2) / a22,
            "U234": -I23 * sin(B2),
            "U244": -I23 * sin(B2),
            "U2": mu21 * cos(A2) + a21 * csc * sin(B2 - P) * mu22 * cos(A2 + B2) / a22
            + a21 * csc * sin(B2) * mu12 * cos(A1 + B1) / a12,
        }
        for name, paper in (first | second).items():
            self.assert_same_at_poses(U[name], paper, name)
        for name in set(U) - set(first) - set(second) - {""}:
            self.assert_same_at_poses(U[name], sympy.Integer(0), name)


if __name__ == "__main__":
    unittest.main()
