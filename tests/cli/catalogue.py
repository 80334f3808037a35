"""Parts from catalogues: which row, how many, and where."""

import hashlib
import json
import math
import os
import unittest

import h5py
import numpy
from scipy.optimize import minimize

from _program import CONFIGS, Case, run

G = 9.81
STEP = int(os.environ.get("CATALOGUE_STEP", "100"))


def helical_springs(count, seed=1):
    """Tension springs by EN 13906-1: name, rate [N/m], free length [m], initial tension [N], longest length [m], mass [kg], price."""
    random = numpy.random.default_rng(seed)
    rows = []
    for i in range(count):
        wire, index, coils = random.uniform(0.8e-3, 2.6e-3), random.uniform(5, 11), random.integers(12, 70)
        mean = index * wire
        rate = 81.5e9 * wire**4 / (8 * mean**3 * coils)
        free = (coils + 1) * wire + 1.8 * (mean - wire)
        tension = math.pi * wire**3 * 1e8 * (1.2 - 0.05 * index) / (8 * mean)
        strength = (1980 - 740 * math.log10(wire * 1e3)) * 1e6
        largest = math.pi * wire**3 * 0.45 * strength / (8 * mean * (index + 0.5) / (index - 0.75))
        mass = 7850 * math.pi / 4 * wire**2 * math.pi * mean * (coils + 2)
        price = round(0.9 + 20 * coils * wire + 25 * mass, 2)
        rows.append((f"P{i:04}", rate, free, tension, free + (largest - tension) / rate, mass, price))
    return rows


def table(rows):
    text = "part,rate [N/mm],L0 [mm],F0 [N],Lmax [mm],mass [g],EUR\n"
    for name, rate, free, tension, longest, mass, price in rows:
        numbers = (rate * 1e-3, free * 1e3, tension, longest * 1e3, mass * 1e3, price)
        text += ",".join([name, *(repr(float(x)) for x in numbers)]) + "\n"
    return text


COLUMNS = "{stiffness: rate, free_length: L0, initial_tension: F0, longest_length: Lmax, mass: mass, price: EUR}"
# The arm of github.com/jay-j/virtual-counterweight: configs/published/virtual-counterweight.yaml
ARM = """\
space: planar
gravity: [0, -9.81]
{parameters}
ground: {{points: {{O: [0, 0], S: [{S}]}}}}
bodies: {{arm: {{mass: 0.467, com: [0.2045, 0], inertia: 0.00651, points: {{O: [0, 0], P: [{P}], E: [0.409, 0]}}}}}}
payloads: {{hand: {{body: arm, at: E, mass: 0.3272}}}}
joints: {{J: {{type: revolute, connects: [ground.O, arm.O]}}}}
springs:
  s: {spring}
{more}
actuators: [J]
workspace: {{joints: {{J: ["-43.4 * pi / 180", "53.6 * pi / 180"]}}, samples: 32}}
design: {design}
"""
ANGLES = numpy.linspace(-43.4, 53.6, 32) * math.pi / 180
WEIGHT = G * (0.467 * 0.2045 + 0.3272 * 0.409) * numpy.cos(ANGLES)
PLACES = """parameters:
  r: {free: [0.015, 0.09], start: 0.03}
  sx: {free: [-0.13, 0.13], start: 0.02}
  sy: {free: [0.11, 0.27], start: 0.2}
  cable: {free: [0, 0.3], start: 0.01}"""


def lengths(r, sx, sy):
    """Of the spring between (sx, sy) and the point at r of the arm at all angles, with the lever arms dl/dJ."""
    px, py = r * numpy.cos(ANGLES), r * numpy.sin(ANGLES)
    length = numpy.hypot(sx - px, sy - py)
    return length, (-(sx - px) * -py - (sy - py) * px) / length


def torque(row, r, sx, sy, cable=0.0, count=1):
    _, rate, free, tension, *_ = row
    length, arm = lengths(r, sx, sy)
    return WEIGHT + count * (tension + rate * (length - cable - free)) * arm


def rms(values):
    """Over the poses of a workspace, of which each counts as much."""
    return math.sqrt((values**2).mean())


class Catalogues(Case):
    def design(self, spec, *arguments, code=0):
        done = run("design", spec, "--json", *arguments)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout[:2000])
        return json.loads(done.stdout)

    def arm(self, rows, name="arm.yaml", count="", more="", design="{minimize: {rms: torque, over: workspace}}",
            parameters="", S="0.02, 0.2", P="0.04, 0", cable=""):
        self.write("springs.csv", table(rows))
        spring = f"{{between: [ground.S, arm.P], catalogue: springs.csv, columns: {COLUMNS}{count}{cable}}}"
        return self.write(name, ARM.format(parameters=parameters, S=S, P=P, spring=spring, more=more, design=design))

    def test_the_best_row_at_given_places_is_that_of_all(self):
        rows = helical_springs(300)
        got = self.design(self.arm(rows))
        fitting = [row for row in rows if within_travel(row, 0.04, 0.02, 0.2)]
        self.assertGreater(len(fitting), 10)  # a limit that excludes all or none would test nothing
        self.assertLess(len(fitting), 290)
        best = min(fitting, key=lambda row: rms(torque(row, 0.04, 0.02, 0.2)))
        part = got["parts"]["list"][0]
        self.assertEqual(part["part"], best[0])
        self.assertTrue(got["parts"]["proved"])
        self.assertEqual(got["optimality"], "proved-best")
        # the same trapezoidal sum, in another order
        self.assertAlmostEqual(got["objective"]["value"] / rms(torque(best, 0.04, 0.02, 0.2)), 1, delta=1e-9)

    def test_the_best_row_and_place_are_those_of_an_enumeration(self):
        """Of every hundredth of 1,300 rows; scripts/soak.d/catalogue takes all of them."""
        rows = helical_springs(1300)[::STEP]
        got = self.design(self.arm(rows, parameters=PLACES, S="sx, sy", P="r, 0", cable=", cable: cable"), "--seconds", "60" if STEP > 1 else "3600")
        best, part = enumerate_places(rows), got["parts"]["list"][0]
        found = got["objective"]["value"]
        self.assertEqual(got["optimality"], "proved-best", got["parts"])
        self.assertEqual(part["part"], best[1])
        # SLSQP and the descent of the search end near the same minimum, to the root of the machine's accuracy
        self.assertAlmostEqual(found / best[0], 1, delta=1e-5)
        self.assertLessEqual(got["parts"]["lower_bound"], best[0] * (1 + 1e-9))
        self.assertGreaterEqual(got["parts"]["lower_bound"], found * (1 - 1e-3))  # the gap of a proof
        row = next(row for row in rows if row[0] == part["part"])
        x = {number["path"].split(".")[1]: number["value"] for number in got["free_numbers"]}
        self.assertAlmostEqual(rms(torque(row, x["r"], x["sx"], x["sy"], x["cable"])) / found, 1, delta=1e-8)
        self.assertTrue(within_travel(row, x["r"], x["sx"], x["sy"], x["cable"], 1e-8))

    def test_two_springs_of_2000_rows_each_are_chosen_in_seconds_with_proof(self):
        rows = helical_springs(2000, seed=7)
        self.write("more.csv", table(helical_springs(2000, seed=8)))
        more = f"  t: {{between: [ground.T, arm.Q], catalogue: more.csv, columns: {COLUMNS}}}"
        spec = self.arm(rows, more=more, P="0.04, 0], Q: [0.03, -0.01", S="0.02, 0.2], T: [-0.06, 0.16")
        got = self.design(spec, "--seconds", "10")
        self.assertEqual(got["optimality"], "proved-best", got["parts"])
        # no pair of a sample is better
        second = helical_springs(2000, seed=8)
        pull = numpy.array([pulls(row, 0.04, 0.02, 0.2) for row in rows[::4]])
        other = numpy.array([pulls(row, 0.0316227766, -0.06, 0.16, lag=math.atan2(-0.01, 0.03)) for row in second[::4]])
        allowed = [i for i, row in enumerate(rows[::4]) if within_travel(row, 0.04, 0.02, 0.2)]
        others = [i for i, row in enumerate(second[::4])
                  if within_travel(row, 0.0316227766, -0.06, 0.16, lag=math.atan2(-0.01, 0.03))]
        least = min(((WEIGHT + pull[i] + other[others])**2).mean(1).min() for i in allowed)
        self.assertLessEqual(got["objective"]["lower_bound"], math.sqrt(least) * (1 + 1e-9))

    def test_parts_are_listed_with_their_sums_in_all_formats(self):
        rows = helical_springs(60)
        spec, h5 = self.arm(rows, count=", count: [1, 2]"), self.path("design.h5")
        got = self.design(spec, "--h5", h5)
        part = got["parts"]["list"][0]
        row = next(row for row in rows if row[0] == part["part"])
        self.assertIn(part["count"], (1, 2))
        self.assertAlmostEqual(got["parts"]["mass"], part["count"] * row[5], delta=1e-12)  # grams and back
        self.assertAlmostEqual(got["parts"]["price"], part["count"] * row[6], delta=1e-12)
        with open(self.path("springs.csv"), "rb") as file:
            self.assertEqual(part["sha256"], hashlib.sha256(file.read()).hexdigest())
        with h5py.File(h5) as file:
            self.assertEqual(file["parts/part"].asstr()[0], row[0])
            self.assertEqual(file["parts/count"][0], part["count"])
        done = run("design", spec)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(row[0], done.stdout)
        self.assertIn("all parts:", done.stdout)
        # one spring of twice the rate and initial tension pulls as two do
        best = min((rms(torque(one, 0.04, 0.02, 0.2, count=n)) for one in rows for n in (1, 2)
                    if within_travel(one, 0.04, 0.02, 0.2)))
        self.assertAlmostEqual(got["objective"]["value"] / best, 1, delta=1e-9)

    def test_price_is_an_objective_and_a_limit(self):
        rows = helical_springs(200, seed=3)
        fitting = [row for row in rows if within_travel(row, 0.04, 0.02, 0.2)]
        bound = sorted(rms(torque(row, 0.04, 0.02, 0.2)) for row in fitting)[9]
        got = self.design(self.arm(rows, design=f"{{minimize: price, subject_to: ['rms(torque, workspace) <= {bound!r}']}}"))
        cheapest = min(row[6] for row in fitting if rms(torque(row, 0.04, 0.02, 0.2)) <= bound)
        self.assertEqual(got["objective"]["value"], cheapest)
        self.assertEqual(got["optimality"], "proved-best")
        limit = sorted(row[6] for row in fitting)[len(fitting) // 3]
        got = self.design(self.arm(rows, design=f"{{minimize: {{rms: torque, over: workspace}}, subject_to: ['price <= {limit!r}']}}"))
        best = min(rms(torque(row, 0.04, 0.02, 0.2)) for row in fitting if row[6] <= limit)
        self.assertAlmostEqual(got["objective"]["value"] / best, 1, delta=1e-9)

    def test_the_written_spec_names_the_part(self):
        rows = helical_springs(40)
        spec, out = self.arm(rows, count=", count: [1, 3]"), self.path("out.yaml")
        got = self.design(spec, "-o", out)
        with open(out, encoding="utf-8") as file:
            self.assertIn(got["parts"]["list"][0]["part"], file.read())
        done = run("simulate", out, "--json", "--trajectory", "workspace")
        self.assertEqual(done.returncode, 0, done.stderr)
        metrics = {metric["quantity"]: metric for metric in json.loads(done.stdout)["metrics"]}
        self.assertAlmostEqual(metrics["torque[J]"]["rms"] / got["objective"]["value"], 1, delta=1e-9)

    def test_a_spring_with_initial_tension_pulls_with_it_and_goes_slack(self):
        """T = F0 + k (l - l0) above the free length and 0 below it, in both formulations."""
        text = ARM.format(parameters="", S="0.02, 0.2", P="0.04, 0", more="", design="{minimize: {rms: torque, over: workspace}}",
                          spring="{between: [ground.S, arm.P], stiffness: 300, free_length: 0.19, initial_tension: 5, longest_length: 0.21}")
        text += "trajectories: {t: {law: cycloidal, drive: joints, duration: 1, samples: 201, from: {joints: {J: -0.7}}, to: {joints: {J: 0.9}}}}\n"
        for formulation in ("tree", "natural"):
            spec, out = self.write("slack.yaml", text.replace("design: {minimize: {rms: torque, over: workspace}}\n", "")), self.path("o.h5")
            done = run("simulate", spec, "-o", out, "--force", "--trajectory", "t", "--formulation", formulation)
            self.assertEqual(done.returncode, 0, done.stderr)
            with h5py.File(out) as file:
                q, acceleration = file["joint_position"][:, 0], file["joint_acceleration"][:, 0]
                got = file["torque"][:, 0]
            px, py = 0.04 * numpy.cos(q), 0.04 * numpy.sin(q)
            length = numpy.hypot(0.02 - px, 0.2 - py)
            arm = (-(0.02 - px) * -py - (0.2 - py) * px) / length
            tension = numpy.where(length > 0.19, 5 + 300 * (length - 0.19), 0)
            self.assertTrue((tension == 0).any() and (tension > 0).any())
            inertia = 0.00651 + 0.467 * 0.2045**2 + 0.3272 * 0.409**2
            expected = inertia * acceleration + G * (0.467 * 0.2045 + 0.3272 * 0.409) * numpy.cos(q) + tension * arm
            self.assertLess(abs(got - expected).max(), 1e-11 * abs(expected).max())
            self.assertIn("longer than its longest length", done.stdout + done.stderr)
        done = run("check", self.path("slack.yaml"), "--verify")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_counterweights_of_plates_and_gears_of_teeth(self):
        plates = "part,mass [kg],inertia [kg m^2],EUR\n" + "".join(
            f"D{d},{0.05 * d},{0.05 * d * (0.01 * d)**2 / 8},{d}\n" for d in range(1, 13))
        self.write("plates.csv", plates)
        text = """\
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {arm: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {O: [0, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, arm.O]}}
counterweights: {cw: {body: arm, at: [-0.07, 0], catalogue: plates.csv, columns: {mass: mass, inertia: inertia, price: EUR}, count: [1, 2, 3, 4]}}
actuators: [J]
workspace: {joints: {J: [-1, 1]}, samples: 21}
design: {minimize: {rms: torque, over: workspace}}
"""
        got = self.design(self.write("plates.yaml", text))
        part = got["parts"]["list"][0]
        # 1 kg at 0.1 m needs 1.43 kg at 0.07 m: 1.4 or 1.45 kg of n equal plates of 0.05 d kg
        best = min(abs(1 * 0.1 - 0.07 * n * 0.05 * d) for d in range(1, 13) for n in (1, 2, 3, 4))
        found = abs(0.1 - 0.07 * part["count"] * part["mass"])
        self.assertAlmostEqual(found, best, delta=1e-12)
        self.assertEqual(got["optimality"], "proved-best")
        wheels = "part,z1,z2,EUR\n" + "".join(f"{a}/{b},{a},{b},{a + b}\n" for a in range(18, 40, 3) for b in range(20, 60, 4))
        self.write("gears.csv", wheels)
        text = """\
space: planar
gravity: [0, 0]
ground: {points: {O: [0, 0], Q: [0.2, 0]}}
bodies:
  a: {mass: 1, com: [0, 0], inertia: 0.03, points: {O: [0, 0]}}
  b: {mass: 1, com: [0, 0], inertia: 0.02, points: {Q: [0, 0]}}
joints: {A: {type: revolute, connects: [ground.O, a.O]}, B: {type: revolute, connects: [ground.Q, b.Q]}}
couplings: [{joint: B, follows: A, catalogue: gears.csv, columns: {teeth_of_leader: z1, teeth: z2}}]
actuators: [A]
trajectories: {t: {law: cycloidal, drive: joints, duration: 1, samples: 101, from: {joints: {A: 0}}, to: {joints: {A: 2}}}}
design: {minimize: {peak: shaking_moment, along: t}}
"""
        got = self.design(self.write("gears.yaml", text))
        # the shaking moment is (0.03 - 0.02 z1/z2) A'', least for z1/z2 nearest to 1.5
        a, b = map(int, got["parts"]["list"][0]["part"].split("/"))
        best = min(abs(0.03 - 0.02 * p / q) for p in range(18, 40, 3) for q in range(20, 60, 4))
        self.assertAlmostEqual(abs(0.03 - 0.02 * a / b), best, delta=1e-12)

    def test_mistakes_are_told_with_line_and_column(self):
        rows = helical_springs(5)
        good = table(rows)
        lines = good.splitlines()
        cases = [
            (good.replace("F0 [N]", "F0 [m]"), "unit of initial_tension"),
            (good.replace("rate [N/mm]", "speed"), "'rate'"),
            (lines[0] + "\n", "at least one row"),
            ("", "empty"),
            (good.replace(lines[2].split(",")[1], "soft"), "line 3, column 'rate'"),
            (good.replace(lines[2].split(",")[1], "-1"), "a number ≥ 0"),
            (good.replace("P0003", "P0001"), "also in line 3"),
            (good + "P9,1,2\n", "expected 7 fields"),
            (good + 'P9,"1,2,3,4,5,6\n', "no end"),
            (good.replace(",", ";"), "commas"),
            (good.replace("P0001", "P\0001"), "UTF-8"),
        ]
        for text, message in cases:
            spec = self.arm(rows)
            self.write("springs.csv", text)
            done = run("check", spec)
            self.assert_failure(done, 3, "springs.s", message)
        spec = self.arm(rows)
        with open(self.path("springs.csv"), "wb") as file:
            file.write(good.replace("P0001", "Ä1").encode("latin-1"))
        self.assert_failure(run("check", spec), 3, "springs.s", "UTF-8")
        with open(self.arm(rows), encoding="utf-8") as file:
            text = file.read().replace("stiffness: rate", "stiffness: {column: rate, unit: N/m}")
        spec = self.write("two.yaml", text)
        self.assert_failure(run("check", spec), 3, "springs.s", "'N/mm' in the file and 'N/m' in 'columns'")
        os.remove(self.path("springs.csv"))
        self.assert_failure(run("check", spec), 3, "springs.s.catalogue", "a file next to the spec")

    def test_configs_of_the_project(self):
        for name in ("stock-spring-arm.yaml",):
            got = self.design(os.path.join(CONFIGS, name))
            self.assertEqual(got["optimality"], "proved-best", name)


def within_travel(row, r, sx, sy, cable=0.0, tolerance=0.0, lag=0.0):
    _, _, free, _, longest, *_ = row
    angles = ANGLES + lag
    length = numpy.hypot(sx - r * numpy.cos(angles), sy - r * numpy.sin(angles)) - cable
    return length.min() >= free - tolerance and length.max() <= longest + tolerance


def pulls(row, r, sx, sy, lag=0.0):
    """Torques of a spring at a point of the arm that lags by an angle."""
    _, rate, free, tension, *_ = row
    px, py = r * numpy.cos(ANGLES + lag), r * numpy.sin(ANGLES + lag)
    length = numpy.hypot(sx - px, sy - py)
    return (tension + rate * (length - free)) * (-(sx - px) * -py - (sy - py) * px) / length


def enumerate_places(rows, starts=2, polished=12):
    """(rms, name) of the best row: Levenberg-Marquardt from several places for every row at once, travel as a penalty,
    and the best ones with all limits by SLSQP."""
    random = numpy.random.default_rng(5)
    lower, upper = numpy.array([0.015, -0.13, 0.11, 0.0]), numpy.array([0.09, 0.13, 0.27, 0.3])
    _, rate, free, tension, longest, _, _ = (numpy.repeat(numpy.array(column), starts) for column in zip(*rows))
    x = lower + (upper - lower) * random.random((len(rate), 4)) * [1, 1, 1, 0.2]
    def residuals(x):
        px, py = x[:, :1] * numpy.cos(ANGLES), x[:, :1] * numpy.sin(ANGLES)
        length = numpy.hypot(x[:, 1:2] - px, x[:, 2:3] - py)
        own = length - x[:, 3:]
        arm = (-(x[:, 1:2] - px) * -py - (x[:, 2:3] - py) * px) / length
        y = (WEIGHT + (tension[:, None] + rate[:, None] * (own - free[:, None])) * arm) / math.sqrt(32)
        outside = (numpy.maximum(own.max(1) - longest, 0), numpy.maximum(free - own.min(1), 0))
        return numpy.column_stack([y, *(20 * one for one in outside)])

    y, damping = residuals(x), numpy.full(len(x), 1e-3)
    for _ in range(40):
        step = 1e-6 * (upper - lower)
        slopes = numpy.stack([(residuals(x + step * (numpy.arange(4) == j)) - y) / 1e-6 for j in range(4)], 2)
        downhill = -numpy.einsum("rij,ri->rj", slopes, y)
        slopes *= ~((x <= lower) & (downhill < 0) | (x >= upper) & (downhill > 0))[:, None, :]
        normal = numpy.einsum("rij,rik->rjk", slopes, slopes) + damping[:, None, None] * numpy.eye(4)
        move = numpy.linalg.solve(normal, -numpy.einsum("rij,ri->rj", slopes, y)[:, :, None])[:, :, 0]
        trial = numpy.clip(x + move * (upper - lower), lower, upper)
        new = residuals(trial)
        better = (new**2).sum(1) < (y**2).sum(1)
        x[better], y[better] = trial[better], new[better]
        damping = numpy.where(better, damping * 0.3, damping * 4).clip(1e-13, 1e5)
    best, tried = (math.inf, ""), set()
    for k in numpy.argsort((y**2).sum(1)):
        row = rows[k // starts]
        if row[0] in tried:
            continue
        tried.add(row[0])
        limits = [{"type": "ineq", "fun": lambda y, row=row: 100 * (row[4] - (lengths(*y[:3])[0] - y[3]))},
                  {"type": "ineq", "fun": lambda y, row=row: 100 * (lengths(*y[:3])[0] - y[3] - row[2])}]
        done = minimize(lambda y, row=row: 100 * rms(torque(row, *y)), x[k], method="SLSQP", bounds=list(zip(lower, upper)),
                        constraints=limits, options={"maxiter": 300, "ftol": 1e-13})
        if within_travel(row, *done.x, tolerance=1e-7):
            best = min(best, (done.fun / 100, row[0]))
        if len(tried) == polished:
            return best
    return best


if __name__ == "__main__":
    unittest.main()
