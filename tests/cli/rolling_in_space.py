"""Constraints on speeds: what rolls on a plane, blades and wheels that do not slip, held against closed forms."""

import json
import math
import os
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, config, run

CART = os.path.join(CONFIGS, "rolling-cart.yaml")
DISC = os.path.join(CONFIGS, "rolling-on-a-plane.yaml")
SLEIGH = os.path.join(CONFIGS, "sleigh.yaml")
BICYCLE = os.path.join(CONFIGS, "bicycle.yaml")
R, B, D, CART_MASS, WHEEL, SPIN, ACROSS, CART_INERTIA = 0.1, 0.2, 0.15, 8, 0.7, 0.0035, 0.002, 0.25

BALL = """
space: spatial
gravity: [3, -1, -9]
ground: {points: {O: [0, 0, 0]}}
bodies:
  ball: {mass: 2, com: [0, 0, 0], inertia: [0.0072, 0.0072, 0.0072], points: {C: [0, 0, 0]}}
joints:
  B: {type: rolling, shape: sphere, connects: [ground.O, ball.C], radius: 0.1}
actuators: [B.x, B.y]
motion: {duration: 2, samples: 101, from: {joints: {B.x: 0, B.y: 0}}, to: {joints: {B.x: 1, B.y: 2}}}
trajectories: {go: {law: cycloid, drive: joints}}
"""


# A plate, its lower side up, that rolls on a ball fixed to the ground: here the plane is what moves.
PLATE = """
space: spatial
gravity: [0, 0, -9.81]
ground: {points: {C: [0.1, 0.2, 0.5]}}
bodies:
  plate: {mass: 3, com: [0.05, 0.02, 0.1], inertia: [0.1, 0.12, 0.2], points: {P: [0.02, -0.03, 0]}}
joints:
  R: {type: rolling, shape: sphere, connects: [plate.P, ground.C], radius: 0.2, axis: [0, 0, -1], rpy: [0.2, -0.1, 0.4]}
actuators: [R.x, R.y, R.3]
motion: {duration: 1, samples: 2001, from: {joints: {R.x: 0, R.y: 0, R.3: 0}}, to: {joints: {R.x: 0.1, R.y: -0.2, R.3: 0.3}}}
trajectories: {go: {law: cycloid, drive: joints}}
"""


def cycloid(t):
    """Of a duration of one second: the part of the way with its first two derivatives."""
    return (t - np.sin(2 * np.pi * t) / (2 * np.pi), 1 - np.cos(2 * np.pi * t), 2 * np.pi * np.sin(2 * np.pi * t))


def integral(rate, times):
    """Of a function of the time from 0, by Gauss and Legendre's rule between any two times."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    steps = [(b - a) / 2 * np.dot(weights, rate((a + b) / 2 + (b - a) / 2 * nodes))
             for a, b in zip(times[:-1], times[1:])]
    return np.concatenate([[0], np.cumsum(steps)])


def turn(axis, angle):
    """Rotation matrices about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros(np.shape(angle) + (3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[..., axis, axis], R[..., i, i], R[..., j, j], R[..., j, i], R[..., i, j] = 1, c, c, s, -s
    return R


# A wheel whose drive becomes singular half way through its motion.
STUCK = """
space: spatial
gravity: [1.1, -3.6, -3.9]
ground: {points: {O: [0, 0, 0]}}
bodies:
  w:
    mass: 1.4
    com: [0.106, 0.015, 0.1]
    inertia: [0.034, 0.038, 0.037, 0.0078, -0.0059, 0.0058]
    points: {C: [0.145, 0.011, 0.175], K: [0.162, 0.207, -0.222]}
joints: {W: {type: rolling, connects: [ground.O, w.C], radius: 0.274}}
constraints: {k: {w.K.w: 1, w.rx: 0.194}}
assembly: {W.x: 0.103, W.y: 0.1, W.heading: -0.7, W.lean: 0.4026, W.angle: -0.596}
actuators: [W.lean, W.y]
motion: {duration: 0.92, samples: 301, from: {joints: {W.lean: 0.4026, W.y: 0.1}}, to: {joints: {W.lean: 0.48, W.y: -0.0616}}}
trajectories: {go: {law: cubic, drive: joints}}
"""


class RollingInSpace(Case):
    def moved(self, command, spec, *call):
        file = self.path("run.h5")
        done = run(command, spec, "-o", file, "--force", *call)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file, "r") as results:
            found = {}
            results.visititems(lambda name, item: found.update({name: item[()]})
                               if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" else None)
            names = [name.decode() for name in results["coordinate"][()]]
        found["q"] = {name: found["joint_position"][:, c] for c, name in enumerate(names)}
        found["dq"] = {name: found["joint_velocity"][:, c] for c, name in enumerate(names)}
        return found

    def near(self, found, expected, error):
        self.assertLess(np.max(np.abs(np.asarray(found) - expected)), error)

    def test_a_disc_goes_where_it_has_rolled(self):
        found = self.moved("simulate", DISC, "-t", "curve")
        t = found["time"]
        heading = lambda s: 2 * cycloid(s)[0]
        x = integral(lambda s: 0.3 * 8 * cycloid(s)[1] * np.cos(heading(s)), t)
        y = integral(lambda s: 0.3 * 8 * cycloid(s)[1] * np.sin(heading(s)), t)
        # a step is good to 1e-13 of the radius
        self.near(found["q"]["W.x"], x, 1e-12)
        self.near(found["q"]["W.y"], y, 1e-12)

    def disc(self, t):
        """Centre of mass, angular momentum about it, and how both speeds and angular velocity go with the three driven rates."""
        heading, lean, angle = 2 * cycloid(t)[0], 0.1 + 0.3 * cycloid(t)[0], 8 * cycloid(t)[0]
        rates = np.stack([2 * cycloid(t)[1], 0.3 * cycloid(t)[1], 8 * cycloid(t)[1]], -1)
        upright = turn(2, heading) @ turn(0, lean)
        R = upright @ turn(1, angle)
        e = np.eye(3)
        axes = np.stack([np.broadcast_to(e[2], upright.shape[:-1]), turn(2, heading)[..., 0], upright[..., 1]], -1)
        arm = 0.3 * upright[..., 2] + 0.02 * R[..., 0]  # from where it touches to the centre of mass
        omega = np.einsum("...ij,...j->...i", axes, rates)
        speed = np.cross(omega, arm)
        inertia = R @ np.diag([0.05, 0.09, 0.05]) @ np.swapaxes(R, -1, -2)
        momentum = np.einsum("...ij,...j->...i", inertia, omega)
        partial = np.stack([np.cross(axes[..., k], arm) for k in range(3)], -1)
        return speed, momentum, partial, axes

    def test_what_drives_a_disc_does_the_work_of_its_momenta(self):
        # Jourdain: Σ (m (a − g) · ∂v + L' · ∂ω) for every driven rate, momenta differentiated by fourth-order differences
        found = self.moved("simulate", DISC, "-t", "curve")
        t, h = found["time"], 2e-4
        slope = lambda k: sum(w * self.disc(t + n * h)[k] for n, w in ((-2, 1), (-1, -8), (1, 8), (2, -1))) / (12 * h)
        _, _, partial, axes = self.disc(t)
        force = 2 * (slope(0) + np.array([0, 0, 9.81]))
        torque = np.einsum("ti,tik->tk", force, partial) + np.einsum("ti,tik->tk", slope(1), axes)
        # what differences leave of 1e-4⁴ times sixth derivatives
        self.near(found["torque"], torque, 1e-7 * np.max(np.abs(torque)))
        self.near(found["joint_force"][:, 0], force, 1e-7 * np.max(np.abs(force)))

    def test_a_free_disc_keeps_its_energy_and_a_leaning_one_its_circle(self):
        # steady: lean λ, precession Ω, spin s relative to the frame that turns: moments about the point of contact
        lean, precession, m, r, a, c, g = -0.4, 1.2, 2, 0.3, 0.05, 0.09, 9.81
        # (c + m r²) Ω s cos λ + (c − a + m r²) Ω² sin λ cos λ + m g r sin λ = 0 for the spin s
        spin = -((c - a + m * r * r) * precession ** 2 * math.sin(lean) * math.cos(lean) + m * g * r * math.sin(lean)) \
            / ((c + m * r * r) * precession * math.cos(lean))
        spec = self.write("coin.yaml", config(
            "rolling-on-a-plane.yaml", (r"com: \[0.02, 0, 0\]", "com: [0, 0, 0]"), (r"motion:.*", f"""
motion:
  duration: 3
  samples: 301
  from: {{joints: {{W.heading: 0, W.lean: {lean}, W.angle: 0}}}}
  to: {{joints: {{W.heading: {3 * precession}, W.lean: {lean}, W.angle: {3 * spin}}}}}
trajectories: {{even: {{law: uniform, drive: joints}}}}
""")))
        driven = self.moved("simulate", spec, "-t", "even")
        self.near(driven["torque"], 0, 1e-9)  # round-off of moments of the order 10
        free = self.moved("control", spec, "-t", "even", "-c", "none")
        energy = free["kinetic_energy"] + free["potential_energy"]
        self.near(energy, energy[0], 1e-8 * abs(energy[0]))
        # the circle is stable here; integrated to 1e-9 a step
        self.near(free["q"]["W.lean"], lean, 1e-6)
        radius = r * spin / precession
        self.near(np.hypot(free["q"]["W.x"], free["q"]["W.y"] - radius), abs(radius), 1e-6)

    def test_a_ball_rolls_down_a_slope_through_any_number_of_turns(self):
        # homogeneous here: J = 0.36 m r², so that it goes by g/(1 + 0.36)
        found = self.moved("control", self.write("ball.yaml", BALL), "-t", "go", "-c", "none")
        t = found["time"]
        for name, g in (("B.x", 3), ("B.y", -1)):
            self.near(found["q"][name], g / 1.36 * t ** 2 / 2, 1e-7)
        self.near(found["joint_force"][:, 0], 2 * np.array([3 / 1.36 - 3, -1 / 1.36 + 1, 9]), 1e-7)

    def test_a_plate_rolls_on_a_ball_that_rests(self):
        found = self.moved("simulate", self.write("plate.yaml", PLATE), "-t", "go", "--poses")
        q = found["body_orientation"][:, 0]
        w, x, y, z = q.T
        axes = np.stack([np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
                         np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
                         np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)], 1)
        origin, h = found["body_position"][:, 0], found["time"][1]
        rate = lambda a: (8 * (a[3:-1] - a[1:-3]) - (a[4:] - a[:-4])) / (12 * h)
        normal = -axes[:, :, 2]
        contact = np.array([0.1, 0.2, 0.5]) - 0.2 * normal
        on_plate = contact - origin - axes @ [0.02, -0.03, 0]
        self.near(np.sum(on_plate * normal, -1), 0, 1e-14)
        # its point in touch stands still: fixed to the plate, at the place of every moment
        fixed = np.einsum("tji,tj->ti", axes, contact - origin)[2:-2]
        self.near(rate(origin) + np.einsum("tij,tj->ti", rate(axes), fixed), 0, 1e-10)

    def test_a_sleigh_left_alone_turns_as_chaplygin_found(self):
        # v' = a w², w' = −m a v w / (J + m a²): w = w₀ / cosh(k t) where it starts across, v₀ = 0
        spec = self.write("free.yaml", config(
            "sleigh.yaml", (r"motion:.*", """
motion: {duration: 2, samples: 201, from: {joints: {P.x: 0, P.angle: 0.0}}, to: {joints: {P.x: 0, P.angle: 6}}}
trajectories: {even: {law: uniform, drive: joints}}
""")))
        found = self.moved("control", spec, "-t", "even", "-c", "none")
        m, a, J, w0, t = 2, 0.1, 0.05, 3, found["time"]
        inertia = J + m * a * a
        k = a * w0 * math.sqrt(m / inertia)
        rate = w0 / np.cosh(k * t)
        self.near(found["dq"]["P.angle"], rate, 1e-7)
        speed = a * w0 / k * w0 * np.tanh(k * t)
        self.near(np.hypot(found["dq"]["P.x"], found["dq"]["P.y"]), speed, 1e-7)

    def test_the_blade_bears_what_the_pull_does_not(self):
        # m a of the centre of mass is the pull along x and the blade's force across its own axis
        found = self.moved("simulate", SLEIGH, "-t", "pull")
        heading = found["q"]["P.angle"]
        across = np.stack([-np.sin(heading), np.cos(heading)], -1)
        wanted = 2 * found["com_acceleration"] - np.stack([found["torque"][:, 0], 0 * heading], -1)
        force = found["constraint_force"][:, 0]
        self.near(force, np.sum(wanted * across, -1), 1e-12 * np.max(np.abs(force)))
        self.assertIn("constraint_force[blade]", run("simulate", SLEIGH, "-t", "pull").stdout)

    def test_parts_bring_their_constraints(self):
        spec = self.write("two.yaml", f"""
space: planar
include: {{file: {SLEIGH}, as: [S1, S2]}}
bodies: {{post: {{mass: 1, com: [0, 0], inertia: 1, points: {{P: [0, 0]}}}}}}
ground: {{points: {{P: [0, 5]}}}}
joints: {{T: {{type: revolute, connects: [ground.P, post.P]}}}}
constraints: {{together: {{T: 1, S1.P.angle: -0.5, S2.sleigh.angle: -0.5}}}}
""")
        told = json.loads(run("check", spec, "--json").stdout)
        self.assertEqual((told["configuration_freedoms"], told["degrees_of_freedom"]), (7, 4))

    def test_the_benchmark_bicycle_rides_as_published(self):
        # Meijaard, Papadopoulos, Ruina and Schwab (2007), eq. 5.3 and table 2: M q'' + v C q' + (g K0 + v^2 K2) q = 0 of lean and steer
        mass = [[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]]
        damping = [[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]]
        weight = [[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]]
        speed = [[0, 76.59734589573222], [0, 2.65431523794604]]
        v, start = 5, 1e-5
        rates = np.zeros((4, 4))
        rates[:2, 2:] = np.eye(2)
        rates[2:, :2] = -np.linalg.solve(mass, 9.81 * np.array(weight) + v * v * np.array(speed))
        rates[2:, 2:] = -np.linalg.solve(mass, v * np.array(damping))
        values, modes = np.linalg.eig(rates)
        self.near(np.sort_complex(values), np.sort_complex([-0.322866429004087, -0.775341882195845 - 4.46486771378823j,
                                                            -0.775341882195845 + 4.46486771378823j, -14.0783896927982]), 1e-11)
        found = self.moved("control", BICYCLE, "-t", "ride", "-c", "none", "--set", f"lean={start}")
        parts = np.linalg.solve(modes, np.array([start, 0, 0, 0], complex))
        linear = np.real(modes @ (parts[:, None] * np.exp(np.outer(values, found["time"]))))
        # what is left is the cube of the start, and the integration's 1e-11 of a radian
        self.near(found["q"]["L.lean"] / start, linear[0] / start, 1e-5)
        self.near(-found["q"]["S"] / start, linear[1] / start, 1e-5)  # to the left, about the axis that points up

    def test_a_cart_needs_the_torques_of_a_unicycle(self):
        found = self.moved("simulate", CART, "-t", "turn")
        dA, dB = found["dq"]["A"], found["dq"]["B"]
        scale = cycloid(found["time"])
        v, w = R * (dA + dB) / 2, R * (dB - dA) / (2 * B)
        dv, dw = R * 24 / 2 * scale[2], R * 4 / (2 * B) * scale[2]
        self.near(found["dq"]["P.angle"], w, 1e-11)
        force = (CART_MASS + 2 * WHEEL + 2 * SPIN / R ** 2) * dv - CART_MASS * D * w ** 2
        inertia = CART_INERTIA + CART_MASS * D * D + 2 * (ACROSS + WHEEL * B * B) + 2 * SPIN * B * B / R ** 2
        moment = inertia * dw + CART_MASS * D * v * w
        expected = np.stack([force * R / 2 - moment * R / (2 * B), force * R / 2 + moment * R / (2 * B)], -1)
        self.near(found["torque"], expected, 1e-10 * np.max(np.abs(expected)))
        heading = lambda s: R * 4 / (2 * B) * cycloid(s)[0]
        self.near(found["q"]["P.x"], integral(lambda s: R * 12 * cycloid(s)[1] * np.cos(heading(s)), found["time"]), 1e-11)
        # and the tool's path can be driven as well
        parked = self.moved("simulate", CART, "-t", "park")
        self.near(parked["tool_position"][-1], [0.9, 0.3, 0.1], 1e-12)
        across = parked["dq"]["P.y"] * np.cos(parked["q"]["P.angle"]) - parked["dq"]["P.x"] * np.sin(parked["q"]["P.angle"])
        self.near(across, 0, 1e-12)

    def test_a_cart_under_control_stays_with_its_motion(self):
        found = self.moved("control", CART, "-t", "turn", "-c", "computed-torque")
        self.near(found["tracking_error"][:, :2] if found["tracking_error"].ndim > 1 else found["tracking_error"], 0, 2e-3)
        wheel_slip = found["dq"]["L.x"] - R * found["dq"]["L.angle"] * np.cos(found["q"]["L.heading"])
        self.near(wheel_slip, 0, 1e-9)

    def test_freedoms_of_configuration_and_of_velocity_are_told_apart(self):
        for spec, places, rates in ((CART, 5, 2), (DISC, 5, 3), (SLEIGH, 3, 2), (self.write("b.yaml", BALL), 5, 3)):
            told = json.loads(run("check", spec, "--json").stdout)
            self.assertEqual((told["configuration_freedoms"], told["degrees_of_freedom"]), (places, rates), spec)

    def conditions(self, spec, goal):
        done = run("conditions", spec, "--goal", goal)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_conditions_are_those_of_admissible_velocities(self):
        # the blade: no velocity terms where the centre of mass is above it
        told = self.conditions(SLEIGH, "gyroscopic")
        self.assertIn("rank 1 of 4", told)
        self.assertIn("sleigh.mx = 0", told)
        # the cart: its momenta ahead and round, those of both wheels, and the sum of all masses
        self.assertIn("rank 7 of 30", self.conditions(CART, "force"))
        # each wheel feels its own acceleration alone where m b^2 = I of all that turns about the middle of the axle
        told = self.conditions(CART, "decoupled")
        self.assertIn("-b^2 cart.m + cart.Izz + 2 b left.my + left.Izz - 2 b right.my", told)
        apart = self.write("apart.yaml", config("rolling-cart.yaml", (r"com: \[d, 0, 0.05\], inertia: \[0.1, 0.2, 0.25\]",
                                                                      "com: [0, 0, 0.05], inertia: [0.18, 0.2, 0.316]")))
        self.assertIn("all are met", self.conditions(apart, "decoupled"))
        at = "P.x=0.2,P.y=0,P.angle=0.3,A=1,B=2"
        mass = json.loads(run("equations", apart, "--at", at, "--only", "inertia", "--json").stdout)
        self.assertLess(abs(np.array(mass["M"])[0, 1]), 1e-14)

    def test_equations_at_the_start_leave_out_what_bound_rates_do_not_have(self):
        for spec in (CART, SLEIGH, BICYCLE, DISC):
            done = run("equations", spec, "--at", "start", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            found = json.loads(done.stdout)
            self.assertEqual({"regressor", "natural"} & found.keys(), set())
            self.assertEqual(np.linalg.matrix_rank(found["M"]), len(found["independent"]))
            self.assertTrue(any(note.startswith("no regressor") for note in found["notes"]))

    def test_the_start_is_answered_whatever_comes_later(self):
        spec = self.write("stuck.yaml", STUCK)
        self.assert_failure(run("simulate", spec, "-t", "go"), 4, "drive singularity")
        found = json.loads(run("equations", spec, "--at", "start", "--json").stdout)
        self.assertEqual(found["configuration"]["W.lean"], 0.4026)

    def test_equations_in_the_speeds_of_the_spec(self):
        mass = json.loads(run("equations", CART, "--at", "end", "-t", "turn", "--only", "inertia", "--json").stdout)
        told = mass["in_speeds"]
        ahead = CART_MASS + 2 * WHEEL + 2 * SPIN / R ** 2
        around = CART_INERTIA + CART_MASS * D * D + 2 * (ACROSS + WHEEL * B * B) + 2 * SPIN * B * B / R ** 2
        self.near(np.array(told["M"]), np.diag([ahead, around]), 1e-10)

    def test_a_design_keeps_what_the_blade_bears_small(self):
        # the blade bears less the nearer the centre of mass: the limit decides
        spec = self.write("limited.yaml", config("sleigh.yaml", ("a: 0.1", "a: {free: [0.02, 0.2], start: 0.1}")) + """
design: {minimize: {rms: "force[P.x]", along: pull}, subject_to: ["peak(constraint_force[blade], pull) <= 15"]}
""")
        done = run("design", spec)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_split_of_torques_adds_up(self):
        for spec, trajectory in ((CART, "turn"), (DISC, "curve"), (SLEIGH, "pull")):
            found = self.moved("simulate", spec, "-t", trajectory, "--split")
            parts = sum(found[f"torque_{part}"] for part in ("inertia", "velocity", "friction", "weight", "spring", "load"))
            self.near(parts, found["torque"], 1e-12 * np.max(np.abs(found["torque"])))


if __name__ == "__main__":
    unittest.main()
