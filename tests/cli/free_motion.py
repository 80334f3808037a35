"""Partly driven mechanisms: numbers found by two other routes, closed forms, and what cannot be left free."""

import json
import math
import os
import re
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, config, run

FRAME, CART, ARM, SHAFT = (f"machines/{name}.yaml" for name in ("frame-on-mounts", "pendulum-cart", "space-arm", "torsion-shaft"))

# A rotor that is driven beside a block that is not.
BLOCK = """
space: {space}
gravity: {gravity}
bodies:
  rotor: {{mass: 1, com: {origin}, inertia: {inertia}, points: {{O: {origin}}}}}
  block: {{mass: 2, com: {origin}, inertia: {block_inertia}, points: {{O: {origin}}}}}
joints:
  R: {{type: revolute, connects: [ground.origin, rotor.O]}}
bushings:
  m: {{between: [ground.origin, block.O], stiffness: {stiffness}, damping: {damping}, angular: {{stiffness: {angular}, damping: 0.3}}}}
actuators: [R]
trajectories:
  swing: {{law: cycloidal, drive: joints, duration: 1, from: {{joints: {{R: 0}}}}, to: {{joints: {{R: 1}}}}, free: {free}, initial: {initial}}}
"""

# A five-bar of which one crank is driven and the other hangs on a spring: the loop has several assembly modes.
FIVE_BAR = """
space: planar
gravity: [0, -9.81]
ground: {points: {A: [0, 0], E: [0.3, 0]}}
bodies:
  a: {mass: 1, com: [0.05, 0], inertia: 0.001, points: {A: [0, 0], B: [0.1, 0]}}
  b: {mass: 1, com: [0.15, 0], inertia: 0.01, points: {B: [0, 0], C: [0.3, 0]}}
  c: {mass: 1, com: [0.15, 0], inertia: 0.01, points: {C: [0, 0], D: [0.3, 0]}}
  d: {mass: 1, com: [0.1, 0], inertia: 0.002, points: {D: [0, 0], E: [0.2, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
  C: {type: revolute, connects: [b.C, c.C]}
  D: {type: revolute, connects: [c.D, d.D]}
  E: {type: revolute, connects: [d.E, ground.E]}
springs: {e: {joint: E, stiffness: 20, damping: 0.2, rest: 0.5}}
actuators: [A]
assembly: {A: 0.3, B: 0.6, C: -1.6, E: 0.5}
trajectories:
  run: {drive: joints, speed: {A: 6}, from: {joints: {A: 0.3}}, free: [E], initial: steady}
  go:  {drive: joints, law: cubic, duration: 1, from: {joints: {A: 0.3}}, to: {joints: {A: 1.3}}, free: [E], initial: equilibrium}
"""

# A wheel inside a body that floats.
SATELLITE = """
space: spatial
bodies:
  bus:   {mass: 10, com: [0, 0, 0], inertia: [2, 3, 4], points: {O: [0, 0, 0]}}
  wheel: {mass: 1, com: [0, 0, 0], inertia: [0.05, 0.05, 0.1], points: {O: [0, 0, 0]}}
joints:
  F: {type: free, connects: [ground.origin, bus.O]}
  W: {type: revolute, connects: [bus.O, wheel.O], axis: [0, 0, 1]}
actuators: [W]
trajectories:
  spin: {law: cycloidal, drive: joints, duration: 1, from: {joints: {W: 0}}, to: {joints: {W: 20}}, free: [F.x, F.y, F.z, F.1, F.2, F.3], initial: {rates: {F.x: 0.5}}}
"""


def damped(time, start, mass, stiffness, damping):
    """An oscillator from rest."""
    decay = damping / (2 * mass)
    omega = math.sqrt(stiffness / mass - decay**2)
    return start * np.exp(-decay * time) * (np.cos(omega * time) + decay / omega * np.sin(omega * time))


class FreeMotion(Case):
    def result(self, spec, *arguments):
        """Time, positions by coordinate, and the file's other arrays by name."""
        output = self.path("result.h5")
        done = run("simulate", spec, *arguments, "-o", output, "--force")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with h5py.File(output) as file:
            arrays = {name: file[name][()] for name in file if isinstance(file[name], h5py.Dataset) and file[name].dtype.kind == "f"}
            names = [name.decode() for name in file["coordinate"][()]]
        return arrays["time"], dict(zip(names, arrays["joint_position"].T)), arrays

    def spec(self, name, *changes):
        return self.write("spec.yaml", config(name, *changes))

    def near(self, value, expected, tolerance=1e-9):
        self.assertAlmostEqual(value, expected, delta=tolerance * abs(expected))

    def test_a_pendulum_on_a_cart(self):
        time, q, arrays = self.result(os.path.join(CONFIGS, CART), "--trajectory", "move")
        for moment, angle in ((0.25, -0.0855298972296893), (0.5, -0.513589237949134), (1, 0.732083062955803)):
            self.near(q["P"][np.searchsorted(time, moment - 1e-9)], angle, 1e-11)
        self.near(arrays["torque"][-1, 0], -5.7398865734939, 1e-8)
        self.assertEqual(arrays["torque"].shape[1], 1)

    def test_an_arm_that_floats(self):
        time, q, arrays = self.result(os.path.join(CONFIGS, ARM))
        self.near(q["F.angle"][np.searchsorted(time, 1 - 1e-9)], -0.342940757860299588, 1e-12)
        self.near(q["F.angle"][-1], -0.664820415453640217, 1e-12)
        self.assertLess(np.abs(arrays["com_position"] - arrays["com_position"][0]).max(), 1e-13)
        self.assertEqual(np.abs(arrays["shaking_force"]).max(), 0)
        self.assertEqual(np.abs(arrays["shaking_moment"]).max(), 0)

    def test_an_elastic_shaft(self):
        time, q, _ = self.result(os.path.join(CONFIGS, SHAFT))
        self.near(q["R"][np.searchsorted(time, 0.2 - 1e-9)], -0.0472327230431915, 1e-10)
        self.near(q["R"][-1], -0.00112134613803864, 1e-9)

    def test_a_frame_starts_from_rest(self):
        _, q, _ = self.result(os.path.join(CONFIGS, FRAME), "--trajectory", "start")
        self.near(q["F.x"][-1], -4.271329575e-3)
        self.near(q["F.y"][-1], 4.78084392e-4)

    def orders(self, spec, *arguments):
        done = run("simulate", spec, "--orders", "8", "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return {(row["quantity"], row["component"], row["order"]): row for row in json.loads(done.stdout)["orders"]["rows"]}

    def test_a_frame_in_steady_motion(self):
        found = self.orders(os.path.join(CONFIGS, FRAME), "--trajectory", "run")
        for name, order, amplitude in (("F.x", 1, 6.390632837e-3), ("F.x", 2, 1.72037819e-4), ("F.y", 1, 3.834379702e-3)):
            self.near(found[(f"joint_position[{name}]", "", order)]["amplitude"], amplitude)
        _, q, _ = self.result(os.path.join(CONFIGS, FRAME), "--trajectory", "run", "--samples", "4097")
        self.near(np.abs(q["F.x"]).max(), 6.5533825e-3, 1e-7)
        self.assertLess(abs(q["F.x"][-1] - q["F.x"][0]), 1e-12)

    def test_a_frame_that_only_translates_is_linear_order_by_order(self):
        mass, stiffness, damping = 10.7, 3000, 50
        for speed, amplitude, transmitted in ((4, 0.2821012416e-3, 0.848182315), (16.7443672, 16.74436717e-3, 52.1525474),
                                              (20 * math.pi, 5.014092634e-3, 21.7807962)):
            moving = self.orders(self.spec(FRAME, (r'"10 \* pi"', repr(speed))), "--trajectory", "run")
            held = self.orders(self.spec(FRAME, (r'"10 \* pi"', repr(speed)), ("type: free", "type: fixed"), ("bushings:\n.*?\n", ""),
                                         (", free: .F.x, F.y., hold: .F.angle.", ""), (", initial: steady", "")), "--trajectory", "run")
            self.near(moving[("joint_position[F.x]", "", 1)]["amplitude"], amplitude, 2e-9)
            force = abs((stiffness + 1j * speed * damping) * amplitude)
            self.near(force, transmitted, 2e-9)
            for name, component in (("F.x", "x"), ("F.y", "y")):
                for order in (1, 2, 4):
                    row = held[("shaking_force", component, order)]
                    shaking = complex(row["cosine"], -row["sine"])
                    response = -shaking / (stiffness - (order * speed) ** 2 * mass + 1j * order * speed * damping)
                    if abs(shaking) < 1e-9:
                        continue
                    row = moving[(f"joint_position[{name}]", "", order)]
                    self.assertLess(abs(complex(row["cosine"], -row["sine"]) - response), 1e-9 * abs(response) + 1e-15)

    def test_a_balanced_machine_leaves_its_frame_at_rest(self):
        """Counterweights on rod and crank; of a frame that translates nothing remains, of one that turns the moment."""
        rod, crank = 0.2, 0.4
        balanced = ("bushings:", "counterweights:\n  rod: {body: rod, at: [-0.3, 0], mass: 0.2}\n"
                    f"  crank: {{body: crank, at: [-0.1, 0], mass: {(crank * 0.05 + (rod + 0.2 + 0.1) * 0.1) / 0.1}}}\nbushings:")
        _, q, _ = self.result(self.spec(FRAME, balanced), "--trajectory", "run")
        self.assertLess(max(np.abs(q["F.x"]).max(), np.abs(q["F.y"]).max()), 1e-15)
        _, q, _ = self.result(self.spec(FRAME, balanced, ("damping: .50, 50.", "damping: 50, angular: {stiffness: 100, damping: 1}"),
                                        ("free: .F.x, F.y., hold: .F.angle., initial", "free: [F.x, F.y, F.angle], initial")), "--trajectory", "run")
        self.assertGreater(np.abs(q["F.angle"]).max(), 1e-3)

    def test_the_formulations_agree(self):
        for name, trajectory in ((CART, "move"), (ARM, "reach"), (SHAFT, "turn"), (FRAME, "run")):
            results = [self.result(os.path.join(CONFIGS, name), "--trajectory", trajectory, *formulation)[2]
                       for formulation in ((), ("--formulation", "natural"))]
            for quantity in ("torque", "shaking_force", "joint_acceleration", "kinetic_energy"):
                first, second = (result[quantity] for result in results)
                self.assertLess(np.abs(first - second).max(), 1e-9 * max(1, np.abs(first).max()), (name, quantity))

    def test_loops_stay_in_their_assembly_mode(self):
        spec = self.write("spec.yaml", FIVE_BAR)
        for trajectory in ("run", "go"):
            results = [self.result(spec, "--trajectory", trajectory, *formulation)
                       for formulation in ((), ("--formulation", "natural"))]
            first, second = (arrays["torque"] for _, _, arrays in results)
            self.assertLess(np.abs(first - second).max(), 1e-9 * np.abs(first).max())
            _, q, arrays = results[0]
            if trajectory == "run":
                self.assertLess(abs(q["E"][-1] - q["E"][0]), 1e-9)
                self.assertLess(np.abs(arrays["torque"][-1] - arrays["torque"][0]).max(), 1e-7 * np.abs(first).max())
            else:
                self.assertLess(abs(arrays["joint_velocity"][0]).max(), 1e-9)

    def test_check_compares_the_formulations(self):
        for name in (CART, ARM, SHAFT, FRAME):
            done = run("check", "--verify", os.path.join(CONFIGS, name))
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_power_is_the_rate_of_energy(self):
        """Without dampers the motor's work is the change of energy."""
        for name, changes in ((CART, ()), (ARM, ()), (SHAFT, ((", damping: 0.02", ""),))):
            time, _, arrays = self.result(self.spec(name, *changes), "--samples", "20001")
            energy = arrays["kinetic_energy"] + arrays["potential_energy"]
            power = arrays["power"].sum(axis=1)
            work = np.concatenate(([0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))))
            self.assertLess(np.abs(energy - energy[0] - work).max(), 1e-7 * max(np.ptp(energy), np.abs(work).max()), name)

    def test_bushings_in_the_plane_and_in_space(self):
        plane = {"space": "planar", "gravity": "[0, -9.81]", "origin": "[0, 0]", "inertia": 0.1, "block_inertia": 0.4}
        spatial = {"space": "spatial", "gravity": "[0, -9.81, 0]", "origin": "[0, 0, 0]", "inertia": "[0.1, 0.1, 0.1]",
                   "block_inertia": "[0.4, 0.5, 0.6]"}
        cases = [(plane, "[200, 300]", 5, 80, {"m.x": (0.01, 2, 200, 5), "m.angle": (0.2, 0.4, 80, 0.3)}, ["m.x", "m.y", "m.angle"]),
                 (spatial, "[200, 300, 400]", "[5, 4, 3]", "[80, 90, 100]",
                  {"m.x": (0.01, 2, 200, 5), "m.z": (0.02, 2, 400, 3), "m.2": (0.1, 0.5, 90, 0.3)},
                  ["m.x", "m.y", "m.z", "m.1", "m.2", "m.3"])]
        for shape, stiffness, damping, angular, starts, free in cases:
            values = ", ".join(f"{name}: {start}" for name, (start, *_) in starts.items())
            text = BLOCK.format(**shape, stiffness=stiffness, damping=damping, angular=angular, free=f"[{', '.join(free)}]",
                                initial=f"{{joints: {{m.y: {-2 * 9.81 / 300}, {values}}}}}")
            time, q, _ = self.result(self.write("spec.yaml", text))
            for name, (start, mass, k, c) in starts.items():
                self.assertLess(np.abs(q[name] - damped(time, start, mass, k, c)).max(), 1e-10 * start, name)
            self.assertLess(np.abs(q["m.y"] + 2 * 9.81 / 300).max(), 1e-13)
            for start in ("equilibrium", "steady"):
                text = re.sub("initial: .*", f"initial: {start}" + "}", text)
                _, q, _ = self.result(self.write("spec.yaml", text))
                self.assertLess(np.abs(q["m.y"] + 2 * 9.81 / 300).max(), 1e-13, start)

    def test_a_wheel_turns_the_body_that_carries_it(self):
        time, q, arrays = self.result(self.write("spec.yaml", SATELLITE))
        self.assertLess(np.abs(q["F.3"] + 0.1 / 4.1 * q["W"]).max(), 1e-12)
        self.assertLess(np.abs(q["F.x"] - 0.5 * time).max(), 1e-13)
        # a body that tumbles keeps its momentum and, while the wheel rests relative to it, its energy
        tumbling = (SATELLITE.replace("rates: {F.x: 0.5}", "rates: {F.1: 1, F.2: -0.4, F.3: 0.7}")
                    .replace("to: {joints: {W: 20}}", "to: {joints: {W: 0}}"))
        time, q, arrays = self.result(self.write("spec.yaml", tumbling))
        self.assertEqual(np.abs(arrays["shaking_moment"]).max(), 0)
        energy = arrays["kinetic_energy"]
        self.assertLess(np.ptp(energy), 1e-12 * energy[0])
        self.assertGreater(np.ptp(q["F.1"]), 0.3)

    def test_orders_of_half_a_turn_and_steady_motion_of_several(self):
        """A pendulum on a cart that goes to and fro: the steady motion repeats, whatever the start of the search."""
        table = ", ".join(f"[{t}, {0.05 * (1 - math.cos(2 * math.pi * t)):.15g}]" for t in np.linspace(0, 1, 201))
        text = (config(CART).split("trajectories:")[0] + "friction: {P: {viscous: 0.05}}\ntrajectories:\n"
                f"  sway: {{drive: joints, path: {{table: [{table}], columns: [X]}}, free: [P], initial: steady}}\n")
        done = run("simulate", self.write("spec.yaml", text), "--json")
        if done.returncode == 0:
            _, q, _ = self.result(self.write("spec.yaml", text))
            self.assertLess(abs(q["P"][-1] - q["P"][0]), 1e-9)
        else:
            self.assertIn("no periodic motion found", done.stdout + done.stderr)

    def vibrations(self, spec):
        return {one["trajectory"]: one for one in json.loads(run("check", spec, "--json").stdout)["vibrations"]}

    def test_vibrations(self):
        frame = self.vibrations(os.path.join(CONFIGS, FRAME))["start"]
        mass, stiffness, damping = 10.7, 3000, 50
        self.assertEqual(len(frame["modes"]), 2)
        for mode in frame["modes"]:
            real, imaginary = mode["eigenvalue"]
            self.near(math.hypot(real, imaginary), math.sqrt(stiffness / mass), 1e-9)
            self.near(real, -damping / (2 * mass), 1e-9)
            self.near(mode["damping_ratio"], damping / (2 * math.sqrt(stiffness * mass)), 1e-9)
        # pendulum: m g l = (I + m l^2) omega^2; a start away from the equilibrium does not matter
        for one in self.vibrations(os.path.join(CONFIGS, CART)).values():
            self.assertLess(abs(one["equilibrium"]["P"]), 1e-10)
            self.near(one["modes"][0]["frequency"], math.sqrt(9.81 * 0.3 / (0.02 + 0.09)) / (2 * math.pi), 1e-9)
            self.assertLess(abs(one["modes"][0]["damping_ratio"]), 1e-8)
        upside_down = self.vibrations(self.spec(CART, ("joints: {P: 0.1}", "joints: {P: pi}")))["move"]
        self.assertEqual(sorted(mode["eigenvalue"][0] > 0 for mode in upside_down["modes"]), [False, True])
        # two rotors on a shaft, of which one is held by the motor
        shaft = self.vibrations(os.path.join(CONFIGS, SHAFT))["turn"]["modes"]
        self.near(math.hypot(*shaft[0]["eigenvalue"]), math.sqrt(25 / 0.01), 1e-9)
        # what floats moves as a rigid body
        self.assertEqual([mode["eigenvalue"] for mode in self.vibrations(os.path.join(CONFIGS, ARM))["reach"]["modes"]], [[0, 0]] * 6)
        text = run("check", os.path.join(CONFIGS, FRAME)).stdout
        self.assertIn("2.63888 Hz, damping ratio 0.1395", " ".join(text.split()))

    def test_the_range_of_a_free_coordinate_does_not_depend_on_the_samples(self):
        for samples in ("2", "1001"):
            done = run("simulate", os.path.join(CONFIGS, CART), "--trajectory", "move", "--samples", samples)
            self.assertIn("P from -0.5426", done.stdout + done.stderr)

    def test_the_actuator_of_a_free_coordinate_exerts_nothing(self):
        _, without, _ = self.result(os.path.join(CONFIGS, CART), "--trajectory", "move")
        _, q, arrays = self.result(self.spec(CART, (r"actuators: .X.", "actuators: [X, P]")), "--trajectory", "move")
        self.assertEqual(np.abs(q["P"] - without["P"]).max(), 0)
        self.assertEqual(arrays["torque"].shape[1], 1)

    def test_a_body_that_floats_is_at_rest_anywhere(self):
        spec = self.spec(ARM, ("free: .F.x, F.y, F.angle.", "free: [F.x, F.y, F.angle], initial: equilibrium"))
        done = run("simulate", spec, "--trajectory", "reach")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("is one of many, because nothing determines F.x, F.y, F.angle", " ".join(done.stderr.split()))

    def test_what_cannot_be_left_free(self):
        refused = [
            (FRAME, (("free: .F.x, F.y., hold: .F.angle., initial: steady", "free: [F.x], initial: steady"),), "run",
             "coordinates are neither driven, held nor free: F.y, F.angle"),
            (FRAME, (("free: .F.x, F.y., hold: .F.angle., initial", "free: [F.x, F.y, A], hold: [F.angle], initial"),), "run", "a joint of 'from'"),
            (FRAME, (("hold: .F.angle., initial: steady", "hold: [F.x], initial: steady"),), "run", "coordinates that are not free"),
            (FRAME, ((r"free: .F.x, F.y., hold: .F.angle., initial: steady", "hold: [F.angle]"),), "run", "'free', the coordinates"),
            (CART, (("trajectories:", "friction: {P: {coulomb: 0.1}}\ntrajectories:"),), "move", "dry friction of P"),
            (CART, (("initial: equilibrium", "initial: {start: equilibrium, rates: {P: 1}}"),), "hangs", "no 'rates' with an equilibrium"),
            (CART, (("initial: equilibrium", "initial: {rates: {X: 1}}"),), "hangs", "a free coordinate"),
            (CART, (("initial: equilibrium", "initial: resting"),), "hangs", "rest"),
            (ARM, (("free: .F.x, F.y, F.angle.", "free: [F.x, F.y, F.angle], initial: steady"),), "reach", "no periodic motion found"),
            (SHAFT, (("stiffness: 25", "stiffness: 25e9"),), "turn", "too fast for the length of the run"),
            (CART, (("trajectories:", "payloads: {load: {body: bob, at: [0, -0.3], mass: 1, from: 0.5}}\ntrajectories:"),), "move",
             "payloads are taken up or set down"),
        ]
        for name, changes, trajectory, message in refused:
            done = run("simulate", self.spec(name, *changes), "--trajectory", trajectory)
            self.assertNotEqual(done.returncode, 0, message)
            self.assertIn(message, " ".join((done.stdout + done.stderr).split()))
            self.assertNotIn("internal", done.stdout + done.stderr)
        done = run("control", os.path.join(CONFIGS, CART), "--trajectory", "move")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("leaves coordinates free", " ".join((done.stdout + done.stderr).split()))


if __name__ == "__main__":
    unittest.main()
