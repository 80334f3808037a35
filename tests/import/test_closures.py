"""One parallelogram, its loop said in every way: the crank's effort is that of the open tree along the loop's motion."""

import json
import math
import unittest

import numpy as np

from _mechanics import Urdf
from _spec import ImportCase, run

# crank and rocker 0.3 m, coupler 0.5 m, in the plane x z; q, -q and q close the loop
LINKS = """<robot name="parallelogram"><link name="base"/>
<link name="crank"><inertial><origin xyz="0.01 0.02 0.15"/><mass value="1.5"/>
 <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.018" iyz="0" izz="0.004"/></inertial></link>
<link name="coupler"><inertial><origin xyz="0.2 -0.03 0.01" rpy="0.1 0.2 0.3"/><mass value="2.5"/>
 <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.052"/></inertial></link>
<link name="rocker"><inertial><origin xyz="0 0 0.1"/><mass value="1.1"/>
 <inertia ixx="0.01" ixy="0" ixz="0.0004" iyy="0.011" iyz="0" izz="0.003"/></inertial></link>
"""
TREE = """<joint name="J1" type="revolute"><parent link="base"/><child link="crank"/><axis xyz="0 1 0"/></joint>
<joint name="J2" type="revolute"><parent link="crank"/><child link="coupler"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
<joint name="J3" type="revolute"><parent link="base"/><child link="rocker"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>
"""
# a ball of 10 mm and 900 t, as drawing programs export them
MARKER = """<link name="{0}"><inertial><mass value="900000"/>
 <inertia ixx="90" ixy="0" ixz="0" iyy="90" iyz="0" izz="90"/></inertial></link>
<joint name="{1}" type="{2}"><parent link="{3}"/><child link="{0}"/><origin xyz="{4}"/><axis xyz="0 1 0"/></joint>"""


def markers(kind):
    return MARKER.format("mark_a", "tie_a", kind, "coupler", "0.5 0 0") + MARKER.format("mark_b", "tie_b", kind, "rocker", "0 0 0.3")


def elements(text):
    return LINKS + TREE + text + "</robot>"


IN_FILE = {
    "loop": '<loop name="C" type="revolute"><predecessor link="coupler"><origin xyz="0.5 0 0"/></predecessor>'
            '<successor link="rocker"><origin xyz="0 0 0.3"/></successor><axis xyz="0 1 0"/></loop>',
    "constraint": '<constraint name="C" type="spherical"><predecessor link="coupler"><origin xyz="0.5 0 0"/></predecessor>'
                  '<successor link="rocker"><origin xyz="0 0 0.3"/></successor></constraint>',
    "loop_joint": '<loop_joint name="C" type="revolute"><link1 link="coupler" xyz="0.5 0 0" rpy="0.4 0 0"/>'
                  '<link2 link="rocker" xyz="0 0 0.3" rpy="0.4 0 0"/><axis xyz="0 0.9210609940028851 -0.3894183423086505"/></loop_joint>',
    "gazebo": '<gazebo><joint name="C" type="revolute"><parent>coupler</parent><child>rocker</child>'
              '<pose>0 0 0.3 0 0 0</pose><axis><xyz>0 1 0</xyz></axis></joint></gazebo>',
    "two parents": '<joint name="C" type="revolute"><parent link="coupler"/><child link="rocker_tip"/><origin xyz="0.5 0 0"/>'
                   '<axis xyz="0 1 0"/></joint><joint name="T" type="fixed"><parent link="rocker"/><child link="rocker_tip"/>'
                   '<origin xyz="0 0 0.3"/></joint><link name="rocker_tip"/>',
}
BESIDE = {
    "two joints, welded": (markers("revolute"), "closed_loop: [[tie_a, tie_b]]\ntype: [6d]\nname_mot: [J1]\n"),
    "two joints, one point": (markers("revolute"), "closed_loop: [[tie_a, tie_b]]\ntype: [3d]\nname_mot: [J1]\n"),
    "two links, one point": (markers("fixed"), "closed_loop: [[mark_a, mark_b]]\ntype: ['3d']\nname_mot: [J1]\nother: 1\n"),
}


class Closures(ImportCase):
    def agrees(self, spec, travel=1.2):
        robot = Urdf(LINKS + TREE + "</robot>")
        with self.moved(spec, ["J1"], [0], [travel]) as result:
            torque, force, moment = result["torque"][:, 0], result["shaking_force"][:], result["shaking_moment"][:]
        for row in range(0, 1001, 125):
            u = row / 1000
            s, ds, dds = u - math.sin(2 * math.pi * u) / (2 * math.pi), 1 - math.cos(2 * math.pi * u), 2 * math.pi * math.sin(2 * math.pi * u)
            signs = {"J1": travel, "J2": -travel, "J3": travel}
            efforts, F, N, _, mass = robot.dynamics(*({n: k * x for n, k in signs.items()} for x in (s, ds, dds)))
            wanted = efforts["J1"] - efforts["J2"] + efforts["J3"]
            self.assert_near(torque[row], wanted, np.abs(torque).max(), "effort")
            self.assert_near(force[row], F, np.abs(force).max(), "force")
            self.assert_near(moment[row], N, np.abs(moment).max(), "moment")
        check = json.loads(run("check", self.path("moved.yaml"), "--json").stdout)
        self.assertEqual((check["degrees_of_freedom"], len(check["loops"])), (1, 1))
        self.assertAlmostEqual(check["total_mass"], mass, places=12)

    def test_loops_inside_the_file(self):
        for name, text in IN_FILE.items():
            with self.subTest(name):
                self.agrees(self.imported(self.write("robot.urdf", elements(text)), "--actuate", "J1"))

    def test_loops_beside_the_file(self):
        for name, (text, loops) in BESIDE.items():
            with self.subTest(name):
                self.agrees(self.imported(self.write("robot.urdf", elements(text)), "--loops", self.write("loops.yaml", loops)))

    def test_connected_in_mjcf(self):
        """The same bodies; inertias as MuJoCo says them, the place in the second body from the model's pose."""
        text = """<mujoco><compiler angle="radian"/><worldbody>
          <body name="crank"><joint name="J1" axis="0 1 0"/>
            <inertial pos="0.01 0.02 0.15" mass="1.5" fullinertia="0.02 0.018 0.004 0.001 0 0"/>
            <body name="coupler" pos="0 0 0.3"><joint name="J2" axis="0 3 0"/>
              <inertial pos="0.2 -0.03 0.01" euler="0.3 0.2 0.1" mass="2.5" diaginertia="0.004 0.05 0.052"/></body></body>
          <body name="rocker" pos="0.4 0 0"><joint name="J3" axis="0 1 0" pos="0.1 0 0"/>
            <inertial pos="0.1 0 0.1" mass="1.1" fullinertia="0.01 0.011 0.003 0 0.0004 0"/></body></worldbody>
          <equality><connect body1="coupler" body2="rocker" anchor="0.5 0 0"/></equality>
          <actuator><motor joint="J1"/></actuator></mujoco>"""
        # intrinsic z y x by 0.3, 0.2, 0.1 is rpy 0.1 0.2 0.3
        self.agrees(self.imported(self.write("robot.xml", text.replace("<compiler ", '<compiler eulerseq="zyx" '))))

    def test_the_mode_is_written_down(self):
        """A four-bar that is not closed at zero: its assembly line closes it."""
        text = elements(IN_FILE["loop"].replace('xyz="0.5 0 0"', 'xyz="0.6 0 0"'))
        spec = self.imported(self.write("robot.urdf", text), "--actuate", "J1")
        values = spec["assembly"]
        # coupler end: J1 = 0: (0.6 cos J2, 0.3 - 0.6 sin J2); rocker tip: (0.5 + 0.3 sin J3, 0.3 cos J3)
        x = 0.6 * math.cos(values["J2"]) - 0.5 - 0.3 * math.sin(values["J3"])
        z = 0.3 - 0.6 * math.sin(values["J2"]) - 0.3 * math.cos(values["J3"])
        self.assertLess(math.hypot(x, z), 1e-8)


if __name__ == "__main__":
    unittest.main()
