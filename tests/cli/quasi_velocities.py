"""Quasi-velocities: of the centre of mass, with factors that depend on the pose, redundant sets; as formulas, in conditions, in control."""

import json
import math
import os
import re
import unittest

import h5py
import numpy as np

from _formulas import parse
from _program import CONFIGS, Case, run

FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")

ARM = """
space: planar
gravity: [0, -9.81]
parameters: {l1: 0.5, l2: 0.4}
ground: {points: {O: [0, 0]}}
bodies:
  a: {mass: 2, com: [0.2, 0.03], inertia: 0.03, points: {A: [0, 0], B: [l1, 0]}}
  b: {mass: 1, com: [0.15, 0], inertia: 0.01, points: {B: [0, 0], H: [l2, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
springs: {s: {joint: B, stiffness: 3}}
actuators: [A, B]
tool: b.H
motion: {duration: 1, samples: 201, from: {joints: {A: 0.3, B: 0.9}}, to: {joints: {A: 1, B: 1.4}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""

PLATE = """
space: planar
gravity: [0, 0]
parameters: {h: 0.2, k: 0.1}
ground: {points: {O: [0, 0]}}
bodies:
  plate: {mass: 2, com: [0.12, -0.05], inertia: 0.03, points: {C: [0, 0], H: [h, k]}}
joints:
  P: {type: planar, connects: [ground.O, plate.C]}
actuators: [P.x, P.y, P.angle]
tool: plate.H
"""

SLIDES = """
space: planar
gravity: [0, 0]
ground: {{points: {{O: [0, 0]}}}}
bodies:
  a: {{mass: {mass}, com: [0, 0], inertia: 0, points: {{O: [0, 0]}}}}
  b: {{mass: {mass}, com: [0, 0], inertia: 0, points: {{O: [0, 0]}}}}
joints:
  A: {{type: prismatic, connects: [ground.O, a.O], axis: [1, 0]}}
  B: {{type: prismatic, connects: [a.O, b.O], axis: [0, 1]}}
actuators: [A, B]
"""

# An arm in space: a turntable, a shoulder and a slide.
SPATIAL = """
space: spatial
gravity: [0, 0, -9.81]
ground: {points: {O: [0, 0, 0]}}
bodies:
  table: {mass: 2, com: [0.02, 0.01, 0.1], inertia: [0.02, 0.03, 0.04], points: {O: [0, 0, 0], S: [0.05, 0, 0.3]}}
  arm: {mass: 1, com: [0.2, 0, 0.01], inertia: [0.004, 0.03, 0.03], points: {S: [0, 0, 0], E: [0.3, 0, 0]}}
  rod: {mass: 0.5, com: [0.1, 0, 0], inertia: [0.001, 0.01, 0.01], points: {E: [0, 0, 0], H: [0.2, 0.01, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, table.O]}
  B: {type: revolute, connects: [table.S, arm.S], axis: [0, 1, 0]}
  S: {type: prismatic, connects: [arm.E, rod.E], axis: [1, 0, 0]}
actuators: [A, B, S]
tool: rod.H
"""


def forms(matrices, speeds):
    return np.einsum("krs,r,s->k", np.array(matrices), speeds, speeds)


class QuasiVelocities(Case):
    def at(self, spec, pose, *call):
        done = run("equations", spec, "--at", pose, "--only", "inertia,velocity,gravity", "--json", *call)
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def close(self, found, expected, scale=1):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * scale)

    def refused(self, code, words, *call):
        done = run(*call)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stdout + done.stderr)
        self.assertIn(words, done.stderr)

    def test_at_a_pose_by_differences(self):
        """w = V^T (D q' q' - M V W' q') with W' by differences of fourth order."""
        arm, spatial = self.write("arm.yaml", ARM), self.write("spatial.yaml", SPATIAL)
        cases = [(arm, "AB", (0.3, 0.9), "x: com.x, y: com.y"),
                 (arm, "AB", (0.3, 0.9), 'p: {A: "0.5*cos(A + 2*B)", B: 0.12}, r: {B: "1 + sin(A)^2", tool.x: 2}'),
                 (spatial, "ABS", (0.4, 0.5, 0.1), "x: com.x, y: com.y, z: com.z"),
                 (spatial, "ABS", (0.4, 0.5, 0.1), 'a: {A: "(0.3 + S)*cos(B)"}, b: {B: "0.3 + S"}, s: S'),
                 (FIVE_BAR, ("A1", "A2"), None, "x: com.x, y: com.y")]
        for spec, names, q, speeds in cases:
            def told(values, names=names, spec=spec, speeds=speeds):
                return self.at(spec, ",".join(f"{n}={v!r}" for n, v in zip(names, values)), "--speeds", speeds)
            start = told(q) if q else self.at(spec, "start", "--speeds", speeds)
            q, own = np.array(start["q"]), start["in_speeds"]
            W, V = np.array(own["rows"]), np.array(own["rates"])
            self.close(W @ V, np.eye(len(V)), np.abs(V).max())
            self.close(V.T @ start["M"] @ V, own["M"], np.abs(own["M"]).max())
            for sigma in np.vstack([np.eye(len(V)), np.linspace(0.7, -1.1, len(V))]):
                rates = V @ sigma
                h = 1e-3 / np.linalg.norm(rates)
                rows = [np.array(told(q + k * h * rates)["in_speeds"]["rows"]) for k in (-2, -1, 1, 2)]
                W_rate = (rows[0] - 8 * rows[1] + 8 * rows[2] - rows[3]) / (12 * h)
                expected = V.T @ (forms(start["D"], rates) - np.array(start["M"]) @ V @ W_rate @ rates)
                np.testing.assert_allclose(forms(own["D"], sigma), expected, rtol=1e-7, atol=1e-8 * max(1e-3, np.abs(expected).max()))

    def test_speeds_of_a_spec_may_have_parameters(self):
        spec = self.write("p.yaml", ARM + 'speeds: {p: {A: "l1*cos(A + 2*B)", B: "0.3*l2"}, r: B}\n')
        found = self.at(spec, "A=0.3,B=0.9")["in_speeds"]
        self.close(found["rows"], [[0.5 * math.cos(2.1), 0.12], [0, 1]])
        formulas, _ = self.sheet(spec, "--only", "speeds")
        self.assertIn("W11", formulas)

    def test_the_centre_of_mass_of_the_arm(self):
        found = self.at(self.write("arm.yaml", ARM), "A=0.3,B=0.9", "--speeds", "x: com.x, y: com.y")["in_speeds"]
        a, b = 0.3, 1.2
        first = np.array([-0.2 * math.sin(a) - 0.03 * math.cos(a), 0.2 * math.cos(a) - 0.03 * math.sin(a)])
        elbow, second = 0.5 * np.array([-math.sin(a), math.cos(a)]), 0.15 * np.array([-math.sin(b), math.cos(b)])
        self.close(found["rows"], np.stack([(2 * first + elbow + second) / 3, second / 3], 1))

    def test_a_redundant_set(self):
        """The quasi-velocities of P0 eq. 68; C is that of eq. 74 and A C = 0."""
        speeds = ("R1: A, R2: B, v1x: a.com.x, v1y: a.com.y, w1: a.angle, v2x: b.com.x, v2y: b.com.y, w2: b.angle")
        arm = self.write("arm.yaml", ARM.replace("[0.2, 0.03]", "[0.2, 0]"))
        told = self.at(arm, "A=0.3,B=0.9", "--speeds", speeds)
        own = told["in_speeds"]
        self.assertEqual(own["independent"], ["R1", "R2"])
        self.close(own["M"], told["M"])
        self.close(own["D"], told["D"])
        a, b, g1, g2 = 0.3, 1.2, 0.4, 0.375
        p2 = 0.5 * np.array([math.cos(a), math.sin(a)])
        p3 = p2 + 0.4 * np.array([math.cos(b), math.sin(b)])
        expected = [[1, 0], [0, 1], [-g1 * p2[1], 0], [g1 * p2[0], 0], [1, 0],
                    [(g2 - 1) * p2[1] - g2 * p3[1], g2 * (p2[1] - p3[1])],
                    [-(g2 - 1) * p2[0] + g2 * p3[0], g2 * (p3[0] - p2[0])], [1, 1]]
        self.close(own["C"], expected)
        self.assertEqual(np.array(own["A"]).shape, (6, 8))
        self.close(np.array(own["A"]) @ np.array(own["C"]), np.zeros((6, 2)))
        # p' = C s' + c(s, s): by differences of C along the motion
        s, h = np.array([0.7, -1.1]), 1e-3
        C = [np.array(self.at(arm, f"A={0.3 + k * h * s[0]!r},B={0.9 + k * h * s[1]!r}", "--speeds", speeds)["in_speeds"]["C"])
             for k in (-2, -1, 1, 2)]
        rate = (C[0] - 8 * C[1] + 8 * C[2] - C[3]) / (12 * h) @ s
        np.testing.assert_allclose(forms(own["c"], s), rate, rtol=0, atol=1e-9)
        # with the platform's point first, its velocities are the independent ones
        other = self.at(arm, "A=0.3,B=0.9", "--speeds", "x: tool.x, again: {tool.x: 2}, y: tool.y, w: A")["in_speeds"]
        self.assertEqual(other["independent"], ["x", "y"])
        self.close(np.array(other["C"])[1], [2, 0])
        text = run("equations", arm, "--at", "A=0.3,B=0.9", "--speeds", speeds).stdout
        self.assertIn("in the speeds R1, R2, the first of R1, R2, v1x", text)
        self.assertIn("C: all speeds per independent speed (P0 eq. 16)", text)

    def sheet(self, spec, *call):
        done = run("equations", spec, "--json", *call)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        told = json.loads(done.stdout)
        return {f["name"]: f["formula"] for s in told["sections"] for f in s["formulas"] if f.get("name")}, told

    @staticmethod
    def evaluated(formulas, values):
        """Values of formulas in their order, each of which may contain those before it; what is unknown is 0.4."""
        known = dict(values)
        for name, text in formulas.items():
            expression = parse(text)
            known[name] = float(expression.subs({s: known.get(s.name, 0.4) for s in expression.free_symbols}))
        return known

    def test_formulas_of_the_plate_in_its_own_axes(self):
        """Euler: F_u = m (u' - v r) - m b r' - m a r^2 and so on, with the centre of mass at (a, b)."""
        formulas, told = self.sheet(self.write("plate.yaml", PLATE), "--only", "speeds", "--speeds", "u: plate.C.u, v: plate.C.v, r: P.angle")
        self.assertEqual((formulas["M11"], formulas["M22"]), ("m1", "m1"))
        found = self.evaluated(formulas, dict(told["symbols"]))
        self.assertAlmostEqual(found["M13"], 2 * 0.05, delta=1e-14)
        self.assertAlmostEqual(found["M23"], 2 * 0.12, delta=1e-14)
        self.assertAlmostEqual(found["w123"], -2 / 2, delta=1e-14)   # -m v r, half for each order
        self.assertAlmostEqual(found["w133"], -2 * 0.12, delta=1e-14)
        self.assertAlmostEqual(found["w213"], 2 / 2, delta=1e-14)
        self.assertAlmostEqual(found["w233"], 2 * 0.05, delta=1e-14)

    def test_every_name_is_defined_before_it_is_used(self):
        """Velocity terms of six links are too long to be printed: what uses their names is left out with them."""
        links = range(1, 7)
        text = ("space: planar\ngravity: [0, -9.81]\nground: {points: {O: [0, 0]}}\nbodies:\n" +
                "".join(f"  b{k}: {{mass: {k}, com: [0.1, 0.0{k}], inertia: 0.03, points: {{P: [0, 0], Q: [0.3, 0]}}}}\n" for k in links) +
                "joints:\n" + "".join(f"  J{k}: {{type: revolute, connects: [{f'b{k - 1}.Q' if k > 1 else 'ground.O'}, b{k}.P]}}\n" for k in links) +
                "actuators: [J1, J2, J3, J4, J5, J6]\n")
        arm, speeds = self.write("arm.yaml", text), "p1: J1, p2: J2, p3: J3, p4: J4, p5: J5, p6: {J5: 1, J6: 1}"
        left_out = {}
        for call in ((), ("--only", "inertia,speeds"), ("--only", "velocity,speeds"), ("--all",)):
            _, told = self.sheet(arm, "--speeds", speeds, *call)
            known = {*told["symbols"], *told["coordinates"], "sin", "cos"}
            for section in told["sections"]:
                for formula in section["formulas"]:
                    self.assertEqual(set(re.findall(r"[A-Za-z_]\w*", formula["formula"])) - known, set(), (call, formula))
                    known.add(formula.get("name"))
            left_out[call] = [section["section"] for section in told["sections"] if section["too_long"]]
        self.assertEqual(left_out, {(): ["velocity", "speeds"], ("--only", "inertia,speeds"): ["speeds"],
                                    ("--only", "velocity,speeds"): ["velocity", "speeds"], ("--all",): []})
        self.assertIn("left out like velocity, whose names it uses: --all prints them", run("equations", arm, "--speeds", speeds).stdout)

    def test_the_note_names_what_vanishes_at_some_poses(self):
        """Constants are no divisors that vanish; the same divisor of two speeds is one."""
        slides = SLIDES.format(mass=2)
        springs = ARM.replace("springs: {s: {joint: B, stiffness: 3}}", "springs: {s: {between: [ground.O, b.H], stiffness: 3, free_length: 0.2}}")
        for text, speeds, notes in (
                (slides, "x: com.x, y: B", []),
                (slides, "x: {A: 1, B: 0.123456789012345678}, y: {A: 0.987654321098765432, B: 1}", []),
                (slides, 'x: {A: "B"}, y: {B: "B"}', ["where B vanishes, the speeds do not determine the motion"]),
                (slides, 'x: {A: "B"}, y: {B: "A"}', ["where B, A vanish, the speeds do not determine the motion"]),
                (springs, "x: tool.x, y: tool.y", ["where l1 l2 sin(B) vanishes, the speeds do not determine the motion"]),
                (ARM, "x: com.x, y: com.y", ["where Delta vanishes, the speeds do not determine the motion"])):
            _, told = self.sheet(self.write("s.yaml", text), "--only", "speeds", "--speeds", speeds)
            self.assertEqual([note for note in told["notes"] if note.startswith("where")], notes, speeds)

    def test_formulas_of_a_mechanism_without_mass(self):
        """All terms are zero, and so is their difference from those of the engine."""
        done = run("equations", self.write("slides.yaml", SLIDES.format(mass=0)), "--json", "--only", "speeds", "--speeds", "x: A, y: B")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        self.assertEqual(told["checked"]["error"], 0)
        self.assertIn("M11", told["sections"][0]["zero"])

    def test_formulas_are_those_of_the_engine_at_poses(self):
        """Each sheet has been compared by the program; here two are evaluated and compared with the matrices at a pose."""
        cases = [(ARM, "AB", (0.3, 0.9), "x: tool.x, y: tool.y"),
                 (ARM, "AB", (0.3, 0.9), "x: com.x, y: com.y"),
                 (ARM, "AB", (0.3, 0.9), 'p: {A: "cos(A + 2*B)", B: 1}, w: {A: 1, B: 1}'),
                 (ARM, "AB", (0.3, 0.9), "u: tool.u, v: tool.v, w: b.angle, x: tool.x"),
                 (SPATIAL, "ABS", (0.4, 0.5, 0.1), "a: A, b: {B: \"0.3 + S\"}, s: S")]
        for text, names, q, speeds in cases:
            spec = self.write("s.yaml", text)
            formulas, told = self.sheet(spec, "--only", "speeds", "--all", "--speeds", speeds)
            self.assertLess(told["checked"]["error"], 1e-9)
            own = self.at(spec, ",".join(f"{n}={v}" for n, v in zip(names, q)), "--speeds", speeds)["in_speeds"]
            values = dict(told["symbols"])
            for name, value in zip(names, q):
                values[name] = value
            found = self.evaluated(formulas, values)
            n = len(names)
            for i in range(n):
                self.assertAlmostEqual(found.get(f"z{i + 1}", 0), own["z"]["sum"][i], delta=1e-9)
                for j in range(i, n):
                    self.assertAlmostEqual(found.get(f"M{i + 1}{j + 1}", 0), own["M"][i][j], delta=1e-9)
                    for k in range(n):
                        name = f"w{k + 1}{i + 1}{j + 1}"
                        self.assertAlmostEqual(found.get(name, 0), own["D"][k][i][j], delta=1e-9, msg=name)

    def test_conditions_in_speeds(self):
        """Efforts along x, y and about C, in the derivatives of H's speeds: no velocity terms if the mass is centred at H."""
        plate = self.write("plate.yaml", PLATE)

        def conditions(*call):
            done = run("conditions", plate, "--json", *call)
            self.assertEqual(done.returncode, 0, done.stderr)
            told = json.loads(done.stdout)
            return [c["text"] for c in told["conditions"]], told
        own, _ = conditions("--goal", "gyroscopic-independent")
        self.assertEqual(sorted(own), ["plate.mx = 0", "plate.my = 0"])
        of_h, told = conditions("--goal", "gyroscopic", "--speeds", "x: tool.x, y: tool.y, w: P.angle")
        self.assertEqual(sorted(of_h), ["-h plate.m + plate.mx = 0", "-k plate.m + plate.my = 0"])
        self.assertTrue(any("derivatives of x, y, w" in note for note in told["notes"]))
        self.assertTrue(any("written in the derivatives of x, y, w" in meaning for meaning in told["meaning"]))
        # in axes that turn with the body, products of speeds remain whatever the masses are
        turning, _ = conditions("--goal", "gyroscopic", "--speeds", "u: plate.C.u, v: plate.C.v, w: P.angle")
        self.assertIn("plate.m = 0", turning)
        # a mechanism that meets them has none of the terms at any pose
        met = self.write("met.yaml", PLATE.replace("[0.12, -0.05]", "[h, k]"))
        for pose in ("P.x=0,P.y=1,P.angle=0.3", "P.x=2,P.y=1,P.angle=2"):
            found = self.at(met, pose, "--speeds", "x: tool.x, y: tool.y, w: P.angle")["in_speeds"]
            self.close(found["D"], np.zeros((3, 3, 3)))
        # of its centre of mass, wherever that is: F = m a
        of_com, told = conditions("--goal", "gyroscopic", "--speeds", "x: com.x, y: com.y, w: P.angle")
        self.assertEqual(sorted(of_com), ["-0.12 plate.m + plate.mx = 0", "0.05 plate.m + plate.my = 0"])
        self.assertTrue(all(c["met"] for c in told["conditions"]))
        self.assertTrue(any("the centre of mass in these speeds is that of the present masses" in note for note in told["notes"]))
        self.refused(4, "fewer than the degrees of freedom", "conditions", plate, "--goal", "gyroscopic", "--speeds", "x: tool.x")
        self.refused(2, "--strategy modular", "conditions", plate, "--goal", "static", "--strategy", "modular", "--speeds", "x: tool.x")

    def test_conditions_in_speeds_of_the_centre_of_mass(self):
        """They are those in the same sums of rates written out, and are met where the equations have no velocity terms."""
        def com(m1, x1, y1, m2, x2, l1=0.5):
            # rates of the arm's centre of mass: first moments over the mass
            m, f = m1 + m2, m1 * x1 + m2 * l1
            return ("x: {A: \"" + f"-({f!r}*sin(A) + {m1 * y1!r}*cos(A) + {m2 * x2!r}*sin(A + B))/{m!r}" + "\", B: \"" + f"-{m2 * x2!r}*sin(A + B)/{m!r}" +
                    "\"}, y: {A: \"" + f"({f!r}*cos(A) - {m1 * y1!r}*sin(A) + {m2 * x2!r}*cos(A + B))/{m!r}" + "\", B: \"" + f"{m2 * x2!r}*cos(A + B)/{m!r}" + "\"}")

        text = ARM.replace("gravity: [0, -9.81]", "gravity: [0, 0]").replace("springs: {s: {joint: B, stiffness: 3}}\n", "")
        arm = self.write("arm.yaml", text)
        answers = []
        for speeds in ("x: com.x, y: com.y", com(2, 0.2, 0.03, 1, 0.15)):
            done = run("conditions", arm, "--goal", "gyroscopic", "--speeds", speeds, "--numbers", "--json")
            self.assertEqual(done.returncode in (0, 1), True, done.stderr)
            answers.append(json.loads(done.stdout))
        self.assertEqual(answers[0]["rank"], answers[1]["rank"])
        for own, other in zip(*(answer["conditions"] for answer in answers)):
            self.assertEqual(own["met"], other["met"])
            self.assertAlmostEqual(own["residual"], other["residual"], delta=1e-9)
        self.assertFalse(all(c["met"] for c in answers[0]["conditions"]))
        terms = self.at(arm, "A=0.3,B=0.9", "--speeds", "x: com.x, y: com.y")["in_speeds"]["D"]
        self.assertGreater(np.abs(terms).max(), 0.01)

    def test_designs_for_goals_in_speeds(self):
        """The plate of test_conditions_in_speeds: its centre of mass goes to the tool, or the tool to it."""
        design = "design: {goal: gyroscopic, speeds: {x: tool.x, y: tool.y, w: P.angle}}\n"
        free_com = PLATE.replace("[0.12, -0.05]", "[{free: [-1, 1], start: 0.12}, {free: [-1, 1], start: -0.05}]")
        free_point = PLATE.replace("{h: 0.2, k: 0.1}", "{h: {free: [-1, 1], start: 0.2}, k: {free: [-1, 1], start: 0.1}}")
        for text, expected in ((free_com, (0.2, 0.1)), (free_point, (0.12, -0.05))):
            done = run("design", self.write("d.yaml", text + design), "--json")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            told = json.loads(done.stdout)
            self.assertTrue(any("written in the derivatives of x, y, w" in note for note in told["notes"]), told["notes"])
            self.close([number["value"] for number in told["free_numbers"]], expected, 10)
        # a payload that is there in the second case only, and pulls the common centre of mass towards (0.4, 0)
        cases = free_com.replace("tool: plate.H", "payloads: {load: {body: plate, at: [0.4, 0], mass: load}}\ntool: plate.H").replace("k: 0.1}", "k: 0.1, load: 0}")
        cases += design.replace("design: {", "design: {for: {load: [0, 0.5]}, adapt: bodies.plate.com, ")
        done = run("design", self.write("cases.yaml", cases), "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        law = json.loads(done.stdout)["load_cases"]
        for case, mass in zip(law, (0, 0.5)):
            self.close(list(case["free_numbers"].values()), (((2 + mass) * 0.2 - 0.4 * mass) / 2, (2 + mass) * 0.1 / 2), 10)

    def test_designs_in_speeds_of_the_centre_of_mass(self):
        """A plate whose motor turns it about C: in x, y of the centre of mass and the angle, no masses need to change."""
        text = PLATE.replace("mass: 2,", "mass: {free: [1, 3], start: 2},") + "design: {goal: gyroscopic, speeds: {x: com.x, y: com.y, w: P.angle}}\n"
        done = run("design", self.write("d.yaml", text), "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_what_speeds_of_a_design_may_not_be(self):
        free = PLATE.replace("{h: 0.2, k: 0.1}", "{h: {free: [-1, 1], start: 0.2}, k: 0.1, f: 2}")
        for speeds, words in (("{x: tool.x, y: {P.y: h}}", "factors of numbers that no design changes"), ("{}", "at least one speed"),
                              ("{x: tool.x, y: nothing.y}", "expected a joint coordinate")):
            self.refused(3, words, "check", self.write("bad.yaml", free + f"design: {{goal: gyroscopic, speeds: {speeds}}}\n"))
        modular = self.write("m.yaml", free + "design: {goal: gyroscopic, speeds: {x: tool.x, y: tool.y, w: P.angle}}\n")
        self.refused(3, "not of the chains one by one", "design", modular, "--strategy", "modular")
        self.refused(4, "not of the chains one by one", "conditions", modular, "--strategy", "modular")

    def test_as_many_conditions_as_differences_of_the_terms(self):
        """The terms of u = M p' + D p p + z' are linear in the masses: their differences when one changes are the rows."""
        def spec(p):
            m1, x1, y1, j1, m2, x2, y2, j2 = p
            body = "{{mass: {}, com: [{}, {}], inertia: {{about: origin, value: {}}}, points: {}}}"
            return self.write("rank.yaml", ARM.split("ground:")[0] + "ground: {points: {O: [0, 0]}}\nbodies:\n  a: " +
                              body.format(m1, x1 / m1, y1 / m1, j1, "{A: [0, 0], B: [0.5, 0.1]}") + "\n  b: " +
                              body.format(m2, x2 / m2, y2 / m2, j2, "{B: [0, 0], H: [0.4, 0.05]}") +
                              "\njoints:" + ARM.split("joints:")[1].split("springs:")[0] + "actuators: [A, B]\ntool: b.H\n")

        def terms(p, pose, speeds):
            own = self.at(spec(p), pose, "--speeds", speeds, "--only", "inertia,velocity,gravity")["in_speeds"]
            inverse = np.linalg.inv(own["input"])
            return [inverse @ np.array(own["M"]), np.einsum("ki,irs->krs", inverse, np.array(own["D"])), inverse @ np.array(own["z"]["sum"])]

        base = np.array([2, 0.4, 0.1, 0.5, 1, 0.15, 0.02, 0.3])
        for goal, speeds in (("decoupled", "x: tool.x, y: tool.y"), ("fully-gyroscopic", "f: A, s: {A: 1, B: 1}"),
                             ("gyroscopic", 'p: {A: "2 + cos(B)"}, r: B')):
            rows, first = [], None
            for pose in ("A=0.3,B=0.9", "A=-1.1,B=1.7", "A=1.9,B=0.5", "A=0.8,B=2.2", "A=-0.4,B=1.2"):
                start, columns = terms(base, pose, speeds), []
                for k in range(8):
                    changed = np.where(np.arange(8) == k, 1.1 * base, base)
                    columns.append([(a - b) / (changed[k] - base[k]) for a, b in zip(terms(changed, pose, speeds), start)])
                M = np.array([c[0] for c in columns])
                rows += [np.array([c[2] for c in columns]).T, np.array([c[1] for c in columns]).reshape(8, -1).T]
                if goal == "decoupled":
                    rows.append(np.stack([M[:, 0, 1], M[:, 1, 0]]))
                if goal.startswith("fully"):
                    first = M if first is None else first
                    rows.append((M - first).reshape(8, -1).T)
            singular = np.linalg.svd(np.vstack(rows))[1]
            done = run("conditions", spec(base), "--goal", goal, "--speeds", speeds, "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout)["rank"], np.sum(singular > 1e-6 * singular[0]), (goal, speeds))

    def test_decoupled_in_speeds(self):
        """Absolute angles of an arm with both motors on the base: decoupled when the second centre of mass is in its joint."""
        done = run("conditions", self.write("arm.yaml", ARM.replace("gravity: [0, -9.81]", "gravity: [0, 0]").replace("springs: {s: {joint: B, stiffness: 3}}\n", "")),
                   "--goal", "gyroscopic", "--speeds", "f: A, s: {A: 1, B: 1}", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(c["text"] for c in json.loads(done.stdout)["conditions"]), ["b.mx = 0", "b.my = 0"])

    def test_control_in_the_tools_speeds(self):
        """The tool's error decays as e'' + K_d e' + K_p e = 0 does, in every direction by itself."""
        text = ARM + ("controllers: {tip: {type: computed-torque, rate: 20000, kp: [400, 100], kd: {x: 40, y: 20}, speeds: {x: tool.x, y: tool.y}, "
                      "initial_error: {tool: [0.01, -0.02]}}}\n")
        file = self.path("c.h5")
        done = run("control", self.write("arm.yaml", text), "--controller", "tip", "-o", file)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file, "r") as results:
            found = {}
            results.visititems(lambda name, node: found.__setitem__(name.split("/")[-1], np.array(node)))
        t, e = found["time"], found["tool_error"]
        for axis, rate in ((0, 20), (1, 10)):
            np.testing.assert_allclose(e[:, axis], e[0, axis] * (1 + rate * t) * np.exp(-rate * t), rtol=0, atol=3e-5)
        self.assertGreater(np.abs(e[0]).min(), 5e-3)

    def controlled(self, text, *call):
        file = self.path("c.h5")
        done = run("control", self.write("arm.yaml", text), "--controller", "c", "-o", file, "--force", *call)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = {}
        with h5py.File(file, "r") as results:
            results.visititems(lambda name, node: found.__setitem__(name.split("/")[-1], np.array(node)))
        return found

    def test_springs_between_the_desired_and_the_actual_tool(self):
        """At rest, a PD law in the tool's speeds leaves e = F/K in each of them, F the weight and the spring as forces at the tool."""
        held = ARM.replace("to: {joints: {A: 1, B: 1.4}}", "to: {joints: {A: 0.3001, B: 0.9001}}")
        found = self.controlled(held + "controllers: {c: {type: pd, rate: 2000, kp: [3000, 2000], kd: {x: 300, y: 250}, gravity: ignored, "
                                       "speeds: {x: tool.x, y: tool.y}}}\n", "--settle", "4")
        self.assertLess(np.abs(found["joint_velocity"][-1]).max(), 1e-6)
        A, B = found["joint_position"][-1]
        forces = self.at(self.path("arm.yaml"), f"A={A!r},B={B!r}", "--speeds", "x: tool.x, y: tool.y")["in_speeds"]["z"]["sum"]
        np.testing.assert_allclose(found["tool_error"][-1], np.array(forces) / [3000, 2000], rtol=1e-5)
        # holding efforts added, nothing is left; default gains follow from the inertia at the tool
        for more in ("", ", measurement: {velocity: difference}", ", bandwidth: 5"):
            found = self.controlled(held + f"controllers: {{c: {{type: pd, speeds: {{x: tool.x, y: tool.y}}{more}}}}}\n", "--settle", "3")
            self.assertLess(np.abs(found["tool_error"][-1]).max(), 1e-7)

    def test_sliding_in_the_tools_speeds(self):
        """s = -(e' + lambda e) of each speed falls at its rate k and stays at zero, P0 eq. 47-50."""
        text = ARM + ("controllers: {c: {type: sliding-mode, rate: 20000, lambda: 20, k: {x: 2, y: 1}, speeds: {x: tool.x, y: tool.y}, "
                      "initial_error: {tool: [0.01, -0.02]}}}\n")
        found = self.controlled(text)
        self.assertEqual([name.decode() for name in found["sliding"]], ["x", "y"])
        t, s, e = found["time"], found["sliding_variable"], found["tool_error"]
        start = -20 * e[0]
        self.assertGreater(np.abs(start).min(), 0.1)
        for axis, k in ((0, 2), (1, 1)):
            falling = np.sign(start[axis]) * np.maximum(np.abs(start[axis]) - k * t, 0)
            # the model acts between samples as the state at their start: k h of the sampled sign, and as much of the change of the pose
            np.testing.assert_allclose(s[:, axis], falling, rtol=0, atol=1e-3)
        found = self.controlled(ARM + "controllers: {c: {type: sliding-mode, switching: {boundary_layer: {x: 0.01, y: 0.02}}, speeds: {x: tool.x, y: com.y}}}\n")
        self.assertLess(np.abs(found["tracking_error"]).max(), 1e-3)

    def test_control_of_other_quantities(self):
        for speeds in ("{x: com.x, y: com.y}", "{r: b.angle, y: tool.y}", "{s: {A: 1, B: 1}, d: {A: 1, B: -1}}"):
            text = ARM + f"controllers: {{c: {{type: computed-torque, speeds: {speeds}}}}}\n"
            file = self.path("c.h5")
            done = run("control", self.write("arm.yaml", text), "--controller", "c", "-o", file, "--force")
            self.assertEqual(done.returncode, 0, done.stderr)
            with h5py.File(file, "r") as results:
                worst = []
                results.visititems(lambda name, node: worst.append(np.abs(node[:]).max()) if name.endswith("tracking_error") else None)
            self.assertLess(worst[0], 1e-3, speeds)

    def test_what_has_no_meaning_in_control_is_refused(self):
        for speeds, words in (("{u: tool.u, v: tool.v}", "axes that turn with a body"), ('{p: {A: "cos(A)"}, q: B}', "depend on the pose"), ("{}", "at least one speed")):
            text = ARM + f"controllers: {{c: {{type: computed-torque, speeds: {speeds}}}}}\n"
            self.refused(3, words, "check", self.write("bad.yaml", text))
        for kind, words in (("extended-sliding-mode", "the coordinates of the spanning tree"), ("open-loop", "controls no errors"), ("none", "controls no errors")):
            text = ARM + f"controllers: {{c: {{type: {kind}, speeds: {{x: tool.x, y: tool.y}}}}}}\n"
            self.refused(3, f"no 'speeds' with 'type: {kind}'", "check", self.write("other.yaml", text))
            self.refused(3, words, "check", self.write("other.yaml", text))
        text = ARM + "controllers: {c: {type: computed-torque, speeds: {x: tool.x}}}\n"
        done = run("control", self.write("few.yaml", text), "--controller", "c")
        self.assertEqual(done.returncode, 4)
        self.assertIn("1 speeds for 2 degrees of freedom", done.stderr)
        with open(os.path.join(CONFIGS, "rolling-cart.yaml")) as file:
            cart = file.read()
        rolling = self.write("rolling.yaml", cart + "\ncontrollers: {c: {type: computed-torque, speeds: {x: tool.x, y: tool.y}}}\n")
        done = run("control", rolling, "--controller", "c")
        self.assertEqual(done.returncode, 4)
        self.assertIn("rates are constrained and positions are not", done.stderr)

    def test_what_cannot_be_is_refused(self):
        arm = self.write("arm.yaml", ARM)
        self.refused(2, "com.x or com.y", "equations", arm, "--at", "A=0.3,B=0.9", "--speeds", "x: com.u, y: com.y")
        self.refused(2, "there is no parameter or variable 'Q'", "equations", arm, "--at", "A=0.3,B=0.9", "--speeds", 'x: {A: "cos(A)*Q"}, y: B')
        self.refused(3, "centre of mass", "check", self.write("c.yaml", ARM + "constraints: {c: com.x}\n"))
        self.refused(3, "does not depend on the pose", "check", self.write("d.yaml", ARM + 'constraints: {c: {A: "cos(A)"}}\n'))
        self.refused(2, "needs --speeds", "equations", arm, "--only", "speeds")


if __name__ == "__main__":
    unittest.main()
