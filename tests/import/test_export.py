"""From a URDF to a spec, to a balanced spec, back into the URDF, and again to a spec."""

import csv
import difflib
import json
import os
import re
import unittest

import numpy as np
import yaml

from _spec import ImportCase, case, run


def moments(spec, body):
    """Mass, first moment and inertia about the origin of a body with its counterweights."""
    entry = spec["bodies"][body]
    parts = [(entry["mass"], np.array(entry.get("com", [0, 0, 0])), entry.get("inertia", [0, 0, 0]))]
    for one in spec.get("counterweights", {}).values():
        if one["body"] == body:
            at = one["at"]
            at = spec["bodies"][body]["points"][at] if isinstance(at, str) else at
            parts.append((one["mass"], np.array(at), one.get("inertia", [0, 0, 0])))
    mass, first, second = 0, np.zeros(3), np.zeros((3, 3))
    for m, c, i in parts:
        i = i["as_given"] if isinstance(i, dict) else i
        xx, yy, zz, xy, xz, yz = [float(number) for number in [*i, 0, 0, 0][:6]]  # YAML 1.1 takes 1e-05 for a text
        mass, first = mass + m, first + m * c
        second = second + np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) + m * (c @ c * np.eye(3) - np.outer(c, c))
    return mass, first, second


MJCF = """<mujoco model="arm">
  <compiler angle="degree"/>
  <worldbody>
    <body name="upper" pos="0 0 0.5">
      <inertial pos="0.1 0 0" euler="0 30 0" mass="2" diaginertia="0.02 0.03 0.015"/> <!-- stays -->
      <joint name="shoulder" axis="0 1 0"/>
      <body name="fore" pos="0.3 0 0">
        <inertial pos="0 0 0.1" mass="1" diaginertia="0.004 0.004 0.001"/>
        <joint name="elbow" axis="0 1 0"/>
        <joint name="twist" axis="1 0 0"/>
        <body name="hand" pos="0 0 0.2">
          <inertial pos="0 0.01 0" mass="0.5" fullinertia="0.001 0.0012 0.0009 1e-5 2e-5 -1e-5"/>
          <joint name="wrist" axis="0 0 1"/>
          <body name="finger" pos="0.05 0 0">
            <joint name="knuckle" axis="0 1 0"/>
            <geom type="box" size="0.01 0.02 0.03"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


class Export(ImportCase):
    def round_trip(self, urdf, balanced, kind="--urdf"):
        done = run("export", balanced, kind, urdf, "-o", self.path("new.urdf"), "--parts", self.path("parts.csv"), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(balanced, encoding="utf-8") as file:
            wanted = yaml.safe_load(file)
        again = self.imported(self.path("new.urdf"))
        for body in wanted["bodies"]:
            for one, other in zip(moments(wanted, body), moments(again, body)):
                self.assertLess(np.abs(np.asarray(one) - other).max(), 1e-12 * max(1, np.abs(one).max()), body)
        with open(urdf, encoding="utf-8") as one, open(self.path("new.urdf"), encoding="utf-8") as other:
            before, after = one.read(), other.read()
        return json.loads(done.stdout), before, after

    def test_a_balanced_arm_goes_back(self):
        """Design with counterweights on two bodies, one of which has links fixed to it."""
        urdf = case("panda.urdf")
        spec = self.imported(urdf)
        spec["friction"] = {}
        spec["counterweights"] = {
            "elbow": {"body": "panda_link3", "at": [{"free": [-0.2, 0.2]}, 0, {"free": [-0.3, 0.3]}], "mass": {"free": [0.1, 20], "start": 5}},
            "hand": {"body": "panda_link7", "at": [0, 0, -0.1], "mass": {"free": [0.1, 3], "start": 1}}}
        path = self.write("free.yaml", yaml.safe_dump(spec, sort_keys=False))
        run("design", path, "--minimize", "added-mass", "-o", self.path("balanced.yaml"), "--json")
        told, before, after = self.round_trip(urdf, self.path("balanced.yaml"))
        self.assertEqual(sorted(told["changed"]), ["panda_link3", "panda_link7"])
        # nothing but numbers of two links changes
        numbers = re.compile(r'[-+0-9.e]+')
        changed = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]
        self.assertTrue(changed)
        self.assertLessEqual(len(changed), 2 * 2 * 3)
        self.assertEqual(numbers.sub("#", before), numbers.sub("#", after))
        with open(self.path("parts.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(row["name"], row["kind"], row["body"]) for row in rows],
                         [("elbow", "counterweight", "panda_link3"), ("hand", "counterweight", "panda_link7")])

    def test_what_does_not_change_stays_to_the_byte(self):
        for name in ("panda.urdf", "lint.urdf"):
            self.imported(case(name))
            told, before, after = self.round_trip(case(name), self.path("imported.yaml"))
            self.assertEqual((told["changed"], before), ([], after))
            for made in ("new.urdf", "parts.csv"):
                os.remove(self.path(made))

    def test_other_specs_are_refused(self):
        self.imported(case("panda.urdf"))
        done = run("export", self.path("imported.yaml"), "--urdf", case("lint.urdf"), "-o", self.path("no.urdf"))
        self.assert_failure(done, 3, "panda_link1", "has no link for it")
        done = run("export", self.path("imported.yaml"), "--urdf", self.write("no.sdf", "<sdf/>"), "-o", self.path("no.urdf"))
        self.assert_failure(done, 3, "only a URDF or an MJCF")
        done = run("export", self.path("imported.yaml"), "-o", self.path("no.robot"))
        self.assert_failure(done, 2, "no.robot", "--format")

    def test_an_mjcf_takes_masses_too(self):
        """A diagonal inertia in turned axes, one that stays diagonal, a full one, one from shapes; a weld takes no part."""
        model = self.write("arm.xml", MJCF)
        spec = self.imported(model)
        spec["counterweights"] = {
            "a": {"body": "upper", "at": [-0.1, 0.02, 0.03], "mass": 1.5},
            "b": {"body": "fore", "at": [0, 0, -0.2], "mass": 0.7},
            "c": {"body": "hand", "at": [0.01, 0, 0], "mass": 0.3, "inertia": [1e-4, 2e-4, 3e-4]},
            "d": {"body": "finger", "at": [0, 0.05, 0], "mass": 0.2}}
        balanced = self.write("balanced.yaml", yaml.safe_dump(spec, sort_keys=False))
        told, before, after = self.round_trip(model, balanced, "--mjcf")
        self.assertEqual(sorted(told["changed"]), ["finger", "fore", "hand", "upper"])
        self.assertIn("<!-- stays -->", after)
        self.assertIn('<inertial pos="', after.split('name="finger"')[1])  # it had none
        self.assertNotIn("euler", after.split('name="upper"')[1].split("<joint")[0])  # no orientation beside fullinertia
        self.assertEqual([line for line in before.splitlines() if "joint" in line], [line for line in after.splitlines() if "joint" in line])

    def test_what_does_not_change_stays_in_an_mjcf(self):
        for model in (self.write("arm.xml", MJCF), case("2f85.xml")):
            self.imported(model)
            told, before, after = self.round_trip(model, self.path("imported.yaml"), "--mjcf")
            self.assertEqual((told["changed"], before), ([], after))
            for made in ("new.urdf", "parts.csv"):
                os.remove(self.path(made))

    def test_shapes_that_overrule_are_refused(self):
        model = self.write("arm.xml", MJCF.replace("<compiler", '<compiler inertiafromgeom="true"'))
        spec = self.imported(model)
        spec["counterweights"] = {"a": {"body": "finger", "at": [0, 0.05, 0], "mass": 0.2}}
        balanced = self.write("balanced.yaml", yaml.safe_dump(spec, sort_keys=False))
        done = run("export", balanced, "--mjcf", model, "-o", self.path("no.xml"))
        self.assert_failure(done, 3, "arm.xml:", "follows from its shapes")


if __name__ == "__main__":
    unittest.main()
