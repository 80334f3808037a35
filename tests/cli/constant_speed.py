"""Balancing at constant speed: rotors exact and with proof, in words of the shop, and what is refused."""

import json
import math
import unittest

from _program import Case, config, run, unwrapped

ROTOR = "machines/rotor-two-planes.yaml"


class ConstantSpeed(Case):
    def answer(self, *arguments):
        done = run(*arguments, "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return json.loads(done.stdout)

    def test_a_rotor_is_balanced_exactly_and_with_proof(self):
        name, designed = self.write("rotor.yaml", config(ROTOR)), self.path("balanced.yaml")
        design = self.answer("design", name, "-o", designed)
        self.assertEqual((design["status"], design["optimality"]), ("balanced", "proved-best"))
        # by hand: U = U1 + U2, D = z1 U1 + z2 U2 of the three wheels, in kg m and kg m^2
        wheels = [(0.02, 0, 0.15), (0.03, 100, 0.3), (0.025, 200, 0.45)]
        at = lambda mass, angle: complex(math.cos(math.radians(angle)), math.sin(math.radians(angle))) * mass * 0.1
        U = sum(at(mass, angle) for mass, angle, _ in wheels)
        D = sum(z * at(mass, angle) for mass, angle, z in wheels)
        needed = [-(0.5 * U - D) / 0.4, -(D - 0.1 * U) / 0.4]
        numbers = {number["path"]: number["value"] for number in design["free_numbers"]}
        directions = [complex(math.cos(math.radians(a)), math.sin(math.radians(a))) for a in (0, 120, 240)]
        for plane, vector in zip("PQ", needed):
            masses = [numbers[f"counterweights.{plane}{k}.mass"] for k in (1, 2, 3)]
            total = 0.12 * sum(mass * direction for mass, direction in zip(masses, directions))
            self.assertAlmostEqual(abs(total - vector), 0, delta=1e-12)
            self.assertAlmostEqual(min(masses), 0, delta=1e-12)  # a third mass would only add to the others
        metrics = {m["quantity"]: m["peak"] for m in self.answer("simulate", designed, "--trajectory", "turn")["metrics"]}
        before = {m["quantity"]: m["peak"] for m in self.answer("simulate", name, "--trajectory", "turn")["metrics"]}
        for quantity in ("shaking_force", "shaking_moment"):
            self.assertLess(metrics[quantity], 1e-9 * before[quantity])

    def test_the_ordinary_goal_is_impossible(self):
        name = self.write("rotor.yaml", config(ROTOR, ("constant-speed-dynamic", "dynamic")))
        self.assertEqual(self.answer("design", name)["status"], "impossible")

    def test_check_speaks_of_static_couple_and_dynamic_unbalance(self):
        name = self.write("rotor.yaml", config(ROTOR))
        (rotor,) = self.answer("check", name)["rotors"]
        ux = 0.1 * (0.02 + 0.03 * math.cos(math.radians(100)) + 0.025 * math.cos(math.radians(200)))
        uy = 0.1 * (0.03 * math.sin(math.radians(100)) + 0.025 * math.sin(math.radians(200)))
        self.assertAlmostEqual(rotor["static_unbalance"], math.hypot(ux, uy), delta=1e-12)
        self.assertAlmostEqual(rotor["static_angle"], math.atan2(uy, ux), delta=1e-12)
        self.assertAlmostEqual(rotor["mass"], 40.075)
        self.assertAlmostEqual(rotor["eccentricity"], math.hypot(ux, uy) / 40.075, delta=1e-15)
        self.assertEqual([plane["name"] for plane in rotor["planes"]], ["P1, P2, P3", "Q1, Q2, Q3"])
        (quality,) = rotor["qualities"]
        speed = 2 * math.pi / 0.04
        worst = max(plane["unbalance"] / plane["share"] for plane in rotor["planes"])
        self.assertAlmostEqual(quality["speed"], speed, delta=1e-9)
        self.assertAlmostEqual(quality["quality"], 1000 * speed * worst / 40.075, delta=1e-9)
        # two vectors in the planes are the rotor's
        total = sum(p["unbalance"] * complex(math.cos(p["angle"]), math.sin(p["angle"])) for p in rotor["planes"])
        self.assertAlmostEqual(abs(total - complex(ux, uy)), 0, delta=1e-12)
        text = unwrapped(run("check", name).stdout)
        for part in ("rotor shaft", "static unbalance", "couple unbalance", "plane at 0.1 m", "along turn", "within G"):
            self.assertIn(part, text)

    def test_check_says_that_a_balanced_rotor_has_no_unbalance(self):
        designed = self.path("balanced.yaml")
        run("design", self.write("rotor.yaml", config(ROTOR)), "-o", designed)
        (rotor,) = self.answer("check", designed)["rotors"]
        # masses are written with all digits, angles in degrees: round-off of the wheels' 6e-3 kg m
        self.assertLess(rotor["static_unbalance"] + rotor["couple_unbalance"], 1e-10)
        self.assertEqual(rotor["qualities"][0]["grade"], 0.4)

    def test_a_planar_rotor_has_static_unbalance_alone(self):
        (rotor,) = self.answer("check", self.write("rot1.yaml", config("published/rot1.yaml")))["rotors"]
        self.assertEqual((rotor["couple_unbalance"], rotor["planes"], rotor["qualities"]), (None, [], []))
        self.assertGreater(rotor["static_unbalance"], 0.1)

    def test_bodies_with_other_joints_are_no_rotors(self):
        self.assertEqual(self.answer("check", self.write("four-bar.yaml", config("four-bar.yaml")))["rotors"], [])

    def test_the_same_goal_in_the_spec_and_on_the_command_line(self):
        name = self.write("rotor.yaml", config(ROTOR))
        goals = ("constant-speed-moment[x]", "constant-speed-moment[y] about ground.A")
        arguments = [part for goal in goals for part in ("--goal", goal)]
        found = self.answer("conditions", name, *arguments)
        self.assertEqual(found["goal"], list(goals))
        listed = ", ".join(f'"{goal}"' for goal in goals)
        other = self.write("other.yaml", config(ROTOR, ("goal: constant-speed-dynamic", f"goal: [{listed}]")))
        self.assertEqual(self.answer("conditions", other)["conditions"], found["conditions"])
        self.assertIn("while the drives are at constant speed", " ".join(found["meaning"]))

    def test_formulas_of_a_goal_at_constant_speed(self):
        name = self.write("rotor.yaml", config(ROTOR))
        done = run("equations", name, "--only", "conditions")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Conditions for the goal constant-speed-dynamic", done.stdout)
        plane = self.write("rot1.yaml", config("published/rot1.yaml", ("d: ", "m_cw: 8, d: "), (r"mass: \{free: \[0, 50\], start: 5\}", "mass: m_cw")))
        for goal in ("constant-speed-force", "force"):
            solved = run("equations", plane, "--solve", "bodies.shaft.com", "--goal", goal, "--only", "solutions")
            self.assertEqual(solved.returncode, 0, solved.stderr)

    def test_load_cases_share_one_design(self):
        loads = "design:\n  for: {payloads.wheel1.mass: [0.02, 0.03]}\n  adapt: [P1, P2, P3, Q1, Q2, Q3]\n"
        design = self.answer("design", self.write("loads.yaml", config(ROTOR, ("design:\n", loads))))
        self.assertTrue(all(case["met"] for case in design["load_cases"]), design["status"])
        named = self.answer("design", self.write("named.yaml", config(
            ROTOR, ("design:\n", loads), ("goal: constant-speed-dynamic", "goal: constant-speed-dynamic of S"))))
        self.assertEqual(named["status"], "balanced")
        self.assertAlmostEqual(named["objective"]["value"], design["objective"]["value"], delta=1e-9)

    def test_mistakes_are_told_with_their_place(self):
        name = self.write("rotor.yaml", config(ROTOR))
        for goal, part in (
            ("constant-speed-dynamc", "nearest is 'constant-speed-dynamic'"),
            ("moment about ground.C", "expected a point of the ground (ground.A or ground.origin), found 'ground.C'"),
            ("constant-speed-force of T", "expected a coordinate (S), found 'T'"),
            ("force[w]", "expected a component x, y or z of the goal 'force', found 'w'"),
        ):
            self.assert_failure(run("conditions", name, "--goal", goal), 2, part)
            bad = self.write("bad.yaml", config(ROTOR, ("goal: constant-speed-dynamic", f'goal: "{goal}"')))
            self.assert_failure(run("check", bad), 3, "bad.yaml:50:9: design.goal: expected", part)

    def test_the_modular_strategy_refuses(self):
        done = run("conditions", self.write("rotor.yaml", config(ROTOR)), "--strategy", "modular")
        self.assert_failure(done, 4, "not for constant-speed-dynamic")

    def test_a_suite_names_goals_too(self):
        self.write("rotor.yaml", config(ROTOR))
        suite = self.write("suite.yaml", "cases:\n  c: {spec: rotor.yaml, run: conditions, goal: 'constant-speed-moment[z]'}\n"
                                         "  d: {spec: rotor.yaml, run: conditions, goal: 'moment about ground.Z'}\n")
        done = run("batch", suite, "--json", "-o", self.path("results"))
        self.assertIn("expected a point of the ground", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
