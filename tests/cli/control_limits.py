#!/usr/bin/env python3
"""balance control where it must stop, where it needs no desired motion, and with dry friction."""

import json
import unittest

import h5py
import numpy

from _program import Case, run

ARM = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 1, com: [0, -0.5], inertia: 0.0833, points: {A: [0, 0], B: [0, -1]}}
  lower: {mass: 1, com: [0, -0.5], inertia: 0.0833, points: {B: [0, 0], E: [0, -1]}}
joints:
  J1: {type: revolute, connects: [ground.O, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
ACTUATORS
tool: lower.E
motion: {duration: 1, samples: 101, from: {joints: {J1: -0.5, J2: -0.3}}, to: {joints: {J1: 0.8, J2: 1.1}}}
SPRINGS
trajectories: {c: {law: cycloidal, drive: joints}}
controllers:
  inf: {type: computed-torque, kp: 1e308, kd: 1e308}
  noise: {type: pd, measurement: {position_noise: 1e6}}
  free: {type: none}
  stated: {type: open-loop, torque: 0.5}
  pd: {type: pd}
  smc: {type: sliding-mode}
  esmc: {type: extended-sliding-mode}
  loop: {type: open-loop}
  ct: {type: computed-torque}
"""
STUCK = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {x: {mass: 1, com: [0, -1], inertia: 0.01, points: {P: [0, 0]}}}
joints: {X: {type: revolute, connects: [ground.O, x.P]}}
actuators: [X]
friction: {X: {coulomb: 4}}
tool: x.origin
motion: {duration: 10, samples: 1001, from: {joints: {X: 0.3}}, to: {joints: {X: 0.1}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""
GANTRY = """
space: planar
parameters: {c: "cos(0.7)", s: "sin(0.7)"}
ground: {points: {O: [0, 0]}}
bodies:
  x: {mass: 1, com: [0, 0], inertia: 0.01, points: {P: [0, 0]}}
  y: {mass: 1, com: [0, 0], inertia: 0.01, points: {P: [0, 0]}}
joints:
  X: {type: prismatic, connects: [ground.O, x.P], axis: [c, s]}
  Y: {type: prismatic, connects: [x.P, y.P], axis: ["-s", c]}
actuators: [X, Y]
friction: {X: {coulomb: 5}, Y: {coulomb: 5}}
tool: y.P
motion: {duration: 1, samples: 101, from: {tool: [0, 0]}, to: {tool: ["0.3*c", "0.3*s"]}}
trajectories: {go: {law: cycloidal, drive: tool}, five: {law: 3-4-5, drive: tool}, sine: {law: modified-sine, drive: tool}}
"""
# The tool's straight path leads through the stretched arm.
STRETCHED = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 1, com: [0.5, 0], inertia: 0.08, points: {A: [0, 0], B: [1, 0]}}
  lower: {mass: 1, com: [0.5, 0], inertia: 0.08, points: {B: [0, 0], E: [1, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
actuators: [J1, J2]
tool: lower.E
motion: {duration: 1, samples: 101, from: {tool: [0.8, 0.2]}, to: {tool: [TO]}}
trajectories: {out: {law: cycloidal, drive: tool}}
controllers: {free: {type: none}, stated: {type: open-loop, torque: [12, 4]}}
"""


def arm(actuators="actuators: [J1, J2]", springs=""):
    return ARM.replace("ACTUATORS", actuators).replace("SPRINGS", springs)


class Limits(Case):
    def control(self, spec, controller, *more):
        return run("control", spec, "-c", controller, *more)

    def test_without_actuators_controllers_end_as_simulate_does_and_what_is_let_go_moves(self):
        """C1."""
        spec = self.write("bare.yaml", arm(actuators=""))
        simulated = run("simulate", spec, "-t", "c")
        self.assertEqual(simulated.returncode, 4)
        self.assertIn("under-actuated: 0 actuators for 2 degrees of freedom", simulated.stderr)
        for controller in ("stated", "pd", "ct", "smc", "esmc", "loop", "computed-torque"):
            done = self.control(spec, controller, "-t", "c")
            self.assertEqual((controller, done.returncode, done.stderr), (controller, 4, simulated.stderr))
        for controller in ("free", "none"):
            self.assertEqual(self.control(spec, controller, "-t", "c").returncode, 0, controller)

    def test_without_actuators_no_command_crashes(self):
        """C1."""
        spec = self.write("bare.yaml", arm(actuators="").split("controllers:")[0])
        result = self.path("r.h5")
        for words in (["check", spec], ["check", spec, "--verify"], ["simulate", spec, "-o", result],
                      ["control", spec, "-o", result], ["design", spec, "--goal", "force"],
                      ["design", spec, "--goal", "static"], ["conditions", spec, "--goal", "static"],
                      ["conditions", spec, "--goal", "force"], ["plot", spec], ["report", spec]):
            done = run(*words)
            self.assertIn(done.returncode, (0, 1, 2, 3, 4), words)

    def test_numbers_that_overflow_are_called_so(self):
        """A7."""
        done = self.control(self.write("arm.yaml", arm()), "inf", "-t", "c")
        self.assert_failure(done, 4, "numbers overflow")
        self.assertNotIn("closures", done.stderr)

    def test_a_run_has_a_budget_of_steps(self):
        """A8."""
        stiff = self.write("stiff.yaml", arm(
            springs="springs: {s: {between: [ground.O, lower.E], stiffness: 1e14, free_length: 1}}"))
        self.assert_failure(self.control(stiff, "free", "-t", "c", "--steps", "20000"), 4, "20000 steps", "at t = ")
        plain = self.write("arm.yaml", arm())
        self.assert_failure(self.control(plain, "noise", "-t", "c", "--steps", "20000"), 4, "at t = ")
        self.assertEqual(self.control(plain, "free", "-t", "c", "--steps", "20000").returncode, 0)

    def test_a_duration_of_next_to_nothing_is_refused(self):
        """A8."""
        done = self.control(self.write("arm.yaml", arm().replace("duration: 1,", "duration: 5e-324,")), "pd", "-t", "c")
        self.assertIn(done.returncode, (2, 3, 4))

    def test_what_needs_no_desired_motion_runs_without_one(self):
        """A5."""
        for to in ("2.1, 0.1", "5, 5"):
            spec = self.write("stretched.yaml", STRETCHED.replace("TO", to))
            self.assertEqual(run("simulate", spec, "-t", "out").returncode, 4)
            for controller in ("free", "stated"):
                done = self.control(spec, controller, "-t", "out", "-o", self.path("r.h5"), "--force", "--json")
                self.assertEqual(done.returncode, 0, done.stderr)
                said = json.loads(done.stdout)
                self.assertIn("no errors are reported", " ".join(said["notes"]))
                names = " ".join(metric["quantity"] for metric in said["metrics"])
                self.assertNotIn("error", names)
                self.assertIn("torque_variation", names)
                self.assertEqual(run("compare", self.path("r.h5"), self.path("r.h5")).returncode, 0)
            self.assertEqual(self.control(spec, "pd", "-t", "out").returncode, 4)
            self.assertEqual(self.control(spec, "open-loop", "-t", "out").returncode, 4)

    def test_a_pendulum_held_by_dry_friction_does_not_creep(self):
        """A4."""
        spec, result = self.write("stick.yaml", STUCK), self.path("stick.h5")
        self.assertEqual(self.control(spec, "none", "-o", result).returncode, 0)
        with h5py.File(result) as file:
            place, rate = file["joint_position"][:], file["joint_velocity"][:]
            shaking = numpy.abs(file["shaking_force"][:]).max()
        self.assertTrue((place == 0.3).all())
        self.assertTrue((rate == 0).all())
        self.assertLess(shaking, 1e-12)

    def test_an_axis_at_rest_has_no_friction_in_inverse_dynamics(self):
        """A3."""
        spec, result = self.write("gantry.yaml", GANTRY), self.path("g.h5")
        for trajectory in ("go", "five", "sine"):
            for formulation in ("tree", "natural"):
                done = run("simulate", spec, "-t", trajectory, "--formulation", formulation, "-o", result, "--force")
                self.assertEqual(done.returncode, 0, done.stderr)
                with h5py.File(result) as file:
                    torque = file["torque"][:]
                self.assertLess(numpy.abs(torque[:, 1]).max(), 1e-9, (trajectory, formulation))
                self.assertGreater(numpy.abs(torque[:, 0]).max(), 5, (trajectory, formulation))
        self.assertEqual(run("check", spec, "--verify").returncode, 0)

    def test_static_friction_is_at_least_coulombs(self):
        """A4."""
        done = run("check", self.write("s.yaml", STUCK.replace("coulomb: 4", "coulomb: 4, static: 3")))
        self.assert_failure(done, 3, "friction.X.static", "at least as much as 'coulomb'")


if __name__ == "__main__":
    unittest.main()
