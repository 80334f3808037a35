"""Identification from Python: what the program prints, and its files."""

import json
import os
import unittest

import h5py
import numpy

import balance_mechanisms as bm

from _module import Case, run

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "identification", "data")
SPEC, TRAIN, VALIDATION = (os.path.join(DATA, name) for name in ("5r-spec.yaml", "5r-train.csv", "5r-validation.csv"))


def content(path):
    with open(path, "rb") as file:
        return file.read()


def datasets(path):
    """All numbers and words of a file by the names of their datasets."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, one: found.update({name: one[...]}) if isinstance(one, h5py.Dataset) else None)
        return found, file.attrs["command_line"]


class Identify(Case):
    @classmethod
    def setUpClass(cls):
        cls.spec = bm.load(SPEC)
        cls.found = cls.spec.identify(TRAIN, validate=[VALIDATION], cutoff=6, passive_friction="dry")

    def test_the_module_says_what_the_program_says_and_writes_its_files(self):
        options = [SPEC, TRAIN, "--validate", VALIDATION, "--cutoff", "6", "--passive-friction", "dry"]
        told = json.loads(run("identify", *options, "-o", self.path("told.yaml"), "--h5", self.path("told.h5"), "--json").stdout)
        del told["files"]
        found = self.found.to_dict()
        del found["files"]
        self.assertEqual(found, told)
        self.found.write_spec(self.path("found.yaml"))
        self.found.write(self.path("found.h5"))
        self.assertEqual(content(self.path("found.yaml")), content(self.path("told.yaml")))
        self.assertEqual(content(self.path("found.h5")), content(self.path("told.h5")))
        self.assertEqual(run("identify", *options).stdout, str(self.found))

    def test_the_command_in_a_file_names_all_options(self):
        records = {"records": [TRAIN], "rows": (1, 1500), "time": (0.5, 20), "rest": 0.03, "prior_weight": 2, "correlation": 0.5, "hold_out": 1.5}
        self.spec.identify(**records).write(self.path("found.h5"))
        numbers, command = datasets(self.path("found.h5"))
        self.assertEqual(command, "balance identify 5r-spec.yaml 5r-train.csv --rows 1:1500 --time 0.5:20 --rest 0.03 --prior-weight 2 "
                                  "--correlation 0.5 --hold-out 1.5")
        words = command.split()[1:]
        words[1:3] = [SPEC, TRAIN]
        self.assertEqual(run(*words, "--h5", self.path("again.h5")).returncode, 0)
        self.assertEqual(content(self.path("again.h5")), content(self.path("found.h5")))
        self.assertIn("channels/A1/validation/predicted", numbers)

    def test_numbers_are_arrays(self):
        """Of the covariance, the deviations are the roots of its diagonal; of a channel, the residual is its root mean square where it moves."""
        deviations = [one["deviation"] for one in self.found.base_parameters]
        self.assertEqual(self.found.covariance.shape, (len(deviations),) * 2)
        numpy.testing.assert_allclose(numpy.sqrt(numpy.diagonal(self.found.covariance)), deviations, rtol=1e-12)
        for told in self.found.to_dict()["channels"]:
            channel = self.found.channels[told["name"]]
            for series, figures in ((channel.training, told["training"]), (channel.validation, told["validation"])):
                self.assertEqual((len(series.time), series.moving.sum()), (figures["rows"], figures["moving_rows"]))
                error = (series.measured - series.predicted)[series.moving]
                self.assertAlmostEqual(numpy.sqrt(numpy.mean(error**2)), figures["residual"], delta=1e-12 * figures["measured"])
            with self.assertRaises(ValueError):
                channel.training.measured[0] = 0
        with self.assertRaises(ValueError):
            self.found.covariance[0, 0] = 0

    def test_bodies_are_those_of_the_written_spec(self):
        self.found.write_spec(self.path("found.yaml"))
        for mine, read in zip(self.found.bodies, bm.load(self.path("found.yaml")).mechanism.bodies):
            self.assertEqual(mine["name"], read["name"])
            for key in ("mass", "com", "inertia"):  # the spec has twelve digits or more
                numpy.testing.assert_allclose(mine[key], read[key], rtol=1e-9, atol=1e-12)
        values = {one["name"]: one["value"] for one in self.found.unknowns}
        crank = next(one for one in self.found.bodies if one["name"] == "crank1")
        self.assertAlmostEqual(crank["mass"] * crank["com"][0], values["crank1.mx"], delta=1e-12)

    def test_files_are_whole_and_replace_nothing_unasked(self):
        for write in (self.found.write, self.found.write_spec):
            path = self.write("old", "old\n")
            with self.assertRaises(FileExistsError):
                write(path)
            self.assertEqual(content(path), b"old\n")
            write(path, force=True)
            self.assertGreater(len(content(path)), 1000)
            with self.assertRaises(OSError):
                write(os.path.join(path, "below-a-file"))
            self.assertEqual(os.listdir(self.folder), ["old"])

    def test_inputs_are_never_replaced(self):
        for name, original in (("spec.yaml", SPEC), ("log.csv", TRAIN), ("other.csv", VALIDATION)):
            with open(original, encoding="utf-8") as file:
                self.write(name, file.read())
        found = bm.load(self.path("spec.yaml")).identify(self.path("log.csv"), validate=self.path("other.csv"))
        for name in ("spec.yaml", "log.csv", "other.csv"):
            before = content(self.path(name))
            for write in (found.write, found.write_spec):
                with self.assertRaisesRegex(OSError, "input"):
                    write(self.path(name), force=True)
            self.assertEqual(content(self.path(name)), before)


class Misuse(Case):
    def setUp(self):
        super().setUp()
        self.spec = bm.load(SPEC)

    def test_arguments_without_meaning_are_errors_with_their_names(self):
        for wrong, message in (({"gain": {"A9": 1}}, "^gain: no actuator 'A9'"), ({"gain": {"A1": 0}}, "^gain: expected a number > 0"),
                               ({"find_payload": "tool"}, "^find_payload: the spec has no payloads"), ({"cutoff": -1}, "^cutoff: expected a number"),
                               ({"rest": float("nan")}, "^rest: expected a number"), ({"passive_friction": "wet"}, "^passive_friction: expected none"),
                               ({"loaded": {"tool": TRAIN}}, "^loaded: the spec has no payloads"),
                               ({"hold_out": 1, "validate": VALIDATION}, "^hold_out: excluded")):
            with self.assertRaisesRegex(ValueError, message):
                self.spec.identify(TRAIN, **wrong)
        with self.assertRaisesRegex(ValueError, "^records: expected at least one"):
            self.spec.identify([])

    def test_files_that_are_no_records_are_errors_with_their_reason(self):
        with self.assertRaises(FileNotFoundError):
            self.spec.identify(self.path("missing.csv"))
        with self.assertRaisesRegex(OSError, "A2"):
            self.spec.identify(self.write("log.csv", "time,A1,A1.effort,A2\n0,0,0,none\n"))

    def test_records_that_say_nothing_are_refused(self):
        rows = "".join(f"{0.01 * k:.2f},0.3,0.5,1.2,0.1\n" for k in range(400))
        with self.assertRaises(bm.MechanismError) as raised:
            self.spec.identify(self.write("still.csv", "time,A1,A2,A1.effort,A2.effort\n" + rows))
        self.assertIn(raised.exception.status, ("record", "not-identifiable"))


if __name__ == "__main__":
    unittest.main()
