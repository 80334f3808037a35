"""`balance compare`: figures of real runs side by side, requirements, formats and mistakes."""

import csv
import io
import json
import os
import subprocess
import tempfile
import unittest

from _junit import read_junit
from _program import CONFIGS, SPEC, Case, run

LESS = "peak(shaking_force) <= 0.9 * base"


class Compare(Case):
    @classmethod
    def setUpClass(cls):
        cls._runs = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls._runs.cleanup)
        for name, options in (
            ("original", ["-t", "cycloid", "--samples", "201"]),
            ("bang-bang", ["-t", "bang-bang", "--samples", "201"]),
            ("coarse", ["-t", "cycloid", "--samples", "51"]),
            ("slow", ["-t", "cycloid", "--samples", "64", "--duration", "0.2"]),
        ):
            done = run("simulate", SPEC, *options, "-q", "-o", cls.file(name))
            assert done.returncode == 0, done.stderr
        done = run("simulate", os.path.join(CONFIGS, "slider-crank.yaml"), "--samples", "21", "-q", "-o", cls.file("slider"))
        assert done.returncode == 0, done.stderr

    @classmethod
    def file(cls, name):
        return os.path.join(cls._runs.name, name + ".h5")

    def compare(self, *names, options=()):
        return run("compare", *(self.file(name) for name in names), *options)

    def test_the_table_is_that_of_the_files(self):
        report = json.loads(self.compare("original", "bang-bang", options=["--json"]).stdout)
        self.assertEqual([one["name"] for one in report["runs"]], ["original", "bang-bang"])
        force = next(one for one in report["quantities"] if one["quantity"] == "shaking_force")
        # 4 m L / T^2 of the bang-bang centre of mass; the cycloid's largest sample
        bang = force["runs"]["bang-bang"]
        self.assertAlmostEqual(bang["peak"], 549.2528818391, places=6)
        original = json.loads(run("simulate", SPEC, "-t", "cycloid", "--samples", "201", "--json").stdout)
        for metric in original["metrics"]:
            found = next(one for one in report["quantities"] if one["quantity"] == metric["quantity"])
            self.assertEqual(found["unit"], metric["unit"])
            for figure in ("peak", "peak_time", "rms", "mean", "range"):
                self.assertEqual(found["runs"]["original"][figure], metric[figure])
        self.assertAlmostEqual(bang["ratio"]["peak"], bang["peak"] / force["runs"]["original"]["peak"], places=15)
        self.assertEqual(report["runs"][0]["energy"], original["energy"])
        reactions = [one for one in report["quantities"] if one["quantity"].startswith("joint_force[")]
        worst = next(one for one in report["quantities"] if one["quantity"] == "joint_force")
        self.assertEqual(len(reactions), 9)
        self.assertEqual(worst["runs"]["original"]["peak"], max(one["runs"]["original"]["peak"] for one in reactions))

    def test_other_samples_of_the_same_motion_are_no_difference(self):
        report = json.loads(self.compare("original", "coarse", "slow", options=["--json"]).stdout)
        for one in report["quantities"]:
            difference = one["runs"]["coarse"]["difference"]
            # (1/200)^4 of the fourth derivative; moments of free joints are round-off
            self.assertLess(difference["largest"], 1e-7 * one["runs"]["original"]["peak"] + 1e-10, one["quantity"])
        force = next(one for one in report["quantities"] if one["quantity"] == "shaking_force")
        self.assertAlmostEqual(force["runs"]["slow"]["ratio"]["rms"], 0.25, places=6)
        self.assertEqual(len(report["notes"]), 2)
        self.assertIn("equal fractions", report["notes"][1])

    def test_a_spec_is_run_first(self):
        """The same figures as those of its result files, under the same names as in plot."""
        names = {name: self.path(name + ".h5") for name in ("cycloid", "bang-bang")}
        for name, file in names.items():
            self.assert_quiet_success(run("simulate", SPEC, "-t", name, "-q", "-o", file))
        files = json.loads(run("compare", *names.values(), "--json").stdout)
        done = run("compare", SPEC + ":cycloid", SPEC + ":bang-bang", "--json")
        self.assert_quiet_success(done)
        specs = json.loads(done.stdout)
        self.assertEqual([(one["name"], one["trajectory"], one["law"], one["drive"]) for one in specs["runs"]],
                         [("cycloid", "cycloid", "cycloidal", "tool"), ("bang-bang", "bang-bang", "bang-bang", "com")])
        for mine, theirs in zip(specs["quantities"], files["quantities"]):
            self.assertEqual(mine["runs"]["bang-bang"], theirs["runs"]["bang-bang"])
        mixed = run("compare", names["cycloid"], SPEC, "--require", "peak(shaking_force) == base")
        self.assertEqual(mixed.returncode, 0, mixed.stderr)
        self.assertIn("note: " + SPEC + ": using 'cycloid', the first of its 3 trajectories", mixed.stderr)

    def test_a_requirement_that_holds_ends_with_0(self):
        done = self.compare("original", "bang-bang", options=["--require", LESS])
        self.assert_quiet_success(done)
        self.assertIn("ok     " + LESS + " [bang-bang]: holds: 549.253 N <= ", done.stdout)
        self.assertIn("1 of 1 requirement met", done.stdout)

    def test_a_requirement_that_fails_ends_with_1_and_says_by_how_much(self):
        done = self.compare("original", "bang-bang", "coarse", options=["--require", LESS, "--require", "energy() < 1.001 * base"])
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        # coarse samples, but figures of the whole motion
        self.assertRegex(done.stdout, r"FAILED peak\(shaking_force\) <= 0.9 \* base \[coarse\]: 869.7\d+ N is 11.1 % above the limit of 782.\d+ N")
        self.assertIn("4 of 4" if "FAILED" not in done.stdout else "3 of 4 requirements met", done.stdout)

    def test_names_with_signs_and_runs_by_name(self):
        for requirement in ("rms(torque[A1], bang-bang) < 1.2 * rms(torque[A1], base)",
                            "mean(shaking_force, coarse) < bang-bang * 1.1",
                            "range(power[A3]) > 0 && (energy(bang-bang) < base || 1 < 0)"):
            with self.subTest(requirement=requirement):
                self.assert_quiet_success(
                    self.compare("original", "bang-bang", "coarse", options=["--require", requirement]))

    def test_a_quantity_that_a_file_lacks_is_missing_and_never_passes(self):
        done = self.compare("original", "slider", options=["--require", "peak(torque[A1]) < 1e9"])
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        self.assertIn("slider has no torque[A1]", done.stdout)
        self.assertRegex(done.stdout, r"torque\[A1\] +N m +[\d.]+ +- +-\n")

    def test_mistakes_are_wrong_usage_with_their_place(self):
        for requirement, *parts in (
            ("peak(shakin_force) <= base", "column 6: ", "nearest is 'shaking_force'"),
            ("peak(torque[A9]) <= base", "column 6: ", "nearest is 'torque[A"),
            ("peak(shaking_force, bangbang) <= base", "column 21: ", "nearest is 'bang-bang'"),
            ("peak(shaking_force) <= bas", "column 24: ", "nearest is 'base'"),
            ("peak(shaking_force)", "column 1: expected a comparison"),
            ("peak(shaking_force) <= 0.9 *", "column 29: expected a number"),
            ("peek(shaking_force) <= 1", "column 1: ", "nearest is 'peak'"),
            ("", "expected a comparison"),
        ):
            with self.subTest(requirement=requirement):
                done = self.compare("original", "bang-bang", options=["--require", requirement])
                self.assert_failure(done, 2, "--require '" + requirement, *parts)
                self.assertEqual(done.stdout, "")
        done = self.compare("original", "bang-bang", options=["--json", "--require", "1"])
        self.assertEqual((done.returncode, json.loads(done.stdout)["error"]["kind"]), (2, "usage"))

    def test_wrong_calls(self):
        self.assert_failure(self.compare("original"), 2, "at least two runs")
        self.assert_failure(run("compare"), 2, "no run given: ")
        self.assert_failure(self.compare("original", "nowhere"), 5, "nowhere.h5")
        self.assert_failure(run("compare", SPEC, self.path("none.yaml")), 5, "none.yaml")
        self.assert_failure(run("compare", SPEC, self.file("original"), "-o", SPEC, "--force"), 2, "would replace")
        self.assert_failure(self.compare("original", "slow", options=["--format", "yaml"]), 2, "--format")
        self.assert_failure(self.compare("original", "slow", options=["--format", "junit"]), 2, "--require")

    def test_csv_has_every_figure_of_every_quantity(self):
        done = self.compare("original", "bang-bang", options=["--format", "csv", "--require", "energy() < 0"])
        self.assert_failure(done, 1, "FAILED energy() < 0 [bang-bang]: ", " J above the limit of 0 J")
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        report = json.loads(self.compare("original", "bang-bang", options=["--json"]).stdout)
        values = {(row["quantity"], row["figure"], row["run"]): row["value"] for row in rows}
        self.assertEqual(len(values), len(rows))
        for one in report["quantities"]:
            for name, figures in one["runs"].items():
                for figure in ("peak", "peak_time", "rms", "mean", "range"):
                    self.assertEqual(float(values[one["quantity"], figure, name]), figures[figure])
            self.assertEqual(float(values[one["quantity"], "rms_difference", "bang-bang"]),
                             one["runs"]["bang-bang"]["difference"]["rms"])

    def test_junit_has_a_case_for_every_requirement_and_file(self):
        out = self.path("junit.xml")
        done = self.compare("original", "bang-bang", "coarse",
                            options=["--require", LESS, "--require", "1 < 2 && peak(torque, base) > 0", "-o", out])
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        self.assertIn("FAILED " + LESS + " [coarse]", done.stdout)
        self.assertIn("written: " + out, done.stdout)
        root = read_junit(out)
        suite = root.find("testsuite")
        self.assertEqual((root.tag, suite.get("tests"), suite.get("failures"), suite.get("errors")),
                         ("testsuites", "3", "1", "0"))
        cases = [(one.get("classname"), one.get("name"), one.find("failure") is not None)
                 for one in suite.findall("testcase")]
        self.assertEqual(cases, [("bang-bang", LESS, False), ("coarse", LESS, True),
                                 ("requirements", "1 < 2 && peak(torque, base) > 0", False)])
        self.assertTrue(all(float(one.get("time")) >= 0 for one in [root, suite, *suite]))
        self.assertIn(" N is 11.1 % above the limit of ", suite.find("testcase/failure").get("message"))

    def test_markdown(self):
        done = self.compare("original", "bang-bang", options=["--format", "markdown", "--require", LESS])
        self.assert_quiet_success(done)
        self.assertTrue(done.stdout.startswith("# Comparison with original\n"))
        self.assertIn("| ok | `" + LESS + "` | bang-bang | holds: 549.253 N &lt;= ", done.stdout)

    def test_reactions_of_every_joint_are_shown_when_asked_for(self):
        self.assertNotIn("joint_force[B2]", self.compare("original", "slow").stdout)
        self.assertIn("joint_force[B2]", self.compare("original", "slow", options=["--all"]).stdout)

    def test_a_file_takes_its_format_from_its_ending_and_is_not_replaced(self):
        for name, start in (("a.md", "# "), ("a.csv", "quantity,"), ("a.json", "{"), ("a.txt", "runs"), ("a", "runs")):
            out = self.path(name)
            done = self.compare("original", "slow", options=["-o", out, "-q"])
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
            with open(out, encoding="utf-8") as file:
                self.assertTrue(file.read().startswith(start), name)
            self.assert_failure(self.compare("original", "slow", options=["-o", out]), 5, out)
            self.assert_quiet_success(self.compare("original", "slow", options=["-o", out, "--force", "--format", "csv"]))
        self.assertEqual(sorted(os.listdir(self.folder)), ["a", "a.csv", "a.json", "a.md", "a.txt"])
        done = self.compare("original", "slow", options=["-o", self.file("slow"), "--force"])
        self.assert_failure(done, 2, "would replace its input")
        self.assert_quiet_success(self.compare("original", "slow"))

    def test_files_of_the_same_name_are_told_apart(self):
        for folder in ("old", "new"):
            os.mkdir(self.path(folder))
            os.symlink(self.file("original"), self.path(folder + "/run.h5"))
        done = run("compare", self.path("old/run.h5"), self.path("new/run.h5"), "--json",
                   "--require", "peak(torque) == base", "--require", "energy(new/run) <= old/run")
        self.assert_quiet_success(done)
        self.assertEqual([one["name"] for one in json.loads(done.stdout)["runs"]], ["old/run", "new/run"])

    def test_runs_of_a_design_file(self):
        design = self.path("design.h5")
        spec = os.path.join(CONFIGS, "rr-design.yaml")
        done = run("design", spec, "--h5", design)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        names = [design + ":" + when + "/cycloid" for when in ("before", "after")]
        done = run("compare", *names, "--json", "--require", "energy() >= 0")
        self.assert_quiet_success(done)
        self.assertEqual([one["name"] for one in json.loads(done.stdout)["runs"]], ["before/cycloid", "after/cycloid"])

    def test_the_report_is_deterministic(self):
        for form in ("text", "markdown", "csv", "json", "junit"):
            outputs = {self.compare("original", "slow", options=["--format", form, "--require", "1 < 2"]).stdout
                       for _ in range(2)}
            self.assertEqual(len(outputs), 1, form)

    def test_a_full_disk_is_a_failure(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = run("compare", self.file("original"), self.file("slow"), stdout=full, stderr=subprocess.PIPE)
        self.assert_failure(done, 5)


if __name__ == "__main__":
    unittest.main()
