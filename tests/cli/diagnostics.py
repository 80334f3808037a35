"""What is wrong with a spec reaches people and programs: all of it, in parts, and nothing that steers a terminal."""

import json
import os
import shutil
import unittest

import yaml

from _program import CONFIGS, Case, run

WRONG = """\
name: "wrong \\e[31m"
space: planar
ground: {points: {O: [0, 0]}}
bodies:
  arm: {mass: -1, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0]}}
  "fore\\u202earm": {mass: 1, com: [0.1, 0, 0], inertia: 0.01, points: {A: [0, 0]}}
joints:
  J: {type: hinge, connects: [ground.O, arm.A]}
  K: {type: revolute, connects: [arm.B, "fore\\u202earm.A"]}
loads:
  push: {on: arm, force: [1, "3 N"]}
"""

KEYS = ["bodies.arm.mass", "bodies.fore\u202earm", "bodies.fore\u202earm.com", "joints.J.type", "joints.K.connects[0]",
        "loads.push.force[1]"]


class Mistakes(Case):
    def test_all_of_them_are_told_a_line_each_D7(self):
        spec = self.write("wrong.yaml", WRONG)
        for command in ("check", "simulate", "conditions", "design", "control", "report"):
            with self.subTest(command=command):
                done = run(command, spec)
                self.assertEqual(done.returncode, 3)
                lines = done.stderr.splitlines()
                self.assertEqual(len(lines), len(KEYS), done.stderr)
                for line in lines:
                    self.assertRegex(line, r"^.*wrong\.yaml:\d+:\d+: [^ ].*: expected ")
                self.assertNotRegex(done.stderr + done.stdout, "[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e]")

    def test_json_has_their_parts_D7(self):
        spec = self.write("wrong.yaml", WRONG)
        done = run("check", spec, "--json")
        error = json.loads(done.stdout)["error"]
        self.assertEqual((done.returncode, error["kind"], error["more"]), (3, "spec", 0))
        self.assertEqual([mistake["key"] for mistake in error["mistakes"]], KEYS)
        first = error["mistakes"][0]
        self.assertEqual(first, {"file": spec, "line": 5, "column": 15, "key": "bodies.arm.mass",
                                 "message": "must be positive: expected a number > 0, found -1",
                                 "expected": "a number > 0", "found": "-1", "hint": None})
        self.assertEqual(error["message"], done.stderr.rstrip("\n"))
        self.assertNotIn("\u202e", done.stdout)

    def test_options_are_the_callers_D7(self):
        spec = os.path.join(CONFIGS, "rr-design.yaml")
        for option, value, file in (("--set", "nosuch=1", "--set nosuch"), ("--minimize", "[weight, mass]", "--minimize")):
            done = run("design" if option == "--minimize" else "check", spec, option, value, "--json")
            error = json.loads(done.stdout)["error"]
            self.assertEqual((done.returncode, error["kind"]), (2, "usage"))
            self.assertEqual({mistake["file"] for mistake in error["mistakes"]}, {file})
            self.assertEqual({mistake["line"] for mistake in error["mistakes"]}, {None})
        self.assertEqual(len(error["mistakes"]), 2)

    def test_a_file_called_like_a_command_to_the_terminal_is_spelt_out_C8(self):
        name = self.path("a\x1b[31m\u202eb.yaml")
        shutil.copy(os.path.join(CONFIGS, "rr.yaml"), name)
        for arguments in (("check", name), ("simulate", name), ("check", self.path("no\x07ne.yaml"))):
            done = run(*arguments)
            self.assertNotRegex(done.stdout + done.stderr, "[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e]")

    def test_a_round_trip_through_yaml_1_1_D8(self):
        with open(os.path.join(CONFIGS, "rr-balanced.yaml"), encoding="utf-8") as file:
            text = file.read()
        again = self.write("again.yaml", yaml.safe_dump(yaml.safe_load(text), sort_keys=False, allow_unicode=True))
        self.assert_quiet_success(run("check", again))
        old = text.replace("{body: ", "{on: ")
        self.assertNotEqual(old, text)
        self.assert_quiet_success(run("check", self.write("old.yaml", old)))
        broken = self.write("broken.yaml", yaml.safe_dump(yaml.safe_load(old), sort_keys=False, allow_unicode=True))
        self.assert_failure(run("check", broken), 3, "found 'true'", "use 'body'")


if __name__ == "__main__":
    unittest.main()
