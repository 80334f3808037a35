#!/usr/bin/env python3
"""scripts/sweep.smk: the shards of a suite under Snakemake, one of them killed."""

import os
import pathlib
import shutil
import stat
import subprocess
import unittest

from _program import CONFIGS, PROGRAM, Case, run
from _untimed import untimed

WORKFLOW = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts" / "sweep.smk"
SUITE = """
matrix: {spec: SPEC, trajectory: cycloid, samples: 101, set: {xg: {from: -0.09, to: 0.09, count: 9}}}
"""
# Dies by SIGKILL once in the middle of shard 2, after some of its cases.
KILLED_ONCE = """#!/bin/sh
case "$*" in
  *"--shard 2/"*)
    if mkdir FOLDER/died 2>/dev/null; then
      timeout --signal KILL 0.02 PROGRAM "$@"
      kill -KILL $$
    fi ;;
esac
echo "$@" >> FOLDER/calls
exec PROGRAM "$@"
"""


@unittest.skipUnless(shutil.which("snakemake"), "snakemake is not installed")
class Sweep(Case):
    def snakemake(self, *config):
        command = ["snakemake", "--snakefile", str(WORKFLOW), "--directory", self.folder, "--cores", "2", "--nolock",
                   "--config", "suite=suite.yaml", "shards=3", "out=out", *config]
        environment = {**os.environ, "HOME": self.folder, "XDG_CACHE_HOME": self.path("cache")}
        return subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True, check=False,
                              timeout=240)

    def results(self, folder):
        return {path.name: untimed(path.read_bytes()) for path in pathlib.Path(self.path(folder)).iterdir()
                if path.is_file() and not path.name.startswith(".") and path.name != "verdict.txt"}

    def test_a_killed_shard_is_tried_again_and_the_whole_is_the_same(self):
        self.write("suite.yaml", SUITE.replace("SPEC", os.path.join(CONFIGS, "3rrr.yaml")))
        self.assert_quiet_success(run("batch", self.path("suite.yaml"), "-o", self.path("whole")))
        wrapper = self.write("wrapper", KILLED_ONCE.replace("FOLDER", self.folder).replace("PROGRAM", PROGRAM))
        os.chmod(wrapper, stat.S_IRWXU)
        done = self.snakemake(f"balance={wrapper}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(os.path.isdir(self.path("died")))
        self.assertEqual(self.results("out"), self.results("whole"))
        self.assertEqual(pathlib.Path(self.path("out/verdict.txt")).read_text(encoding="utf-8"), "0\n")
        calls = pathlib.Path(self.path("calls")).read_text(encoding="utf-8")
        self.assertEqual(calls.count("--shard"), 3)

        again = self.snakemake(f"balance={wrapper}")
        self.assertEqual(again.returncode, 0, again.stderr)
        calls = pathlib.Path(self.path("calls")).read_text(encoding="utf-8")
        self.assertEqual(calls.count("--shard"), 3, "what is finished ran again")

    def test_a_case_that_takes_too_long_is_in_the_verdict_and_no_reason_to_try_again(self):
        """(C1)"""
        self.write("suite.yaml", SUITE.replace("SPEC", os.path.join(CONFIGS, "3rrr.yaml")) +
                   f"cases: {{long: {{spec: {CONFIGS}/3rrr.yaml, samples: 3000000}}}}\n")
        wrapper = self.write("wrapper", f"#!/bin/sh\necho \"$@\" >> {self.folder}/calls\nexec {PROGRAM} \"$@\"\n")
        os.chmod(wrapper, stat.S_IRWXU)
        done = self.snakemake(f"balance={wrapper}", "options=--case-timeout 2 --metrics-only")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(pathlib.Path(self.path("out/verdict.txt")).read_text(encoding="utf-8"), "5\n")
        self.assertIn("exceeded --case-timeout 2 s", self.results("out")["summary.md"].decode())
        calls = pathlib.Path(self.path("calls")).read_text(encoding="utf-8")
        self.assertEqual(calls.count("--shard"), 3)


if __name__ == "__main__":
    unittest.main()
