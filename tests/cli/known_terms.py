"""Loads, springs and friction in the conditions and designs: known terms, and what no mass balances."""

import json
import math
import unittest

from _four_bar import four_bar
from _program import Case, run

# Two links in a vertical plane; what hangs on them differs from test to test.
ARM = """\
name: arm
space: planar
gravity: [0, -9.81]
parameters: {{a1: 0.5, a2: 0.4}}
ground: {{points: {{O: [0, 0]}}}}
bodies:
  link1: {{mass: 2, com: [0.25, 0], inertia: 0.042, points: {{P1: [0, 0], P2: [a1, 0]}}}}
  link2: {{mass: 1.5, com: [0.2, 0], inertia: 0.02, points: {{P2: [0, 0], P3: [a2, 0]}}}}
counterweights:
  cw1: {{on: link1, at: [-0.2, 0], mass: {cw1}}}
  cw2: {{on: link2, at: [-0.2, 0], mass: {cw2}}}
joints:
  R1: {{type: revolute, connects: [ground.O, link1.P1]}}
  R2: {{type: revolute, connects: [link1.P2, link2.P2]}}
actuators: [R1, R2]
tool: link2.P3
trajectories:
  uni:  {{law: uniform, drive: joints, duration: 1, samples: 201,
         from: {{joints: {{R1: 0, R2: 0.5}}}}, to: {{joints: {{R1: 1, R2: 1.5}}}}}}
  slow: {{law: cycloidal, drive: joints, duration: 1e5, samples: 401,
         from: {{joints: {{R1: -2, R2: -1}}}}, to: {{joints: {{R1: 4, R2: 3}}}}}}
{more}
"""
# Without a load the arm is balanced with these: 1.5·0.2 = 0.2 cw2, 2·0.25 + 0.5 (1.5 + cw2) = 0.2 cw1.
CW2, CW1 = 1.5, 10.0

# An arm about an upright axis: weight does not turn it.
UPRIGHT = """\
space: spatial
gravity: [0, 0, -9.81]
ground: {{points: {{O: [0, 0, 0]}}}}
bodies:
  mast: {{mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.01, 0.01], points: {{A: [0, 0, 0], B: [0.3, 0, 0]}}}}
  boom: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01], points: {{B: [0, 0, 0], T: [0.4, 0, 0]}}}}
joints:
  A: {{type: revolute, connects: [ground.O, mast.A], axis: [0, 0, 1]}}
  B: {{type: revolute, connects: [mast.B, boom.B], axis: [0, 1, 0]}}
actuators: [A, B]
loads: {{push: {{on: boom, at: T, force: {force}}}}}
"""

# A horizontal press: no weight, a force against the ram.
PRESS = """\
space: planar
ground: {{points: {{O: [0, 0]}}}}
bodies:
  crank: {{mass: 1, com: [0, 0], inertia: 0.001, points: {{O: [0, 0], K: [{r}, 0]}}}}
  rod: {{mass: 1, com: [0.1, 0], inertia: 0.005, points: {{K: [0, 0], P: [{rod}, 0]}}}}
  ram: {{mass: 3, com: [0, 0], inertia: 0.01, points: {{P: [0, 0]}}}}
joints:
  O: {{type: revolute, connects: [ground.O, crank.O]}}
  K: {{type: revolute, connects: [crank.K, rod.K]}}
  P: {{type: revolute, connects: [rod.P, ram.P]}}
  G: {{type: prismatic, connects: [ground.O, ram.P]}}
actuators: [O]
assembly: {{O: 1, G: 0.28}}
loads: {{push: {{body: ram, force: [-{force}, 0]}}}}
"""


def metric(result, quantity):
    return next(m for m in result["metrics"] if m["quantity"] == quantity)


class KnownTerms(Case):
    def arm(self, more, cw1=CW1, cw2=CW2, name="arm.yaml"):
        return self.write(name, ARM.format(more=more, cw1=cw1, cw2=cw2))

    def conditions(self, spec, *options, code=0):
        done = run("conditions", spec, "--json", *options)
        self.assertEqual((done.returncode, done.stderr), (code, ""), done.stdout[:400])
        return json.loads(done.stdout)

    def peak(self, spec, actuator, trajectory="slow"):
        done = run("simulate", spec, "-t", trajectory, "--json")
        self.assert_quiet_success(done)
        return metric(json.loads(done.stdout), f"torque[{actuator}]")["peak"]

    def test_a_constant_force_is_a_known_term_on_the_right_hand_side(self):
        """(B1) The same arm is balanced without the force and not with it."""
        bare, loaded = self.arm(""), self.arm("loads: {push: {on: link2, at: P3, force: [0, -5]}}", name="loaded.yaml")
        self.assertTrue(all(c["met"] for c in self.conditions(bare, "--goal", "static")["conditions"]))
        found = self.conditions(loaded, "--goal", "static")
        by_pivot = {c["terms"][0]["parameter"]: c for c in found["conditions"]}
        self.assertEqual((found["rank"], found["staying"]), (4, []))
        # By hand: g (m c) = lever · F for a force that acts like a weight; what lies beside the links stays met.
        for pivot, lever in (("link1.mx", 0.5), ("link2.mx", 0.4)):
            condition = by_pivot[pivot]
            self.assertFalse(condition["met"])
            self.assertAlmostEqual(condition["right_hand_side"], -5 * lever / 9.81, places=9)
            self.assertEqual([(k["term"], k["value"]) for k in condition["known"]], [("push.fy", -5)])
        self.assertTrue(by_pivot["link1.my"]["met"] and by_pivot["link2.my"]["met"])
        text = run("conditions", loaded, "--goal", "static").stdout
        self.assertIn("= (a1/g) push.fy", text)
        self.assertIn("push.fy = -5 N", text)
        self.assertIn("2 of 4 not met", text)
        self.assertIn("F_{y,\\text{push}}", run("conditions", loaded, "--goal", "static", "--latex").stdout)

    def test_counterweights_are_designed_for_the_load(self):
        """(B1) Judged by inverse dynamics so slow that only weight and load are left."""
        free = {"cw1": "{free: [0, 40]}", "cw2": "{free: [0, 40]}"}
        for force in ("[0, -5]", "[0, -30]"):
            spec = self.arm(f"loads: {{push: {{on: link2, at: P3, force: {force}}}}}\ndesign: {{goal: static}}", **free)
            out = self.path("balanced.yaml")
            done = run("design", spec, "--json", "-o", out, "--force")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual(json.loads(done.stdout)["status"], "balanced")
            for actuator in ("R1", "R2"):
                self.assertLess(self.peak(out, actuator), 1e-6)
            self.assertTrue(all(c["met"] for c in self.conditions(out, "--goal", "static")["conditions"]))

    def test_a_force_beside_gravity_asks_for_mass_beside_the_links(self):
        """(B1) In the plane a counterweight makes up for any constant force."""
        spec = self.arm("loads: {push: {on: link2, at: P3, force: [7, 0]}}")
        found = self.conditions(spec, "--goal", "static")
        by_pivot = {c["terms"][0]["parameter"]: c for c in found["conditions"]}
        self.assertTrue(by_pivot["link2.mx"]["met"])
        self.assertAlmostEqual(by_pivot["link2.my"]["right_hand_side"], -by_pivot["link2.my"]["scale"] *
                               by_pivot["link2.my"]["residual"], places=9)
        self.assertAlmostEqual(abs(by_pivot["link2.my"]["right_hand_side"]), 7 * 0.4 / 9.81, places=9)

    def test_a_load_that_no_weight_is_like_is_named_with_what_it_leaves(self):
        """(B1) A moment, a force that turns with its body, a force across gravity about an upright axis."""
        spec = self.arm("loads: {twist: {on: link2, at: P3, moment: 2}}")
        found = self.conditions(spec, "--goal", "static", code=1)
        (twist,) = found["staying"]
        self.assertEqual((twist["kind"], twist["name"], twist["terms"]), ("load", "twist", ["twist.m"]))
        at_rest = {e["actuator"]: e["peak"] for e in twist["efforts"] if e["along"] is None}
        self.assertAlmostEqual(at_rest["R1"], 2, places=9)
        self.assertAlmostEqual(at_rest["R2"], 2, places=9)
        for actuator in ("R1", "R2"):  # the arm is balanced else
            self.assertAlmostEqual(self.peak(spec, actuator), 2, places=6)
        self.assertIn("load twist", run("conditions", spec, "--goal", "static").stdout)
        follower = self.arm("loads: {jet: {on: link2, at: P3, frame: body, force: [0, 3]}}")
        (jet,) = self.conditions(follower, "--goal", "static", code=1)["staying"]
        at_rest = {e["actuator"]: e["peak"] for e in jet["efforts"] if e["along"] is None}
        self.assertAlmostEqual(at_rest["R2"], 3 * 0.4, places=9)
        upright = self.write("upright.yaml", UPRIGHT.format(force="[0, 6, 0]"))
        (push,) = self.conditions(upright, "--goal", "static", code=1)["staying"]
        at_rest = {e["actuator"]: e["peak"] for e in push["efforts"]}
        self.assertAlmostEqual(at_rest["A"], 6 * 0.7, places=6)  # stretched, across the force
        self.assertAlmostEqual(at_rest["B"], 6 * 0.4, places=6)  # the boom upright
        down = self.write("down.yaml", UPRIGHT.format(force="[0, 0, -6]"))
        self.assertEqual(self.conditions(down, "--goal", "static")["staying"], [])

    def test_the_largest_effort_at_rest_does_not_depend_on_chance(self):
        """(B1) A press: the force times the largest velocity ratio of its crank, whatever the seed."""
        r, rod, force = 0.06, 0.25, 900
        turns = (k * 1e-4 for k in range(62832))
        ratio = max(abs(r * math.sin(t) * (1 + r * math.cos(t) / math.sqrt(rod**2 - (r * math.sin(t)) ** 2))) for t in turns)
        spec = self.write("press.yaml", PRESS.format(force=force, r=r, rod=rod))
        for seed in ("1", "2", "3"):
            (push,) = self.conditions(spec, "--goal", "static", "--seed", seed, code=1)["staying"]
            (effort,) = (e for e in push["efforts"] if e["along"] is None)
            self.assertAlmostEqual(effort["peak"], force * ratio, places=4)

    def test_terms_too_large_to_compute_with_end_the_command_and_do_not_crash_it(self):
        """(A7) Lengths of 1e200 m in a spring, friction of 1e308: squares have no value any more."""
        bent = self.write("long.yaml", PRESS.format(force=1, r=0.06, rod=0.25) +
                          "springs: {s: {between: [ground.O, rod.P], stiffness: 10, free_length: 1e200}}\n")
        done = run("conditions", bent, "--goal", "static")
        self.assertEqual(done.returncode, 4, done.stdout)
        self.assertIn("numbers overflow", done.stderr)
        stuck = self.write("stuck.yaml", PRESS.format(force=1, r=0.06, rod=0.25).replace("rod: {mass: 1", "rod: {mass: {free: [1, 2]}") +
                           "friction: {O: {viscous: 1e308}}\n")
        self.assertIn(run("design", stuck, "--goal", "gyroscopic").returncode, (1, 4))

    def test_a_load_that_changes_over_time_stays(self):
        """(B1) Balanced is what it is at first; the change is named with its largest effort; in step they may cancel."""
        spec = self.arm("loads: {press: {on: link2, at: P3, table: [[0, 0, 0], [0.4, 0, -8], [1, 0, 0]]}}")
        (press,) = self.conditions(spec, "--goal", "static", code=1)["staying"]
        self.assertEqual(press["terms"], ["press.fy(t)"])
        along = {e["actuator"]: e["peak"] for e in press["efforts"] if e["along"] == "uni"}
        # R1 = t, R2 = 0.5 + t: the lever arms are horizontal distances, the force grows until 0.4 s
        forces = [(t, 20 * t if t <= 0.4 else 8 * (1 - t) / 0.6) for t in (k / 200 for k in range(201))]
        far = max(abs(f * 0.4 * math.cos(0.5 + 2 * t)) for t, f in forces)
        whole = max(abs(f * (0.5 * math.cos(t) + 0.4 * math.cos(0.5 + 2 * t))) for t, f in forces)
        self.assertAlmostEqual(along["R1"], whole, places=6)
        self.assertAlmostEqual(along["R2"], far, places=6)
        steady = self.arm("loads: {press: {on: link2, at: P3, table: [[0, 0, -8], [1, 0, -8]]}}")
        self.assertEqual(self.conditions(steady, "--goal", "static")["staying"], [])
        pair = """loads:
  one: {on: link1, at: P2, table: [[0, 0, 0], [1, 3, 4]]}
  two: {on: link2, at: P2, table: [[0, 0, 0], [1, -3, -4]]}"""
        found = self.conditions(self.arm(pair), "--goal", "static")
        self.assertEqual(found["staying"], [])
        self.assertTrue(all(c["met"] for c in found["conditions"]))

    def test_proofs_of_impossibility_know_the_load(self):
        """(B1) An upward force beyond what mass at these places can take."""
        free = {"cw1": "{free: [0, 40]}", "cw2": "{free: [0, 40]}"}
        spec = self.arm("loads: {lift: {on: link2, at: P3, force: [0, 50]}}\ndesign: {goal: static}", **free)
        done = run("design", spec, "--json")
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        result = json.loads(done.stdout)
        self.assertEqual(result["status"], "impossible")
        self.assertIn("lift.fy", result["reason"])

    def test_momenta_do_not_know_loads(self):
        """(B1) No load changes what a vanishing shaking force or moment asks for."""
        loads = "loads: {push: {on: link2, at: P3, force: [3, -5], moment: 1}}\nfriction: {R1: {coulomb: 1}}"
        for goal in ("force", "moment", "dynamic", "proportional", "affine"):
            bare = self.conditions(self.arm(""), "--goal", goal)
            loaded = self.conditions(self.arm(loads, name="loaded.yaml"), "--goal", goal)
            self.assertEqual([c["text"] for c in bare["conditions"]], [c["text"] for c in loaded["conditions"]], goal)

    def test_a_free_load_is_designed(self):
        """(B1) A force may be a free number: it stands where its value is zero, too."""
        more = "loads: {push: {on: link2, at: P3, force: [0, {free: [-20, 20], start: 0}]}}\ndesign: {goal: static}"
        spec = self.arm(more, cw2=2.5, cw1="{free: [0, 40]}")
        done = run("design", spec, "--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout[:600])
        values = {n["path"]: n["value"] for n in json.loads(done.stdout)["free_numbers"]}
        # 2.5 kg behind joint 2 are 1 kg too much: 0.2 kg m · g = 0.4 m · F
        self.assertAlmostEqual(values["loads.push.force[1]"], -0.2 * 9.81 / 0.4, places=8)

    def test_friction_counts_for_the_velocity_terms(self):
        """(B2) P0 Definition 2.1 asks that all velocity terms vanish; friction never does."""
        friction = "friction: {R1: {viscous: 0.5, coulomb: 0.2}, R2: {viscous: 0.3}}"
        spec = self.arm(friction)
        for goal in ("gyroscopic", "gyroscopic-independent", "fully-gyroscopic"):
            found = self.conditions(spec, "--goal", goal, code=1)
            self.assertEqual([(s["kind"], s["name"]) for s in found["staying"]], [("friction", "R1"), ("friction", "R2")])
            efforts = {(s["name"], e["actuator"]): e["peak"] for s in found["staying"] for e in s["efforts"]
                       if e["along"] == "uni"}
            # 1 rad/s at both joints: 0.5 + 0.2 and 0.3 N m
            self.assertAlmostEqual(efforts["R1", "R1"], 0.7, places=9)
            self.assertAlmostEqual(efforts["R2", "R2"], 0.3, places=9)
        text = run("conditions", spec, "--goal", "gyroscopic").stdout
        self.assertIn("friction in R1 (0.5 N m s/rad viscous, 0.2 N m dry)", text)
        self.assertIn("up to 0.7 N m at R1 along uni", text)
        self.assertNotIn("\nall are met", text)
        self.conditions(spec, "--goal", "static")  # rest knows no friction
        self.conditions(spec, "--goal", "force")

    def test_what_is_left_out_on_purpose_is_said(self):
        """(B2) --without: sections, single names, both; wrong names are refused."""
        spec = self.arm("friction: {R1: {viscous: 0.5}, R2: {viscous: 0.3}}\n"
                        "loads: {push: {on: link2, at: P3, force: [0, -5]}}\n"
                        "payloads: {cargo: {on: link2, at: [a2, 0], mass: 1}}")
        found = self.conditions(spec, "--goal", "gyroscopic", "--without", "friction,push", "--without", "payloads")
        self.assertTrue(all(c["met"] for c in found["conditions"]))
        self.assertIn("left out: friction, push, payloads", found["notes"])
        found = self.conditions(spec, "--goal", "gyroscopic", "--without", "R1", code=1)
        # where the velocity terms want the links' centres of mass no weight is left to hold the load
        self.assertEqual([s["name"] for s in found["staying"]], ["push", "R2"])
        for name, nearest in (("frictoin", "friction"), ("pusch", "push"), ("loads.pusch", "loads.push")):
            self.assert_failure(run("conditions", spec, "--goal", "static", "--without", name), 2, f"'{name}'", nearest)

    def test_a_design_balances_what_masses_can_and_names_the_rest(self):
        """(B2) Gyroscopic with friction: not balanced, and balanced without it; the masses are the same."""
        more = "friction: {R1: {viscous: 0.5}}\ndesign: {goal: gyroscopic}"
        free = {"cw1": "{free: [0, 40]}", "cw2": "{free: [0, 40]}"}
        spec = self.arm(more, **free)
        done = run("design", spec, "--json")
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        rubbing = json.loads(done.stdout)
        self.assertEqual(rubbing["status"], "impossible")
        self.assertIn("R1.viscous", rubbing["reason"])
        self.assertLess(max(abs(c["residual"]) for c in rubbing["conditions"] if "residual" in c), 1e-10)
        self.assertEqual([s["name"] for s in rubbing["staying"]], ["R1"])
        done = run("design", spec, "--json", "--without", "friction")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        smooth = json.loads(done.stdout)
        self.assertEqual(smooth["status"], "balanced")
        for one, other in zip(rubbing["free_numbers"], smooth["free_numbers"]):
            self.assertAlmostEqual(one["value"], other["value"], places=9)
        self.assertIn("no mass or spring balances", run("design", spec).stdout)

    def test_friction_where_no_motor_is_and_springs_without_counterpart(self):
        """(B2) A passive joint's friction reaches the motor through the loop; a spring of free length stays."""
        def bar(more):
            return four_bar(0.5, 0.1, 0.4, 0.3, coupler_com=[0.2, 0], more="assembly: {A: 1}\n" + more)

        spec = self.write("bar.yaml", bar("friction: {C: {viscous: 0.2}}"))
        found = self.conditions(spec, "--goal", "gyroscopic", code=1)
        self.assertEqual([(s["kind"], s["name"]) for s in found["staying"]], [("friction", "C")])
        more = "springs: {s1: {between: [ground.D, crank.B], stiffness: 100, free_length: 0.2}}"
        spec = self.write("sprung.yaml", bar(more))
        found = self.conditions(spec, "--goal", "static", code=1)
        self.assertEqual([(s["kind"], s["name"]) for s in found["staying"]], [("spring", "s1")])


if __name__ == "__main__":
    unittest.main()
