#!/usr/bin/env python3
"""Suites that ask for values, points, designs, conditions, equations and solved parameters: against closed forms and the program's own commands."""

import json
import math
import os
import unittest

from _program import CONFIGS, Case, run

SLIDER_CRANK = """
space: planar
gravity: [0, 0]
parameters: {r: 0.15, l: 0.6, w: "15 * pi", m: 1}
ground: {points: {O: [0, 0]}}
bodies:
  crank: {mass: 1, com: [0, 0], inertia: 1, points: {P: [r, 0]}}
  rod: {mass: 0, points: {G: [l, 0]}}
  piston: {mass: m, com: [0, 0], inertia: 1, points: {}}
joints:
  A: {type: revolute, connects: [ground.O, crank.origin]}
  P: {type: revolute, connects: [crank.P, rod.origin]}
  G: {type: revolute, connects: [rod.G, piston.origin]}
  X: {type: prismatic, connects: [ground.O, piston.origin], axis: [1, 0]}
actuators: [A]
assembly: {X: "r + l"}
motion: {duration: "2 * pi / w", samples: 721, from: {joints: {A: 0}}, to: {joints: {A: "2 * pi"}}}
trajectories: {turn: {law: uniform, drive: joints}}
"""
ROTOR = """
space: planar
parameters: {a: {free: [0, 360], start: 200}, d: pi / 180}
ground: {points: {O: [0, 0]}}
bodies: {shaft: {mass: 1, com: [0, 0], inertia: 1, points: {O: [0, 0]}}}
joints: {S: {type: revolute, connects: [ground.O, shaft.O]}}
actuators: [S]
payloads: {A: {body: shaft, at: [0.04, 0], mass: 12}}
counterweights: {cw: {body: shaft, at: ["0.1 * cos(a * d)", "0.1 * sin(a * d)"], mass: {free: [0, 50], start: 5}}}
design: {goal: force, minimize: added-mass}
"""
ARM = """
space: planar
gravity: [0, -10]
parameters: {m: 2}
bodies: {link: {mass: m, com: [0.5, 0], inertia: 0.1, points: {E: [1, 0]}}}
joints: {J: {type: revolute, connects: [ground.origin, link.origin]}}
actuators: [J]
motion: {duration: 1, samples: 51, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
"""


class Suite(Case):
    def batch(self, text, *arguments, out="out"):
        for name in ("3rrr", "5r", "5r-design", "5r-impossible", "planar-rrr"):
            text = text.replace(f"{name.upper()}.YAML", os.path.join(CONFIGS, f"{name}.yaml"))
        return run("batch", self.write("suite.yaml", text), "-o", self.path(out), *arguments)

    def summary(self, out="out"):
        with open(os.path.join(self.path(out), "summary.json"), encoding="utf-8") as file:
            return json.load(file)

    def assert_holds(self, text, *arguments):
        done = self.batch(text, *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return self.summary()

    def program_json(self, *arguments):
        done = run(*arguments, "--json")
        return json.loads(done.stdout)


class Motions(Suite):
    def setUp(self):
        super().setUp()
        self.write("crank.yaml", SLIDER_CRANK)

    def test_a_slider_crank_at_sixty_degrees_is_the_closed_form(self):
        r, l, w, t = 0.15, 0.6, 15 * math.pi, math.pi / 3
        root = math.sqrt(l**2 - (r * math.sin(t))**2)
        speed = r * w * (math.sin(t) + r * math.sin(t) * math.cos(t) / root)
        # the middle of the rod
        y, vy, ay = r * math.sin(t) / 2, r * w * math.cos(t) / 2, -r * w**2 * math.sin(t) / 2
        phi_rate = -r * w * math.cos(t) / root
        phi_acceleration = r * w**2 * math.sin(t) / root - (r * w * math.cos(t))**2 * r * math.sin(t) / root**3
        text = f"""
cases:
  K:
    spec: crank.yaml
    source: a book
    page: 522
    points: {{D: {{rod: [0.3, 0]}}, G: rod.G}}
    require:
      - abs(-value(joint_velocity[X], joint_position[A] = pi/3) - {speed!r}) <= 1e-6
      - abs(value(point_position[D].y, joint_position[A] = pi/3) - {y!r}) <= 1e-8
      - abs(value(point_velocity[D][y], joint_position[A] = pi/3) - {vy!r}) <= 1e-6
      - abs(value(point_acceleration[D].y, joint_position[A] = pi/3) - {ay!r}) <= 1e-3
      - abs(value(body_angular_velocity[rod], joint_position[A] = pi/3) - {phi_rate!r}) <= 1e-6
      - abs(value(body_angular_acceleration[rod], joint_position[A] = pi/3) - {phi_acceleration!r}) <= 1e-3
      - value(point_velocity[G].x, 0.01) == value(joint_velocity[X], 0.01)
      - duration() == {2 * math.pi / w!r}
      - "abs(time(joint_position[A] = pi/3) - {t / w!r}) <= 1e-12"
      - "value(joint_position[X], joint_velocity[X] = 0 #2) - ({l - r!r}) <= 1e-9"
    published:
      - {{what: piston speed, unit: m/s, printed: 6.833, exact: 6.90536, verdict: drawn,
         figure: "-value(joint_velocity[X], joint_position[A] = pi/3)"}}
      - {{what: turn, unit: deg, printed: 60, verdict: reproduced, figure: "value(joint_position[A], joint_position[A] = pi/3)"}}
    waits: [{{what: flywheel, printed: 121, reason: not computed}}]
"""
        self.assertAlmostEqual(speed, 6.90536, places=5)
        case = self.assert_holds(text, "--metrics-only")["cases"][0]
        self.assertEqual((case["source"], case["page"]), ("a book", "522"))
        row = case["published"][0]
        self.assertEqual((row["verdict"], row["printed"], row["exact"], row["holds"]), ("drawn", 6.833, 6.90536, True))
        self.assertAlmostEqual(row["ours"], speed, places=6)
        self.assertAlmostEqual(row["deviation"], speed / 6.833 - 1, places=6)
        self.assertEqual(case["waits"][0]["reason"], "not computed")
        with open(self.path("out/summary.md"), encoding="utf-8") as file:
            self.assertIn("## Published numbers", file.read())

    def test_a_missed_row_says_value_expectation_and_unit(self):
        done = self.batch("""
cases:
  K15-2:
    spec: crank.yaml
    published: [{what: piston speed, unit: m/s, printed: 6.833, exact: 6.95, tolerance: 0.01, verdict: drawn,
                 figure: "-value(joint_velocity[X], joint_position[A] = pi/3)"}]
""", "--quiet")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr.strip(), "FAILED K15-2: piston speed: 6.90536 m/s, expected 6.95 ± 0.01 m/s")

    def test_what_never_happens_does_not_hold_and_is_said(self):
        done = self.batch("cases: {a: {spec: crank.yaml, require: 'value(joint_velocity[X], joint_position[A] = 7) < 9'}}", "-q")
        self.assert_failure(done, 1, "a: joint_position[A] never is 7: it is between 0 and 6.28319 rad")

    def test_misspelled_names_have_a_place_and_the_nearest_name(self):
        done = self.batch("cases: {a: {spec: crank.yaml, require: 'value(joint_velocty[X], 0.01) < 9'}}", "-q")
        self.assert_failure(done, 3, "suite.yaml:1:40: cases.a.require: column 7: no run has a quantity 'joint_velocty[X]'; "
                                     "nearest is 'joint_velocity[X]'")
        done = self.batch("cases: {a: {spec: crank.yaml, points: {D: rod.H}}}", "-q")
        self.assert_failure(done, 3, "suite.yaml:1:43: cases.a.points.D: expected a point of rod (origin, com or G), found 'H'")
        done = self.batch("cases: {a: {spec: crank.yaml, points: {D: rood.G}}}", "-q")
        self.assert_failure(done, 3, "nearest is 'rod'")

    def test_neither_a_pole_nor_a_jump_nor_a_constant_is_a_root(self):
        self.write("arm.yaml", ARM)
        for figure, part in (("1 / (number(m) - 3.1234567)", "jumps past 0 at m = 3.12346"),
                             ("abs(number(m) - 3.1234567) / (number(m) - 3.1234567)", "jumps past 0 at m = 3.12346"),
                             ("0 * duration()", "does not determine m")):
            with self.subTest(figure):
                done = self.batch(f"cases: {{a: {{spec: arm.yaml, solve: {{m: {{figure: '{figure}', equals: 0, within: [1, 20]}}}}}}}}", "-q")
                self.assert_failure(done, 4, part)

    def test_a_row_has_a_unit_of_its_figure(self):
        row = "cases:\n  a:\n    spec: crank.yaml\n    published:\n      - {what: x, unit: %s, printed: 1, tolerance: 1e9, verdict: reproduced,\n" \
              "         figure: \"%s\"}\n"
        for unit, figure in (("m/s", "-value(joint_velocity[X], 0.01)"), ("deg", "value(joint_position[A], 0.01)"),
                             ("ft lbf", "peak(torque[A]) + 0.1"), ("rpm", "value(joint_velocity[A], 0.01)"),
                             ("kg m^2/s^2", "maximum(kinetic_energy) - minimum(kinetic_energy)"), ("W", "peak(power[A])"),
                             ("kg", "peak(shaking_force) / 9.81")):
            with self.subTest(unit):
                self.assert_holds(row % (unit, figure))
        for unit, figure, place in (("kg", "value(joint_velocity[X], 0.01)", "in m/s"), ("Hz", "value(joint_velocity[A], 0.01)", "in rad/s"),
                                    ("N", "abs(peak(torque[A]) - rms(torque[A]))", "in N m"), ("m", "value(joint_position[A], 0.01)", "in rad")):
            with self.subTest(unit):
                done = self.batch(row % (unit, figure), "-q")
                self.assert_failure(done, 3, "suite.yaml:5:25: cases.a.published[0].unit: expected a unit of the figure, which is " + place)
        done = self.batch(row % ("m/s", "value(joint_velocty[X], 0.01)"), "-q")
        self.assert_failure(done, 3, "suite.yaml:6:18: cases.a.published[0].figure: column 7: no run has a quantity")

    def test_a_verdict_that_contradicts_the_numbers_is_a_mistake(self):
        row = "cases: {a: {spec: crank.yaml, published: [{what: x, printed: 0.12, exact: %s, verdict: %s, figure: duration()%s}]}}"
        for exact, verdict, proof, part in (("0.1207", "misprint", "", "agrees with the exact one"), ("0.1153", "source-wrong", "", "agrees with"),
                                            ("0.13", "drawn", ", proof: duration() > 0", "'proof' is for improved")):
            with self.subTest(verdict):
                done = self.batch(row % (exact, verdict, proof), "-q")
                self.assert_failure(done, 3, "cases.a.published[0].verdict: the verdict is " + verdict, part)

    def test_a_point_has_the_coordinates_of_the_space(self):
        done = self.batch("cases: {a: {spec: crank.yaml, points: {D: {rod: [1, 2, 3]}}}}", "-q")
        self.assert_failure(done, 3, "suite.yaml:1:43: cases.a.points.D: expected 2 coordinates of a point of ", "found a list of 3")
        done = self.batch("cases: {a: {spec: crank.yaml, require: 'value(point_position[D], 0) > 0'}}", "-q")
        self.assert_failure(done, 3, "'point_position[D]' needs a case with 'points'")

    def test_keys_of_another_kind_of_case_are_refused(self):
        for keys, part in (("rates: {A: 1}", "'rates' is for run: equations, not for 'run: motion'"),
                           ("run: design, at: {A: 1}", "'at' is for run: equations"),
                           ("run: conditions, goal: force, trajectory: no", "'trajectory' is for run: motion, run: equations or run: modes")):
            done = self.batch(f"cases: {{a: {{spec: crank.yaml, {keys}}}}}", "-q")
            self.assert_failure(done, 3, "cases.a: " + part)
        self.assert_holds("defaults: {spec: crank.yaml, at: {A: 1}, trajectory: turn}\n"
                          "cases: {a: {require: duration() > 0}, b: {run: equations, require: 'abs(torque[A]) >= 0'}}\n")

    def test_an_improvement_whose_proof_is_not_judged_does_not_hold(self):
        done = self.batch("""
cases:
  broken: {spec: missing.yaml}
  a:
    spec: crank.yaml
    published:
      - {what: time, unit: s, printed: 1, exact: 1.5, tolerance: 9, verdict: improved, figure: duration(),
         proof: "duration() < duration(broken) || duration() > 0"}
""", "-q")
        self.assertIn("the proof is not judged", done.stderr)

    def test_a_new_requirement_computes_only_the_cases_that_lack_its_figure(self):
        cases = "defaults: {spec: crank.yaml}\ncases:\n  a: {require: [duration() > 0%s]}\n  b: {set: {m: 2}, require: duration() > 0}\n"
        self.assert_holds(cases % "")
        done = self.batch(cases % "")
        self.assertIn("2 of 2 cases were finished already", done.stderr)
        done = self.batch(cases % ", 'value(joint_velocity[X], 0.01) < 9'")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1 of 2 cases were finished already", done.stderr)
        done = self.batch(cases % "")  # a figure too many is no reason to compute
        self.assertIn("2 of 2 cases were finished already", done.stderr)

    def test_compare_evaluates_the_same_figures_of_files_and_specs(self):
        spec = self.path("crank.yaml")
        self.assert_quiet_success(run("simulate", spec, "-o", self.path("file.h5"), "--quiet"))
        for requirement in ("value(joint_velocity[X], joint_position[A] = pi/3) == base",
                            "value(body_angular_velocity[rod], 0.01) == base",
                            "minimum(joint_velocity[X]) == -maximum(joint_velocity[X])"):
            done = run("compare", spec + ":turn", self.path("file.h5"), "--require", requirement)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        done = run("compare", spec, self.path("file.h5"), "--require", "value(joint_velocty[X], 0) < 1")
        self.assert_failure(done, 2, "column 7: no run has a quantity 'joint_velocty[X]'; nearest is 'joint_velocity[X]'")


class WithoutMotion(Suite):
    def test_a_design_alone_has_numbers_a_verdict_and_a_bound(self):
        self.write("rotor.yaml", ROTOR)
        summary = self.assert_holds("""
cases:
  rotor:
    spec: rotor.yaml
    run: design
    require:
      - verdict() == proved-best
      - verdict() == balanced && verdict() != impossible
      - abs(number(counterweights.cw.mass) - 4.8) <= 1e-8
      - abs(added_mass() - objective()) <= 1e-9 && gap() <= 1e-6 && bound() <= 4.8
      - abs(number(parameters.a) - 180) <= 1e-6
""")
        self.assertEqual(summary["cases"][0]["status"], "done")
        self.assertIn("1 of 1 cases were finished already", self.batch("cases: {rotor: {spec: rotor.yaml, run: design}}").stderr)
        done = self.batch("cases: {rotor: {spec: rotor.yaml, run: design, require: number(counterweights.cv.mass) < 9}}", "-q")
        self.assert_failure(done, 3, "column 8: there is no number 'counterweights.cv.mass'", "nearest is 'counterweights.cw.mass'")

    def test_an_impossible_design_is_a_result_only_for_those_who_ask(self):
        self.assert_holds("cases: {a: {spec: 5R-IMPOSSIBLE.YAML, run: design, require: verdict() == impossible}}")
        self.assertEqual(self.batch("cases: {a: {spec: 5R-IMPOSSIBLE.YAML, run: design}}").returncode, 1)
        done = self.batch("cases: {a: {spec: 5R-IMPOSSIBLE.YAML, run: design, require: verdict() == balanced}}", "-q")
        self.assert_failure(done, 1, "FAILED verdict() == balanced [a]: the verdict is impossible")

    def test_conditions_are_those_of_the_command(self):
        conditions = self.program_json("conditions", os.path.join(CONFIGS, "5r.yaml"), "--goal", "force")
        met = int(all(one["met"] for one in conditions["conditions"]))
        self.assert_holds(f"""
cases:
  a: {{spec: 5R.YAML, run: conditions, goal: force,
      require: "rank() == {conditions['rank']} && conditions() == rank() && impossible() == 0 && holds() == {met}"}}
""")

    def test_equations_are_those_of_the_command(self):
        spec = os.path.join(CONFIGS, "planar-rrr.yaml")
        names = self.program_json("equations", spec, "--at", "start")["independent"]
        pose, rates, accelerations = ({name: value for name, value in zip(names, values)}
                                      for values in ((0.3, -0.2, 0.5), (1, 2, -1), (0.5, 0, -2)))
        option = lambda values: ",".join(f"{name}={value}" for name, value in values.items())  # noqa: E731
        at = self.program_json("equations", spec, "--at", option(pose), "--rates", option(rates),
                               "--accelerations", option(accelerations))
        state = self.program_json("simulate", spec, "--at", option(pose), "--rates", option(rates),
                                  "--accelerations", option(accelerations))
        self.assertTrue(state)
        requirements = []

        def expect(figure, value):
            requirements.append(f"abs({figure} - ({value!r})) <= {1e-12 * max(1, abs(value))!r}")

        dq = [rates[name] for name in names]
        for k, name in enumerate(names):
            expect(f"torque[{name}]", at["torques"][name]["sum"])
            expect(f"value(gravity[{name}])", at["z"]["weight"][k])
            velocity = sum(at["D"][k][r][s] * dq[r] * dq[s] for r in range(len(dq)) for s in range(len(dq)))
            expect(f"velocity[{name}]", velocity)
            for j, other in enumerate(names):
                expect(f"inertia[{name}, {other}]", at["M"][k][j])
        energy = sum(at["M"][k][j] * dq[k] * dq[j] for k in range(len(dq)) for j in range(len(dq))) / 2
        expect("value(kinetic_energy)", energy)
        listing = "\n".join(f"      - {json.dumps(one)}" for one in requirements)
        self.assert_holds(f"""
cases:
  state:
    spec: PLANAR-RRR.YAML
    run: equations
    at: {json.dumps(pose)}
    rates: {json.dumps(rates)}
    accelerations: {json.dumps(accelerations)}
    require:
{listing}
""")
        self.assertGreater(len(requirements), 18)

    def test_a_solved_parameter_is_the_root_of_the_closed_form(self):
        self.write("arm.yaml", ARM)
        summary = self.assert_holds("""
cases:
  a:
    spec: arm.yaml
    solve: {m: {figure: "value(torque[J], start)", equals: 15, within: [0.1, 10]}}   # m g / 2 = 15
    require: [abs(number(m) - 3) <= 3e-12, "abs(value(torque[J], start) - 15) <= 1e-9"]
  b:
    spec: arm.yaml
    run: equations
    at: {J: pi/3}
    solve: {m: {figure: "torque[J]", equals: 5, within: [0.1, 10]}}
    require: abs(number(m) - 2) <= 2e-12
""")
        self.assertAlmostEqual(summary["cases"][0]["solved"]["m"], 3, places=11)
        done = self.batch("cases: {a: {spec: arm.yaml, solve: {m: {figure: 'value(torque[J], start)', equals: 0, within: [1, 2]}}}}", "-q")
        self.assert_failure(done, 4, "value(torque[J], start) is 5 N m at m = 1 and 10 N m at m = 2: it does not pass 0 between them")
        done = self.batch("cases: {a: {spec: arm.yaml, solve: {n: {figure: 'value(torque[J], start)', equals: 0, within: [1, 2]}}}}", "-q")
        self.assert_failure(done, 3, "cases.a.solve.n")

    def test_figures_of_other_kinds_of_cases_say_what_they_need(self):
        self.write("arm.yaml", ARM)
        for figure, part in (("added_mass()", "'design: true' or 'run: design'"), ("rank()", "'run: conditions'"),
                             ("number(m)", "a design or with 'solve'"), ("value(torque[J])", "needs a moment")):
            done = self.batch(f"cases: {{a: {{spec: arm.yaml, require: '{figure} < 1'}}}}", "-q")
            self.assert_failure(done, 3, "cases.a.require", part)


if __name__ == "__main__":
    unittest.main()
