#!/usr/bin/env python3
"""`balance simulate` against the reference: trajectories of all configs, all quantities, at seven samples.

Finds the program in the environment variable BALANCE, the mechanisms in CONFIGS and in specs/ beside this file.
Arguments: configs, or config:trajectory. Without them a sample (cli/_sampling.py); BALANCE_WHOLE=1 tries every trajectory."""
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

import h5py
import numpy as np

from laws import LAWS
from mechanism import Mechanism
from reference import at_indices
from spec import Spec, binds_rates, buys_parts
from _sampling import draw, traits_of

CONFIGS = os.environ.get("CONFIGS", os.path.join(HERE, "..", "..", "configs"))
# Both solve positions to about 1e-13 of their size; accelerations and forces lose up to the condition number of the
# closures, a few hundred in the configs.
TOLERANCE = 1e-10


def cases(chosen):
    folders = (CONFIGS, os.path.join(HERE, "specs"))
    for path in (path for folder in folders for path in sorted(glob.glob(os.path.join(folder, "*.yaml")))):
        name = os.path.basename(path)[:-5]
        raw = Spec.load(path)
        # tests/cli/include.py holds what is made of parts against what is written out.
        if "bodies" not in raw or "motion" not in raw or "include" in raw or binds_rates(raw) or buys_parts(raw):
            continue
        for trajectory, entry in (raw.get("trajectories") or {}).items():
            path_kind = entry.get("path", "line")
            known = entry.get("law") in LAWS and (path_kind == "line" or not {"table", "file"} & set(path_kind))
            if known and (not chosen or name in chosen or f"{name}:{trajectory}" in chosen):
                yield path, trajectory


def traits(case):
    """Those of the spec, and of this one of its trajectories."""
    path, trajectory = case
    entry = Spec.load(path)["trajectories"][trajectory]
    kind = entry.get("path", "line")
    own = {f"law: {entry['law']}", f"drive: {entry.get('drive', 'tool')}", *([kind] if isinstance(kind, str) else kind)}
    return {t for t in traits_of(path) if not t.startswith(("law:", "drive:"))} | own


def size_of(mechanism):
    points = [np.linalg.norm(place) for joint in mechanism.joints for place in (joint["p"], joint["q"])]
    return max(points + [1e-3])


class Scales:
    """What counts as one: the largest value of a quantity, but no less than its kin let expect."""
    def __init__(self, mechanism, samples):
        def largest(*names):
            return max(np.abs(s[name]).max(initial=0) for s in samples for name in names if name in s)
        self.length = max(size_of(mechanism), largest("com_position"))
        self.rate = largest("joint_velocity") + 1e-9
        self.acceleration = max(largest("joint_acceleration"), self.rate**2)
        self.force = max(largest("joint_force", "shaking_force", "ground_force"),
                         mechanism.mass * self.length * self.acceleration)
        self.moment = max(largest("torque", "joint_moment", "shaking_moment", "ground_moment"),
                          self.force * self.length)

    def of(self, name):
        return {"joint_position": 1, "joint_velocity": self.rate, "joint_acceleration": self.acceleration,
                "power": self.moment * self.rate, "com_position": self.length, "com_velocity": self.length * self.rate,
                "com_acceleration": self.length * self.acceleration, "tool_position": self.length,
                "tool_orientation": 1, "shaking_force": self.force, "ground_force": self.force,
                "joint_force": self.force}.get(name, self.moment)


def difference(name, found, sample, mechanism):
    expected = np.array(sample[name])
    if found.shape != expected.shape and found.size == expected.size:
        found = found.reshape(expected.shape)   # a moment in the plane is one number
    error = found - expected
    if name == "joint_position":
        turning = np.array(mechanism.angular[:mechanism.spec_coordinates])
        error = np.where(turning, np.remainder(error + np.pi, 2 * np.pi) - np.pi, error)
    elif name == "tool_orientation" and mechanism.planar:
        error = np.remainder(error + np.pi, 2 * np.pi) - np.pi
    elif name == "tool_orientation":
        error = min(error, found + expected, key=np.linalg.norm)   # q and −q are one orientation
    elif name in ("joint_force", "joint_moment"):
        error = np.where(np.array(sample[name + "_open"]) > 1e-7, 0, error)   # no unique answer there
    elif name in ("torque", "power"):
        error = np.where(np.array(sample["torque_open"]) > 1e-7, 0, error)
    return np.abs(error).max(initial=0)


def sticks(sample, mechanism):
    """Dry friction at rest may take any value up to its limit."""
    fastest = np.abs(sample["joint_velocity"]).max()
    return any(coulomb and abs(sample["joint_velocity"][c]) <= 1e-9 * fastest + 1e-12
               for c, _, coulomb in mechanism.friction)


QUANTITIES = ["joint_position", "joint_velocity", "joint_acceleration", "torque", "power", "com_position",
              "com_velocity", "com_acceleration", "tool_position", "tool_orientation", "shaking_force",
              "shaking_moment", "ground_force", "ground_moment", "joint_force", "joint_moment", "kinetic_energy"]


def labels(result, name):
    return [x.decode() if isinstance(x, bytes) else str(x) for x in result[name][...]]


def faults_in(result, reference, mechanism):
    faults, samples = [], [s for s in reference["samples"] if not sticks(s, mechanism)]
    for name in ("coordinate", "joint", "actuator"):
        if labels(result, name) != reference[name]:
            faults.append(f"labels {name}: {labels(result, name)}, expected {reference[name]}")
    if faults:
        return faults, 0
    scales, worst = Scales(mechanism, samples), 0
    for name in QUANTITIES:
        if name not in samples[0]:
            continue
        if name not in result:
            faults.append(f"{name} is missing")
            continue
        errors = [difference(name, result[name][s["index"]], s, mechanism) / scales.of(name) for s in samples]
        worst = max([worst] + errors)
        if not max(errors) <= TOLERANCE:
            at = int(np.argmax(errors))
            faults.append(f"{name} at t = {samples[at]['time']:.6g} differs by {errors[at]:.2e} of its scale: "
                          f"{np.array2string(result[name][samples[at]['index']], precision=9, threshold=12)}, "
                          f"expected {np.array2string(np.array(samples[at][name]), precision=9, threshold=12)}")
    for s in samples:
        if abs(result["time"][s["index"]] - s["time"]) > 1e-12 * abs(s["time"]):
            faults.append(f"sample {s['index']} is at {result['time'][s['index']]}, expected {s['time']}")
    return faults, worst


def compare(case):
    path, trajectory = case
    title = f"{os.path.basename(path)[:-5]}:{trajectory}"
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "result.h5")
        command = [os.environ["BALANCE"], "simulate", path, "--trajectory", trajectory, "-o", file]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return title, [f"exit code {done.returncode}", done.stderr.strip()], 0
        with h5py.File(file, "r") as result:
            return (title, *faults_in(result, at_indices(path, trajectory), Mechanism(path)))


def main():
    todo = list(cases(sys.argv[1:]))
    if not todo:
        sys.exit("no trajectory to compare")
    if not sys.argv[1:]:
        todo = draw("trajectories against the reference", todo, 0.2, traits)
    failed = 0
    with multiprocessing.Pool(2) as pool:
        for title, faults, worst in pool.imap(compare, todo):
            print(f"{title}: {'differs' if faults else f'agrees to {worst:.1e}'}", *faults, sep="\n    ", flush=True)
            failed += bool(faults)
    print(f"{len(todo) - failed} of {len(todo)} trajectories agree")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
