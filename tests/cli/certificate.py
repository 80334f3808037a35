#!/usr/bin/env python3
"""The proof of a bound over all lengths: a script that shares nothing with the program accepts what the program writes, and nothing less."""

import copy
import itertools
import json
import os
import re
import subprocess
import sys
import unittest

from _program import CONFIGS, SLOWNESS, Case, run

PROJECT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CHECKER = os.path.join(PROJECT, "scripts", "check-certificate")


def length_spec(name):
    return os.path.join(PROJECT, "tests", "certificate", "specs", name + ".yaml")


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def check(file):
    return subprocess.run([sys.executable, CHECKER, file], capture_output=True, text=True, check=False, timeout=120 * SLOWNESS)


def bounded(certificate):
    return [box for geometry in certificate["geometries"] for box in geometry["boxes"] if "bound" in box]


class Certificate(Case):
    def design(self, name, *options):
        """The exit code and the certificate's path."""
        file = self.path(name + ".json")
        return run("design", length_spec(name), "--certificate", file, "--quiet", *options).returncode, file

    def read(self, file):
        return json.loads(text_of(file))

    def assert_refused(self, certificate, *parts):
        with open(self.path("changed.json"), "w", encoding="utf-8") as file:
            json.dump(certificate, file)
        done = check(self.path("changed.json"))
        self.assertEqual(done.returncode, 1, done.stdout)
        for part in ("not proved: ", *parts):
            self.assertIn(part, done.stderr)

    def test_a_bound_that_is_reached_is_proved(self):
        # one geometry; two of them; boxes that conditions of assembly exclude
        for name, value in (("four_hi_4", "1.43994"), ("four_fix21", "1.62061"), ("four_box_1", "0.87908")):
            with self.subTest(name=name):
                code, file = self.design(name)
                self.assertEqual(code, 0)
                done = check(file)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn(f"proved: added mass ≥ {value}", done.stdout)

    def test_the_example_of_the_page_has_the_numbers_that_are_derived_there_by_hand(self):
        page = text_of(os.path.join(PROJECT, "docs", "certificate.md"))
        spec = length_spec("four_by_hand")
        self.assertEqual(text_of(spec), re.search(r"```yaml\n(.*?)```", page, re.DOTALL).group(1))
        printed = re.search(r"```text\n(.*?)```", page, re.DOTALL).group(1)
        self.assert_quiet_success(run("design", spec, "--certificate", self.path("proof.json"), "--quiet"))
        self.assertEqual(check(self.path("proof.json")).stdout, printed)
        certificate = self.read(self.path("proof.json"))
        self.assertEqual(certificate["not_covered"], [])
        (box,) = bounded(certificate)
        self.assertEqual(box["affine"], [])
        # w = (-1, -2), of crank and rocker: real and imaginary parts; the solver's tolerance
        for (value,), expected in zip(box["w"], (-1, 0, -2, 0), strict=True):
            self.assertAlmostEqual(float.fromhex(value), expected, delta=1e-8)
        # the sum over the links and the heights of the counterweights, as on the page
        w = [complex(float.fromhex(box["w"][i][0]), float.fromhex(box["w"][i + 1][0])) for i in (0, 2)]
        for a, b, c in itertools.product((0.1, 0.13, 0.14), (0.3, 0.4, 0.5), (0.2, 0.3, 0.4)):
            moments = 2 * a * w[0] / 2 + 2 * b * (w[0] + w[1]) / 2 + 2 * c * w[1] / 2
            self.assertAlmostEqual(-moments.real, a + 3 * b + 2 * c, delta=1e-7)
            self.assertGreaterEqual(-moments.real, float.fromhex(certificate["lower_bound"]))
            for height in (-0.1 * w[0].real / a, -0.1 * w[1].real / c):
                self.assertLessEqual(height, 1)

    def test_a_bound_that_is_not_reached_is_proved_and_agrees_with_the_answer(self):
        file = self.path("five.json")
        done = run("design", length_spec("five_box_1"), "--seconds", "0.5", "--certificate", file, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(file, json.loads(done.stdout)["files"])
        certificate = self.read(file)
        boxes = certificate["geometries"][0]["boxes"]
        self.assertTrue(any("excluded_by" in box for box in boxes))
        self.assertTrue(any(box["kappa"] for box in boxes if "bound" in box))
        self.assertEqual(check(file).returncode, 0)
        self.assertLessEqual(float.fromhex(certificate["lower_bound"]), certificate["best"]["value"])

    def test_limits_that_no_lengths_meet_are_proved(self):
        code, file = self.design("watt_hi_3", "--seconds", "1")
        self.assertEqual(code, 1)
        done = check(file)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("proved: no masses within their limits", done.stdout)
        self.assertIn("not covered: ", done.stdout)

    def test_a_certificate_with_a_flaw_is_refused(self):
        _, file = self.design("four_fix21")
        good = self.read(file)

        def changed():
            return copy.deepcopy(good)

        higher = changed()
        for box in bounded(higher):
            box["w"] = [[(2 * float.fromhex(value)).hex() for value in values] for values in box["w"]]
        self.assert_refused(higher)
        raised = changed()
        raised["lower_bound"] = (1.01 * float.fromhex(good["lower_bound"])).hex()
        self.assert_refused(raised, "the bound of a box is too low")
        for box in bounded(raised):
            box["bound"] = raised["lower_bound"]
        self.assert_refused(raised)
        for geometry in range(len(good["geometries"])):
            for index in range(len(good["geometries"][geometry]["boxes"])):
                missing = changed()
                del missing["geometries"][geometry]["boxes"][index]
                self.assert_refused(missing)
        missing = changed()
        del missing["geometries"][1]
        self.assert_refused(missing, "a geometry is missing")
        excluded = changed()
        excluded["geometries"][1]["boxes"] = [{"excluded_by": 0}]
        self.assert_refused(excluded)
        negative = changed()
        negative["geometries"][0]["conditions"] = [{"polynomial": [["0x1p+0", {}]], "is_zero": False}]
        bounded(negative)[0]["kappa"] = {"0": "-0x1p+0"}
        self.assert_refused(negative, "negative")
        damaged = changed()
        damaged["lower_bound"] = "nan"
        self.assert_refused(damaged, "damaged")

    def test_a_multiplier_of_a_mass_limit_counts(self):
        _, file = self.design("four_hi_4")
        certificate = self.read(file)
        self.assertTrue(any(box["sigma"] for box in bounded(certificate)))
        for box in bounded(certificate):
            for sigma in box["sigma"].values():
                sigma["value"] = [(float.fromhex(value) + 0.01).hex() for value in sigma["value"]]
        self.assert_refused(certificate, "σ exceeds a mass limit")

    def test_moments_are_proved_and_their_multipliers_count(self):
        for name, value in (("link_with_disc", "2.25 kg"), ("slider_with_discs", "")):
            with self.subTest(name=name):
                code, file = self.design(name)
                self.assertEqual(code, 0)
                self.assertEqual(self.read(file)["version"], 2)
                done = check(file)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn("proved: added mass ≥ " + value, done.stdout)
        good = self.read(file)

        def changed(change):
            certificate = copy.deepcopy(good)
            for geometry in certificate["geometries"]:
                change(geometry)
            return certificate

        def raise_sigma(geometry):
            for box in geometry["boxes"]:
                box["inertia_sigma"] = [[(float.fromhex(values[0]) + 0.01).hex(), *values[1:]] for values in box["inertia_sigma"]]

        def narrow_inertias(geometry):
            for inertia in geometry["inertias"]:
                inertia["inertia"] = [inertia["inertia"][0], "0x1p+10"]

        def widen_places(geometry):
            for length in geometry["lengths"]:
                if ".at[" in length:
                    geometry["lengths"][length] = ["-0x1p+1", "0x1p+1"]

        self.assert_refused(changed(raise_sigma), "σ exceeds a limit of its inertia")
        self.assert_refused(changed(narrow_inertias), "σ exceeds a limit of its inertia")
        self.assert_refused(changed(widen_places), "a place is higher than 1")
        self.assert_refused(changed(lambda geometry: geometry["inertias"].clear()))

    def test_without_a_bound_it_says_why_and_writes_nothing(self):
        text = text_of(length_spec("four_box_1"))
        for reason, before, after in (("not a polynomial", "0.5925 * b + 0.0046", "0.5925 * sin(b)"),
                                      ("the objective", "minimize: added-mass", "minimize: rms(torque)")):
            spec = self.write("without.yaml", text.replace(before, after))
            with self.subTest(reason=reason):
                done = run("design", spec, "--certificate", self.path("c.json"), "-o", self.path("o.yaml"))
                self.assert_failure(done, 2, "--certificate", "no certificate because", reason)
                self.assertFalse(os.path.exists(self.path("c.json")) or os.path.exists(self.path("o.yaml")))

    def test_a_front_has_none(self):
        done = run("design", os.path.join(CONFIGS, "four-bar-front.yaml"), "--certificate", self.path("c.json"))
        self.assert_failure(done, 2, "--certificate", "front")

    def test_it_replaces_no_file_unasked_and_never_an_input(self):
        spec = self.write("spec.yaml", text_of(length_spec("four_box_1")))
        self.assert_failure(run("design", spec, "--certificate", spec, "--force"), 2, "spec.yaml")
        self.assert_failure(run("design", spec, "--certificate", self.path("a"), "-o", self.path("a")), 2, "same file")
        old = self.write("old.json", "old")
        self.assertNotEqual(run("design", spec, "--certificate", old).returncode, 0)
        self.assertEqual(text_of(old), "old")
        self.assert_quiet_success(run("design", spec, "--certificate", old, "--force", "--quiet"))
        self.assertEqual(check(old).returncode, 0)


if __name__ == "__main__":
    unittest.main()
