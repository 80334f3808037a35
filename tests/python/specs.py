"""Specs: reading, mistakes, overrides, pickling, what a mechanism is."""

import errno
import json
import os
import pickle
import unittest

import balance_mechanisms as bm

from _module import Case, config

ARM = """
name: arm
space: planar
units: {length: mm}
parameters: {m: 2}
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: m, com: [100, 0], inertia: 0.01, points: {A: [0, 0], E: [200, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, upper.A]}
actuators: [A]
"""


class Reading(Case):
    def test_a_mistake_says_where_it_is(self):
        for source, file in ((ARM.replace("mass: m", "mass: -1"), "arm.yaml"), (None, self.path("arm.yaml"))):
            if source is None:
                with open(file, "w", encoding="utf-8") as out:
                    out.write(ARM.replace("mass: m", "mass: -1"))
            with self.assertRaises(bm.SpecError) as caught:
                bm.load(source, file=file) if source else bm.load(file)
            error = caught.exception
            self.assertIsInstance(error, ValueError)
            self.assertEqual((error.file, error.line, error.key), (file, 8, "bodies.upper.mass"))
            self.assertEqual(ARM.splitlines()[7][error.column - 1:][:1], "m")
            self.assertIn("must be positive", str(error))
            again = pickle.loads(pickle.dumps(error))
            self.assertEqual((str(again), again.line, again.mistakes), (str(error), error.line, error.mistakes))

    def test_overrides_are_numbers_and_expressions(self):
        for value, mass in ((3, 3.0), (0.1, 0.1), ("2 * 4", 8.0)):
            self.assertEqual(bm.load(ARM, set={"m": value}).mechanism.bodies[1]["mass"], mass)
        with self.assertRaises(bm.SpecError):
            bm.load(ARM, set={"no_such": 1})

    def test_a_file_that_cannot_be_read_is_python_s_own_error(self):
        """Of the class that `open` raises, with its number; the sentence names the file."""
        for ask, name in ((bm.load, "none.yaml"), (bm.batch, "none.yaml"), (bm.import_, "none.urdf"), (bm.read, "none.h5")):
            with self.assertRaises(FileNotFoundError) as caught:
                ask(self.path(name))
            self.assertEqual(caught.exception.errno, errno.ENOENT)
            self.assertIn(self.path(name), str(caught.exception))
            with self.assertRaises(IsADirectoryError):
                ask(self.folder)
        with self.assertRaises(NotADirectoryError):
            bm.load(config("rr.yaml") + "/rr.yaml")
        self.assertIsInstance(pickle.loads(pickle.dumps(caught.exception)), FileNotFoundError)

    def test_a_file_that_may_not_be_read_is_a_permission_error(self):
        spec, result = self.path("arm.yaml"), self.path("arm.h5")
        with open(spec, "w", encoding="utf-8") as out:
            out.write(ARM)
        bm.load(spec).state({"A": 0}).write(result)
        user = os.geteuid()
        for name in (spec, result):
            os.chmod(name, 0)
        if user == 0:  # who may read everything
            os.chmod(self.folder, 0o755)
            os.seteuid(65534)
            self.addCleanup(os.seteuid, user)
        for ask, name in ((bm.load, spec), (bm.read, result)):
            with self.assertRaises(PermissionError) as caught:
                ask(name)
            self.assertEqual(caught.exception.errno, errno.EACCES)
        os.seteuid(user)

    def test_kinds_of_specs_to_start_from_are_those_of_the_program(self):
        listed = [one["kind"] for one in json.loads(self.program("new", "--json"))["kinds"]]
        self.assertEqual(list(bm.kinds()), listed)
        for kind in listed:
            self.assertEqual(bm.new(kind), self.program("new", kind))
            bm.load(bm.new(kind))
        with self.assertRaises(ValueError):
            bm.new("none")


class Mechanisms(Case):
    def test_it_says_what_it_is(self):
        spec = bm.load(config("3rrr.yaml"))
        mechanism = spec.mechanism
        told = json.loads(self.program("check", config("3rrr.yaml"), "--json"))
        self.assertEqual(mechanism.dof, told["degrees_of_freedom"])
        self.assertEqual(mechanism.actuators, ["A1", "A2", "A3"])
        self.assertEqual(len(mechanism.coordinates), 9)
        self.assertAlmostEqual(mechanism.total_mass, told["total_mass"], delta=1e-12 * mechanism.total_mass)
        self.assertEqual(spec.check().to_dict(), told)

    def test_it_never_changes(self):
        mechanism = bm.load(ARM).mechanism
        for name in ("name", "coordinates", "actuators", "dof", "bodies", "total_mass"):
            with self.assertRaises(AttributeError):
                setattr(mechanism, name, None)
        mechanism.bodies[0]["mass"] = 7
        self.assertEqual(mechanism.bodies[0]["mass"], 0)

    def test_it_pickles_as_its_text_with_what_was_overridden(self):
        spec = bm.load(ARM, set={"m": "5 / 2"})
        again = pickle.loads(pickle.dumps(spec))
        self.assertEqual((again.text, again.set), (spec.text, spec.set))
        mechanism = pickle.loads(pickle.dumps(spec.mechanism))
        self.assertEqual(mechanism.bodies[1]["mass"], 2.5)
        self.assertEqual(mechanism.inverse_dynamics([0.1], [0.2], [3]), spec.mechanism.inverse_dynamics([0.1], [0.2], [3]))

    def test_a_spec_with_files_pickles_for_another_folder(self):
        with open(self.path("table.csv"), "w", encoding="utf-8") as out:
            out.write("time,A\n" + "".join(f"{t},{t * t}\n" for t in (0, 0.5, 1, 1.5, 2)))
        with open(self.path("arm.yaml"), "w", encoding="utf-8") as out:
            out.write(ARM + "motion: {samples: 5}\ntrajectories:\n  t: {path: {file: table.csv}, drive: joints}\n")
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(self.folder)
        spec = bm.load("arm.yaml")
        packed = pickle.dumps(spec)
        os.chdir(here)
        again = pickle.loads(packed)
        self.assertEqual(again.simulate("t").torque.tolist(), spec.simulate("t").torque.tolist())


if __name__ == "__main__":
    unittest.main()
