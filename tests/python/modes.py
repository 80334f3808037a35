"""Vibrations from Python: what the program prints, and its files."""

import json
import os
import unittest

import h5py
import numpy

import balance_mechanisms as bm

from _module import Case, config, run


class Modes(Case):
    def test_the_module_says_what_the_program_says(self):
        path = config("machines/frame-on-mounts.yaml")
        found = bm.load(path).modes("run", sweep="A=10:60:6", exact=2)
        told = json.loads(run("modes", path, "--trajectory", "run", "--sweep", "A=10:60:6", "--exact", "2", "--json").stdout)
        self.assertEqual(found.to_dict(), told)
        self.assertEqual(found.stability, "stable")
        numpy.testing.assert_allclose(found.frequencies, 2.63888, rtol=1e-5)
        self.assertEqual(len(found.eigenvalues), 4)
        self.assertEqual(found.stability_changes, [])

    def test_a_bicycle_is_stable_at_some_speeds(self):
        found = bm.load(config("bicycle.yaml")).modes(sweep="v=4:5:2")
        self.assertAlmostEqual(found.stability_changes[0]["value"], 4.29238253634111, delta=1e-9)

    def test_files_are_those_of_the_program(self):
        path, file = config("machines/torsion-shaft.yaml"), self.path("modes.h5")
        bm.load(path).modes().write(file)
        with h5py.File(file) as written:
            self.assertEqual(list(written["modes/coordinate"].asstr()), ["R"])
        with self.assertRaises(FileExistsError):
            bm.load(path).modes().write(file)
        self.assertTrue(os.path.exists(file))

    def test_mistakes_are_errors(self):
        spec = bm.load(config("machines/frame-on-mounts.yaml"))
        with self.assertRaisesRegex(ValueError, "NAME=FROM:TO"):
            spec.modes("run", sweep="A=5")
        with self.assertRaises(bm.SpecError):
            spec.modes("run", sweep="nothing=1:2")


if __name__ == "__main__":
    unittest.main()
