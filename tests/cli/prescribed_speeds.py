"""Constraints on speeds with a value: conveyors, driven tables and prescribed slip, held against closed forms and scipy."""

import json
import math
import os
import unittest

import h5py
import numpy as np

from _program import Case, run

# A box on a belt: its motor moves it across, the belt along.
BELT = """
space: planar
gravity: [0, 0]
parameters: {speed: 0.3, w: 5}
ground: {points: {O: [0, 0]}}
bodies:
  box: {mass: 4, com: [0.02, 0.01], inertia: 0.05, points: {C: [0, 0]}}
joints:
  P: {type: planar, connects: [ground.O, box.C]}
constraints:
  belt: {box.C.x: 1, value: VALUE}
actuators: [P.y, P.angle]
tool: box.C
assembly: {P.x: 0.5}
motion: {duration: 1, samples: 401, from: {joints: {P.y: 0, P.angle: 0}}, to: {joints: {P.y: 0.4, P.angle: 1}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""

# A bead on a table that is turned at a given rate; its guide passes the axis at the distance e.
TABLE = """
space: planar
gravity: [0, 0]
parameters: {e: 0.2}
ground: {points: {O: [0, 0]}}
bodies:
  table: {mass: 3, com: [0, 0], inertia: 0.4, points: {O: [0, 0], E: [0, e]}}
  bead: {mass: 1.5, com: [0, 0], inertia: 0.001, points: {C: [0, 0]}}
joints:
  T: {type: revolute, connects: [ground.O, table.O]}
  S: {type: prismatic, connects: [table.E, bead.C], axis: [1, 0]}
constraints:
  motor: {T: 1, value: "2 + 0.5*sin(3*t)"}
friction: {S: {viscous: 0.7}, T: {viscous: 0.1}}
actuators: [S]
tool: bead.C
assembly: {T: 0.3}
motion: {duration: 2, samples: 801, from: {joints: {S: 0.1}}, to: {joints: {S: 0.5}}}
trajectories: {go: {law: cycloidal, drive: joints}}
"""

# Chaplygin's sleigh whose blade slips sideways as told.
SLEIGH = """
space: planar
gravity: [0, 0]
ground: {points: {O: [0, 0]}}
bodies:
  sleigh: {mass: 2, com: [0.1, 0], inertia: 0.05, points: {blade: [0, 0], G: [0.1, 0]}}
joints:
  P: {type: planar, connects: [ground.O, sleigh.blade]}
constraints:
  blade: {sleigh.blade.v: 1, value: "0.2*sin(4*t)"}
actuators: [P.x, P.angle]
tool: sleigh.G
motion: {duration: 1.5, samples: 301, from: {joints: {P.x: 0, P.angle: 0.2}}, to: {joints: {P.x: 1, P.angle: 0.8}}}
trajectories: {go: {law: cycloidal, drive: joints}}
controllers: {free: {type: none}, push: {type: open-loop, torque: [0.5, 0.1]}}
"""


class Prescribed(Case):
    def results(self, command, spec, *call):
        file = self.path("run.h5")
        done = run(command, spec, "-o", file, "--force", *call)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file, "r") as results:
            found = {}
            results.visititems(lambda name, node: found.__setitem__(name.split("/")[-1], np.array(node))
                               if isinstance(node, h5py.Dataset) and node.dtype.kind == "f" else None)
        return found

    def refused(self, code, words, *call):
        done = run(*call)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stdout + done.stderr)
        self.assertIn(words, done.stderr)

    def power_balance(self, found, dissipated=0):
        """Energies change by what motors and constraints do, less what friction takes: by differences of sixth order."""
        energy = (found["kinetic_energy"] + found["potential_energy"]).ravel()
        h = found["time"][1] - found["time"][0]
        slope = (45 * (energy[4:-2] - energy[2:-4]) - 9 * (energy[5:-1] - energy[1:-5]) + energy[6:] - energy[:-6]) / (60 * h)
        power = found["power"].sum(1) + found["constraint_power"].sum(1) - dissipated
        self.assertGreater(np.abs(found["constraint_power"]).max(), 1e-3)
        np.testing.assert_allclose(slope, power[3:-3], rtol=0, atol=1e-7 * np.abs(power).max())

    def test_a_conveyor(self):
        for value, speed, rate in (("speed", lambda t: 0.3 + 0 * t, lambda t: 0 * t),
                                   ("-0.25", lambda t: -0.25 + 0 * t, lambda t: 0 * t),
                                   ('"speed*sin(w*t)"', lambda t: 0.3 * np.sin(5 * t), lambda t: 1.5 * np.cos(5 * t))):
            found = self.results("simulate", self.write("belt.yaml", BELT.replace("VALUE", value)))
            t, q = found["time"], found["joint_position"]
            np.testing.assert_allclose(found["joint_velocity"][:, 0], speed(t), rtol=0, atol=1e-13)
            np.testing.assert_allclose(found["joint_acceleration"][:, 0], rate(t), rtol=0, atol=1e-12)
            way = 0.5 + (0.06 * (1 - np.cos(5 * t)) if "sin" in value else speed(t) * t)
            np.testing.assert_allclose(q[:, 0], way, rtol=0, atol=1e-12)
            a, w = found["joint_acceleration"][:, 2], found["joint_velocity"][:, 2]
            r = np.stack([0.02 * np.cos(q[:, 2]) - 0.01 * np.sin(q[:, 2]), 0.02 * np.sin(q[:, 2]) + 0.01 * np.cos(q[:, 2])], 1)
            force = 4 * (rate(t) - a * r[:, 1] - w**2 * r[:, 0])
            np.testing.assert_allclose(found["constraint_force"][:, 0], force, rtol=0, atol=1e-11)
            np.testing.assert_allclose(found["constraint_power"][:, 0], force * speed(t), rtol=0, atol=1e-11)
            self.power_balance(found)

    def test_rates_do_not_jump_as_a_load_is_set_down(self):
        spec = self.write("sleigh.yaml", SLEIGH.replace("P.angle: 0.2", "P.angle: 1.3").replace(
            "constraints:", "payloads: {load: {body: sleigh, at: G, mass: 3, until: 0.7}}\nconstraints:"))
        found = self.results("control", spec, "-c", "push")
        t, q, velocity = found["time"], found["joint_position"], found["joint_velocity"]
        fastest = np.abs(found["joint_acceleration"]).max(0)
        self.assertLess((np.abs(np.diff(velocity, axis=0)) / (np.diff(t)[:, None] * fastest)).max(), 1.01)
        slip = velocity[:, 1] * np.cos(q[:, 2]) - velocity[:, 0] * np.sin(q[:, 2])
        np.testing.assert_allclose(slip, 0.2 * np.sin(4 * t), rtol=0, atol=1e-12)

    def test_a_bead_on_a_driven_table(self):
        """F = m (s'' - s W^2 - e W') + c s'; the motor's torque by the angular momentum."""
        found = self.results("simulate", self.write("table.yaml", TABLE))
        t, e, m = found["time"], 0.2, 1.5
        W, dW = 2 + 0.5 * np.sin(3 * t), 1.5 * np.cos(3 * t)
        s, ds, dds = (found[f"joint_{name}"][:, 1] for name in ("position", "velocity", "acceleration"))
        np.testing.assert_allclose(found["joint_velocity"][:, 0], W, rtol=0, atol=1e-12)
        np.testing.assert_allclose(found["torque"][:, 0], m * (dds - s * W**2 - e * dW) + 0.7 * ds, rtol=0, atol=1e-10)
        torque = (0.4 + 0.001 + m * (s**2 + e**2)) * dW + 2 * m * s * ds * W - m * e * dds + 0.1 * W
        np.testing.assert_allclose(found["constraint_force"][:, 0], torque, rtol=0, atol=1e-10)
        self.power_balance(found, 0.7 * ds**2 + 0.1 * W**2)

    def test_a_single_state_is_that_of_a_run(self):
        for text, joints in ((BELT.replace("VALUE", '"speed*sin(w*t)"'), ("P.y", "P.angle")), (TABLE, ("S",)),
                             (SLEIGH, ("P.x", "P.angle"))):
            spec = self.write("spec.yaml", text)
            found = self.results("simulate", spec, "--samples", "11")
            with h5py.File(self.path("run.h5")) as file:
                names = [name.decode() for name in file["coordinate"]]
            at = ",".join(f"{name}={q!r}" for name, q in zip(names, found["joint_position"][4].tolist()))
            rates, accelerations = (
                ",".join(f"{name}={found[f'joint_{what}'][4, names.index(name)].item()!r}" for name in joints)
                for what in ("velocity", "acceleration"))
            done = run("simulate", spec, "--at", at, "--rates", rates, "--accelerations", accelerations,
                       "--time", repr(found["time"][4].item()), "--json")
            self.assert_quiet_success(done)
            values = {one["quantity"]: one["value"] for one in json.loads(done.stdout)["values"]}
            for what in ("velocity", "acceleration"):
                np.testing.assert_allclose([values[f"joint_{what}[{name}]"] for name in names],
                                           found[f"joint_{what}"][4], rtol=0, atol=1e-10)
            np.testing.assert_allclose(values["shaking_force"], found["shaking_force"][4], rtol=0, atol=1e-9)

    def test_equation_at_a_pose(self):
        """M' = m, B' = c and z' = -m (s W^2 + e W') at the time given."""
        spec = self.write("table.yaml", TABLE)
        for time in (0, 0.4):
            done = run("equations", spec, "--at", "T=0.3,S=0.35", "--time", str(time), "--only",
                       "inertia,velocity,gravity,redundant", "--json")
            self.assert_quiet_success(done)
            told = json.loads(done.stdout)
            W, dW = 2 + 0.5 * math.sin(3 * time), 1.5 * math.cos(3 * time)
            self.assertEqual(told["independent"], ["S"])
            np.testing.assert_allclose(told["M"], [[1.5]], atol=1e-13)
            np.testing.assert_allclose(told["D"], [[[0]]], atol=1e-13)
            np.testing.assert_allclose(told["B"], [[0.7]], atol=1e-13)
            np.testing.assert_allclose(told["z"]["sum"], [-1.5 * (0.35 * W**2 + 0.2 * dW)], atol=1e-12)
            np.testing.assert_allclose(told["z"]["prescribed"], told["z"]["sum"], atol=1e-13)
            np.testing.assert_allclose(told["redundant"]["rate_offset"], [W, 0], atol=1e-13)
            np.testing.assert_allclose(told["redundant"]["constraint_speeds"], [W], atol=1e-13)
        done = run("equations", spec, "--at", "T=0.3,S=0.35", "--only", "velocity,gravity")
        self.assert_quiet_success(done)
        self.assertIn("prescribed speeds", done.stdout)

    def test_in_speeds(self):
        """The bead's velocity v along the guide as seen from the world: v = s' - e W, so M v' has a part of its own."""
        spec = self.write("table.yaml", TABLE)
        W, dW, e, m, s = 2, 1.5, 0.2, 1.5, 0.35
        done = run("equations", spec, "--at", "T=0.3,S=0.35", "--only", "inertia,velocity,gravity", "--json", "--speeds", "v: bead.C.u")
        self.assert_quiet_success(done)
        told = json.loads(done.stdout)["in_speeds"]
        # F = m (v' - s W^2) + c (v + e W)
        np.testing.assert_allclose(told["M"], [[m]], atol=1e-13)
        np.testing.assert_allclose(told["B"], [[0.7]], atol=1e-13)
        np.testing.assert_allclose(told["z"]["sum"], [-m * s * W**2 + 0.7 * e * W], atol=1e-12)
        np.testing.assert_allclose(told["rate_offset"], [e * W], atol=1e-13)
        # the same of the mechanism without the constraint, by --constraints with a value
        free = self.write("free.yaml", TABLE.replace('constraints:\n  motor: {T: 1, value: "2 + 0.5*sin(3*t)"}\n', ""))
        done = run("equations", free, "--at", "T=0.3,S=0.35", "--independent", "T,S", "--only", "inertia,velocity,gravity", "--json",
                   "--speeds", "v: bead.C.u", "--constraints", 'motor: {T: 1, value: "2 + 0.5*sin(3*t)"}')
        self.assert_quiet_success(done)
        other = json.loads(done.stdout)["in_speeds"]
        np.testing.assert_allclose(other["M"], told["M"], atol=1e-13)
        np.testing.assert_allclose(other["B"], told["B"], atol=1e-13)
        np.testing.assert_allclose(other["z"]["sum"], told["z"]["sum"], atol=1e-12)
        # with v = 0, s' = e W and s'' = e W'; a turn of the table at this v also moves the bead along the guide
        held = 0.1 * W + (0.401 + m * (s * s + e * e)) * dW + 2 * m * s * W * e * W - m * e * e * dW + e * told["z"]["sum"][0]
        np.testing.assert_allclose(other["held"]["z"]["sum"], [held], atol=1e-11)

    def test_split_terms_add_up(self):
        found = self.results("simulate", self.write("table.yaml", TABLE), "--split")
        parts = sum(found[f"torque_{name}"] for name in ("inertia", "velocity", "friction", "weight", "spring", "load"))
        np.testing.assert_allclose(parts, found["torque"], rtol=0, atol=1e-11)

    def test_a_sleigh_that_slips_under_given_forces(self):
        """The free motion by scipy: with the blade's speeds u ahead, c(t) aside and the turning w."""
        from scipy.integrate import solve_ivp
        m, J, a = 2, 0.05, 0.1
        c, dc = (lambda t: 0.2 * math.sin(4 * t)), (lambda t: 0.8 * math.cos(4 * t))

        def slope(t, state):
            _, _, angle, u, w = state
            # ahead: m (u' - c w - a w^2) = F cos(angle); about the blade: (J + m a^2) w' + m a (c' + u w) = torque
            du = 0.5 * math.cos(angle) / m + c(t) * w + a * w * w
            dw = (0.1 - m * a * (dc(t) + u * w)) / (J + m * a * a)
            return [u * math.cos(angle) - c(t) * math.sin(angle), u * math.sin(angle) + c(t) * math.cos(angle), w, du, dw]
        found = self.results("control", self.write("sleigh.yaml", SLEIGH), "--controller", "push")
        end = solve_ivp(slope, (0, 1.5), [0, 0, 0.2, 0, 0], rtol=1e-11, atol=1e-13).y[:, -1]
        np.testing.assert_allclose(found["joint_position"][-1], end[:3], rtol=0, atol=1e-7)
        self.power_balance(found)

    def test_computed_torque_follows(self):
        found = self.results("control", self.write("sleigh.yaml", SLEIGH), "--controller", "computed-torque")
        self.assertLess(np.abs(found["tracking_error"][:, [0, 2]]).max(), 1e-3)

    def test_what_is_not_derived_is_refused(self):
        spec = self.write("table.yaml", TABLE)
        self.refused(4, "a constraint on speeds has a value", "conditions", spec, "--goal", "static")
        stuck = self.write("stuck.yaml", TABLE.replace("S: {viscous: 0.7}", "S: {viscous: 0.7, coulomb: 0.1}"))
        done = run("control", stuck, "--controller", "computed-torque")
        self.assertEqual(done.returncode, 3)
        self.assertIn("whose constraints prescribe speeds", done.stderr)
        fast = self.write("fast.yaml", TABLE.replace("{law: cycloidal, drive: joints}",
                                                     "{law: fastest, drive: joints, limits: {torque: 20}}"))
        done = run("simulate", fast)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("with a value", done.stderr)
        for bad, words in (('value: "2*x"', "there is no parameter or variable 'x'"), ("value: [1]", "an expression of the time t"),
                           ('value: "1/t"', "finite at t = 0"), ("value: 1, value2: 1", "value2")):
            self.refused(3, words, "check", self.write("bad.yaml", TABLE.replace('value: "2 + 0.5*sin(3*t)"', bad)))
        named = TABLE.replace("{e: 0.2}", "{e: 0.2, t: 1}")
        self.refused(3, "give the parameter another name", "check", self.write("t.yaml", named))
        self.refused(3, "no 'value'", "check", self.write("v.yaml", TABLE.replace("friction:", "speeds: {v: {S: 1, value: 2}}\nfriction:")))

    def test_parts_bring_their_values(self):
        """Names of a part's parameters change in its values, the time does not."""
        part = self.write("belt.yaml", BELT.replace("VALUE", '"speed*sin(w*t)"'))
        spec = self.write("two.yaml", f"""
space: planar
include: {{file: {part}, as: [S1, S2], set: {{speed: {{S1: 0.3, S2: -0.1}}}}}}
motion: {{duration: 1, samples: 41, from: {{joints: {{S1.P.y: 0, S1.P.angle: 0, S2.P.y: 0, S2.P.angle: 0}}}},
         to: {{joints: {{S1.P.y: 0.1, S1.P.angle: 0, S2.P.y: 0, S2.P.angle: 0.2}}}}}}
trajectories: {{go: {{law: cycloidal, drive: joints}}}}
""")
        found = self.results("simulate", spec)
        np.testing.assert_allclose(found["joint_velocity"][:, [0, 3]], np.outer(np.sin(5 * found["time"]), [0.3, -0.1]), rtol=0, atol=1e-12)

    def test_units(self):
        """In millimetres and milliseconds the belt is the same."""
        scaled = BELT.replace("space:", "units: {length: mm, time: ms}\nspace:").replace("speed: 0.3, w: 5", "speed: 0.3, w: 0.005")
        scaled = scaled.replace("[0.02, 0.01]", "[20, 10]").replace("inertia: 0.05", "inertia: 5.0e4").replace("P.x: 0.5", "P.x: 500")
        scaled = scaled.replace("duration: 1", "duration: 1000").replace("P.y: 0.4", "P.y: 400").replace("VALUE", '"speed*sin(w*t)"')
        found = self.results("simulate", self.write("mm.yaml", scaled))
        np.testing.assert_allclose(found["joint_velocity"][:, 0], 0.3 * np.sin(5 * found["time"]), rtol=0, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
