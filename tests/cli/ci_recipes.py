#!/usr/bin/env python3
"""Runs the script lines of the jobs in docs/ci.md: they pass, and fail when a change raises the shaking force."""

import os
import pathlib
import re
import subprocess
import unittest
import xml.etree.ElementTree as xml

import yaml

from _program import CONFIGS, PROGRAM, Case

PAGE = pathlib.Path(__file__).resolve().parent.parent.parent / "docs" / "ci.md"


def blocks():
    """The YAML blocks of the page, by the file's name that the first line is a comment of."""
    text = PAGE.read_text(encoding="utf-8")
    return {re.match(r"# (\S+)", block).group(1): block for block in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)}


class Recipes(Case):
    def setUp(self):
        super().setUp()
        os.mkdir(self.path("bin"))
        os.symlink(PROGRAM, self.path("bin/balance"))
        self.environment = {**os.environ, "PATH": self.path("bin") + ":" + os.environ["PATH"], "HOME": self.folder,
                            "GIT_AUTHOR_NAME": "a", "GIT_AUTHOR_EMAIL": "a@b", "GIT_COMMITTER_NAME": "a",
                            "GIT_COMMITTER_EMAIL": "a@b"}
        with open(os.path.join(CONFIGS, "3rrr-redistributed.yaml"), encoding="utf-8") as file:
            self.good = file.read()
        self.bad = self.good.replace("xg: -0.09", "xg: 0.09")
        self.assertNotEqual(self.good, self.bad)

    def shell(self, script, folder, **variables):
        """As runners do: the first line that fails ends the script."""
        return subprocess.run(["bash", "-e", "-c", script], cwd=folder, env={**self.environment, **variables},
                              capture_output=True, text=True, check=False, timeout=120)

    def test_the_github_job(self):
        job = yaml.safe_load(blocks()[".github/workflows/balance.yml"])["jobs"]["shaking-force"]
        steps = [step["run"] for step in job["steps"] if "run" in step and "apt-get" not in step["run"]]
        os.mkdir(self.path("work"))
        self.write("work/suite.yaml", blocks()["suite.yaml"])
        self.write("work/reference.yaml", self.good)
        for spec, code in ((self.good, 0), (self.bad, 1)):
            self.write("work/design.yaml", spec)
            summary = self.write("summary.md", "")
            done = self.shell(steps[0], self.path("work"))
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            self.assertEqual(self.shell(steps[1], self.path("work"), GITHUB_STEP_SUMMARY=summary).returncode, 0)
            with open(summary, encoding="utf-8") as file:
                self.assertIn("| design | done |", file.read())

    def test_the_github_job_with_limits_for_cases(self):
        command = re.search(r"`(balance batch suite\.yaml [^`]*--case-timeout[^`]*)`", PAGE.read_text(encoding="utf-8")).group(1)
        os.mkdir(self.path("work"))
        self.write("work/suite.yaml", blocks()["suite.yaml"])
        for name in ("reference", "design"):
            self.write(f"work/{name}.yaml", self.good)
        done = self.shell(command, self.path("work"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_gitlab_job(self):
        script = "\n".join(yaml.safe_load(blocks()[".gitlab-ci.yml"])["shaking-force"]["script"])
        os.mkdir(self.path("origin"))
        self.write("origin/design.yaml", self.good)
        made = self.shell("git init -q -b main . && git add -A && git commit -qm one && git clone -q . ../work",
                          self.path("origin"))
        self.assertEqual(made.returncode, 0, made.stderr)
        for spec, code in ((self.good, 0), (self.bad, 1)):
            self.write("work/design.yaml", spec)
            done = self.shell(script, self.path("work"), CI_MERGE_REQUEST_TARGET_BRANCH_NAME="main")
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            failed = [case for case in xml.parse(self.path("work/junit.xml")).iter("testcase") if list(case.iter("failure"))]
            self.assertEqual(len(failed), code)


if __name__ == "__main__":
    unittest.main()
