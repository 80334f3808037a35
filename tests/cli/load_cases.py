"""`design: {for: …, adapt: …}`: what the command says of several loads, and the spec that it writes."""

import json
import os
import re
import unittest

from _program import CONFIGS, Case, run, unwrapped

SPEC = os.path.join(CONFIGS, "rr-adaptive.yaml")


class LoadCases(Case):
    def design(self, spec, *arguments, code=0):
        done = run("design", spec, "--json", *arguments)
        self.assertEqual((done.returncode, done.stderr), (code, ""))
        return json.loads(done.stdout)

    def test_the_law_of_the_rr_arm(self):
        """P0 eq. 95 by hand: (m2 a2/2 + mp a2)/cw2, (m1 a1/2 + (m2 + cw2 + mp) a1)/cw1, both behind the joints."""
        told = self.design(SPEC)
        self.assertEqual(told["status"], "balanced")
        first, second = told["adaptive"]["numbers"]
        self.assertEqual([n["path"] for n in (first, second)], ["counterweights.cw1.at[0]", "counterweights.cw2.at[0]"])
        for number, constant, slope in ((first, -3.25 / 12, -0.5 / 12), (second, -0.3 / 4, -0.4 / 4)):
            terms = {tuple(t["powers"].items()): t["coefficient"] for t in number["law"]["terms"]}
            self.assertEqual(set(terms), {(), (("mp", 1),)})
            self.assertAlmostEqual(terms[()], constant, delta=1e-12)
            self.assertAlmostEqual(terms[(("mp", 1),)], slope, delta=1e-12)
            self.assertAlmostEqual(number["slope"]["mp"], slope, delta=1e-12)
        self.assertTrue(all(case["met"] for case in told["load_cases"]))
        # 0.5 kg too much, both links level
        heavy = told["adaptive"]["not_adapted"][2]
        self.assertEqual(heavy["loads"], {"mp": 1})
        self.assertAlmostEqual(heavy["at_rest"]["R1"], 4.4145, delta=1e-5)
        self.assertAlmostEqual(heavy["at_rest"]["R2"], 1.962, delta=1e-5)
        self.assertEqual([t["trajectory"] for t in heavy["trajectories"]], ["cycloid", "bang-bang"])

    def test_laws_leg_by_leg(self):
        """The modular strategy gives half of the payload to each leg of a five-bar: by hand, half of P0 eq. 95 on both."""
        spec = self.write("legs.yaml", """space: planar
gravity: [0, -9.81]
parameters: {a11: 0.3, a12: 0.45, a21: 0.32, a22: 0.42, base: 0.4, load: 0.5}
ground: {points: {A1: [0, 0], A2: [base, 0]}}
bodies:
  crank1: {mass: 1.2, com: ["a11 / 2", 0], inertia: 0.01, points: {A: [0, 0], B: [a11, 0]}}
  coupler1: {mass: 0.9, com: ["a12 / 2", 0], inertia: 0.016, points: {B: [0, 0], P: [a12, 0]}}
  crank2: {mass: 1.3, com: ["a21 / 2", 0], inertia: 0.012, points: {A: [0, 0], B: [a21, 0]}}
  coupler2: {mass: 0.8, com: ["a22 / 2", 0], inertia: 0.013, points: {B: [0, 0], P: [a22, 0]}}
joints:
  A1: {type: revolute, connects: [ground.A1, crank1.A]}
  B1: {type: revolute, connects: [crank1.B, coupler1.B]}
  A2: {type: revolute, connects: [ground.A2, crank2.A]}
  B2: {type: revolute, connects: [crank2.B, coupler2.B]}
  P: {type: revolute, connects: [coupler1.P, coupler2.P]}
payloads: {cargo: {body: coupler1, at: P, mass: load}}
counterweights:
  cw11: {body: crank1, at: [{free: [-0.8, 0]}, 0], mass: 4}
  cw12: {body: coupler1, at: [{free: [-0.8, 0]}, 0], mass: 2}
  cw21: {body: crank2, at: [{free: [-0.8, 0]}, 0], mass: 4}
  cw22: {body: coupler2, at: [{free: [-0.8, 0]}, 0], mass: 2}
actuators: [A1, A2]
tool: coupler1.P
assembly: {A1: 2.3, B1: -1.5, A2: 0.8, B2: 1.4}
loads: {wind: {body: coupler1, at: P, force: [0, 0]}}
design: {goal: static, for: {load: [0, 0.5, 1]}, adapt: [cw11.at, cw12.at, cw21.at, cw22.at]}
""")
        told = self.design(spec, "--strategy", "modular")
        self.assertEqual((told["status"], told["strategy"]), ("balanced", "modular"))
        self.assertTrue(all(case["met"] for case in told["load_cases"]))
        laws = {number["path"].split(".")[1]: {tuple(t["powers"].items()): t["coefficient"] for t in number["law"]["terms"]}
                for number in told["adaptive"]["numbers"]}
        a11, a12, a21, a22 = 0.3, 0.45, 0.32, 0.42
        for name, constant, slope in (("cw12", -0.9 * a12 / 4, -a12 / 4), ("cw22", -0.8 * a22 / 4, -a22 / 4),
                                      ("cw11", -(1.2 / 2 + 0.9 + 2) * a11 / 4, -a11 / 8),
                                      ("cw21", -(1.3 / 2 + 0.8 + 2) * a21 / 4, -a21 / 8)):
            self.assertAlmostEqual(laws[name][()], constant, delta=1e-12, msg=name)
            self.assertAlmostEqual(laws[name][(("load", 1),)], slope, delta=1e-12, msg=name)
        with open(spec, encoding="utf-8") as file:
            longer = file.read().replace("for: {load: [0, 0.5, 1]}", "for: {load: [0, 1], a12: [0.4, 0.45]}")
        longer = self.design(self.write("longer.yaml", longer), "--strategy", "modular")  # the tool is elsewhere in each case
        self.assertEqual([case["met"] for case in longer["load_cases"]], [True] * 4)
        complete = self.design(spec)
        self.assertTrue(all(case["met"] for case in complete["load_cases"]))
        self.assertLess(len(complete["conditions"]), len(told["conditions"]))

    def test_the_text_says_the_law(self):
        done = run("design", SPEC)
        self.assert_quiet_success(done)
        for words in ("counterweights.cw2.at[0] = -0.075 - 0.1 mp; from -0.175 to -0.075 m; -0.1 per mp", "mp = 0.5",
                      "not adapted: as for mp = 0.5", "4.41450", "work against gravity"):
            self.assertIn(words, unwrapped(done.stdout))

    def test_the_written_spec_is_balanced_for_every_load(self):
        written = self.path("adapted.yaml")
        self.assert_quiet_success(run("design", SPEC, "-o", written, "--quiet"))
        with open(written, encoding="utf-8") as file:
            self.assertIn(" * mp\"", file.read())
        for load in ("0", "0.37", "1", "3"):
            done = run("conditions", written, "--set", f"mp={load}", "--json")
            self.assert_quiet_success(done)
            for condition in json.loads(done.stdout)["conditions"]:
                self.assertLess(abs(condition["residual"]), 1e-12)

    def test_limits_hold_in_every_case(self):
        """One link, level at the worst pose: 9.81 |1.25 + 0.5 mp - 0.2 c| <= 6 for all three loads."""
        spec = self.write("limited.yaml", """space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
parameters: {mp: 1}
bodies: {a: {mass: 5, com: [0.25, 0], inertia: 0.1, points: {O: [0, 0], E: [0.5, 0]}}}
joints: {A: {type: revolute, connects: [ground.O, a.O]}}
counterweights: {c: {body: a, at: [-0.2, 0], mass: {free: [0, 40]}}}
payloads: {p: {body: a, at: E, mass: mp}}
actuators: [A]
workspace: {joints: {A: [-1, 1]}, samples: 11}
design: {minimize: added-mass, subject_to: "peak(torque, workspace) <= 6", for: {mp: [0, 1, 2]}}
""")
        told = self.design(spec)
        self.assertEqual(told["optimality"], "proved-best")
        self.assertAlmostEqual(told["objective"]["value"], (2.25 - 6 / 9.81) / 0.2, delta=1e-6)
        self.assertTrue(told["constraints"][0]["active"])
        with open(spec, encoding="utf-8") as file:
            text = file.read()
        # loads differ by 1 kg at 0.5 m: with one mass for all of them, half of that is too much in one of them
        tight = self.design(self.write("tight.yaml", text.replace("<= 6", "<= 2")), code=1)
        self.assertEqual(tight["status"], "impossible")
        self.assertAlmostEqual(tight["constraints"][0]["value"], 9.81 * 0.5, delta=1e-5)

    def test_a_number_of_the_spec_is_a_load_too(self):
        with open(SPEC, encoding="utf-8") as file:
            text = file.read().replace("for: {mp: [0, 0.5, 1]}", "for: {cargo.mass: {range: [0, 1], samples: 3}}")
        spec, written = self.write("spec.yaml", text), self.path("out.yaml")
        told = self.design(spec, "-o", written)
        self.assertEqual([case["loads"]["cargo.mass"] for case in told["load_cases"]], [0, 0.5, 1])
        with open(written, encoding="utf-8") as file:
            place = re.search(r"cw2: .*at: \[([^,]+), 0\]", file.read()).group(1)
        self.assertAlmostEqual(float(place), -(0.075 + 0.1 * 0.5), delta=1e-12)  # the spec's own load
        self.assertEqual(run("check", written).returncode, 0)

    def test_one_design_for_all_loads(self):
        with open(SPEC, encoding="utf-8") as file:
            text = file.read().replace("  adapt: [cw1.at, cw2.at]\n", "")
        told = self.design(self.write("spec.yaml", text), code=1)
        self.assertEqual((told["status"], told["proved"], told["adaptive"]), ("impossible", True, None))
        light, middle, heavy = (case["largest_residual"] for case in told["load_cases"])
        self.assertLess(middle, 1e-6 * min(light, heavy))  # the least sum of squares is half-way
        self.assertAlmostEqual(told["free_numbers"][1]["value"], -0.125, delta=1e-7)

    def test_what_load_cases_do_not_know_is_told(self):
        done = run("design", SPEC, "--goal", "affine")
        self.assert_failure(done, 3, "design: the goal affine does not support load cases")


if __name__ == "__main__":
    unittest.main()
