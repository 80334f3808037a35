"""Joints of the type `planar` in the plane: a floating body against closed forms, other joints and the second formulation."""

import json
import os
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, run

M, J, A, B, G = 2, 0.03, 0.12, -0.05, 9.81
U = np.array([0.6, 0.8])
V = np.array([-0.8, 0.6])

BODY = f"""
space: planar
gravity: [0, -{G}]
ground: {{points: {{O: [0.3, 0.1]}}}}
bodies:
  plate: {{mass: {M}, com: [{A}, {B}], inertia: {J}, points: {{C: [0, 0], H: [0.2, 0.1]}}}}
joints:
  P: {{type: planar, connects: [ground.O, plate.C], axis: [0.6, 0.8]}}
actuators: [P.x, P.y, P.angle]
tool: plate.H
motion: {{duration: 0.7, samples: 61, from: {{joints: {{P.x: 0, P.y: 0.1, P.angle: 0.2}}}}, to: {{joints: {{P.x: 0.4, P.y: -0.2, P.angle: 1.5}}}}}}
trajectories: {{go: {{law: cycloidal, drive: joints}}}}
"""

# The same with carriers without mass.
CARRIED = BODY.replace("  plate:", "  lane: {mass: 0, com: [0, 0], inertia: 0, points: {P: [0, 0]}}\n"
                       "  cross: {mass: 0, com: [0, 0], inertia: 0, points: {P: [0, 0]}}\n  plate:").replace(
    "  P: {type: planar, connects: [ground.O, plate.C], axis: [0.6, 0.8]}",
    "  X: {type: prismatic, connects: [ground.O, lane.P], axis: [0.6, 0.8]}\n"
    "  Y: {type: prismatic, connects: [lane.P, cross.P], axis: [-0.8, 0.6]}\n"
    "  T: {type: revolute, connects: [cross.P, plate.C]}").replace("P.x", "X").replace("P.y", "Y").replace("P.angle", "T")

# A four-bar linkage whose coupler also lies on the ground, which only tells where it is.
FOUR_BAR = """
space: planar
gravity: [1, -9]
ground: {points: {A: [0, 0], D: [0.5, 0.02], O: [0.1, 0.2]}}
bodies:
  crank: {mass: 1, com: [0.05, 0.01], inertia: 0.002, points: {A: [0, 0], B: [0.12, 0]}}
  coupler: {mass: 1.5, com: [0.2, 0.05], inertia: 0.02, points: {B: [0, 0], C: [0.45, 0.03], H: [0.2, 0.1]}}
  rocker: {mass: 0.7, com: [0.1, 0], inertia: 0.004, points: {D: [0, 0], C: [0.3, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
  B: {type: revolute, connects: [crank.B, coupler.B]}
  C: {type: revolute, connects: [coupler.C, rocker.C]}
  D: {type: revolute, connects: [ground.D, rocker.D]}
  P: {type: planar, connects: [ground.O, coupler.H], axis: [0.8, -0.6]}
EXTRA
actuators: [A]
tool: coupler.H
assembly: {A: 0.5, D: 2}
motion: {duration: 1, samples: 41, from: {joints: {A: 0.5}}, to: {joints: {A: 2.5}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""

# A plate that slides of two other bodies carry along in both directions.
LED = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0], S: [0.2, 0.4]}}
bodies:
  first: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {C: [0, 0]}}
  second: {mass: 2, com: [0, 0.1], inertia: 0.02, points: {C: [0, 0]}}
  plate: {mass: 3, com: [0.1, 0.2], inertia: 0.05, points: {C: [0, 0], H: [0.2, 0.1]}}
  wheel: {mass: 0.5, com: [0.02, 0], inertia: 0.001, points: {C: [0, 0]}}
joints:
  S: {type: prismatic, connects: [ground.O, first.C], axis: [1, 0]}
  T: {type: prismatic, connects: [ground.S, second.C], axis: [0.6, 0.8]}
  P: {type: planar, connects: [ground.O, plate.C], axis: [0, 1], angle: 0.3}
  W: {type: revolute, connects: [plate.H, wheel.C]}
couplings:
  - {joint: P.x, follows: S, ratio: 0.5, offset: 0.1}
  - {joint: P.y, follows: T, ratio: -2}
actuators: [S, T, P.angle, W]
tool: plate.H
motion: {duration: 1, samples: 41, from: {joints: {S: 0, T: 0, P.angle: 0, W: 0}}, to: {joints: {S: 0.3, T: 0.2, P.angle: 1, W: -2}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""


class PlanarJoint(Case):
    def simulated(self, spec, *call):
        file = self.path("run.h5")
        done = run("simulate", spec, "-o", file, "--force", *call)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file, "r") as results:
            found = {}
            results.visititems(lambda name, node: found.__setitem__(name.split("/")[-1], np.array(node))
                               if isinstance(node, h5py.Dataset) and node.dtype.kind == "f" else None)
        return found

    def agree(self, text, name="s.yaml"):
        done = run("check", self.write(name, text), "--verify")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertIn("both formulations agree", done.stdout)

    def refused(self, text, words):
        done = run("check", self.write("bad.yaml", text))
        self.assertEqual(done.returncode, 3, done.stdout)
        self.assertIn(words, done.stderr)

    def test_a_floating_body_by_newton_and_euler(self):
        found = self.simulated(self.write("body.yaml", BODY))
        q, dq, ddq = (found[f"joint_{name}"] for name in ("position", "velocity", "acceleration"))
        angle = np.arctan2(0, 1) + q[:, 2]
        r = np.stack([A * np.cos(angle) - B * np.sin(angle), A * np.sin(angle) + B * np.cos(angle)], 1)
        normal = np.stack([-r[:, 1], r[:, 0]], 1)
        a = np.outer(ddq[:, 0], U) + np.outer(ddq[:, 1], V) + ddq[:, 2:] * normal - dq[:, 2:]**2 * r
        force = M * (a + [0, G])
        torque = J * ddq[:, 2] + r[:, 0] * force[:, 1] - r[:, 1] * force[:, 0]
        expected = np.stack([force @ U, force @ V, torque], 1)
        np.testing.assert_allclose(found["torque"], expected, rtol=0, atol=1e-12 * np.abs(expected).max())
        place = [0.3, 0.1] + np.outer(q[:, 0], U) + np.outer(q[:, 1], V)
        np.testing.assert_allclose(found["com_position"], place + r, rtol=0, atol=1e-14)
        np.testing.assert_allclose(found["joint_moment"][:, 0], torque, rtol=0, atol=1e-12 * np.abs(expected).max())

    def test_it_replaces_carriers_without_mass(self):
        own, carried = self.simulated(self.write("a.yaml", BODY)), self.simulated(self.write("b.yaml", CARRIED))
        for name in ("torque", "shaking_force", "shaking_moment", "kinetic_energy", "potential_energy", "tool_position"):
            np.testing.assert_allclose(own[name], carried[name], rtol=0, atol=1e-12 * np.abs(own[name]).max(), err_msg=name)

    def test_control_follows_the_floating_body(self):
        file = self.path("c.h5")
        done = run("control", self.write("body.yaml", BODY), "--controller", "computed-torque", "-o", file)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file, "r") as results:
            errors = []
            results.visititems(lambda name, node: errors.append(np.abs(node[:]).max()) if name.endswith("tracking_error") else None)
        self.assertLess(errors[0], 1e-3)

    def test_both_formulations(self):
        self.agree(BODY)
        self.agree(FOUR_BAR.replace("EXTRA", ""))
        self.agree(LED)

    def test_where_a_coupler_is(self):
        """A planar joint that closes a loop holds nothing; with a spring in it, the same motion is under other efforts."""
        plain = self.simulated(self.write("f.yaml", FOUR_BAR.replace("EXTRA", "")))
        place = plain["joint_position"][:, 4:6] @ np.array([[0.8, -0.6], [0.6, 0.8]]) + [0.1, 0.2]
        np.testing.assert_allclose(place, plain["tool_position"], rtol=0, atol=1e-13)
        self.assertEqual(np.abs(plain["joint_force"].reshape(41, 5, 2)[:, 4]).max(), 0)
        sprung = FOUR_BAR.replace("EXTRA", "springs: {s: {joint: P.x, stiffness: 50}}\nfriction: {P.angle: {viscous: 0.2}}")
        held = self.simulated(self.write("g.yaml", sprung))
        np.testing.assert_allclose(held["joint_position"], plain["joint_position"], rtol=0, atol=1e-12)
        x, dx, w = held["joint_position"][:, 4], held["joint_velocity"][:, 4], held["joint_velocity"][:, 6]
        extra = (held["power"] - plain["power"])[:, 0]
        np.testing.assert_allclose(extra, 50 * x * dx + 0.2 * w * w, rtol=0, atol=1e-11 * np.abs(held["power"]).max())
        self.agree(sprung)

    def test_formulas(self):
        done = run("equations", self.write("body.yaml", BODY), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        formulas = {f["name"]: f["formula"] for s in json.loads(done.stdout)["sections"] for f in s["formulas"] if "name" in f}
        self.assertEqual(formulas["D11"], "m1")
        self.assertEqual(formulas["D22"], "m1")
        done = run("equations", self.write("f.yaml", FOUR_BAR.replace("EXTRA", "")), "--only", "inertia,closures,natural")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_conditions_of_the_floating_body(self):
        done = run("conditions", self.write("body.yaml", BODY), "--goal", "force", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["rank"], 3)  # a body that goes anywhere has a momentum unless it has no mass

    def test_pictures_and_reports(self):
        spec = self.write("body.yaml", BODY)
        file = self.path("run.h5")
        self.assertEqual(run("simulate", spec, "-o", file).returncode, 0)
        done = run("plot", file, "-o", self.path("p.svg"))
        self.assertEqual(done.returncode, 0, done.stderr)
        done = run("report", spec, "-o", self.path("r.html"))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_what_cannot_be_is_refused(self):
        self.refused(BODY.replace("axis: [0.6, 0.8]", "axis2: [0.6, 0.8]"), "no 'axis2': in the plane, 'axis' is the direction of x")
        self.refused(BODY.replace("axis: [0.6, 0.8]", "axis: [0, 0]"), "joints.P.axis")
        self.refused(BODY.replace("axis: [0.6, 0.8]", "rpy: [0, 0, 1]"), "joints.P.rpy")
        self.refused(BODY.replace("type: planar, connects", "type: plane, connects"), "its name here is 'planar'")
        self.refused(BODY.replace("actuators: [P.x,", "actuators: [P.z,"), "P.x")


if __name__ == "__main__":
    unittest.main()
