#!/usr/bin/env python3
"""balance batch: cases, failures, requirements, interrupted runs, shards."""

import fcntl
import hashlib
import json
import os
import random
import signal
import subprocess
import time
import unittest
import xml.etree.ElementTree as xml

from _program import CONFIGS, PROGRAM, Case, run
from _untimed import untimed

SUITE = os.path.join(CONFIGS, "suites", "p3.yaml")
MANY = """
defaults: {samples: 301}
matrix:
  spec: SPEC
  trajectory: [cycloid, tool-bang]
  set: {xg: {from: -0.09, to: 0.09, count: 10}}
baseline: "3rrr_cycloid_xg=0.09"
require:
  - peak(shaking_force) <= 2 * base
"""


def contents(folder):
    """SHA-256 of every file that is a result, without durations."""
    found = {}
    for name in sorted(os.listdir(folder)):
        if not name.startswith("."):
            with open(os.path.join(folder, name), "rb") as file:
                found[name] = hashlib.sha256(untimed(file.read())).hexdigest()
    return found


class Batch(Case):
    def suite(self, text, name="suite.yaml"):
        """The folder has no mechanisms: the suite names those of the configs by their full paths."""
        text = text.replace("SPEC", os.path.join(CONFIGS, "3rrr.yaml"))
        return self.write(name, text)

    def batch(self, suite, *arguments, out="out", **options):
        return run("batch", suite, "-o", self.path(out), *arguments, **options)

    def summary(self, out="out"):
        with open(os.path.join(self.path(out), "summary.json"), encoding="utf-8") as file:
            return json.load(file)

    def failures(self, out="out"):
        """Names of the JUnit test cases with a failure, and with an error."""
        root = xml.parse(os.path.join(self.path(out), "junit.xml")).getroot()
        return [[case.get("name") for case in root.iter("testcase") if case.find(kind) is not None]
                for kind in ("failure", "error")]

    def statuses(self, out="out"):
        return {case["name"]: case["status"] for case in self.summary(out)["cases"]}


class Results(Batch):
    def test_the_suite_of_p3_holds(self):
        done = self.batch(SUITE)
        self.assert_quiet_success(done)
        self.assertEqual(self.failures(), [[], []])
        peaks = {case["name"]: next(m["peak"] for m in case["metrics"] if m["quantity"] == "shaking_force")
                 for case in self.summary()["cases"]}
        self.assertAlmostEqual(peaks["com-bang-bang"], 549.2528818391, places=6)
        self.assertAlmostEqual(peaks["redistributed"], 402.4922359500, places=6)

    def test_without_the_redistribution_p3_misses_its_requirements(self):
        with open(os.path.join(CONFIGS, "3rrr-redistributed.yaml"), encoding="utf-8") as file:
            spec = file.read()
        self.assertIn("xg: -0.09", spec)
        self.write("3rrr-redistributed.yaml", spec.replace("xg: -0.09", "xg: 0.09"))
        os.symlink(os.path.join(CONFIGS, "3rrr.yaml"), self.path("3rrr.yaml"))
        os.mkdir(self.path("suites"))
        with open(SUITE, encoding="utf-8") as file:
            suite = self.write("suites/p3.yaml", file.read())
        done = self.batch(suite)
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        failed, errors = self.failures()
        self.assertIn("peak(shaking_force, redistributed) <= 0.47 * base", failed)
        self.assertEqual(errors, [])
        last = done.stdout.splitlines()[-2:]
        self.assertRegex(last[0], r"^FAILED peak\(shaking_force, redistributed\) <= 0\.47 \* base: [\d.]+ N is [\d.]+ % above the limit of [\d.]+ N$")
        self.assertRegex(last[1], r"^FAILED range\(shaking_force, redistributed\) <= 1e-6: ([\d.]+) N is [\d.]+ N above the limit of 1e-06 N$")
        done = self.batch(suite, "--quiet")
        self.assertEqual((done.returncode, done.stdout, done.stderr.splitlines()[-2:]), (1, "", last))

    def test_a_case_is_what_simulate_writes(self):
        suite = self.suite("cases: {a: {spec: SPEC, trajectory: tool-bang, samples: 101, set: {xg: 0.01}}}")
        self.assert_quiet_success(self.batch(suite))
        one = run("simulate", os.path.join(CONFIGS, "3rrr.yaml"), "-t", "tool-bang", "--samples", "101", "--set", "xg=0.01",
                  "-q", "-o", self.path("one.h5"))
        self.assert_quiet_success(one)
        with open(self.path("one.h5"), "rb") as one_file, open(self.path("out/a.h5"), "rb") as other:
            self.assertTrue(one_file.read() == other.read())

    def test_designed_cases_are_balanced(self):
        spec = os.path.join(CONFIGS, "3rrr-force-balance.yaml")
        suite = self.suite(f"cases:\n  before: {{spec: {spec}, trajectory: cycloid, samples: 101}}\n"
                           f"  after: {{spec: {spec}, trajectory: cycloid, samples: 101, design: true}}\n"
                           "baseline: before\nrequire: peak(shaking_force) <= 1e-9 * base\n")
        done = self.batch(suite)
        self.assert_quiet_success(done)
        after = self.summary()["cases"][1]
        self.assertEqual(after["design"]["status"], "balanced")
        self.assertAlmostEqual(after["design"]["mass_after"] - after["design"]["mass_before"], 36.18, places=6)
        again = run("simulate", self.path("out/after.yaml"), "-t", "cycloid", "--samples", "101", "-o", self.path("a.h5"))
        self.assert_quiet_success(again)
        with open(self.path("a.h5"), "rb") as one, open(self.path("out/after.h5"), "rb") as other:
            self.assertTrue(one.read() == other.read())

    def test_a_compromise_ends_with_1(self):
        spec = os.path.join(CONFIGS, "5r-impossible.yaml")
        done = self.batch(self.suite(f"cases: {{a: {{spec: {spec}, samples: 11, design: true}}}}"))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(self.statuses(), {"a": "compromise"})
        self.assertEqual(self.failures(), [["a"], []])

    def test_one_thread_or_two_write_the_same_bytes(self):
        suite = self.suite(MANY)
        for jobs in ("1", "2", "7"):
            self.assert_quiet_success(self.batch(suite, "-j", jobs, out=jobs))
        self.assertEqual(len(contents(self.path("1"))), 2 * 20 + 4)
        self.assertEqual(contents(self.path("1")), contents(self.path("2")))
        self.assertEqual(contents(self.path("1")), contents(self.path("7")))

    def test_json_is_the_summary(self):
        done = self.batch(SUITE, "--json")
        self.assertEqual(json.loads(done.stdout), self.summary())


class Failures(Batch):
    def test_a_case_that_fails_does_not_stop_the_others(self):
        self.write("broken.yaml", "space: planar\nbodies: 3\njoints: {}\n")
        suite = self.suite("""
cases:
  good: {spec: SPEC, samples: 101}
  broken: {spec: broken.yaml}
  far: {spec: far.yaml}
  absent: {spec: nowhere.yaml}
  misspelt: {spec: SPEC, trajectory: cycloyd}
  unknown: {spec: SPEC, set: {xgg: 1}}
baseline: good
require: peak(shaking_force) <= base
""")
        with open(os.path.join(CONFIGS, "3rrr.yaml"), encoding="utf-8") as file:
            self.write("far.yaml", file.read().replace("to: {tool: [0.1, 0.05]", "to: {tool: [5, 5]"))
        done = self.batch(suite)
        self.assertEqual((done.returncode, done.stderr), (5, ""))
        self.assertEqual(self.statuses(), {"good": "done", "broken": "spec", "far": "mechanism", "absent": "system",
                                           "misspelt": "spec", "unknown": "spec"})
        self.assertEqual(self.failures()[1], ["broken", "far", "absent", "misspelt", "unknown"])
        for part in ("suite.yaml:7:41: cases.misspelt.trajectory: expected a trajectory", "nearest is 'cycloid'",
                     "suite.yaml:8:", "cases.unknown.set.xgg: expected a parameter", "nearest is 'xg'",
                     "suite.yaml:6:18: cases.absent.spec: ", "broken.yaml:2:9: bodies: ", "not judged: far has no result"):
            self.assertIn(part.replace("41", str(done.stdout.split("suite.yaml:7:")[1].split(":")[0])), done.stdout)

    def test_the_exit_code_is_that_of_the_worst_case(self):
        text = "cases: {good: {spec: SPEC, samples: 11}, bad: {spec: SPEC, samples: 11, trajectory: none}}"
        self.assertEqual(self.batch(self.suite(text)).returncode, 3)

    def test_a_requirement_on_a_quantity_that_nobody_has_is_a_mistake(self):
        done = self.batch(self.suite("cases: {a: {spec: SPEC, samples: 11}}\nrequire: peak(shaking_farce) < 1\n"))
        self.assertEqual(done.returncode, 3)
        self.assertIn("suite.yaml:2:10: require: ", done.stdout)
        self.assertIn("nearest is 'shaking_force'", done.stdout)

    def test_mistakes_in_a_suite_have_a_place(self):
        for text, message in (
            ("case: {}\n", "suite.yaml:1:1: case: unknown key"),
            ("cases: {}\n", "expected at least one case"),
            ("cases: {a: {}}\n", "suite.yaml:1:9: cases.a: missing key: expected 'spec'"),
            ("cases: {../a: {spec: SPEC}}\n", "expected a name usable as a file name"),
            ("cases: {.a: {spec: SPEC}}\n", "expected a name usable as a file name"),
            ("cases: [{spec: SPEC, name: a}, {name: a, spec: SPEC}]\n", "a unique name for each case"),
            ("cases: {a: {spec: SPEC, samples: 1}}\n", "a whole number from 2"),
            ("cases: {a: {spec: SPEC, sett: {}}}\n", "nearest is 'set'"),
            ("cases: {a: {spec: SPEC}}\nbaseline: b\n", "suite.yaml:2:11: baseline: expected the name of a case"),
            ("cases: {a: {spec: SPEC}}\nrequire: [peak(torque)]\n", "suite.yaml:2:11: require[0]: "),
            ("cases: {a: {spec: SPEC}}\nrequire: [peak(torque) < base]\n", "suite.yaml:2:11: require[0]: "),
            ("cases: {a: {spec: SPEC, design: maybe}}\n", "cases.a.design: expected"),
            ("matrix: {spec: []}\n", "matrix.spec: expected at least one"),
            ("matrix: {spec: a.yaml, set: {x: {from: 0, to: 1}}}\n", "missing key: expected 'count'"),
            ("matrix: {spec: a.yaml, set: {x: {from: 0, to: 1, count: 9999}, y: {from: 0, to: 1, count: 9999}}}\n",
             "expected at most 100000 cases"),
            ("[", "suite.yaml:"),
            ("", "expected a suite"),
        ):
            with self.subTest(text=text):
                done = self.batch(self.suite(text))
                self.assert_failure(done, 3, message)
                self.assertFalse(os.path.exists(self.path("out")))

    def test_wrong_usage(self):
        for arguments, message in ((["--shard", "3/2"], "--shard needs i/n"), (["--shard", "1"], "--shard needs i/n"),
                                   (["--shard", "0/2"], "--shard needs i/n"), (["-j", "0"], "--jobs"),
                                   (["--shard", "1/2", "--merge"], "--merge")):
            with self.subTest(arguments=arguments):
                self.assert_failure(self.batch(SUITE, *arguments), 2, message)
        self.assert_failure(run("batch", self.path("none.yaml")), 5, "none.yaml: cannot read the suite")

    def test_a_folder_with_other_things_is_left_alone(self):
        os.mkdir(self.path("out"))
        self.write("out/original.h5", "mine")
        self.assert_failure(self.batch(SUITE), 5, "neither empty nor the folder of a batch")
        with open(self.path("out/original.h5"), encoding="utf-8") as file:
            self.assertEqual(file.read(), "mine")
        self.assert_quiet_success(self.batch(SUITE, "--force"))


class Resuming(Batch):
    def test_a_batch_killed_at_any_moment_ends_with_the_same_bytes(self):
        suite = self.suite(MANY)
        started = time.monotonic()
        self.assert_quiet_success(self.batch(suite, out="whole"))
        duration = time.monotonic() - started
        rng = random.Random(20200401)
        kills = 0
        for _ in range(8):
            process = subprocess.Popen([PROGRAM, "batch", suite, "-o", self.path("killed"), "-q"], stderr=subprocess.PIPE)
            time.sleep(rng.uniform(0, 0.6 * duration))
            process.send_signal(signal.SIGKILL)
            process.communicate()
            kills += process.returncode == -signal.SIGKILL
        self.assertGreater(kills, 0)
        done = self.batch(suite, out="killed")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(contents(self.path("whole")), contents(self.path("killed")))
        self.assertFalse([name for name in os.listdir(self.path("killed")) if name.endswith(".tmp")])

    def test_what_is_finished_is_not_computed_again(self):
        suite = self.suite("cases: {a: {spec: SPEC, samples: 11}, b: {spec: SPEC, samples: 12}}")
        self.assert_quiet_success(self.batch(suite))
        before = {name: os.stat(self.path("out/" + name)).st_mtime_ns for name in ("a.h5", "b.h5")}
        done = self.batch(self.suite("cases: {a: {spec: SPEC, samples: 11}, b: {spec: SPEC, samples: 13}}"))
        self.assertEqual((done.returncode, done.stderr), (0, "note: 1 of 2 cases were finished already\n"))
        after = {name: os.stat(self.path("out/" + name)).st_mtime_ns for name in ("a.h5", "b.h5")}
        self.assertEqual(before["a.h5"], after["a.h5"])
        self.assertNotEqual(before["b.h5"], after["b.h5"])

    def test_a_damaged_result_is_computed_again(self):
        suite = self.suite("cases: {a: {spec: SPEC, samples: 11}}")
        self.assert_quiet_success(self.batch(suite))
        whole = contents(self.path("out"))
        for name, size in (("a.h5", 1000), ("a.case.json", 40)):
            os.truncate(self.path("out/" + name), size)
            self.assert_quiet_success(self.batch(suite))
            self.assertEqual(contents(self.path("out")), whole)

    def test_a_changed_table_is_noticed(self):
        self.write("joints.csv", "time,J1\n0,0\n0.5,0.2\n0.7,0.3\n1,0.3\n")
        self.write("arm.yaml", """
space: planar
bodies: {link: {mass: 1, com: [0.5, 0], inertia: 0.1, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {J1: {type: revolute, connects: [ground.O, link.A]}}
actuators: [J1]
motion: {samples: 11}
trajectories: {recorded: {drive: joints, path: {file: joints.csv}}}
""")
        suite = self.suite("cases: {a: {spec: arm.yaml, trajectory: recorded}}")
        done = self.batch(suite)
        self.assert_quiet_success(done)
        before = contents(self.path("out"))["a.h5"]
        self.write("joints.csv", "time,J1\n0,0\n0.5,0.25\n0.7,0.3\n1,0.3\n")
        self.assert_quiet_success(self.batch(suite))
        self.assertNotEqual(before, contents(self.path("out"))["a.h5"])

    def test_two_batches_do_not_share_a_folder(self):
        self.assert_quiet_success(self.batch(SUITE))
        with open(self.path("out/.batch.lock"), "rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.assert_failure(self.batch(SUITE), 5, "another batch is running in")
            self.assert_failure(self.batch(SUITE, "--shard", "1/2"), 5, "another batch is running in")


class Shards(Batch):
    def test_shards_merged_are_the_whole(self):
        suite = self.suite(MANY)
        self.assert_quiet_success(self.batch(suite, out="whole"))
        listed = []
        for shard in ("2/3", "1/3", "3/3"):
            listed += run("batch", suite, "--list", "--shard", shard).stdout.split()
            self.assert_quiet_success(self.batch(suite, "--shard", shard, out="parts"))
        self.assertEqual(sorted(listed), sorted(run("batch", suite, "--list").stdout.split()))
        self.assertFalse(os.path.exists(self.path("parts/summary.json")))
        self.assert_quiet_success(self.batch(suite, "--merge", out="parts"))
        self.assertEqual(contents(self.path("whole")), contents(self.path("parts")))

    def test_a_shard_does_not_depend_on_the_order_of_the_cases(self):
        names = {}
        for order in ("abcdefgh", "hgfedcba"):
            cases = ", ".join(f"{name}: {{spec: SPEC}}" for name in order)
            names[order] = run("batch", self.suite(f"cases: {{{cases}}}"), "--list", "--shard", "1/2").stdout.split()
        self.assertEqual(sorted(names["abcdefgh"]), sorted(names["hgfedcba"]))

    def test_merging_names_what_is_missing(self):
        suite = self.suite(MANY)
        self.assert_quiet_success(self.batch(suite, "--shard", "1/2"))
        done = self.batch(suite, "--merge")
        self.assertEqual(done.returncode, 5, done.stderr)
        missing = run("batch", suite, "--list", "--shard", "2/2").stdout.split()
        self.assertTrue(missing)
        self.assertEqual(sorted(name for name, status in self.statuses().items() if status == "missing"), sorted(missing))
        self.assert_failure(self.batch(suite, "--merge", out="nowhere"), 5, "no such folder")


if __name__ == "__main__":
    unittest.main()
