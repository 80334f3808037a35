"""`balance tolerance`: deviations against closed forms, against differences of whole runs, and against mechanisms drawn at random."""

import json
import math
import os
import unittest

import h5py

from _program import CONFIGS, Case, run

ARM = os.path.join(CONFIGS, "rr-tolerance.yaml")
G = 9.81

PENDULUM = """\
space: planar
gravity: [0, -9.81]
parameters: {r: 0.4}
ground: {points: {O: [0, 0]}}
bodies:
  link: {mass: 2, com: [r, 0], inertia: 0.1, points: {H: [0, 0]}}
counterweights: {cw: {body: link, at: [-0.8, 0], mass: MASS}}
joints: {A: {type: revolute, connects: [ground.O, link.H]}}
actuators: [A]
motion: {duration: 2, samples: 401, from: {joints: {A: -0.5}}, to: {joints: {A: 1.5}}}
trajectories: {slow: {law: cycloidal, drive: joints}}
tolerances: TOLERANCES
"""


# A balanced arm whose motors peak twice, as fast to as fro, by other numbers.
TWO_PEAKS = """\
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  link1: {mass: 2, com: [0.25, 0], inertia: 0.042, points: {P1: [0, 0], P2: [0.5, 0]}}
  link2: {mass: 1.5, com: [0.2, 0], inertia: 0.02, points: {P2: [0, 0], P3: [0.4, 0]}}
payloads: {cargo: {body: link2, at: [0.4, 0], mass: 0.5}}
counterweights:
  cw1: {body: link1, at: [-0.2, 0], mass: 13.75}
  cw2: {body: link2, at: [-0.2, 0], mass: 2.5}
joints:
  R1: {type: revolute, connects: [ground.O, link1.P1]}
  R2: {type: revolute, connects: [link1.P2, link2.P2]}
actuators: [R1, R2]
motion: {duration: 1, samples: 41, from: {joints: {R1: -0.3, R2: 1.4}}, to: {joints: {R1: 0.9, R2: 2.4}}}
trajectories: {cycloid: {law: cycloidal, drive: joints}}
tolerances: {cw1.mass: 1%, cw2.mass: 1%}
"""


def pendulum(tolerances, mass=0.5):
    return PENDULUM.replace("TOLERANCES", tolerances).replace("MASS", str(mass))


class Tolerance(Case):
    def told(self, spec, *arguments):
        done = run("tolerance", spec, "--json", *arguments)
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def quantity(self, told, name):
        return next(q for q in told["first_order"]["quantities"] if q["quantity"] == name)

    def metrics(self, spec, trajectory):
        done = run("simulate", spec, "-t", trajectory, "--samples", "101", "--json", "-q")
        self.assert_quiet_success(done)
        return {m["quantity"]: m for m in json.loads(done.stdout)["metrics"]}

    def test_the_arm_at_rest_is_as_by_hand(self):
        told = self.told(ARM, "--at-rest")["at_rest"]
        first, second = told["actuators"]
        by_cw1, by_cw2 = G * 0.2 * 0.1375, G * 0.7 * 0.025
        self.assertAlmostEqual(first["deviation"], math.hypot(by_cw1, by_cw2), delta=1e-12)
        self.assertAlmostEqual(first["deviation"], 0.31977, delta=5e-6)
        self.assertAlmostEqual(math.cos(first["coordinates"]["R2"]), -1, delta=1e-12)
        self.assertAlmostEqual(first["effort"], 0, delta=1e-12)
        self.assertAlmostEqual(first["shares"]["counterweights.cw1.mass"], by_cw1**2 / (by_cw1**2 + by_cw2**2), delta=1e-12)
        self.assertAlmostEqual(second["deviation"], G * 0.2 * 0.025, delta=1e-12)

    def test_poses_at_rest_need_no_grid_that_has_the_worst_one(self):
        """Both terms A cos q + B sin q of a tilted arm: the largest is their root, wherever it is."""
        spec = self.write("tilted.yaml", pendulum("{link.com: 1e-3}").replace("[0, -9.81]", "[3, -9]"))
        (only,) = self.told(spec, "--at-rest")["at_rest"]["actuators"]
        # both components off alike: in every pose the same
        self.assertAlmostEqual(only["deviation"], 2 * 1e-3 * math.hypot(3, 9), delta=1e-9)

    def test_a_pendulum_as_by_hand(self):
        """u = (J + m r^2 + …) q'' + m g r cos q: by m and by r, at the sample where it is worst."""
        spec = self.write("s.yaml", pendulum("{link.mass: 1%, r: {uniform: 2e-3}}"))
        worst = self.quantity(self.told(spec), "torque[A]")["worst_sample"]
        t, q = worst["time"] / 2, worst["coordinates"]["A"]
        self.assertAlmostEqual(q, -0.5 + 2 * (t - math.sin(2 * math.pi * t) / (2 * math.pi)), delta=1e-12)
        a = 2 * 2 * math.pi * math.sin(2 * math.pi * t) / 4
        by_mass = 0.02 * (0.4**2 * a + G * 0.4 * math.cos(q))
        by_length = 2e-3 / math.sqrt(3) * 2 * (2 * 0.4 * a + G * math.cos(q))
        self.assertAlmostEqual(worst["deviation"], math.hypot(by_mass, by_length), delta=1e-11)
        self.assertAlmostEqual(worst["shares"]["parameters.r"], by_length**2 / (by_mass**2 + by_length**2), delta=1e-11)

    def test_figures_agree_with_differences_of_whole_runs(self):
        """Loops, slides and space; masses, lengths and angles."""
        for name in ("four-bar", "slider-crank", "spatial-rrr"):
            with self.subTest(name):
                self.differences(name)

    def differences(self, name):
        with open(os.path.join(CONFIGS, name + ".yaml"), encoding="utf-8") as file:
            text = file.read()
        first = json.loads(run("simulate", os.path.join(CONFIGS, name + ".yaml"), "--json", "-q").stdout)
        trajectory = first["trajectory"]
        spec = self.write(name + ".yaml", text + '\ntolerances: {"bodies.*.mass": 1%}\n')
        told = self.told(spec, "-t", trajectory, "--samples", "101")
        now = self.metrics(spec, trajectory)
        for number in told["numbers"][:2]:
            body = number["path"].split(".")[1]
            step = 1e-3 * number["value"]
            moved = []
            for sign in (1, -1):
                lines = text.split("\n")
                at = next(i for i, line in enumerate(lines) if line.strip().startswith(body + ":") and "mass:" in line)
                lines[at] = moved_mass(lines[at], sign * step)
                moved.append(self.metrics(self.write("moved.yaml", "\n".join(lines)), trajectory))
            for quantity in ("shaking_force", "shaking_moment"):
                for figure in ("rms", "peak", "mean"):
                    more, less = ((m[quantity][figure] - now[quantity][figure]) / step for m in moved)
                    slope = (more - less) / 2
                    if figure == "peak" and abs(more + less) > 0.01 * abs(slope):
                        continue  # two places are the peak, and the figure has a kink
                    exact = self.quantity(told, quantity)[figure]["by_number"][number["path"]] / number["deviation"]
                    scale = self.quantity(told, quantity)[figure]["value"] / number["value"]
                    self.assertAlmostEqual(exact, slope, delta=1e-5 * scale, msg=f"{name} {number['path']} {figure} {quantity}")

    def test_a_balanced_arm_has_no_slope_but_squares(self):
        """The shaking force is linear in the masses: its mean square is exact, and so is that square's own deviation."""
        told = self.told(ARM, "--of", "shaking_force", "--monte-carlo", "3000", "--seed", "5", "--samples", "41")
        force = self.quantity(told, "shaking_force")
        self.assertEqual((force["rms"]["value"], force["rms"]["deviation"]), (0, None))
        self.assertGreater(force["expected_rms"], 0)
        sampled = next(f for f in told["sampling"]["figures"] if f["figure"] == "rms")
        self.assertEqual(told["sampling"]["drawn"], 3000)
        square = sampled["mean"] ** 2 + sampled["deviation"] ** 2 * 2999 / 3000
        error = force["mean_square_deviation"] / math.sqrt(3000)
        self.assertLess(abs(square - force["expected_rms"] ** 2), 4 * error)

    def test_draws_agree_with_the_first_order_within_their_errors(self):
        spec = self.write("s.yaml", pendulum("{link.mass: 0.5%, r: {uniform: 1e-4}, cw.mass: 0.3%}"))
        told = self.told(spec, "--monte-carlo", "2000", "--seed", "3", "--samples", "41")
        checked = 0
        for figure in told["sampling"]["figures"]:
            if figure["disagreement"] is not None and figure["quantity"].startswith(("torque", "shaking")):
                self.assertLess(figure["disagreement"], 5, figure)
                checked += 1
        self.assertGreater(checked, 8)
        self.assertEqual(self.told(spec, "--monte-carlo", "20", "--seed", "3"), self.told(spec, "--monte-carlo", "20", "--seed", "3"))

    def test_twice_the_tolerance_is_twice_the_deviation(self):
        one, two = (self.told(self.write(f"{k}.yaml", pendulum(f"{{link.mass: {k}%, r: {k}e-4}}"))) for k in (1, 2))
        for a, b in zip(one["first_order"]["quantities"], two["first_order"]["quantities"]):
            self.assertAlmostEqual(2 * a["worst_sample"]["deviation"], b["worst_sample"]["deviation"],
                                   delta=1e-12 * (1 + b["worst_sample"]["deviation"]))

    def test_draws_that_are_no_mechanism_are_counted(self):
        spec = self.write("s.yaml", pendulum("{cw.mass: 100%}"))
        told = self.told(spec, "--monte-carlo", "400", "--samples", "11")["sampling"]
        (count,) = told["refused"].values()
        self.assertEqual(told["drawn"] + count, 400)
        # one in 6.3 of a normal distribution is more than one deviation below its mean
        self.assertLess(abs(count / 400 - 0.1587), 4 * math.sqrt(0.1587 * 0.8413 / 400))

    def test_a_peak_that_two_moments_share_is_off_as_draws_are(self):
        spec = self.write("s.yaml", TWO_PEAKS)
        told = self.told(spec, "--of", "torque", "--monte-carlo", "3000", "--seed", "2")
        rivals = 0
        for figure in told["sampling"]["figures"]:
            if figure["figure"] not in ("peak", "range") or figure["quantity"] == "torque":
                continue  # of the worst actuator there is no first order
            known = self.quantity(told, figure["quantity"])[figure["figure"]]
            rivals += len(known["rival_times"]) > 1
            # the draws' own error, and the hundredth that such a deviation is good to
            self.assertLess(abs(known["deviation"] - figure["deviation"]),
                            4 * figure["deviation_error"] + 0.02 * figure["deviation"], figure)
        self.assertGreater(rivals, 0)
        done = run("tolerance", spec, "--of", "torque")
        self.assert_quiet_success(done)
        self.assertRegex(done.stdout, r"\d\*  ")
        self.assertIn("which moment is the largest depends on the numbers", done.stdout)

    def test_numbers_that_open_a_joint_are_named_and_left_out(self):
        """A four-bar in space: across its plane nothing can move, along it all can."""
        with open(os.path.join(CONFIGS, "four-bar-in-space.yaml"), encoding="utf-8") as file:
            text = file.read()
        both = self.write("both.yaml", text + "\ntolerances: {'ground.points.A[2]': 1e-4, crank.mass: 1%}\n")
        mass = self.write("mass.yaml", text + "\ntolerances: {crank.mass: 1%}\n")
        told, without = self.told(both, "--samples", "41"), self.told(mass, "--samples", "41")
        (opening,) = told["openings"]
        self.assertEqual((opening["number"], opening["unit"]), ("ground.points.A[2]", "m"))
        self.assertAlmostEqual(opening["gap"], 1e-4, delta=1e-12)
        self.assertEqual(without["openings"], [])
        for one, other in zip(told["first_order"]["quantities"], without["first_order"]["quantities"]):
            for figure in ("peak", "rms", "mean", "range"):
                # of several moments good to a hundredth, with other draws
                error = 0.03 * one[figure]["deviation"] if one[figure]["rival_times"] else 0
                self.assertAlmostEqual(one[figure]["deviation"] or 0, other[figure]["deviation"] or 0, delta=error)
                self.assertIsNone(one[figure]["by_number"]["ground.points.A[2]"])
        # drawn are the others, and all of them assemble
        sampling = self.told(both, "--samples", "11", "--monte-carlo", "20")["sampling"]
        self.assertEqual((sampling["drawn"], sampling["refused"]), (20, {}))
        done = run("tolerance", both, "--samples", "41")
        self.assert_quiet_success(done)
        self.assertRegex(done.stdout, r"ground\.points\.A\[2\] +" + opening["joint"] + r" +0\.0001\d* +m")
        self.assertIn("least norm", done.stdout)  # what the joints transmit is not determined
        (rest,) = self.told(both, "--at-rest")["openings"]
        self.assertEqual(rest["joint"], opening["joint"])
        with_file = self.path("both.h5")
        self.assert_quiet_success(run("tolerance", both, "--samples", "41", "-o", with_file))
        with h5py.File(with_file) as file:
            self.assertEqual(list(file["tolerance/openings/opening"].asstr()), ["ground.points.A[2]"])
            self.assertEqual(list(file["tolerance/openings/joint"].asstr()), [opening["joint"]])
        only = self.write("only.yaml", text + "\ntolerances: {'ground.points.A[2]': 1e-4}\n")
        self.assert_failure(run("tolerance", only, "--monte-carlo", "9"), 3, "every number opens a joint")

    def test_at_rest_without_what_it_is_about(self):
        spec = pendulum("{link.mass: 1%}")
        still = self.told(self.write("still.yaml", spec.replace("[0, -9.81]", "[0, 0]")), "--at-rest")["at_rest"]
        self.assertEqual((still["actuators"][0]["deviation"], still["actuators"][0]["effort"]), (0, 0))
        idle = self.write("idle.yaml", spec.replace("actuators: [A]", "actuators: []"))
        self.assert_failure(run("tolerance", idle, "--at-rest"), 3, "there are no actuators")
        free = spec.replace("\njoints: {", "\njoints: {B: {type: revolute, connects: [link.E, end.E]}, ").replace(
            "points: {H: [0, 0]}}", "points: {H: [0, 0], E: [1, 0]}}\n  end: {mass: 1, com: [0.1, 0], inertia: 0.1, points: {E: [0, 0]}}")
        self.assert_failure(run("tolerance", self.write("free.yaml", free), "--at-rest"), 4, "under-actuated: 1 actuators for 2")

    def test_mistakes(self):
        for tolerances, wanted in (
            ("{cx.mass: 1%}", "tolerances.cx.mass: expected a parameter"),
            ("{cw.mass: -1%}", "tolerances.cw.mass: must not be negative"),
            ("{link.com: 1%}", "a percentage of bodies.link.com[1], which is zero"),
            ("{cw.mass: {uniform: 1%, normal: 2}}", "normal"),
            ("{cw.mass: [1, 2]}", "tolerances.cw.mass: expected"),
            ("{cw.mass: 1%, counterweights.cw.mass: 2%}", "each number only once"),
            ("3", "tolerances: expected numbers"),
        ):
            spec = self.write("s.yaml", pendulum(tolerances))
            for command in (["tolerance"], ["check"]):
                self.assert_failure(run(*command, spec), 3, "s.yaml:12:", wanted)
        whole = self.write("s.yaml", pendulum("{}").replace("tolerances: {}\n", ""))
        self.assert_failure(run("tolerance", whole), 3, "tolerances: missing")
        self.assert_failure(run("tolerance", ARM, "--of", "torqe"), 2, "nearest is 'torque'")
        self.assert_failure(run("tolerance", ARM, "-t", "cycle"), 2, "nearest is 'cycloid'")

    def test_the_file_has_deviations_of_every_sample(self):
        """Against differences of two runs with another length."""
        spec = self.write("s.yaml", pendulum("{r: 1e-3}"))
        self.assert_quiet_success(run("tolerance", spec, "-o", self.path("t.h5")))
        for name, r in (("more", 0.4 + 1e-5), ("less", 0.4 - 1e-5)):
            self.assert_quiet_success(run("simulate", spec, "--set", f"r={r!r}", "-o", self.path(name + ".h5"), "-q"))
        with h5py.File(self.path("t.h5")) as told, h5py.File(self.path("more.h5")) as more, \
                h5py.File(self.path("less.h5")) as less:
            self.assertEqual(list(told["tolerance/numbers/number"].asstr()), ["parameters.r"])
            for name in ("torque", "shaking_force", "joint_force", "com_position", "kinetic_energy"):
                slope = (more[name][:] - less[name][:]) / 2e-5
                left = abs(told["tolerance"][name][:] - 1e-3 * abs(slope)).max()
                self.assertLess(left, 1e-7 * 1e-3 * max(1, abs(slope).max()), name)
        self.assert_failure(run("tolerance", spec, "-o", self.path("t.h5")), 5, "exists")

    def test_a_name_beats_a_pattern(self):
        told = self.told(self.write("s.yaml", pendulum('{"*.mass": 1%, link.mass: 0.1}')))
        self.assertEqual({n["path"]: n["deviation"] for n in told["numbers"]},
                         {"bodies.link.mass": 0.1, "counterweights.cw.mass": 0.005})


def moved_mass(line, step):
    """The same line with another mass."""
    head, tail = line.split("mass:", 1)
    end = min(i for i in (tail.find(","), tail.find("}")) if i >= 0)
    value = tail[:end].strip().strip('"')
    return f'{head}mass: "{value} + ({step!r})"{tail[end:]}'


if __name__ == "__main__":
    unittest.main()
