"""Comparisons, batches, imports and exports are those of the program."""

import json
import os
import unittest

import balance_mechanisms as bm

from _module import Case, config

SUITE = """
baseline: a
cases:
  a: {{spec: {spec}, trajectory: cycloid, samples: 51}}
  b: {{spec: {spec}, trajectory: bang-bang, samples: 51}}
require: ["peak(shaking_force) <= 2 * base"]
"""

ROBOT = """<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
</robot>
"""


class OfADesign(Case):
    def test_a_run_knows_the_spec_that_it_is_of(self):
        """The spec before has what `set` changed beside it, the designed one in its text."""
        design = bm.load(config("5r-design.yaml"), set={"a11": 0.29}).design(seed=1)
        names = list(design.before)
        before, after = design.before[names[0]].description, design.after[names[0]].description
        self.assertEqual((before["override_names"], before["override_values"]), (["a11"], ["0.29"]))
        self.assertIn("--set a11=0.29", before["command_line"])
        self.assertNotIn("override_names", after)
        self.assertNotIn("--set", after["command_line"])
        self.assertEqual((before["spec"] == after["spec"], after["spec"]), (False, design.spec_text))


class Comparing(Case):
    def test_it_is_the_program_s(self):
        spec = bm.load(config("3rrr.yaml"))
        names = []
        for trajectory in ("cycloid", "bang-bang"):
            names.append(self.path(trajectory + ".h5"))
            spec.simulate(trajectory, samples=51).write(names[-1])
        requirement = "peak(shaking_force) <= 0.5 * base"
        found = bm.compare(names, require=requirement)
        told = json.loads(self.program("compare", *names, "--require", requirement, "--json"))
        mine = found.to_dict()
        for one in (*mine["runs"], *told["runs"]):
            one.pop("file")
        self.assertEqual(mine, told)
        self.assertEqual(found.holds, False)
        runs = {name: bm.read(file) for name, file in zip(("slow", "quick"), names)}
        self.assertTrue(bm.compare(runs, require="peak(torque, quick) > 0").holds)
        table = found.to_dataframe()
        peak = table[(table.quantity == "shaking_force") & (table.figure == "peak")]
        self.assertEqual(list(peak.value), [run.metrics["shaking_force"].peak for run in runs.values()])

    def test_what_is_no_run_is_told(self):
        for what, options in (("simulate", ["-q"]), ("equations", [])):
            self.program(what, config("four-bar.yaml"), "--at", "start", "-o", self.path(what + ".h5"), *options)
        with self.assertRaisesRegex(ValueError, "'simulate' is a single state, not a run"):
            bm.compare([self.path("simulate.h5"), self.path("simulate.h5")])
        with self.assertRaisesRegex(OSError, "holds equations of motion"):
            bm.read(self.path("equations.h5"))
        with self.assertRaisesRegex(OSError, r"no\\x0asuch.h5"):
            bm.read("no\nsuch.h5")

    def test_requirements_that_make_no_sense_are_told(self):
        run = bm.load(config("3rrr.yaml")).simulate("cycloid", samples=11)
        with self.assertRaisesRegex(ValueError, "column"):
            bm.compare([run, run], require="peak(shaking_force) <=")
        with self.assertRaises(ValueError):
            bm.compare([run])


class Batches(Case):
    def test_it_is_the_program_s(self):
        with open(self.path("suite.yaml"), "w", encoding="utf-8") as file:
            file.write(SUITE.format(spec=config("3rrr.yaml")))
        parts = []
        found = bm.batch(self.path("suite.yaml"), jobs=2, folder=self.path("python"), progress=parts.append)
        self.program("batch", self.path("suite.yaml"), "-o", self.path("program"), "--quiet")
        self.assertEqual(found.cases, {"a": "done", "b": "done"})
        for name in ("a.h5", "b.h5", "summary.csv"):
            with open(os.path.join(found.folder, name), "rb") as one, open(self.path("program/" + name), "rb") as other:
                self.assertEqual(one.read(), other.read(), name)
        self.assertEqual(found.run("a").metrics["torque"].peak,
                         found.to_dataframe().query("case == 'a' and quantity == 'torque'").peak.item())
        again = bm.batch(self.path("suite.yaml"), jobs=2, folder=self.path("python"))
        self.assertEqual(again.to_json(), found.to_json())
        with self.assertRaises(bm.SpecError):
            bm.batch(config("3rrr.yaml"), folder=self.path("none"))


class Written(Case):
    def test_a_file_that_cannot_be_written_is_python_s_own_error(self):
        run = bm.load(config("rr.yaml")).simulate(samples=5)
        run.write(self.path("run.h5"))
        for name, error in (("run.h5", FileExistsError), ("run.h5/run.h5", NotADirectoryError), (".", IsADirectoryError)):
            with self.assertRaises(error):
                run.write(self.path(name))
        with self.assertRaisesRegex(FileExistsError, "force=True replaces it$"):
            run.write(self.path("run.h5"))
        run.write(self.path("run.h5"), force=True)

    def test_a_result_that_is_damaged_is_no_missing_file(self):
        with open(self.path("run.h5"), "wb") as file:
            file.write(b"no result")
        with self.assertRaises(OSError) as caught:
            bm.read(self.path("run.h5"))
        self.assertIs(type(caught.exception), OSError)


class Robots(Case):
    def test_import_and_export_are_the_program_s(self):
        with open(self.path("arm.urdf"), "w", encoding="utf-8") as file:
            file.write(ROBOT)
        found = bm.import_(self.path("arm.urdf"), base="fixed")
        told = json.loads(self.program("import", self.path("arm.urdf"), "--base", "fixed", "--json"))
        self.assertEqual(found.spec_text, told["spec"])
        self.assertEqual(found.findings, told["findings"])
        self.assertEqual(found.to_dict()["dof"], 1)
        heavier = found.spec_text.replace("mass: 2", "mass: 3")
        self.assertNotEqual(heavier, found.spec_text)
        spec = bm.load(heavier, file=self.path("arm.yaml"))
        with open(self.path("arm.yaml"), "w", encoding="utf-8") as file:
            file.write(heavier)
        exported = bm.export(spec, self.path("arm.urdf"), base="fixed")
        self.program("export", self.path("arm.yaml"), "--urdf", self.path("arm.urdf"), "--base", "fixed", "-o",
                     self.path("new.urdf"), "--parts", self.path("parts.csv"))
        with open(self.path("new.urdf"), encoding="utf-8") as file:
            self.assertEqual(exported.text, file.read())
        with open(self.path("parts.csv"), encoding="utf-8") as file:
            self.assertEqual(bm.parts(spec), file.read())
        self.assertEqual(exported.changed, ["upper"])


if __name__ == "__main__":
    unittest.main()
