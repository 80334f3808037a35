#!/usr/bin/env python3
"""The recipes of docs/cluster.md: the Slurm array with an `sbatch` that runs what it is given at once, and the Snakemake commands. On a Slurm of
our own, with killed tasks and dead nodes, they run in scripts/soak cluster."""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from _console import ROOT, workplace

sys.path.insert(0, str(ROOT / "tests/cli"))

from _untimed import untimed  # noqa: E402  (found by the line above)

PAGE = (ROOT / "docs/cluster.md").read_text(encoding="utf-8")
SUITE = "matrix: {spec: configs/3rrr.yaml, trajectory: cycloid, samples: 11, set: {xg: {from: -0.09, to: 0.09, count: 6}}}\n"
SBATCH = """#!/bin/bash
# Runs what it is given: all tasks of an array's script, or the command behind --wrap.
while [[ $# -gt 1 && $1 != --wrap ]]; do shift; done
if [[ $1 == --wrap ]]; then bash -c "$2"; exit; fi
last=$(sed -n 's/^#SBATCH --array=1-//p' "$1")
for ((SLURM_ARRAY_TASK_ID = 1; SLURM_ARRAY_TASK_ID <= last; ++SLURM_ARRAY_TASK_ID)); do
  SLURM_CPUS_PER_TASK=1 SLURM_ARRAY_TASK_ID=$SLURM_ARRAY_TASK_ID bash "$1" >&2 || exit
done
echo 1
"""


def block(begin):
    """The block of commands that begins so, with its first lines joined where a backslash ends them."""
    return re.search(rf"^```(?:bash)?\n({begin}.*?)^```$", PAGE, re.MULTILINE | re.DOTALL).group(1).replace("\\\n", " ")


class Recipes(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder, self.environment = workplace(temporary.name)
        (self.folder / "suite.yaml").write_text(SUITE, encoding="utf-8")

    def shell(self, script):
        done = subprocess.run(["bash", "-ec", script], cwd=self.folder, env=self.environment, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def results(self, folder):
        return {path.name: untimed(path.read_bytes()) for path in (self.folder / folder).iterdir()
                if path.is_file() and path.suffix != ".txt" and not path.name.startswith(".")}

    def assert_as_on_one_machine(self):
        self.shell("balance batch suite.yaml -o plain --quiet")
        self.assertEqual(self.results("results"), self.results("plain"))

    def test_the_array_of_jobs_computes_what_one_machine_does(self):
        script = block("#!/bin/bash").replace("--array=1-50", "--array=1-6").replace("$SLURM_ARRAY_TASK_ID/50", "$SLURM_ARRAY_TASK_ID/6")
        self.assertNotIn("50", script)
        (self.folder / "shards.sh").write_text(script, encoding="utf-8")
        sbatch = self.folder / "bin/sbatch"
        sbatch.write_text(SBATCH, encoding="utf-8")
        sbatch.chmod(0o755)
        self.shell(block("job="))
        self.assert_as_on_one_machine()

    @unittest.skipUnless(shutil.which("snakemake"), "snakemake is not installed")
    def test_snakemake_computes_what_one_machine_does(self):
        self.shell(block("snakemake .*?--cores"))
        self.assertEqual((self.folder / "results/verdict.txt").read_text(encoding="utf-8").strip(), "0")
        self.assert_as_on_one_machine()

    @unittest.skipUnless(shutil.which("snakemake"), "snakemake is not installed")
    def test_snakemake_accepts_the_command_for_slurm(self):
        self.shell(block("snakemake [^`]*?--cluster ").strip() + " --dry-run")


if __name__ == "__main__":
    unittest.main()
