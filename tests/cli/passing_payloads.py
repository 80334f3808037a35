"""Payloads that are taken up and set down on the way: `payloads: {extra: {…, from: 0.3, until: 0.7}}`."""

import json
import os
import unittest

import h5py
import numpy

from _program import CONFIGS, Case, config, run, unwrapped

G = 9.81
# The arm of P0, section 3.2, balanced for the 0.5 kg that it always carries: the conditions by hand, as in load_cases.py.
ARM = """\
name: arm
space: planar
gravity: [0, -9.81]
ground: {{points: {{O: [0, 0]}}}}
bodies:
  link1: {{mass: 2, com: [0.25, 0], inertia: 0.042, points: {{P1: [0, 0], P2: [0.5, 0]}}}}
  link2: {{mass: 1.5, com: [0.2, 0], inertia: 0.02, points: {{P2: [0, 0], P3: [0.4, 0]}}}}
payloads:
  cargo: {{body: link2, at: P3, mass: 0.5}}
{extra}
counterweights:
  cw1: {{body: link1, at: [{cw1}, 0], mass: 12}}
  cw2: {{body: link2, at: [{cw2}, 0], mass: 4{more}}}
joints:
  R1: {{type: revolute, connects: [ground.O, link1.P1]}}
  R2: {{type: revolute, connects: [link1.P2, link2.P2]}}
actuators: [R1, R2]
tool: link2.P3
assembly: {{R1: -0.3, R2: 1.2}}
trajectories:
  # at rest, with both links level, at 0.3 and 0.7 s
  stops: {{law: cycloidal, drive: joints, duration: 1, samples: 501, from: {{joints: {{R1: -0.3, R2: 1.2}}}},
    to: {{joints: {{R1: 0.9, R2: 1.1}}}},
    path: {{waypoints: [{{joints: {{R1: 0, R2: 0}}}}, {{joints: {{R1: 0, R2: 0.5}}}}], times: [0.3, 0.7]}}}}
  swing: {{law: bang-bang, drive: joints, duration: 1, samples: 501, from: {{joints: {{R1: -0.3, R2: 1.2}}}},
    to: {{joints: {{R1: 0.9, R2: 1.1}}}}}}
{tail}
"""
COMES = "  extra: {body: link2, at: P3, mass: 0.5, from: 0.3, until: 0.7}"
STAYS = "  extra: {body: link2, at: P3, mass: 0.5}"


def arm(extra, tail="", cw1=-3.5 / 12, cw2=-0.125, more=""):
    return ARM.format(extra=extra, tail=tail, cw1=cw1, cw2=cw2, more=more)


class PassingPayloads(Case):
    def simulate(self, extra, *arguments, trajectory="stops", **more):
        spec, out = self.write("arm.yaml", arm(extra, **more)), self.path("out.h5")
        done = run("simulate", spec, "-t", trajectory, "-o", out, "--force", "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(out) as file:
            samples = {name: numpy.array(file[name]) for name in file if isinstance(file[name], h5py.Dataset)}
            changes = {name: numpy.array(data) for name, data in file.get("payload_changes", {}).items()}
        return json.loads(done.stdout), samples, changes

    quantities = ("torque", "power", "shaking_force", "shaking_moment", "ground_force", "ground_moment", "joint_force",
                  "com_position", "com_velocity", "com_acceleration", "kinetic_energy", "potential_energy")

    def pieces(self, trajectory, *arguments, quantities=quantities):
        """The run, and those of the arm without and with the payload, at the same states."""
        told, mixed, changes = self.simulate(COMES, *arguments, trajectory=trajectory)
        without, with_it = (self.simulate(extra, *arguments, trajectory=trajectory)[1] for extra in ("", STAYS))
        time = mixed["time"]
        there = (time >= 0.3 - 1e-9) & (time < 0.7 - 1e-9)
        for name in quantities:
            scale = 1 + numpy.abs(with_it[name]).max()
            for rows, alone in ((~there, without), (there, with_it)):
                # the same states up to what Newton's method leaves
                self.assertLess(numpy.abs(mixed[name] - alone[name])[rows].max(), 1e-11 * scale, name)
        return told, mixed, changes, without, with_it, there

    def test_every_stretch_is_that_of_the_arm_with_what_it_carries_then(self):
        for trajectory in ("stops", "swing"):
            with self.subTest(trajectory):
                told, mixed, _, without, with_it, there = self.pieces(trajectory)
                # what Newton–Euler says of the whole: the frame feels weight less the rate of momentum
                mass = 20 + 0.5 * there
                weight = numpy.outer(mass, [0, -G])
                self.assertLess(numpy.abs(mixed["ground_force"] - weight + mixed["shaking_force"]).max(), 1e-9)
                # figures: the trapezoidal rule within every stretch, peaks from both sides
                peak = {m["quantity"]: m for m in told["metrics"]}
                k = {t: int(round(500 * t)) for t in (0.3, 0.7)}
                for a, name in enumerate(("torque[R1]", "torque[R2]")):
                    sides = [(without, 0, k[0.3]), (with_it, k[0.3], k[0.7]), (without, k[0.7], 500)]
                    squares = peaks = 0
                    if trajectory == "swing":  # a jump of the acceleration besides: samples have one side of it only
                        sides = []
                    for source, begin, end in sides:
                        values = source["torque"][begin:end + 1, a]
                        squares += numpy.trapezoid(values**2, dx=1 / 500) if hasattr(numpy, "trapezoid") else numpy.trapz(
                            values**2, dx=1 / 500)
                        peaks = max(peaks, numpy.abs(values).max())
                    if sides:
                        self.assertAlmostEqual(peak[name]["rms"], squares**0.5, delta=1e-9)
                        self.assertAlmostEqual(peak[name]["peak"], peaks, delta=1e-9)

    def test_natural_coordinates_agree(self):
        no_reactions = tuple(q for q in self.quantities if q != "joint_force")
        for trajectory in ("stops", "swing"):
            with self.subTest(trajectory):
                told, mixed, changes, *_ = self.pieces(trajectory, "--formulation", "natural", quantities=no_reactions)
                tree, other, same = self.simulate(COMES, trajectory=trajectory)
                for name in no_reactions:
                    self.assertLess(numpy.abs(mixed[name] - other[name]).max(), 1e-9 * (1 + numpy.abs(other[name]).max()), name)
                for name in ("speed", "torque_before", "torque_after"):
                    self.assertLess(numpy.abs(changes[name] - same[name]).max(), 1e-9, name)
                self.assertEqual(told["notes"], tree["notes"])
        done = run("check", self.write("arm.yaml", arm(COMES)), "--verify")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_loops_and_space(self):
        """The shipped mechanisms that carry a cargo, with it, without it, and with it for a while."""
        for name in ("5r", "delta"):
            with open(os.path.join(CONFIGS, name + ".yaml"), encoding="utf-8") as file:
                text = file.read().replace("  bang-bang: {law: bang-bang, drive: com}\n", "")
            begin = text.index("  cargo: {")
            end = text.index("}\n", begin)
            runs = {}
            for kind, changed in (("with", text), ("without", text.replace("payloads:\n" + text[begin:end + 2], "")),
                                  ("mixed", text[:end] + ", from: 0.0617, until: 0.2" + text[end:])):
                spec, out = self.write(kind + ".yaml", changed), self.path(kind + ".h5")
                done = run("simulate", spec, "-t", "cycloid", "-o", out, "--force", "--json")
                self.assertEqual(done.returncode, 0, done.stderr)
                with h5py.File(out) as file:
                    runs[kind] = {data: numpy.array(file[data]) for data in (*self.quantities, "time")}
            told, time = json.loads(done.stdout), runs["mixed"]["time"]
            there = (time >= 0.0617) & (time < 0.2 - 1e-9)
            self.assertGreater(there.sum(), 10)
            for data in self.quantities:
                scale = 1 + numpy.abs(runs["with"][data]).max()
                for rows, kind in ((there, "with"), (~there, "without")):
                    apart = numpy.abs(runs["mixed"][data] - runs[kind][data])[rows].max()
                    self.assertLess(apart, 1e-9 * scale, (name, data, kind))  # loops: Newton's residual over the mobility
            self.assertEqual(len([note for note in told["notes"] if "impact" in note]), 2, told["notes"])

    def test_the_jump_at_a_dwell_is_the_weight(self):
        """0.5 kg too much on the balanced arm with both links level: 0.5 · 9.81 · 0.9 and 0.5 · 9.81 · 0.4."""
        told, _, changes = self.simulate(COMES)
        taken, down = told["payload_changes"]
        self.assertEqual([(c["payload"], c["change"], c["time"]) for c in (taken, down)],
                         [("extra", "taken up", 0.3), ("extra", "set down", 0.7)])
        for torque, after in zip(taken["torque"], (4.4145, 1.962)):
            self.assertAlmostEqual(torque["before"], 0, delta=1e-9)
            self.assertAlmostEqual(torque["after"], after, delta=1e-9)
        arm2 = 0.4 * numpy.cos(0.5)
        for torque, before in zip(down["torque"], (0.5 * G * (0.5 + arm2), 0.5 * G * arm2)):
            self.assertAlmostEqual(torque["before"], before, delta=1e-9)
            self.assertAlmostEqual(torque["after"], 0, delta=1e-9)
        self.assertLess(max(taken["speed"], down["speed"]), 1e-9)
        self.assertFalse([note for note in told["notes"] if "impact" in note])
        self.assertEqual([label.decode() for label in changes["change"]], ["extra taken up", "extra set down"])
        numpy.testing.assert_allclose(changes["torque_after"], [[4.4145, 1.962], [0, 0]], atol=1e-9)
        text = run("simulate", self.path("arm.yaml"), "-t", "stops").stdout
        self.assertIn("extra taken up at 0.3 s: R1 from 0 to 4.4145 N m, R2 from 0 to 1.962 N m\n", text)

    def test_under_control_the_impact_is_in_the_motion(self):
        """A bar on a pivot takes up a point mass at rest: J w stays, and the energy falls by that of the lost rate."""
        J, m, r, rate = 0.5, 0.7, 0.4, 1.5
        spec = self.write("bar.yaml", f"""
space: planar
gravity: [0, 0]
ground: {{points: {{O: [0, 0]}}}}
bodies: {{bar: {{mass: 2, com: [0, 0], inertia: {J}, points: {{O: [0, 0], H: [{r}, 0]}}}}}}
joints: {{A: {{type: revolute, connects: [ground.O, bar.O]}}}}
payloads: {{cargo: {{body: bar, at: H, mass: {m}, from: 0.4, until: 0.7}}}}
actuators: [A]
motion: {{duration: 1, samples: 101, from: {{joints: {{A: 0}}}}, to: {{joints: {{A: {rate}}}}}}}
trajectories: {{turn: {{law: uniform, drive: joints}}}}
""")
        out = self.path("bar.h5")
        done = run("control", spec, "-t", "turn", "--controller", "none", "-o", out, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        taken, down = told["payload_changes"]
        self.assertEqual([(c["payload"], c["change"], c["time"]) for c in (taken, down)], [("cargo", "taken up", 0.4), ("cargo", "set down", 0.7)])
        after = J * rate / (J + m * r * r)
        loss = J * rate**2 / 2 - (J + m * r * r) * after**2 / 2
        self.assertAlmostEqual(taken["speed"], r * rate, delta=1e-9)
        self.assertAlmostEqual(taken["impact_loss"], loss, delta=1e-9)
        self.assertAlmostEqual(down["speed"], r * after, delta=1e-8)
        self.assertEqual(down["impact_loss"], 0)
        self.assertIn(f"the impact takes {loss:.4g} J", " ".join(told["notes"]))
        self.assertNotIn("do not include the impact", " ".join(told["notes"]))
        with h5py.File(out) as file:
            changes = file["payload_changes"]
            self.assertEqual([label.decode() for label in changes["change"]], ["cargo taken up", "cargo set down"])
            numpy.testing.assert_allclose(changes["impact_loss"], [loss, 0], atol=1e-9)
            numpy.testing.assert_allclose(numpy.ravel(file["joint_velocity"])[[20, 60, 90]], [rate, after, after], rtol=1e-8)
        # held efforts are the same on both sides of a change between samples of the controller, and the new ones at a sample
        done = run("control", spec, "-t", "turn", "--controller", "computed-torque", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        taken = json.loads(done.stdout)["payload_changes"][0]
        self.assertGreater(taken["torque"][0]["after"], taken["torque"][0]["before"] + 1)
        self.assertIn("cargo taken up at 0.4 s: A from", run("control", spec, "-t", "turn", "--controller", "computed-torque").stdout)

    def test_an_impact_is_told(self):
        told, mixed, changes = self.simulate(COMES, trajectory="swing")
        tool = numpy.gradient(mixed["tool_position"], 1 / 500, axis=0)
        for i, k in enumerate((150, 350)):
            speed = numpy.linalg.norm(tool[k])
            self.assertAlmostEqual(changes["speed"][i], speed, delta=1e-3 * speed)  # differences of samples
        notes = [note for note in told["notes"] if "the figures do not include the impact" in note]
        self.assertEqual(len(notes), 2)
        self.assertRegex(notes[0], r"^payload 'extra' is taken up at 0\.3 s while it moves at [\d.]+ m/s: ")

    def test_a_payload_on_an_axis_meets_the_turn_alone(self):
        """At 0.3 s of a bang-bang turn by 1.2 rad in 1 s: 4 · 1.2 · 0.3 rad/s. A point mass there meets nothing."""
        for inertia, turning in ((", inertia: 0.01", 1.44), ("", 0)):
            told, _, changes = self.simulate(f"  extra: {{body: link1, at: P1, mass: 0.5{inertia}, from: 0.3}}", trajectory="swing")
            self.assertAlmostEqual(changes["turning"][0], turning, delta=1e-9)
            said = [note for note in told["notes"] if "while it turns at 1.44 rad/s" in note]
            self.assertEqual(len(said), 1 if turning else 0)

    def test_power_is_the_rate_of_energy_in_every_stretch(self):
        _, mixed, changes = self.simulate(COMES, "--samples", "5001")
        energy = (mixed["kinetic_energy"] + mixed["potential_energy"]).ravel()
        power = mixed["power"].sum(axis=1)
        for begin, end in ((0, 1498), (1500, 3498), (3500, 5000)):
            piece = power[begin:end + 1]
            done = (piece[0] + piece[-1] + 4 * piece[1:-1:2].sum() + 2 * piece[2:-1:2].sum()) / 15000  # Simpson's rule
            self.assertAlmostEqual(energy[end] - energy[begin], done, delta=1e-8)
        # at the dwells the payload brings and takes its weight's height, and nothing else: 0 and 0.4 sin 0.5 above the base
        for k, height in ((1500, 0), (3500, -0.4 * numpy.sin(0.5))):
            self.assertAlmostEqual(energy[k] - energy[k - 1], 0.5 * G * height, delta=1e-6)

    def test_parts_add_up_on_both_sides(self):
        spec, out = self.write("arm.yaml", arm(COMES)), self.path("split.h5")
        self.assertEqual(run("simulate", spec, "-t", "swing", "-o", out, "--split").returncode, 0)
        with h5py.File(out) as file:
            parts = sum(numpy.array(file[f"torque_{part}"]) for part in ("inertia", "velocity", "friction", "weight", "spring", "load"))
            self.assertLess(numpy.abs(parts - file["torque"]).max(), 1e-10)

    def test_only_one_end_may_be_said(self):
        for extra, changes in (("from: 0.3", ["taken up"]), ("until: 0.7", ["set down"]), ("from: 0, until: 1", []),
                               ("from: -1, until: 0.7", ["set down"])):
            told, *_ = self.simulate(STAYS.replace("}", f", {extra}}}"))
            self.assertEqual([c["change"] for c in told.get("payload_changes", [])], changes)
        told, *_ = self.simulate(COMES.replace("0.3, until: 0.7", "1.5"), tail="  long: {law: cycloidal, drive: joints, "
                                 "duration: 2, from: {joints: {R1: 0, R2: 1}}, to: {joints: {R1: 1, R2: 1}}}")
        self.assertIn("payload 'extra' is never there: it is taken up at 1.5 s, and the motion ends at 1 s", told["notes"])

    def test_designs_see_it_while_it_is_there(self):
        """The convex program's least rms is that of a simulation, and no neighbour has a smaller one."""
        minimize = "design: {minimize: {rms: 'torque[R2]', along: stops}}"
        spec, found = self.write("design.yaml", arm(COMES, tail=minimize).replace("mass: 4}", "mass: {free: [0, 30]}}")), self.path("found.yaml")
        done = run("design", spec, "-o", found, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        self.assertEqual(told["optimality"], "proved-best")
        number = told["free_numbers"][0]
        self.assertIsNone(number["at_bound"])

        def rms(mass):
            run_told = json.loads(run("simulate", self.write("tried.yaml", arm(COMES).replace("mass: 4}", f"mass: {mass!r}}}")), "-t", "stops",
                                      "--json").stdout)
            return next(m["rms"] for m in run_told["metrics"] if m["quantity"] == "torque[R2]")

        least = rms(number["value"])
        self.assertAlmostEqual(told["objective"]["value"], least, delta=1e-8 * least)
        for step in (-0.01, 0.01):
            self.assertGreater(rms(number["value"] + step), least)

    def test_slopes_of_figures_are_those_of_differences(self):
        # not balanced by anything: magnitudes have no slope where they vanish
        spec = self.write("off.yaml", arm(COMES, tail="tolerances: {cw2.mass: 0.001}").replace("mass: 4}", "mass: 3.5}"))
        told = json.loads(run("tolerance", spec, "-t", "stops", "--json", "--of", "torque[R2]").stdout)

        def figures(mass):
            tried = self.write("tried.yaml", arm(COMES).replace("mass: 4}", f"mass: {mass!r}}}"))
            metrics = json.loads(run("simulate", tried, "-t", "stops", "--json").stdout)["metrics"]
            return next(m for m in metrics if m["quantity"] == "torque[R2]")

        step = 1e-4
        more, less = figures(3.5 + step), figures(3.5 - step)
        quantity = next(q for q in told["first_order"]["quantities"] if q["quantity"] == "torque[R2]")
        for figure in ("rms", "peak", "mean", "range"):
            slope = abs(more[figure] - less[figure]) / (2 * step)
            self.assertAlmostEqual(quantity[figure]["deviation"], 1e-3 * slope, delta=1e-7 * slope + 1e-10, msg=figure)

    def test_equations_of_a_pose_are_those_at_a_time(self):
        spec = self.write("arm.yaml", arm(COMES))
        weights = {}
        for time in (0, 0.3, 0.7):
            done = run("equations", spec, "--at", "R1=0,R2=0", "--time", str(time), "--only", "torques", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            told = json.loads(done.stdout)
            weights[time] = done.stdout
            self.assertIn(f"at {time:g} s payload 'extra' is {'' if time == 0.3 else 'not '}there", told["notes"])
        self.assertIn("4.4145", weights[0.3])
        self.assertNotIn("4.4145", weights[0] + weights[0.7])

    def test_what_cannot_be_meant_is_refused_with_its_place(self):
        free = arm(COMES, tail="design: {goal: static}", cw2="{free: [-0.5, 0]}")
        spec = self.write("free.yaml", free)
        place = "free.yaml:10:49: payloads.extra.from: expected payloads that are always there, for "
        self.assert_failure(run("design", spec), 3, place + "the goals of a design")
        because = ", because payload 'extra' is taken up or set down on the way"
        joints = "from: {joints: {R1: 0, R2: 1}}, to: {joints: {R1: 1, R2: 1}}"
        for tail, message in (
                (f"  t: {{law: cubic, drive: com, duration: 1, {joints}}}",
                 "trajectories.t.drive: expected 'joints' or 'tool': the centre of mass would jump" + because),
                (f"  t: {{law: fastest, drive: joints, {joints}, limits: {{torque: 40}}}}",
                 "trajectories.t.law: expected a law that is not searched for" + because),
                (f"  t: {{law: cubic, drive: joints, duration: 1, {joints}, limits: {{torque: 40}}}}",
                 "trajectories.t.limits: expected no 'limits'" + because),
                (f"  t: {{law: cubic, drive: joints, duration: {{free: [1, 2]}}, {joints}}}",
                 "trajectories.t: expected a 'duration' that no free number, load case or tolerance changes" + because),
                ("  t: {law: cubic, drive: joints, duration: 1, from: {com: [0.1, 0]}, to: {joints: {R1: 1, R2: 1}}}",
                 "trajectories.t.from: expected a pose by 'joints' or 'tool'" + because),
                ("workspace: {joints: {R1: [0, 1], R2: 1}}",
                 "workspace: expected no workspace, whose poses have no time" + because)):
            self.assert_failure(run("check", self.write("bad.yaml", arm(COMES, tail=tail))), 3, message)

    def test_conditions_are_those_of_all_load_states(self):
        # without the payload the arm is balanced
        spec = self.write("arm.yaml", arm(COMES))
        told = json.loads(run("conditions", spec, "--goal", "static", "--json").stdout)
        alone = json.loads(run("conditions", spec, "--goal", "static", "--json", "--without", "extra").stdout)
        self.assertTrue(all(one["met"] for one in alone["conditions"]))
        unmet = sum(not one["met"] for one in told["conditions"])
        self.assertGreater(unmet, 0)
        self.assertIn(f"with extra: {unmet} of {len(told['conditions'])} not met", told["notes"])
        self.assertIn("without extra: all conditions are met", told["notes"])
        always = json.loads(run("conditions", self.write("always.yaml", arm(STAYS)), "--goal", "static", "--json").stdout)
        self.assertEqual([one["residual"] for one in told["conditions"]], [one["residual"] for one in always["conditions"]])

    def test_equations_along_a_motion_are_those_of_what_is_there(self):
        spec = self.write("arm.yaml", arm(COMES))
        self.assert_quiet_success(run("equations", spec, "--at", "stops", "-o", self.path("e.h5")))
        self.assert_quiet_success(run("simulate", spec, "-t", "stops", "-o", self.path("r.h5"), "-q"))
        with h5py.File(self.path("e.h5")) as equations, h5py.File(self.path("r.h5")) as result:
            torque = numpy.array(equations["torque"]).sum(axis=2)
            numpy.testing.assert_allclose(torque, result["torque"], rtol=0, atol=1e-9)
            mass = numpy.array(equations["M"])
            self.assertGreater(numpy.abs(numpy.diff(mass[:, 1, 1])).max(), 0.01)

    def test_formulas_have_the_payload_as_a_symbol(self):
        done = run("equations", self.write("arm.yaml", arm(COMES)), "--only", "gravity")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("payload 'extra' is not always there", unwrapped(done.stdout))

    def test_under_control_the_impact_is_part_of_the_motion(self):
        # `stops` rests while the payload comes and goes: nothing jumps
        spec = self.write("arm.yaml", arm(COMES))
        done = run("control", spec, "-t", "stops", "-c", "computed-torque", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        notes = json.loads(done.stdout)["notes"]
        self.assertTrue(any("payload 'extra' is taken up at" in note for note in notes), notes)
        self.assertTrue(any("payload 'extra' is set down at" in note for note in notes), notes)

    def controlled(self, text, *arguments):
        file = self.path("run.h5")
        done = run("control", self.write("spec.yaml", text), "-o", file, "--force", "--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(file) as read:
            samples = {name: numpy.array(read[name]) for name in read if isinstance(read[name], h5py.Dataset)}
        return json.loads(done.stdout), samples

    def test_both_sides_of_a_change_have_the_efforts_of_that_moment(self):
        """The open-loop torque falls from 100 N m to 0 within 1e-7 s of the change; the peak of the power is before it."""
        text = arm("  extra: {body: link2, at: P3, mass: 0.5, from: 0.4}") + """\
controllers:
  push: {type: open-loop, table: [[0, 0, 0], [0.4, 100, 0], [0.4000001, 0, 0], [1, 0, 0]]}
"""
        told, samples = self.controlled(text, "-t", "swing", "-c", "push", "--samples", "401")
        k = int(numpy.argmin(abs(samples["time"] - 0.4)))
        before = 2 * samples["joint_velocity"][k - 1, 0] - samples["joint_velocity"][k - 2, 0]  # to 0.4 s, before the impact
        peak = next(one["peak"] for one in told["metrics"] if one["quantity"] == "power")
        self.assertAlmostEqual(peak, 100 * abs(before), delta=1e-4 * peak)

    def test_full_turns_are_counted_across_a_change(self):
        """The cut joint's angle goes on where it was, whichever joint the loop is cut at."""
        text = config("four-bar.yaml", (r"joints:\n(.*?\n)(.*?\n)(.*?\n)(.*?\n)", ""), ("motion: {duration: 0.5", "motion: {duration: 1"),
                      ("2 \\* pi", "4 * pi"))
        joints = {name: f"  {name}: {{type: revolute, connects: [{one}, {two}]}}\n" for name, one, two in (
            ("A", "ground.A", "crank.A"), ("B", "crank.B", "coupler.B"), ("C", "coupler.C", "rocker.C"), ("D", "ground.D", "rocker.D"))}
        for order in ("ADCB", "ABCD", "ABDC"):
            listed = "joints:\n" + "".join(joints[name] for name in order) + "payloads: {load: {body: coupler, at: C, mass: 0.1, until: 0.8}}\n"
            _, samples = self.controlled(text.replace("\nactuators:", f"\n{listed}\nactuators:", 1), "-t", "cycloid", "-c", "computed-torque")
            self.assertLess(numpy.abs(numpy.diff(samples["joint_position"], axis=0)).max(), 0.5, order)

    def test_notes_of_what_was_before_a_change_remain(self):
        text = config("four-bar.yaml", ("assembly:", "friction: {A: {coulomb: 5}, B: {coulomb: 5}, C: {coulomb: 5}, D: {coulomb: 5}}\nassembly:")) + """
payloads: {load: {body: coupler, at: C, mass: 0.1, until: 0.3}}
controllers: {push: {type: open-loop, table: [[0, 0], [0.1, 0], [0.2, 60], [0.5, 60]]}}
"""
        told, _ = self.controlled(text, "-t", "cycloid", "-c", "push")
        self.assertTrue(any("joints at rest share the load" in note for note in told["notes"]), told["notes"])


if __name__ == "__main__":
    unittest.main()
