"""Runs: views of the library's memory, the same names, units and numbers as in the program's files."""

import gc
import json
import resource
import signal
import threading
import time
import unittest

import numpy
import xarray

import balance_mechanisms as bm

from _module import Case, config


def resident():
    """Bytes of memory that this process has now."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


class Views(Case):
    def test_arrays_are_read_only_views_that_keep_their_owner(self):
        run = bm.load(config("3rrr.yaml")).simulate("cycloid", samples=101)
        torque = run.torque
        self.assertIs(run["torque"].base.__class__, torque.base.__class__)
        self.assertEqual(run["torque"].ctypes.data, torque.ctypes.data)
        with self.assertRaises(ValueError):
            torque[0, 0] = 1
        with self.assertRaises(ValueError):
            torque.flags.writeable = True
        kept = torque.copy()
        del run
        gc.collect()
        numpy.testing.assert_array_equal(torque, kept)

    def test_a_payload_that_is_taken_up_is_told_with_the_torques_on_both_sides(self):
        """A level link at rest: m g l more of it afterwards."""
        link = bm.load("""\
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 2, com: [0.25, 0], inertia: 0.04, points: {A: [0, 0], E: [0.5, 0]}}}
payloads: {cargo: {body: link, at: E, mass: 0.5, from: 0.4}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
actuators: [J]
trajectories:
  lift: {law: cycloidal, drive: joints, duration: 1, from: {joints: {J: -1}}, to: {joints: {J: 1}},
    path: {waypoints: [{joints: {J: 0}}], times: [0.4]}}
""")
        change, = link.simulate("lift").payload_changes
        self.assertEqual((change.payload, change.change), ("cargo", "taken up"))
        self.assertAlmostEqual(change.time, 0.4)
        self.assertLess(change.speed, 1e-12)
        numpy.testing.assert_allclose(change.torque_before, [2 * 9.81 * 0.25], rtol=1e-12)
        numpy.testing.assert_allclose(change.torque_after, [2 * 9.81 * 0.25 + 0.5 * 9.81 * 0.5], rtol=1e-12)
        self.assertEqual(bm.load(config("3rrr.yaml")).simulate("cycloid", samples=11).payload_changes, [])

    def test_what_a_run_does_not_have_is_told(self):
        run = bm.load(config("3rrr.yaml")).simulate("cycloid", samples=11)
        with self.assertRaises(KeyError):
            run["no_such"]
        with self.assertRaises(AttributeError):
            run.sliding_variable
        self.assertIn("torque", dir(run))
        self.assertEqual(set(run), {"time", *run.quantities})

    def test_memory_does_not_grow(self):
        spec = bm.load(config("rr.yaml"))
        before = None
        for k in range(600):
            spec.simulate(samples=101).torque.sum()
            if k == 200:
                before = resident()
        self.assertLess(resident() - before, 4 << 20)


class Files(Case):
    SPECS = (("3rrr.yaml", "cycloid"), ("stewart.yaml", "cycloid"), ("rr.yaml", "cycloid"))

    def test_files_have_the_bytes_of_the_program_s(self):
        for name, trajectory in self.SPECS:
            run = bm.load(config(name)).simulate(trajectory, samples=21, poses=True)
            run.write(self.path("python.h5"), force=True)
            run.write(self.path("python.csv"), force=True)
            self.program("simulate", config(name), "-t", trajectory, "--samples", "21", "--poses", "--force",
                         "-o", self.path("program.h5"), "--csv", self.path("program.csv"))
            for ending in ("h5", "csv"):
                with open(self.path("python." + ending), "rb") as one, open(self.path("program." + ending), "rb") as other:
                    self.assertEqual(one.read(), other.read(), name)

    def test_overrides_and_options_are_described_as_by_the_program(self):
        spec = bm.load(config("3rrr.yaml"), set={"l": 0.3})
        run = spec.simulate("cycloid", samples=11, duration=0.25, about=[0.1, -0.2])
        run.write(self.path("python.h5"))
        self.program("simulate", config("3rrr.yaml"), "-t", "cycloid", "--samples", "11", "--duration", "0.25",
                     "--about", "0.1,-0.2", "--set", "l=0.3", "-o", self.path("program.h5"))
        with open(self.path("python.h5"), "rb") as one, open(self.path("program.h5"), "rb") as other:
            self.assertEqual(one.read(), other.read())
        with self.assertRaises(OSError):
            run.write(self.path("python.h5"))

    def test_xarray_has_what_the_file_has(self):
        for name, trajectory in self.SPECS:
            run = bm.load(config(name)).simulate(trajectory, samples=21, poses=True)
            run.write(self.path("run.h5"), force=True)
            self.assert_like_file(run)

    def test_xarray_of_a_controlled_run_has_what_the_file_has(self):
        run = bm.load(config("control-rrr.yaml")).control("sliding-mode", "cycloid", duration=0.1, samples=21)
        run.write(self.path("run.h5"))
        self.assert_like_file(run)

    def assert_like_file(self, run):
        for group, mine in ((None, run.to_xarray()), ("metrics", run.metrics_to_xarray())):
            with xarray.open_dataset(self.path("run.h5"), engine="netcdf4", group=group) as file:
                self.assertEqual(set(mine.variables), set(file.variables))
                for name, variable in file.variables.items():
                    self.assertEqual(mine[name].dims, variable.dims, name)
                    numpy.testing.assert_array_equal(mine[name].values, variable.values, name)
                    for word in set(variable.attrs) | set(mine[name].attrs):
                        numpy.testing.assert_array_equal(mine[name].attrs[word], variable.attrs[word], f"{name}: {word}")
                if group is None:
                    for word, value in mine.attrs.items():
                        self.assertEqual(value, file.attrs[word], word)

    def test_results_are_read_back(self):
        run = bm.load(config("3rrr.yaml")).simulate("cycloid", samples=21)
        run.write(self.path("run.h5"))
        again = bm.read(self.path("run.h5"))
        for name in run:
            numpy.testing.assert_array_equal(again[name], run[name])
        self.assertEqual(again.metrics, run.metrics)
        self.assertEqual(again.description, run.description)
        with self.assertRaises(OSError):
            bm.read(config("3rrr.yaml"))

    def test_tables(self):
        run = bm.load(config("3rrr.yaml")).simulate("cycloid", samples=21)
        table = run.to_dataframe()
        numpy.testing.assert_array_equal(table["torque[A2]"], run.torque[:, 1])
        numpy.testing.assert_array_equal(table["joint_force[B1].y"], run.joint_force[:, run.labels["joint"].index("B1"), 1])
        self.assertEqual(run.metrics_to_dataframe().loc["shaking_force", "peak"], run.metrics["shaking_force"].peak)


class Trouble(Case):
    def test_a_motion_that_cannot_be_says_when_and_why(self):
        with self.assertRaises(bm.MotionError) as caught:
            bm.load(config("3rrr.yaml"), set={"l": 0.02}).simulate("cycloid")
        error = caught.exception
        self.assertTrue(error.reason)
        self.assertIn(error.status, ("unreachable", "not-assembled"))
        self.assertGreaterEqual(error.time, 0)

    def test_a_controlled_run_that_ends_early_keeps_its_rows(self):
        with self.assertRaises(bm.MotionError) as caught:
            bm.load(config("control-rrr.yaml")).control("pd", "cycloid", steps=200)
        run = caught.exception.run
        self.assertGreater(len(run.time), 1)
        self.assertLessEqual(run.time[-1], caught.exception.time)

    def test_names_that_do_not_exist_are_told(self):
        spec = bm.load(config("3rrr.yaml"))
        for call in (lambda: spec.simulate("cycliod"), lambda: spec.control("none-such", "cycloid"),
                     lambda: spec.simulate("cycloid", samples=1), lambda: spec.simulate("cycloid", duration=-1),
                     lambda: spec.simulate("cycloid", about=[0]), lambda: spec.simulate("cycloid", formulation="x")):
            with self.assertRaises(ValueError):
                call()
        with self.assertRaisesRegex(ValueError, "nearest is 'cycloid'"):
            spec.simulate("cycliod")

    def test_ctrl_c_ends_a_long_run(self):
        spec = bm.load(config("stewart.yaml"))
        threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            spec.simulate("cycloid", samples=5_000_000)
        self.assertLess(time.monotonic() - begin, 20)

    def test_progress_is_told_and_may_stop_the_run(self):
        parts = []

        def tell(part):
            parts.append(part)
            if len(parts) == 2:
                raise StopIteration("enough")

        with self.assertRaises(StopIteration):
            bm.load(config("stewart.yaml")).simulate("cycloid", samples=2_000_000, progress=tell)
        self.assertTrue(0 < parts[0] < parts[1] < 1)

    def test_what_a_run_prints_is_what_the_program_prints(self):
        run = bm.load(config("3rrr.yaml")).simulate("cycloid", samples=21)
        told = self.program("simulate", config("3rrr.yaml"), "-t", "cycloid", "--samples", "21", "--json")
        self.assertEqual(json.loads(run.to_json()), json.loads(told))
        self.assertEqual(run.text(), self.program("simulate", config("3rrr.yaml"), "-t", "cycloid", "--samples", "21"))


if __name__ == "__main__":
    unittest.main()
