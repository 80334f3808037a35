"""Trajectories that follow a machine's log: what the spec predicts for it, and by what the measured efforts differ."""

import json
import os
import unittest

import h5py
import numpy
from scipy.signal import butter, filtfilt

from _program import Case, run

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "identification", "data")
FIVE_BAR, TRAIN, VALIDATION = (os.path.join(DATA, name) for name in ("5r-spec.yaml", "5r-train.csv", "5r-validation.csv"))
FRICTION = "friction: {A1: {viscous: 0.4}, A2: {viscous: 0.3}}\n"


def five_bar(*lines):
    with open(FIVE_BAR, encoding="utf-8") as file:
        return file.read() + "".join(line + "\n" for line in lines)


def low_passed(values, cutoff, rate):
    b, a = butter(4, 2 * cutoff / rate)
    return filtfilt(b, a, values, axis=0)


class Prediction(Case):
    def simulated(self, spec, *options):
        """All datasets of a run along the log, and what the program says of it."""
        done = run("simulate", spec, "-t", "log", *options, "-o", self.path("run.h5"), "--force", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(self.path("run.h5")) as file:
            return {name: one[...] for name, one in file.items() if isinstance(one, h5py.Dataset)}, json.loads(done.stdout)

    def figures(self, told):
        return {one["quantity"]: one for one in told["metrics"]}


class OwnMotion(Prediction):
    """A log that the program itself made: 10 s at 500 Hz of harmonics up to 1.1 Hz."""

    CUTOFF = 20

    def setUp(self):
        super().setUp()
        time = numpy.linspace(0, 10, 5001)
        joints = numpy.column_stack([2.0 + 0.25 * numpy.sin(2 * numpy.pi * 0.7 * time), 1.1 + 0.3 * numpy.sin(2 * numpy.pi * 1.1 * time + 0.4)])
        numpy.savetxt(self.path("motion.csv"), numpy.column_stack([time, joints]), fmt="%.17g", delimiter=",", header="time,A1,A2", comments="")
        spec = self.write("truth.yaml", five_bar(FRICTION, "motion: {samples: 5001}", "trajectories: {log: {path: {file: motion.csv}, drive: joints}}"))
        truth, _ = self.simulated(spec)
        self.torque = truth["torque"]
        numpy.savetxt(self.path("log.csv"), numpy.column_stack([time, joints, self.torque]), fmt="%.12g", delimiter=",",
                      header="time,A1,A2,A1.effort,A2.effort", comments="")
        self.spec = self.write("spec.yaml", five_bar(FRICTION, "trajectories: {log: {measured: {file: log.csv, cutoff: %d}}}" % self.CUTOFF))

    def test_a_result_is_no_log(self):
        os.rename(self.path("run.h5"), self.path("log.csv"))
        self.assert_failure(run("simulate", self.spec, "-t", "log"), 3, "is an HDF5 file; expected a CSV file")

    def test_currents_with_gains_are_efforts(self):
        found, _ = self.simulated(self.spec)
        with open(self.path("log.csv"), encoding="utf-8") as file:
            rows = numpy.loadtxt(file, delimiter=",", skiprows=1)
        rows[:, 3:] /= [0.5, 2.0]
        numpy.savetxt(self.path("log.csv"), rows, fmt="%.17g", delimiter=",", header="time,A1,A2,A1.current,A2.current", comments="")
        without, told = self.simulated(self.spec)
        self.assertNotIn("torque_measured", without)
        with open(self.spec, "a", encoding="utf-8") as file:
            file.write("current_gains: {A1: 0.5, A2: 2}\n")
        again, _ = self.simulated(self.spec)
        numpy.testing.assert_allclose(again["torque_measured"], found["torque_measured"], rtol=0, atol=1e-9)

    def test_the_residual_of_the_true_spec_is_that_of_filter_and_spline(self):
        """At 1.1 Hz, and its third multiple in the torque, the filters pass all but (3.3/20)^8 = 5e-7, alike in both torques. Near the ends the
        computed torque's reflection is that of the run, the measured one's that of the log: 2e-4 of the torque."""
        found, told = self.simulated(self.spec)
        figures = self.figures(told)
        for name in ("A1", "A2"):
            self.assertLess(figures[f"torque_residual[{name}]"]["rms"], 1e-3 * figures[f"torque_measured[{name}]"]["rms"])
        self.assertLess(figures["torque_residual"]["rms"], 1e-3 * figures["torque"]["rms"])
        middle = slice(500, -500)
        self.assertLess(numpy.abs(found["torque_residual"][middle]).max(), 1e-8 * numpy.abs(found["torque"]).max())

    def test_what_was_measured_is_low_passed_without_delay(self):
        found, _ = self.simulated(self.spec)
        edge = (5001 - len(found["time"])) // 2
        self.assertEqual(edge, 500 // self.CUTOFF + 3)  # a period of the cut-off, and three samples of the derivatives
        expected = low_passed(self.torque, self.CUTOFF, 500)[edge:-edge]
        middle = slice(500, -500)  # the ends are continued in another way than SciPy's
        numpy.testing.assert_allclose(found["torque_measured"][middle], expected[middle], rtol=0, atol=1e-9 * numpy.abs(expected).max())
        residual = found["torque_measured"] - low_passed(found["torque"], self.CUTOFF, 500)
        numpy.testing.assert_allclose(found["torque_residual"][middle], residual[middle], rtol=0, atol=1e-9 * numpy.abs(expected).max())

    def test_both_formulations_predict_the_same(self):
        tree, _ = self.simulated(self.spec)
        natural, _ = self.simulated(self.spec, "--formulation", "natural")
        for name in ("torque", "torque_measured", "torque_residual"):
            numpy.testing.assert_allclose(natural[name], tree[name], rtol=0, atol=1e-8 * numpy.abs(tree["torque"]).max())

    def test_a_wrong_mass_is_in_the_residual(self):
        """A fifth less friction leaves a residual of that part: 0.08 N m s times the rate."""
        wrong = self.write("wrong.yaml", five_bar(FRICTION.replace("0.4", "0.32"), "trajectories: {log: {measured: {file: log.csv, cutoff: %d}}}" % self.CUTOFF))
        found, _ = self.simulated(wrong)
        middle = slice(500, -500)
        numpy.testing.assert_allclose(found["torque_residual"][middle, 0], 0.08 * found["joint_velocity"][middle, 0], rtol=0,
                                      atol=1e-4 * numpy.abs(found["torque"]).max())
        done = run("compare", wrong + ":log", self.spec + ":log", "--require", "rms(torque_residual[A1]) <= 0.01 * base")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        done = run("compare", self.spec + ":log", wrong + ":log", "--require", "rms(torque_residual[A1]) <= 0.01")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)

    def test_suites_judge_it(self):
        for limit, code in ((0.01, 0), (1e-9, 1)):
            suite = self.write("suite.yaml", "cases:\n  ours: {spec: spec.yaml, trajectory: log}\nrequire:\n  - peak(torque_residual) <= 0.01\n"
                                             "  - rms(torque_residual[A2]) <= %g\n" % limit)
            done = run("batch", suite, "-o", self.path(f"results-{code}"))
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)

    def test_the_run_says_what_was_done_and_can_be_drawn(self):
        done = run("simulate", self.spec, "-t", "log")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("low-passed at 20 Hz; 28 rows at each end are left out", " ".join(done.stderr.split()))
        self.assertIn("torque_residual[A1]", done.stdout)
        done = run("plot", self.spec + ":log", "--quantity", "torque", "--quantity", "torque_measured", "-o", self.path("plot.svg"))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_log_is_never_replaced(self):
        for option in (["-o", self.path("log.csv")], ["--csv", self.path("log.csv")]):
            done = run("simulate", self.spec, "-t", "log", *option, "--force")
            self.assertEqual(done.returncode, 2, done.stderr)
        with open(self.path("log.csv"), encoding="utf-8") as file:
            self.assertEqual(file.readline(), "time,A1,A2,A1.effort,A2.effort\n")


class RealLog(Prediction):
    """The residual is what `identify` states for the same spec and record, over the rows that it takes."""

    def predicted(self, spec, measured, channels, series, part):
        """Pairs per channel: rms of the residual at the rows in which the joint moves, and what identify says of this channel."""
        with open(spec, encoding="utf-8") as file:
            path = self.write("predict.yaml", file.read() + "\ntrajectories: {log: {measured: {%s}}}\n" % measured)
        found, _ = self.simulated(path)
        for k, channel in enumerate(channels):
            with h5py.File(series) as file:
                rows = {key: one[...] for key, one in file[f"channels/{channel['name']}/{part}"].items()}
            step = found["time"][1]
            start = rows["time"][0] - step * round(rows["time"][0] / step)  # the log's
            edge = round((self.duration - found["time"][-1]) / 2 / step) * step
            at = rows["time"] - start - edge
            inside = (at >= 0) & (at <= found["time"][-1]) & rows["moving"].astype(bool)
            numpy.testing.assert_allclose(numpy.interp(at, found["time"], found["torque_measured"][:, k])[inside], rows["measured"][inside],
                                          rtol=0, atol=1e-9 * numpy.abs(rows["measured"]).max())
            mine = numpy.interp(at, found["time"], found["torque_residual"][:, k])[inside]
            yield numpy.sqrt(numpy.mean(mine**2)), channel[part]

    def test_of_a_five_bar(self):
        self.duration = 10.0  # 2501 rows at 250 Hz
        done = run("identify", FIVE_BAR, TRAIN, "--validate", VALIDATION, "-o", self.path("found.yaml"), "--h5", self.path("found.h5"), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        measured = "file: %s, cutoff: %.6g" % (VALIDATION, told["cutoff"])
        for mine, theirs in self.predicted(FIVE_BAR, measured, told["channels"], self.path("found.h5"), "validation"):
            # regressors are evaluated at every third row: the digits that the program shows
            self.assertAlmostEqual(mine / theirs["spec_residual"], 1, delta=5e-4)
        for mine, theirs in self.predicted(self.path("found.yaml"), measured, told["channels"], self.path("found.h5"), "validation"):
            # of possible bodies instead of base parameters, and dry friction that jumps: within a twentieth of 0.2 %
            self.assertAlmostEqual(mine / theirs["measured"], theirs["relative"], delta=1e-4)

    def test_of_a_six_axis_arm_with_its_own_cutoff(self):
        self.duration = 8.998  # 4500 rows at 500 Hz
        spec, log = os.path.join(DATA, "tx40.yaml"), os.path.join(DATA, "tx40.csv")
        names = [name for k in range(1, 7) for name in (f"joint_{k}=q{k}", f"joint_{k}.effort=tau{k}")]
        done = run("identify", spec, log, "--columns", ",".join(names), "--h5", self.path("found.h5"), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        measured = "file: %s, columns: {%s}" % (log, ", ".join(name.replace("=", ": ") for name in names))
        for mine, theirs in self.predicted(spec, measured, told["channels"], self.path("found.h5"), "training"):
            self.assertAlmostEqual(mine / theirs["spec_residual"], 1, delta=5e-5)


class Mistakes(Prediction):
    def told(self, log, measured="file: log.csv"):
        self.write("log.csv", log)
        done = run("simulate", self.write("spec.yaml", five_bar("trajectories: {log: {measured: {%s}}}" % measured)), "-t", "log", "-o", self.path("run.h5"))
        self.assertFalse(os.path.exists(self.path("run.h5")))
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        return " ".join(done.stderr.split())

    def rows(self, names="time,A1,A2,A1.effort,A2.effort", times=None):
        times = 0.01 * numpy.arange(400) if times is None else times
        columns = {"time": times, "A1": 2.0 + 0.2 * numpy.sin(3 * times), "A2": 1.1 + 0.2 * numpy.cos(3 * times)}
        return names + "\n" + "".join(",".join("%.9g" % columns.get(name.split(" ")[0], 0 * times)[k] for name in names.split(",")) + "\n" for k in range(len(times)))

    def test_of_logs_are_errors_with_their_place(self):
        gap = numpy.concatenate([0.01 * numpy.arange(200), 5 + 0.01 * numpy.arange(200)])
        for log, measured, message in ((self.rows(times=gap), "file: log.csv", "without gaps"),
                                       (self.rows("time,A1,A1.effort,A2.effort"), "file: log.csv", "expected a column 'A2'"),
                                       (self.rows("time,A1,A2,A1.effort"), "file: log.csv", "'A2.effort' is missing"),
                                       (self.rows("time,A1 [kg],A2"), "file: log.csv", "expected a unit like rad, found 'kg'"),
                                       (self.rows("A1,A2"), "file: log.csv", "expected a column 'time'"),
                                       (self.rows(times=0.01 * numpy.arange(40)), "file: log.csv, cutoff: 2", "shorter than its filter"),
                                       (self.rows(), "file: log.csv, cutoff: 60", "expected a cut-off below half"),
                                       (self.rows(), "file: log.csv, columns: {A3: A1}", "no column is called 'A3'"),
                                       (self.rows(), "file: log.csv, coordinates: [A1, Z]", "'Z'"),
                                       (self.rows() + "4,nan,0,0,0\n", "file: log.csv", "row 401 (line 402), column 'A1'")):
            told = self.told(log, measured)
            self.assertIn(message, told)
            self.assertIn("spec.yaml:", told)
            self.assertNotIn("--", told.replace("--set", ""))

    def test_positions_alone_are_a_motion(self):
        self.write("log.csv", self.rows("time,A1,A2"))
        found, _ = self.simulated(self.write("spec.yaml", five_bar("trajectories: {log: {measured: {file: log.csv}}}")))
        self.assertNotIn("torque_residual", found)
        self.assertIn("torque", found)


if __name__ == "__main__":
    unittest.main()
