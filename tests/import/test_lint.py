"""What an import tells: faults of masses by name, mistakes with their place, exit codes; and that it repairs nothing."""

import json
import math
import os
import unittest

import numpy as np
import yaml

from _spec import ImportCase, case, run

ARM = """<robot name="arm">
<link name="base"/>
<link name="{link}"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
 <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="{joint}" type="continuous"><parent link="base"/><child link="{link}"/><axis xyz="0 1 0"/></joint>
{more}</robot>
"""


def arm(link="arm", joint="J", more=""):
    return ARM.format(link=link, joint=joint, more=more)


class Lint(ImportCase):
    def findings(self, *arguments):
        done = run("import", *arguments, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_every_fault_by_name(self):
        """(lint.urdf) one fault a link, with its size where it has one."""
        told = {}
        answer = self.findings(case("lint.urdf"))
        for one in answer["findings"]:
            told.setdefault(one["subject"], []).append(one)
        expected = {
            "link 'triangle'": ("warning", "triangle", "0.003", "0.001 + 0.001"), "link 'indefinite'": ("warning", "indefinite", "-0.001"),
            "link 'point_mass'": ("note", "point", "0.5 kg"), "link 'massless'": ("note", "massless", "'J5'"),
            "link 'sphere'": ("warning", "density", "5.39 m", "0.0158 m"), "link 'placeholder'": ("note", "placeholder", "1.83 m"),
            "link 'millimetres'": ("warning", "millimetres", "45 m", "37.4 m", "millimetres"),
            "link 'about_joint'": ("warning", "about-joint", "0.1201", "0.09", "0.0301"), "joint 'J1'": ("warning", "axis", "normalised"),
            "joint 'J2'": ("note", "no-axis", "(1, 0, 0)"), "joint 'J3'": ("note", "no-limit"), "joint 'J10'": ("note", "no-limit"),
            "joint 'J9'": ("note", "planar", "three coordinates"), "joint 'J5'": ("note", "mimic", "ratio -2", "offset 0.1"),
            "joint 'J6'": ("note", "friction", "0.2", "0.1")}
        for subject, (level, code, *parts) in expected.items():
            with self.subTest(subject):
                found = [one for one in told[subject] if one["code"] == code]
                self.assertEqual([one["level"] for one in found], [level])
                for part in parts:
                    self.assertIn(part, found[0]["message"])
        self.assertTrue(any(one["code"] == "merged" and "marker" in one["message"] for one in answer["findings"]))
        self.assertFalse(any("'good'" in subject for subject in told))
        with open(case("lint.urdf"), encoding="utf-8") as file:
            lines = file.read().splitlines()
        for one in answer["findings"]:
            if one["line"]:
                self.assertIn(one["subject"].split("'")[1], lines[one["line"] - 1])

    def test_nothing_is_repaired_and_every_command_warns(self):
        spec = self.imported(case("lint.urdf"))
        self.assertEqual(spec["bodies"]["triangle"]["inertia"], {"as_given": [0.001, 0.001, 0.003]})
        self.assertEqual(spec["bodies"]["indefinite"]["inertia"], {"as_given": [0.001, 0.001, 0.001, 0.002, 0, 0]})
        self.assertEqual(spec["bodies"]["massless"]["mass"], 0)
        self.assertEqual(spec["couplings"], [{"joint": "J5", "follows": "J1", "ratio": -2, "offset": 0.1}])
        done = run("check", self.path("imported.yaml"))
        self.assertEqual(done.returncode, 0, done.stderr)
        for body in ("triangle", "indefinite"):
            self.assertIn(f"bodies.{body}.inertia: kept as given: no body can have this inertia", done.stderr)

    def test_a_clean_file_has_no_warnings(self):
        done = run("import", case("panda.urdf"), "--strict", "-o", self.path("panda.yaml"))
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertNotIn("warning", done.stdout + done.stderr)
        self.assertIn("16.822132 kg", done.stdout)

    def test_strict_minds_warnings(self):
        done = run("import", case("lint.urdf"), "--strict", "-o", self.path("lint.yaml"))
        self.assertEqual(done.returncode, 1)
        self.assertTrue(os.path.exists(self.path("lint.yaml")))

    def test_what_stands_on_standard_output_is_a_spec(self):
        done = run("import", case("panda.urdf"))
        self.assertEqual(done.returncode, 0)
        self.assertIn("# from panda.urdf:", done.stdout)
        self.assertEqual(yaml.safe_load(done.stdout)["space"], "spatial")
        self.assertIn("collision (17)", done.stderr)

    def test_names_are_changed_and_told(self):
        answer = self.findings(self.write("r.urdf", arm("left arm", "2nd/joint")))
        self.assertEqual(answer["renamed"], {"body 'left arm'": "left_arm", "joint '2nd/joint'": "n2nd_joint"})
        self.assertEqual(answer["actuators"], ["n2nd_joint"])

    def test_two_names_that_become_one(self):
        more = arm("a b", "x").split("<link name=\"base\"/>")[1].replace("</robot>", "")
        spec = self.imported(self.write("r.urdf", arm("a/b", "y", more)))
        self.assertEqual(sorted(spec["bodies"]), ["a_b", "a_b_2"])


class Mistakes(ImportCase):
    def refused(self, text, *parts, name="r.urdf", arguments=(), code=3):
        done = run("import", self.write(name, text), "-o", self.path("never.yaml"), *arguments)
        self.assert_failure(done, code, *parts)
        self.assertFalse(os.path.exists(self.path("never.yaml")))

    def test_a_urdf_with_mistakes(self):
        link = arm()
        self.refused(link.replace('child link="arm"', 'child link="arn"'), "r.urdf:5:", "there is no link 'arn'", "nearest is 'arm'")
        self.refused(link.replace('value="2"', 'value="2,5"'), "r.urdf:3:", "expected 1 number, found '2,5'")
        self.refused(link.replace('value="2"', 'value="-2"'), "r.urdf:3:", "expected a mass ≥ 0")
        self.refused(link.replace('value="2"', 'value="nan"'), "r.urdf:3:", "'nan'")
        self.refused(link.replace("continuous", "hinge"), "r.urdf:5:", "found 'hinge'")
        self.refused(link.replace('"0 1 0"', '"0 0 0"'), "r.urdf:5:", "a zero vector")
        self.refused(link.replace("</robot>", '<link name="lost"/></robot>'), "expected one root link, found 2: 'base' and 'lost'")
        self.refused(link.replace("</robot>", ""), "r.urdf:", "expected XML")
        self.refused(link.replace("</robot>", "<xacro:macro/></robot>"), "expand it with xacro first")
        self.refused(link.replace('type="continuous"', 'type="fixed"'), "something that moves")
        self.refused(link.replace('type="continuous"', 'type="floating"'), "--base fixed")

    def test_all_mistakes_are_told(self):
        text = arm().replace('value="2"', 'value="two"').replace('"0 1 0"', '"0 1"').replace('ixx="0.01"', 'ixx=""')
        done = run("import", self.write("r.urdf", text), "--json")
        self.assertEqual(done.returncode, 3)
        self.assertGreaterEqual(len(json.loads(done.stdout)["error"]["mistakes"]), 2)

    def test_other_files(self):
        self.refused("<sdf/>", "expected <robot> (URDF) or <mujoco> (MJCF), found <sdf>")
        self.refused("space: planar\njoints: {}\n", "a spec, which needs no import", name="s.yaml")
        self.refused("a: 1\n", "URDF or MJCF", name="s.yaml")
        self.refused("", "r.urdf:1:1:", "empty")
        self.refused("\x00\x01", "r.urdf:1:1:")
        self.assert_failure(run("import", self.path("nowhere.urdf")), 5, "nowhere.urdf")

    def test_options(self):
        self.refused(arm(), "--actuate", "expected a joint that moves (J), found 'K'", arguments=("--actuate", "K"), code=2)
        self.refused(arm(), "--base", arguments=("--base", "loose"), code=2)
        path = self.write("r.urdf", arm())
        self.assert_failure(run("import", path, "-o", path, "--force"), 2, "would replace its input")
        self.write("there.yaml", "")
        self.assert_failure(run("import", path, "-o", self.path("there.yaml")), 5, "there.yaml")

    def test_loops_with_mistakes(self):
        path = self.write("r.urdf", arm())
        for text, part in (("closed_loop: [[J, K]]", "found 'K'"), ("closed_loop: [[J]]", "a pair [A, B]"), ("a: 1", "closed_loop"),
                           ("closed_loop: [[J, base]]\ntype: [5d]", "6d"), ("closed_loop: [[J, base]]\ntype: [6d, 6d]", "one for each")):
            self.assert_failure(run("import", path, "--loops", self.write("l.yaml", text)), 3, "l.yaml:", part)

    def test_hostile_files(self):
        entities = '<!DOCTYPE r [<!ENTITY a "x"><!ENTITY f SYSTEM "file:///etc/passwd">]>'
        done = run("import", self.write("e.urdf", entities + arm(joint="&f;&a;")))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("root:", done.stdout + done.stderr)
        self.refused('<robot name="r">' + "<a>" * 300 + "</a>" * 300 + "</robot>", "levels of nesting")
        self.refused('<robot name="r">' + "".join(f'<link name="l{i}"/>' for i in range(3000)) + "</robot>", "expected at most 2000 links")
        self.refused('<mujoco><include file="r.xml"/></mujoco>', "levels of files", name="r.xml")
        self.refused('<mujoco><include file="/etc/passwd"/></mujoco>', "absolute path", name="r.xml")

    def test_mjcf_that_cannot_be_read(self):
        body = '<mujoco><worldbody><body name="b">{}</body></worldbody></mujoco>'
        self.refused(body.format("<joint/><geom type='mesh' mesh='m'/>"), "mj_saveLastXML", name="r.xml")
        self.refused(body.format("<freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"), "--base fixed", name="r.xml")
        self.refused(body.format("<joint class='none'/>"), "there is no default class 'none'", name="r.xml")
        self.refused(body.format("<replicate/>"), "mj_saveLastXML", name="r.xml")


class Mjcf(ImportCase):
    def test_a_chain_of_joints_turned_and_shifted(self):
        """A hinge off the body's origin, a slide, a turned frame, degrees and ref: poses against rotations by hand."""
        text = """<mujoco><default><default class="c"><joint axis="0 0 1"/></default></default><worldbody>
          <frame pos="0 0 1"><body name="b" childclass="c" pos="1 0 0" euler="0 0 90">
            <joint name="h" pos="0.5 0 0" ref="30" range="30 90"/><joint name="s" type="slide" axis="2 0 0"/>
            <inertial pos="0.25 0 0" mass="2" diaginertia="0.01 0.02 0.02"/></body></frame></worldbody></mujoco>"""
        spec = self.imported(self.write("r.xml", text))
        self.assertEqual(spec["actuators"], ["h", "s"])
        with self.moved(spec, ["h", "s"], [0.3, 0.1], [0.1, 0.2]) as result:
            com = result["com_position"][0]
        # the body's x is the world's y; the hinge at (1, 0.5, 1); the slide along the turned body x
        along = 0.25 - 0.5 + 0.1
        self.assert_near(com, [1 + along * math.cos(math.pi / 2 + 0.3), 0.5 + along * math.sin(math.pi / 2 + 0.3), 1], 1, "place")

    def test_an_armature_is_offered_as_a_disc(self):
        """Taken in, it adds its inertia times the acceleration to the effort of its own joint, and nothing else at rest."""
        text = """<mujoco><worldbody><body name="a"><joint name="p" axis="0 1 0" armature="0.3"/>
          <inertial pos="0.3 0 0" mass="2" diaginertia="0.01 0.02 0.02"/><body name="b" pos="0.5 0 0"><joint name="q" axis="0 1 0"/>
          <inertial pos="0.2 0 0" mass="1" diaginertia="0.01 0.02 0.02"/></body></body></worldbody></mujoco>"""
        done = run("import", self.write("r.xml", text))
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        begin = lines.index("# discs:")
        with_disc = yaml.safe_load("\n".join(lines[:begin] + [line[2:] for line in lines[begin:begin + 2]]))
        torques = []
        for spec in (yaml.safe_load(done.stdout), with_disc):
            with self.moved(spec, ["p", "q"], [0, 0], [1, -0.5]) as result:
                torques.append(result["torque"][:])
                acceleration = 2 * math.pi * np.sin(2 * math.pi * result["time"][:])
        self.assert_near((torques[1] - torques[0])[:, 0], 0.3 * acceleration, 1, "the joint's own")
        self.assert_near((torques[1] - torques[0])[:, 1], 0 * acceleration, 1, "the other")

    def test_an_included_file(self):
        self.write("arm.xml", '<mujocoinclude><body name="b"><joint name="h" axis="0 1 0"/><inertial pos="0.3 0 0" mass="2" '
                              'diaginertia="0.01 0.02 0.02"/></body></mujocoinclude>')
        spec = self.imported(self.write("r.xml", '<mujoco><worldbody><include file="arm.xml"/></worldbody></mujoco>'))
        self.assertEqual(spec["bodies"]["b"]["com"], [0.3, 0, 0])


if __name__ == "__main__":
    unittest.main()
