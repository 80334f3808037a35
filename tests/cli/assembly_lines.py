"""Each line that `check` prints for an assembly mode picks that mode when it is pasted into the spec. (D1)"""

import json
import math
import os
import re
import shutil
import unittest

from _program import CONFIGS, Case, run
from _sampling import WHOLE, draw, traits_of

LEG = """\
name: leg in millimetres and degrees
space: planar
units: {length: mm, mass: g, angle: deg}
ground: {points: {O: [0, 0], C: [50, 0]}}
bodies:
  crank: {mass: 40, com: [12, 0], inertia: 4000, points: {O: [0, 0], A: [25, 0]}}
  coupler: {mass: 120, com: [30, 0], inertia: 160000, points: {A: [0, 0], B: [62.5, 0]}}
  rocker: {mass: 60, com: [30, 0], inertia: 20000, points: {C: [0, 0], B: [62.5, 0]}}
  ram: {mass: 60, com: [0, 0], inertia: 20000, points: {P: [0, 0]}}
joints:
  O: {type: revolute, connects: [ground.O, crank.O]}
  A: {type: revolute, connects: [crank.A, coupler.A]}
  B: {type: revolute, connects: [coupler.B, rocker.B]}
  C: {type: revolute, connects: [ground.C, rocker.C]}
  R: {type: pin-slot, connects: [coupler.B, ram.P], axis: [0, 1]}
  G: {type: prismatic, connects: [ground.O, ram.P]}
actuators: [O]
motion: {duration: 1, from: {joints: {O: 30}}, to: {joints: {O: 60}}}
"""


def pasted(text, line):
    """The spec with another line in place of its own."""
    text = re.sub(r"^assembly:.*\n(?:[ \t]+.*\n)*", "", text, flags=re.MULTILINE)
    return text.rstrip("\n") + "\n" + line + "\n"


class AssemblyLines(Case):
    def check(self, name, text):
        done = run("check", self.write(name, text), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["modes"]

    def assert_every_line_picks_its_mode(self, name, text):
        told = self.check(name, text)
        for mode in told:
            if mode["assembly"] == "assembly: {}":
                continue
            with self.subTest(spec=name, line=mode["assembly"]):
                picked = next(m for m in self.check(name, pasted(text, mode["assembly"])) if m["selected"])
                for joint, value in mode["coordinates"].items():
                    off = picked["coordinates"][joint] - value
                    self.assertLess(min(abs(off), abs(off - 2 * math.pi), abs(off + 2 * math.pi)), 1e-6, joint)
        return len(told)

    def test_of_configs(self):
        several = 0
        shutil.copytree(os.path.join(CONFIGS, "parts"), os.path.join(self.folder, "parts"))
        for name in sorted(os.listdir(CONFIGS)):
            if name.endswith((".csv", ".h5")):
                shutil.copy(os.path.join(CONFIGS, name), self.folder)
        specs = [name for name in sorted(os.listdir(CONFIGS)) if name.endswith(".yaml")]
        for name in draw("assembly lines", specs, 0.2, lambda name: traits_of(os.path.join(CONFIGS, name))):
            with open(os.path.join(CONFIGS, name), encoding="utf-8") as file:
                text = file.read()
            if "\nbodies:" in text:
                several += self.assert_every_line_picks_its_mode(name, text) > 1
        self.assertGreater(several, 5 if WHOLE else 1)

    def test_the_motions_that_it_names_can_be_made_from_the_line_and_the_others_cannot(self):
        for name in ("5r.yaml", "four-bar.yaml", "watt-six-bar.yaml"):
            with open(os.path.join(CONFIGS, name), encoding="utf-8") as file:
                text = file.read()
            spec = self.write(name, text)
            motions = re.findall(r"can follow", run("check", spec).stdout)
            self.assertGreater(len(motions), 0, name)
            for mode in self.check(name, text):
                there = self.write(f"there-{name}", pasted(text, mode["assembly"]))
                for trajectory in json.loads(run("check", there, "--json").stdout)["modes"][0]["motions"]:
                    self.assertIn(trajectory, mode["motions"])
                for trajectory in ("cycloid", "bang-bang"):
                    done = run("simulate", there, "-t", trajectory, "--samples", "11", "-q")
                    if "no trajectory" not in done.stderr:
                        self.assertEqual(done.returncode == 0, trajectory in mode["motions"], f"{name} {trajectory} {done.stderr}")

    def test_of_a_spec_in_millimetres_and_degrees(self):
        self.assertGreater(self.assert_every_line_picks_its_mode("leg.yaml", LEG), 1)


if __name__ == "__main__":
    unittest.main()
