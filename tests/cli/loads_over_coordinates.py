"""Loads over a joint coordinate: virtual power, splines against scipy, springs that do the same, both formulations, flywheels."""

import csv
import json
import math
import os
import unittest

import h5py
import numpy as np
from scipy.interpolate import CubicSpline

from _program import CONFIGS, Case, config, run

PRESS = os.path.join(CONFIGS, "machines", "flywheel-press.yaml")
PUMP = os.path.join(CONFIGS, "machines", "pumping-unit.yaml")

CRANK = """
space: planar
ground: {points: {O: [0, 0]}}
bodies:
  crank: {mass: 1, com: [0, 0], inertia: 0.4, points: {O: [0, 0], P: [0.1, 0]}}
  rod: {mass: 1e-30, com: [0, 0], inertia: 0, points: {P: [0, 0], C: [0.3, 0]}}
  ram: {mass: 1e-30, com: [0, 0], inertia: 0, points: {C: [0, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, crank.O]}
  B: {type: revolute, connects: [crank.P, rod.P]}
  C: {type: revolute, connects: [rod.C, ram.C]}
  S: {type: prismatic, connects: [ground.O, ram.C]}
actuators: [A]
assembly: {A: 0, B: 0, C: 0, S: 0.4}
loads: {work: {body: ram, %s}}
trajectories:
  run: {drive: joints, speed: {A: 2}, turns: %d, samples: %d, from: {joints: {A: 0}}}
"""

PENDULUM = """
space: planar
gravity: [0, -9.81]
bodies: {bob: {mass: 2, com: [0, -0.4], inertia: 0.05, points: {O: [0, 0]}}, cart: {mass: 1, com: [0, 0], inertia: 1}}
joints:
  J: {type: revolute, connects: [ground.origin, bob.O]}
  X: {type: prismatic, connects: [ground.origin, cart.origin]}
actuators: %s
%s
trajectories:
  swing: {law: cycloidal, drive: joints, duration: 1, from: {joints: {%sX: 0}}, to: {joints: {%sX: 0.1}}%s}
"""


class LoadsOverCoordinates(Case):
    def result(self, spec, *arguments):
        path = os.path.join(self.folder, "run.h5")
        done = run("simulate", spec, "-o", path, "--force", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(path) as file:
            return {name: file[name][()] for name in ("time", "torque", "joint_position", "joint_velocity", "shaking_force")}

    def crank(self, load, turns=1, samples=97):
        return self.result(self.write("crank.yaml", CRANK % (load, turns, samples)))

    def test_virtual_power_of_a_closed_spline(self):
        angles, forces = [0, 0.8, 2, 3.5, 5], [10, -4, 30, 12, 7]
        rows = ", ".join(f"[{a}, {f}, 0]" for a, f in zip(angles, forces))
        run_ = self.crank(f"over: A, period: turn, interpolation: spline, table: [{rows}]", turns=2)
        spline = CubicSpline(angles + [2 * math.pi], forces + forces[:1], bc_type="periodic")
        force = spline(np.mod(run_["joint_position"][:, 0], 2 * math.pi))
        self.check(run_, force)

    def test_virtual_power_over_the_stroke(self):
        # end values are held outside the rows
        run_ = self.crank("over: S, table: [[0.25, 5, 0], [0.3, -20, 0], [0.36, 8, 0]]")
        self.check(run_, np.interp(run_["joint_position"][:, 3], [0.25, 0.3, 0.36], [5, -20, 8]))

    def test_a_cycle_of_two_turns_and_a_file(self):
        with open(os.path.join(self.folder, "gas.csv"), "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["fx", "A"])
            writer.writerows([[3, 0], [90, 1], [5, 6], [-2, 9]])
        run_ = self.crank('over: A, period: "4 * pi", file: gas.csv', turns=2)
        self.check(run_, np.interp(run_["joint_position"][:, 0], [0, 1, 6, 9, 4 * math.pi], [3, 90, 5, -2, 3]))

    def check(self, run_, force):
        """No mass moves: the torque's power is that which the ram takes."""
        expected = -force * run_["joint_velocity"][:, 3] / run_["joint_velocity"][:, 0]
        np.testing.assert_allclose(run_["torque"][:, 0], expected, atol=1e-12 * np.max(np.abs(expected)), rtol=0)

    def test_a_load_that_a_spring_could_exert(self):
        # the table is the line 3 - 5 q: the spring's stiffness is 5, its preload 3
        load = "loads: {w: {body: bob, over: J, table: {J: [-20, 20], moment: [103, -97]}}}"
        spring = "springs: {w: {joint: J, stiffness: 5, preload: 3}}"
        driven, free = ("[J, X]", "J: -0.5, ", "J: 2, ", ""), ("[X]", "", "", ", free: [J], initial: {joints: {J: 1}}")
        for actuators, start, end, more in (driven, free):
            by_load, by_spring = (self.result(self.write("p.yaml", PENDULUM % (actuators, text, start, end, more))) for text in (load, spring))
            # round-off of values of the order of one
            np.testing.assert_allclose(by_load["joint_position"], by_spring["joint_position"], atol=1e-12)
            np.testing.assert_allclose(by_load["shaking_force"], by_spring["shaking_force"], atol=1e-10)
            np.testing.assert_allclose(by_load["torque"], by_spring["torque"], atol=1e-10)

    def test_conditions_and_designs_know_it(self):
        load = "loads: {w: {body: bob, over: J, table: {J: [-20, 20], moment: [-100, 100]}}}"
        free = "springs: {s: {joint: J, stiffness: {free: [0, 50]}}}\ncounterweights: {c: {body: bob, at: [0, 0.5], mass: {free: [0, 5]}}}"
        spec = self.write("p.yaml", PENDULUM % ("[J, X]", load + "\n" + free + "\ndesign: {goal: static, minimize: added-mass}", "J: 0, ", "J: 1, ", ""))
        done = run("design", spec, "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        values = {row["path"]: row["value"] for row in json.loads(done.stdout)["free_numbers"]}
        self.assertAlmostEqual(values["springs.s.stiffness"], 5, delta=1e-9)
        self.assertAlmostEqual(values["counterweights.c.mass"], 1.6, delta=1e-9)
        done = run("conditions", self.write("q.yaml", PENDULUM % ("[J, X]", load, "J: 0, ", "J: 1, ", "")), "--goal", "static")
        self.assertEqual(done.returncode, 1)
        self.assertIn("load w (m(J) up to 100 N m)", " ".join(done.stdout.split()))

    def test_both_formulations(self):
        for spec in (PRESS, PUMP):
            done = run("check", spec, "--verify")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_flywheel(self):
        # without masses that accelerate, J = (largest - smallest energy)/(C omega^2), exactly
        spec = self.write("crank.yaml", CRANK % ("over: A, period: turn, table: [[0, 0, 0], [2, 0, 0], [2.5, 90, 0], [3, 0, 0]]", 1, 4001))
        done = run("simulate", spec, "--orders", "2", "--fluctuation", "0.02", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)["orders"]["fluctuation"]
        samples = self.result(spec)
        torque, angle = samples["torque"][:, 0], samples["joint_position"][:, 0]
        surplus = torque - np.trapezoid(torque, angle) / (2 * math.pi) if hasattr(np, "trapezoid") else torque - np.trapz(torque, angle) / (2 * math.pi)
        energy = np.concatenate([[0], np.cumsum((surplus[1:] + surplus[:-1]) / 2 * np.diff(angle))])
        needed = (energy.max() - energy.min()) / (0.02 * 4)
        self.assertAlmostEqual(told["flywheel"] + 0.4, needed, delta=1e-4 * needed)  # the trapezoids' error

    def test_a_press_that_would_come_to_rest(self):
        done = run("simulate", PRESS, "--orders", "4", "--fluctuation", "0.1", "--json")
        told = json.loads(done.stdout)["orders"]["fluctuation"]
        self.assertEqual([told[name] for name in ("coefficient", "largest", "smallest")], [None] * 3)
        self.assertIn("comes to rest without a flywheel", " ".join(run("simulate", PRESS, "--orders", "4", "--fluctuation", "0.1").stdout.split()))
        heavy = self.write("heavy.yaml", config("machines/flywheel-press.yaml", ("inertia: 8,", f"inertia: {8 + told['flywheel']!r},")))
        told = json.loads(run("simulate", heavy, "--orders", "4", "--json").stdout)["orders"]["fluctuation"]
        self.assertAlmostEqual(told["coefficient"], 0.1, delta=1e-9)

    def test_torque_factors_are_torques_of_a_unit_load(self):
        # API Spec 11E: torque factor = travel of the rod per angle of the crank
        unit = self.result(PUMP, "--set", "up=1", "--set", "down=1", "--set", "g=0", "--set", "balance=0", "--trajectory", "run")
        light = self.result(PUMP, "--set", "up=0", "--set", "down=0", "--set", "g=0", "--set", "balance=0", "--trajectory", "run")
        factor = (unit["torque"] - light["torque"])[:, 0]
        travel = 3 * unit["joint_velocity"][:, 3] / unit["joint_velocity"][:, 0]
        np.testing.assert_allclose(factor, travel, atol=1e-9 * np.max(np.abs(light["torque"])))

    def test_the_counterbalance(self):
        # the torque is affine in the counterweight's mass: the least peak by a scan of its envelope
        done = run("design", PUMP, "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        answer = json.loads(done.stdout)
        none, one = (self.result(PUMP, "--set", f"balance={m}", "--trajectory", "run")["torque"][:, 0] for m in (0, 1000))
        masses = np.linspace(0, 12000, 240001)
        peaks = np.array([np.max(np.abs(none + m / 1000 * (one - none))) for m in masses[::40]])
        self.assertLessEqual(answer["objective"]["value"], peaks.min() * (1 + 1e-3))


class Expressions(Case):
    """Loads as expressions of a coordinate: a wheel whose motor gives what the load takes."""

    WHEEL = """
space: planar
units: {angle: ANGLE}
parameters: {a: 5}
bodies:
  w: {mass: 1, com: [0, 0], inertia: 0.1, points: {O: [0, 0]}}
joints:
  A: {type: revolute, connects: [ground.origin, w.O]}
actuators: [A]
loads:
  uneven: {body: w, LOAD}
trajectories:
  run: {drive: joints, speed: {A: SPEED}, samples: 361, from: {joints: {A: 0}}}
"""

    def wheel(self, load, angle="rad", speed="3"):
        return self.write("wheel.yaml", self.WHEEL.replace("LOAD", load).replace("ANGLE", angle).replace("SPEED", speed))

    def torque(self, *arguments):
        done = run("simulate", self.wheel(*arguments), "-o", self.path("wheel.h5"), "--force")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with h5py.File(self.path("wheel.h5")) as file:
            return file["torque"][:, 0], file["joint_position"][:, 0]

    def test_the_motor_gives_what_the_expression_takes(self):
        torque, angle = self.torque('over: A, period: turn, moment: "a * sin(2 * A) - cos(A) + 3"')
        self.assertLess(np.abs(torque + 5 * np.sin(2 * angle) - np.cos(angle) + 3).max(), 1e-8 * 9)
        torque, angle = self.torque('over: A, period: turn, moment: "a * sin(2 * A * pi / 180)"', "deg", "90")
        self.assertLess(np.abs(torque + 5 * np.sin(2 * angle)).max(), 1e-8 * 5)

    def test_what_is_no_smooth_function_that_repeats(self):
        for load, message in (('over: A, moment: "sin(A)"', "loads.uneven.over: expected 'period'"),
                              ('over: A, period: turn, moment: "abs(sin(A))"', "loads.uneven.moment: expected a smooth expression"),
                              ('over: A, period: turn, moment: A', "loads.uneven.moment: expected a smooth expression"),
                              ('over: A, period: turn, moment: "sin(B)"', "loads.uneven.moment: expected a number or an expression, found 'sin(B)'"),
                              ('over: A, period: turn, moment: "1 / sin(A)"', "loads.uneven.moment: expected a finite value everywhere, found none at A = 0"),
                              ('over: A, period: turn, interpolation: linear, moment: "sin(A)"', "loads.uneven.interpolation: expected no"),
                              ('over: A, period: turn, force: ["sin(A)"]', "loads.uneven.force")):
            done = run("check", self.wheel(load))
            self.assertEqual(done.returncode, 3, load)
            self.assertIn(message, " ".join(done.stderr.split()))


if __name__ == "__main__":
    unittest.main()
