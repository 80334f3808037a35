"""URDF against a second reading of its numbers: a tree's efforts by virtual power, in numpy."""

import json
import math
import random
import unittest

import numpy as np

from _mechanics import Urdf
from _spec import ImportCase, run


def element_vector(rng, size=0.3):
    return " ".join(f"{rng.uniform(-size, size):.6g}" for _ in range(3))


def inertial(rng):
    """A body that can exist: second moments of some points."""
    points = np.array([[rng.gauss(0, 0.1) for _ in range(3)] for _ in range(6)])
    sigma = (points - points.mean(0)).T @ (points - points.mean(0)) / 6
    mass = rng.uniform(0.5, 3)
    I = mass * (np.trace(sigma) * np.eye(3) - sigma)
    return (f'<inertial><origin xyz="{element_vector(rng)}" rpy="{element_vector(rng, 3)}"/><mass value="{mass!r}"/>'
            f'<inertia ixx="{I[0, 0]!r}" ixy="{I[0, 1]!r}" ixz="{I[0, 2]!r}" iyy="{I[1, 1]!r}" iyz="{I[1, 2]!r}" '
            f'izz="{I[2, 2]!r}"/></inertial>')


def random_tree(seed):
    """Seven links: turning, sliding, fixed and mimicking joints, a point and a link without mass between."""
    rng = random.Random(seed)
    kinds = ["revolute", "fixed", "prismatic", "continuous", "revolute", "fixed", "revolute"]
    text = '<robot name="random"><link name="base"/>'
    for i, kind in enumerate(kinds):
        parent = "base" if i == 0 else f"l{rng.randrange(max(0, i - 2), i)}"
        body = inertial(rng) if i != 3 else ""
        text += f'<link name="l{i}">{body}</link>'
        mimic = '<mimic joint="j0" multiplier="-0.7" offset="0.2"/>' if i == 4 else ""
        axis = "" if i == 6 else f'<axis xyz="{element_vector(rng, 2)}"/>'
        text += (f'<joint name="j{i}" type="{kind}"><parent link="{parent}"/><child link="l{i}"/>'
                 f'<origin xyz="{element_vector(rng)}" rpy="{element_vector(rng, 3)}"/>{axis}{mimic}</joint>')
    return text + '<link name="tip">' + inertial(rng) + '</link><joint name="jt" type="revolute"><parent link="l3"/><child ' \
        'link="tip"/><origin xyz="0.1 0.2 0.3"/><axis xyz="0 1 0"/></joint></robot>'


class Trees(ImportCase):
    def agrees(self, text):
        robot = Urdf(text)
        moving = [j["name"] for j in robot.joints if j["type"] != "fixed" and not j["mimic"]]
        rng = random.Random(5)
        start = [rng.uniform(-0.5, 0.5) for _ in moving]
        travel = [rng.uniform(-1, 1) for _ in moving]
        spec = self.imported(self.write("robot.urdf", text))
        self.assertEqual(sorted(spec["actuators"]), sorted(moving))
        with self.moved(spec, moving, start, travel) as result:
            names = [one.decode() for one in result["actuator"][:]]
            torque, force = result["torque"][:], result["shaking_force"][:]
            moment, com = result["shaking_moment"][:], result["com_position"][:]
        scales = [np.abs(one).max() for one in (torque, force, moment)]
        for row in range(0, 1001, 125):
            u = row / 1000
            s, ds, dds = u - math.sin(2 * math.pi * u) / (2 * math.pi), 1 - math.cos(2 * math.pi * u), 2 * math.pi * math.sin(2 * math.pi * u)
            q, dq, ddq = ({n: a + b * s for n, a, b in zip(moving, start, travel)},
                          {n: b * ds for n, b in zip(moving, travel)}, {n: b * dds for n, b in zip(moving, travel)})
            efforts, F, N, place, mass = robot.dynamics(q, dq, ddq)
            self.assert_near([torque[row][names.index(n)] for n in moving], [efforts[n] for n in moving], scales[0], "efforts")
            self.assert_near(force[row], F, scales[1], "force")
            self.assert_near(moment[row], N, scales[2], "moment")
            self.assert_near(com[row], place, 1, "centre of mass")
        check = json.loads(run("check", self.path("moved.yaml"), "--json").stdout)
        self.assertAlmostEqual(check["total_mass"] / mass, 1, places=12)

    def test_random_trees(self):
        for seed in range(4):
            with self.subTest(seed=seed):
                self.agrees(random_tree(seed))

    def test_a_body_fixed_to_the_base_stands_still(self):
        self.agrees("""<robot name="r"><link name="base"/><link name="stand"><inertial><mass value="50"/>
            <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
            <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
            <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
            <joint name="foot" type="fixed"><parent link="base"/><child link="stand"/><origin xyz="0 0 1" rpy="0.3 0 0"/></joint>
            <joint name="J" type="continuous"><parent link="stand"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>""")


if __name__ == "__main__":
    unittest.main()
