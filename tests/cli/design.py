"""`balance design`: numbers that balance, files that hold them, and honest answers where there are none."""

import json
import os
import shutil
import subprocess
import unittest

import h5py
import netCDF4
import numpy
import xarray

from _program import CONFIGS, SPEC, Case, run, unwrapped

RR = os.path.join(CONFIGS, "rr.yaml")
IMPOSSIBLE = os.path.join(CONFIGS, "5r-impossible.yaml")


class Design(Case):
    def design(self, spec, *options, code=0):
        done = run("design", spec, "--json", *options)
        self.assertEqual((done.returncode, done.stderr), (code, ""), done.stdout[:300])
        return json.loads(done.stdout)

    def test_the_arm_is_balanced_by_the_counterweights_of_the_book(self):
        result = self.design(RR)
        numbers = {n["path"]: n["value"] for n in result["free_numbers"]}
        # By hand, P0 eq. 90: link2 and cargo against cw2, everything beyond joint 2 against cw1.
        cw2 = (1.5 * 0.2 + 0.5 * 0.4) / 0.2
        cw1 = (2 * 0.25 + 0.5 * (1.5 + 0.5 + cw2)) / 0.2
        self.assertAlmostEqual(numbers["counterweights.cw2.mass"], cw2, places=9)
        self.assertAlmostEqual(numbers["counterweights.cw1.mass"], cw1, places=9)
        self.assertEqual((result["status"], result["objective"]["global"]), ("balanced", True))
        for condition in result["conditions"]:
            self.assertLess(abs(condition["residual"]), 1e-10)
        self.assertAlmostEqual(result["mass"]["after"] - result["mass"]["before"], result["objective"]["value"] -
                               result["objective"]["start"], places=9)

    def test_the_balanced_spec_is_balanced(self):
        out = self.path("balanced.yaml")
        done = run("design", RR, "-o", out)
        self.assert_quiet_success(done)
        self.assertIn(f"written: {out}\n", done.stdout)
        checked = run("conditions", out, "--json")
        self.assert_quiet_success(checked)
        self.assertTrue(all(c["met"] for c in json.loads(checked.stdout)["conditions"]))
        # Nothing is free any more.
        self.assert_failure(run("design", out), 3, "no number is free", "{free: [lower, upper]}")
        # A force-balanced arm: the centre of mass stands still.
        metrics = json.loads(run("simulate", out, "-t", "cycloid", "--json").stdout)["metrics"]
        force = next(m for m in metrics if m["quantity"] == "shaking_force")
        self.assertLess(force["peak"], 1e-9)

    def test_what_is_printed_for_people(self):
        done = run("design", RR)
        self.assert_quiet_success(done)
        for part in ("planar RR arm: balanced exactly for gyroscopic, with the least possible added mass\n",
                     "free number ", "counterweights.cw1.mass", "where a1 = 0.5 m\n", "added mass     ",
                     "optimality: proved-best: ", "freedom: none: no other solution",
                     "trajectory cycloid\n", "worst torque", "\ntrajectory bang-bang\ncannot be followed after: "):
            self.assertIn(part, unwrapped(done.stdout))
        # Round-off is no force.
        self.assertRegex(done.stdout, r"shaking_force +N +[\d.]+ +0 +0 +[\d.]+ +0 +0\n")
        self.assertEqual(run("design", RR, "--quiet").stdout, "")

    def test_what_cannot_be_balanced_ends_with_1_says_why_and_is_still_written(self):
        out = self.path("compromise.yaml")
        done = run("design", IMPOSSIBLE, "-o", out)
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        self.assertIn("impossible: ", done.stdout)
        # The prototype's finding for the 5R: c1.J + c c2.J = 0 with c = (a12/a22)^2 > 0
        self.assertIn("coupler1.J + 0.852071 coupler2.J = 0 cannot hold: both are positive\n", done.stdout)
        self.assertIn(f"written, not balanced: {out}\n", done.stdout)
        self.assertTrue(os.path.exists(out))
        result = self.design(IMPOSSIBLE, code=1)
        self.assertEqual((result["status"], result["proof"]["kind"]), ("impossible", "sign"))

    def test_the_file_is_netcdf_and_its_groups_are_result_files(self):
        out = self.path("design.h5")
        result = self.design(RR, "--h5", out)
        self.assertEqual(result["files"], [out])
        with h5py.File(out) as file:
            self.assertEqual([file.attrs[n] for n in ("Conventions", "goal", "status", "objective")],
                             ["balance-1", "gyroscopic", "balanced", "added mass"])
            self.assertEqual([n["value"] for n in result["free_numbers"]], list(file["value"]))
            self.assertEqual([d[0].name for d in file["condition_matrix"].dims], ["/condition", "/parameter"])
            self.assertLess(numpy.abs(file["residual_after"]).max(), 1e-10)
            self.assertGreater(file["condition_matrix"].attrs["gap"], 1e8)
            self.assertEqual(file["after/bang-bang"].attrs["status"], "mismatch")  # a balanced centre of mass cannot drive
            self.assertEqual(list(file["after/bang-bang"]), [])
            design = {name: file["before/cycloid"][name][...] for name in file["before/cycloid"]
                      if isinstance(file["before/cycloid"][name], h5py.Dataset)}
        # The mechanism before is the spec at its start values: what simulate runs.
        simulated = self.path("run.h5")
        self.assert_quiet_success(run("simulate", RR, "-t", "cycloid", "-o", simulated))
        with h5py.File(simulated) as file:
            self.assertEqual(set(design), {n for n in file if isinstance(file[n], h5py.Dataset)})
            numpy.testing.assert_array_equal(design["torque"], file["torque"])
            numpy.testing.assert_array_equal(design["joint_force"], file["joint_force"])
        with netCDF4.Dataset(out) as file:
            self.assertEqual(file["condition_matrix"].dimensions, ("condition", "parameter"))
            self.assertEqual(file["after"]["cycloid"]["torque"].dimensions, ("time", "actuator"))
        with xarray.open_dataset(out, group="after/cycloid", engine="netcdf4") as after:
            self.assertLess(float(abs(after.shaking_force).max()), 1e-9)
        for tool in (["ncdump", out], ["h5dump", out]):
            done = subprocess.run(tool, capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), tool)

    def test_the_same_command_gives_the_same_bytes(self):
        for name in ("a.h5", "b.h5"):
            self.design(RR, "--h5", self.path(name))
        with open(self.path("a.h5"), "rb") as a, open(self.path("b.h5"), "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_files_are_replaced_only_with_force_and_the_spec_never(self):
        spec = shutil.copy(RR, self.folder)
        old = self.write("old", "old")
        for option in ("-o", "--h5"):
            self.assert_failure(run("design", spec, option, old), 5, "--force replaces it")
        with open(old, encoding="utf-8") as file:
            self.assertEqual(file.read(), "old")
        for options in (["-o", spec], ["-o", spec, "--force"], ["--h5", spec, "--force"]):
            self.assert_failure(run("design", spec, *options), 2, "would replace the spec")
        self.assert_failure(run("design", spec, "--h5", self.path("x"), "-o", self.path("x")), 2, "the same file")
        self.assert_quiet_success(run("design", spec, "-o", old, "--force"))
        self.assert_failure(run("design", old), 3, "no number is free")
        self.assertEqual(sorted(os.listdir(self.folder)), ["old", "rr.yaml"])

    def test_overrides_and_objectives_from_the_command_line(self):
        heavy = self.design(RR, "--set", "gamma4=0.25")
        numbers = {n["path"]: n["value"] for n in heavy["free_numbers"]}
        # Half the arm, twice the mass
        self.assertAlmostEqual(numbers["counterweights.cw2.mass"], 2 * (1.5 * 0.2 + 0.5 * 0.4) / 0.2, places=9)
        torque = self.design(RR, "--minimize", "{rms: torque, along: cycloid}")
        self.assertEqual((torque["objective"]["name"], torque["objective"]["unit"]),
                         ("rms of torque along cycloid", "N m"))

    def test_wrong_usage_is_named(self):
        for options, parts in ((["--goal", "forse"], ["'forse'", "nearest is 'force'"]),
                               (["--algorithm", "slsq"], ["'slsq'", "nearest is 'slsqp'"]),
                               (["--strategy", "x"], ["complete or modular"]),
                               (["--minimize", "added-mas"], ["--minimize", "added-mass"]),
                               (["--minimize", "{rms: torque, along: nowhere}"], ["--minimize", "nowhere"])):
            with self.subTest(options):
                done = run("design", RR, *options)
                self.assert_failure(done, 2, *parts)
                self.assertEqual(done.stdout, "")
        self.assert_failure(run("design", SPEC, "--goal", "force"), 3, "no number is free")

    def test_a_mechanism_that_cannot_be_assembled_ends_with_4(self):
        with open(RR, encoding="utf-8") as file:
            text = file.read()
        bare = self.write("bare.yaml", text.replace("tool: link2.P3\n", "").split("motion:", maxsplit=1)[0])
        done = run("design", bare, "--goal", "proportional", "--json")
        self.assert_failure(done, 4, "error: ")
        self.assertEqual(json.loads(done.stdout)["error"]["status"], "mismatch")


if __name__ == "__main__":
    unittest.main()
