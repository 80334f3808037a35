#!/usr/bin/env python3
"""balance batch as a fence: cases that crash, hang or eat memory; signals; files that are not the batch's."""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import time
import unittest

from _program import CONFIGS, PROGRAM, Case, run
from _untimed import untimed

LONG = "{spec: SPEC, trajectory: cycloid, samples: 3000000}"  # half a minute at least
SHORT = "{spec: SPEC, trajectory: cycloid, samples: 21}"


def sanitized():
    with open(PROGRAM, "rb") as file:
        return b"__asan_init" in file.read()


def content(path):
    with open(path, "rb") as file:
        return file.read()


def children_of(process):
    """Processes whose parent is this one."""
    found = []
    for name in os.listdir("/proc"):
        if not name.isdigit():
            continue
        try:
            with open(f"/proc/{name}/stat", encoding="utf-8") as file:
                state, parent = file.read().rsplit(")", 1)[1].split()[:2]
        except OSError:
            continue
        if int(parent) == process and state != "Z":
            found.append(int(name))
    return found


def wait_for(condition, seconds=60):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.01)
    raise AssertionError("waited in vain")


def is_alive(process):
    """A process that has ended may be kept in the table until its new parent asks for it."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8") as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


class Fence(Case):
    def suite(self, text):
        return self.write("suite.yaml", text.replace("SPEC", os.path.join(CONFIGS, "3rrr.yaml")))

    def batch(self, suite, *arguments, out="out", **options):
        return run("batch", suite, "-o", self.path(out), *arguments, **options)

    def start(self, suite, *arguments):
        process = subprocess.Popen([PROGRAM, "batch", suite, "-o", self.path("out"), *arguments], text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def cases(self):
        with open(self.path("out/summary.json"), encoding="utf-8") as file:
            return {case["name"]: case for case in json.load(file)["cases"]}

    def statuses(self):
        return {name: case["status"] for name, case in self.cases().items()}


class Failures(Fence):
    def kill_first_child(self, number):
        suite = self.suite(f"cases: {{bad: {LONG}, a: {SHORT}, b: {SHORT}}}\nbaseline: a\n"
                           "require: peak(shaking_force) <= base\n")
        process = self.start(suite, "-j", "1")
        child = wait_for(lambda: children_of(process.pid))[0]
        os.kill(child, number)
        out, err = process.communicate(timeout=60)
        return suite, process.returncode, out, err

    def test_a_case_that_dies_is_a_failed_case_and_the_others_go_on(self):
        """(C1)"""
        for number, name in ((signal.SIGSEGV, "SIGSEGV"), (signal.SIGKILL, "SIGKILL"), (signal.SIGABRT, "SIGABRT")):
            with self.subTest(name=name):
                shutil.rmtree(self.path("out"), ignore_errors=True)
                _, code, out, _ = self.kill_first_child(number)
                self.assertEqual(code, 5)
                self.assertEqual(self.statuses(), {"bad": "failed", "a": "done", "b": "done"})
                self.assertIn("bad: crashed: " + name, out)
                self.assertIn("1 failed", out)
                for document in ("summary.json", "summary.md", "junit.xml"):
                    self.assertIn(b"crashed: " + name.encode(), content(self.path("out/" + document)))
                self.assertIn(b",cycloid,failed,", content(self.path("out/summary.csv")))
                self.assertFalse([name for name in os.listdir(self.path("out")) if name.endswith(".tmp")])

    def test_what_failed_is_not_tried_again_unless_asked_for(self):
        """(C1)"""
        suite, _, _, _ = self.kill_first_child(signal.SIGSEGV)
        before = content(self.path("out/summary.json"))
        done = self.batch(suite)
        self.assertEqual((done.returncode, done.stderr), (5, "note: 3 of 3 cases were finished already, 1 of them "
                                                          "without a result; --retry-failed computes those again\n"))
        self.assertEqual(content(self.path("out/summary.json")), before)
        self.assertEqual(self.batch(suite, "--merge").returncode, 5)
        self.assertEqual(content(self.path("out/summary.json")), before)
        done = self.batch(suite, "--retry-failed", "--case-timeout", "1")
        self.assertIn("exceeded --case-timeout 1 s", done.stdout)
        # Other input, other case.
        suite = self.suite(f"cases: {{bad: {SHORT}, a: {SHORT}, b: {SHORT}}}\n")
        done = self.batch(suite)
        self.assertEqual((done.returncode, done.stderr), (0, "note: 2 of 3 cases were finished already\n"))

    def test_a_case_that_takes_too_long_is_tried_again_with_more_time_only(self):
        """(C1)"""
        suite = self.suite(f"cases: {{a: {SHORT}, bad: {LONG}, b: {SHORT}}}\n")
        done = self.batch(suite, "--case-timeout", "2", "-j", "2")
        self.assertEqual(done.returncode, 5)
        self.assertEqual(self.statuses(), {"a": "done", "bad": "failed", "b": "done"})
        self.assertEqual(self.cases()["bad"]["message"], "exceeded --case-timeout 2 s")
        self.assertEqual(self.cases()["bad"]["cause"], "timeout")
        for limit, note in (("2", "3 of 3"), ("0.5s", "3 of 3"), ("2.5", "2 of 3")):
            done = self.batch(suite, "--case-timeout", limit)
            self.assertEqual(done.returncode, 5)
            self.assertIn(f"note: {note} cases were finished already", done.stderr)

    @unittest.skipIf(sanitized(), "sanitizers keep a shadow of the memory")
    def test_a_case_that_eats_memory_is_a_failed_case(self):
        """(C1)"""
        suite = self.suite(f"cases: {{a: {SHORT}, bad: {LONG}, b: {SHORT}}}\n")
        done = self.batch(suite, "--case-memory", "64", "-j", "1")
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertEqual(self.statuses(), {"a": "done", "bad": "failed", "b": "done"})
        self.assertEqual(self.cases()["bad"]["message"], "exceeded --case-memory 64 MiB")
        done = self.batch(suite, "--case-memory", "64MiB")
        self.assertIn("note: 3 of 3 cases were finished already", done.stderr)
        done = self.batch(suite, "--case-memory", "0.125GiB")
        self.assertIn("note: 2 of 3 cases were finished already", done.stderr)
        self.assertIn("exceeded --case-memory 128 MiB", done.stdout)

    def test_limits_that_are_none(self):
        suite = self.suite(f"cases: {{a: {SHORT}}}\n")
        for option, values in (("--case-timeout", ("-1", "ten", "nan", "inf", "1 parsec", "1e999")),
                               ("--case-memory", ("-1", "much", "1XiB", "nan", "1e30", "1e-9"))):
            for value in values:
                self.assert_failure(self.batch(suite, f"{option}={value}"), 2, option)
        self.assert_quiet_success(self.batch(suite, "--case-timeout", "1h", "--case-memory", "0"))

    def test_no_child_outlives_the_batch(self):
        """(C1)"""
        suite = self.suite(f"cases: {{a: {LONG}, b: {LONG}, c: {SHORT}}}\n")
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            with self.subTest(number=number):
                process = self.start(suite, "-j", "2")
                children = wait_for(lambda: len(c := children_of(process.pid)) == 2 and c)
                process.send_signal(number)
                process.communicate(timeout=60)
                self.assertIn(process.returncode, (-number, 128 + number))
                wait_for(lambda: not any(map(is_alive, children)))
                # What was not finished is not blamed: it was the batch that ended.
                self.assertNotIn("a.case.json", os.listdir(self.path("out")))


class Files(Fence):
    def test_a_batch_does_not_replace_what_it_reads(self):
        """(C4)"""
        spec = shutil.copy(os.path.join(CONFIGS, "5r-design.yaml"), self.path("dd.yaml"))
        before = content(spec)
        suite = self.write("s.yaml", "cases: {dd: {spec: dd.yaml, design: true}}")
        for arguments in (["--force"], ["--force", "--merge"], ["--force", "--shard", "1/1"], []):
            done = self.batch(suite, *arguments, out=".")
            self.assert_failure(done, 2, "the spec", "would be replaced by")
        os.symlink(".", self.path("same"))
        self.assert_failure(self.batch(suite, "--force", out="same"), 2, "would be replaced by")
        os.mkdir(self.path("out"))
        os.link(spec, self.path("out/dd.h5"))
        self.assert_failure(self.batch(suite, "--force"), 2, "would be replaced by")
        self.assertEqual(content(spec), before)

    def test_no_command_replaces_what_it_reads(self):
        """(C4)"""
        self.write("joints.csv", "time,J1\n0,0\n0.5,0.2\n0.7,0.3\n1,0.3\n")
        spec = self.write("arm.yaml", """
space: planar
bodies: {link: {mass: 1, com: [0.5, 0], inertia: {free: [0, 1], start: 0.1}, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {J1: {type: revolute, connects: [ground.O, link.A]}}
actuators: [J1]
design: {goal: static}
motion: {samples: 11}
trajectories: {recorded: {drive: joints, path: {file: joints.csv}}}
""")
        self.assert_quiet_success(run("simulate", spec, "-o", self.path("run.h5"), "-q"))
        inputs = {name: content(self.path(name)) for name in ("arm.yaml", "joints.csv", "run.h5")}
        for name in inputs:
            os.link(self.path(name), self.path("hard-" + name))
            os.symlink(name, self.path("soft-" + name))
        for name in ("arm.yaml", "joints.csv", "hard-arm.yaml", "soft-arm.yaml", "hard-joints.csv", "./joints.csv"):
            for command in (["simulate", spec, "-o"], ["simulate", spec, "--csv"], ["control", spec, "-o"],
                            ["design", spec, "--h5"], ["report", spec, "-o"]):
                with self.subTest(command=command, name=name):
                    self.assert_failure(run(*command, self.path(name), "--force"), 2, "would replace")
        self.assert_failure(run("design", spec, "-o", self.path("joints.csv"), "--force"), 2, "would replace a table")
        for name in ("run.h5", "hard-run.h5", "soft-run.h5"):
            path = self.path(name)
            self.assert_failure(run("report", self.path("run.h5"), "-o", path, "--force"), 2, "would replace")
            self.assert_failure(run("compare", self.path("run.h5"), self.path("run.h5"), "-o", path, "--force"), 2,
                                "would replace")
        os.rename(self.path("hard-run.h5"), self.path("hard-run.svg"))
        self.assert_failure(run("plot", self.path("run.h5"), "-o", self.path("hard-run.svg"), "--force"), 2,
                            "would replace")
        for name, bytes_before in inputs.items():
            self.assertEqual(content(self.path(name)), bytes_before, name)

    def test_a_record_with_a_changed_digit_is_computed_again(self):
        """(C5)"""
        suite = self.suite(f"cases: {{a: {SHORT}, b: {SHORT}}}\nbaseline: a\nrequire: peak(shaking_force) <= base\n")
        self.assert_quiet_success(self.batch(suite))
        whole = {name: content(self.path("out/" + name)) for name in os.listdir(self.path("out"))}
        for name, change in (("b.case.json", lambda text: text.replace(b'"peak": 8', b'"peak": 9').replace(
                                 b'"peak": 5', b'"peak": 9')),
                             ("b.case.json", lambda text: text + b"\n"),
                             ("b.h5", lambda text: text[:5000] + bytes([text[5000] ^ 1]) + text[5001:])):
            changed = change(whole[name])
            self.assertNotEqual(changed, whole[name])
            with open(self.path("out/" + name), "wb") as file:
                file.write(changed)
            done = self.batch(suite)
            self.assertEqual((done.returncode, done.stderr), (0, "note: 1 of 2 cases were finished already\n"))
            self.assertEqual({name: untimed(content(self.path("out/" + name))) for name in whole}, {name: untimed(text) for name, text in whole.items()})

    def test_a_record_that_no_batch_writes_is_computed_again(self):
        """(C5)"""
        suite = self.suite(f"cases: {{a: {SHORT}}}\n")
        self.assert_quiet_success(self.batch(suite, "--metrics-only"))
        path = self.path("out/a.case.json")
        honest = content(path).decode()
        os.truncate(path, 1 << 32)  # of nothing: it takes no room on the disk
        limited = ["sh", "-c", 'ulimit -v 2000000; exec "$0" "$@"'] if not sanitized() else []
        done = subprocess.run([*limited, PROGRAM, "batch", suite, "-o", self.path("out"), "--metrics-only"],
                              capture_output=True, text=True, check=False, timeout=60)
        self.assert_quiet_success(done)
        self.assertEqual(untimed(content(path)), untimed(honest.encode()))
        for old, new in (('"status": "done"', '"status": "splendid"'),
                         ('"files": []', '"files": [\n    {\n      "name": "../suite.yaml",\n      "sha256": "SUM"\n    }\n  ]')):
            with open(suite, "rb") as file:
                new = new.replace("SUM", hashlib.sha256(file.read()).hexdigest())
            changed = honest[:honest.rindex(",\n  \"sha256\"")].replace(old, new)
            digest = hashlib.sha256((changed + "\n}\n").encode()).hexdigest()
            self.write("out/a.case.json", f'{changed},\n  "sha256": "{digest}"\n}}\n')
            self.assert_quiet_success(self.batch(suite, "--metrics-only"))
            self.assertEqual(untimed(content(path)), untimed(honest.encode()))

    def test_links_in_the_folder_are_replaced_and_not_followed(self):
        """(C6)"""
        suite = self.suite(f"cases: {{a: {{spec: {CONFIGS}/5r-design.yaml, samples: 21, design: true}}, b: {SHORT}}}\n")
        os.mkdir(self.path("out"))
        self.write("out/.batch.lock", "")
        names = ("a.h5", "a.yaml", "a.case.json", "summary.json", "summary.csv", "summary.md", "junit.xml")
        for name in names:
            self.write("victim-" + name, "precious")
            os.symlink("../victim-" + name, self.path("out/" + name))
        os.symlink("../not-there", self.path("out/b.h5"))
        self.assert_quiet_success(self.batch(suite))
        for name in names:
            self.assertEqual(content(self.path("victim-" + name)), b"precious")
            self.assertFalse(os.path.islink(self.path("out/" + name)), name)
        self.assertFalse(os.path.exists(self.path("not-there")))
        # A link to the very same bytes is no result either.
        os.rename(self.path("out/b.h5"), self.path("elsewhere.h5"))
        os.symlink("../elsewhere.h5", self.path("out/b.h5"))
        done = self.batch(suite)
        self.assertIn("note: 1 of 2 cases were finished already", done.stderr)
        self.assertFalse(os.path.islink(self.path("out/b.h5")))
        # The folder itself may be a link, the lock may not.
        os.symlink("out", self.path("other"))
        self.assertEqual(self.batch(suite, out="other").returncode, 0)
        os.remove(self.path("out/.batch.lock"))
        os.symlink("../victim-a.h5", self.path("out/.batch.lock"))
        self.assert_failure(self.batch(suite), 5, ".batch.lock: it is a symbolic link")

    def test_no_writer_follows_a_link(self):
        """(C6)"""
        spec = os.path.join(CONFIGS, "double-pendulum.yaml")
        self.write("victim", "precious")
        for name in ("a.h5", "a.csv", "a.html"):
            os.symlink("victim", self.path(name))
        for command in (["simulate", spec, "-o", self.path("a.h5")], ["simulate", spec, "--csv", self.path("a.csv")],
                        ["report", spec, "-o", self.path("a.html")]):
            self.assert_failure(run(*command, "--force"), 5, "it is a symbolic link, which is not followed")
        self.assertEqual(content(self.path("victim")), b"precious")

    def test_only_unfinished_files_of_dead_batches_are_removed(self):
        """(C7)"""
        suite = self.suite(f"cases: {{a: {SHORT}}}\n")
        self.assert_quiet_success(self.batch(suite))
        foreign = (".mine.h5.01234567.tmp", ".a.h5.01234567.tmp", ".b.h5.batch-01234567.tmp", ".a.h5.tmp", "a.tmp")
        for name in foreign + (".a.h5.batch-01234567.tmp", ".junit.xml.batch-89abcdef.tmp"):
            self.write("out/" + name, "x")
        self.assertEqual(self.batch(suite).returncode, 0)
        left = [name for name in os.listdir(self.path("out")) if name.endswith(".tmp")]
        self.assertEqual(sorted(left), sorted(foreign))

    def test_a_command_that_writes_into_the_folder_is_not_disturbed(self):
        """(C7)"""
        suite = self.suite(f"cases: {{a: {SHORT}}}\n")
        self.assert_quiet_success(self.batch(suite))
        process = subprocess.Popen([PROGRAM, "simulate", os.path.join(CONFIGS, "double-pendulum.yaml"), "--samples",
                                    "40000", "-o", self.path("out/mine.h5"), "-q"], stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        wait_for(lambda: process.poll() is not None or any("mine" in name for name in os.listdir(self.path("out"))))
        process.send_signal(signal.SIGSTOP)  # it writes for as long as the batch takes
        self.assertEqual(self.batch(suite).returncode, 0)
        process.send_signal(signal.SIGCONT)
        self.assertEqual(("", 0), (process.communicate(timeout=100)[1], process.returncode))

    def test_another_build_computes_again(self):
        """(C11)"""
        suite = self.suite(f"cases: {{a: {SHORT}}}\n")
        program = shutil.copy(PROGRAM, self.path("balance"))
        def batch():
            return subprocess.run([program, "batch", suite, "-o", self.path("out")], capture_output=True, text=True,
                                  check=False, timeout=120)
        self.assert_quiet_success(batch())
        self.assertIn("note: 1 of 1 cases were finished already", batch().stderr)
        with open(program, "ab") as file:
            file.write(b"\0")
        self.assert_quiet_success(batch())
        self.assertIn("note: 1 of 1 cases were finished already", batch().stderr)
        self.assertEqual(self.batch(suite).stderr, "")

    def test_metrics_without_samples(self):
        """(D9)"""
        suite = self.suite(f"cases: {{a: {SHORT}, b: {{spec: {CONFIGS}/5r-design.yaml, samples: 21, design: true}}}}\n"
                           "baseline: a\nrequire: [\"peak(torque, b) > 0\", peak(torque) > 0]\n")
        self.assert_quiet_success(self.batch(suite, "--metrics-only", out="few"))
        self.assertEqual(sorted(os.listdir(self.path("few"))), [".batch.lock", "a.case.json", "b.case.json", "b.yaml",
                                                                "junit.xml", "summary.csv", "summary.json",
                                                                "summary.md"])
        self.assert_quiet_success(self.batch(suite, out="all"))
        for name in ("summary.csv", "summary.md", "junit.xml"):
            self.assertEqual(untimed(content(self.path("few/" + name))), untimed(content(self.path("all/" + name))), name)
        # What has samples has metrics, not the other way round.
        self.assertIn("2 of 2", self.batch(suite, "--metrics-only", out="few").stderr)
        self.assertIn("2 of 2", self.batch(suite, "--metrics-only", out="all").stderr)
        self.assertEqual(self.batch(suite, "--merge", out="few").returncode, 0)
        self.assert_quiet_success(self.batch(suite, out="few"))
        self.assertEqual({name: untimed(content(self.path("few/" + name)))
                          for name in os.listdir(self.path("few"))},
                         {name: untimed(content(self.path("all/" + name)))
                          for name in os.listdir(self.path("all"))})

    def test_names_are_no_formulas(self):
        """(C8)"""
        for name in ("=1+1", "+a", "'@a'", "'=a'", "a b", "a/b", "\"a\\e[0mb\"", "\"a\\u202Eb\"", "',a'", "-a", ".a", "\"\\ta\""):
            self.assert_failure(self.batch(self.suite(f"cases: {{{name}: {SHORT}}}\n")), 3, "expected a name usable as a file name")
        self.assert_quiet_success(self.batch(self.suite(f"cases: {{a: {SHORT}, 2-b.c_d: {SHORT}, e=1: {SHORT}, größe: {SHORT}}}\n")))
        self.assertTrue(os.path.exists(self.path("out/größe.h5")))
        # Made of files' names that begin in other ways
        for stem in ("+a", "-b", ".c", "=d", "_e"):
            shutil.copy(os.path.join(CONFIGS, "3rrr.yaml"), self.path(stem + ".yaml"))
        done = run("batch", self.write("m.yaml", "matrix: {spec: [+a.yaml, ./-b.yaml, ./.c.yaml, =d.yaml, _e.yaml]}"),
                   "--list")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for line in done.stdout.split():
            self.assertTrue(line[0].isalnum() or line[0] == "_", line)


if __name__ == "__main__":
    unittest.main()
