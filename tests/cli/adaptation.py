"""Counterweights that move along their bodies during a motion (`adapt`): against runs with fixed ones, and by hand."""

import json
import math
import os
import unittest

import h5py
import numpy as np

from _program import CONFIGS, Case, config, run, unwrapped

G = 9.81
# An arm that stays where it is while its counterweight of 4 kg moves along it.
STILL = """
space: planar
gravity: [0, -9.81]
parameters: {angle: 0.7}
ground: {points: {O: [0, 0]}}
bodies:
  arm: {mass: 2, com: [0.25, 0], inertia: 0.04, points: {O: [0, 0], P: [0.5, 0], N: [-0.3, 0]}}
counterweights:
  cw: {body: arm, at: [-0.1, 0.02], mass: 4, inertia: 0.003}
joints:
  R: {type: revolute, connects: [ground.O, arm.O]}
actuators: [R]
tool: arm.P
controllers: {follow: {type: computed-torque, rate: 5000}}
trajectories:
  stay:
    law: cycloidal
    drive: joints
    duration: 2
    samples: 2001
    from: {joints: {R: angle}}
    to: {joints: {R: angle}}
    adapt: {cw: ADAPT}
"""
OUT = "{to: [-0.3, 0.02], start: 0.5, duration: 0.8}"
# An arm that takes a payload up, to which both counterweights move out, with a ballast that moves with the second link.
CARRIER = """
space: planar
gravity: [0, -9.81]
parameters: {load: 0.8}
ground: {points: {O: [0, 0]}}
bodies:
  link1: {mass: 2, com: [0.2, 0], inertia: 0.04, points: {O: [0, 0], B: [0.5, 0]}}
  link2: {mass: 1.5, com: [0.2, 0], inertia: 0.03, points: {B: [0, 0], C: [0.45, 0]}}
payloads: {ballast: {body: link2, at: [0.1, 0.1], mass: 0.3}, cargo: {body: link2, at: C, mass: load, from: 0.5}}
counterweights: {cw1: {body: link1, at: [-0.4, 0], mass: 6}, cw2: {body: link2, at: [-0.1, 0], mass: 3}}
joints:
  J1: {type: revolute, connects: [ground.O, link1.O]}
  J2: {type: revolute, connects: [link1.B, link2.B]}
actuators: [J1, J2]
tool: link2.C
controllers:
  follow: {type: computed-torque, rate: 2000, bandwidth: 10MODEL}
trajectories:
  carry:
    law: cycloidal
    drive: joints
    duration: 1.2
    samples: 601
    from: {joints: {J1: 0.2, J2: 0.5}}
    to: {joints: {J1: 1.4, J2: 1.3}}
    adapt:
      cw1: {to: [-0.46, 0], start: 0.5, duration: 0.3}
      cw2: {to: [-0.22, 0], start: 0.5, duration: 0.3}
"""
# A wrist in space, with a counterweight that moves askew.
SPATIAL = """
space: spatial
gravity: [0.5, -1, -9.7]
ground: {points: {O: [0, 0, 0]}}
bodies:
  post: {mass: 3, com: [0, 0, 0.2], inertia: [0.1, 0.1, 0.05], points: {O: [0, 0, 0], A: [0.1, 0, 0.4]}}
  arm: {mass: 2, com: [0.25, 0, 0.03], inertia: [0.01, 0.05, 0.05], points: {A: [0, 0, 0], P: [0.5, 0.1, 0]}}
counterweights:
  cw: {body: arm, at: [-0.1, 0.02, 0.03], mass: 4, inertia: [0.003, 0.002, 0.004]}
joints:
  R1: {type: revolute, connects: [ground.O, post.O], axis: [0, 0, 1]}
  R2: {type: revolute, connects: [post.A, arm.A], axis: [0, 1, 0]}
actuators: [R1, R2]
tool: arm.P
trajectories:
  go:
    law: 3-4-5
    drive: joints
    duration: 1
    samples: 1001
    from: {joints: {R1: 0.2, R2: -0.4}}
    to: {joints: {R1: 1.4, R2: 0.7}}
    adapt: {cw: [{to: [-0.2, 0.1, -0.05], start: 0.1, duration: 0.4, law: bang-bang}, {to: [-0.05, -0.02, 0.07], start: 0.6, duration: 0.3}]}
"""


def cycloid(tau):
    """s, s' and s''."""
    turn = 2 * math.pi * tau
    return tau - np.sin(turn) / (2 * math.pi), 1 - np.cos(turn), 2 * math.pi * np.sin(turn)


class Adaptation(Case):
    def samples(self, text, *arguments, command="simulate"):
        file = self.path("run.h5")
        done = run(command, self.write("spec.yaml", text), "-o", file, "--force", "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file) as read:
            found = {name: np.array(read[name]) for name in read if isinstance(read[name], h5py.Dataset)}
            found["moves"] = {name: np.array(data) for name, data in read.get("adaptation", {}).items()}
        return json.loads(done.stdout), found

    def test_a_run_is_that_of_fixed_weights_on_both_sides(self):
        text = config("machines/5r-adapts.yaml")
        told, found = self.samples(text)
        t = found["time"]
        self.assertEqual([one["counterweight"] for one in told["adaptation"]["moves"]], ["cw11", "cw12"])
        plain = config("machines/5r-adapts.yaml", ("    adapt:.*", ""))
        empty = plain.replace("mass: load, from: 1", "mass: 0")
        full = plain.replace("mass: load, from: 1", "mass: load").replace(
            "at: [x11, 0]", 'at: ["x11 - a11 * load / 4", 0]').replace("at: [x12, 0]", 'at: ["x12 - a12 * load / 2", 0]')
        for other, when in ((empty, t < 1), (full, t > 1.4)):
            _, fixed = self.samples(other)
            for name in ("torque", "shaking_force", "shaking_moment", "ground_moment", "kinetic_energy"):
                columns = fixed[name].shape[-1] if fixed[name].ndim > 1 else None
                here = found[name][when][:, :columns] if columns else found[name][when]
                np.testing.assert_allclose(here, fixed[name][when], rtol=0, atol=1e-9 * max(1, np.abs(fixed[name]).max()), err_msg=name)
            # balanced at rest: the centre of mass stands still
            self.assertLess(np.abs(found["shaking_force"][when]).max(), 1e-9 * np.abs(found["shaking_force"]).max())

    def test_formulations_agree(self):
        text = config("machines/5r-adapts.yaml")
        _, tree = self.samples(text)
        _, natural = self.samples(text, "--formulation", "natural")
        for name in ("torque", "shaking_force", "shaking_moment", "joint_acceleration"):
            np.testing.assert_allclose(natural[name], tree[name], rtol=0, atol=1e-8 * np.abs(tree[name]).max(), err_msg=name)

    def test_force_and_work_of_a_weight_on_an_arm_at_rest(self):
        """F = m (s'' - g sin(angle)) along the slide, which points against the arm; the work lifts the weight."""
        told, found = self.samples(STILL.replace("ADAPT", OUT))
        t, angle, m, way = found["time"], 0.7, 4, 0.2
        tau = np.clip((t - 0.5) / 0.8, 0, 1)
        s, ds, dds = cycloid(tau)
        np.testing.assert_allclose(found["joint_position"][:, 1], way * s, rtol=0, atol=1e-14)
        np.testing.assert_allclose(found["joint_velocity"][:, 1], way * ds / 0.8, rtol=0, atol=1e-13)
        force = m * (way * dds / 0.64 - G * math.sin(angle))
        np.testing.assert_allclose(found["torque"][:, 1], force, rtol=0, atol=1e-11)
        # at the joint: the weights' moments, and the weight's inertia beside the joint's line
        x, y = -0.1 - way * s, 0.02
        torque = G * (2 * 0.25 * math.cos(angle) + m * (x * math.cos(angle) - y * math.sin(angle))) + m * y * way * dds / 0.64
        np.testing.assert_allclose(found["torque"][:, 0], torque, rtol=0, atol=1e-11)
        move, = told["adaptation"]["moves"]
        self.assertAlmostEqual(move["work"], -m * G * way * math.sin(angle), delta=1e-9)
        self.assertAlmostEqual(told["adaptation"]["end"] - told["adaptation"]["start"], 0.8)
        self.assertEqual((move["from"], move["start"]), (0, 0.5))
        self.assertAlmostEqual(move["to"], way, delta=1e-12)
        self.assertAlmostEqual(move["torque"][1]["peak"], np.abs(force).max(), delta=1e-5)
        np.testing.assert_allclose(found["moves"]["work"], [move["work"]])
        self.assertEqual(found["moves"]["peak_torque"].shape, (1, 2))

    def test_there_and_back_takes_no_work(self):
        told, _ = self.samples(STILL.replace("ADAPT", f"[{OUT}, {{to: N, start: 1.4, duration: 0.1}}, "
                                                      "{to: [-0.1, 0.02], start: 1.5, duration: 0.5, law: harmonic}]").replace(
                                                          "N: [-0.3, 0]", "N: [0.05, 0.02]"))
        first, second, third = told["adaptation"]["moves"]
        self.assertAlmostEqual(second["to"], -0.15, delta=1e-12)
        self.assertAlmostEqual(third["to"], 0, delta=1e-12)
        self.assertAlmostEqual(first["work"] + second["work"] + third["work"], 0, delta=1e-4 * first["energy"])
        self.assertAlmostEqual(told["adaptation"]["work"], first["work"] + second["work"] + third["work"], delta=1e-12)

    def test_power_is_the_rate_of_energy(self):
        for text in (config("machines/5r-adapts.yaml"), SPATIAL):
            _, found = self.samples(text, "--samples", "4001")
            energy = (found["kinetic_energy"] + found["potential_energy"]).ravel()
            t, power = found["time"], found["power"].sum(1)
            slope = (energy[2:] - energy[:-2]) / (t[2] - t[0])
            mean = (power[2:] + 4 * power[1:-1] + power[:-2]) / 6
            away = np.abs(mean - slope) < 1e-4 * np.abs(power).max()
            self.assertGreater(away.mean(), 0.995)  # all but the steps across a jump

    def test_what_moves_in_space_is_a_body_on_a_slide(self):
        """The same arm with the slide written out, moved through the same coordinates."""
        _, found = self.samples(SPATIAL)
        direction = np.array([-0.1, 0.08, -0.08]) / np.linalg.norm([-0.1, 0.08, -0.08])
        table = "\n".join(f"      - [{t!r}, {', '.join(repr(q) for q in row)}]" for t, row in
                          zip(found["time"].tolist(), found["joint_position"].tolist()))
        written = SPATIAL.split("trajectories:")[0].replace("counterweights:\n  cw: {body: arm, at: [-0.1, 0.02, 0.03], mass: 4, ",
                                                            "  slider: {mass: 4, com: [0, 0, 0], points: {C: [0, 0, 0]}, ")
        written = written.replace("P: [0.5, 0.1, 0]}", "P: [0.5, 0.1, 0], C: [-0.1, 0.02, 0.03]}").replace(
            "actuators: [R1, R2]", f"  S: {{type: prismatic, connects: [arm.C, slider.C], axis: {direction.tolist()}}}\n"
            "actuators: [R1, R2, S]") + f"""
trajectories:
  go: {{drive: joints, samples: 1001, path: {{table: \n{table}\n    , columns: [R1, R2, S]}}}}
"""
        written = written.replace("path: {table: \n", "path: {table: [\n").replace("\n    , columns", "], columns").replace(
            "      - [", "      [").replace("]\n      [", "],\n      [")
        _, other = self.samples(written)
        smooth = np.all([np.abs(found["time"] - jump) > 0.02 for jump in (0, 0.1, 0.3, 0.5, 0.6, 0.9, 1)], 0)
        for name in ("torque", "shaking_force", "shaking_moment"):
            np.testing.assert_allclose(found[name][smooth], other[name][smooth], rtol=0, atol=1e-4 * np.abs(other[name]).max(), err_msg=name)

    def test_under_control(self):
        told, found = self.samples(STILL.replace("ADAPT", OUT), "-c", "follow", command="control")
        self.assertLess(np.abs(found["tracking_error"]).max(), 1e-5)
        move, = told["adaptation"]["moves"]
        self.assertAlmostEqual(move["work"], -4 * G * 0.2 * math.sin(0.7), delta=1e-2)
        told, found = self.samples(config("machines/5r-adapts.yaml"), "-c", "computed-torque", command="control")
        self.assertLess(np.abs(found["tracking_error"]).max(), 1e-3)
        self.assertEqual(len(told["adaptation"]["moves"]), 2)
        for gains, words in (("{type: pd, kp: 30, kd: 4}", "'kp'"), ("{type: sliding-mode, k: 3}", "'k'")):
            spec = self.write("pd.yaml", STILL.replace("ADAPT", OUT).replace("{type: computed-torque, rate: 5000}", gains))
            done = run("control", spec, "-c", "follow")
            key = words.strip("'")
            self.assert_failure(done, 3, words, "counterweights that move", f": controllers.follow.{key}: along trajectory 'stay'")
            self.assertRegex(done.stderr, rf"pd\.yaml:14:\d+: controllers\.follow\.{key}")

    def test_a_controller_that_does_not_know_the_payload(self):
        """A model without the payload is one in which it has no mass, whatever else the model lacks before it in the list."""
        runs = {}
        for name, model in (("knows", ""), ("lacks", ", model: {without: [cargo]}"), ("weightless", ", model: {set: {load: 0}}"),
                            ("lacks two", ", model: {without: [ballast, cargo]}")):
            text = CARRIER.replace("MODEL", model)
            told, runs[name] = self.samples(text, "-c", "follow", command="control")
            self.assertEqual(len(told["adaptation"]["moves"]), 2)
        for quantity in ("torque", "joint_position"):
            np.testing.assert_allclose(runs["lacks"][quantity], runs["weightless"][quantity], rtol=0, atol=1e-9)
        error = {name: np.abs(found["tracking_error"][-1]).max() for name, found in runs.items()}  # long after the impact
        self.assertLess(error["knows"], 1e-4)
        self.assertGreater(error["lacks"], 20 * error["knows"])
        self.assertGreater(np.abs(runs["lacks two"]["torque"] - runs["lacks"]["torque"]).max(), 1e-3)
        done = run("control", self.write("blind.yaml", CARRIER.replace("MODEL", ", model: {without: [cw1]}")), "-c", "follow")
        self.assert_failure(done, 3, "blind.yaml:17:", "controllers.follow.model.without", "needs counterweight 'cw1'")

    def test_every_drive(self):
        for text in (config("machines/5r-adapts.yaml", ("law: cycloidal\n.*from: ", "path: {table: [[0, 0.1, 0.5], [0.6, 0.15, 0.5], [1.4, 0.2, 0.5], [2, 0.3, 0.42]]}\n"
                                               "    drive: tool\n    samples: 801\n    from: "), (r"    from:.*?    adapt", "    adapt")),
                     config("machines/5r-adapts.yaml", ("drive: tool", "drive: joints"), (r"    path:[^\n]*\n", ""))):
            told, found = self.samples(text)
            self.assertEqual(len(told["adaptation"]["moves"]), 2)
            x = found["joint_position"][:, -2:]
            np.testing.assert_allclose(x[0], [0, 0], atol=1e-12)
            np.testing.assert_allclose(x[-1], [0.075, 0.225], atol=1e-12)

    def test_units(self):
        plain, found = self.samples(STILL.replace("ADAPT", OUT))
        scaled = STILL.replace("ADAPT", "{to: [-300, 20], start: 500, duration: 800}").replace("space:", "units: {length: mm, time: ms}\nspace:")
        scaled = scaled.replace("-9.81", "-9.81e-3").replace("[0.25, 0]", "[250, 0]").replace("inertia: 0.04", "inertia: 40000").replace(
            "P: [0.5, 0], N: [-0.3, 0]", "P: [500, 0]").replace("at: [-0.1, 0.02]", "at: [-100, 20]").replace("inertia: 0.003", "inertia: 3000").replace(
            "duration: 2", "duration: 2000")
        told, other = self.samples(scaled)
        np.testing.assert_allclose(other["torque"], found["torque"], rtol=0, atol=1e-10)
        self.assertAlmostEqual(told["adaptation"]["work"], plain["adaptation"]["work"], delta=1e-10)

    def test_files_have_the_slides(self):
        """Poses, parts, plots, pages and comparisons follow the weights."""
        file = self.path("run.h5")
        spec = os.path.join(CONFIGS, "machines", "5r-adapts.yaml")
        self.assert_quiet_success(run("simulate", spec, "-o", file, "--poses", "--split", "-q"))
        with h5py.File(file) as read:
            bodies = [name.decode() for name in read["body"]]
            x = np.array(read["body_position"])
            self.assertEqual(bodies[-2:], ["cw11", "cw12"])
            self.assertGreater(np.abs(x[-1, -2:] - x[0, -2:]).max(), 0.01)
            parts = sum(np.array(read[f"torque_{name}"]) for name in ("inertia", "velocity", "friction", "weight", "spring", "load"))
            np.testing.assert_allclose(parts, np.array(read["torque"]), atol=1e-9)
        self.assertEqual(run("plot", file, "--poses", "--path", "-o", self.path("path.svg"), "-q").returncode, 0)
        self.assertEqual(run("plot", file, "-o", self.path("plot.svg"), "-q").returncode, 0)
        self.assertEqual(run("report", file, "-o", self.path("file.html"), "-q").returncode, 0)
        self.assertEqual(run("report", spec, "-o", self.path("spec.html"), "-q").returncode, 0)
        done = run("compare", file, spec + ":carry", "--require", "peak(force[cw12]) <= 1.001 * base", "--require",
                   "minimum(distance[coupler1.P, ground.A1]) >= 0.1")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_page_draws_one_slide_per_counterweight(self):
        spec = STILL.replace("ADAPT", OUT) + STILL.split("trajectories:\n")[1].replace("stay:", "away:").replace(
            "ADAPT", "{to: [-0.1, 0.2], start: 0.5, duration: 0.8}")
        done = run("report", self.write("two.yaml", spec), "-o", self.path("two.html"), "-q")
        self.assert_failure(done, 3, "two.yaml", "counterweight 'cw' moves along different lines in two trajectories")
        self.assertFalse(os.path.exists(self.path("two.html")))

    def test_text_tells_the_moves(self):
        done = run("simulate", os.path.join(CONFIGS, "machines", "5r-adapts.yaml"))
        self.assertEqual(done.returncode, 0, done.stderr)
        text = unwrapped(done.stdout)
        self.assertIn("cw12 moved from 0 to 0.225 m, 1 to 1.4 s", text)
        self.assertIn("adaptation: 0.4 s, work ", text)

    def test_mistakes_are_told_with_their_place(self):
        for adapt, words in (("{to: [-0.3, 0.02], start: 1.5, duration: 0.8}", "the motion ends at 2 s"),
                             ("{to: [-0.3, 0.02], start: -1, duration: 0.8}", "0 or later"),
                             ("{to: [-0.3, 0.02], start: 0.5, duration: 0}", "a positive duration"),
                             ("{to: [-0.3, 0.02], start: 0.5}", "duration"),
                             ("{to: [-0.3, 0.02], start: 0.5, duration: 0.5, law: uniform}", "from rest to rest"),
                             ("{to: [-0.3, 0.02], start: 0.5, duration: 0.5, law: fastest}", "from rest to rest"),
                             (f"[{OUT}, {{to: [0, 0.3], start: 1.4, duration: 0.1}}]", "not on one line"),
                             (f"[{OUT}, {{to: [0, 0.02], start: 1.2, duration: 0.1}}]", "before 1.3 s"), ("[]", "at least one move")):
            spec = self.write("bad.yaml", STILL.replace("ADAPT", adapt))
            self.assert_failure(run("check", spec), 3, words, "bad.yaml:23")
        self.assert_failure(run("check", self.write("bad.yaml", STILL.replace("ADAPT", OUT).replace("{cw: {to", "{cv: {to"))), 3, "'cw'")
        named = STILL.replace("ADAPT", OUT).replace("cw: {body", "R: {body").replace("{cw: {to", "{R: {to")
        self.assert_failure(run("check", self.write("bad.yaml", named)), 3, "also a body or a joint")
        fastest = STILL.replace("ADAPT", OUT).replace("law: cycloidal", "law: fastest\n    limits: {torque: 90}").replace("    duration: 2\n", "")
        self.assert_failure(run("check", self.write("bad.yaml", fastest)), 3, "no 'adapt' with a law")
        design = STILL.replace("ADAPT", OUT) + "design: {minimize: {rms: torque}}\n"
        self.assert_failure(run("check", self.write("bad.yaml", design.replace("mass: 4", "mass: {free: [0, 9]}"))), 3, "without 'adapt'")


if __name__ == "__main__":
    unittest.main()
