"""Vibration modes, response to orders and sweeps: published numbers, closed forms, other routes, and what has no modes."""

import json
import math
import os
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, config, run

BICYCLE = os.path.join(CONFIGS, "bicycle.yaml")
MACHINES = os.path.join(CONFIGS, "machines")
FRAME = os.path.join(MACHINES, "frame-on-mounts.yaml")

# Meijaard, Papadopoulos, Ruina and Schwab (2007), eq. 5.3: M q'' + v C q' + (g K0 + v^2 K2) q = 0 of lean and steer.
BICYCLE_MASS = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
BICYCLE_DAMPING = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
BICYCLE_WEIGHT = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
BICYCLE_SPEED = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])

# Two masses between walls: three springs.
CHAIN = """
space: planar
bodies:
  a: {{mass: {m}, com: [0, 0], inertia: 1, points: {{P: [0, 0]}}}}
  b: {{mass: {m}, com: [0, 0], inertia: 1, points: {{P: [0, 0]}}}}
joints:
  X: {{type: prismatic, connects: [ground.origin, a.P]}}
  Y: {{type: prismatic, connects: [a.P, b.P]}}
springs:
{springs}
"""

# A rotor on a weightless elastic shaft in its middle (Laval, Jeffcott): bearings are springs across the shaft; the disc tilts, too.
ROTOR = """
space: spatial
bodies:
  carrier: {{mass: 1e-9, com: [0, 0, 0], inertia: [1e-12, 1e-12, 1e-12], points: {{O: [0, 0, 0]}}}}
  disc: {{mass: 5, com: [0, 0, 0], inertia: [{across}, {across}, {along}], points: {{O: [0, 0, 0]}}}}
joints:
  U: {{type: universal, connects: [ground.origin, carrier.O], axis: [1, 0, 0], axis2: [0, 1, 0]}}
  R: {{type: revolute, connects: [carrier.O, disc.O], axis: [0, 0, 1]}}
springs:
  one: {{joint: U.1, stiffness: {stiffness}, rest: 0}}
  two: {{joint: U.2, stiffness: {stiffness}, rest: 0}}
actuators: [R]
trajectories:
  spin: {{drive: joints, speed: {{R: {speed}}}, from: {{joints: {{R: 0}}}}, free: [U.1, U.2]}}
"""

# An eccentric rotor in a frame that slides on a spring without damping: 10.4 kg at 1040 N/m, in resonance at 10 rad/s.
SLIDER = """
space: planar
bodies:
  f: {{mass: 10, com: [0, 0], inertia: 0.3, points: {{O: [0, 0]}}}}
  w: {{mass: 0.4, com: [0.05, 0], inertia: 0.001, points: {{A: [0, 0]}}}}
joints:
  X: {{type: prismatic, connects: [ground.origin, f.O], axis: [1, 0]}}
  A: {{type: revolute, connects: [f.O, w.A]}}
springs: {{s: {{joint: X, stiffness: {stiffness}, rest: 0}}}}
actuators: [A]
trajectories:
  run: {{drive: joints, speed: {{A: {speed}}}, from: {{joints: {{A: 0}}}}, free: [X], initial: steady}}
"""


def bicycle_eigenvalues(v):
    rates = np.zeros((4, 4))
    rates[:2, 2:] = np.eye(2)
    rates[2:, :2] = -np.linalg.solve(BICYCLE_MASS, 9.81 * BICYCLE_WEIGHT + v * v * BICYCLE_SPEED)
    rates[2:, 2:] = -np.linalg.solve(BICYCLE_MASS, v * BICYCLE_DAMPING)
    return np.sort_complex(np.linalg.eigvals(rates))


class Modes(Case):
    def ask(self, spec, *arguments):
        done = run("modes", spec, "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def eigenvalues(self, spec, *arguments):
        return np.array([complex(*one) for one in self.ask(spec, *arguments)["eigenvalues"]])

    def frequencies(self, text, *arguments):
        """Angular ones of all oscillations."""
        found = self.ask(self.write("spec.yaml", text), *arguments)["modes"]
        return sorted(mode["eigenvalue"][1] for mode in found if mode["eigenvalue"][1] > 0)

    def near(self, found, expected, tolerance):
        self.assertLess(np.abs(np.asarray(found) - np.asarray(expected)).max(), tolerance)

    # Published.

    def test_the_benchmark_bicycle_has_its_published_eigenvalues(self):
        # the coefficients have 15 digits; derivatives are differences good to 1e-12 of the largest eigenvalue
        for v in (1, 3.7, 5, 8, 10):
            found = self.eigenvalues(BICYCLE, "--set", f"v={v}")
            moving = np.sort_complex(found[np.abs(found) > 1e-9])
            self.near(moving, bicycle_eigenvalues(v), 1e-10 * np.abs(moving).max())
        # table 2 at 5 m/s
        found = self.eigenvalues(BICYCLE)
        for value in (-0.322866429004087, complex(-0.775341882195845, 4.46486771378823), -14.0783896927982):
            self.assertLess(np.abs(found - value).min(), 1e-10)

    def test_the_bicycle_is_stable_between_weave_and_capsize_speed(self):
        found = self.ask(BICYCLE, "--sweep", "v=3:7:9")["sweep"]["stability_changes"]
        self.assertEqual([(one["kind"], one["above"]) for one in found],
                         [("oscillation", "decays above"), ("divergence", "grows above")])
        self.near([one["value"] for one in found], [4.29238253634111, 6.02426201538837], 1e-9)

    # Closed forms.

    def test_two_masses_in_a_chain(self):
        m, k = 2.5, 900
        spring = "  {0}: {{joint: {1}, stiffness: {2}, rest: 0}}\n"
        fixed = CHAIN.format(m=m, springs=spring.format("s", "X", k) + spring.format("t", "Y", k))
        # fixed to one wall: k/m (3 ∓ √5)/2
        expected = [math.sqrt(k / m * (3 - math.sqrt(5)) / 2), math.sqrt(k / m * (3 + math.sqrt(5)) / 2)]
        self.near(self.frequencies(fixed), expected, 1e-11 * expected[1])
        # floating: a rigid motion, whose eigenvalue is exactly zero twice, and 2 k/m
        floating = self.ask(self.write("spec.yaml", CHAIN.format(m=m, springs=spring.format("t", "Y", k))))
        self.assertEqual([mode["eigenvalue"] for mode in floating["modes"]][:2], [[0, 0], [0, 0]])
        self.near(floating["modes"][2]["eigenvalue"], [0, math.sqrt(2 * k / m)], 1e-11 * math.sqrt(k / m))
        shape = floating["modes"][2]["shape"]
        self.near([shape["X"][0] / shape["Y"][0], shape["X"][1]], [-0.5, 0], 1e-9)
        self.assertEqual(floating["stability"], "marginal")

    def test_damping_below_and_above_the_critical(self):
        for damping in (0.5, 4, 40, 400):
            springs = f"  s: {{joint: X, stiffness: 100, damping: {damping}, rest: 0}}\n  t: {{joint: Y, stiffness: 1e5, rest: 0}}\n"
            found = self.eigenvalues(self.write("spec.yaml", CHAIN.format(m=1, springs=springs)))
            matrix = np.zeros((4, 4))
            matrix[:2, 2:] = np.eye(2)  # of the places of both masses in the world
            matrix[2:] = [[-100 - 1e5, 1e5, -damping, 0], [1e5, -1e5, 0, 0]]
            self.near(np.sort_complex(found), np.sort_complex(np.linalg.eigvals(matrix)), 1e-9 * math.sqrt(2e5))

    def test_a_double_pendulum(self):
        text = config("double-pendulum.yaml")
        found = self.ask(self.write("spec.yaml", text))
        self.assertEqual(found["stability"], "marginal")
        # the equation of motion at the equilibrium, by another command, and its derivative by differences
        self.assertEqual(len([mode for mode in found["modes"] if mode["frequency"] > 0]), 2)

    def test_a_pendulum_that_stands_is_unstable(self):
        spec = self.write("spec.yaml", config("machines/pendulum-cart.yaml", ("joints: {P: 0.1}", "joints: {P: pi}")))
        found = self.ask(spec, "--trajectory", "move")
        rate = math.sqrt(9.81 * 0.3 / (0.02 + 0.09))
        self.assertEqual(found["stability"], "unstable")
        self.near(self.eigenvalues(spec, "--trajectory", "move"), [rate, -rate], 1e-10 * rate)

    def test_an_elastic_shaft_with_both_ends_free(self):
        # two rotors: k (1/I1 + 1/I2), of which the damper is proportional to the spring
        text = config("machines/torsion-shaft.yaml", ("actuators: .M.", "actuators: []"), ("trajectories:.*", ""))
        found = self.ask(self.write("spec.yaml", text))
        stiffness, damping, inverse = 25, 0.02, 1 / 0.003 + 1 / 0.01
        roots = np.roots([1, damping * inverse, stiffness * inverse])
        self.near(np.sort_complex([complex(*one) for one in found["eigenvalues"] if np.hypot(*one) > 1e-9]),
                  np.sort_complex(roots), 1e-10 * abs(roots[0]))

    def test_a_spinning_disc_whirls_forward_and_backward(self):
        # A λ² ± i C Ω λ + k = 0
        across, along, stiffness = 0.02, 0.035, 50
        for speed in (5, 40, 300):
            spec = self.write("spec.yaml", ROTOR.format(across=across, along=along, stiffness=stiffness, speed=speed))
            found = sorted(mode["eigenvalue"][1] for mode in self.ask(spec)["modes"])
            gyro = along * speed
            expected = sorted(abs((sign * gyro + math.sqrt(gyro * gyro + 4 * across * stiffness)) / (2 * across))
                              for sign in (1, -1))
            self.near(found, expected, 1e-9 * expected[1])

    def test_a_governor_swings_about_its_relative_equilibrium(self):
        # an arm of length l hinged on the axis of a spindle: cos θ = g/(l Ω²), frequency Ω sin θ
        length, speed = 0.2, 10
        text = f"""
space: spatial
gravity: [0, 0, -9.81]
bodies:
  spindle: {{mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1], points: {{O: [0, 0, 0]}}}}
  arm: {{mass: 1.5, com: [0, 0, {-length}], inertia: [0, 0, 0], points: {{O: [0, 0, 0]}}}}
joints:
  S: {{type: revolute, connects: [ground.origin, spindle.O], axis: [0, 0, 1]}}
  H: {{type: revolute, connects: [spindle.O, arm.O], axis: [0, 1, 0]}}
actuators: [S]
trajectories:
  spin: {{drive: joints, speed: {{S: {speed}}}, from: {{joints: {{S: 0}}}}, free: [H], initial: {{joints: {{H: 0.7}}}}}}
"""
        found = self.ask(self.write("spec.yaml", text))
        angle = math.acos(9.81 / (length * speed**2))
        self.assertEqual(found["reference"], "steady")
        self.near(abs(found["equilibrium"]["H"]), angle, 1e-11)
        self.near(found["modes"][0]["eigenvalue"], [0, speed * math.sin(angle)], 1e-9 * speed)
        self.assertLess(found["response"]["rows"][0]["linear"], 1e-15)

    # The response.

    def response(self, found):
        return {(row["quantity"], row["order"]): row for row in found["response"]["rows"]}

    def test_a_frame_that_translates_responds_linearly(self):
        # numbers of two other routes: (k - n² ω² M + i n ω c) x = -F, and integration; linear and exact agree to the latter's 1e-9
        for speed, amplitude, transmitted in ((4, 0.2821012416e-3, 0.848182315), (math.sqrt(3000 / 10.7), 16.74436717e-3, 52.1525474),
                                              (20 * math.pi, 5.014092634e-3, 21.7807962), (10 * math.pi, 6.390632837e-3, None)):
            spec = self.write("spec.yaml", config("machines/frame-on-mounts.yaml", (r'"10 \* pi"', repr(speed))))
            found = self.response(self.ask(spec, "--trajectory", "run"))
            row = found[("joint_position[F.x]", 1)]
            self.near([row["linear"] / amplitude, row["exact"] / amplitude], 1, 2e-9)
            if transmitted:
                linear = self.ask(spec, "--trajectory", "run")["response"]["linear"]
                force = {(one["quantity"], one["component"], one["order"]): one["amplitude"] for one in linear}
                self.near(force[("ground_force", "x", 1)] / transmitted, 1, 2e-9)
        self.near(found[("joint_position[F.x]", 2)]["linear"] / 1.72037819e-4, 1, 2e-9)
        self.near(found[("joint_position[F.y]", 1)]["linear"] / 3.834379702e-3, 1, 2e-9)

    def test_transmissibility_is_that_of_an_oscillator(self):
        mass, stiffness, damping, omega = 10.7, 3000, 50, 10 * math.pi
        for row in self.ask(FRAME, "--trajectory", "run")["response"]["transmission"]:
            if row["transmissibility"] is None:
                continue
            rate = row["order"] * omega
            expected = abs((stiffness + 1j * rate * damping) / (stiffness - rate**2 * mass + 1j * rate * damping))
            self.near(row["transmissibility"] / expected, 1, 1e-9)

    def test_a_frame_that_turns_is_linear_in_small_motions_alone(self):
        """The coefficients vary over a turn. What the linear figures leave out is of second order in the excitation."""
        relative = []
        for share in (1, 0.5):
            spec = self.write("spec.yaml", config(
                "machines/frame-on-mounts.yaml", ("damping: .50, 50.", "damping: [50, 50], angular: {stiffness: 100, damping: 3}"),
                ("free: .F.x, F.y., hold: .F.angle., initial", "free: [F.x, F.y, F.angle], initial"), ("mass: 0.4,", f"mass: {0.4 * share},"),
                ("mass: 0.2,", f"mass: {0.2 * share},"), ("mass: 0.1,", f"mass: {0.1 * share},"), (r'"0.4 \*', f'"{0.4 * share} *'),
                (r'"0.2 \*', f'"{0.2 * share} *'), ("inertia: 0.0001", f"inertia: {0.0001 * share}")))
            found = self.ask(spec, "--trajectory", "run")
            self.assertGreater(found["variation"], 1e-3)
            rows = self.response(found)
            if share == 1:
                # the equations of Lagrange, linearised and solved by harmonic balance in symbols and NumPy
                for name, order, amplitude in (("F.x", 1, 6.39058080e-3), ("F.y", 1, 3.81153441e-3), ("F.angle", 1, 3.34037684e-3),
                                               ("F.x", 2, 1.67320538e-4), ("F.y", 2, 8.17755271e-6), ("F.angle", 2, 3.11365396e-5)):
                    self.near(rows[(f"joint_position[{name}]", order)]["linear"] / amplitude, 1, 1e-7)
            # the exact motion is near; averages of the coefficients alone would have no order 2 of the angle
            for order, near in ((1, 1e-3), (2, 0.03)):
                for name in ("F.x", "F.y", "F.angle"):
                    row = rows[(f"joint_position[{name}]", order)]
                    self.assertLess(abs(row["linear"] - row["exact"]), near * row["exact"], (name, order))
            relative.append(abs(rows[("joint_position[F.angle]", 1)]["linear"] / rows[("joint_position[F.angle]", 1)]["exact"] - 1))
        self.assertGreater(relative[0], 2 * relative[1])

    # Sweeps.

    def test_a_sweep_finds_where_orders_meet_modes(self):
        path = self.path("sweep.h5")
        found = self.ask(FRAME, "--trajectory", "run", "--sweep", "A=2:70:18", "--exact", "3", "-o", path)["sweep"]
        mass, stiffness, damping = 10.7, 3000, 50
        frequency = math.sqrt(stiffness / mass - (damping / 2 / mass) ** 2)
        speeds = {one["order"]: one["value"] for one in found["critical_speeds"]}
        for order, speed in speeds.items():
            self.near(speed * order / frequency, 1, 1e-8)
        self.assertEqual(sorted(speeds), [1, 2, 3, 4])
        self.assertEqual(found["stability_changes"], [])
        self.assertEqual(sum(point["response"]["exact"] is not None for point in found["points"]), 3)
        with h5py.File(path) as file:
            sweep = file["sweep"]
            self.assertEqual(sweep["linear"].shape, (18, len(sweep["quantity"]), 4))
            quantity = [name.decode() for name in sweep["quantity"][()]].index("joint_position[F.x]")
            exact, linear = sweep["exact"][:, quantity, 0], sweep["linear"][:, quantity, 0]
            self.assertEqual(np.isfinite(exact).sum(), 3)
            self.assertLess(np.nanmax(np.abs(exact / linear - 1)), 1e-8)
            self.near(sweep["value"][()], np.linspace(2, 70, 18), 1e-12)
            self.assertEqual(file["modes"].attrs["stability"], "stable")

    def test_an_order_that_nothing_excites_has_no_resonance(self):
        # order 2 of 5 rad/s meets 10 rad/s, but a rotor excites order 1 alone: X1 = m e w^2 / (k - m w^2)
        spec = self.write("slider.yaml", SLIDER.format(stiffness=1040, speed=5))
        rows = json.loads(run("modes", spec, "--json").stdout)["response"]["linear"]
        peaks = {row["order"]: row["amplitude"] for row in rows if row["quantity"] == "joint_position[X]"}
        self.assertAlmostEqual(peaks[1], 0.4 * 0.05 * 25 / (1040 - 10.4 * 25), delta=1e-12)
        self.assertEqual([peaks[order] for order in (2, 3, 4)], [0, 0, 0])

    def test_a_resonance_without_damping_has_no_steady_motion(self):
        spec = self.write("slider.yaml", SLIDER.format(stiffness=1040, speed=10))
        text = " ".join(run("modes", spec).stdout.split())
        self.assertIn("an undamped vibration in resonance grows without bounds: order 1 of A excites it", text)
        done = run("simulate", spec)
        self.assertEqual(done.returncode, 4)
        self.assertIn("no periodic motion found", done.stderr)

    def test_what_nothing_pulls_back_is_a_rigid_motion(self):
        spec = self.write("slider.yaml", SLIDER.format(stiffness=0, speed=10))
        told = json.loads(run("modes", spec, "--json").stdout)
        self.assertEqual(told["stability"], "marginal")
        self.assertEqual([mode["frequency"] for mode in told["modes"]], [0] * len(told["modes"]))

    def test_round_off_is_no_response(self):
        # the rotor of no eccentricity moves nothing, and nothing is compared
        spec = self.write("slider.yaml", SLIDER.format(stiffness=1040, speed=7).replace("com: [0.05, 0]", "com: [0, 0]"))
        self.assertIn("nothing moves beyond round-off", run("modes", spec).stdout)

    def test_what_has_no_modes(self):
        cases = [(("--sweep", "A"), 2, "NAME=FROM:TO"), (("--sweep", "A=5:1"), 2, "FROM less than TO"),
                 (("--sweep", "A=1:5:1"), 2, "from 2 to"), (("--sweep", "A=1:5:"), 2, "NAME=FROM:TO"),
                 (("--sweep", "nothing=1:5"), 2, "nothing"), (("--sweep", "A=-1:5"), 2, "above zero"),
                 (("--trajectory", "none"), 2, "no trajectory 'none'")]
        for arguments, code, message in cases:
            arguments = arguments if "--trajectory" in arguments else ("--trajectory", "run", *arguments)
            done = run("modes", FRAME, *arguments)
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            self.assertIn(message, " ".join(done.stderr.split()))
        # an undamped machine in resonance
        spec = self.write("spec.yaml", config("machines/frame-on-mounts.yaml", ("damping: .50, 50.", "damping: [0, 0]"),
                                              (r'"10 \* pi"', repr(math.sqrt(3000 / 10.7)))))
        done = run("modes", spec, "--trajectory", "run")
        self.assertEqual(done.returncode, 0, done.stderr)
        # nothing holds a pendulum that a force accelerates without end
        text = config("machines/pendulum-cart.yaml", ("gravity: .0, -9.81.", "gravity: [9.81, 0]"), ("actuators: .X.", "actuators: []"),
                      ("trajectories:.*", ""))
        done = run("modes", self.write("spec.yaml", text))
        self.assertEqual(done.returncode, 4, done.stdout + done.stderr)
        self.assertIn("no equilibrium found", " ".join(done.stderr.split()))


if __name__ == "__main__":
    unittest.main()
