"""`balance equations`: matrices at a pose as text, JSON, LaTeX and HDF5, and the words where there are none."""

import json
import os
import shutil
import subprocess
import tempfile
import unittest

import h5py
import numpy

from _program import CONFIGS, Case, run

ARM = os.path.join(CONFIGS, "planar-rrr.yaml")
FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")
THREE_RRR = os.path.join(CONFIGS, "3rrr.yaml")
DELTA = os.path.join(CONFIGS, "delta.yaml")


class Equations(Case):
    def answer(self, *call):
        done = run("equations", *call, "--json")
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def refused(self, code, words, *call):
        done = run("equations", *call)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(words, done.stderr)
        self.assertEqual(done.stdout, "")

    def test_the_decoupled_arm(self):
        found = self.answer(ARM, "--at", "J1=1,J2=-2,J3=0.3", "--only", "inertia")
        numpy.testing.assert_allclose(found["k"], [2.537333, 4.3168, 0.0715], atol=5e-7)
        self.assertNotIn("D", found)

    def test_torques_are_those_of_the_equation(self):
        found = self.answer(FIVE_BAR, "--at", "start", "--rates", "A1=2,A2=-1", "--accelerations", "A1=3")
        dq, ddq = numpy.array(found["rates"]), numpy.array(found["accelerations"])
        u = numpy.array(found["M"]) @ ddq + numpy.einsum("krs,r,s->k", found["D"], dq, dq) + found["z"]["sum"]
        told = [found["torques"][name]["sum"] for name in found["actuators"]]
        numpy.testing.assert_allclose(u, told, rtol=1e-9, atol=1e-9)
        for parts in found["torques"].values():
            kinds = ("inertia", "velocity", "friction", "weight", "spring", "load")
            self.assertAlmostEqual(sum(parts[kind] for kind in kinds), parts["sum"], places=11)

    def test_redundant_coordinates_become_independent_ones(self):
        found = self.answer(DELTA, "--at", "start", "--only", "inertia,redundant")
        loops = found["redundant"]
        C, A = numpy.array(loops["C"]), numpy.array(loops["A"])
        numpy.testing.assert_allclose(C.T @ numpy.array(loops["M"]) @ C, found["M"], atol=1e-10)
        numpy.testing.assert_allclose(A @ C, 0, atol=1e-9)

    def test_a_pose_in_the_specs_units(self):
        with tempfile.TemporaryDirectory() as folder:
            spec = os.path.join(folder, "arm.yaml")
            with open(ARM) as source, open(spec, "w") as copy:
                copy.write("units: {angle: deg}\n" + source.read())
            found = self.answer(spec, "--at", "J1=30,J2=90,J3=0", "--rates", "J1=180", "--only", "inertia")
        numpy.testing.assert_allclose(found["q"], numpy.radians([30, 90, 0]))
        numpy.testing.assert_allclose(found["rates"], [numpy.pi, 0, 0])

    def test_tool_and_joints_name_the_same_pose(self):
        there = self.answer(THREE_RRR, "--at", "end", "--only", "inertia")
        names = ",".join(f"{name}={value!r}" for name, value in zip(there["independent"], there["q"]))
        again = self.answer(THREE_RRR, "--at", names, "--only", "inertia")
        numpy.testing.assert_allclose(again["M"], there["M"], rtol=1e-8)

    def test_along_a_trajectory(self):
        with tempfile.TemporaryDirectory() as folder:
            out, samples = os.path.join(folder, "out.h5"), os.path.join(folder, "run.h5")
            self.assertEqual(run("equations", FIVE_BAR, "--at", "cycloid", "-o", out).returncode, 0)
            self.assertEqual(run("simulate", FIVE_BAR, "-t", "cycloid", "-o", samples).returncode, 0)
            with h5py.File(out) as file, h5py.File(samples) as ran:
                numpy.testing.assert_allclose(file["torque"][:].sum(axis=2), ran["torque"][:], rtol=1e-9, atol=1e-9)
                self.assertEqual(file["D"].shape[1:], (2, 2, 2))
                numpy.testing.assert_allclose(numpy.swapaxes(file["M"][:], 1, 2), file["M"][:], atol=1e-12)
            self.refused(5, "exists", FIVE_BAR, "--at", "cycloid", "-o", out)

    def test_the_same_parts_beside_a_simulation(self):
        with tempfile.TemporaryDirectory() as folder:
            out, table = os.path.join(folder, "out.h5"), os.path.join(folder, "out.csv")
            done = run("simulate", FIVE_BAR, "-t", "cycloid", "--split", "-o", out, "--csv", table)
            self.assertEqual(done.returncode, 0, done.stderr)
            with h5py.File(out) as file:
                names = [f"torque_{kind}" for kind in ("inertia", "velocity", "friction", "weight", "spring", "load")]
                parts = sum(file[name][:] for name in names)
                numpy.testing.assert_allclose(parts, file["torque"][:], rtol=1e-9, atol=1e-9)
                self.assertIn("--split", file.attrs["command_line"])
            with open(table) as file:
                self.assertIn("torque_weight", file.readline())
        self.assertEqual(run("simulate", FIVE_BAR, "--split").returncode, 2)

    def test_rotations_of_discs_are_rows_of_C(self):
        belts = os.path.join(CONFIGS, "planar-rrr-belts.yaml")
        rows = json.loads(run("equations", belts, "--at", "start", "--only", "redundant", "--json").stdout)["redundant"]
        self.assertEqual(rows["discs"], ["d4.r", "d5.r", "d6.r", "d7.r"])
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "out.h5")
            self.assert_quiet_success(run("equations", belts, "--at", "start", "--only", "redundant", "-o", out))
            with h5py.File(out) as file:
                numpy.testing.assert_allclose(file["C_discs"][0], rows["C_discs"], rtol=1e-14)
                self.assertEqual([name.decode() for name in file["disc"][:]], rows["discs"])

    def test_latex(self):
        done = run("equations", ARM, "--at", "start", "--latex", "--only", "inertia,redundant,natural,parameters")
        self.assert_quiet_success(done)
        self.assertEqual(done.stdout.count("{"), done.stdout.count("}"))
        if not shutil.which("pdflatex"):
            return
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "all.tex"), "w") as page:
                page.write("\\documentclass{article}\\usepackage{amsmath}\\begin{document}" + done.stdout + "\\end{document}")
            made = subprocess.run(["pdflatex", "-halt-on-error", "all.tex"], cwd=folder, capture_output=True, text=True)
            self.assertEqual(made.returncode, 0, made.stdout)

    @unittest.skipUnless(shutil.which("pdflatex"), "no TeX")
    def test_wide_matrices_and_long_parameters_stay_within_the_margins(self):
        """Matrices come in blocks, base parameters on several lines, and pages break between rows."""
        for spec in ("delta-gravity.yaml", "bricard.yaml", "5r.yaml"):
            done = run("equations", os.path.join(CONFIGS, spec), "--at", "start", "--latex", "--only",
                       "inertia,velocity,gravity,redundant,parameters")  # fmt: skip
            self.assert_quiet_success(done)
            with tempfile.TemporaryDirectory() as folder:
                with open(os.path.join(folder, "all.tex"), "w") as page:
                    page.write("\\documentclass{article}\\usepackage{amsmath}\\begin{document}" + done.stdout + "\\end{document}")
                made = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "all.tex"], cwd=folder,
                                      capture_output=True, text=True)  # fmt: skip
                self.assertEqual(made.returncode, 0, made.stdout[-2000:])
                self.assertNotIn("Overfull", made.stdout, spec)

    def test_words_for_what_is_no_pose(self):
        self.refused(2, "POSE", ARM, "--at")
        self.refused(2, "empty", ARM, "--at", "")
        self.refused(2, "nearest is 'J1'", ARM, "--at", "J9=0.3")
        self.refused(2, "such as A1=0.3", ARM, "--at", "J1=1,J2")
        self.refused(2, "unknown key", ARM, "--at", "foo")
        self.refused(2, "needs -o FILE", ARM, "--at", "cycloid")
        self.refused(2, "nearest is 'torques'", ARM, "--at", "start", "--only", "torqes")
        self.refused(2, "has no trajectory", ARM, "--at", "end", "-t", "nowhere")
        self.refused(2, "B1 is not one of them", FIVE_BAR, "--at", "start", "--rates", "B1=1")
        self.refused(2, "for 2 degrees of freedom", FIVE_BAR, "--at", "start", "--independent", "A1")
        self.refused(4, "states 1 of the 3 numbers", THREE_RRR, "--at", "A1=0.3")
        self.refused(4, "", ARM, "--at", "{tool: [100, 0], angle: 0}")


if __name__ == "__main__":
    unittest.main()
