"""A platform on six legs, every joint of them written as revolute joints with nothing between: they become universal and spherical
joints, and what moves it is what its energy gains."""

import json
import math
import unittest

import numpy as np

from _spec import ImportCase, run


def rpy_of(R):
    """Away from the singularity."""
    return " ".join(repr(float(v)) for v in (math.atan2(R[2, 1], R[2, 2]), math.asin(-R[2, 0]), math.atan2(R[1, 0], R[0, 0])))


def frame_along(direction):
    z = direction / np.linalg.norm(direction)
    x = np.cross([0.3, 1, 0.2], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def xyz(v):
    return " ".join(repr(float(c)) for c in v)


def revolute(name, parent, child, p, R, axis):
    return (f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz(p)}" rpy="{rpy_of(R)}"/><axis xyz="{axis}"/></joint>')


def body(name, mass, com, inertia):
    return (f'<link name="{name}"><inertial><origin xyz="{xyz(com)}"/><mass value="{mass}"/><inertia ixx="{inertia[0]}" ixy="0" '
            f'ixz="0" iyy="{inertia[1]}" iyz="0" izz="{inertia[2]}"/></inertial></link>')


def platform(spherical_feet):
    """Legs with universal or spherical feet; the first carries the platform in the tree, the others are closed to it."""
    text, pairs = '<robot name="hexapod"><link name="base"/>', []
    text += body("platform", 5, [0, 0, 0.02], [0.1, 0.1, 0.18])
    at = np.array([0, 0, 0.8])
    for i in range(6):
        low = 0.5 * np.array([math.cos(a := math.radians(60 * (i // 2) * 2 + (20 if i % 2 else -20))), math.sin(a), 0])
        up = at + 0.3 * np.array([math.cos(b := math.radians(60 * (i // 2) * 2 + (45 if i % 2 else -45))), math.sin(b), 0])
        R, length = frame_along(up - low), np.linalg.norm(up - low)
        text += body(f"tube{i}", 1, [0, 0, 0.2], [0.02, 0.02, 0.002]) + body(f"rod{i}", 0.6, [0, 0, -0.15], [0.01, 0.01, 0.0004])
        text += f'<link name="u{i}"/><link name="v{i}"/><link name="w{i}"/>'
        if spherical_feet:
            text += f'<link name="s{i}"/>' + revolute(f"a{i}", "base", f"s{i}", low, R, "0 0 1")
            text += revolute(f"b{i}", f"s{i}", f"u{i}", np.zeros(3), np.eye(3), "1 0 0")
        else:
            text += revolute(f"b{i}", "base", f"u{i}", low, R, "1 0 0")
        text += revolute(f"c{i}", f"u{i}", f"tube{i}", np.zeros(3), np.eye(3), "0 1 0")
        text += (f'<joint name="L{i}" type="prismatic"><parent link="tube{i}"/><child link="rod{i}"/>'
                 f'<origin xyz="0 0 {float(length)!r}"/><axis xyz="0 0 1"/></joint>')
        text += revolute(f"x{i}", f"rod{i}", f"v{i}", np.zeros(3), np.eye(3), "1 0 0")
        text += revolute(f"y{i}", f"v{i}", f"w{i}", np.zeros(3), np.eye(3), "0 1 0")
        last = "platform" if i == 0 else f"mark{i}"
        back = R.T @ (at - up) if i == 0 else np.zeros(3)
        if i == 0:
            text += f'<link name="tip"/>' + revolute("z0", "w0", "tip", np.zeros(3), np.eye(3), "0 0 1")
            text += (f'<joint name="hold" type="fixed"><parent link="tip"/><child link="platform"/><origin xyz="{xyz(back)}" '
                     f'rpy="{rpy_of(R.T)}"/></joint>')
        else:
            text += f'<link name="{last}"/>' + revolute(f"z{i}", f"w{i}", last, np.zeros(3), R.T, "0 0 1")
            text += (f'<link name="seat{i}"/><joint name="seat{i}_joint" type="fixed"><parent link="platform"/><child link="seat{i}"/>'
                     f'<origin xyz="{xyz(up - at)}"/></joint>')
            pairs.append(f"[mark{i}, seat{i}]")
    loops = f"closed_loop: [{', '.join(pairs)}]\ntype: [{', '.join(['6d'] * 5)}]\nname_mot: [{', '.join(f'L{i}' for i in range(6))}]\n"
    return text + "</robot>", loops


class Platform(ImportCase):
    def moves(self, spherical_feet, idle):
        text, loops = platform(spherical_feet)
        spec = self.imported(self.write("hexapod.urdf", text), "--loops", self.write("hexapod.loops.yaml", loops))
        kinds = [joint["type"] for joint in spec["joints"].values()]
        feet = "spherical" if spherical_feet else "universal"
        self.assertEqual(sorted(kinds), sorted([feet] * 6 + ["prismatic"] * 6 + ["spherical"] * 6))
        self.assertEqual(len(spec["bodies"]), 13)
        legs = [f"L{i}" for i in range(6)]
        with self.moved(spec, legs, [0] * 6, [0.1, 0.06, 0.02, 0.12, 0.08, 0.03]) as result:
            time, power, energy = result["time"][:], result["power"][:].sum(1), result["kinetic_energy"][:]
            height = result["com_position"][:, 2]
        check = json.loads(run("check", self.path("moved.yaml"), "--json").stdout)
        self.assertEqual((check["degrees_of_freedom"], len(check["loops"]), len(check["passive_freedoms"])), (6, 5, idle))
        mass = 5 + 6 * 1.6
        self.assertAlmostEqual(check["total_mass"], mass, places=12)
        gained = energy + mass * 9.81 * height
        work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])
        # the trapezoidal rule is exact to the square of a step
        self.assertLess(np.abs(work - (gained - gained[0])).max(), 1e-5 * np.abs(work).max())

    def test_legs_with_universal_feet(self):
        self.moves(False, 0)

    def test_legs_with_spherical_feet_spin_and_are_held(self):
        self.moves(True, 6)


if __name__ == "__main__":
    unittest.main()
