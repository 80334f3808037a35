#!/usr/bin/env python3
"""`balance design` judged by the reference: the spec that it writes meets the conditions derived here.

Finds the program in the environment variable BALANCE, the mechanisms in CONFIGS. Arguments: configs. Without them a sample
(cli/_sampling.py); BALANCE_WHOLE=1 tries every design."""
import glob
import multiprocessing
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "cli")]
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")   # small matrices: threads only get in each other's way

import numpy as np

from conditions import configurations, derive, every_name, values
from mechanism import Mechanism
from spec import Spec, buys_parts
from _sampling import draw, traits_of

CONFIGS = os.environ.get("CONFIGS", os.path.join(HERE, "..", "..", "configs"))
# The program calls a residual of 1e-10 met. Rows of the reference are combinations of its conditions, and the narrowest of
# them are known to 1e-8 of the widest.
TOLERANCE = 1e-9
# By design, say their headers: exit code 1, the best compromise is written.
IMPOSSIBLE = {"5r-impossible", "5r-catalogue"}


def distance(path, goals):
    """How far the spec's numbers are from meeting the goals, their own size being 1."""
    mechanism = Mechanism(path)
    names, worst = every_name(mechanism), 0
    for goal in goals:
        basis, _, units = derive(mechanism, goal, names, configurations(mechanism))
        size = values(mechanism, names) / units
        worst = max(worst, np.linalg.norm(basis @ size) / np.linalg.norm(size))
    return worst


def judge(path):
    name = os.path.basename(path)[:-5]
    goals = np.atleast_1d(Spec.load(path)["design"]["goal"]).tolist()
    with tempfile.TemporaryDirectory() as folder:
        written = os.path.join(folder, "balanced.yaml")
        done = subprocess.run([os.environ["BALANCE"], "design", path, "-o", written], capture_output=True, text=True,
                              check=False)
        expected = 1 if name in IMPOSSIBLE else 0
        if done.returncode != expected:
            return name, False, f"exit code {done.returncode}, expected {expected}: {done.stderr.strip()}"
        if "{free:" in open(written, encoding="utf-8").read():
            return name, False, "a number is still free"
        if name in IMPOSSIBLE:
            return name, True, "impossible"
        before, after = distance(path, goals), distance(written, goals)
    text = f"{' and '.join(goals)}: {before:.1e} before, {after:.1e} after"
    return name, after < TOLERANCE and before > 1e-4, text


def main():
    todo = [path for path in sorted(glob.glob(os.path.join(CONFIGS, "*.yaml")))
            if "{free:" in open(path, encoding="utf-8").read() and "goal" in Spec.load(path).get("design", {})
            and not buys_parts(Spec.load(path))
            and (not sys.argv[1:] or os.path.basename(path)[:-5] in sys.argv[1:])]
    if not todo:
        sys.exit("no design to judge")
    if not sys.argv[1:]:
        todo = draw("designs against the reference", todo, 0.2, traits_of)
    failed = 0
    with multiprocessing.Pool(2) as pool:
        for name, good, text in pool.imap(judge, todo):
            print(f"{name}: {'' if good else 'WRONG: '}{text}", flush=True)
            failed += not good
    print(f"{len(todo) - failed} of {len(todo)} designs are balanced")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
