#!/usr/bin/env python3
"""No output replaces what a command reads, by whatever path, with --force too; folders are made, permissions kept."""

import itertools
import json
import os
import shutil
import stat
import unittest

from _program import CONFIGS, Case, run
from _sampling import draw

ARM = """
space: planar
bodies: {link: {mass: 1, com: [0.5, 0], inertia: {free: [0, 1], start: 0.1}, points: {A: [0, 0], B: [1, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {J1: {type: revolute, connects: [ground.O, link.A]}}
actuators: [J1]
design: {goal: static}
tolerances: {bodies.link.mass: 0.01}
motion: {samples: 11}
trajectories: {recorded: {drive: joints, path: {file: joints.csv}}}
"""

ROBOT = """<robot name="r">
  <link name="base"><visual><geometry><mesh filename="package://arm/meshes/base.stl"/></geometry></visual></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="meshes/arm.stl"/></geometry></visual></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>
"""

MODEL = """<mujoco><compiler meshdir="meshes"/><asset><mesh name="m" file="arm.stl"/></asset>
  <include file="inner/outer.xml"/></mujoco>
"""


def content(path):
    with open(path, "rb") as file:
        return file.read()


class Overwriting(Case):
    def setUp(self):
        super().setUp()
        os.makedirs(self.path("inner"))
        os.makedirs(self.path("meshes"))

    def spellings(self, name):
        """Paths that all mean one file."""
        folder, base = os.path.split(self.path(name))
        links = self.path("links")
        os.makedirs(links, exist_ok=True)
        suffix = os.path.splitext(name)[1]
        count = len(os.listdir(links))
        hard, soft, beside = (os.path.join(links, f"{kind}{count}") for kind in ("hard", "soft", "folder"))
        os.link(self.path(name), hard + suffix)
        os.symlink(self.path(name), soft + suffix)
        os.symlink(folder, beside)
        return [self.path(name), os.path.join(folder, ".", base), folder + "//" + base, os.path.relpath(self.path(name)),
                os.path.join(folder, "new", "..", base), os.path.join(folder, "new", "er", "..", "..", base),
                os.path.join(beside, base), os.path.join(beside, "new", "..", base), hard + suffix, soft + suffix]

    def assert_kept(self, names, commands):
        """Each command, with an output behind it, for the files in their spellings."""
        before = {name: content(self.path(name)) for name in names}
        paths = [(name, kind, path) for name in names for kind, path in enumerate(self.spellings(name))]
        cases = itertools.product(paths, enumerate(commands))
        for (_, _, path), (_, command) in draw("files to be kept", cases, 0.1, lambda case: {case[0][0], case[0][1], f"command {case[1][0]}"}):
            with self.subTest(command=command, path=path):
                done = run(*command, path, "--force")
                if done.returncode == 5:
                    self.assert_failure(done, 5, "it is a symbolic link, which is not followed")
                    self.assertTrue(os.path.islink(path))
                else:
                    self.assert_failure(done, 2, "would replace")
        self.assertEqual({name: content(self.path(name)) for name in names}, before)
        self.assertFalse(os.path.exists(self.path("new")))

    def arm(self):
        self.write("joints.csv", "time,J1\n0,0\n0.5,0.2\n0.7,0.3\n1,0.3\n")
        return self.write("arm.yaml", ARM)

    def test_runs_designs_and_pages(self):
        spec = self.arm()
        at = ["equations", spec, "--at", "start", "-o"]
        self.assert_kept(["arm.yaml", "joints.csv"],
                         [["simulate", spec, "-o"], ["simulate", spec, "--csv"], ["control", spec, "-o"], ["design", spec, "-o"],
                          ["design", spec, "--h5"], ["report", spec, "-o"], ["compare", spec, spec, "-o"],
                          ["tolerance", spec, "-o"], at])

    def test_parts(self):
        spec = shutil.copy(os.path.join(CONFIGS, "3rrr-legs.yaml"), self.path("legs.yaml"))
        shutil.copytree(os.path.join(CONFIGS, "parts"), self.path("parts"))
        self.assert_kept(["parts/3rrr-leg.yaml"], [["simulate", spec, "-o"], ["report", spec, "-o"]])

    def test_pictures_and_comparisons_of_results(self):
        spec = self.arm()
        self.assertEqual(run("simulate", spec, "-q", "-o", self.path("run.h5")).returncode, 0)
        self.assert_kept(["run.h5"], [["report", self.path("run.h5"), "-o"],
                                      ["compare", self.path("run.h5"), self.path("run.h5"), "-o"]])
        os.link(self.path("run.h5"), self.path("run.svg"))
        for path in self.spellings("run.svg"):
            self.assert_failure(run("plot", self.path("run.h5"), "-o", path, "--force"), 2, "would replace")

    def test_robots_and_what_they_name(self):
        names = ["r.urdf", "meshes/arm.stl", "meshes/base.stl"]
        self.write("meshes/arm.stl", "solid arm\n")
        self.write("meshes/base.stl", "solid base\n")
        robot = self.write("r.urdf", ROBOT)
        spec = self.path("spec.yaml")
        self.assertEqual(run("import", robot, "-o", spec).returncode, 0)
        self.assert_kept(names + ["spec.yaml"], [["export", spec, "--urdf", robot, "-o"],
                                                 ["export", spec, "--urdf", robot, "-o", self.path("out.urdf"), "--parts"]])
        self.assert_kept(names, [["import", robot, "-o"]])
        done = run("export", spec, "--urdf", robot, "-o", self.path("out"), "--parts", self.path("new/../out"), "--force")
        self.assert_failure(done, 2, "name the same file")

    def test_models_and_what_they_include(self):
        self.write("inner/outer.xml", '<mujoco><include file="deep.xml"/><include file="inner/deep.xml"/></mujoco>')
        self.write("inner/deep.xml", '<mujoco><asset><texture name="t" fileright="right.png"/></asset></mujoco>')
        self.write("right.png", "no picture")
        self.write("meshes/arm.stl", "solid arm\n")
        model = self.write("m.xml", MODEL)
        self.assert_kept(["m.xml", "inner/outer.xml", "inner/deep.xml", "meshes/arm.stl"], [["import", model, "-o"]])

    def test_batches(self):
        shutil.copy(os.path.join(CONFIGS, "5r-design.yaml"), self.path("dd.yaml"))
        suite = self.write("s.yaml", "cases: {dd: {spec: dd.yaml, design: true}}")
        before = content(self.path("dd.yaml"))
        os.symlink(self.folder, self.path("links"))
        for folder in (".", "new/..", "new/er/../..", "links", "links/new/..", self.folder + "//"):
            for options in ([], ["--merge"]):
                done = run("batch", suite, "-o", os.path.join(self.folder, folder), "--force", "-q", *options)
                self.assert_failure(done, 2, "would be replaced by")
        self.assertEqual(content(self.path("dd.yaml")), before)

    def test_what_standard_input_is_read_from(self):
        self.arm()
        for name, commands in (("arm.yaml", (["simulate", "-", "-o"], ["simulate", "-", "--csv"], ["design", "-", "-o"],
                                             ["design", "-", "--h5"], ["control", "-", "-o"], ["tolerance", "-", "-o"],
                                             ["report", "-", "-o"], ["equations", "-", "--at", "start", "-o"],
                                             ["compare", "-", "arm.yaml", "-o"], ["export", "-", "--urdf", "r.urdf", "-o"])),
                               ("r.urdf", (["import", "-", "-o"], ["export", "arm.yaml", "--urdf", "-", "-o"]))):
            before = content(self.write("r.urdf", ROBOT)) if name == "r.urdf" else content(self.path(name))
            for command in commands:
                with self.subTest(command=command), open(self.path(name), encoding="utf-8") as given:
                    done = run(*command, name, "--force", stdin=given, cwd=self.folder)
                    self.assert_failure(done, 2, "would replace")
            self.assertEqual(content(self.path(name)), before)
        suite = self.write("summary.json", "cases: {a: {spec: arm.yaml}}")
        with open(suite, encoding="utf-8") as given:
            done = run("batch", "-", "-o", ".", "--force", stdin=given, cwd=self.folder)
        self.assert_failure(done, 2, "would be replaced by")

    def test_an_empty_name_is_none(self):
        spec = self.arm()
        for command in (["simulate", spec, "-o"], ["simulate", spec, "--csv"], ["design", spec, "-o"], ["new", "four-bar", "-o"],
                        ["report", spec, "-o"], ["compare", spec, spec, "-o"], ["plot", spec, "-o"], ["import", spec, "-o"],
                        ["batch", spec, "-o"], ["tolerance", spec, "-o"], ["equations", spec, "--at", "start", "-o"],
                        ["export", spec, "--urdf", spec, "-o"], ["control", spec, "-o"], ["check"]):
            self.assert_failure(run(*command, ""), 2, "needs", "name", "found ''")

    def test_relative_folders_are_made(self):
        spec = self.arm()
        for command, suffix in ((["simulate", spec, "-q", "-o"], ".h5"), (["new", "four-bar", "-o"], ".yaml"),
                                (["compare", spec, spec, "-o"], ".csv")):
            for folder in ("a1/b/c/", "./a2/b/", "new/../", "a3/new/er/../../", "a4/"):
                name = folder + "out" + suffix
                done = run(*command, name, cwd=self.folder)
                self.assertEqual(done.returncode, 0, done.stderr)
                os.remove(os.path.normpath(self.path(name)))
        self.assertFalse(os.path.exists(self.path("new")), "a folder that the path leaves again")
        suite = self.write("s.yaml", "cases: {a: {spec: arm.yaml}}")
        for name in ("b1/b/c", "new/../b2/c"):
            done = run("batch", suite, "-q", "-o", name, cwd=self.folder)
            self.assertTrue(os.path.exists(os.path.normpath(self.path(name + "/summary.json"))), done.stderr)

    def test_folders_are_made(self):
        spec = self.arm()
        for command, name in ((["simulate", spec, "-o"], "a/b/run.h5"), (["simulate", spec, "--csv"], "c/run.csv"),
                              (["new", "four-bar", "-o"], "d/spec.yaml"), (["report", spec, "-o"], "e/f/page.html"),
                              (["compare", spec, spec, "-o"], "g/compared.csv"), (["design", spec, "-o"], "h/design.yaml"),
                              (["plot", spec, "-o"], "k/torque.svg"), (["man", "--all"], "man/man1"),
                              (["equations", spec, "--at", "recorded", "-o"], "l/equations.h5"),
                              (["tolerance", spec, "-o"], "m/tolerance.h5")):
            done = run(*command, self.path(name))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(os.path.exists(self.path(name)), name)

    def test_the_suffix_of_another_format_is_refused(self):
        spec = self.arm()
        everything = {".h5", ".hdf5", ".nc", ".csv", ".yaml", ".YML", ".json", ".html", ".svg", ".pdf", ".png"}
        hdf5, csv, yaml = {".h5", ".hdf5", ".nc"}, {".csv"}, {".yaml", ".YML"}
        for command, own in ((["simulate", spec, "-o"], hdf5), (["simulate", spec, "--csv"], csv), (["control", spec, "-o"], hdf5),
                             (["control", spec, "--csv"], csv), (["tolerance", spec, "-o"], hdf5), (["design", spec, "-o"], yaml),
                             (["design", spec, "--h5"], hdf5), (["design", os.path.join(CONFIGS, "four-bar-front.yaml"), "--csv"], csv),
                             (["design", spec, "--certificate"], {".json"}), (["report", spec, "-o"], {".html"}),
                             (["equations", spec, "--at", "start", "-o"], hdf5), (["new", "four-bar", "-o"], yaml),
                             (["import", self.write("r.urdf", ROBOT), "-o"], yaml)):
            for suffix in sorted(everything - own):
                other = self.write("other" + suffix, "precious")
                with self.subTest(command=command, suffix=suffix):
                    self.assert_failure(run(*command, other, "--force"), 2, "end its name in")
                    self.assertEqual(content(other), b"precious")

    def test_a_refused_output_leaves_no_folder(self):
        self.assertEqual(run("simulate", self.path("none.yaml"), "-o", self.path("new/run.h5")).returncode, 5)
        self.assertFalse(os.path.exists(self.path("new")))

    def test_a_file_is_no_folder(self):
        spec = self.arm()
        for name in ("arm.yaml/run.h5", "arm.yaml/deep/run.h5"):
            self.assert_failure(run("simulate", spec, "-o", self.path(name), "--force"), 5, "is a file, not a folder")

    def test_permissions_outlive_a_file(self):
        spec = self.arm()
        for mode in (0o600, 0o664, 0o755):
            self.assertIn(run("simulate", spec, "-o", self.path("run.h5"), "--force").returncode, (0,))
            os.chmod(self.path("run.h5"), mode)
            self.assertEqual(run("simulate", spec, "-o", self.path("run.h5"), "--force").returncode, 0)
            self.assertEqual(stat.S_IMODE(os.stat(self.path("run.h5")).st_mode), mode)

    def test_equations_along_a_trajectory_are_told_as_json(self):
        done = run("equations", self.arm(), "--at", "recorded", "-o", self.path("e.h5"), "--json")
        self.assert_quiet_success(done)
        self.assertEqual(json.loads(done.stdout)["files"], [self.path("e.h5")])


if __name__ == "__main__":
    unittest.main()
