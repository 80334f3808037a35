"""Faults of the system: a full disk, a read-only folder, damaged files, signals, a stdout that takes nothing. Whatever happens, no
file is half there, an older file is as it was, the message is one line, and the exit code says what it was."""

import ctypes
import ctypes.util
import os
import random
import resource
import signal
import subprocess
import time
import unittest

from _program import CONFIGS, PROGRAM, SPEC, Case, run

CONTROL = os.path.join(CONFIGS, "control-5r.yaml")
DESIGN = os.path.join(CONFIGS, "5r-design.yaml")
SUITE = os.path.join(CONFIGS, "suites", "p3.yaml")
SEED = 20261121
ENDS = {".h5": b"balance:", ".html": b"</html>", ".svg": b"</svg>", ".csv": b"\n", ".json": b"}\n"}  # what whole files end with


def mount_small(folder, size):
    """Whether a file system of so many bytes could be mounted there."""
    libc = ctypes.CDLL(ctypes.util.find_library("c"), use_errno=True)
    return libc.mount(b"tmpfs", folder.encode(), b"tmpfs", 0, f"size={size}".encode()) == 0


def unmount(folder):
    libc = ctypes.CDLL(ctypes.util.find_library("c"), use_errno=True)
    libc.umount2(folder.encode(), 2)


def content(path):
    with open(path, "rb") as file:
        return file.read()


class Faults(Case):
    def result(self, name="a.h5"):
        path = self.path(name)
        self.assert_quiet_success(run("simulate", SPEC, "-t", "cycloid", "--samples", "51", "-o", path, "--quiet"))
        return path

    def writers(self, folder):
        """Commands that write files into a folder, by name."""
        at = lambda name: os.path.join(folder, name)
        good = self.result("good.h5")
        writers = {
            "simulate": ["simulate", SPEC, "-t", "cycloid", "-o", at("a.h5"), "--csv", at("a.csv"), "--force"],
            "simulate compressed": ["simulate", SPEC, "-t", "cycloid", "-o", at("a.h5"), "--compress", "--force"],
            "design": ["design", DESIGN, "-o", at("a.yaml"), "--h5", at("a.h5"), "--force"],
            "control": ["control", CONTROL, "-o", at("a.h5"), "--csv", at("a.csv"), "--force"],
            "compare": ["compare", good, good, "--format", "json", "-o", at("a.json"), "--force"],
            "plot": ["plot", good, "-o", at("a.svg"), "--force"],
            "batch": ["batch", SUITE, "-o", at("out"), "--quiet"],
        }
        if self.has_page():
            writers["report"] = ["report", SPEC, "--samples", "51", "-o", at("a.html"), "--force"]
        return writers

    def has_page(self):
        """Whether the program was built with the scripts of the page."""
        return run("report", SPEC, "--samples", "2", "-o", self.path("page.html"), "--force").returncode == 0

    def assert_file_failure(self, done, name):
        self.assertEqual(done.returncode, 5, (name, done.stdout[-300:], done.stderr))
        self.assertNotIn("internal error", done.stderr, name)
        self.assertIn("cannot write", done.stderr, name)

    def assert_no_remains(self, folder):
        """Nothing but what may stay: no temporary file, no result that is not whole."""
        for where, _, names in os.walk(folder):
            for name in names:
                self.assertFalse(name.endswith(".tmp"), os.path.join(where, name))
                for kind, end in ENDS.items():
                    if name.endswith(kind):
                        self.assertIn(end, content(os.path.join(where, name))[-16:], name)

    def test_a_full_disk(self):
        disk = self.path("disk")
        os.mkdir(disk)
        if not mount_small(disk, 4 << 10):
            self.skipTest("no file system can be mounted here: the test of file sizes stands in")
        try:
            for name, command in self.writers(disk).items():
                self.assert_file_failure(run(*command), name)
                self.assert_no_remains(disk)
        finally:
            unmount(disk)

    def test_a_limit_on_the_size_of_files(self):
        for name, command in self.writers(self.folder).items():
            limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))
            done = run(*command, preexec_fn=limit)
            self.assert_file_failure(done, name)
            self.assert_no_remains(self.folder)

    def test_a_folder_that_cannot_be_written(self):
        if os.geteuid() == 0:
            folder = "/proc"  # where not even root writes
        else:
            folder = self.path("locked")
            os.mkdir(folder, 0o555)
        for name, command in self.writers(folder).items():
            done = run(*command)
            self.assertEqual(done.returncode, 5, (name, done.stderr))
            self.assertNotIn("internal error", done.stderr, name)

    def test_an_older_file_survives_a_failure(self):
        path = self.result()
        before = content(path)
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))
        done = run("simulate", SPEC, "-t", "cycloid", "-o", path, "--force", preexec_fn=limit)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(content(path), before)

    def test_results_that_are_cut_off_or_damaged_are_refused_by_every_reader(self):
        good = self.result("good.h5")
        whole = content(good)
        loads = "\nloads: {l: {on: platform, file: bad.h5}}\n"
        spec = self.write("table.yaml", content(SPEC).decode() + loads)
        led = self.write("led.yaml", content(CONTROL).decode() + loads.replace("platform", "coupler1"))
        suite = self.write("suite.yaml", "cases: {a: {spec: table.yaml, trajectory: cycloid}}\n")
        chance = random.Random(SEED)
        for trial in range(48):
            bytes_ = bytearray(whole)
            at = chance.randrange(len(whole))
            if trial % 2:
                del bytes_[at:]
            else:
                bytes_[at] ^= 1 << chance.randrange(8)
            with open(self.path("bad.h5"), "wb") as file:
                file.write(bytes_)
            bad = self.path("bad.h5")
            command, code = [
                (["compare", good, bad], 5),
                (["plot", bad, "--quantity", "shaking_force", "-o", self.path("a.svg")], 5),
                (["simulate", spec], 3),
                (["control", led], 3),
                (["report", spec, "-o", self.path("a.html")], 3),
                (["batch", suite, "-o", self.path("out")], 3),
            ][trial // 2 % 6]
            done = run(*command)
            where = (trial, at, len(whole), command[0], done.stderr)
            self.assertEqual(done.returncode, code, where)
            # a batch goes on with its other cases and tells of this one in its summary
            self.assertIn("bad.h5", done.stdout if command[0] == "batch" else done.stderr, where)
            self.assertEqual(done.stderr.count("\n"), int(command[0] != "batch"), where)
            for name in ("a.svg", "a.html", "table.h5", "led.h5"):
                self.assertFalse(os.path.exists(self.path(name)), where)

    def test_signals_at_random_moments_leave_whole_files_or_none(self):
        chance = random.Random(SEED)
        for name, command in self.writers(self.folder).items():
            for sent in (signal.SIGINT, signal.SIGKILL, signal.SIGTERM):
                process = subprocess.Popen([PROGRAM, *command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                time.sleep(chance.uniform(0.0, 0.15))
                process.send_signal(sent)
                stderr = process.communicate(timeout=60)[1].decode()
                ends = (0, -sent, 128 + sent) + ((1,) if name == "design" else ())
                self.assertIn(process.returncode, ends, (name, sent, stderr))
                if sent != signal.SIGKILL and name != "batch":
                    self.assert_no_remains(self.folder)
                else:  # nobody can clean up (of a batch, the next one does); but no temporary file bears the name of a result
                    for where, _, names in os.walk(self.folder):
                        for left in names:
                            if left.endswith(".tmp"):
                                self.assertTrue(left.startswith("."), left)
                                os.unlink(os.path.join(where, left))
                    self.assert_no_remains(self.folder)

    def test_a_stdout_that_takes_nothing_is_a_failure_of_the_system(self):
        good = self.result("good.h5")
        commands = [
            ["--help"],
            ["--version"],
            ["batch", SUITE, "-o", self.path("out")],
            ["check", SPEC],
            ["check", SPEC, "--json"],
            ["compare", good, good],
            ["compare", good, good, "--json"],
            ["completion", "bash"],
            ["conditions", DESIGN, "--goal", "static"],
            ["conditions", DESIGN, "--goal", "static", "--latex"],
            ["control", CONTROL, "--samples", "51"],
            ["design", DESIGN],
            ["new"],
            ["new", "four-bar"],
            ["plot", good, "--quantity", "shaking_force", "-o", self.path("a.svg")],
            ["simulate", SPEC, "-t", "cycloid", "--samples", "51"],
            ["simulate", SPEC, "-t", "cycloid", "--samples", "51", "--json"],
        ]
        if self.has_page():
            commands.append(["report", SPEC, "--samples", "2", "-o", self.path("a.html")])
        for command in commands:
            with open("/dev/full", "w", encoding="utf-8") as full:
                done = run(*command, stdout=full)
            self.assertEqual(done.returncode, 5, (command, done.stderr))
            self.assertIn("cannot write to standard output: No space left on device", done.stderr, command)


if __name__ == "__main__":
    unittest.main()
