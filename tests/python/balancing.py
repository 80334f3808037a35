"""Conditions and designs are those of the program."""

import json
import unittest

import numpy

import balance_mechanisms as bm

from _module import Case, config


class Equations(Case):
    def test_they_are_the_program_s(self):
        for file, options, words in (
                ("rr.yaml", {"only": "gravity"}, ("--only", "gravity")),
                ("5r.yaml", {"only": ["inertia", "efforts"], "collect": "a11"}, ("--only", "inertia,efforts", "--collect", "a11")),
                ("planar-rrr-belts.yaml", {"solve": ["lg1", "lg2", "lg3"], "goal": "static"}, ("--solve", "lg1,lg2,lg3", "--goal", "static"))):
            found = bm.load(config(file)).equations(**options)
            self.assertEqual(found.to_dict(), json.loads(self.program("equations", config(file), "--json", *words)), file)
            self.assertEqual(found.latex(), self.latex("equations", config(file), *words))
        self.assertEqual(found.solution["lg2"], "-m3 l2/m2")

    def test_programs_are_the_program_s(self):
        for file, language in (("rr.yaml", "python"), ("5r.yaml", "c")):
            self.assertEqual(bm.load(config(file)).program(language), self.program("equations", config(file), "--code", language))

    def test_what_cannot_be_meant_is_told(self):
        spec = bm.load(config("rr.yaml"))
        for options, words in (({"only": "gravitation"}, "only without at needs"), ({"solve": "nothing", "goal": "static"}, "solve: 'nothing'"),
                               ({"collect": "nothing"}, "collect: 'nothing'"), ({"independent": "nothing"}, "independent: there is no coordinate"),
                               ({"solve": "m_cw1", "goal": "sttaic"}, "goal")):
            with self.assertRaisesRegex(ValueError, words):
                spec.equations(**options)
        with self.assertRaisesRegex(ValueError, "language"):
            spec.program("java")


class Conditions(Case):
    def test_they_are_the_program_s(self):
        found = bm.load(config("5r.yaml")).conditions("static")
        told = json.loads(self.program("conditions", config("5r.yaml"), "--goal", "static", "--json"))
        self.assertEqual(found.to_dict(), told)
        self.assertEqual(len(found), told["rank"])
        self.assertEqual(found.latex(), self.latex("conditions", config("5r.yaml"), "--goal", "static"))
        self.assertEqual([one.text for one in found.conditions], [one["text"] for one in told["conditions"]])

    def test_the_matrix_times_the_parameters_is_what_is_left(self):
        spec = bm.load(config("5r.yaml"))
        found = spec.conditions("static")
        own = numpy.array([spec.mechanism.parameters[name] for name in found.parameters])
        left = found.matrix[:len(found), :len(own)] @ own
        scale = numpy.array([one["scale"] for one in found.to_dict()["conditions"]])
        numpy.testing.assert_allclose(left / scale, [one.residual for one in found.conditions], atol=1e-12)

    def test_tables_and_proofs(self):
        found = bm.load(config("5r-impossible.yaml")).conditions("dynamic")
        self.assertIsNotNone(found.impossible)
        self.assertIn("cannot", found.impossible)
        table = found.to_dataframe()
        self.assertEqual(list(table["met"]), [one.met for one in found.conditions])
        self.assertIsNone(bm.load(config("5r.yaml")).conditions("static").impossible)

    def test_words_that_do_not_exist_are_told(self):
        spec = bm.load(config("5r.yaml"))
        for words in ({"goal": "sttaic"}, {"goal": "static", "strategy": "none"}, {"goal": "static", "without": "none"}):
            with self.assertRaisesRegex(ValueError, "expected"):
                spec.conditions(**words)

    def test_they_are_in_the_speeds_asked_for(self):
        spec, speeds = bm.load(config("rr-design.yaml")), "x: tool.x, y: tool.y"
        found = spec.conditions("gyroscopic", speeds=speeds)
        told = self.program("conditions", config("rr-design.yaml"), "--goal", "gyroscopic", "--speeds", speeds, "--json")
        self.assertEqual(found.to_dict(), json.loads(told))
        with self.assertRaises(bm.SpecError):
            spec.conditions("gyroscopic", speeds="x: nothing")
        with self.assertRaisesRegex(ValueError, "modular"):
            spec.conditions("static", speeds=speeds, strategy="modular")

    def test_no_conditions_is_an_error_of_its_own(self):
        with self.assertRaises(bm.MechanismError) as caught:
            bm.load(config("3rrr.yaml"), set={"l": 0.02}).conditions("force")
        self.assertEqual(caught.exception.status, "not-assembled")
        self.assertEqual(str(caught.exception), caught.exception.reason)


class Designs(Case):
    def test_it_is_the_program_s(self):
        spec = bm.load(config("5r-design.yaml"))
        design = spec.design(seed=1)
        self.program("design", config("5r-design.yaml"), "--seed", "1", "-o", self.path("balanced.yaml"),
                     "--h5", self.path("program.h5"))
        with open(self.path("balanced.yaml"), encoding="utf-8") as file:
            self.assertEqual(design.spec_text, file.read())
        self.assertEqual(design.status, "balanced")
        design.write(self.path("python.h5"))
        with open(self.path("python.h5"), "rb") as one, open(self.path("program.h5"), "rb") as other:
            self.assertEqual(one.read(), other.read())
        for name, value in design.values.items():
            row = design.to_dataframe().loc[name]
            self.assertEqual(row["value"], value)
            self.assertTrue(row["lower"] <= value <= row["upper"])

    def test_the_designed_spec_meets_the_conditions_and_moves_as_told(self):
        design = bm.load(config("rr-design.yaml")).design(seed=1)
        self.assertEqual(design.status, "balanced")
        again = design.spec
        self.assertTrue(all(one.met for one in again.conditions(design.to_dict()["goal"]).conditions))
        for name, run in design.after.items():
            numpy.testing.assert_allclose(again.simulate(name).torque, run.torque, atol=1e-9)
        self.assertEqual(set(design.before), set(design.after))

    def test_what_is_to_be_small_may_be_said_in_python(self):
        spec = bm.load(config("rr-design.yaml"))
        by_text = spec.design(minimize="{rms: torque, along: cycloid}", seed=1, trajectories=False)
        by_dict = spec.design(minimize={"rms": "torque", "along": "cycloid"}, seed=1, trajectories=False)
        self.assertEqual(by_text.values, by_dict.values)
        with self.assertRaises(bm.SpecError) as caught:
            spec.design(minimize={"rms": "no_such", "along": "cycloid"})
        self.assertEqual(caught.exception.file, "minimize")

    def test_load_cases_and_laws_are_the_program_s(self):
        found = bm.load(config("rr-adaptive.yaml")).design()
        told = json.loads(self.program("design", config("rr-adaptive.yaml"), "--json"))
        self.assertEqual((found.load_cases, found.adaptive), (told["load_cases"], told["adaptive"]))
        self.assertIn("* mp", found.spec_text)
        self.assertEqual(bm.load(config("rr.yaml")).design("static").load_cases, [])

    def test_a_front_is_the_program_s(self):
        front = bm.load(config("four-bar-front.yaml")).front()
        told = json.loads(self.program("design", config("four-bar-front.yaml"), "--json"))
        self.assertEqual(front.to_dict()["front"], told["front"])
        self.assertEqual((len(front), len(front.figures), front.middle + 1), (len(told["front"]["points"]), 2, told["front"]["middle"]))
        design = front.design(2)
        self.assertEqual(design.values, {n["path"]: n["value"] for n in front.points[2]["free_numbers"]})
        moved = design.spec.simulate("steady").metrics["shaking_force"].rms
        self.assertAlmostEqual(moved, front.points[2]["values"][0], delta=1e-9 * moved)
        with self.assertRaises(IndexError):
            front.design(len(front))
        with self.assertRaises(ValueError):
            bm.load(config("rr-design.yaml")).front()

    def test_a_spec_without_free_numbers_is_told(self):
        with self.assertRaises(bm.SpecError):
            bm.load(config("3rrr.yaml")).design("static")


class Tolerances(Case):
    def test_they_are_the_program_s(self):
        spec = bm.load(config("rr-tolerance.yaml"))
        for words, options in (({}, []), ({"of": "torque", "samples": 51}, ["--of", "torque", "--samples", "51"]),
                               ({"monte_carlo": 20, "seed": 3, "samples": 11}, ["--monte-carlo", "20", "--seed", "3", "--samples", "11"]),
                               ({"at_rest": True}, ["--at-rest"])):
            found = spec.tolerance(**words)
            self.assertEqual(found.to_json(), self.program("tolerance", config("rr-tolerance.yaml"), "--json", *options))
            self.assertEqual(str(found), self.program("tolerance", config("rr-tolerance.yaml"), *options))
        spec.tolerance(samples=51).write(self.path("python.h5"))
        self.program("tolerance", config("rr-tolerance.yaml"), "--samples", "51", "-o", self.path("program.h5"))
        with open(self.path("python.h5"), "rb") as one, open(self.path("program.h5"), "rb") as other:
            self.assertEqual(one.read(), other.read())

    def test_mistakes_are_told(self):
        with self.assertRaises(bm.SpecError):
            bm.load(config("rr.yaml")).tolerance()
        spec = bm.load(config("rr-tolerance.yaml"))
        for words in ({"of": "torqe"}, {"monte_carlo": 1}, {"samples": 1}, {"at_rest": True, "monte_carlo": 5}, {"seed": 3}):
            with self.assertRaises(ValueError):
                spec.tolerance(**words)


if __name__ == "__main__":
    unittest.main()
