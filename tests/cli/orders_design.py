"""Goals, objectives and limits on orders: against textbooks' numbers, hand-made optima, and finite differences of simulated orders."""

import json
import math
import random
import unittest

import h5py

from _program import Case, config, run, unwrapped
from _sampling import draw

SINGLE, FOUR, TWIN, RADIAL = (f"machines/{name}.yaml" for name in
                              ("single-cylinder-design", "inline-four-lanchester", "v-twin-design", "radial-three-design"))
OMEGA = 100 * math.pi


class OrdersCase(Case):
    def answer(self, *arguments, codes=(0, 1)):
        done = run(*arguments, "--json")
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def design(self, text, *arguments):
        """The answer, its free numbers by name, and the file of the designed spec."""
        name, designed = self.write("spec.yaml", text), self.path("designed.yaml")
        answer = self.answer("design", name, "-o", designed, "--force", *arguments)
        return answer, {number["path"]: number["value"] for number in answer["free_numbers"]}, designed

    def simulated(self, spec, highest, *arguments):
        rows = self.answer("simulate", spec, "--orders", str(highest), *arguments)["orders"]["rows"]
        return {(row["quantity"], row["component"], row["order"]): row for row in rows}


class Engines(OrdersCase):
    def test_a_single_cylinder_with_shafts(self):
        answer, numbers, designed = self.design(config(SINGLE))
        self.assertEqual(answer["status"], "balanced")
        expected = {"counterweights.cw.mass": 0.01675 / 0.02, "discs.b1.eccentricity": 0.00925 / 0.5,
                    "discs.b2.eccentricity": 5.874329103348804e-4 / 0.2, "discs.b3.eccentricity": 5.874329103348804e-4 / 0.2}
        for path, value in expected.items():
            self.assertAlmostEqual(numbers[path], value, delta=1e-9 * value)
        found, before = self.simulated(designed, 6), self.simulated(self.path("spec.yaml"), 6)
        for order in (1, 2):
            self.assertLess(found[("shaking_force", "", order)]["amplitude"], 1e-9 * before[("shaking_force", "", order)]["amplitude"])
        for order, left in {4: 7.482646171, 6: 0.1358069514}.items():
            self.assertAlmostEqual(found[("shaking_force", "", order)]["amplitude"], left, delta=1e-9 * left)
        self.assertAlmostEqual(found[("shaking_moment", "", 1)]["amplitude"], 56.51931535, delta=1e-8 * 56.5)
        peak = {m["quantity"]: m["peak"] for m in self.answer("simulate", designed)["metrics"]}["shaking_force"]
        self.assertAlmostEqual(peak, 7.620931267, delta=1e-9)  # the sum of all orders from 4, at a right angle

    def test_the_conditions_of_a_single_cylinder(self):
        spec = self.write("spec.yaml", config(SINGLE))
        conditions = self.answer("conditions", spec)
        self.assertEqual(conditions["rank"], 8)  # orders 1 and 2, forward and backward, cosine and sine
        motion = conditions["orders"]["motions"][0]
        self.assertEqual((motion["trajectory"], motion["coordinate"], motion["turns"]), ("steady", "A", 1))
        self.assertLess(motion["spectral_error"], 1e-12)
        simulated = self.simulated(spec, 2)
        for row in conditions["orders"]["rows"]:
            part = simulated[("shaking_force", row["quantity"][-2], row["order"])]
            size = simulated[("shaking_force", "", row["order"])]["amplitude"]
            self.assertAlmostEqual(row["amplitude"], part["cosine" if row["harmonic"] == "cos" else "sine"], delta=1e-9 * size)
        always = {(row["quantity"], row["order"], row["harmonic"]) for row in conditions["orders"]["rows"] if row["always_zero"]}
        self.assertEqual(always, set())  # the shafts have sines and cosines of both orders
        text = unwrapped(run("conditions", spec).stdout)
        for part in ("order 1 of shaking_force[x]", "order 2 of shaking_force[y]", "A makes 1 turn"):
            self.assertIn(part, text)

    def test_order_four_follows_from_order_two(self):
        """One rod has a single sum that shakes along the cylinder in all even orders, and one across: two conditions, however many orders."""
        spec = self.write("spec.yaml", config("machines/single-cylinder.yaml", ("counterweights:.*?\n\n", ""), ("discs:.*?\n\n", "")))
        for orders, rank in (("2", 2), ("4", 2), ("8", 2)):
            conditions = self.answer("conditions", spec, "--goal", f"order {orders} of shaking_force along steady")
            self.assertEqual(conditions["rank"], rank)
        both = self.answer("conditions", spec, "--goal", "order 2 of shaking_force along steady", "--goal", "order 4 of shaking_force along steady",
                           "--goal", "order 8 of shaking_force along steady")
        self.assertEqual(both["rank"], 2)
        odd = self.answer("conditions", spec, "--goal", "order 3 of shaking_force along steady")
        self.assertEqual(odd["rank"], 0)
        self.assertTrue(all(row["always_zero"] for row in odd["orders"]["rows"]))
        # at any speed nothing may be left: the orders are combinations of the conditions of the force
        force = self.answer("conditions", spec, "--goal", "force")["rank"]
        with_orders = self.answer("conditions", spec, "--goal", "force", "--goal", "order 1 of shaking_force along steady",
                                  "--goal", "order 6 of shaking_force along steady")
        self.assertEqual(with_orders["rank"], force)

    def test_an_inline_four_with_lanchester_shafts(self):
        answer, numbers, designed = self.design(config(FOUR))
        self.assertEqual(answer["status"], "balanced")
        for shaft in ("b1", "b2"):
            self.assertAlmostEqual(0.6 * numbers[f"discs.{shaft}.eccentricity"], 3545.64819 / (8 * OMEGA**2), delta=1e-9 * 0.0045)
            self.assertAlmostEqual(math.cos(numbers[f"discs.{shaft}.phase"]), -1, delta=1e-9)
        found = self.simulated(designed, 4)
        self.assertLess(found[("shaking_force", "", 2)]["amplitude"], 1e-9 * 3545)
        self.assertAlmostEqual(found[("shaking_force", "", 4)]["amplitude"], 83.5768281, delta=1e-8 * 83.6)

    def test_a_v_twin(self):
        answer, numbers, designed = self.design(config(TWIN))
        self.assertEqual(answer["status"], "balanced")
        self.assertAlmostEqual(0.04 * numbers["counterweights.cw.mass"], 6884.04907 / OMEGA**2, delta=1e-9 * 0.07)
        for shaft in ("b1", "b2"):
            self.assertAlmostEqual(0.01 * numbers[f"discs.{shaft}.mass"], 1253.57594 / (8 * OMEGA**2), delta=1e-8 * 0.0016)
        found = self.simulated(designed, 4)
        for order in (1, 2):
            self.assertLess(found[("shaking_force", "", order)]["amplitude"], 1e-9 * 6884)
        self.assertAlmostEqual(found[("shaking_force", "x", 4)]["amplitude"], 29.5488709, delta=1e-8 * 29.5)

    def test_a_radial_engine_with_the_fewest_shafts(self):
        answer, numbers, designed = self.design(config(RADIAL))
        self.assertEqual(answer["status"], "balanced")
        self.assertEqual(answer["chosen"]["choices"][0]["kept"], ["s3"])
        self.assertTrue(answer["chosen"]["least_proved"])
        self.assertAlmostEqual(numbers["counterweights.cw.mass"] / 0.45359237, 4.285714286, delta=1e-9 * 4.3)
        self.assertAlmostEqual(0.02 * numbers["discs.s3.mass"], 1208.195 / (4 * (50 * math.pi) ** 2), delta=1e-6 * 0.0122)
        found = self.simulated(designed, 4)
        self.assertLess(max(found[("shaking_force", "", order)]["amplitude"] for order in (1, 2, 3)), 1e-9 * 4264)
        self.assertAlmostEqual(found[("shaking_force", "", 4)]["amplitude"], 24.25, delta=0.005)

    def test_forward_and_backward_parts(self):
        """A counterweight on the crank changes the forward part of order 1 alone, a shaft against it the backward part alone."""
        text = config(RADIAL, ("  goal: .*?\n", "  goal: {orders: {shaking_force: {forward: [1], backward: [2]}}, along: steady}\n"))
        answer, numbers, _ = self.design(text)
        self.assertEqual((answer["status"], answer["conditions"] and len(answer["conditions"])), ("balanced", 4))
        self.assertAlmostEqual(numbers["counterweights.cw.mass"] / 0.45359237, 4.285714286, delta=1e-9 * 4.3)
        # the other parts of a radial engine vanish by themselves
        others = self.answer("conditions", self.write("bare.yaml", config("machines/radial-three.yaml")),
                             "--goal", "backward order 1 of shaking_force along steady",
                             "--goal", "forward order 2 of shaking_force along steady")
        sizes = [abs(row["amplitude"]) for row in others["orders"]["rows"]]
        self.assertLess(max(sizes), 1e-9 * 4264)

    def test_a_ratio_among_integers(self):
        """Of one shaft with a ratio from a list, only that at twice the speed against the crank can remove order 2."""
        shafts = ("discs:\n.*?\n\n", "discs:\n  s: {body: ground, at: [0, 0], follows: A, ratio: {free: {values: [-3, -2, -1, 1, 2, 3]}}, "
                  "mass: {free: [0, 2]}, eccentricity: 0.02, phase: pi, inertia: 0}\n\n")
        answer, numbers, designed = self.design(config(RADIAL, shafts, ("  choose: .*?\n", "")))
        self.assertEqual((answer["status"], numbers["discs.s.ratio"]), ("balanced", -2))
        self.assertLess(self.simulated(designed, 2)[("shaking_force", "", 2)]["amplitude"], 1e-9 * 1208)

    def test_an_impossible_goal_says_why(self):
        """Without a shaft against the crank the backward order 1 of one cylinder stays: no masses above zero change it."""
        text = config(SINGLE, ("discs:.*?\n\n", ""), (r"shaking_force: .1, 2.", "shaking_force: [1]"))
        answer = self.answer("design", self.write("spec.yaml", text))
        self.assertEqual(answer["status"], "impossible")
        self.assertTrue(answer["proof"]["sentence"])

    def test_torque_orders(self):
        """Orders of the torque are linear in the masses, too, and equal those of simulate."""
        spec = self.write("spec.yaml", config(SINGLE, (r"\{orders: .*?steady\}", "{orders: {\"torque[A]\": [1, 2, 3, 4], shaking_moment: [1, 3]}, along: steady}")))
        rows = self.answer("conditions", spec)["orders"]["rows"]
        simulated = self.simulated(spec, 4)
        self.assertEqual(len(rows), 12)
        for row in rows:
            part = simulated[(row["quantity"], "", row["order"])]
            self.assertAlmostEqual(row["amplitude"], part["cosine" if row["harmonic"] == "cos" else "sine"], delta=1e-9 * 40)

    def test_gas_pressure_and_friction_are_known_terms(self):
        """A closed spline over the crank's angle has orders that fall as the fourth power: as many samples give nine digits."""
        loads = ("(actuators: )", "loads:\n  gas: {body: piston, over: A, table: [[0, -100, 0], [1, -40, 0], [3, -10, 0], [5, -30, 0]], period: turn, "
                 "interpolation: spline}\nfriction: {A: {viscous: 0.01}}\nactuators: ")
        goal = ("goal: .*?\n", "goal: {orders: {\"torque[A]\": [1, 2], ground_force: [1]}, along: steady}\n")
        spec = self.write("spec.yaml", config(SINGLE, loads, goal))
        simulated = self.simulated(spec, 2, "--samples", "8193")
        for row in self.answer("conditions", spec)["orders"]["rows"]:
            name, component = (row["quantity"], "") if row["quantity"] == "torque[A]" else (row["quantity"][:-3], row["quantity"][-2])
            part = simulated[(name, component, row["order"])]["cosine" if row["harmonic"] == "cos" else "sine"]
            self.assertAlmostEqual(row["amplitude"], part, delta=1e-9 * 2000)

    def test_hdf5_and_the_written_spec(self):
        file = self.path("design.h5")
        _, _, designed = self.design(config(SINGLE), "--h5", file)
        with h5py.File(file) as data:
            group = data["orders"]
            self.assertEqual(len(group["order_row"]), 8)
            self.assertEqual(sorted(set(group["order"][:])), [1, 2])
            self.assertLess(max(abs(group["amplitude"][:])), 1e-9 * 2566)
        check = self.answer("conditions", designed)
        self.assertTrue(all(one["met"] for one in check["conditions"]))


class Figures(OrdersCase):
    BARE = (("discs:.*?\n\n", ""), ("  goal: .*?\n", "{}"))
    X, Y = 2566.097144, 740.2203301  # order 1 of the cylinder without a counterweight

    def test_the_least_order_one_with_a_counterweight_alone(self):
        """The forward part can be removed, the backward part (X - Y)/2 stays."""
        for figure, value in (("{order: 1, of: shaking_force, along: steady}", (self.X - self.Y) / 2), ("order(1, shaking_force[y], steady)", 0),
                              ("forward_order(1, shaking_force, steady)", 0)):
            answer, _, designed = self.design(config(SINGLE, self.BARE[0], ("  goal: .*?\n", f"  minimize: {json.dumps(figure) if '(' in figure else figure}\n")))
            self.assertEqual(answer["optimality"], "proved-best")
            self.assertAlmostEqual(answer["objective"]["value"], value, delta=1e-7 * self.X)
        row = self.simulated(designed, 1)[("shaking_force", "", 1)]
        self.assertAlmostEqual(row["amplitude"], (self.X - self.Y) / 2, delta=1e-6 * self.X)

    def test_a_limit_on_an_order(self):
        """The least counterweight that keeps order 1 along the cylinder below 2000 N, by hand (X - 2000)/(0.02 omega^2)."""
        answer, numbers, _ = self.design(config(SINGLE, self.BARE[0], ("  goal: .*?\n", "  minimize: added-mass\n  subject_to: [\"order(1, shaking_force[x], steady) <= 2000\"]\n")))
        self.assertEqual(answer["optimality"], "proved-best")
        self.assertAlmostEqual(numbers["counterweights.cw.mass"], (self.X - 2000) / (0.02 * OMEGA**2), delta=1e-6)
        self.assertEqual(answer["constraints"][0]["unit"], "N")
        self.assertAlmostEqual(answer["constraints"][0]["value"], 2000, delta=1e-3)

    def test_a_front_of_orders(self):
        front = "  front: [\"order(1, shaking_force[x], steady)\", \"order(1, shaking_force[y], steady)\"]\n  search: {seconds: 20}\n"
        answer = self.answer("design", self.write("spec.yaml", config(SINGLE, self.BARE[0], ("  goal: .*?\n", front))))
        points = answer["front"]["points"]
        self.assertGreater(len(points), 2)
        self.assertTrue(all(a["values"][0] < b["values"][0] and a["values"][1] > b["values"][1] for a, b in zip(points, points[1:])))

    def test_load_cases(self):
        """One shaft pair for pistons of two masses: impossible as a goal; the least worst order lies between the two needs."""
        cases = ("  goal: .*?\n", "  minimize: {order: 2, of: \"shaking_force[x]\", along: steady}\n  for: {\"piston.mass\": [0.35, 0.45]}\n")
        answer, _, _ = self.design(config(SINGLE, cases))
        single = self.answer("conditions", self.write("one.yaml", config(SINGLE)))
        change = 0.1 * 0.04 * 0.2540250423069753 * OMEGA**2  # of order 2 between the two pistons
        self.assertAlmostEqual(answer["objective"]["value"], change / 2, delta=1e-6 * change)
        self.assertTrue(single["orders"]["rows"])
        goal = ("  goal: (.*?)\n", "  goal: {orders: {shaking_force: [1, 2]}, along: steady}\n  for: {\"piston.mass\": [0.35, 0.45]}\n")
        refused = self.answer("design", self.write("two.yaml", config(SINGLE, goal)))
        self.assertEqual(refused["status"], "impossible")

    def test_half_orders(self):
        """A shaft at half the speed over two turns has the order 1/2 alone, which its counterpart removes."""
        discs = ("discs:.*?\n\n", """discs:
  h: {body: ground, at: [0, 0.06], follows: A, ratio: 1/2, mass: 0.5, eccentricity: 0.01, phase: 0, inertia: 1.0e-4}
  g: {body: ground, at: [0, 0.06], follows: A, ratio: 0.5, mass: {free: [0, 1]}, eccentricity: 0.02, phase: pi, inertia: 1.0e-4}

""")
        text = config(SINGLE, discs, ("mass: .free: .0, 2..", "mass: 0.8"), ("speed: .A: omega.", "speed: {A: omega}, turns: 2"),
                      ("  goal: .*?\n", "  goal: {orders: {shaking_force: [1/2]}, along: steady}\n"))
        answer, numbers, _ = self.design(text)
        self.assertEqual(answer["status"], "balanced")
        self.assertAlmostEqual(numbers["discs.g.mass"], 0.25, delta=1e-9)

    def test_fluctuation_and_quality(self):
        flywheel = ("discs:.*?\n\n", "discs:\n  wheel: {body: crank, at: [0, 0], follows: A, inertia: {free: [0, 5]}}\n\n")
        text = config(SINGLE, flywheel, ("mass: .free: .0, 2..", "mass: 0.8"),
                      ("  goal: .*?\n", "  minimize: added-inertia\n  subject_to: [fluctuation(steady) <= 0.01]\n"))
        answer, _, designed = self.design(text)
        told = self.answer("simulate", designed, "--orders", "2")["orders"]["fluctuation"]
        self.assertAlmostEqual(told["coefficient"], 0.01, delta=1e-6)
        before = self.answer("simulate", self.write("bare.yaml", text.replace("{free: [0, 5]}", "0")), "--orders", "2", "--fluctuation", "0.01")
        self.assertAlmostEqual(4 * answer["free_numbers"][0]["value"], before["orders"]["fluctuation"]["flywheel"], delta=1e-4)  # it turns at twice the speed
        rotor = config("machines/rotor-two-planes.yaml", ("design:.*", "design: {minimize: added-mass, subject_to: [\"quality(shaft, turn) <= 2.5\"]}\n"))
        answer, _, designed = self.design(rotor)
        quality = self.answer("check", designed)["rotors"][0]["qualities"][0]
        self.assertLessEqual(quality["quality"], 2.5 * (1 + 1e-6))


class Laws(OrdersCase):
    """On random loops: rows equal finite differences of simulated orders by every mass number, and a design removes its order."""

    def loop(self, seed):
        """A planar crank-rocker or a slider-crank off its line, turned uniformly, with masses that are parameters."""
        rng = random.Random(seed)
        r, l, off = rng.uniform(0.03, 0.06), rng.uniform(0.15, 0.25), rng.uniform(-0.03, 0.03)
        numbers = {"m1": rng.uniform(0.5, 2), "x1": rng.uniform(-0.02, 0.02), "y1": rng.uniform(-0.02, 0.02), "m2": rng.uniform(0.3, 1),
                   "x2": rng.uniform(0, l), "y2": rng.uniform(-0.02, 0.02), "j2": rng.uniform(0.01, 0.03), "m3": rng.uniform(0.2, 1)}
        parameters = ", ".join(f"{name}: {value!r}" for name, value in numbers.items())
        if rng.random() < 0.5:
            tail = f"  rocker: {{mass: m3, com: [0.05, 0.01], inertia: 0.01, points: {{C: [0, 0], D: [0.2, 0]}}}}"
            joints = ("  C: {type: revolute, connects: [rod.C, rocker.C]}\n  D: {type: revolute, connects: [ground.D, rocker.D]}")
            assembly = "{A: 0, B: 0.7}"
            ground = f"D: [{rng.uniform(0.18, 0.2)!r}, 0]"
        else:
            tail = "  slide: {mass: m3, com: [0, 0], inertia: 0.001, points: {C: [0, 0]}}"
            joints = f"  C: {{type: revolute, connects: [rod.C, slide.C]}}\n  S: {{type: prismatic, connects: [ground.D, slide.C], axis: [1, 0]}}"
            assembly = f"{{A: 0, B: 0, S: {l + r!r}}}"
            ground = f"D: [0, {off!r}]"
        return numbers, f"""name: loop
space: planar
gravity: [0, -9.81]
parameters: {{{parameters}}}
ground: {{points: {{O: [0, 0], {ground}}}}}
bodies:
  crank: {{mass: m1, com: [x1, y1], inertia: 0.001, points: {{O: [0, 0], P: [{r!r}, 0]}}}}
  rod: {{mass: m2, com: [x2, y2], inertia: j2, points: {{P: [0, 0], C: [{l!r}, 0]}}}}
{tail}
joints:
  A: {{type: revolute, connects: [ground.O, crank.O]}}
  B: {{type: revolute, connects: [crank.P, rod.P]}}
{joints}
discs:
  b: {{body: ground, at: [0.1, 0.05], follows: A, ratio: -1, mass: 0.4, eccentricity: 0.01, phase: 0.3, inertia: 1.0e-4}}
actuators: [A]
assembly: {assembly}
trajectories:
  run: {{drive: joints, speed: {{A: 60}}, samples: 257, from: {{joints: {{A: 0}}}}}}
design:
  goal: {{orders: {{shaking_force: [1, 2, 3], shaking_moment: [1, 2], "torque[A]": [1, 2], "joint_force[B]": [1]}}, along: run}}
"""

    def amplitudes(self, spec, *arguments):
        done = run("simulate", spec, "--orders", "3", "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return {(row["quantity"] + (f"[{row['component']}]" if row["component"] else ""), row["order"]): row
                for row in json.loads(done.stdout)["orders"]["rows"]}

    def test_rows_are_finite_differences(self):
        for seed in draw("loop", range(1, 41), 0.06):
            with self.subTest(seed=seed):
                numbers, text = self.loop(seed)
                spec = self.write(f"loop{seed}.yaml", text)
                rows = self.answer("conditions", spec)["orders"]["rows"]
                start = self.amplitudes(spec)
                # parameters of the rows: m, mx = m x, my = m y, J = J + m |c|^2; all are linear in each number of the spec
                inertial = lambda n: {"crank.m": n["m1"], "crank.mx": n["m1"] * n["x1"], "crank.my": n["m1"] * n["y1"],
                                      "crank.J": 0.001 + n["m1"] * (n["x1"] ** 2 + n["y1"] ** 2), "rod.m": n["m2"], "rod.mx": n["m2"] * n["x2"],
                                      "rod.my": n["m2"] * n["y2"], "rod.J": n["j2"] + n["m2"] * (n["x2"] ** 2 + n["y2"] ** 2)}
                for name in ("m1", "x1", "y1", "m2", "x2", "y2", "j2"):
                    changed = dict(numbers, **{name: numbers[name] + 0.01})
                    moved = self.amplitudes(spec, "--set", f"{name}={changed[name]!r}")
                    before, after = inertial(numbers), inertial(changed)
                    for row in rows:
                        key = (row["quantity"], row["order"])
                        part = "cosine" if row["harmonic"] == "cos" else "sine"
                        size = max(abs(one[key]["amplitude"]) for one in (start, moved)) + 1e-3
                        expected = 0 if row["always_zero"] else row["factor"] * sum(
                            term["coefficient"] * (after[term["parameter"]] - before[term["parameter"]])
                            for term in row["terms"] if term["parameter"] in before)
                        # the samples' own aliasing and round-off of the difference of two runs
                        self.assertAlmostEqual(moved[key][part] - start[key][part], expected, delta=1e-9 * size, msg=(name, row["quantity"], row["order"]))

    def test_amplitudes_are_those_of_runs(self):
        for seed in draw("loop amplitudes", range(1, 41), 0.1):
            with self.subTest(seed=seed):
                _, text = self.loop(seed)
                spec = self.write(f"loop{seed}.yaml", text)
                start = self.amplitudes(spec)
                for row in self.answer("conditions", spec)["orders"]["rows"]:
                    key = (row["quantity"], row["order"])
                    self.assertAlmostEqual(row["amplitude"], start[key]["cosine" if row["harmonic"] == "cos" else "sine"],
                                           delta=1e-9 * max(one["amplitude"] for (name, _), one in start.items() if name == row["quantity"]))


class Space(OrdersCase):
    GOAL = "design: {goal: {orders: {shaking_force: [1, 2], shaking_moment: [1, 3], \"torque[A]\": [1, 2], \"joint_force[S]\": [1]}, along: steady}}\n"
    WEIGHTS = ("counterweights:\n  cw: {body: crank, at: [0, 0, -0.05], mass: {free: [0, 5]}}\n"
               "  cx: {body: crank, at: [0.02, 0.05, 0], mass: {free: [0, 5]}}\n")

    def test_amplitudes_are_those_of_runs(self):
        spec = self.write("spec.yaml", config("spatial-slider-crank.yaml") + self.GOAL)
        rows = {(row["quantity"] + (f"[{row['component']}]" if row["component"] else ""), row["order"]): row
                for row in self.answer("simulate", spec, "--trajectory", "steady", "--orders", "3")["orders"]["rows"]}
        conditions = self.answer("conditions", spec)
        self.assertEqual(len(conditions["orders"]["rows"]), 2 * (3 * 2 + 3 * 2 + 2 + 3))
        for row in conditions["orders"]["rows"]:
            run_row = rows[(row["quantity"], row["order"])]
            self.assertAlmostEqual(row["amplitude"], run_row["cosine" if row["harmonic"] == "cos" else "sine"], delta=1e-9 * (run_row["amplitude"] + 0.1))

    def test_the_least_peak_of_an_order(self):
        """The larger singular value of an ellipse in space: no neighbour of the proved optimum is better."""
        text = config("spatial-slider-crank.yaml") + self.WEIGHTS + "design: {minimize: {order: 1, of: shaking_force, along: steady}}\n"
        answer, numbers, designed = self.design(text)
        best = answer["objective"]["value"]
        self.assertEqual(answer["optimality"], "proved-best")
        def peak(spec):
            found = self.answer("simulate", spec, "--trajectory", "steady", "--orders", "1")["orders"]["rows"]
            return next(row["amplitude"] for row in found if (row["quantity"], row["component"]) == ("shaking_force", ""))
        self.assertAlmostEqual(peak(designed), best, delta=1e-9 * best)
        for path, value in numbers.items():
            for step in (-0.01, 0.01):
                if not 0 <= value + step <= 5:
                    continue
                name = path.split(".")[1]
                moved = text
                for other, at in numbers.items():
                    moved = moved.replace("mass: {free: [0, 5]}", f"mass: {at + (step if other == path else 0)!r}", 1)
                self.assertGreaterEqual(peak(self.write(f"{name}.yaml", moved.split("design:")[0])), best * (1 - 1e-9))


class Mistakes(OrdersCase):
    def refuse(self, goal, *parts, changes=()):
        text = config(SINGLE, ("  goal: .*?\n", f"  goal: {goal}\n"), *changes)
        done = run("design", self.write("spec.yaml", text))
        self.assertEqual(done.returncode, 3 if parts[0] is not None else 4, done.stdout + done.stderr)
        for part in parts:
            if part is not None:
                self.assertIn(part, unwrapped(done.stderr))

    def test_mistakes_in_the_goal(self):
        self.refuse("{orders: {shaking_force: [1, 2]}}", "along")
        self.refuse("{orders: {shaking_farce: [1]}, along: steady}", "spec.yaml", "nearest is 'shaking_force'")
        self.refuse("{orders: {shaking_force: [0]}, along: steady}", "above 0")
        self.refuse("{orders: {shaking_force: [1, 1]}, along: steady}", "only once")
        self.refuse("{orders: {shaking_force: [1]}, along: stedy}", "nearest is 'steady'")
        self.refuse("{orders: {shaking_moment: {forward: [1]}}, along: steady}", "a force in the plane")
        self.refuse("{orders: {mobility: [1]}, along: steady}", "linear in the masses")
        self.refuse("{orders: {}, along: steady}", "at least one quantity")
        self.refuse("order 2 of shaking_force", "along")
        self.refuse("{orders: {shaking_force: [1]}, along: swing}", "cycloidal", changes=(
            ("(trajectories:\n)", "trajectories:\n  swing: {law: cycloidal, drive: joints, duration: 1, from: {joints: {A: 0}}, to: {joints: {A: 1}}}\n"),))

    def test_motions_without_the_order(self):
        """Refused when the motion is followed: the reason names it."""
        self.refuse("{orders: {shaking_force: [1/2]}, along: steady}", None, "no order 0.5")
        self.refuse("{orders: {shaking_force: [1]}, along: part}", None, "whole turns", changes=(
            ("(trajectories:\n)", "trajectories:\n  part: {law: uniform, drive: joints, duration: 1, from: {joints: {A: 0}}, to: {joints: {A: 1}}}\n"),))

    def test_mistakes_in_figures(self):
        for figure, part in (("order(2, shaking_force)", None), ("order(shaking_force)", "order(number, quantity, trajectory)"),
                             ("order(-1, shaking_force)", "above 0"), ("order(2, shaking_farce)", "nearest is"),
                             ("backward_order(1, shaking_moment)", "a vector in the plane"), ("quality(rod, steady)", "a rotor")):
            text = config(SINGLE, ("  goal: .*?\n", f"  minimize: \"{figure}\"\n"))
            done = run("check", self.write("spec.yaml", text))
            self.assertEqual(done.returncode, 0 if part is None else 3, done.stdout + done.stderr)
            if part:
                self.assertIn(part, unwrapped(done.stderr))
        text = config(SINGLE, ("  goal: .*?\n", "  minimize: \"order(200, shaking_force)\"\n"))
        done = run("design", self.write("spec.yaml", text))
        self.assertIn("needs at least 801 samples", unwrapped(done.stderr))


if __name__ == "__main__":
    unittest.main()
