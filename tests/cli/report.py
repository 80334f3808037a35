"""The page: one file, small, complete, with the same numbers as the other commands."""

import base64
import json
import os
import re
import tempfile
import time
import unittest

import h5py
import numpy

from _program import CONFIGS, SPEC, Case, run

MISSING = "built without the scripts of the page"


def has_page():
    with tempfile.TemporaryDirectory() as folder:
        return MISSING not in run("report", SPEC, "--samples", "2", "-o", os.path.join(folder, "page.html")).stderr


def config(name):
    return os.path.join(CONFIGS, name + ".yaml")


def data_of(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    return json.loads(re.search(r'<script type="application/json" id="balance-data">(.*?)</script>', text, re.S)[1])


def samples(packed):
    kind, text = next(iter(packed.items()))
    return numpy.frombuffer(base64.b64decode(text), "<f4" if kind == "f32" else "<f8")


class Wishes(Case):
    """What is wrong is told whether or not the program can make pages."""

    def test_help_has_examples(self):
        done = run("report", "--help")
        self.assert_quiet_success(done)
        self.assertIn("balance report 3rrr.yaml", done.stdout)

    def test_wrong_usage_ends_with_2(self):
        page = self.path("page.html")
        self.assert_failure(run("report", SPEC, "-o", page, "-t", "cyclod"), 2, "nearest is 'cycloid'")
        self.assert_failure(run("report", SPEC, "-o", SPEC, "--force"), 2, "would replace the spec")
        self.assertFalse(os.path.exists(page))

    def test_a_file_in_the_place_of_a_folder_ends_with_5(self):
        self.assert_failure(run("report", SPEC, "-o", os.path.join(self.write("none", ""), "page.html")), 5)


class Page(Case):
    def make(self, *arguments):
        page = self.path("page.html")
        done = run("report", *arguments, "-o", page)
        if MISSING in done.stderr:
            self.assertEqual(done.returncode, 5)
            self.assertFalse(os.path.exists(page))
            self.skipTest("the program was built without node")
        self.assert_quiet_success(done)
        return page

    def test_the_page_of_the_3rrr_is_one_small_file(self):
        page = self.make(SPEC)
        with open(page, encoding="utf-8") as file:
            text = file.read()
        self.assertLess(len(text.encode()), 2_000_000)
        # Nothing but a name space may look like an address.
        addresses = set(re.findall(r"https?://[^\s\"'<>)\\]*", text))
        self.assertLessEqual(addresses, {"http://www.w3.org/1999/xhtml", "http://www.w3.org/2000/svg"})
        self.assertNotRegex(text, r"<(link|script|img)[^>]+(src|href)=\"(?!data:)")
        self.assertEqual(os.listdir(self.folder), ["page.html"])

    def test_samples_are_those_of_the_result_file(self):
        data = data_of(self.make(SPEC, "-t", "cycloid", "--samples", "51"))
        file = self.path("run.h5")
        self.assert_quiet_success(run("simulate", SPEC, "-t", "cycloid", "--samples", "51", "-q", "-o", file))
        shown = data["trajectories"][0]["before"]
        with h5py.File(file) as stored:
            numpy.testing.assert_array_equal(samples(shown["time"]), stored["time"][:])
            for series in shown["series"]:
                values = samples(series["values"]).reshape(len(series["columns"]), -1).T
                there = stored[series["quantity"]][:].reshape(51, -1)
                round_off = stored[series["quantity"]].attrs.get("round_off", numpy.zeros(1))
                there = numpy.where(abs(there) <= numpy.repeat(round_off, there.shape[1] // len(numpy.atleast_1d(round_off))), 0, there)
                if series["quantity"] == "joint_force":
                    there = numpy.linalg.norm(there.reshape(51, len(series["columns"]), -1), axis=2)
                numpy.testing.assert_allclose(values, there, rtol=1e-6, atol=1e-6 * abs(there).max(), err_msg=series["quantity"])

    def test_figures_and_conditions_are_those_of_the_other_commands(self):
        data = data_of(self.make(config("5r-design")))
        design = json.loads(run("design", config("5r-design"), "--json").stdout)
        self.assertEqual(data["design"]["free_numbers"], design["free_numbers"])
        self.assertEqual(data["design"]["conditions"], design["conditions"])
        for shown, told in zip(data["trajectories"], design["trajectories"], strict=True):
            self.assertEqual(shown["name"], told["trajectory"])
            for side in ("before", "after"):
                self.assertEqual(shown[side]["metrics"], told[side]["metrics"])
        check = json.loads(run("check", config("5r-design"), "--json").stdout)
        self.assertEqual(data["check"], check)

    def test_a_controlled_run_names_its_controller(self):
        data = data_of(self.make(config("control-rrr"), "-t", "cycloid", "--controller", "torque", "--samples", "21"))
        self.assertEqual(data["controller"], {"name": "torque", "type": "computed-torque"})
        file = self.path("run.h5")
        self.assert_quiet_success(run("control", config("control-rrr"), "-t", "cycloid", "-c", "torque", "--samples", "21", "-q", "-o", file))
        self.assertEqual(data_of(self.make(file, "--force"))["controller"], {"name": "torque", "type": "computed-torque"})
        self.assertIsNone(data_of(self.make(SPEC, "--samples", "11", "--force"))["controller"])

    def test_a_result_of_very_many_samples_has_a_small_page(self):
        """C10: 200,000 samples in seconds."""
        file = self.path("long.h5")
        self.assert_quiet_success(run("simulate", config("rr"), "-t", "cycloid", "--samples", "200000", "-q", "-o", file))
        began = time.monotonic()
        page = self.make(file)
        self.assertLess(time.monotonic() - began, 60)
        self.assertLess(os.path.getsize(page), 2_000_000)
        shown = data_of(page)["trajectories"][0]["before"]
        self.assertEqual(shown["samples"], 200000)
        self.assertLessEqual(len(samples(shown["time"])), 4000)

    def test_a_goal_adds_its_conditions(self):
        data = data_of(self.make(SPEC, "-g", "force", "-t", "cycloid"))
        told = json.loads(run("conditions", SPEC, "-g", "force", "--json").stdout)
        self.assertEqual(data["conditions"]["conditions"], told["conditions"])
        self.assertIsNone(data["design"])

    def test_the_same_page_comes_from_the_same_spec(self):
        first, second = self.make(SPEC, "--samples", "11"), self.path("again.html")
        run("report", SPEC, "--samples", "11", "-o", second)
        with open(first, "rb") as a, open(second, "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_a_page_is_replaced_only_by_force(self):
        page = self.make(SPEC, "--samples", "5")
        self.assert_failure(run("report", SPEC, "-o", page), 5, page)
        self.assertEqual(run("report", SPEC, "-o", page, "--force", "-q", "--samples", "5").stdout, "")

    def test_without_scripts_nothing_but_the_page_is_missing(self):
        if has_page():
            self.skipTest("the program was built with node")
        self.assert_failure(run("report", SPEC, "-o", self.path("page.html")), 5, "node 18", "scripts/setup")
        self.assertEqual(os.listdir(self.folder), [])

    def test_json_tells_what_is_in_the_page(self):
        if not has_page():
            self.skipTest("the program was built without node")
        page = self.path("page.html")
        told = json.loads(run("report", config("5r-design"), "--json", "-o", page).stdout)
        self.assertEqual(told["files"], [page])
        self.assertTrue(told["design"])
        self.assertEqual(told["bytes"], os.path.getsize(page))

    def test_a_mechanism_that_cannot_move_has_no_page(self):
        page = self.path("page.html")
        with open(SPEC, encoding="utf-8") as file:
            far = self.write("far.yaml", file.read().replace("to: {tool: [0.1, 0.05]", "to: {tool: [9, 9]"))
        if not has_page():
            self.skipTest("the program was built without node")
        self.assert_failure(run("report", far, "-o", page), 4)
        self.assertFalse(os.path.exists(page))


if __name__ == "__main__":
    unittest.main()
