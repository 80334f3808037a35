#!/usr/bin/env python3
"""Runs every trajectory of one spec and looks into every result file.

A run must end with exit code 0 and leave a file whose time increases and whose numbers are all finite."""

import os
import subprocess
import sys
import tempfile

import h5py
import numpy
import yaml

BUILT_IN = ["cycloid", "bang-bang"]


def trajectories(spec_file):
    with open(spec_file, encoding="utf-8") as stream:
        spec = yaml.safe_load(stream)
    names = list((spec.get("trajectories") or {}).keys())
    return names + [name for name in BUILT_IN if name not in names]


def run(spec_file, trajectory, result_file):
    command = [os.environ["BALANCE"], "simulate", spec_file, "--trajectory", trajectory, "-o", result_file, "--force"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return [f"exit code {done.returncode}", done.stdout, done.stderr]
    return faults(result_file)


def faults(result_file):
    """What is wrong with a result file, one line each."""
    found = []

    def look(name, item):
        if not isinstance(item, h5py.Dataset) or item.dtype.kind != "f":
            return
        if not numpy.isfinite(item[...]).all():
            found.append(f"{name} has numbers that are not finite")

    with h5py.File(result_file, "r") as result:
        result.visititems(look)
        time = result["time"][...]
        if len(time) < 2 or not (numpy.diff(time) > 0).all():
            found.append("time does not increase")
        for name in ["joint_position", "torque", "shaking_force"]:
            if len(result[name]) != len(time):
                found.append(f"{name} has {len(result[name])} rows, time has {len(time)}")
    return found


def main():
    spec_file = sys.argv[1]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        for trajectory in trajectories(spec_file):
            found = run(spec_file, trajectory, os.path.join(folder, "result.h5"))
            print(f"{os.path.basename(spec_file)} {trajectory}: {'failed' if found else 'ok'}")
            for line in found:
                print(f"  {line}")
            failed = failed or bool(found)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
