"""Figures of designs: every figure that a design reports is that of the designed mechanism's run, in the same words that
comparisons use; limits on reactions and components are proved as those on forces; a limit does not cost a proof."""

import json
import re
import unittest

from _program import Case, run

# A crank with a connecting rod between two guides out of line; a spring from the ground to the rod.
ENGINE = """\
space: {space}
gravity: [0, -9.81{z}]
parameters: {{a: 0.1, bore: 0.4}}
ground: {{points: {{O: [0, 0{z}], X: [0, 0{z}], S: [-0.3, 0.1{z}], M: [0.2, 0.3{z}]}}}}
bodies:
  crank: {{mass: 2, com: [0.03, 0.01{z}], {crank}, points: {{O: [0, 0{z}], E: [a, 0{z}], W: [-0.05, 0{z}]}}}}
  rod: {{mass: 1.5, com: [0.1, 0.01{z}], {rod}, points: {{E: [0, 0{z}], P: [bore, 0{z}], K: [0.1, 0.05{z}]}}}}
  piston: {{mass: 1, com: [0, 0{z}], {piston}, points: {{C: [0, 0{z}]}}}}
joints:
  A: {{type: revolute, connects: [ground.O, crank.O]{axis}}}
  B: {{type: revolute, connects: [crank.E, rod.E]{axis}}}
  C: {{type: revolute, connects: [rod.P, piston.C]{axis}}}
  X: {{type: prismatic, connects: [ground.X, piston.C], axis: [1, 0{z}]}}
actuators: [A]
springs: {{s: {{between: [ground.S, rod.K], stiffness: 40, free_length: 0.1}}}}
counterweights:
  w: {{body: crank, at: [{place}, 0{z}], mass: {{free: [0, 4], start: 1}}}}
  v: {{body: rod, at: [-0.08, 0.02{z}], mass: {{free: [0, 4], start: 0.5}}}}
motion: {{duration: 0.4, samples: 81, from: {{joints: {{A: 0.3}}}}, to: {{joints: {{A: "0.3 + 2 * pi"}}}}}}
trajectories: {{turn: {{law: uniform, drive: joints}}}}
assembly: {{A: 0.3, B: -0.37, C: 0.07, X: 0.49}}
design: {{search: {{seconds: 20}}, {design}}}
"""

FIGURES = ["rms(shaking_force[x], turn)", "peak(shaking_force[y], turn)", "maximum(shaking_force[x], turn)",
           "minimum(shaking_force.x, turn)", "range(joint_force[B][y], turn)", "mean(joint_force[A].x, turn)",
           "peak(joint_force[X], turn)", "maximum(joint_moment[X], turn)", "rms(shaking_moment about ground.M, turn)",
           "peak(ground_moment about ground.M, turn)", "maximum(torque[A], turn)", "minimum(power[A], turn)",
           "maximum(distance[ground.S, rod.K], turn)", "minimum(distance[w, rod.E to rod.P], turn)",
           "range(spring_length[s], turn)", "maximum(spring_force[s], turn)", "maximum(joint_position[X], turn)",
           "peak(joint_velocity[X], turn)", "rms(joint_acceleration[B], turn)", "maximum(potential_energy, turn)",
           "peak(kinetic_energy, turn)", "range(com_position[x], turn)", "peak(body_acceleration[rod][y], turn)",
           "rms(com_velocity[y], turn)", "peak(shaking_moment_com, turn)", "energy(turn)", "peak(joint_force, turn)"]


def engine(design, *, spatial=False, place="-0.06"):
    inertia = "inertia: [0.01, 0.01, 0.02]" if spatial else "inertia: 0.01"
    return ENGINE.format(space="spatial" if spatial else "planar", z=", 0" if spatial else "",
                         axis=", axis: [0, 0, 1]" if spatial else "", crank=inertia, rod=inertia, piston=inertia,
                         place=place, design=design)


class Figures(Case):
    def design(self, text, code=0, *options):
        done = run("design", self.write("spec.yaml", text), "--json", "-o", self.path("out.yaml"), "--force", *options)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return json.loads(done.stdout)

    def require(self, requirements):
        """Of the written design, computed anew."""
        spec = self.path("out.yaml")
        options = [word for one in requirements for word in ("--require", one)]
        done = run("compare", f"{spec}:cycloid", f"{spec}:turn", *options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def compare_with_run(self, found):
        requirements = []
        for limit in found["constraints"]:
            name = limit["text"].split("<=")[0].strip()
            # a relative 1e-9 of the value, and of a unit where it vanishes
            requirements.append(f"abs({name} - ({limit['value']!r})) <= {1e-9 * max(1, abs(limit['value']))}")
        self.require(requirements)

    def test_figures_are_those_of_the_run_where_the_motion_is_fixed(self):
        for spatial in (False, True):
            figures = [f for f in FIGURES if not (spatial and "joint_moment" in f)]
            limits = json.dumps([f"{figure} <= 1e9" for figure in figures])
            self.compare_with_run(self.design(engine(f"minimize: added-mass, subject_to: {limits}", spatial=spatial)))

    def test_figures_are_those_of_the_run_where_the_motion_is_free(self):
        text = engine(f"minimize: added-mass, subject_to: {json.dumps([f'{figure} <= 1e9' for figure in FIGURES])}")
        text = text.replace("a: 0.1,", "a: {free: [0.08, 0.12], start: 0.1},").replace("seconds: 20", "seconds: 1")
        self.compare_with_run(self.design(text))

    def test_one_spelling_for_terms_sums_and_fronts(self):
        objectives = []
        for minimize in ('{rms: "shaking_force[x]", along: turn}', '"rms(shaking_force[x], turn)"',
                         '[{rms: "shaking_force.x", along: turn}]'):
            objectives.append(self.design(engine(f"minimize: {minimize}"))["objective"]["value"])
        self.assertEqual(len(set(objectives)), 1)
        self.require([f"abs(rms(shaking_force[x], turn) - {objectives[0]!r}) <= 1e-9 * {objectives[0]!r}"])
        front = engine('front: {of: [{rms: "shaking_force[x]", along: turn}, {peak: "joint_force[B][y]", along: turn}], points: 3}')
        done = run("design", self.write("front.yaml", front), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        figures = json.loads(done.stdout)["front"]["figures"]
        self.assertEqual([figure["unit"] for figure in figures], ["N", "N"])
        self.assertIn("rms of shaking_force[x]", figures[0]["name"])

    def test_limits_on_reactions_and_signed_extremes_are_proved(self):
        free = self.design(engine("minimize: {rms: shaking_force, along: turn}"))
        self.assertEqual(free["optimality"], "proved-best")
        for figure in ("peak(joint_force[B], turn)", "maximum(joint_force[A][x], turn)", "peak(shaking_force[y], turn)",
                       "rms(shaking_moment about ground.M, turn)", "range(joint_force[B][x], turn)"):
            loose = self.design(engine(f'minimize: {{rms: shaking_force, along: turn}}, subject_to: "{figure} <= 1e6"'))
            value = loose["constraints"][0]["value"]
            limited = self.design(engine(
                f'minimize: {{rms: shaking_force, along: turn}}, subject_to: "{figure} <= {value - 5e-4 * abs(value)!r}"'))
            self.assertEqual(limited["optimality"], "proved-best", figure)
            self.assertTrue(limited["constraints"][0]["kept"], figure)
            self.assertGreater(limited["objective"]["value"], free["objective"]["value"], figure)

    def test_a_limit_that_no_proof_covers_does_not_cost_the_proof(self):
        free = self.design(engine("minimize: {rms: shaking_force, along: turn}"))
        for limit in ("peak(com_acceleration, turn) <= 1e6", "rms(shaking_moment_com, turn) >= 1e-6"):
            found = self.design(engine(f'minimize: {{rms: shaking_force, along: turn}}, subject_to: "{limit}"'))
            self.assertEqual(found["optimality"], "proved-best", limit)
            self.assertAlmostEqual(found["objective"]["value"], free["objective"]["value"],
                                   delta=1e-6 * free["objective"]["value"])

    def test_a_start_that_keeps_all_limits_is_a_design(self):
        before = self.design(engine('minimize: added-mass, subject_to: "range(com_acceleration[x], turn) <= 1e6"'))
        found = self.design(engine('subject_to: "distance(w, ground.O, turn) <= 0.0601"', place="{free: [-0.2, -0.01], start: -0.06}"))
        self.assertTrue(found["constraints"][0]["kept"], before)

    def test_names_that_do_not_exist_are_said_with_their_place(self):
        for text, wrong, words in (
                ('subject_to: "peak(joint_force[Q][x], turn) <= 1"', "joint_force[Q][x]", "joint_force"),
                ('subject_to: "peak(shaking_force[z], turn) <= 1"', "shaking_force[z]", "only x and y"),
                ('subject_to: "peak(shaking_moment about ground.N, turn) <= 1"', "ground.N", "a point of ground (O"),
                ('subject_to: "peak(shaking_moment about rod.P, turn) <= 1"', "rod.P", "a point of the ground"),
                ('subject_to: "maximum(distance[rod.P, crank.Q], turn) <= 1"', "crank.Q", "a point of crank"),
                ('minimize: {rms: "shaking_force[w]", along: turn}', "shaking_force[w]", "only x and y")):
            done = run("design", self.write("bad.yaml", engine(text)))
            self.assertEqual(done.returncode, 3, done.stdout)
            self.assertIn(words, done.stderr)
            written = engine(text).splitlines()
            row, column = re.search(r"bad\.yaml:(\d+):(\d+): ", done.stderr).groups()
            self.assertTrue(written[int(row) - 1][int(column) - 1:].lstrip('"').startswith(wrong), done.stderr)


if __name__ == "__main__":
    unittest.main()
