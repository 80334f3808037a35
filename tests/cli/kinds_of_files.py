#!/usr/bin/env python3
"""A file that is no run says what it is and what to do; standard input is a spec like another; names are shown as they are read."""

import os
import unittest

from _program import CONFIGS, Case, run

SPEC = os.path.join(CONFIGS, "four-bar.yaml")
ROBOT = """<robot name="r">
  <link name="base"/>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="end"/><link name="tip"/>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="j1" type="fixed"><parent link="arm"/><child link="end"/></joint>
  <joint name="j2" type="revolute"><parent link="end"/><child link="tip"/><axis xyz="0 0 1"/><limit effort="1" velocity="1"/>MIMIC</joint>
  <transmission name="t"><joint name="j"/></transmission>
  <transmission name="u"/><gazebo/><gazebo/>
</robot>
"""


class KindsOfFiles(Case):
    def spec(self):
        with open(SPEC, encoding="utf-8") as file:
            return file.read()

    def test_a_single_state_has_nothing_to_compare_or_to_draw(self):
        state = self.path("one.h5")
        self.assert_quiet_success(run("simulate", SPEC, "--at", "start", "-q", "-o", state))
        for command in (["compare", state, state], ["compare", SPEC, state], ["compare", state, SPEC, "--require", "peak(torque) < 1"],
                        ["plot", state, "-o", self.path("p.svg")], ["report", state, "-o", self.path("p.html")]):
            self.assert_failure(run(*command), 5, "one.h5 holds a single state, not a run", "along a trajectory")
        self.assertEqual(os.listdir(self.folder), ["one.h5"])

    def test_equations_are_no_run(self):
        equations = self.path("eq.h5")
        self.assertEqual(run("equations", SPEC, "--at", "start", "-o", equations).returncode, 0)
        for command in (["compare", equations, SPEC], ["plot", equations, "-o", self.path("p.svg")], ["report", equations, "-o", self.path("p.html")]):
            self.assert_failure(run(*command), 5, "eq.h5: holds equations of motion", "not a run")

    def test_standard_input_is_a_spec(self):
        for command, text in ((["compare", "-", SPEC], "ratios and differences are relative to stdin"), (["plot", "-", "-o", self.path("p.svg")], "written"),
                              (["report", "-", "-o", self.path("p.html"), "--samples", "11"], "written")):
            with open(SPEC, encoding="utf-8") as given:
                done = run(*command, stdin=given)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(text, done.stdout)
        self.assert_failure(run("compare", "-", "-"), 2, "can be read only once")

    def test_a_note_on_the_trajectory_names_the_spec_and_the_cure(self):
        several = os.path.join(CONFIGS, "3rrr.yaml")
        done = run("compare", several, several + ":bang-bang")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"note: {several}: using '", done.stderr)
        self.assertIn(f"; {several}:NAME selects another", done.stderr)
        self.assertNotIn("--trajectory", done.stderr)
        self.assert_failure(run("compare", several), 2, "expected at least two runs to compare", "specs (arm.yaml:cycloid)")

    def test_control_characters_of_names_are_spelled_out(self):
        odd = self.write("ne\nw\x1b.yaml", self.spec())
        shown = "ne\\x0aw\\x1b"
        for command in (["compare", odd, SPEC], ["compare", odd, SPEC, "--format", "markdown"],
                        ["simulate", odd, "-o", self.path("ne\nw\x1b.h5")], ["plot", odd, "--label", "a", "-o", self.path("ne\nw\x1b.svg")],
                        ["report", odd, "-o", self.path("ne\nw\x1b.html")], ["compare", self.path("no\nsuch.h5"), SPEC],
                        ["check", self.path("no\nsuch.yaml")], ["new", "four-bar", "-o", odd], ["simulate", odd, "-o", odd],
                        ["export", odd, "--urdf", self.path("no\nsuch.urdf"), "-o", self.path("x")]):
            done = run(*command)
            said = done.stdout + done.stderr
            self.assertFalse("ne\nw" in said or "no\nsuch" in said or "ne w" in said or "\x1b" in said, (command, said))
            self.assertTrue(shown in said or "no\\x0asuch" in said, (command, said))

    def test_mistakes_of_a_robot_say_what_was_found(self):
        robot = self.write("r.urdf", ROBOT.replace("MIMIC", ""))
        done = run("import", robot)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("left out: gazebo (2), transmission\n", done.stderr)
        for leader, what in (("j1", "which is fixed"), ("j2", "which is this joint itself"), ("none", "which is not a joint here")):
            wrong = self.write("m.urdf", ROBOT.replace("MIMIC", f'<mimic joint="{leader}"/>'))
            self.assert_failure(run("import", wrong), 3, f"found '{leader}', {what}")
        loops = self.write("loops.yaml", "closed_loop: []\ntype: []\n")
        self.assert_failure(run("import", robot, "--loops", loops), 3, "closed_loop: expected at least one pair [A, B], found an empty list")

    def test_sizes_and_kinds_of_what_a_spec_is_read_from(self):
        large = self.write("large.yaml", "#" * 10_000_003)
        self.assert_failure(run("check", large), 3, "expected a document of at most 4 MiB, found one that is larger")
        spec = self.write("s.yaml", "space: planar\ninclude: {file: f, as: a}\n")
        os.mkdir(self.path("f"))
        self.assert_failure(run("check", spec), 3, "found a folder at")

    def test_a_spec_is_offered_as_a_spec_and_a_suite_as_a_suite(self):
        self.write("x.yaml", self.spec())
        self.assertNotIn("x.yaml", run("batch", cwd=self.folder).stderr)
        self.assertIn("x.yaml", run("check", cwd=self.folder).stderr)
        self.write("s.yaml", "cases: {a: {spec: x.yaml}}\n")
        self.assertIn("this folder contains s.yaml", run("batch", cwd=self.folder).stderr)
        self.assertIn("this folder contains x.yaml", run("check", cwd=self.folder).stderr)

    def test_commas_and_slips(self):
        arm = """space: planar
parameters: {m: 1}
bodies: {link: {mass: m, com: [0.5, 0], inertia: 0.1, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {J1: {type: revolute, connects: [ground.O, link.A]}}
"""
        for wrong, right, hint in (("com: [0.5, 0]", "com: [0,25, 0]", "use a decimal point: 0.25"),
                                   ("{m: 1}", "{m: 1,5}", "use a decimal point: 1.5"),
                                   ("mass: m", "mass: 1,000.5", "use a decimal point: 1000.5"),
                                   ("mass: m", "mass: '1.234,5'", "use a decimal point: 1234.5"),
                                   ("bodies:", "body:", "nearest is 'bodies'")):
            self.assert_failure(run("check", self.write("arm.yaml", arm.replace(wrong, right))), 3, hint)
        spec = self.write("arm.yaml", arm + "actuators: [J1]\n")
        self.assert_failure(run("simulate", spec, "--at", "J1=0,3"), 2, "use a decimal point: 0.3")
        self.assertNotIn("nearest", run("simulate", spec, "--foo").stderr)


if __name__ == "__main__":
    unittest.main()
