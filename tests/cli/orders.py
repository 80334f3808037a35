"""Motions at constant speed and their orders: against textbooks' series, a hand-written slider-crank, and runs of shafts as bodies."""

import json
import math
import os
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, config, run

SPEC = os.path.join(CONFIGS, "machines", "single-cylinder.yaml")
BARE = (("counterweights:.*?\n\n", ""), ("discs:.*?\n\n", ""))


def slider(ratio, samples=4096):
    """Cosine coefficients of -s''/(r omega^2) of a slider-crank: s = r cos + l sqrt(1 - ratio^2 sin^2), twice differentiated."""
    theta = 2 * math.pi * np.arange(samples) / samples
    root = np.sqrt(1 - (ratio * np.sin(theta)) ** 2)
    slope = -np.sin(theta) - ratio * np.sin(theta) * np.cos(theta) / root
    coefficients = np.fft.fft(slope) / samples
    n = np.fft.fftfreq(samples, 1 / samples)
    curve = np.real(np.fft.ifft(1j * n * coefficients * samples))
    return -2 * np.real(np.fft.fft(curve)) / samples


class Orders(Case):
    def orders(self, spec, highest, *arguments):
        done = run("simulate", spec, "--orders", str(highest), "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)["orders"]
        return told, {(row["quantity"], row["component"], row["order"]): row for row in told["rows"]}

    def test_the_series_of_the_slider(self):
        for rod, known in ((0.12, {2: 0.3431085772854066, 4: -0.01009907915242399, 6: 3.344321532971346e-4, 8: -1.093827037e-5}),
                           (0.16, {2: 0.2540250423069753, 4: -0.004098111172029278, 6: 7.437903279419574e-5, 8: -1.333291505e-6})):
            spec = self.write("spec.yaml", config("machines/single-cylinder.yaml", *BARE, ("C: .0.16, 0.", f"C: [{rod}, 0]")))
            _, found = self.orders(spec, 8)
            scale = 0.04 * (100 * math.pi) ** 2
            theory = slider(0.04 / rod)
            for order in range(1, 9):
                row = found[("joint_acceleration[S]", "", order)]
                self.assertAlmostEqual(-row["cosine"] / scale, theory[order], delta=1e-9)
                if order in known:
                    self.assertAlmostEqual(-row["cosine"] / scale, known[order], delta=1e-9 * max(1, abs(known[order])))

    def test_a_single_cylinder(self):
        spec = self.write("spec.yaml", config("machines/single-cylinder.yaml", *BARE))
        told, found = self.orders(spec, 6)
        self.assertEqual((told["coordinate"], told["turns"]), ("A", 1))
        self.assertAlmostEqual(told["speed"], 100 * math.pi, delta=1e-9)
        for (component, order), amplitude in {("x", 1): 2566.097144, ("y", 1): 740.2203301, ("", 2): 463.8184350, ("", 4): 7.482646171,
                                              ("", 6): 0.1358069514}.items():
            self.assertAlmostEqual(found[("shaking_force", component, order)]["amplitude"], amplitude, delta=1e-9 * amplitude)
        for order, amplitude in {1: 13.92801066, 3: 0.3356961688}.items():
            self.assertAlmostEqual(found[("shaking_moment", "", order)]["amplitude"], amplitude, delta=1e-9 * amplitude)
        for order, amplitude in {1: 4.638184350, 2: 38.25377233, 3: 14.02679274, 4: 1.122269457}.items():
            self.assertAlmostEqual(found[("torque[A]", "", order)]["amplitude"], amplitude, delta=1e-9 * amplitude)
        whole = found[("shaking_force", "", 1)]
        self.assertAlmostEqual(whole["forward"], (2566.097144 + 740.2203301) / 2, delta=1e-5)
        self.assertAlmostEqual(whole["backward"], (2566.097144 - 740.2203301) / 2, delta=1e-5)
        self.assertAlmostEqual(sum(found[("shaking_force", "", n)]["share"] for n in range(1, 7)), 1, delta=1e-9)

    def test_balance_shafts(self):
        told, found = self.orders(SPEC, 6)
        for order in (1, 2, 3, 5):
            self.assertLess(found[("shaking_force", "", order)]["amplitude"], 1e-9)
        self.assertAlmostEqual(found[("shaking_force", "", 4)]["amplitude"], 7.482646171, delta=1e-8)
        self.assertAlmostEqual(found[("shaking_force", "", 6)]["amplitude"], 0.1358069514, delta=1e-8)
        self.assertAlmostEqual(found[("shaking_moment", "", 1)]["amplitude"], 56.51931535, delta=1e-7)
        done = run("compare", SPEC + ":steady", SPEC + ":steady", "--require", "order(1, shaking_force) <= 1e-9", "--require",
                   "abs(order(4, shaking_force) - 7.482646171) <= 1e-8", "--require", "abs(order(4, shaking_force[x]) - 7.482646171) <= 1e-8")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # along one line both parts are half of it
        done = run("compare", SPEC + ":steady", SPEC + ":steady", "--require", "abs(forward_order(4, shaking_force) - 7.482646171 / 2) <= 1e-8",
                   "--require", "abs(backward_order(4, shaking_force) - 7.482646171 / 2) <= 1e-8")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        done = run("compare", SPEC + ":steady", SPEC + ":steady", "--require", "forward_order(4, shaking_moment) <= 1")
        self.assertIn("only a vector in the plane has a forward order", " ".join((done.stdout + done.stderr).split()))
        # all orders have their peaks at a right angle
        told, found = self.orders(SPEC, 24)
        peak = sum(row["amplitude"] for (quantity, component, _), row in found.items() if (quantity, component) == ("shaking_force", ""))
        done = run("compare", SPEC + ":steady", SPEC + ":steady", "--require", f"abs(peak(shaking_force) - {peak!r}) <= 1e-9")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_engines(self):
        """An inline four and a V-twin by hand; a radial engine as printed (Bevan ex. 12 p. 517, exact)."""
        for name, amplitudes in (("inline-four", {("x", 2): 3545.64819, ("x", 4): 83.5768281, ("x", 6): 2.21637752, ("x", 1): 0, ("", 3): 0, ("y", 2): 0}),
                                 ("v-twin", {("x", 1): 6884.04907, ("y", 1): 6884.04907, ("y", 2): 1253.57594, ("x", 2): 0,
                                             ("x", 4): 29.5488709, ("y", 4): 0})):
            _, found = self.orders(os.path.join(CONFIGS, "machines", name + ".yaml"), 8)
            for (component, order), amplitude in amplitudes.items():
                self.assertAlmostEqual(found[("shaking_force", component, order)]["amplitude"], amplitude, delta=max(1e-8, 2e-9 * amplitude),
                                       msg=(name, component, order))
        _, found = self.orders(os.path.join(CONFIGS, "machines", "radial-three.yaml"), 4)
        for order, part, other, amplitude, delta in ((1, "forward", "backward", 4264.13, 5e-3), (2, "backward", "forward", 1208.195, 5e-4)):
            row = found[("shaking_force", "", order)]
            self.assertAlmostEqual(row[part], amplitude, delta=delta)
            self.assertLess(row[other], 1e-8)
        self.assertAlmostEqual(found[("shaking_force", "", 4)]["amplitude"], 24.25, delta=5e-3)
        _, found = self.orders(os.path.join(CONFIGS, "machines", "inline-four.yaml"), 8)
        for order in range(1, 9):
            self.assertLess(found[("shaking_moment", "", order)]["amplitude"], 1e-9)

    def test_shafts_are_bodies_with_gears(self):
        file, other = self.path("discs.h5"), self.path("bodies.h5")
        text = config("machines/single-cylinder.yaml", ("discs:.*?\n\n", ""), ("points: {O: .0, 0.}\n", "points: {O: [0, 0], S1: [0, 0.06], S2: [0, 0.05], S3: [0, -0.05]}\n"),
                      ("\njoints:", """  b1: {mass: 0.5, com: ["-0.00925 / 0.5", 0], inertia: 1.0e-4, points: {O: [0, 0]}}
  b2: {mass: 0.2, com: ["-p2 / 0.2", 0], inertia: 1.0e-4, points: {O: [0, 0]}}
  b3: {mass: 0.2, com: ["-p2 / 0.2", 0], inertia: 1.0e-4, points: {O: [0, 0]}}

joints:"""), ("\ncounterweights:", """  b1: {type: revolute, connects: [ground.S1, b1.O]}
  b2: {type: revolute, connects: [ground.S2, b2.O]}
  b3: {type: revolute, connects: [ground.S3, b3.O]}

couplings:
  - {joint: b1, follows: A, ratio: -1}
  - {joint: b2, follows: A, ratio: 2}
  - {joint: b3, follows: A, ratio: -2}

counterweights:"""))
        self.assert_quiet_success(run("simulate", SPEC, "-o", file, "-q"))
        self.assert_quiet_success(run("simulate", self.write("spec.yaml", text), "-o", other, "-q"))
        with h5py.File(file) as discs, h5py.File(other) as bodies:
            for name in ("torque", "shaking_force", "shaking_moment", "joint_force", "kinetic_energy"):
                np.testing.assert_allclose(discs[name], bodies[name], rtol=0, atol=1e-9 * np.abs(bodies[name]).max(), err_msg=name)

    def test_eccentric_discs_in_space(self):
        """A shaft askew in space, its mass by hand: m e w^2 towards the centre of mass, which turns about the axis."""
        spec = self.write("spec.yaml", """
space: spatial
gravity: [0, 0, 0]
ground: {points: {O: [0, 0, 0]}}
bodies: {crank: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1], points: {O: [0, 0, 0]}}}
joints: {A: {type: revolute, connects: [ground.O, crank.O], axis: [0, 0.6, 0.8]}}
discs: {b: {body: ground, at: [0.3, 0, 0], follows: A, ratio: 2, axis: [0, 0.6, 0.8], mass: 2, eccentricity: 0.05, phase: 0.4, zero: [1, 1, 0]}}
actuators: [A]
trajectories: {turn: {drive: joints, speed: {A: 10}, samples: 101, from: {joints: {A: 0}}}}
""")
        _, found = self.orders(spec, 3)
        self.assertAlmostEqual(found[("shaking_force", "", 2)]["amplitude"], 2 * 0.05 * 20**2, delta=1e-9)
        axis, zero = np.array([0, 0.6, 0.8]), np.array([1, 1, 0]) / math.sqrt(2)
        normal = np.cross(axis, zero)
        normal /= np.linalg.norm(normal)
        radial = np.cross(normal, axis)
        start = -2 * 0.05 * 400 * (math.cos(0.4) * radial + math.sin(0.4) * normal)
        cosine = [found[("shaking_force", name, 2)]["cosine"] for name in "xyz"]
        np.testing.assert_allclose(cosine, start, atol=1e-9)
        for order in (1, 3):
            self.assertLess(found[("shaking_force", "", order)]["amplitude"], 1e-9)

    def test_halves_and_turns(self):
        """A shaft at half the speed has order 1/2; over a single turn the motion does not repeat."""
        text = config("machines/single-cylinder.yaml", ("ratio: -2", "ratio: 0.5"))
        spec = self.write("spec.yaml", text)
        done = run("simulate", spec, "--orders", "4")
        self.assert_failure(done, 2, "does not repeat after 1 turn of A")
        spec = self.write("spec.yaml", text.replace("speed: {A: omega}", "speed: {A: -omega}, turns: 2"))
        told, found = self.orders(spec, 4)
        self.assertEqual(told["turns"], 2)
        self.assertAlmostEqual(told["speed"], -100 * math.pi, delta=1e-9)
        self.assertAlmostEqual(found[("shaking_force", "", 0.5)]["amplitude"], 0.0005874329103348804 * (50 * math.pi) ** 2, delta=1e-9)
        self.assertAlmostEqual(found[("shaking_force", "", 2)]["amplitude"], 0.0005874329103348804 * (200 * math.pi) ** 2, delta=1e-7)
        done = run("compare", spec + ":steady", spec + ":steady", "--require", "order(1/2, shaking_force) >= 1", "--require", "order(1/3, shaking_force) >= 0")
        self.assertEqual(done.returncode, 1)
        self.assertIn("a run of 2 turns has no order 0.333", done.stdout)

    def fluctuation(self, spec, *arguments):
        return self.orders(spec, 4, *arguments)[0]["fluctuation"]

    def test_the_speed_of_a_free_engine(self):
        """Without a torque J(angle) w^2 stays what it is; a flywheel is inertia of the crank."""
        spec = self.write("spec.yaml", config("machines/single-cylinder.yaml", *BARE, ("samples: 513", "samples: 2049")))
        found = self.fluctuation(spec, "--fluctuation", "0.05")
        self.assert_quiet_success(run("simulate", spec, "-o", self.path("run.h5"), "-q"))
        with h5py.File(self.path("run.h5")) as read:
            inertia = 2 * np.array(read["kinetic_energy"]).ravel() / (100 * math.pi) ** 2
        high, low = 1 / math.sqrt(inertia.min()), 1 / math.sqrt(inertia.max())
        self.assertAlmostEqual(found["coefficient"], 2 * (high - low) / (high + low), delta=1e-6)
        self.assertAlmostEqual((found["largest"] + found["smallest"]) / 2, 100 * math.pi, delta=1e-9)
        self.assertAlmostEqual(found["mean_torque"], 0, delta=1e-9)
        heavy = self.write("heavy.yaml", config("machines/single-cylinder.yaml", *BARE, ("samples: 513", "samples: 2049"), (
            "inertia: 0.002,", f"inertia: {0.002 + found['flywheel']!r},")))
        self.assertAlmostEqual(self.fluctuation(heavy)["coefficient"], 0.05, delta=1e-9)
        self.assertEqual(self.fluctuation(heavy, "--fluctuation", "0.06")["flywheel"], 0)

    def test_textbooks_flywheels(self):
        """Khurmi & Gupta ex. 16.13: 0.1013 %; Sarkar ch. 6 ill. 6, 1.3293 %, and ill. 10, 15125 N m and 1724 kg m^2 (misprinted there)."""
        for torque, inertia, speed, figures in (
                (lambda a: 5000 + 1500 * math.sin(3 * a), 1000, 300, {"coefficient": 0.001013212}),
                (lambda a: 1000 + 300 * math.sin(2 * a) - 500 * math.cos(2 * a), 64, 250, {"coefficient": 0.01329298}),
                (lambda a: 8000 * math.sin(2 * a) - 6000 * math.cos(a), 1e-3, 200, {"energy_range": 15125, "flywheel": 1724.043})):
            omega = speed * math.pi / 30
            rows = 720
            times = [2 * math.pi / omega * k / rows for k in range(rows + 1)]
            moments = [torque(2 * math.pi * k / rows) for k in range(rows + 1)]
            spec = self.write("spec.yaml", f"""
space: planar
gravity: [0, 0]
ground: {{points: {{O: [0, 0]}}}}
bodies: {{rotor: {{mass: 1, com: [0, 0], inertia: {inertia}, points: {{O: [0, 0]}}}}}}
joints: {{A: {{type: revolute, connects: [ground.O, rotor.O]}}}}
actuators: [A]
loads: {{gas: {{body: rotor, table: {{time: {times}, moment: {moments}}}}}}}
trajectories: {{turn: {{drive: joints, speed: {{A: {omega!r}}}, samples: {rows + 1}, from: {{joints: {{A: 0}}}}}}}}
""")
            found = self.fluctuation(spec, "--fluctuation", "0.02")
            for name, value in figures.items():
                self.assertAlmostEqual(found[name], value, delta=3e-5 * value, msg=name)

    def test_files(self):
        file = self.path("run.h5")
        self.assert_quiet_success(run("simulate", SPEC, "--orders", "3", "-o", file, "-q"))
        with h5py.File(file) as read:
            group = read["orders"]
            self.assertEqual(group.attrs["coordinate"], "A")
            order, quantity = np.array(group["order"]), [name.decode() for name in group["quantity"]]
            self.assertEqual(len(order), len(quantity))
            self.assertEqual(set(order), {1, 2, 3})
            self.assertIn("--orders 3", read.attrs["history"] if "history" in read.attrs else read.attrs["command_line"])
        text = run("simulate", SPEC, "--orders", "6")
        self.assert_quiet_success(text)
        self.assertIn("orders of the angle of A", text.stdout)

    def test_mistakes(self):
        def refused(*changes, words, code=3, options=()):
            done = run("simulate", self.write("bad.yaml", config("machines/single-cylinder.yaml", *changes)), *options)
            self.assert_failure(done, code, *words)
        refused(("speed: {A: omega}", "speed: {S: 1}"), words=("a joint that turns",))
        refused(("speed: {A: omega}", "speed: {B: 1}"), words=("a joint of the start pose",))
        refused(("speed: {A: omega}", "speed: {A: 0}"), words=("other than zero",))
        refused(("speed: {A: omega}", "speed: {A: omega}, duration: 1"), words=("no 'duration' with 'speed'",))
        refused(("speed: {A: omega}", "speed: {A: omega}, law: cycloidal"), words=("'uniform' or no law",))
        refused(("speed: {A: omega}", "speed: {A: omega}, turns: -1"), words=("a positive number of turns",))
        refused(("drive: joints, speed", "drive: tool, speed"), ("actuators:", "tool: piston.C\nactuators:"), words=("only with 'drive: joints'",))
        refused(("  b1: {body: ground", "  cw: {body: ground"), words=("a name of its own",))
        refused(("speed: {A: omega}", "law: cycloidal, duration: 1, turns: 1"), words=("no joint does",), code=2, options=("--orders", "2"))
        refused(("samples: 513", "samples: 11"), words=("needs at least 17 samples",), code=2, options=("--orders", "4"))


if __name__ == "__main__":
    unittest.main()
