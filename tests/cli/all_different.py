"""`all_different`: the order of cranks on a shaft, against every order simulated with --set; and what is refused."""

import itertools
import json
import random
import unittest

from _program import Case, config, run

ANGLES = (0, 90, 180, 270)
FREE = ", ".join(str(angle) for angle in ANGLES)


def engine(seed):
    """engines/crank-order.yaml with other places and pistons."""
    dice = random.Random(seed)
    text = config("engines/crank-order.yaml", ("samples: 73", "samples: 13"))
    for k, place in enumerate(("0.9", "0.3", "-0.3", "-0.9"), 1):
        text = text.replace(f"O{k}: [{place}, 0]", f"O{k}: [{float(place) + dice.uniform(-0.2, 0.2):.3f}, 0]")
        text = text.replace(f"piston{k}: {{mass: 1.5,", f"piston{k}: {{mass: {dice.uniform(1, 2.5):.3f},")
    return text


class Orders(Case):
    def design(self, name, *options):
        done = run("design", name, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def moment(self, name, angles):
        sets = [part for k, angle in enumerate(angles, 2) for part in ("--set", f"a{k}={angle}")]
        done = run("simulate", name, "--trajectory", "turn", "--json", *sets)
        self.assertEqual(done.returncode, 0, done.stderr)
        return next(metric["rms"] for metric in json.loads(done.stdout)["metrics"] if metric["quantity"] == "shaking_moment")

    def test_the_best_order_is_that_of_all_orders(self):
        for seed in range(1, 6):
            name = self.write(f"engine{seed}.yaml", engine(seed))
            design = self.design(name)
            values = [number["value"] for number in design["free_numbers"]]
            self.assertEqual(sorted(values), [90, 180, 270])
            self.assertEqual(design["all_different"], [["parameters.a2", "parameters.a3", "parameters.a4"]])
            orders = {order: self.moment(name, order) for order in itertools.permutations(ANGLES[1:])}
            self.assertAlmostEqual(design["objective"]["value"], min(orders.values()), delta=1e-9 * max(orders.values()))
            # round-off: the mirrored order is as good
            self.assertAlmostEqual(orders[tuple(values)], min(orders.values()), delta=1e-9 * max(orders.values()))
            self.assertEqual(design["optimality"], "proved-best")

    def test_set_takes_an_angle_from_the_others(self):
        name = self.write("engine.yaml", engine(1))
        design = self.design(name, "--set", "a3=90")
        values = [number["value"] for number in design["free_numbers"]]
        self.assertEqual(sorted(values), [180, 270])
        best = min((self.moment(name, (a2, 90, a4)), a2, a4) for a2, a4 in ((180, 270), (270, 180)))
        self.assertEqual(values, list(best[1:]))

    def test_equal_start_values_are_no_design(self):
        design = self.design(self.write("engine.yaml", engine(1)))
        equal = self.design(self.write("equal.yaml", engine(1).replace("start: 180", "start: 90").replace("start: 270", "start: 90")))
        self.assertEqual(sorted(number["value"] for number in equal["free_numbers"]), [90, 180, 270])
        self.assertAlmostEqual(equal["objective"]["value"], design["objective"]["value"], delta=1e-9 * design["objective"]["value"])

    def test_a_written_design_is_read_again(self):
        name, written = self.write("engine.yaml", engine(1)), self.path("written.yaml")
        design = self.design(name, "-o", written)
        done = run("simulate", written, "--trajectory", "turn", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        moments = [metric["rms"] for metric in json.loads(done.stdout)["metrics"] if metric["quantity"] == "shaking_moment"]
        self.assertAlmostEqual(moments[0], design["objective"]["value"], delta=1e-9 * moments[0])

    def test_the_text_says_it_once(self):
        done = run("design", self.write("engine.yaml", engine(1)))
        self.assertEqual(done.stdout.count("all different: parameters.a2, parameters.a3 and parameters.a4\n"), 1, done.stdout)

    def test_too_few_sizes_left_by_set_end_the_design_early(self):
        text = engine(1).replace(f"[{FREE}]}}, start: 270", "[90, 180]}, start: 180").replace(
            f"[{FREE}]}}, start: 180", "[90, 180]}, start: 90")
        done = run("design", self.write("engine.yaml", text), "--set", "a2=90")
        self.assert_failure(done, 3, "parameters.a3 and parameters.a4 have only 1 different size: 180")

    def test_what_cannot_be_asked_is_refused_where_it_is_written(self):
        for names, said in (
            ("[a1, a2, a3, b4]", "design.all_different[3]: expected a free number with sizes "
             "(parameters.a2, parameters.a3 or parameters.a4), found 'b4'; nearest is 'a4'"),
            ("[a2, a3, a2]", "design.all_different[2]: expected each number only once, found 'parameters.a2' again"),
            ("[[a2, a3], [a3, a4]]", "design.all_different[1][0]: expected each number only once, found 'parameters.a3' again"),
            ("[a2]", "design.all_different: expected at least two numbers, found one"),
            ("[a2, shaft]", "found 'shaft'"),
        ):
            text = engine(1).replace("all_different: [a1, a2, a3, a4]", f"all_different: {names}")
            self.assert_failure(run("check", self.write("engine.yaml", text)), 3, said)
        text = engine(1).replace(f"[{FREE}]", "[90, 180]").replace("start: 270", "start: 180")
        text = text.replace("[a1, a2, a3, a4]", "[a2, a3, a4]")
        self.assert_failure(run("check", self.write("engine.yaml", text)), 3, "parameters.a2, parameters.a3 and parameters.a4 have "
                            "only 2 different sizes: 90 and 180; add sizes, or take numbers out of the list")


if __name__ == "__main__":
    unittest.main()
