"""`balance conditions`: what it prints for people, programs and LaTeX, and how it ends."""

import json
import os
import re
import unittest

import numpy

from _four_bar import SHORT
from _program import CONFIGS, Case, config, run, unwrapped

RR = os.path.join(CONFIGS, "rr.yaml")
FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")
ARM = os.path.join(CONFIGS, "planar-rrr.yaml")

# A pendulum without gravity, tool or goal.
BARE = """\
space: planar
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
"""


class Conditions(Case):
    def derive(self, spec, *options):
        done = run("conditions", spec, "--json", *options)
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def test_the_arm_has_the_published_conditions_by_name(self):
        done = run("conditions", ARM, "--goal", "decoupled")
        self.assert_quiet_success(done)
        # P1 eq. 20 and 26, with the discs' masses explicit; d4 and d6 turn at ratio 1.
        for condition in ("link1.mx + l1 link2.m + l1 link3.m + l1 d6.m + l1 d7.m = 0", "link2.mx + l2 link3.m = 0",
                          "link2.J + l2^2 link3.m + d4.J + beta d5.J + (1 - gamma) d7.J = 0",
                          "link3.J + d6.J + gamma d7.J = 0"):
            self.assertIn(f"  {condition}  ", done.stdout)
        self.assertIn("where l1 = 0.5 m, l2 = 0.4 m, beta = -14.2, gamma = -5.5\n", done.stdout)
        self.assertRegex(done.stdout, r"rank 16 of 28 parameters, gap \d+\.\d decades, \d+ samples\n")
        self.assertIn("hold for every disc that is symmetrical about its axis\n", done.stdout)
        self.assertTrue(done.stdout.endswith("all are met\n"), done.stdout)

    def test_names_have_the_values_of_their_coefficients(self):
        for spec in (ARM, FIVE_BAR, os.path.join(CONFIGS, "four-bar.yaml")):
            result = self.derive(spec, "--goal", "dynamic")
            symbols = {s["name"].replace(".", "_"): s["value"] for s in result["symbols"]}
            named = 0
            for term in (t for c in result["conditions"] for t in c["terms"] if "name" in t):
                name = re.sub(r"(?<=\w)\.(?=[A-Za-z])", "_", term["name"]).replace("^", "**")
                name = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", name)
                # Coefficients carry the round-off of the derivation.
                self.assertAlmostEqual(eval(name, {}, symbols), term["coefficient"], delta=1e-6)  # pylint: disable=eval-used
                named += term["name"] != "1"
            self.assertGreater(named, 3, spec)

    def test_json_is_the_matrix(self):
        result = self.derive(FIVE_BAR, "--goal", "static")
        self.assertEqual((result["goal"], result["rank"], result["status"]), ("static", 6, "done"))
        self.assertGreater(result["gap"], 1e8)
        matrix = numpy.zeros((result["rank"], len(result["parameters"])))
        for row, condition in zip(matrix, result["conditions"]):
            for term in condition["terms"]:
                row[result["parameters"].index(term["parameter"])] = term["coefficient"]
        self.assertEqual(numpy.linalg.matrix_rank(matrix), 6)
        two = self.derive(FIVE_BAR, "--goal", "static", "--goal", "force")
        self.assertEqual(two["goal"], ["static", "force"])
        self.assertGreaterEqual(two["rank"], 6)

    def test_free_numbers_that_a_condition_depends_on_are_named(self):
        conditions = {c["terms"][0]["parameter"]: c["free"] for c in self.derive(RR, "--goal", "static")["conditions"]}
        self.assertEqual(conditions["link1.mx"], ["counterweights.cw1.mass", "counterweights.cw2.mass"])
        self.assertEqual(conditions["link2.mx"], ["counterweights.cw2.mass"])
        self.assertEqual(conditions["link1.my"], [])

    def test_the_spec_s_goal_is_the_default(self):
        self.assertEqual(self.derive(RR)["goal"], "gyroscopic")
        spec = self.write("bare.yaml", BARE)
        self.assert_failure(run("conditions", spec), 2, "--goal is needed", "static", "proportional")

    def test_numbers_are_not_named_if_nobody_wants_names(self):
        done = run("conditions", RR, "--numbers")
        self.assert_quiet_success(done)
        self.assertIn("link1.mx + 0.5 link2.m + cw1.mx", done.stdout)
        self.assertNotIn("where", done.stdout)

    def test_latex_is_one_environment_and_nothing_else(self):
        done = run("conditions", FIVE_BAR, "--goal", "static", "--latex")
        self.assert_quiet_success(done)
        self.assertTrue(done.stdout.startswith("\\begingroup\\allowdisplaybreaks\n\\begin{align*}\n"))
        self.assertTrue(done.stdout.endswith("\n\\end{align*}\n\\endgroup\n"))
        self.assertIn("(m x)_{\\text{crank1}} + a_{11}\\, m_{\\text{coupler1}}", done.stdout)
        self.assertIn("\\frac{a_{12}}{a_{22}}", done.stdout)
        bare = re.sub(r"\\.", "", done.stdout)
        self.assertEqual(bare.count("{"), bare.count("}"))
        self.assert_failure(run("conditions", FIVE_BAR, "--latex", "--json"), 2)

    def test_latex_of_no_conditions_is_a_comment(self):
        done = run("conditions", os.path.join(CONFIGS, "3rrr.yaml"), "--goal", "static", "--latex")
        self.assert_quiet_success(done)
        self.assertEqual(done.stdout, "% no conditions\n")

    def test_speeds_of_the_command_line_know_the_parameters(self):
        """As if the number of the parameter stood there, also one that --set changes."""
        adaptive = os.path.join(CONFIGS, "rr-adaptive.yaml")
        for options, number in (((), "0.5"), (("--set", "a1=0.7"), "0.7")):
            named = run("conditions", adaptive, "--goal", "gyroscopic", "--speeds", "p: {R1: a1, R2: a1^2}, q: R2", *options)
            self.assert_quiet_success(named)
            plain = run("conditions", adaptive, "--goal", "gyroscopic", "--speeds", f"p: {{R1: {number}, R2: {number}^2}}, q: R2", *options)
            self.assertEqual(named.stdout, plain.stdout)
        done = run("conditions", adaptive, "--speeds", "p: {R1: a9}, q: R2")
        self.assert_failure(done, 2, "--speeds: p.R1", "there is no parameter 'a9'")
        at = run("equations", adaptive, "--at", "{tool: [a1, a2]}", "--only", "inertia")
        self.assert_quiet_success(at)
        self.assertEqual(at.stdout, run("equations", adaptive, "--at", "{tool: [0.5, 0.4]}", "--only", "inertia").stdout)

    def test_gravity_that_is_zero_by_a_parameter_is_named(self):
        text = config("rr-adaptive.yaml", (r"gravity: \[0, -9.81\]", "gravity: [0, \"-g0\"]"), (r"parameters: {", "parameters: {g0: 0, "))
        done = run("conditions", self.write("zero.yaml", text), "--goal", "gyroscopic")
        self.assertIn("g0 is 0 in the spec: weight imposes no condition, but does with another value (--set)", unwrapped(done.stdout))
        self.assertEqual(run("conditions", self.path("zero.yaml"), "--goal", "gyroscopic", "--set", "g0=9.81").stdout.count("g0"), 0)
        none = run("conditions", self.write("none.yaml", text.replace("-g0", "0 * g0")), "--goal", "gyroscopic")
        self.assertIn("there is no gravity in this spec", unwrapped(none.stdout))

    def test_the_modular_strategy_asks_for_more(self):
        # P0 section 2.2: eight static conditions where six are enough.
        modular = self.derive(FIVE_BAR, "--goal", "static", "--strategy", "modular")
        self.assertEqual((modular["rank"], modular["strategy"]), (8, "modular"))

    def test_wrong_names_end_with_2_and_name_the_nearest(self):
        for options, parts in ((["--goal", "statik"], ["'statik'", "nearest is 'static'"]),
                               (["--strategy", "modula"], ["'modula'", "nearest is 'modular'"]),
                               (["--goal"], ["--goal"])):
            done = run("conditions", RR, *options)
            self.assert_failure(done, 2, *parts)
            self.assertEqual(done.stdout, "")

    def test_a_goal_that_the_mechanism_cannot_have_ends_with_4(self):
        bare = self.write("bare.yaml", BARE)
        short = self.write("short.yaml", SHORT)
        for spec, goal, status in ((bare, "proportional", "mismatch"),
                                   (short, "force", "not-assembled")):
            done = run("conditions", spec, "--goal", goal, "--json")
            self.assert_failure(done, 4, "error: ")
            error = json.loads(done.stdout)["error"]
            self.assertEqual((error["kind"], error["status"]), ("mechanism", status))

    def test_every_mechanism_has_conditions(self):
        for name in sorted(os.listdir(CONFIGS)):
            if name.endswith(".yaml"):
                with self.subTest(name):
                    result = self.derive(os.path.join(CONFIGS, name), "--goal", "force")
                    self.assertEqual(len(result["conditions"]), result["rank"])
                    self.assertGreater(result["gap_decades"] or 99, 5)


if __name__ == "__main__":
    unittest.main()
