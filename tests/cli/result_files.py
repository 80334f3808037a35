"""Result files: complete or absent, the same bytes for the same spec, never lost."""

import csv
import os
import re
import resource
import shutil
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from _program import CONFIGS, PROGRAM, SPEC, Case, run


class ResultFiles(Case):
    def simulate(self, *options, **kwargs):
        return run("simulate", SPEC, "-t", "cycloid", "--samples", "101", *options, **kwargs)

    def content(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def test_the_summary_says_where_the_files_are(self):
        done = self.simulate("-o", self.path("a.h5"), "--csv", self.path("a.csv"))
        self.assert_quiet_success(done)
        self.assertIn(f"written: {self.path('a.h5')}\nwritten: {self.path('a.csv')}\n", done.stdout)
        self.assertEqual(sorted(os.listdir(self.folder)), ["a.csv", "a.h5"])

    def test_without_an_output_there_is_no_file(self):
        self.assert_quiet_success(self.simulate(cwd=self.folder))
        self.assertEqual(os.listdir(self.folder), [])

    def test_quiet_prints_nothing(self):
        done = self.simulate("-o", self.path("a.h5"), "--quiet")
        self.assert_quiet_success(done)
        self.assertEqual(done.stdout, "")

    def test_the_table_and_the_hdf5_file_hold_the_same_numbers(self):
        self.assert_quiet_success(self.simulate("-o", self.path("a.h5"), "--csv", self.path("a.csv")))
        with open(self.path("a.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        columns = dict(zip(rows[0], numpy.array(rows[1:], dtype=float).T))
        with h5py.File(self.path("a.h5")) as result:
            numpy.testing.assert_array_equal(columns["time [s]"], result["time"])
            for i, joint in enumerate(result["joint"].asstr()):
                numpy.testing.assert_array_equal(columns[f"{joint}.force.y [N]"], result["joint_force"][:, i, 1])
                numpy.testing.assert_array_equal(columns[f"{joint}.moment [N m]"], result["joint_moment"][:, i])
            for i, coordinate in enumerate(result["coordinate"].asstr()):
                velocity = columns[f"{coordinate}.velocity [rad/s]"]
                numpy.testing.assert_array_equal(velocity, result["joint_velocity"][:, i])
            numpy.testing.assert_array_equal(columns["shaking_moment [N m]"], result["shaking_moment"])

    def test_the_same_spec_gives_the_same_bytes_wherever_it_lies(self):
        elsewhere = shutil.copy(SPEC, self.folder)
        for kind in ([], ["--compress"]):
            self.assert_quiet_success(self.simulate("-o", self.path("a.h5"), "--force", *kind))
            # Memory that is filled with rubbish must not show.
            rubbish = {**os.environ, "MALLOC_PERTURB_": "165", "TZ": "Asia/Tokyo"}
            done = run("simulate", elsewhere, "-t", "cycloid", "--samples", "101", "-o", "b.h5", "--force", "--json",
                       *kind, cwd=self.folder, env=rubbish)
            self.assert_quiet_success(done)
            self.assertEqual(self.content("a.h5"), self.content("b.h5"))

    def test_the_command_line_in_the_file_makes_the_same_file_again(self):
        self.assert_quiet_success(self.simulate("-o", self.path("a.h5"), "--about", "-0.1,0.25", "--duration", "0.3"))
        with h5py.File(self.path("a.h5")) as result:
            command = result.attrs["command_line"]
            spec = result.attrs["spec"]
        name = os.path.basename(SPEC)
        self.assertEqual(command, f"balance simulate {name} --trajectory cycloid "
                                  "--samples 101 --duration 0.3 --about=-0.1,0.25")
        self.write(name, spec)
        self.assert_quiet_success(run(*command.split()[1:], "-o", "b.h5", cwd=self.folder))
        self.assertEqual(self.content("a.h5"), self.content("b.h5"))

    def test_what_set_changed_is_in_attributes_and_the_report_takes_it_from_there(self):
        spec = self.write("s.yaml", """\
space: planar
parameters: {"l": 1, m: 2}
ground: {points: {O: [0, 0]}}
bodies: {arm: {mass: m, com: ["l / 2", 0], inertia: 0.1}}
joints: {J: {type: revolute, connects: [ground.O, arm.origin]}}
actuators: [J]
motion: {duration: 1, samples: 11, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
""")
        self.assert_quiet_success(run("simulate", spec, "--set", "m=3", "--set", "l=1/2 + 1/4", "-o", self.path("a.h5"), "-q"))
        with h5py.File(self.path("a.h5"), "r+") as file:
            self.assertEqual(list(file.attrs["override_names"]), ["m", "l"])
            self.assertEqual(list(file.attrs["override_values"]), ["3", "1/2 + 1/4"])
            file.attrs["command_line"] = "balance simulate s.yaml"  # nothing is read out of it
        self.assert_quiet_success(run("report", self.path("a.h5"), "-o", self.path("a.html"), "-q"))
        self.assertEqual(re.findall(rb'"mass":3.0,"com":\[([0-9.]*)', self.content("a.html")), [b"0.375"])  # with the text's own numbers 0.5
        self.assert_quiet_success(self.simulate("-o", self.path("b.h5")))
        with h5py.File(self.path("b.h5")) as file:
            self.assertNotIn("override_names", file.attrs)

    def test_a_designed_case_is_a_run_of_its_own_spec(self):
        """That spec has what `set` changed in its text; a case that is not designed has it in attributes."""
        name = os.path.join(CONFIGS, "5r-design.yaml")
        suite = self.write("suite.yaml", f"defaults: {{spec: {name}, samples: 11, set: {{a11: 0.29}}}}\n"
                                         "cases: {plain: {}, designed: {design: true}}\n")
        self.assertIn(run("batch", suite, "-o", self.path("out"), "-q").returncode, (0, 1))
        with h5py.File(self.path("out/plain.h5")) as file:
            self.assertEqual((list(file.attrs["override_names"]), list(file.attrs["override_values"])), (["a11"], ["0.29"]))
            self.assertIn("--set a11=0.29", file.attrs["command_line"])
        with h5py.File(self.path("out/designed.h5")) as file:
            self.assertNotIn("override_names", file.attrs)
            self.assertNotIn("--set", file.attrs["command_line"])

    def test_an_existing_file_is_replaced_only_with_force(self):
        for option in ("-o", "--csv"):
            old = self.write("old", "old")
            reason = f"cannot write {old}: it exists already; --force replaces it"
            self.assert_failure(self.simulate(option, old), 5, reason)
            self.assertEqual(self.content("old"), b"old")
            self.assert_quiet_success(self.simulate(option, old, "--force"))
            self.assertNotEqual(self.content("old"), b"old")

    def test_the_spec_is_never_replaced(self):
        spec = shutil.copy(SPEC, self.folder)
        for option in ("-o", "--csv"):
            done = run("simulate", spec, "-t", "cycloid", option, spec, "--force")
            self.assert_failure(done, 2, "would replace the spec")
        done = self.simulate("-o", self.path("a"), "--csv", self.folder + "/./a")
        self.assert_failure(done, 2, "the same file")
        with open(SPEC, "rb") as file:
            self.assertEqual(self.content(os.path.basename(SPEC)), file.read())

    def test_places_where_no_file_can_be_are_named(self):
        self.write("file", "")
        for option, name in (("-o", "a.h5"), ("--csv", "a.csv")):
            for place, reason in ((self.path(f"file/{name}"), ""), (self.folder, "it is a folder"),
                                  ("/dev/full", "it is not a regular file"), (f"/proc/{name}", "")):
                done = self.simulate(option, place, "--force")
                self.assert_failure(done, 5, f"error: cannot write {place}: {reason}")
                self.assertEqual(done.stdout, "")
        self.assertEqual(os.listdir(self.folder), ["file"])

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_a_folder_without_permission_is_named(self):
        os.chmod(self.folder, 0o555)
        done = self.simulate("-o", self.path("a.h5"))
        self.assert_failure(done, 5, f"cannot write {self.path('a.h5')}: Permission denied")
        os.chmod(self.folder, 0o755)

    def test_a_full_disk_keeps_the_old_file_and_leaves_no_other(self):
        def no_room(size):
            def limit():
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            return limit

        for option, name in (("-o", "a.h5"), ("--csv", "a.csv")):
            for size in (0, 10_000, 50_000):
                self.write(name, "old")
                done = self.simulate(option, self.path(name), "--force", preexec_fn=no_room(size))
                self.assert_failure(done, 5)
                self.assertEqual(done.stderr, f"error: cannot write {self.path(name)}: File too large\n")
                self.assertEqual(self.content(name), b"old")
        self.assertEqual(sorted(os.listdir(self.folder)), ["a.csv", "a.h5"])

    def interrupt(self, number, ready):
        """Sends a signal when `ready` says so; the exit code and what is left."""
        self.write("a.csv", "old")
        arguments = [PROGRAM, "simulate", SPEC, "-t", "cycloid", "--samples", "200000",
                     "--csv", self.path("a.csv"), "--force"]
        with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            end = time.monotonic() + 60
            while not ready() and process.poll() is None and time.monotonic() < end:
                time.sleep(0.001)
            process.send_signal(number)
            process.communicate(timeout=60)
            return process.returncode

    def test_a_signal_while_writing_removes_what_is_unfinished(self):
        def begun():
            return any(name.endswith(".tmp") and os.path.getsize(self.path(name)) > 0 for name in self.listing())

        for number in (signal.SIGINT, signal.SIGTERM):
            self.assertEqual(self.interrupt(number, begun), 128 + number)
            self.assertEqual(os.listdir(self.folder), ["a.csv"])
            self.assertEqual(self.content("a.csv"), b"old")

    def listing(self):
        """Names in the folder; a file may go while one looks."""
        return [name for name in os.listdir(self.folder) if os.path.exists(self.path(name))]

    def test_a_signal_while_computing_ends_at_once(self):
        start = time.monotonic()
        self.assertEqual(self.interrupt(signal.SIGINT, lambda: time.monotonic() > start + 0.1), 128 + signal.SIGINT)
        self.assertEqual(os.listdir(self.folder), ["a.csv"])


if __name__ == "__main__":
    unittest.main()
