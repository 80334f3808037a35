"""Numbers that grow beyond what can be computed with are called so, by every command (A7)."""

import json
import os
import re
import unittest

from _program import CONFIGS, Case, run

HUGE = (("mass: 2,", "mass: 1e200,"), ("a1: 0.5", "a1: 1e154"), ("a1: 0.5", "a1: 1e308"), ("inertia: 0.042", "inertia: 1e200"))
COMMANDS = (["check"], ["simulate"], ["conditions", "--goal", "dynamic"], ["control", "-c", "computed-torque"])


class Overflow(Case):
    def test_no_command_prints_what_is_no_number(self):
        with open(os.path.join(CONFIGS, "rr.yaml"), encoding="utf-8") as file:
            text = file.read()
        refused = 0
        for old, new in HUGE:
            self.assertIn(old, text)
            spec = self.write("huge.yaml", text.replace(old, new, 1))
            for command in COMMANDS:
                with self.subTest(number=new, command=command):
                    done = run(command[0], spec, *command[1:])
                    self.assertIn(done.returncode, (0, 1, 3, 4), done.stderr)
                    refused += done.returncode == 4
                    if done.returncode < 2:
                        self.assertIsNone(re.search(r"\b(nan|inf)\b", done.stdout), done.stdout)
                    self.assertNotIn("rank", done.stderr)
        self.assertGreater(refused, 4)

    def test_a_run_says_where(self):
        with open(os.path.join(CONFIGS, "rr.yaml"), encoding="utf-8") as file:
            text = file.read()
        spec = self.write("huge.yaml", text.replace("mass: 2,", "mass: 1e200,", 1))
        self.assert_failure(run("simulate", spec, "-t", "cycloid"), 4, "numbers overflow at t = ")

    def test_an_effort_that_cannot_be_computed_is_not_known(self):
        with open(os.path.join(CONFIGS, "rr.yaml"), encoding="utf-8") as file:
            text = file.read()
        load = "\nloads:\n  push: {body: link1, at: [50, 0], force: [1e308, 1e308], frame: body}\n"
        spec = self.write("huge.yaml", text + load)
        done = run("conditions", spec, "--goal", "static")
        self.assertIn("not known at rest: the effort of ", done.stdout)
        self.assertIsNone(re.search(r"\b(nan|inf)\b", done.stdout), done.stdout)
        staying = json.loads(run("conditions", spec, "--goal", "static", "--json").stdout)["staying"]
        self.assertIn(None, [unknown["along"] for unknown in staying[0]["unknown"]])


if __name__ == "__main__":
    unittest.main()
