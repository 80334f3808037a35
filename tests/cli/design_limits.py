"""`design: subject_to`: what it finds keeps its limits, is the best that does where that can be told by another route, and where
limits cannot be kept says by how little they can be missed."""

import json
import re
import unittest

from _program import Case, config, run
from _search_problems import problem


def arm(design):
    """Counterweights' products are fixed by the conditions: m₂ |x₂| = 0.5, m₁ |x₁| = 0.5 + 0.5 (2 + m₂)."""
    return config("rr-design.yaml", (r"design: \{.*\}", "design: {" + design + "}"))


class Limits(Case):
    def design(self, text, code, *options):
        done = run("design", self.write("spec.yaml", text), "--json", "-o", self.path("out.yaml"), "--force", *options)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return json.loads(done.stdout)

    def number(self, found, path):
        return next(n["value"] for n in found["free_numbers"] if n["path"] == path)

    def figure(self, trajectory, quantity, figure):
        """Of the written design, run anew."""
        done = run("simulate", self.path("out.yaml"), "-t", trajectory, "--json")
        metrics = json.loads(done.stdout)["metrics"]
        return next(m[figure] for m in metrics if m["quantity"] == quantity)

    # a search without slopes steps back from a limit by up to 1e-5 of it
    def test_least_mass_within_a_clearance_from_above_is_that_of_the_closed_form(self):
        found = self.design(arm('goal: gyroscopic, minimize: added-mass, subject_to: "clearance(cw1, ground.O) <= 0.2"'), 0)
        self.assertEqual(found["status"], "balanced")
        self.assertAlmostEqual(found["objective"]["value"], 0.5 / 0.3 + (0.5 + 0.5 * (2 + 0.5 / 0.3)) / 0.2, delta=1e-4)
        limit, = found["constraints"]
        self.assertTrue(limit["active"] and limit["kept"])
        self.assertAlmostEqual(limit["value"], 0.2, delta=2e-6)
        self.assertAlmostEqual(limit["limit"], 0.2)

    def test_least_inertia_beside_a_line_is_that_of_the_closed_form(self):
        # 0.25 (1.5 + 0.25 / |x₂|) + 0.5 |x₂| falls up to |x₂| = 0.3; beyond the line's end the distance is that from the end
        found = self.design(arm('goal: gyroscopic, minimize: added-inertia, '
                                'subject_to: ["clearance(cw1, link1.P1 to link1.P2) >= 0.25", '
                                '"clearance(cw2, link2.P2) >= 0.1"]'), 0)
        self.assertAlmostEqual(self.number(found, "counterweights.cw1.at[0]"), -0.25, delta=1e-6)
        self.assertAlmostEqual(self.number(found, "counterweights.cw2.at[0]"), -0.3, delta=1e-5)
        self.assertAlmostEqual(found["objective"]["value"], 0.25 * (1.5 + 0.25 / 0.3) + 0.5 * 0.3, delta=1e-6)
        self.assertEqual([limit["active"] for limit in found["constraints"]], [True, False])

    def test_limits_that_no_balanced_design_keeps_are_missed_by_as_little_as_can_be(self):
        least = 0.5 / 0.3 + (0.5 + 0.5 * (2 + 0.5 / 0.3)) / 0.3
        found = self.design(arm('goal: gyroscopic, subject_to: "added_mass <= 9"'), 1)
        self.assertIn(found["status"], ("compromise", "impossible"))
        limit, = found["constraints"]
        self.assertAlmostEqual(limit["violation"], least / 9 - 1, delta=1e-5)
        self.assertFalse(limit["kept"])
        self.assertIn("added_mass <= 9 is missed by 4.94 % of its bound", found["reason"])

    def test_what_is_proved_of_a_convex_problem_agrees_with_its_unlimited_optimum(self):
        free = config("5r-design.yaml")
        goal = re.search(r"design:.*", free, re.DOTALL).group()
        minimal = self.design(free.replace(goal, "design: {goal: static, minimize: added-mass}\n"), 0)
        self.assertEqual(minimal["optimality"], "proved-best")
        least = minimal["objective"]["value"]
        limited = free.replace(goal, f"design: {{goal: static, subject_to: 'added_mass <= {0.9 * least}'}}\n")
        found = self.design(limited, 1)
        self.assertEqual((found["status"], found["proved"]), ("impossible", True))
        self.assertAlmostEqual(found["constraints"][0]["violation"], 1 / 0.9 - 1, delta=1e-6)
        self.assertAlmostEqual(found["least_violation"], 1 / 0.9 - 1, delta=1e-6)
        kept = self.design(limited.replace(str(0.9 * least), str(1.1 * least)), 0)
        self.assertTrue(kept["constraints"][0]["kept"])

    def test_a_peak_limits_the_mass_as_bisection_does(self):
        text = config("rr-design.yaml", (r"design: \{.*\}", "design: {minimize: added-mass, "
                                         'subject_to: "peak(torque[R2], cycloid) <= 3"}'),
                      (r"at: \[\{free: \[-0\.3, -0\.05\]\}, 0\]", "at: [-0.2, 0]"),
                      (r"cw1: \{.*?\}\}", "cw1: {body: link1, at: [-0.2, 0], mass: 0}"))
        found = self.design(text, 0)
        self.assertEqual(found["optimality"], "proved-best")
        mass = self.number(found, "counterweights.cw2.mass")
        self.assertAlmostEqual(self.figure("cycloid", "torque[R2]", "peak"), 3, delta=1e-6)
        # a little less would be too little
        with open(self.path("out.yaml"), encoding="utf-8") as file:
            lighter, count = re.subn(r"(cw2: .*mass: )[0-9.e-]+", rf"\g<1>{mass * (1 - 1e-4)}", file.read())
        self.assertEqual(count, 1)
        self.write("out.yaml", lighter)
        self.assertGreater(self.figure("cycloid", "torque[R2]", "peak"), 3)

    def test_a_range_of_what_has_a_sign_is_convex_and_proved(self):
        linkage = problem(12).split("design: {")[0]
        found = self.design(linkage + 'design: {minimize: {range: shaking_moment, along: go}}\n', 0)
        value = found["objective"]["value"]
        self.assertEqual(found["optimality"], "proved-best")
        self.assertAlmostEqual(found["objective"]["lower_bound"], value, delta=1e-6 * value)
        self.assertAlmostEqual(self.figure("go", "shaking_moment", "range"), value, delta=1e-9 * value)
        # as a limit it is kept, and costs no proof
        limit = f'subject_to: ["range(shaking_moment, go) <= {1.2 * value!r}"]'
        limited = self.design(linkage + f'design: {{minimize: {{rms: torque, along: go}}, {limit}}}\n', 0)
        self.assertEqual(limited["optimality"], "proved-best")
        self.assertLessEqual(self.figure("go", "shaking_moment", "range"), 1.2 * value * (1 + 1e-9))
        # beside a free length, which can only help
        longer = re.sub(r"l_rocker: ([0-9.]+)", r"l_rocker: {free: [0.95*\1, 1.05*\1], start: \1}", linkage)
        free = self.design(longer + f"design: {{minimize: {{rms: torque, along: go}}, {limit}, search: {{seconds: 3}}}}\n", 0)
        self.assertEqual(free["search"]["without_design"], 0)
        self.assertLessEqual(free["objective"]["value"], limited["objective"]["value"] * (1 + 1e-9))

    def test_a_limit_on_a_length_bounds_the_search_for_lengths(self):
        """Every start ends within it, also where the best figure without the limit is beyond it."""
        spring = """space: planar
gravity: [0, -9.81]
parameters: {k: {free: [0, 2000]}, h: {free: [0.05, 0.4], start: 0.2}, s: {free: [0.05, 0.25], start: 0.1}}
ground: {points: {O: [0, 0], S: [0, h]}}
bodies: {arm: {mass: 3, com: [0.3, 0], inertia: 0.05, points: {O: [0, 0], P: [s, 0]}}}
joints: {A: {type: revolute, connects: [ground.O, arm.O]}}
actuators: [A]
springs: {sp: {between: [ground.S, arm.P], stiffness: k, free_length: 0.1}}
motion: {duration: 1, samples: 21, from: {joints: {A: -0.5}}, to: {joints: {A: 1.3}}}
trajectories: {go: {law: cycloidal, drive: joints}}
design: {minimize: {peak: torque}, subject_to: ["maximum(spring_length[sp]) <= 0.28"], search: {seconds: 3, starts: 3}}
"""
        found = self.design(spring, 0)
        self.assertTrue(found["constraints"][0]["kept"])
        self.assertEqual(found["search"]["without_design"], 0)
        self.assertLess(found["objective"]["value"], found["objective"]["start"])

    def test_limits_alone_are_a_task(self):
        found = self.design(arm('subject_to: ["mobility(cycloid) >= 1e-3", "peak(torque[R2]) <= 3", '
                                '"clearance(cw2, link1.P1) >= 0.05"]'), 0)
        self.assertEqual((found["status"], found["optimality"]), ("not-asked", "not-asked"))
        self.assertTrue(all(limit["kept"] for limit in found["constraints"]))
        self.assertLessEqual(self.figure("cycloid", "torque[R2]", "peak"), 3 * (1 + 1e-9))

    def test_lengths_are_free_beside_limits_as_well(self):
        """Where a weighted sum of two figures is least, neither can be less while the other is limited to what it is there."""
        text = config("four-bar-front.yaml", ("coupler: 0.35", "coupler: {free: [0.3, 0.5], start: 0.35}"),
                      ("rocker: 0.25", "rocker: {free: [0.2, 0.45], start: 0.25}"), (r"\ndesign:.*", "\n"))
        force, moment = ({"rms": figure, "along": "steady"} for figure in ("shaking_force", "shaking_moment"))

        def design(**wanted):
            return self.design(text + "design: " + json.dumps(wanted) + "\n", 0)

        design(minimize=[force, {"weight": 4, **moment}])
        least = {of: self.figure("steady", of, "rms") for of in ("shaking_force", "shaking_moment")}
        found = design(minimize=force, subject_to=f"rms(shaking_moment, steady) <= {least['shaking_moment']}")
        self.assertTrue(found["constraints"][0]["kept"])
        self.assertLessEqual(found["objective"]["value"], least["shaking_force"] * (1 + 1e-5))
        # and where both are to be less than they can be together, the worst is missed by as little as can be
        limits = [f"rms({of}, steady) <= {0.9 * value}" for of, value in least.items()]
        missed = self.design(text + "design: " + json.dumps({"subject_to": limits}) + "\n", 1)["constraints"]
        beyond = [limit["value"] / limit["limit"] - 1 for limit in missed]
        self.assertAlmostEqual(beyond[0], beyond[1], delta=1e-3)
        self.assertLessEqual(max(beyond), 1 / 0.9 - 1 + 1e-6)

    def test_a_search_ends_within_its_seconds(self):
        found = self.design(arm('goal: gyroscopic, minimize: {rms: shaking_moment_com, along: bang-bang}, '
                                'subject_to: "energy(cycloid) <= 40"'), 0, "--seconds", "0.5")
        self.assertEqual(found["seconds"], 0.5)
        self.assertIn(found["optimality"], ("stopped", "local-best"))


if __name__ == "__main__":
    unittest.main()
