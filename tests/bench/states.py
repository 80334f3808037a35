#!/usr/bin/env python3
"""What 100,000 states cost in Python as a ratio to C++: processor time on one machine, in turns.

usage: PYTHONPATH=<build>/python states.py <bench build>/tests/bench/states_bench <configs>"""

import json
import subprocess
import sys
import time

import numpy

import balance_mechanisms as bm


def states(freedoms, rows=100_000):
    wave = numpy.linspace(0, 1000, rows)[:, None] + numpy.arange(freedoms)
    return 0.3 * numpy.sin(wave), 0.3 * numpy.cos(wave), -0.3 * numpy.sin(wave)


def seconds_of_python(config):
    mechanism = bm.load(config).mechanism
    asked = states(mechanism.dof)
    best = float("inf")
    for _ in range(20):
        begin = time.process_time()
        mechanism.inverse_dynamics(*asked)
        best = min(best, time.process_time() - begin)
    return best


def seconds_of_library(program, name):
    done = subprocess.run([program, f"--benchmark_filter=/{name}/", "--benchmark_format=json", "--benchmark_repetitions=20",
                           "--benchmark_min_time=0.001"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True)
    return min(one["cpu_time"] for one in json.loads(done.stdout)["benchmarks"] if one["run_type"] == "iteration") / 1e3


def main(program, configs):
    for name in ("spatial_rrr", "scara"):
        pairs = [(seconds_of_python(f"{configs}/{name.replace('_', '-')}.yaml"), seconds_of_library(program, name))
                 for _ in range(5)]
        python, library = (min(column) for column in zip(*pairs))
        print(f"{name}: Python {1e3 * python:.2f} ms, C++ {1e3 * library:.2f} ms, ratio {python / library:.3f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
