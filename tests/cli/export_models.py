"""`balance export`: a mechanism as MJCF, SDF and URDF."""

import json
import os
import re
import unittest
import xml.etree.ElementTree as ElementTree

import h5py
import numpy
import yaml

from _program import CONFIGS, Case, run

# A spatial arm of revolute, prismatic and universal joints with a counterweight, a spring with a damper and friction.
ARM = """\
name: arm
space: spatial
gravity: [0.3, 0, -9.81]
ground: {points: {O: [0, 0, 0.2], S: [0.4, 0, 0.9]}}
bodies:
  base:  {mass: 3, com: [0.01, 0.02, 0.1], inertia: [0.02, 0.03, 0.025, 0.001, -0.002, 0.003], points: {O: [0, 0, 0], B: [0.05, 0, 0.3]}}
  upper: {mass: 2, com: [0.2, 0.01, 0], inertia: [0.004, 0.03, 0.031, 0, 0, 0], points: {B: [0, 0, 0], C: [0.4, 0, 0], S: [0.1, 0.05, 0]}}
  ram:   {mass: 1, com: [0.1, 0, 0], inertia: [0.001, 0.01, 0.01, 0, 0, 0], points: {C: [0, 0, 0], D: [0.2, 0, 0]}}
  hand:  {mass: 0.5, com: [0, 0.02, 0.05], inertia: [0.001, 0.0012, 0.0008, 0, 0, 0], points: {D: [0, 0, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, base.O], axis: [0, 0.1, 1]}
  J2: {type: revolute, connects: [base.B, upper.B], axis: [0, 1, 0], rpy: [0.3, 0.2, -0.4]}
  J3: {type: prismatic, connects: [upper.C, ram.C], axis: [1, 0.2, 0]}
  J4: {type: universal, connects: [ram.D, hand.D], axis: [0, 0, 1], axis2: [0, 1, 0], rpy: [0, 0.5, 0]}
counterweights:
  cw: {body: upper, at: [-0.15, 0, 0], mass: 1.5, inertia: [0.001, 0.002, 0.002]}
springs:
  s: {between: [ground.S, upper.S], stiffness: 80, free_length: 0.3, damping: 4}
  t: {joint: J2, stiffness: 3, rest: 0.4}
friction:
  J1: {viscous: 0.3}
  J3: {viscous: 5, coulomb: 2}
actuators: [J1, J2, J3, J4.1, J4.2]
trajectories:
  move:
    law: cycloidal
    drive: joints
    duration: 1.1
    samples: 51
    from: {joints: {J1: -0.3, J2: 0.2, J3: 0.02, J4.1: 0.1, J4.2: -0.4}}
    to: {joints: {J1: 0.9, J2: -0.7, J3: 0.15, J4.1: 1.2, J4.2: 0.5}}
"""


class ExportModels(Case):
    def export(self, spec, name, *arguments, code=0):
        path = self.path(name)
        done = run("export", spec, "-o", path, "--force", *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        with open(path, encoding="utf-8") as file:
            return ElementTree.fromstring(file.read()), done

    def torque(self, spec, *arguments):
        out = self.path("out.h5")
        done = run("simulate", spec, "-o", out, "--force", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(out) as file:
            return file["torque"][:]

    def reimport(self, name, text, trajectories, rename=lambda joint: joint):
        """The spec that the import makes of the file, with the original motion."""
        path = self.path("again.yaml")
        done = run("import", self.path(name), "-o", path, "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(path, encoding="utf-8") as file:
            again = yaml.safe_load(file)
        original = yaml.safe_load(text)
        again["actuators"] = [rename(joint) for joint in original["actuators"]]
        again["trajectories"] = {trajectories: {
            key: {"joints": {rename(j): v for j, v in value["joints"].items()}} if key in ("from", "to") else value
            for key, value in original["trajectories"][trajectories].items()}}
        return self.write("moved.yaml", yaml.safe_dump(again, sort_keys=False))

    def test_a_tree_read_back_from_mjcf_has_the_same_efforts(self):
        spec = self.write("arm.yaml", ARM)
        self.export(spec, "arm.xml", "--strict")
        moved = self.reimport("arm.xml", ARM, "move", lambda joint: joint.replace(".", "_"))
        expected, got = self.torque(spec), self.torque(moved)
        self.assertLess(abs(got - expected).max(), 1e-10 * abs(expected).max())

    def test_a_tree_read_back_from_urdf_has_the_same_efforts_without_springs(self):
        text = re.sub(r"springs:.*?friction:", "friction:", ARM.replace("[0.3, 0, -9.81]", "[0, 0, -9.81]"), flags=re.DOTALL)
        spec = self.write("arm.yaml", text)
        self.export(spec, "arm.urdf")
        moved = self.reimport("arm.urdf", text, "move", lambda joint: joint.replace(".", "_"))
        expected, got = self.torque(spec), self.torque(moved)
        self.assertLess(abs(got - expected).max(), 1e-10 * abs(expected).max())

    def test_a_planar_tree_with_discs_comes_back_in_space(self):
        path = os.path.join(CONFIGS, "rr-balanced.yaml")
        with open(path, encoding="utf-8") as file:
            text = file.read()
        root, _ = self.export(path, "rr.xml")
        discs = list(yaml.safe_load(text).get("discs", {}))
        self.assertTrue(set(discs) <= {body.get("name") for body in root.iter("body")})
        self.assertEqual({one.get("joint1") for one in root.iter("joint") if one.get("joint1")}, set(discs))

    def test_loops_are_equalities_and_the_key_closes_them(self):
        """Points that `connect` names by one body coincide with the other's at the start pose."""
        for name, kinds in (("four-bar", {"connect"}), ("3rrr", {"connect"}), ("slider-crank", {"connect", "weld"}), ("delta", {"connect", "weld"}),
                            ("whitworth", {"connect", "weld"})):
            root, done = self.export(os.path.join(CONFIGS, f"{name}.yaml"), f"{name}.xml")
            found = {one.tag for one in root.find("equality")} - {"joint", "tendon"}
            self.assertTrue(found and found <= kinds, (name, found))
            joints = list(root.find("worldbody").iter("joint"))
            key = [float(x) for x in root.find("keyframe/key").get("qpos").split()]
            self.assertEqual(len(key), len(joints))
            for joint, value in zip(joints, key):  # the file stands at the start pose
                self.assertEqual(float(joint.get("ref", 0)), value, (name, joint.get("name")))

    def test_masses_and_inertias_include_counterweights(self):
        root, _ = self.export(self.write("arm.yaml", ARM), "arm.xml")
        inertial = {body.get("name"): body.find("inertial") for body in root.iter("body")}["upper"]
        self.assertAlmostEqual(float(inertial.get("mass")), 3.5, 14)
        com = [float(x) for x in inertial.get("pos").split()]
        self.assertLess(abs(numpy.array(com) - [(2 * 0.2 - 1.5 * 0.15) / 3.5, 0.02 / 3.5, 0]).max(), 1e-15)
        # the trace of the inertia does not depend on the axes: 2 Σ m r² about the common centre, and the parts' own
        shift = 2 * 1.5 / 3.5 * (0.35**2 + 0.01**2)
        moments = [float(x) for x in inertial.get("diaginertia").split()]
        self.assertAlmostEqual(sum(moments), 0.065 + 0.005 + 2 * shift, 14)

    def test_springs_dampers_friction_and_motors_are_written(self):
        root, done = self.export(self.write("arm.yaml", ARM), "arm.xml", "--json")
        self.assertEqual(json.loads(done.stdout)["missing"], [])
        tendon = root.find("tendon/spatial")
        self.assertEqual([float(tendon.get(k)) for k in ("stiffness", "springlength", "damping")], [80, 0.3, 4])
        joints = {one.get("name"): one for one in root.find("worldbody").iter("joint")}
        self.assertEqual(float(joints["J2"].get("stiffness")), 3)
        self.assertAlmostEqual(float(joints["J2"].get("springref")), 0.4, 15)
        self.assertEqual((float(joints["J3"].get("damping")), float(joints["J3"].get("frictionloss"))), (5, 2))
        self.assertEqual([one.get("joint") for one in root.find("actuator")], ["J1", "J2", "J3", "J4.1", "J4.2"])
        self.assertEqual(root.find("option").get("gravity"), "0.3 0 -9.81")

    def test_a_spring_with_initial_tension_pulls_as_in_the_file(self):
        """stiffness (length - springlength) = count (F0 + k (length - cable - l0)): the law of a tendon; read back, too."""
        spring = "{between: [ground.A, hand.B], stiffness: 40, free_length: 0.3, initial_tension: 14, cable: 0.01, count: 2, longest_length: 0.9}"
        text = re.sub(r"  s: \{between: \[([^]]*)\].*", lambda found: "  s: " + spring.replace("ground.A, hand.B", found[1]), ARM)
        root, done = self.export(self.write("arm.yaml", text), "arm.xml", "--json")
        tendon = root.find("tendon/spatial")
        stiffness, length = float(tendon.get("stiffness")), float(tendon.get("springlength"))
        self.assertEqual(stiffness, 80)
        self.assertAlmostEqual(length, 0.31 - 14 / 40, 15)
        self.assertLess(length, 0)  # pulls even at zero length
        missing = " ".join(json.loads(done.stdout)["missing"])
        self.assertIn("slack of spring 's'", missing)
        self.assertIn("travel of spring 's'", missing)
        done = run("import", self.path("arm.xml"), "-o", self.path("back.yaml"))
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path("back.yaml"), encoding="utf-8") as file:
            back = next(iter(yaml.safe_load(file)["springs"].values()))
        self.assertAlmostEqual(back["initial_tension"], 80 * (14 / 40 - 0.31), 12)
        self.assertEqual(back["free_length"], 0)

    def test_what_a_format_lacks_is_said(self):
        text = ARM + "loads: {push: {body: hand, force: [0, 0, 5]}}\n"
        text = text.replace("  t: {joint: J2", "  g: {joint: J2, table: [[-1, 2], [1, -2]]}\n  t: {joint: J2")
        spec = self.write("arm.yaml", text)
        root, done = self.export(spec, "arm.xml", "--strict", code=1)
        for what in ("load 'push'", "spring 'g' with a table"):
            self.assertIn(what, done.stderr)
            with open(self.path("arm.xml"), encoding="utf-8") as file:
                self.assertIn(what, file.read())
        _, done = self.export(spec, "arm.urdf")
        for what in ("spring 's' between points", "the spring in 'J2'", "gravity"):
            self.assertIn(what, done.stderr)
        _, done = self.export(os.path.join(CONFIGS, "planar-rrr.yaml"), "rrr.urdf", "--strict")
        self.assertIn("set (0 -9.81 0) m/s^2 in the simulator", done.stderr)
        _, done = self.export(os.path.join(CONFIGS, "machines", "5r-adapts.yaml"), "adapts.xml")
        self.assertIn("moves of the counterweight", done.stderr)
        _, done = self.export(os.path.join(CONFIGS, "four-bar.yaml"), "four-bar.sdf")
        self.assertIn("closes a loop", done.stderr)
        _, done = self.export(os.path.join(CONFIGS, "rolling-on-a-plane.yaml"), "rolling.xml", "--strict", code=1)
        self.assertIn("rolls", done.stderr)

    def test_sdf_has_the_tree_with_gravity(self):
        root, _ = self.export(self.write("arm.yaml", ARM), "arm.sdf")
        self.assertEqual(root.find("world/gravity").text, "0.3 0 -9.81")
        model = root.find("world/model")
        links, joints = model.findall("link"), model.findall("joint")
        self.assertEqual((len(links), len(joints)), (5, 5))  # one between the two axes of the universal joint
        self.assertAlmostEqual(sum(float(link.find("inertial/mass").text) for link in links), 8, 12)
        names = {link.get("name") for link in links} | {"world"}
        for joint in joints:
            self.assertIn(joint.find("parent").text, names)
            self.assertIn(joint.find("child").text, names)

    def test_every_config_is_written_in_every_format(self):
        def listed(folder):
            return sorted(os.path.join(folder, name) for name in os.listdir(os.path.join(CONFIGS, folder)) if name.endswith(".yaml"))

        names = listed("")[::4] + listed("machines")
        for name in names:
            for extension in ("xml", "sdf", "urdf"):
                root, _ = self.export(os.path.join(CONFIGS, name), f"out.{extension}")
                self.assertIn(root.tag, ("mujoco", "sdf", "robot"), name)

    def test_names_of_any_script_survive(self):
        text = ARM.replace("name: arm", "name: \"a <b> & 'c' -- \\\"d\\\"\"").replace("upper", "überarm")
        root, _ = self.export(self.write("arm.yaml", text), "arm.xml")
        self.assertEqual(root.get("model"), "a <b> & 'c' -- \"d\"")
        self.assertIn("überarm", {body.get("name") for body in root.iter("body")})

    def test_bodies_without_mass_get_a_negligible_one_and_a_note(self):
        text = ARM.replace("hand:  {mass: 0.5, com: [0, 0.02, 0.05], inertia: [0.001, 0.0012, 0.0008, 0, 0, 0],", "hand:  {mass: 0,")
        text = text.replace("actuators:", "payloads: {p: {body: hand, at: [0, 0, 0.05], mass: 0.4}}\nactuators:")
        root, done = self.export(self.write("arm.yaml", text), "arm.xml")
        self.assertIn("no mass or inertia", done.stderr)
        hand = {body.get("name"): body.find("inertial") for body in root.iter("body")}["hand"]
        self.assertEqual(float(hand.get("mass")), 0.4)
        self.assertEqual(hand.get("diaginertia"), "2e-15 2e-15 2e-15")

    def test_no_output_overwrites_an_input(self):
        spec = self.write("arm.yaml", ARM)
        done = run("export", spec, "-o", spec, "--format", "mjcf", "--force")
        self.assertEqual(done.returncode, 2, done.stderr)
        with open(spec, encoding="utf-8") as file:
            self.assertEqual(file.read(), ARM)
        self.export(spec, "arm.xml")
        done = run("export", spec, "-o", self.path("arm.xml"))
        self.assertEqual(done.returncode, 5, done.stderr)

    def test_wrong_usage_is_said(self):
        spec = self.write("arm.yaml", ARM)
        for arguments, message in ((["-o", self.path("arm.txt")], "--format"), (["-o", self.path("a.xml"), "--format", "stl"], "mjcf"),
                                   (["-o", self.path("a.xml"), "--loops", spec], "--loops goes only with"),
                                   (["-o", self.path("a.xml"), "-t", "nowhere"], "no trajectory 'nowhere'")):
            done = run("export", spec, *arguments)
            self.assertIn(done.returncode, (2, 3), done.stderr)
            self.assertIn(message, done.stderr)


if __name__ == "__main__":
    unittest.main()
