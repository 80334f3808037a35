#!/usr/bin/env python3
"""scripts/demo ends with a result where it says, and what it says of the result is so. Nothing is installed or built here: cmake and what asks
for packages do nothing, and the program is the one under test."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import yaml

from _console import ROOT

PRETEND = {"cmake": "exit 0", "dpkg-query": "echo installed"}


class Demo(unittest.TestCase):
    def test_the_result_is_where_the_demo_says(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            for name in ("scripts", "build/release", "bin"):
                (folder / name).mkdir(parents=True)
            for name in ("demo", "setup"):
                shutil.copy(ROOT / "scripts" / name, folder / "scripts" / name)
            (folder / "configs").symlink_to(os.environ["CONFIGS"])
            (folder / "build/release/balance").symlink_to(os.environ["BALANCE"])
            for name, script in PRETEND.items():
                (folder / "bin" / name).write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
                (folder / "bin" / name).chmod(0o755)
            done = subprocess.run([str(folder / "scripts/demo")], capture_output=True, text=True, check=False,
                                  env={**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"})
            self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
            published, best = map(float, re.search(r"carries ([\d.]+) kg .*?; ([\d.]+) kg balance", done.stdout).groups())
            for file, added in ((folder / "configs/published/forbal2-published.yaml", published), (folder / "out/forbal2-best.yaml", best)):
                masses = [weight["mass"] for weight in yaml.safe_load(file.read_text(encoding="utf-8"))["counterweights"].values()]
                self.assertAlmostEqual(sum(masses), added, delta=5e-4)  # three decimals are said
            self.assertIn("out/forbal2-best.yaml, its motion in out/forbal2-best.h5", done.stdout)
            self.assertGreater((folder / "out/forbal2-best.h5").stat().st_size, 10000)


if __name__ == "__main__":
    unittest.main()
