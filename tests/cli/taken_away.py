"""Every command answers, or refuses with a reason, whatever is taken away from a spec."""

import json
import random
import unittest

import h5py

import _taken_away
from _four_bar import four_bar
from _program import Case, run
from _sampling import SEED, WHOLE, draw

CASES = 400 if WHOLE else 60


class TakenAway(unittest.TestCase):
    def test_a_sample_of_all_specs_and_commands(self):
        """The whole is `scripts/soak taken-away`."""
        cases = random.Random(SEED).sample(_taken_away.all_cases(), CASES)
        findings, _ = _taken_away.find(cases)
        self.assertEqual(findings, [], f"SEED={SEED}")

    def test_all_commands_on_what_cannot_move(self):
        forms = draw("forms of commands", _taken_away.FORMS, 0.3, lambda form: {form.split()[0]})
        findings, tried = _taken_away.find([("bricard.yaml", "mobility", form) for form in forms])
        self.assertEqual((tried, findings), (len(forms), []))


PENDULUM = """\
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {bob: {mass: 2, com: [0.5, 0], inertia: 0.1}}
joints: {A: {type: revolute, connects: [ground.O, bob.origin]}}
actuators: []
motion: {duration: 1, samples: 101, from: {joints: {A: 0}}, to: {joints: {A: 1}}}
"""


class WithoutActuators(Case):
    def test_it_is_let_go(self):
        """It falls with constant energy, to the integration's tolerance."""
        done = run("control", self.write("p.yaml", PENDULUM), "-c", "none", "--duration", "1", "-o", self.path("p.h5"), "-q")
        self.assert_quiet_success(done)
        with h5py.File(self.path("p.h5"), "r") as file:
            kinetic, potential = file["kinetic_energy"][:], file["potential_energy"][:]
        self.assertGreater(kinetic.max(), 1)
        self.assertLess(abs(kinetic + potential - kinetic[0] - potential[0]).max(), 1e-6 * kinetic.max())
        told = run("control", self.path("p.yaml"), "-c", "none", "--json")
        self.assertEqual(told.returncode, 0, told.stderr)
        json.loads(told.stdout)

    def test_a_controller_with_torques_is_refused(self):
        self.assert_failure(run("control", self.write("p.yaml", PENDULUM), "-c", "pd"), 4, "under-actuated")


class WithoutAssembly(Case):
    def test_every_command_names_the_joint(self):
        spec = self.write("open.yaml", four_bar(1, 0.2, 0.2, 0.2))
        for words in (["check"], ["equations"], ["equations", "--latex"]):
            done = run(words[0], spec, *words[1:])
            self.assert_failure(done, 4, "joint ", "stays open by")
        self.assert_failure(run("conditions", spec, "-g", "force"), 4, "cannot be closed")


if __name__ == "__main__":
    unittest.main()
