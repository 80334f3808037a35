"""What public robot files have: motors on joints that follow others, a ground that is not declared, relations that say nothing; and size."""

import itertools
import time
import unittest

from _spec import ImportCase, run

LINK = '<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
JOINT = ('<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>'
         '{4}</joint>')


def robot(joints, motors=()):
    """@param joints name, type, parent, child, what else stands in them"""
    return ('<robot name="r">' + "".join(LINK.format(child) for _, _, _, child, _ in joints)
            + "".join(JOINT.format(*one) for one in joints)
            + "".join(f'<transmission name="t{m}"><joint name="{m}"/></transmission>' for m in motors) + "</robot>")


CHAIN = [("j1", "continuous", "world", "a", ""), ("j2", "continuous", "a", "b", '<mimic joint="j1" multiplier="-1"/>'),
         ("j3", "continuous", "b", "c", '<mimic joint="j2"/>'), ("j4", "continuous", "c", "d", "")]


class PublicRobots(ImportCase):
    def test_joints_that_are_coupled_have_one_motor_and_the_motion_written_for_it_runs(self):
        for count in (1, 2, 3):
            for motors in itertools.combinations(("j1", "j2", "j3"), count):
                with self.subTest(motors=motors):
                    spec = self.imported(self.write("robot.urdf", robot(CHAIN, (*motors, "j4"))))
                    self.assertEqual(len(spec["actuators"]), 2)
                    self.assertIn("j4", spec["actuators"])
                    if count > 1:
                        self.assertIn("j1", spec["actuators"])
                    done = run("import", self.path("robot.urdf"))
                    moving = self.write("spec.yaml", done.stdout.replace("# motion:", "motion:"))
                    self.assertEqual(run("simulate", moving, "-q").returncode, 0, done.stdout)

    def test_a_world_that_is_not_declared_is_the_ground(self):
        declared = robot(CHAIN).replace('<robot name="r">', '<robot name="r"><link name="world"/>')
        first, second = (self.imported(self.write("robot.urdf", text)) for text in (robot(CHAIN), declared))
        self.assertEqual(first["joints"], second["joints"])
        self.assertEqual(first["bodies"].keys(), second["bodies"].keys())

    def test_a_fixed_joint_mimics_nothing(self):
        joints = [CHAIN[0], ("f", "fixed", "a", "b", '<mimic joint="j1"/>')]
        done = run("import", self.write("robot.urdf", robot(joints)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("is fixed and mimics 'j1': this has no effect", done.stderr)

    def test_names_of_any_length_make_a_spec(self):
        for size in (199, 1023, 5000, 500_000):
            name = "x" * size
            joints = [("j", "continuous", "world", name + "a", ""), ("J", "continuous", name + "a", name + "b", "")]
            spec = self.imported(self.write("robot.urdf", robot(joints)))
            self.assertEqual(len(spec["bodies"]), 2, size)

    def test_time_is_in_proportion_to_size(self):
        """Each took minutes when every place was counted from the file's beginning, or every attribute compared with all others."""
        many = " ".join(f'a{i}=""' for i in range(380_000))
        body = '<body name="b"><joint name="j"/><inertial pos="0 0 0.1" mass="1" diaginertia="0.01 0.01 0.01"/></body>'
        model = f"<mujoco><default><joint {many}/></default><worldbody>{body}</worldbody></mujoco>"
        links = "".join(LINK.format(f"l{i}") for i in range(1500))
        joints = "".join(f'<joint name="j{i}" type="revolute"><parent link="world"/><child link="l{i}"/><axis xyz="0 0 2"/></joint>'
                         for i in range(1500))
        line = f'<robot name="r"><!--{"x" * 3_000_000}-->{links}{joints}</robot>'
        for name, text in (("model.xml", model), ("line.urdf", line)):
            begin = time.monotonic()
            self.assertEqual(run("import", self.write(name, text)).returncode, 0)
            self.assertLess(time.monotonic() - begin, 10)  # a second each on the slowest machine


if __name__ == "__main__":
    unittest.main()
