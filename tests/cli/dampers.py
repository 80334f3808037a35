"""Dampers between points and in joints, and springs whose force is a table."""

import json
import math
import os
import unittest

import h5py
import numpy
import scipy.integrate
import scipy.interpolate

from _program import CONFIGS, Case, run

G = 9.81
# A pendulum of inertia J about O with an element from the ground's S to its end B.
PENDULUM = """\
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0], S: [0.4, 0.7]}}}}
bodies: {{link: {{mass: 2, com: [0.3, 0], inertia: 0.05, points: {{A: [0, 0], B: [0.6, 0.1]}}}}}}
joints: {{J: {{type: revolute, connects: [ground.O, link.A]}}}}
{elements}
actuators: [J]
trajectories:
  swing: {{law: cycloidal, drive: joints, duration: 0.8, samples: 401, from: {{joints: {{J: -1.2}}}}, to: {{joints: {{J: 1.9}}}}}}
{tail}
"""
J = 0.05 + 2 * 0.3**2
TABLE = [[0.1, -40], [0.3, -10], [0.5, 5], [0.8, 60], [1.2, 70]]


def length_and_slope(q):
    """Distance of S from B, and its derivative by q."""
    x, y = 0.6 * numpy.cos(q) - 0.1 * numpy.sin(q), 0.6 * numpy.sin(q) + 0.1 * numpy.cos(q)
    l = numpy.hypot(x - 0.4, y - 0.7)
    return l, ((x - 0.4) * -y + (y - 0.7) * x) / l


class Dampers(Case):
    def simulate(self, text, *arguments):
        spec, out = self.write("spec.yaml", text), self.path("out.h5")
        done = run("simulate", spec, "-o", out, "--force", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(out) as file:
            return {name: numpy.array(file[name]) for name in file if isinstance(file[name], h5py.Dataset)}

    def pendulum(self, elements, *arguments, tail=""):
        got = self.simulate(PENDULUM.format(elements=elements, tail=tail), *arguments)
        q, dq, ddq = (got[f"joint_{name}"][:, 0] for name in ("position", "velocity", "acceleration"))
        return got, q, dq, J * ddq + 2 * G * 0.3 * numpy.cos(q)

    def test_a_damper_between_points_takes_c_times_the_square_of_the_rate_of_its_length(self):
        for formulation in ("tree", "natural"):
            got, q, dq, bare = self.pendulum("dampers: {d: {between: [ground.S, link.B], damping: 7}}", "--formulation", formulation)
            slope = length_and_slope(q)[1]
            expected = bare + 7 * slope**2 * dq
            self.assertLess(abs(got["torque"][:, 0] - expected).max(), 1e-11 * abs(expected).max())

    def test_a_table_is_linear_between_its_rows_and_constant_beyond(self):
        lengths, tensions = zip(*TABLE)
        for formulation in ("tree", "natural"):
            got, q, _, bare = self.pendulum(f"springs: {{s: {{between: [ground.S, link.B], table: {TABLE}}}}}", "--formulation", formulation)
            l, slope = length_and_slope(q)
            self.assertGreater(l.max(), 1.2)  # beyond the last row
            expected = bare + numpy.interp(l, lengths, tensions) * slope
            self.assertLess(abs(got["torque"][:, 0] - expected).max(), 1e-11 * abs(expected).max())

    def test_a_spline_is_scipy_s_not_a_knot_spline_with_its_integral_as_energy(self):
        table = [[0.05, -40], [0.3, -10], [0.5, 5], [0.8, 60], [1.6, 70]]
        spline = scipy.interpolate.CubicSpline(*zip(*table))
        for formulation in ("tree", "natural"):
            got, q, _, bare = self.pendulum(
                f"springs: {{s: {{between: [ground.S, link.B], table: {table}, interpolation: spline}}}}", "--formulation", formulation)
            l, slope = length_and_slope(q)
            expected = bare + spline(l) * slope
            self.assertLess(abs(got["torque"][:, 0] - expected).max(), 1e-11 * abs(expected).max())
            energy = 2 * G * 0.3 * numpy.sin(q) + numpy.array([spline.integrate(0.05, x) for x in l])
            self.assertLess(abs(got["potential_energy"] - energy).max(), 1e-11 * abs(energy).max())

    def test_a_table_in_a_joint_drives_it_with_its_effort(self):
        table = [[-1.5, 4], [-0.5, 1], [0, 0], [1, -6]]
        for formulation in ("tree", "natural"):
            got, q, _, bare = self.pendulum(f"springs: {{s: {{joint: J, table: {table}, damping: 0.3}}}}", "--formulation", formulation)
            expected = bare - numpy.interp(q, *zip(*table)) + 0.3 * got["joint_velocity"][:, 0]
            self.assertLess(abs(got["torque"][:, 0] - expected).max(), 1e-11 * abs(expected).max())

    def test_damping_of_a_spring_is_a_damper_with_its_points(self):
        beside = self.pendulum("springs: {s: {between: [ground.S, link.B], stiffness: 90, free_length: 0.4, damping: 7}}")[0]
        apart = self.pendulum("springs: {s: {between: [ground.S, link.B], stiffness: 90, free_length: 0.4}}\n"
                              "dampers: {d: {between: [ground.S, link.B], damping: 7}}")[0]
        self.assertTrue((beside["torque"] == apart["torque"]).all())

    def test_a_damper_in_a_joint_is_viscous_friction(self):
        damper = self.pendulum("dampers: {d: {joint: J, damping: 0.7}}\nfriction: {J: {viscous: 0.2}}")[0]
        friction = self.pendulum("friction: {J: {viscous: 0.9}}")[0]
        self.assertLess(abs(damper["torque"] - friction["torque"]).max(), 1e-14 * abs(friction["torque"]).max())

    def test_units_scale_damping_and_tables(self):
        metric = self.pendulum(f"springs: {{s: {{between: [ground.S, link.B], table: {TABLE}, damping: 7}}}}")[0]["torque"]
        rows = [[1000 * l, f] for l, f in TABLE]
        text = PENDULUM.format(elements=f"springs: {{s: {{between: [ground.S, link.B], table: {rows}, damping: 0.007}}}}",
                               tail="units: {length: mm, force: N}")
        for old, new in (("-9.81", "-9810"), ("[0.4, 0.7]", "[400, 700]"), ("[0.3, 0], inertia: 0.05", "[300, 0], inertia: 50000"),
                         ("[0.6, 0.1]", "[600, 100]")):
            text = text.replace(old, new)
        got = self.simulate(text)["torque"]
        self.assertLess(abs(got - metric).max(), 1e-11 * abs(metric).max())

    def test_a_released_pendulum_moves_as_scipy_integrates_it(self):
        """Partly driven: a wheel turns beside the free J. The table is a spline, so that the motion is smooth."""
        table = [[0.05, -40], [0.3, -10], [0.5, 5], [0.8, 60], [1.6, 70]]
        text = PENDULUM.format(
            elements=f"springs: {{s: {{between: [ground.S, link.B], table: {table}, interpolation: spline, damping: 3}}}}",
            tail="  fall: {law: uniform, drive: joints, duration: 1, samples: 101, from: {joints: {W: 0}}, to: {joints: {W: 1}}, free: [J],"
                 " initial: {joints: {J: -0.4}}}")
        wheel = ("bodies: {wheel: {mass: 1, com: [0, 0], inertia: 1, points: {A: [0, 0]}}, ",
                 "joints: {W: {type: revolute, connects: [ground.O, wheel.A]}, ")
        for old, new in (("bodies: {", wheel[0]), ("joints: {", wheel[1]), ("actuators: [J]", "actuators: [W]")):
            text = text.replace(old, new, 1)
        text = text.replace(text[text.index("  swing:"):text.index("  fall:")], "")
        got = self.simulate(text, "--trajectory", "fall")
        spline = scipy.interpolate.CubicSpline(*zip(*table))

        def rates(_, y):
            l, slope = length_and_slope(y[0])
            return y[1], -(2 * G * 0.3 * math.cos(y[0]) + spline(l) * slope + 3 * slope**2 * y[1]) / J

        expected = scipy.integrate.solve_ivp(rates, (0, 1), (-0.4, 0), rtol=1e-12, atol=1e-12, t_eval=got["time"]).y[0]
        # the program's own tolerance of the motion is 1e-10 of a radian per duration
        self.assertLess(abs(got["joint_position"][:, 1] - expected).max(), 1e-8)

    def test_a_controlled_run_loses_what_the_damper_takes(self):
        text = PENDULUM.format(elements="dampers: {d: {between: [ground.S, link.B], damping: 7}}",
                               tail="controllers: {none: {type: open-loop, torque: 0}}")
        spec, out = self.write("spec.yaml", text), self.path("out.h5")
        done = run("control", spec, "--controller", "none", "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(out) as file:
            q, dq = file["joint_position"][:, 0], file["joint_velocity"][:, 0]
            energy, time = file["kinetic_energy"][:] + file["potential_energy"][:], file["time"][:]
        slope = length_and_slope(q)[1]
        lost = scipy.integrate.cumulative_trapezoid(7 * slope**2 * dq**2, time, initial=0)
        # trapezoids on 401 samples
        self.assertLess(abs(energy - energy[0] + lost).max(), 1e-4 * lost.max())

    def test_breakdown_counts_dampers_as_friction_and_tables_as_springs(self):
        got, q, dq, _ = self.pendulum(f"springs: {{s: {{between: [ground.S, link.B], table: {TABLE}, damping: 7}}}}", "--split")
        l, slope = length_and_slope(q)
        self.assertLess(abs(got["torque_friction"][:, 0] - 7 * slope**2 * dq).max(), 1e-10)
        self.assertLess(abs(got["torque_spring"][:, 0] - numpy.interp(l, *zip(*TABLE)) * slope).max(), 1e-10)

    def test_a_loop_with_every_element_has_one_answer_in_both_formulations(self):
        with open(os.path.join(CONFIGS, "5r.yaml"), encoding="utf-8") as file:
            text = file.read()
        text += ("\nsprings: {t: {between: [ground.origin, coupler2.origin], table: [[0, 1], [0.3, 4], [0.6, -2], [2, 1]],"
                 " interpolation: spline, damping: 2}}\ndampers: {d: {between: [crank1.origin, coupler2.origin], damping: 3}}\n")
        done = run("check", "--verify", self.write("five.yaml", text))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_conditions_name_what_no_mass_balances(self):
        text = PENDULUM.format(elements=f"springs: {{s: {{between: [ground.S, link.B], table: {TABLE}, damping: 7}}}}", tail="")
        spec = self.write("spec.yaml", text)
        done = run("conditions", spec, "--goal", "gyroscopic")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("damper s (damping = 7 N s/m)", done.stdout)
        done = run("conditions", spec, "--goal", "gyroscopic", "--without", "dampers,springs")
        self.assertNotIn("damper s", done.stdout)

    def test_a_table_of_a_linear_spring_balances_as_the_spring_does(self):
        """A zero-free-length spring with g m c = k a b, as a table: the pendulum is in balance statically."""
        k = 2 * G * 0.3 / (0.5 * 0.4)
        text = f"""\
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0], S: [0, 0.5]}}}}
bodies: {{link: {{mass: 2, com: [0.3, 0], inertia: 0.05, points: {{A: [0, 0], B: [0.4, 0]}}}}}}
joints: {{J: {{type: revolute, connects: [ground.O, link.A]}}}}
springs: {{s: {{between: [ground.S, link.B], table: [[0, 0], [2, {2 * k}]]}}}}
actuators: [J]
trajectories:
  swing: {{law: cycloidal, drive: joints, duration: 5, from: {{joints: {{J: -1}}}}, to: {{joints: {{J: 1}}}}}}
"""
        done = run("conditions", self.write("balanced.yaml", text), "--goal", "static", "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_suites_and_designs_know_lengths_and_forces(self):
        text = PENDULUM.format(elements="dampers: {d: {between: [ground.S, link.B], damping: {free: [1, 9]}}}",
                               tail="design:\n  minimize: 'peak(torque[J], swing)'\n  subject_to: ['peak(damper_force[d], swing) >= 5']")
        done = run("design", self.write("design.yaml", text), "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        spec = self.path("designed.yaml")
        self.assertEqual(run("design", self.path("design.yaml"), "-o", spec).returncode, 0)
        with open(spec, encoding="utf-8") as file:
            self.assertNotIn("free:", file.read())

    def test_a_model_without_the_damper_has_another_gain(self):
        text = PENDULUM.format(elements="springs: {s: {between: [ground.S, link.B], stiffness: 50, damping: 7}}",
                               tail="controllers: {ct: {type: computed-torque, model: {without: s}}}")
        done = run("control", self.write("spec.yaml", text), "--controller", "ct", "-o", self.path("out.h5"))
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
