"""`balance equations` without a pose: formulas as text, JSON and LaTeX that TeX takes, programs that compile and pass their own tests."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from _program import CONFIGS, Case, config, run, unwrapped

ARM = os.path.join(CONFIGS, "planar-rrr.yaml")
SPATIAL = os.path.join(CONFIGS, "spatial-rrr.yaml")
FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")
RCCC = os.path.join(CONFIGS, "rccc.yaml")
PRESS = os.path.join(CONFIGS, "spring-press.yaml")  # springs and a loop
COIN = os.path.join(CONFIGS, "rolling-on-a-plane.yaml")
SPRING = os.path.join(CONFIGS, "spring-balancer-two-link.yaml")


LONG_NAMES = """
space: planar
gravity: [0, -9.81]
parameters: {upper_arm_length: 0.5, forearm_length: 0.4, shoulder_counterweight_mass: 3, elbow_counterweight_mass: 2,
             shoulder_counterweight_distance: -0.2, elbow_counterweight_distance: -0.15, cargo_mass: 0.5, crankthrow: 0.2, connectingrodlength: 0.3}
ground: {points: {O: [0, 0]}}
bodies:
  upper_arm: {mass: 2, com: [0.2, 0.03], inertia: 0.03, points: {A: [0, 0], B: [upper_arm_length, 0]}}
  forearm: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {B: [0, 0], H: [forearm_length, crankthrow]}}
joints:
  shoulder: {type: revolute, connects: [ground.O, upper_arm.A]}
  elbow: {type: revolute, connects: [upper_arm.B, forearm.B]}
counterweights:
  shoulder_counterweight: {body: upper_arm, at: [shoulder_counterweight_distance, connectingrodlength], mass: shoulder_counterweight_mass}
  elbow_counterweight: {body: forearm, at: [elbow_counterweight_distance, 0], mass: elbow_counterweight_mass}
payloads:
  cargo: {body: forearm, at: H, mass: cargo_mass}
actuators: [shoulder, elbow]
tool: forearm.H
"""

# A crank drives a rocker through a rod between two spherical joints, about whose line the rod may spin.
RSSR = """
space: spatial
gravity: [0, 0, -9.81]
ground: {points: {O: [0, 0, 0], Q: [0.4, 0.1, 0]}}
bodies:
  crank: {mass: 1, com: [0.04, 0, 0.01], inertia: [0.001, 0.002, 0.002], points: {O: [0, 0, 0], A: [0.1, 0, 0]}}
  rod: {mass: 0.8, com: [0.2, 0, 0], inertia: [0.001, 0.01, 0.01], points: {A: [0, 0, 0], B: [0.42, 0, 0]}}
  rocker: {mass: 1.1, com: [0.1, 0.02, 0], inertia: [0.001, 0.005, 0.005], points: {Q: [0, 0, 0], B: [0.25, 0, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, crank.O]}
  SA: {type: spherical, connects: [crank.A, rod.A]}
  R: {type: revolute, connects: [ground.Q, rocker.Q], axis: [0, 1, 0]}
  SB: {type: spherical, connects: [rod.B, rocker.B]}
actuators: [A]
assembly: {A: 0.6, R: -1.2}
"""


class Formulas(Case):
    def text(self, *call):
        done = run("equations", *call)
        self.assert_quiet_success(done)
        return done.stdout

    def test_it_says_at_how_many_states_it_was_checked(self):
        self.assertRegex(self.text(ARM), r"checked at 5 states, 2 of them with other numbers: \d+e-\d+\n$")

    def spec(self, text):
        file = tempfile.NamedTemporaryFile("w", suffix=".yaml", delete=False)
        self.addCleanup(os.unlink, file.name)
        with file:
            file.write(text)
        return file.name

    def arm(self, disc="", point="[a, 0]", extra=""):
        return self.spec(f"""
space: planar
gravity: [0, -9.81]
parameters: {{a: 0.5, b: 0.5, z: 0}}
ground: {{points: {{O: [0, 0], S: [0, 0.3]}}}}
bodies:
  b1: {{mass: 2, com: [0.2, 0], inertia: 0.04, points: {{A: [0, 0], Other: [b, 0], B: {point}}}}}
  b2: {{mass: 1, com: [0.1, 0], inertia: 0.02, points: {{A: [0, 0], E: [0.4, 0]}}}}
joints:
  J1: {{type: revolute, connects: [ground.O, b1.A]}}
  J2: {{type: revolute, connects: [b1.B, b2.A]}}
actuators: [J1, J2]
{disc}
{extra}
""")

    def test_free_numbers_that_start_at_zero_are_symbols(self):
        disc = "discs: {d: {body: b1, at: A, follows: J2, ratio: -4, inertia: {free: [0, 1]}}}"
        self.assertIn("Jz_d n_d", self.text(self.arm(disc), "--only", "conditions"))
        weight = "counterweights: {c: {body: b1, at: [-0.1, 0], mass: {free: [0, 9]}}}"
        self.assertIn("m_c", self.text(self.arm(extra=weight), "--only", "conditions"))
        spring = "springs: {s: {between: [ground.S, b1.B], stiffness: {free: [0, 900]}, free_length: {free: [0, 1], start: 0}}}"
        text = self.text(self.arm(extra=spring), "--only", "gravity")
        self.assertIn("k_s", text)
        self.assertIn("l0_s", text)

    def test_a_joint_has_the_symbol_of_the_point_that_it_names(self):
        for point, set_ in (("[a, 0]", []), ("[a, 0]", ["--set", "a=0"]), ("[a, z]", ["--set", "b=0"])):
            text = self.text(self.arm(point=point), *set_, "--only", "inertia")
            self.assertIn("a", re.search(r"where (.*) in SI", unwrapped(text))[1].replace("and", ""))
            self.assertNotRegex(text, r"\bb\b")
            self.assertEqual("z" in re.search(r"where (.*) in SI", unwrapped(text))[1].split(), "z" in point)

    def test_a_disc_with_an_oblique_axis_has_two_moments_of_inertia(self):
        spec = self.spec("""
space: spatial
gravity: [0, 0, -9.81]
parameters: {u: 1, v: 2}
ground: {points: {O: [0, 0, 0]}}
bodies:
  arm:  {mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.02, 0.02], points: {O: [0, 0, 0], E: [0.3, 0, 0]}}
  hand: {mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.02, 0.02], points: {E: [0, 0, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, arm.O], axis: [0, 0, 1]}
  J2: {type: revolute, connects: [arm.E, hand.E], axis: [0, 1, 0]}
actuators: [J1, J2]
discs:
  d: {body: hand, at: [0.1, 0, 0], follows: J2, ratio: 2, axis: [u, v, 3], mass: 0.3, inertia: {axial: 0.02, transverse: 0.011}}
""")
        text = self.text(spec, "--only", "inertia")
        self.assertIn("Ja_d", text)
        self.assertIn("Jt_d", text)
        self.assertIn("2 of them with other numbers", text)
        # the direction is the parameters': its angles are symbols even where it is along an axis
        self.assertIn("alpha", self.text(spec, "--set", "v=0", "--set", "u=0", "--only", "inertia"))
        self.assertIn('"Ja_d": 0.02', self.text(spec, "--code", "python"))

    def test_sections_are_picked(self):
        text = self.text(ARM, "--only", "conditions")
        self.assertIn("m1 lg1 + l1 (m2 + m3 + m6 + m7) = 0", text)
        self.assertNotIn("D11", text)

    def test_closures_are_solved(self):
        self.assertIn("C21 = -1 - a11 sin(B1 + P)/(a12 sin(P))", self.text(FIVE_BAR, "--only", "solved"))

    def test_expressions_of_the_spec_are_put_in(self):
        self.assertIn("zero: D1, D2, D3", self.text(ARM, "--only", "gravity", "--expand"))

    def test_json(self):
        found = json.loads(self.text(SPATIAL, "--json"))
        names = [formula["name"] for section in found["sections"] for formula in section["formulas"]]
        self.assertIn("D211", names)
        self.assertEqual(found["symbols"]["l1"], 0.3)
        self.assertLess(found["checked"]["error"], 1e-9)

    def test_numbers(self):
        found = json.loads(self.text(ARM, "--json", "--numbers", "--only", "inertia"))
        value = {formula["name"]: formula["formula"] for formula in found["sections"][0]["formulas"]}
        self.assertAlmostEqual(float(value["D33"]), 0.0715, places=12)

    def test_what_has_no_formula_says_so(self):
        done = run("equations", RCCC, "--only", "natural")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("no formulas", done.stderr)
        self.assertEqual(done.stdout, "")

    def test_wrong_options(self):
        for call in (["--only", "torques"], ["--code", "fortran"], ["--rates", "J1=1"], ["--at", "start", "--expand"]):
            done = run("equations", ARM, *call)
            self.assertEqual(done.returncode, 2, call)
            self.assertEqual(done.stdout, "")

    @unittest.skipUnless(shutil.which("cc"), "no C compiler")
    def test_programs_in_c_pass_their_own_test(self):
        for spec in (ARM, SPATIAL, FIVE_BAR, SPRING, PRESS, COIN):
            with tempfile.TemporaryDirectory() as folder:
                source, program = os.path.join(folder, "arm.c"), os.path.join(folder, "arm")
                with open(source, "w") as file:
                    file.write(self.text(spec, "--code", "c"))
                subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", source, "-lm", "-o", program], check=True)
                subprocess.run([program], check=True, stdout=subprocess.DEVNULL)

    def test_programs_in_python_pass_their_own_test(self):
        for spec in (ARM, FIVE_BAR, SPRING):
            subprocess.run([sys.executable, "-"], input=self.text(spec, "--code", "python"), text=True, check=True,
                           stdout=subprocess.DEVNULL)

    def test_latex_writes_a_name_the_same_way_wherever_it_is(self):
        for form in ([], ["--numbers"]):
            text = self.text(os.path.join(CONFIGS, "whitworth.yaml"), "--only", "solved", "--latex", *form)
            self.assertRegex(text, r"\\Delta_\{\d\} = ")
            self.assertRegex(text, r"= .*\\Delta_\{\d\}")
            self.assertNotRegex(text, r"(?<!\\)Delta")
        self.assertIn(r"\hat M_{11} = ", self.text(FIVE_BAR, "--latex", "--only", "reduced"))

    def test_a_loop_with_a_passive_freedom_has_every_section(self):
        """The engine on its own takes a coordinate of the cut joint as independent, of which the formulas have none."""
        loop = self.write("rssr.yaml", RSSR)
        for section in ("inertia", "velocity", "gravity", "closures", "solved", "efforts", "reduced", "conditions", "regressor"):
            told = json.loads(self.text(loop, "--only", section, "--json"))
            self.assertEqual((told["independent"], told["checked"]["states"]), (["A", "SA_1"], 5), section)
            self.assertLess(told["checked"]["error"], 1e-9)

    def test_latex_has_no_fractions_over_one(self):
        self.assertNotIn("}{1}", self.text(FIVE_BAR, "--latex", "--only", "reduced"))

    def test_divisors_of_steps_are_listed_as_they_are(self):
        note = " ".join(self.text(os.path.join(CONFIGS, "delta.yaml"), "--only", "solved").split())
        self.assertIn("the steps divide by rod cos(A1 + U1R_1) cos(U1R_2), ", note)

    @unittest.skipUnless(shutil.which("pdflatex"), "no TeX")
    def test_tex_takes_the_formulas(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "page.tex"), "w") as file:
                file.write("\\documentclass{article}\\usepackage{amsmath}\\begin{document}\n")
                for spec in (ARM, SPATIAL, FIVE_BAR, SPRING):
                    file.write(self.text(spec, "--latex"))
                file.write(self.text(FIVE_BAR, "--latex", "--only", "natural"))
                file.write("\\end{document}\n")
            done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"], cwd=folder, text=True,
                                  check=False, capture_output=True)
            self.assertEqual(done.returncode, 0, done.stdout[-2000:])
            self.assertIsNone(re.search(r"^!", done.stdout, re.MULTILINE))

    def test_a_number_that_terms_share_stands_before_what_is_collected(self):
        text = self.text(os.path.join(CONFIGS, "planar-rrr.yaml"), "--collect", "l1", "--only", "inertia")
        self.assertIn("+ 2 l1 (m2 lg2 + m3 l2) cos(theta2)", " ".join(text.split()))

    def test_values_of_parameters_are_in_the_spec_s_units(self):
        spec = self.write("mm.yaml", config("rr.yaml", (r"gravity: \[0, -9.81\]", "units: {length: mm}\ngravity: [0, -9810]"),
                                            (r"a1: 0.5, a2: 0.4", "a1: 500, a2: 400"), (r"inertia: 0.042", "inertia: 42000")))  # fmt: skip
        text = " ".join(self.text(spec, "--only", "gravity").split())
        self.assertRegex(text, r"where a1 = 500, a2 = 400, .* in the spec's units, and m1 = 2, .*g = 9\.81 in SI units")
        self.assertNotIn("spec's units", self.text(os.path.join(CONFIGS, "rr.yaml"), "--only", "gravity"))

    def test_the_radius_of_a_wheel_has_a_name(self):
        """A disc that rolls along a line: M = J + m r^2, whether the radius is a parameter or a number."""
        wheel = """
space: planar
gravity: [0, -9.81]
parameters: {r: 0.2}
ground: {points: {O: [0, 0.2]}}
bodies: {disc: {mass: 3, com: [0, 0], inertia: 0.06, points: {C: [0, 0]}}}
joints: {W: {type: rolling, connects: [ground.O, disc.C], radius: RADIUS}}
actuators: [W.angle]
"""
        for radius, name in (("r", "r"), ("0.2", "r_W"), ("2 * r", "r")):
            text = self.text(self.write("wheel.yaml", wheel.replace("RADIUS", radius)), "--only", "inertia")
            self.assertIn(f"D11 = Jz1 + {'4 ' if '*' in radius else ''}m1 {name}^2", text)

    @unittest.skipUnless(shutil.which("pdflatex"), "no TeX")
    def test_long_names_and_fractions_stay_within_the_margins(self):
        """TeX reports lines that are too wide. Names are those of a spec written to be read, in sums, squares, fractions and conditions."""
        solve = ("--goal", "gyroscopic", "--solve", "shoulder_counterweight_distance,elbow_counterweight_distance")
        arm, loop = self.write("arm.yaml", LONG_NAMES), self.write("rssr.yaml", RSSR)
        pages = [self.text(arm, "--latex", *call) for call in
                 ((), solve, ("--only", "speeds", "--speeds", "horizontal: tool.x, vertical: tool.y"))] + [self.text(loop, "--latex")]
        conditions = run("conditions", arm, "--goal", "decoupled", "--latex")
        self.assertEqual(conditions.stderr, "")
        for k, page in enumerate([*pages, conditions.stdout]):
            with tempfile.TemporaryDirectory() as folder:
                with open(os.path.join(folder, "page.tex"), "w") as file:
                    file.write("\\documentclass{article}\\usepackage{amsmath}\\begin{document}\n" + page + "\\end{document}\n")
                done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"], cwd=folder, text=True,
                                      check=False, capture_output=True)
                self.assertEqual(done.returncode, 0, done.stdout[-2000:])
                self.assertNotIn("Overfull \\hbox", done.stdout, k)


if __name__ == "__main__":
    unittest.main()
