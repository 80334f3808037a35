"""What is said where a mechanism cannot be put together, put into a pose, or moved: figures that geometry gives."""

import math
import re
import unittest

from _four_bar import four_bar
from _program import Case, config, run, unwrapped


def moved(lengths, start, end):
    motion = f"motion: {{duration: 1, samples: 11, from: {{joints: {{A: {start}}}}}, to: {{joints: {{A: {end}}}}}}}\n"
    return four_bar(*lengths) + motion + "trajectories: {turn: {law: cycloidal, drive: joints}}\n"


class GeometryMessages(Case):
    def test_an_arm_that_is_too_short_names_the_nearest_place_and_that_it_is_stretched(self):
        spec = self.write("arm.yaml", SHORT_ARM)
        done = run("simulate", spec)
        self.assert_failure(done, 4, "the start pose cannot be reached: it asks for the tool at (3, 4) m (nearest is (1.2, 1.6) m)",
                            "there one and two are in line at B")

    def test_an_end_out_of_reach_is_said_with_the_nearest_place_and_how_far_it_is(self):
        # the arm with its end at (3, 4) instead of its start
        spec = self.write("arm.yaml", SHORT_ARM.replace("from: {tool: [3, 4]}", "from: {tool: [0.5, 0.6]}").replace(
            "to: {tool: [1, 1]}", "to: {tool: [3, 4]}"))
        self.assert_failure(run("simulate", spec), 4, "the end pose cannot be reached: it asks for the tool at (3, 4) m",
                            "(nearest is (1.2, 1.6) m), 3 m out of reach", "there one and two are in line at B")

    def test_legs_that_miss_a_pose_by_themselves_are_named(self):
        """5R: each leg reaches its two links' length from its bearing, and the nearest place is on the line to the tool."""
        links, base = {"crank1": 0.3 + 0.45, "crank2 - coupler2": 0.32 + 0.42}, {"crank1": (0, 0), "crank2 - coupler2": (0.4, 0)}
        for place in ((0.9, 0.3), (-0.3, 0.5)):
            missing = []
            text = config("5r.yaml", (r"from: \{tool: .*?\]\}", f"from: {{tool: [{place[0]}, {place[1]}]}}"))
            done = run("check", self.write("from.yaml", text))
            self.assertEqual(done.returncode, 4, done.stdout)
            message = unwrapped(done.stderr)
            for leg, (x, y) in base.items():
                distance = math.hypot(place[0] - x, place[1] - y)
                found = re.search(rf"leg {leg} by itself: the tool at \S+ \S+ m \(nearest is \((\S+), (\S+)\) m\), (\S+) m out of reach; there", message)
                self.assertEqual(found is not None, distance > links[leg], message)
                if not found:
                    continue
                missing.append(leg)
                ratio = links[leg] / distance
                for figure, value in zip(found.groups(), (x + ratio * (place[0] - x), y + ratio * (place[1] - y), distance - links[leg])):
                    self.assertAlmostEqual(float(figure), value, places=5)
            self.assertTrue(missing)
        # the same place as an end, for check and simulate
        spec = self.write("to.yaml", config("5r.yaml", (r"to: \{tool: .*?\]\}", "to: {tool: [-0.3, 0.5]}")))
        words = "the end pose cannot be reached: it asks for the tool at (-0.3, 0.5) m"
        self.assertIn(words, unwrapped(run("check", spec).stdout))
        self.assert_failure(run("simulate", spec), 4, words, "leg crank2 - coupler2 by itself")

    def test_legs_of_mechanisms_in_space_are_named(self):
        """A Delta's tool far out on one side: the arms on the other side are too short, whatever the third does."""
        text = config("delta.yaml", (r"from: \{tool: .*?\]\}", "from: {tool: [0.9, 0.05, -0.48]}"))
        message = unwrapped(run("check", self.write("delta.yaml", text)).stderr)
        self.assertIn("m out of reach", message)
        self.assertRegex(message, r"; leg arm\d - rod\dL - rod\dR by itself: the tool at \(0.9, 0.05, -0.48\) m")

    def test_a_joint_beyond_its_dead_point_names_the_nearest_value_and_the_links_in_line(self):
        found = self.stopped((1, 0.5, 0.4, 0.4), 2, 2.5)
        nearest = re.search(r"it asks for A 2 rad \(nearest is (\S+) rad\); there (.*)", found)
        self.assertTrue(nearest, found)
        # coupler and rocker stretched: the side opposite to A is 0.8 long
        self.assertAlmostEqual(float(nearest[1]), math.acos((1 + 0.25 - 0.64) / (2 * 0.5)), places=4)
        self.assertIn("in line", nearest[2])

    def test_a_crank_that_cannot_turn_names_the_links_in_line(self):
        found = self.stopped((1, 0.5, 0.4, 0.4), 0.3, 2)
        self.assertRegex(found, r"drive singularity: .*, where \w+ and \w+ are in line at \w")

    def test_lengths_and_angles_are_said_in_the_units_of_the_spec(self):
        """The same answers as in SI, in millimetres and degrees."""
        text = four_bar(1000, 500, 400, 400, more="units: {length: mm, angle: deg}")
        spec = self.write("units.yaml", text)
        found = run("simulate", spec, "--at", "A=115").stderr
        nearest = re.search(r"it asks for A 115 deg \(nearest is (\S+) deg\)", found)
        self.assertTrue(nearest, found)
        self.assertAlmostEqual(float(nearest[1]), math.degrees(math.acos((1 + 0.25 - 0.64) / (2 * 0.5))), places=2)
        motion = "motion: {duration: 1, samples: 11, from: {joints: {A: 20}}, to: {joints: {A: 115}}}\n"
        done = run("simulate", self.write("moved.yaml", text + motion + "trajectories: {turn: {law: cycloidal, drive: joints}}\n"))
        self.assertRegex(done.stderr, r"configuration: A 5\d\.\d+ deg, .* deg")
        open_loops = run("check", self.write("open.yaml", four_bar(1000, 100, 200, 300, more="units: {length: mm}")))
        self.assertRegex(open_loops.stderr, r"stays open by 400 mm at best")

    def test_what_cannot_be_closed_for_a_visible_gap_is_not_called_singular(self):
        done = run("check", self.write("gap.yaml", four_bar(1 + 1e-7, 0.2, 0.3, 0.5)))
        self.assert_failure(done, 4, "the loops cannot be closed", "stays open by 1e-07 m")
        for command in ("equations", "conditions"):
            done = run(command, self.path("gap.yaml"), *(["-g", "static"] if command == "conditions" else []))
            self.assert_failure(done, 4, "stays open by 1e-07 m")

    def stopped(self, lengths, start, end):
        done = run("simulate", self.write("stopped.yaml", moved(lengths, start, end)))
        self.assertEqual(done.returncode, 4, done.stdout + done.stderr)
        return done.stderr


SHORT_ARM = """\
name: arm
space: planar
ground: {points: {O: [0, 0]}}
bodies:
  one: {mass: 1, com: [0.5, 0], inertia: 0.1, points: {O: [0, 0], E: [1, 0]}}
  two: {mass: 1, com: [0.5, 0], inertia: 0.1, points: {O: [0, 0], E: [1, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, one.O]}
  B: {type: revolute, connects: [one.E, two.O]}
actuators: [A, B]
tool: two.E
assembly: {A: 0.5, B: 0.5}
motion: {duration: 1, samples: 11, from: {tool: [3, 4]}, to: {tool: [1, 1]}}
trajectories: {go: {law: cycloidal, drive: tool}}
"""


if __name__ == "__main__":
    unittest.main()
