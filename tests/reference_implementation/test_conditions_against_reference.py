#!/usr/bin/env python3
"""`balance conditions` against the reference: equal rank and equal row space, for configs and every goal.

Finds the program in the environment variable BALANCE, the mechanisms in CONFIGS and in specs/ beside this file.
Arguments: configs, or config:goal. Without them a sample of the configs (cli/_sampling.py); BALANCE_WHOLE=1 tries every config."""
import glob
import json
import multiprocessing
import os
import re
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "cli")]
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")   # small matrices: threads only get in each other's way

import numpy as np

from conditions import NoConditions, configurations, derive, every_name
from mechanism import Mechanism
from spec import Spec, binds_rates, buys_parts
from _sampling import draw, traits_of

CONFIGS = os.environ.get("CONFIGS", os.path.join(HERE, "..", "..", "configs"))
GOALS = ["static", "gyroscopic", "gyroscopic-independent", "decoupled", "fully-static", "fully-decoupled", "force",
         "moment", "dynamic", "proportional", "affine"]
# A dozen bodies in space have hundreds of parameters and take the reference seconds for each goal. The squeezer's links hardly
# turn while its crank does: what its motions show of the other goals is too little to count their conditions.
FEWER_GOALS = {"stewart": ["static", "force"], "delta": ["gyroscopic-independent"],
               "delta-gravity": ["static", "force"], "squeezer": ["static", "gyroscopic", "force", "proportional"]}
# Of the sine of the largest angle between the row spaces. Rows are exact to about 1e-15 of the largest; what the
# narrowest motions (the six-bar) show of a condition is 1e-8 of it, so 1e-7 is what is left. A condition too many or too
# few gives 1.
TOLERANCE = 1e-7


def cases(chosen):
    """(path, goals) for every mechanism."""
    folders = (CONFIGS, os.path.join(HERE, "specs"))
    for path in (path for folder in folders for path in sorted(glob.glob(os.path.join(folder, "*.yaml")))):
        name = os.path.basename(path)[:-5]
        raw = Spec.load(path)
        if "bodies" not in raw or "include" in raw or binds_rates(raw) or buys_parts(raw):
            continue
        goals = [g for g in FEWER_GOALS.get(name, GOALS) if not chosen or name in chosen or f"{name}:{g}" in chosen]
        if goals:
            yield path, goals


def run(path, goal):
    """What the program says; None if the goal makes no sense for the mechanism."""
    command = [os.environ["BALANCE"], "conditions", path, "--goal", goal, "--numbers", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == 4 and re.search("actuator|tool", done.stderr):
        return None
    if done.returncode not in (0, 1):   # 1: friction or a load stays, which is no condition on masses
        raise RuntimeError(f"exit code {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def tree_joints(answer):
    """The joints in whose accelerations the program writes the torques: where there are loops it has to say so."""
    for note in answer.get("notes", []):
        if found := re.search(r"in the accelerations of (.+)$", note):
            return found.group(1).split(", ")
    return None


def orthonormal(rows):
    if not len(rows):
        return rows
    rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return np.linalg.qr(rows.T)[0].T


def largest_sine(one, other):
    """Of the angles between two spaces of equal dimension, given by orthonormal rows."""
    return np.linalg.norm(one - one @ other.T @ other, 2) if len(one) else 0


class Shared:
    """The same configurations for every goal, drawn when they are needed."""
    def __init__(self, source):
        self.source, self.drawn = source, []

    def __iter__(self):
        k = 0
        while True:
            if k == len(self.drawn):
                self.drawn.append(next(self.source))
            yield self.drawn[k]
            k += 1


def compare(path, goal, mechanism, samples):
    """One line for the report: agreement, or what is wrong."""
    answer = run(path, goal)
    names = answer["parameters"] if answer else []
    try:
        if goal in ("proportional", "affine") and mechanism.tool is None:
            raise NoConditions("no tool")
        if answer is None:
            derive(mechanism, goal, every_name(mechanism), samples)
            return False, "refused by the program, not by the reference"
        basis, gap, units = derive(mechanism, goal, names, samples, tree_joints(answer))
    except NoConditions as reason:
        return answer is None, f"refused: {reason}"
    rows = np.zeros((len(answer["conditions"]), len(names)))
    for row, condition in zip(rows, answer["conditions"]):
        for term in condition["terms"]:
            row[names.index(term["parameter"])] = term["coefficient"]
    found = orthonormal(rows * units)
    if gap < 1e3:
        return False, f"the reference sees no clear rank: gap {gap:.1e}"
    if not answer["rank"] == len(found) == len(basis):
        return False, f"rank {answer['rank']}, {len(found)} conditions, expected {len(basis)}"
    sine = largest_sine(found, basis)
    return sine < TOLERANCE, f"rank {len(basis)}, largest sine {sine:.1e}"


def compare_all(case):
    path, goals = case
    mechanism = Mechanism(path)
    samples, found = Shared(configurations(mechanism)), []
    for goal in goals:
        try:
            good, text = compare(path, goal, mechanism, samples)
        except Exception as trouble:   # one spec must not hide the others
            good, text = False, f"{type(trouble).__name__}: {trouble}"
        found.append((f"{os.path.basename(path)[:-5]}:{goal}", good, text))
    return found


def main():
    todo = list(cases(sys.argv[1:]))
    if not todo:
        sys.exit("nothing to compare")
    if not sys.argv[1:]:
        todo = draw("conditions against the reference", todo, 0.2, lambda case: traits_of(case[0]))
    failed = count = 0
    with multiprocessing.Pool(2) as pool:
        for found in pool.imap_unordered(compare_all, todo):
            for title, good, text in found:
                print(f"{title}: {'' if good else 'DIFFERS: '}{text}", flush=True)
                failed += not good
                count += 1
    print(f"{count - failed} of {count} sets of conditions agree")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
