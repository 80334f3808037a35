"""Formulas and programs of mechanisms with loops: random ones, redundant closures, motors that are too many or too few."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from _program import CONFIGS, Case, run
from _random_loops import fault, runs

FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")

# Its loop closes where all coordinates are zero. The arm on the rocker is no part of it.
ARM_ON_FOUR_BAR = """
space: planar
gravity: [0, -9.81]
ground: {points: {A: [0, 0], D: [0.5, 0]}}
bodies:
  crank: {mass: 1, com: [0.05, 0.15], inertia: 0.01, points: {A: [0, 0], B: [0.1, 0.3]}}
  coupler: {mass: 2, com: [0.25, 0.05], inertia: 0.02, points: {B: [0, 0], C: [0.5, 0.1]}}
  rocker: {mass: 1, com: [0.05, 0.2], inertia: 0.01, points: {C: [0.1, 0.4], D: [0, 0]}}
  arm: {mass: 0.5, com: [0.1, 0], inertia: 0.002, points: {C: [0, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
  B: {type: revolute, connects: [crank.B, coupler.B]}
  C: {type: revolute, connects: [coupler.C, rocker.C]}
  D: {type: revolute, connects: [ground.D, rocker.D]}
  E: {type: revolute, connects: [rocker.C, arm.C]}
actuators: [D, E]
"""

PLANAR_ARM = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  a: {mass: 2, com: [0.2, 0], inertia: 0.03, points: {A: [0, 0], B: [0.5, 0]}}
  b: {mass: 1, com: [0.15, 0], inertia: 0.01, points: {B: [0, 0], H: [0.4, 0]}}
actuators: [A, B]
joints:
  A: {type: revolute, connects: [ground.O, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
"""

PLANAR_ARM_IN_SPACE = """
space: spatial
gravity: [0, -9.81, 0]
ground: {points: {O: [0, 0, 0]}}
bodies:
  a: {mass: 2, com: [0.2, 0, 0], inertia: [0.03, 0.03, 0.03], points: {A: [0, 0, 0], B: [0.5, 0, 0]}}
  b: {mass: 1, com: [0.15, 0, 0], inertia: [0.01, 0.01, 0.01], points: {B: [0, 0, 0], H: [0.4, 0, 0]}}
actuators: [A, B]
joints:
  A: {type: revolute, connects: [ground.O, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
"""


def closed_chain(count):
    """A spatial loop of revolutes with oblique axes, which closes where all coordinates are zero: bodies' axes are the world's there."""
    places = [[round(math.cos(6.2 * k / count), 2), round(math.sin(6.2 * k / count), 2), round(0.3 * math.cos(2.3 * k), 2)] for k in range(count)]
    names = ["ground", *(f"b{k}" for k in range(1, count)), "ground"]
    origins = [[0, 0, 0], *places[:-1], [0, 0, 0]]
    at = [[round(a - b, 2) for a, b in zip(places[k], origins[k])] for k in range(count)]
    bodies = [f"  b{k}: {{mass: {k}, com: [0.1, 0.05, 0.02], inertia: [0.01, 0.02, 0.025], points: {{A: [0, 0, 0], B: {at[k]}}}}}" for k in range(1, count)]
    joints = []
    for k in range(count):
        first = "ground.A" if k == 0 else f"{names[k]}.B"
        second = "ground.B" if k == count - 1 else f"{names[k + 1]}.A"
        joints.append(f"  J{k}: {{type: revolute, connects: [{first}, {second}], axis: [{k % 3 - 0.7:.1f}, {(k + 1) % 4 - 1.3:.1f}, 1]}}")
    return "\n".join(["space: spatial", "gravity: [0, 0, -9.81]", f"ground: {{points: {{A: {places[0]}, B: {places[-1]}}}}}", "bodies:", *bodies,
                      "joints:", *joints, "actuators: [J0]", ""])


class Loops(Case):
    def text(self, *call):
        done = run("equations", *call)
        self.assert_quiet_success(done)
        return done.stdout

    def program(self, call, code):
        """What code behind a printed Python program prints."""
        text = self.text(*call, "--code", "python").split("\nif __name__")[0] + "\n" + code
        return subprocess.run([sys.executable, "-c", text], text=True, check=True, capture_output=True).stdout.strip()

    def test_a_sample_of_random_mechanisms(self):
        """The whole is `scripts/soak loops`."""
        for seed in (3, 12, 20):  # 20: near a dead point wherever it goes
            with self.subTest(seed=seed):
                self.assertIsNone(fault(seed))

    def test_formulas_do_not_depend_on_the_size(self):
        """A five-bar of half a millimetre, and one of half a kilometre."""
        with open(os.path.join(CONFIGS, "5r.yaml"), encoding="utf-8") as file:
            text = file.read().split("motion:")[0]
        formulas = []
        for size in (1e-3, 1, 1e3):
            lengths = ", ".join(f"{name}: {value * size:g}" for name, value in (("a11", 0.3), ("a12", 0.45), ("a21", 0.32), ("a22", 0.42), ("base", 0.4)))
            scaled = re.sub(r"parameters: .*", f"parameters: {{{lengths}}}", text)
            scaled = re.sub(r"at: \[-(0\.\d+), 0\]", lambda m: f"at: [{-float(m[1]) * size:g}, 0]", scaled)
            done = run("equations", self.write("size.yaml", scaled), "--only", "solved,reduced", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            told = json.loads(done.stdout)
            self.assertLess(told["checked"]["error"], 1e-9)
            formulas.append([section["formulas"] for section in told["sections"]])
        self.assertEqual(formulas[0], formulas[1])
        self.assertEqual(formulas[2], formulas[1])

    def test_redundant_closures_and_actuators_have_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            for config, set_ in (("parallelogram", []), ("bricard", []), ("geared-five-bar", [])):
                with self.subTest(config=config):
                    text = self.text(os.path.join(CONFIGS, f"{config}.yaml"), *set_, "--code", "c")
                    if shutil.which("cc"):
                        self.assertIsNone(runs("c", text, folder))

    def test_a_loop_of_seven_oblique_revolutes_has_a_program(self):
        """Its closures are too long for formulas, which the program does not need."""
        spec = self.write("7r.yaml", closed_chain(7))
        self.assertIn("too long", run("equations", spec, "--only", "closures").stderr)
        self.assertIsNone(runs("python", self.text(spec, "--code", "python"), self.folder))

    def test_a_loop_that_is_always_closed_is_no_loop_of_a_program(self):
        """A planar joint between the ground and the end of an arm with parallel axes takes no freedom away."""
        for space, arm in (("plane", PLANAR_ARM), ("space", PLANAR_ARM_IN_SPACE)):
            with self.subTest(space=space):
                spec = self.write("guided.yaml", arm + "  P: {type: planar, connects: [ground.O, b.H]}\n")
                for language in ("python", "c") if shutil.which("cc") else ("python",):
                    program = self.text(spec, "--code", language)
                    self.assertIsNone(runs(language, program, self.folder))
                    self.assertNotIn("close_loops", program)
                    self.assertNotIn("not closed", program)
                self.text(spec)

    def test_a_program_says_that_the_loops_do_not_close(self):
        far = "try:\n    torques(prepare(GIVEN), [9.0, -9.0], [0, 0], [0, 0])\nexcept NotSolved as error:\n    print('not solved:', error)"
        self.assertIn("not solved", self.program([FIVE_BAR], far))

    def test_a_refused_request_leaves_the_pose_as_it_was(self):
        """A number that is none is refused as well, even where the loops do not depend on it."""
        spec = self.write("arm.yaml", ARM_ON_FOUR_BAR)
        wrong = ((9.0, 9.0), (math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0))
        calls = "k, q = prepare(GIVEN), START\n" + "".join(
            f"try:\n    torques(k, [float('{a}'), float('{b}')], [0, 0], [0, 0], q)\nexcept NotSolved:\n    print('refused')\n" for a, b in wrong)
        self.assertEqual(self.program([spec], calls).split(), ["refused"] * len(wrong))
        if not shutil.which("cc"):
            return
        numbers = ", ".join(f"{{{'NAN' if math.isnan(a) else 'INFINITY' if math.isinf(a) else a}, {'NAN' if math.isnan(b) else b}}}" for a, b in wrong)
        code = self.text(spec, "--code", "c").split("#ifndef WITHOUT_TEST")[0] + f"""
int main(void) {{
  const double wrong[][freedoms] = {{{numbers}}}, zero[freedoms] = {{0, 0}};
  double k[constants], u[motors], q[coordinates];
  prepare(&given, k);
  for (int i = 0; i < coordinates; ++i) q[i] = start[i];
  for (int w = 0; w < {len(wrong)}; ++w) {{
    if (torques(k, wrong[w], zero, zero, q, u) == SOLVED) return 1;
    for (int i = 0; i < coordinates; ++i)
      if (!(q[i] == start[i])) return 2;
  }}
  return torques(k, zero, zero, zero, q, u) == SOLVED ? 0 : 3;
}}
"""
        self.assertIsNone(runs("c", code, self.folder))

    def test_a_program_keeps_the_assembly_mode(self):
        there = "k = prepare(GIVEN)\n_, q = torques(k, [a + 0.4 for a in (START[i] for i in INDEPENDENT)], [0, 0], [0, 0])\n"
        back = "_, q = torques(k, [START[i] for i in INDEPENDENT], [0, 0], [0, 0], q)\nprint(max(abs(a - b) for a, b in zip(q, START)) < 1e-12)"
        self.assertEqual(self.program([FIVE_BAR], there + back), "True")

    def test_both_kinds_of_coordinates_give_the_same_torques(self):
        state = ("k = prepare(GIVEN)\nC = transformation(k, START)\ndq = [sum(row) for row in C]\n_, D = jacobian_columns(k, START, DEPENDENT)\n"
                 "b = solve(len(D[0]), D, [[x] for x in closure_bias(k, START, dq)])\nddq = [0.0] * len(START)\n"
                 "for j, c in enumerate(DEPENDENT):\n    ddq[c] = -b[j][0]\n")
        one = self.program([FIVE_BAR], state + "print(torques(k, [START[i] for i in INDEPENDENT], [1, 1], [0, 0])[0], START, dq, ddq, sep=';')")
        expected, q, dq, ddq = one.split(";")
        found = self.program([FIVE_BAR, "--coordinates", "all"], f"print(torques(prepare(GIVEN), {q}, {dq}, {ddq}))")
        for a, b in zip(eval(found), eval(expected), strict=True):
            self.assertAlmostEqual(a, b, places=10)

    def test_conditions_of_loops_are_those_of_the_conditions_command(self):
        text = " ".join(self.text(FIVE_BAR, "--only", "conditions").split())
        for goal in ("static", "force", "gyroscopic", "decoupled"):
            self.assertIn(f"Conditions for the goal {goal}", text)
        self.assertIn("m_cw22 x_cw22", text)

    def test_a_section_that_does_not_exist_has_a_note(self):
        arm = os.path.join(CONFIGS, "rr.yaml")
        for section in ("closures", "solved", "reduced"):
            self.assertIn("no loops", self.text(arm, "--only", section))

    def test_without_loops_all_coordinates_are_independent(self):
        arm = os.path.join(CONFIGS, "rr.yaml")
        for form in ([], ["--code", "python"], ["--only", "inertia"]):
            self.assertEqual(self.text(arm, *form, "--independent", "R2,R1"), self.text(arm, *form))
            for names in ("R1", "R1,R1"):
                self.assert_failure(run("equations", arm, *form, "--independent", names), 2, "no loops", "R1, R2")

    def test_wrong_options(self):
        for call, words in ((["--coordinates", "all"], "--code"), (["--code", "c", "--coordinates", "some"], "independent"),
                            (["--independent", "nothing"], "no coordinate"), (["--independent", "A1"], "2 freedoms"),
                            (["--independent", "A1,B1,A2", "--code", "c"], "2 freedoms")):
            done = run("equations", FIVE_BAR, *call)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    unittest.main()
