"""`balance equations --solve` and `--only efforts`: the papers' solved forms, corrected as in docs/errata.md, are what is printed.

Every formula is parsed by sympy, which simplifies the difference from the paper's to zero."""

import json
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

DEPENDENT = """
space: planar
gravity: [0, -9.81]
parameters: {c: 0.2, x: "-c / 2", d: "2 * x + c / 10", m: 2, M: 3}
ground: {points: {O: [0, 0]}}
bodies:
  link: {mass: m, com: [c, 0], inertia: 0.04, points: {O: [0, 0]}}
counterweights:
  w: {body: link, at: [x, 0], mass: M}
  u: {body: link, at: [d, 0], mass: "3 * c"}
joints:
  J: {type: revolute, connects: [ground.O, link.O]}
actuators: [J]
"""


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
        self.assertEqual(sorted(answer["sections"][0]["nonzero"]), ["m1", "m2", "m3"])  # m3 lg3 = 0

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
        found, _ = equations(os.path.join(CONFIGS, "5r.yaml"), "--only", "inertia,gravity,efforts")
        U, D = found["efforts"], found["inertia"] | found["gravity"]
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

    def test_P0_eq_106_and_107(self):
        """Each leg balanced with its own payload: u = M' of the legs' constant inertias, coupled by eq. 105."""
        spec = self.write("legs.yaml", LEGS)
        names = ("x_cw11", "x_cw12", "x_cw21", "x_cw22")
        found, answer = self.solve(
            spec, "gyroscopic", *names, options=("--strategy", "modular", "--only", "solutions,efforts")
        )
        # the shares of a payload at a joint are multiplied by the leg's length, a number of this geometry
        lengths = {}
        for name in set(answer["symbols"]) & {"c1", "c2"}:
            length = min(("a11", "a21"), key=lambda one, c=name: abs(answer["symbols"][one] - answer["symbols"][c]))
            lengths[NAMES[name]] = NAMES[length]
        papers = {
            "x_cw12": "-(m2 lg2 + mp1 a12)/m_cw12",
            "x_cw11": "-(m1 lg1 + a11 (m2 + mp1 + m_cw12))/m_cw11",
            "x_cw22": "-(m4 lg4 + mp2 a22)/m_cw22",
            "x_cw21": "-(m3 lg3 + a21 (m4 + mp2 + m_cw22))/m_cw21",
        }
        for name, paper in papers.items():  # eq. 95
            self.assert_same(found["solutions"][name].subs(lengths), e(paper), name)
        # eq. 96
        I = {
            "I11": f"(Jz2 + a12^2 mp1 + m2 lg2^2 + m_cw12 ({papers['x_cw12']})^2)",
            "I12": f"(Jz1 + m1 lg1^2 + a11^2 (m2 + mp1 + m_cw12) + m_cw11 ({papers['x_cw11']})^2)",
            "I21": f"(Jz4 + a22^2 mp2 + m4 lg4^2 + m_cw22 ({papers['x_cw22']})^2)",
            "I22": f"(Jz3 + m3 lg3^2 + a21^2 (m4 + mp2 + m_cw22) + m_cw21 ({papers['x_cw21']})^2)",
        }
        M = {  # eq. 107
            "U11": f"{I['I12']} - sin(B1 + P) a11 {I['I11']}/(sin(P) a12)",
            "U12": f"-sin(B1 + P) a11 {I['I11']}/(sin(P) a12)",
            "U13": f"-sin(B1) a11 {I['I21']}/(sin(P) a22)",
            "U14": f"-sin(B1) a11 {I['I21']}/(sin(P) a22)",
            "U21": f"sin(B2) a21 {I['I11']}/(sin(P) a12)",
            "U22": f"sin(B2) a21 {I['I11']}/(sin(P) a12)",
            "U23": f"sin(B2 - P) a21 {I['I21']}/(sin(P) a22) + {I['I22']}",
            "U24": f"sin(B2 - P) a21 {I['I21']}/(sin(P) a22)",
        }
        for name, printed in found["efforts"].items():
            if name:  # eq. 106: no velocity terms, no weight
                self.assert_same(printed.subs(lengths), e(M.get(name, "0")), name)

    # P3

    def test_P3_eq_54_to_61(self):
        spec = os.path.join(CONFIGS, "3rrr.yaml")
        found, answer = self.solve(spec, "affine", *(f"bodies.crank{i}.com" for i in (1, 2, 3)))
        for i, j in ((1, 4), (2, 5), (3, 6)):  # the program counts couplers 4, 5, 6; P3 counts 2, 4, 6
            self.assert_same(found["solutions"][f"xg{i}"], e(f"-l (1 - lg{j}/l) m{j}/m{i}"))
            self.assert_same(found["solutions"][f"yg{i}"], sympy.Integer(0))
        self.assertEqual(found["solutions"][""], [])
        values = {one["name"]: one["value"] for one in answer["sections"][0]["formulas"]}
        for i in (1, 2, 3):
            self.assertAlmostEqual(values[f"xg{i}"], -0.09, places=12)  # eq. 61

    # mechanisms of no paper

    def test_berkof_lowen_four_bar(self):
        """Counterweights at given places get masses; at given masses, places: the first moments are those of Berkof and Lowen."""
        spec = self.write("four-bar.yaml", config("four-bar-force-balance.yaml",
            (r'at: \["radius \* cos\(phi1\)".*?\]', "at: [-0.1, -0.01]"), (r'at: \["radius \* cos\(phi2\)".*?\]', "at: [-0.1, 0.01]"),
            (r'mass: "rho \* coupler", com: \["coupler / 2", 0.02\]', "mass: 1.4, com: [0.17, 0.02]"),
        ))  # fmt: skip
        found, _ = self.solve(spec, "force", "cw1.at", "cw2.at")
        solved = found["solutions"]
        first = {
            "x_cw1": "-(crank m2 (1 - xg2/coupler) + rho crank^2/2)/m_cw1",
            "y_cw1": "crank m2 yg2/(coupler m_cw1)",
            "x_cw2": "-(rocker m2 xg2/coupler + rho rocker^2/2)/m_cw2",
            "y_cw2": "-rocker m2 yg2/(coupler m_cw2)",
        }
        self.assert_forms(solved, first)
        # the masses alone: one direction of each is a condition on the places
        found, answer = self.solve(spec, "force", "m_cw1", "m_cw2")
        self.assertEqual(len(found["solutions"][""]), 2)
        self.assertEqual(sorted(answer["sections"][0]["unsolved"], key=str), [])

    def test_a_spring_and_its_place_for_static_balance(self):
        """m g c = k h p along and across the link: linear in the stiffness, then in the place."""
        spec = os.path.join(CONFIGS, "spring-balancer-one-link.yaml")
        found, answer = self.solve(spec, "static", "k_s", "bodies.link.points.P[1]")
        self.assert_forms(found["solutions"], {"k_s": "g m1 xg1/(yS xP1)", "yP1": "xP1 yg1/xg1"})
        values = {one["name"]: one["value"] for one in answer["sections"][0]["formulas"]}
        self.assertAlmostEqual(values["k_s"], 130.8, places=9)  # as worked out in the config
        self.assertAlmostEqual(values["yP1"], 0.015, places=12)

    def test_units_of_the_spec(self):
        """Lengths in mm: the polynomial of a place holds the factor between the units."""
        text = config("rr-adaptive.yaml", (r"gravity: \[0, -9.81\]", "units: {length: mm}\ngravity: [0, -9810]"),
            (r"a1: 0.5, a2: 0.4, mp: 0.5", "a1: 500, a2: 400, mp: 0.5, x: -500"), (r"inertia: 0.042", "inertia: 42000"),
            (r"inertia: 0.02", "inertia: 20000"), (r"at: \[{free: \[-1, -0.05\]}, 0\], mass: 12", "at: [x, 0], mass: 12"),
            (r"at: \[{free: \[-1, -0.05\]}, 0\], mass: 4", "at: [-500, 0], mass: 4"),
            (r"\nmotion:.*", "\n"),
        )  # fmt: skip
        spec = self.write("mm.yaml", text)
        _, answer = self.solve(spec, "static", "x", "x_cw2")
        values = {one["name"]: one["value"] for one in answer["sections"][0]["formulas"]}
        # the header of rr-adaptive.yaml, at mp = 0.5: a parameter in the spec's units, a number of the mechanism in metres
        self.assertAlmostEqual(values["x_cw2"], -(0.075 + 0.1 * 0.5), places=12)
        self.assertAlmostEqual(values["x"], -1000 * (2 * 0.25 + 1.5 * 0.5 + 0.5 * 0.5 + 4 * 0.5) / 12, places=9)

    def test_parameters_that_depend_on_what_is_solved_for(self):
        """x = -c/2, d = 2 x + c/10 and the mass of u, 3 c: m c + M x + 3 c d = 0, which is solved for c as it is with --expand."""
        pendulum = self.write("pendulum.yaml", DEPENDENT)
        found, _ = self.solve(pendulum, "static", "M")
        self.assert_forms(found["solutions"], {"M": "-(m c + 3 c d)/x"})  # neither contains M
        expanded, _ = self.solve(pendulum, "static", "M", options=("--expand",))
        self.assert_forms(expanded["solutions"], {"M": "2 m - 27 c/5"})
        for options in ((), ("--expand",)):
            found, answer = self.solve(self.write("linear.yaml", DEPENDENT.replace('"3 * c"', "1")), "static", "c", options=options)
            # (m - M/2 - 9/10) c = 0: nothing else than c = 0
            self.assert_forms(found["solutions"], {"c": "0"})
            self.assertEqual(len(answer["sections"][0]["nonzero"]), 1)

    def test_parameters_of_a_loop_that_depend_on_what_is_solved_for(self):
        """Berkof and Lowen's first condition, with the coupler's centre of mass at coupler - c."""
        spec = self.write("four-bar.yaml", config("four-bar.yaml",
            (r"turn: ", "c: 0.2, behind: \"coupler - c\", turn: "), (r'com: \["coupler / 2", 0\]', "com: [behind, 0]"),
            (r'com: \["crank / 2", 0\]', "com: [-0.3, 0]"),
        ))  # fmt: skip
        found, _ = self.solve(spec, "force", "c")
        self.assert_forms(found["solutions"], {"c": "-lg1 crank rho/(rho coupler crank) coupler"})

    def test_what_is_no_polynomial_of_an_unknown_is_named(self):
        spec = self.write("pendulum.yaml", DEPENDENT.replace('"-c / 2"', '"-sqrt(c) / 2"'))
        done = run("equations", spec, "--solve", "c", "--goal", "static")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("the conditions cannot be solved for c: x, which they contain, is a function of it that is no polynomial",
                      unwrapped(done.stderr))  # fmt: skip

    def test_the_name_that_is_asked_for_is_answered(self):
        """The gravity at which a spring balances a link: g m c = k h p."""
        spec = self.write("balancer.yaml", config("spring-balancer-one-link.yaml", (r"stiffness: \{.*?\}", "stiffness: 130.8")))
        found, answer = self.solve(spec, "static", "g", "bodies.link.points.P[1]")
        self.assert_forms(found["solutions"], {"g": "k_s yS xP1/(m1 xg1)"})
        self.assertIn("yP1 is bodies.link.points.P[1]", answer["notes"])
        values = {one["name"]: one["value"] for one in answer["sections"][0]["formulas"]}
        self.assertAlmostEqual(values["g"], 9.81, places=9)

    def test_conditions_that_no_masses_meet_are_no_failure_of_the_check(self):
        """Without counterweights, the rocker's condition asks for masses that vanish: the crank's solution stands, unchecked."""
        answer = json.loads(run("equations", os.path.join(CONFIGS, "four-bar.yaml"), "--solve", "bodies.crank.com", "--goal", "force",
                                "--json").stdout)  # fmt: skip
        values = {one["name"]: one.get("value") for one in answer["sections"][0]["formulas"]}
        # m1 c1 = -m2 crank (1 - c2/coupler), with c2 = coupler/2
        self.assertAlmostEqual(values["xg1"], -0.35 / 2, places=12)
        self.assertAlmostEqual(values["yg1"], 0, places=12)
        # the conditions of the moment ask for rods without mass, which were divided by
        text = unwrapped(run("equations", os.path.join(CONFIGS, "four-bar.yaml"), "--solve", "bodies.crank.com", "--goal", "dynamic").stdout)
        self.assertIn("rho = 0 a contradiction: no values of these numbers meet the goal", text)

    # what is not solved

    def test_what_stays_free_and_what_remains(self):
        spec = os.path.join(CONFIGS, "planar-rrr-belts.yaml")
        places = ("--set", "lg1=-0.5", "--set", "lg2=-0.2")  # instead of the expressions that meet the conditions for any masses
        text = unwrapped(run("equations", spec, "--solve", "m1,m2,m3", "--goal", "static", *places).stdout)
        self.assertIn("m3 stays free", text)
        self.assertIn("where lg1, lg2 are not 0", text)
        text = unwrapped(run("equations", spec, "--solve", "lg1", "--goal", "static").stdout)
        self.assertIn("m2 lg2 + m3 l2 = 0", text)
        self.assertIn("remains to be met", text)
        text = unwrapped(run("equations", spec, "--solve", "lg2,J5", "--goal", "static").stdout)
        self.assertIn("J5 occurs in none of the conditions", text)
        text = unwrapped(run("equations", os.path.join(CONFIGS, "rr-adaptive.yaml"), "--solve", "a2", "--goal", "decoupled").stdout)
        self.assertIn("a2", text)

    def test_a_condition_that_is_not_linear(self):
        spec = os.path.join(CONFIGS, "scara.yaml")
        text = unwrapped(run("equations", spec, "--solve", "l2", "--goal", "decoupled", "--set", "lg2=0").stdout)
        self.assertIn("l2 = ", text)  # linear in the static condition, quadratic in the other

    def test_latex_and_text_and_errors(self):
        spec = os.path.join(CONFIGS, "planar-rrr-belts.yaml")
        latex = run("equations", spec, "--solve", "beta,lg1,lg2", "--latex")
        self.assert_quiet_success(latex)
        self.assertIn(r"\beta = -", latex.stdout)
        self.assertIn(r"l_{g1} = -", latex.stdout)
        self.assertIn(r"m_{1} \neq 0", latex.stdout)
        text = run("equations", spec, "--solve", "beta,lg1,lg2")
        self.assertRegex(text.stdout, r"the solution meets the engine's conditions with 2 sets of other\s+numbers: \d+e-\d+")
        self.assert_failure(run("equations", spec, "--solve", "betta"), 2, "'betta'", "beta")
        self.assert_failure(run("equations", spec, "--only", "solutions"), 2, "--solve")
        self.assert_failure(run("equations", spec, "--goal", "static"), 2, "--solve")
        self.assert_failure(run("equations", spec, "--at", "start", "--solve", "beta"), 2, "--solve")


LEGS = """
space: planar
gravity: [0, -9.81]
parameters: {a11: 0.3, a12: 0.45, a21: 0.32, a22: 0.42, base: 0.4, mp1: 0.3, mp2: 0.31}
ground: {points: {A1: [0, 0], A2: [base, 0]}}
bodies:
  crank1:   {mass: 1.2, com: [0.15, 0], inertia: 0.01, points: {A: [0, 0], B: [a11, 0]}}
  coupler1: {mass: 0.9, com: [0.2, 0], inertia: 0.016, points: {B: [0, 0], P: [a12, 0]}}
  crank2:   {mass: 1.3, com: [0.16, 0], inertia: 0.012, points: {A: [0, 0], B: [a21, 0]}}
  coupler2: {mass: 0.8, com: [0.21, 0], inertia: 0.013, points: {B: [0, 0], P: [a22, 0]}}
payloads:
  cargo1: {body: coupler1, at: P, mass: mp1}
  cargo2: {body: coupler2, at: P, mass: mp2}
counterweights:
  cw11: {body: crank1, at: [-0.12, 0], mass: 10}
  cw12: {body: coupler1, at: [-0.15, 0], mass: 2}
  cw21: {body: crank2, at: [-0.12, 0], mass: 10}
  cw22: {body: coupler2, at: [-0.15, 0], mass: 2}
joints:
  A1: {type: revolute, connects: [ground.A1, crank1.A]}
  B1: {type: revolute, connects: [crank1.B, coupler1.B]}
  A2: {type: revolute, connects: [ground.A2, crank2.A]}
  B2: {type: revolute, connects: [crank2.B, coupler2.B]}
  P:  {type: revolute, connects: [coupler1.P, coupler2.P]}
actuators: [A1, A2]
assembly: {A1: 2.3, B1: -1.5, A2: 0.8, B2: 1.4}
"""


if __name__ == "__main__":
    unittest.main()
