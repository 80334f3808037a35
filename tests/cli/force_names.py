"""The effort of a slide's actuator is a force by name, and its older name, `torque[…]`, is understood wherever one is given."""

import csv
import json
import os
import unittest

import h5py

from _program import CONFIGS, Case, config, run

SCARA = os.path.join(CONFIGS, "scara.yaml")


class ForceNames(Case):
    def result(self, name="scara.h5"):
        file = self.path(name)
        self.assert_quiet_success(run("simulate", SCARA, "-t", "bang-bang", "--samples", "21", "-o", file, "-q"))
        return file

    def test_figures_and_tables_call_it_a_force(self):
        table = self.path("scara.csv")
        done = run("simulate", SCARA, "-t", "bang-bang", "--samples", "21", "--csv", table, "--json", "-q")
        self.assert_quiet_success(done)
        units = {one["quantity"]: one["unit"] for one in json.loads(done.stdout)["metrics"]}
        self.assertEqual((units["torque[J1]"], units["force[J3]"]), ("N m", "N"))
        self.assertNotIn("torque[J3]", units)
        with open(table, encoding="utf-8", newline="") as file:
            heading = next(csv.reader(file))
        self.assertIn("J1.torque [N m]", heading)
        self.assertIn("J3.force [N]", heading)
        with h5py.File(self.result()) as file:
            self.assertEqual([name.decode() for name in file["effort"]], ["torque[J1]", "torque[J2]", "force[J3]"])
            self.assertIn(b"force[J3]", list(file["metrics/quantity"]))
        text = run("simulate", SCARA, "--at", "start")
        self.assertIn("force[J3]", text.stdout)
        self.assertNotIn("torque[J3]", text.stdout)

    def test_requirements_and_plots_know_both_names(self):
        file = self.result()
        with h5py.File(file) as read:
            names = list(read["metrics/quantity"])
            peak = float(read["metrics/peak"][names.index(b"force[J3]")])
        for name in ("force[J3]", "torque[J3]"):
            for bound, code in ((1.01 * peak, 0), (0.99 * peak, 1)):
                done = run("compare", file, file, "--require", f"peak({name}) <= {bound}")
                self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            self.assert_quiet_success(run("plot", file, "--quantity", name, "-o", self.path(f"{name}.svg")))
        done = run("compare", file, file, "--require", "peak(force[J1]) <= 1")
        self.assertEqual(done.returncode, 2, done.stderr)

    def test_files_of_older_versions_compare(self):
        new, old = self.result(), self.result("old.h5")
        with h5py.File(old, "r+") as file:
            names = [name.replace(b"force[J3]", b"torque[J3]") for name in file["metrics/quantity"]]
            file["metrics/quantity"][...] = names
        done = run("compare", old, new, "--format", "json")
        self.assertEqual(done.returncode, 0, done.stderr)
        names = [one["quantity"] for one in json.loads(done.stdout)["quantities"]]
        self.assertEqual(names.count("force[J3]"), 1)
        self.assertNotIn("torque[J3]", names)

    def test_specs_and_options_know_both_names(self):
        answers = []
        for name in ("force[J3]", "torque[J3]"):
            spec = self.write("fast.yaml", config("scara.yaml", (
                r"\n  bang-bang:",
                f'\n  fast: {{law: fastest, drive: joints, limits: {{"torque[J1]": 20, "{name}": 30}},\n'
                "         from: {joints: {J1: -1, J2: 1.4, J3: 0}}, to: {joints: {J1: 0.7, J2: 1, J3: 0.1}}}\n"
                "  bang-bang:"), (r"design: .*", "tolerances: {m3: 1%}")))
            done = run("simulate", spec, "-t", "fast", "--json", "-q")
            self.assert_quiet_success(done)
            found = json.loads(done.stdout)
            off = run("tolerance", spec, "-t", "bang-bang", "--of", name, "--samples", "21", "--json")
            self.assertEqual(off.returncode, 0, off.stderr)
            answers.append((found["duration"], [one["quantity"] for one in json.loads(off.stdout)["first_order"]["quantities"]]))
        self.assertEqual(answers[0], answers[1])
        self.assertEqual(answers[0][1], ["force[J3]"])

    def test_objectives_and_limits_know_both_names(self):
        for name in ("force[J3]", "torque[J3]"):
            spec = self.write("design.yaml", config("scara-design.yaml", (
                r"design: .*", f'design: {{goal: force, minimize: {{rms: "{name}", along: cycloid}}}}\n')))
            done = run("check", spec)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
