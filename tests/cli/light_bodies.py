"""Bodies without mass and point masses, inertias kept as given, passive freedoms of legs that slide."""

import json
import unittest

import h5py
import numpy as np

from _program import Case, run

ARM = """\
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0]}}}}
bodies:
  upper: {{{upper}, points: {{B: [0.4, 0]}}}}
  lower: {{mass: 1, com: [0.2, 0.02], inertia: 0.02}}
joints:
  J1: {{type: revolute, connects: [ground.O, upper.origin]}}
  J2: {{type: revolute, connects: [upper.{at}, lower.origin]}}
actuators: [J1, J2]
motion: {{duration: 1, from: {{joints: {{J1: 0.1, J2: 1}}}}, to: {{joints: {{J1: 1, J2: -0.5}}}}}}
"""

# a platform on six legs would have six of these: here one leg between the ground and a body on a slide
LEG = """\
space: spatial
gravity: [0, 0, -9.81]
ground: {{points: {{A: [0, 0, 0], S: [0.3, 0, 1]}}}}
bodies:
  tube: {{mass: 1, com: [0, 0, 0.2], inertia: [0.02, 0.02, 0.001]}}
  rod: {{{rod}}}
  block: {{mass: 2, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints:
  A: {{type: spherical, connects: [ground.A, tube.origin]}}
  L: {{type: prismatic, connects: [tube.origin, rod.origin], axis: [{tilt}, 0, 1]}}
  B: {{type: spherical, connects: [rod.origin, block.origin]}}
  S: {{type: prismatic, connects: [ground.S, block.origin], axis: [1, 0, 0]}}
actuators: [L]
assembly: {{L: 1, S: 0}}
"""


def arm(upper, at="B"):
    return ARM.format(upper=upper, at=at)


class Light(Case):
    def torques(self, upper):
        done = run("simulate", self.write("arm.yaml", arm(upper)), "--trajectory", "cycloid", "-o", self.path("o.h5"), "-q", "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(self.path("o.h5"), "r") as file:
            return file["torque"][:]

    def test_efforts_without_mass_are_those_of_the_linear_law(self):
        """Efforts are linear in masses and inertias: what belongs to none is twice that of one part less that of two."""
        one, two = (self.torques(f"mass: {k}, com: [0.2, 0.1], inertia: {0.03 * k}") for k in (1, 2))
        for nothing in ("mass: 0", "mass: 0, com: [5, 5]", "mass: 0, com: [0, 0], inertia: 0"):
            self.assertLess(np.abs(self.torques(nothing) - (2 * one - two)).max(), 1e-12 * np.abs(two).max())
        point, some = self.torques("mass: 1, com: [0.2, 0.1], inertia: 0"), self.torques("mass: 1, com: [0.2, 0.1], inertia: 0.06")
        self.assertLess(np.abs(point - (2 * one - some)).max(), 1e-12 * np.abs(two).max())

    def test_both_formulations_agree(self):
        done = run("check", self.write("arm.yaml", arm("mass: 0")), "--verify")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_conditions_and_designs_need_no_mass(self):
        spec = arm("mass: 0") + "counterweights: {cw: {body: lower, at: [{free: [-1, 0]}, {free: [-1, 1]}], mass: {free: [0, 9]}}, " \
            "up: {body: upper, at: [{free: [-1, 0]}, {free: [-1, 1]}], mass: {free: [0, 99]}}}\n"
        done = run("design", self.write("d.yaml", spec), "--goal", "static", "--json")
        self.assertEqual((done.returncode, json.loads(done.stdout)["status"]), (0, "balanced"), done.stderr)
        self.assertEqual(run("conditions", self.path("d.yaml"), "--goal", "force", "--json").returncode, 0)

    def test_control_needs_what_resists(self):
        fine = run("control", self.write("a.yaml", arm("mass: 0")), "--trajectory", "cycloid", "-c", "computed-torque", "-q")
        self.assertEqual(fine.returncode, 0, fine.stderr)
        # both joints in one place: the massless body turns freely between them
        done = run("control", self.write("b.yaml", arm("mass: 0", "origin")), "--trajectory", "cycloid", "-c", "computed-torque", "-q")
        self.assert_failure(done, 4, "mass matrix is singular", "body 'upper' has no mass")
        self.assertEqual(run("simulate", self.path("b.yaml"), "--trajectory", "cycloid", "-q").returncode, 0)

    def test_an_end_without_mass_is_warned_of(self):
        text = arm("mass: 1, com: [0, 0], inertia: 1").replace("mass: 1, com: [0.2, 0.02], inertia: 0.02", "mass: 0")
        done = run("check", self.write("e.yaml", text))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("e.yaml:6:17: bodies.lower.mass: the body has no mass and carries nothing", done.stderr)
        self.assert_quiet_success(run("check", self.write("f.yaml", text + "payloads: {cargo: {body: lower, at: origin, mass: 2}}\n")))

    def test_inertia_without_mass_is_a_mistake(self):
        self.assert_failure(run("check", self.write("i.yaml", arm("mass: 0, com: [0, 0], inertia: 0.1"))), 3, "bodies.upper.mass: must be positive")

    def test_the_verdict_does_not_depend_on_the_tool(self):
        bob = arm("mass: 1, com: [0, 0], inertia: 1").replace("inertia: 0.02", "inertia: 0")
        for text in (bob, bob + "tool: lower.origin\n"):
            self.assert_quiet_success(run("check", self.write("p.yaml", text)))

    def test_every_command_takes_what_check_takes(self):
        ends = {"no mass": "mass: 0", "point": "mass: 1, com: [0.2, 0.1], inertia: 0", "as given": "mass: 1, com: [0.2, 0.1], inertia: {as_given: -0.01}"}
        for what, body in ends.items():
            spec = self.write("all.yaml", arm(body) + "tolerances: {lower.mass: 1%}\n")
            for words in (["check"], ["simulate"], ["simulate", "--split", "--force", "-o", self.path("split.h5")], ["conditions", "-g", "static"], ["equations"], ["equations", "--at", "start"],
                          ["equations", "--code", "c"], ["equations", "--latex"], ["tolerance"], ["tolerance", "--at-rest"]):
                done = run(words[0], spec, *words[1:])
                self.assertEqual(done.returncode, 0, (what, words, done.stderr))

    def test_a_mechanism_without_mass_is_called_so(self):
        text = arm("mass: 0").replace("mass: 1, com: [0.2, 0.02], inertia: 0.02", "mass: 0")
        done = run("simulate", self.write("n.yaml", text))
        self.assert_failure(done, 4, "no body has mass")
        self.assertNotIn("overflow", done.stderr)

    def test_an_inertia_that_no_body_has(self):
        text = arm("mass: 1, com: [0.2, 0.1], inertia: {as_given: -0.3}")
        for command in (("check",), ("simulate", "--trajectory", "cycloid"), ("conditions", "--goal", "static")):
            done = run(command[0], self.write("g.yaml", text), *command[1:])
            self.assertIn("g.yaml:5:46: bodies.upper.inertia: kept as given: no body can have this inertia", done.stderr, command)
        self.assertEqual(run("check", self.write("h.yaml", arm("mass: 1, com: [0, 0], inertia: {as_given: 0.3}"))).stderr, "")


class Legs(Case):
    def check(self, rod="mass: 0.5, com: [0, 0, -0.1], inertia: [0.01, 0.01, 0.001]", tilt=0):
        done = run("check", self.write("leg.yaml", LEG.format(rod=rod, tilt=tilt)), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_a_leg_spins_about_its_line(self):
        found = self.check()
        self.assertEqual((found["degrees_of_freedom"], len(found["passive_freedoms"])), (1, 1))
        self.assertIn("could spin", found["passive_freedoms"][0])

    def test_a_leg_off_its_line_does_not(self):
        self.assertEqual(self.check(rod="mass: 0.5, com: [0.01, 0, -0.1], inertia: [0.01, 0.01, 0.001]")["degrees_of_freedom"], 2)

    def test_a_rod_without_mass_spins(self):
        self.assertEqual(len(self.check(rod="mass: 0")["passive_freedoms"]), 1)

    def test_efforts_of_a_held_leg(self):
        """The power of the drive is the rate of energy: the held spin takes none."""
        motion = "motion: {duration: 1, from: {joints: {L: 1.05}}, to: {joints: {L: 1.3}}}\n"
        text = LEG.format(rod="mass: 0.5, com: [0, 0, -0.1], inertia: [0.01, 0.01, 0.001]", tilt=0).replace("[0, 0, 0], S", "[0, 0.2, 0], S")
        done = run("simulate", self.write("m.yaml", text + motion), "--trajectory", "cycloid", "-o", self.path("m.h5"), "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(self.path("m.h5"), "r") as file:
            time, power, energy = file["time"][:], file["power"][:].sum(1), file["kinetic_energy"][:]
            height, mass = file["com_position"][:, 2], 3.5
        energy = energy + mass * 9.81 * height
        work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])
        # the trapezoidal rule is exact to the square of a step
        self.assertLess(np.abs(work - (energy - energy[0])).max(), 1e-4 * np.abs(work).max())


if __name__ == "__main__":
    unittest.main()
