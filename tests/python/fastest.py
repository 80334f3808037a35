"""The laws `fastest` and `gentlest` against an optimiser that knows nothing of them: linear programs over the squares of the rate.

Along a path q(s) every torque and force is a s'' + b s'² + c. With x = s'² at nodes graded towards both ends and the limits in the middle of
the cells, s'' = (x[k+1] - x[k]) / 2h, the law that is fastest has the largest x; limits of a vector's magnitude are cones, which tangents close in on.
"""

import functools
import unittest

import numpy
import yaml
from scipy.interpolate import BPoly
from scipy.optimize import linprog
from scipy.sparse import coo_array

import balance_mechanisms as bm

from _module import Case, config

DIRECTIONS = 16  # a cone begins with so many tangents
MOST_ROUNDS = 15
# Middles of graded cells leave up to 4e-6 where there are places without inertia, 1e-6 elsewhere; laws keep their limits to 1e-6.
TOLERANCE = 1e-5


class Path:
    """What an inverse dynamics tells of a path at the middles of the cells, for s' = 1 and for s'' = 1."""

    def __init__(self, spec, nodes=501):
        run = spec.simulate("even", samples=2001)
        mechanism = spec.mechanism
        columns = [mechanism.coordinates.index(name) for name in mechanism.independent]
        along = [run[f"joint_{name}"][:, columns] for name in ("position", "velocity", "acceleration")]
        place = BPoly.from_derivatives(numpy.array(run.time), numpy.stack(along, axis=1))
        self.door = bm.InverseDynamics(mechanism)
        self.nodes = numpy.sin(numpy.pi / 2 * numpy.linspace(0, 1, nodes)) ** 2
        self.width = numpy.diff(self.nodes)
        middles = (self.nodes[1:] + self.nodes[:-1]) / 2
        self.states = list(zip(place(middles), place.derivative()(middles), place.derivative(2)(middles)))

    @functools.cached_property
    def answers(self):
        """At rest, pushed from rest, and running evenly: of every cell."""
        return [[self.door.at(q, dq, ddq) for dq, ddq in ((0 * q, 0 * q), (0 * q, rate), (rate, bend))] for q, rate, bend in self.states]

    def parts(self, quantity):
        """a, b, c of every cell, a row of components each."""
        found = []
        for answers in self.answers:
            rest, pushed, running = (numpy.ravel(answer[quantity]) for answer in answers)
            found.append((pushed - rest, running - rest, rest))
        return [numpy.array(part) for part in zip(*found)]

    def least_time(self, limits):
        """limits: (quantity, component or None for the magnitude, least, most)"""
        rows, bounds, cones = [], [], []

        def add(a, b, c, most):
            rows.append((b / 2 - a / (2 * self.width), b / 2 + a / (2 * self.width)))
            bounds.append(most - c)

        for quantity, component, least, most in limits:
            a, b, c = self.parts(quantity)
            if component is not None:
                a, b, c = (part[:, component] for part in (a, b, c))
                add(a, b, c, most)
                add(-a, -b, -c, -least)
                continue
            cones.append((a, b, c, most))
            for angle in 2 * numpy.pi * numpy.arange(DIRECTIONS) / DIRECTIONS:
                way = numpy.array([numpy.cos(angle), numpy.sin(angle)])
                add(a @ way, b @ way, c @ way, most)
        for _ in range(MOST_ROUNDS):
            x = self.largest(rows, bounds)
            bend, square = numpy.diff(x) / (2 * self.width), (x[1:] + x[:-1]) / 2
            beyond = 0
            for a, b, c, most in cones:
                vector = a * bend[:, None] + b * square[:, None] + c
                size = numpy.linalg.norm(vector, axis=1)
                way = vector / size[:, None]
                add(*((part * way).sum(axis=1) for part in (a, b, c)), most)
                beyond = max(beyond, (size / most).max() - 1)
            if beyond < 1e-7:
                return (2 * self.width / (numpy.sqrt(x[1:]) + numpy.sqrt(x[:-1]))).sum()
        raise AssertionError("the cones are not closed in on")

    def largest(self, rows, bounds):
        cells = len(self.width)
        count = cells * len(rows)
        number, cell = numpy.arange(count), numpy.tile(numpy.arange(cells), len(rows))
        here, there = (numpy.concatenate([row[side] for row in rows]) for side in (0, 1))
        matrix = coo_array((numpy.concatenate([here, there]),
                            (numpy.concatenate([number, number]), numpy.concatenate([cell, cell + 1]))), shape=(count, cells + 1))
        rest = [(0, 0), *[(0, None)] * (cells - 1), (0, 0)]
        found = linprog(-numpy.ones(cells + 1), A_ub=matrix.tocsr(), b_ub=numpy.concatenate(bounds), bounds=rest)
        if found.status != 0:
            raise AssertionError(found.message)
        return numpy.maximum(found.x, 0)


def load(name, drive, law, **motion):
    """A config with the law, and the same path at constant speed within a second."""
    with open(config(name), encoding="utf-8") as file:
        document = yaml.safe_load(file)
    document["trajectories"] = {"found": {"drive": drive, "law": law, **motion},
                                "even": {"drive": drive, "law": "uniform", "duration": 1}}
    return bm.load(yaml.safe_dump(document), file=config(name))


class Fastest(Case):
    def judge(self, name, drive, nodes=501, **limits):
        """Torques by actuator's number, as [least, most]; other quantities by their greatest magnitude."""
        torques = limits.pop("torques", {})
        actuators = bm.load(config(name)).mechanism.actuators
        stated = {f"torque[{actuators[k]}]": list(range_) for k, range_ in torques.items()}
        spec = load(name, drive, "fastest", limits={**stated, **limits})
        rows = [("torque", k, *range_) for k, range_ in torques.items()]
        rows += [(quantity, None if quantity.endswith("force") else 0, -most, most) for quantity, most in limits.items()]
        duration = spec.simulate("found", samples=11).time[-1]
        self.assertAlmostEqual(Path(spec, nodes).least_time(rows) / duration, 1, delta=TOLERANCE)

    def test_an_arm_with_weight_on_its_tools_line(self):
        self.judge("rr.yaml", "tool", torques={0: (-35, 45), 1: (-10, 8)})

    def test_arms_with_gears_and_discs(self):
        self.judge("scara.yaml", "joints", torques={0: (-20, 20), 1: (-9, 12)})
        self.judge("planar-rrr.yaml", "joints", torques={0: (-60, 60), 1: (-25, 25), 2: (-6, 6)})

    def test_loops_under_limits_of_force_and_moment(self):
        self.judge("3rrr.yaml", "tool", shaking_force=500.0, shaking_moment=40.0)
        self.judge("5r.yaml", "tool", torques={0: (-9, 12), 1: (-12, 9)})

    def test_mechanisms_in_space(self):
        torques = {k: (-4.0, 5.0) for k in range(3)}
        self.judge("delta-gravity.yaml", "tool", torques=torques)
        self.judge("spatial-rrr.yaml", "joints", torques={0: (-8, 8), 1: (-40, 40), 2: (-20, 20)})

    def test_a_quick_return_whose_inertia_changes_by_a_hundred(self):
        self.judge("whitworth.yaml", "joints", nodes=2001, torques={0: (-200, 200)})

    def test_what_a_gentlest_law_comes_to_is_what_its_time_asks_for(self):
        spec = load("5r.yaml", "tool", "gentlest", of="torque", duration=0.45)
        peak = abs(spec.simulate("found", samples=4001).torque).max()
        least = Path(spec).least_time([("torque", 0, -peak, peak), ("torque", 1, -peak, peak)])
        self.assertAlmostEqual(least / 0.45, 1, delta=TOLERANCE)


if __name__ == "__main__":
    unittest.main()
