"""Counterweights as solids: `shape: {cylinder: {diameter: 0.1, thickness: 0.02, material: steel}}`."""

import json
import math
import os
import unittest

import numpy

from _program import CONFIGS, Case, run

TEXT = """\
space: {space}
gravity: {gravity}
ground: {{points: {{O: {o}}}}}
bodies: {{link: {{mass: 1, com: {c}, inertia: {I}, points: {{O: {o}}}}}}}
joints: {{J: {{type: revolute, connects: [ground.O, link.O]{axis}}}}}
{more}
counterweights: {{cw: {{body: link, at: {at}, {cw}}}}}
actuators: [J]
trajectories: {{t: {{law: cycloidal, drive: joints, duration: 1, samples: 201, from: {{joints: {{J: 0}}}}, to: {{joints: {{J: 1}}}}}}}}
"""


def cloud(inside, low, high, count=140):
    """Mass properties of a solid from small cubes of density 1: volume, centre, inertia about the centre."""
    axes = [numpy.linspace(a, b, count + 1) for a, b in zip(low, high)]
    middles = [0.5 * (axis[1:] + axis[:-1]) for axis in axes]
    x, y, z = numpy.meshgrid(*middles, indexing="ij")
    where = inside(x, y, z)
    points = numpy.stack([x[where], y[where], z[where]])
    cell = math.prod((b - a) / count for a, b in zip(low, high))
    centre = points.mean(1)
    d = points - centre[:, None]
    inertia = cell * ((d * d).sum() * numpy.eye(3) - d @ d.T)
    return cell * where.sum(), centre, inertia


SOLIDS = {
    "cylinder: {diameter: 0.2, thickness: 0.06, material: lead}":
        (11340, lambda x, y, z: (numpy.hypot(x, y) < 0.1) & (abs(z) < 0.03), 0.1, 0.03),
    "ring: {diameter: 0.2, inner_diameter: 0.12, thickness: 0.05, material: brass}":
        (8500, lambda x, y, z: (numpy.hypot(x, y) < 0.1) & (numpy.hypot(x, y) > 0.06) & (abs(z) < 0.025), 0.1, 0.025),
    "sector: {diameter: 0.2, inner_diameter: 0.08, thickness: 0.05, opening: 2.1, density: 5000}":
        (5000, lambda x, y, z: (numpy.hypot(x, y) < 0.1) & (numpy.hypot(x, y) > 0.04) & (abs(numpy.arctan2(y, x)) < 1.05) & (abs(z) < 0.025), 0.1, 0.025),
    "plate: {length: 0.18, width: 0.1, thickness: 0.04, material: steel}":
        (7850, lambda x, y, z: (abs(x) < 0.09) & (abs(y) < 0.05) & (abs(z) < 0.02), 0.1, 0.02),
}


class Shapes(Case):
    def torque(self, text):
        done = run("simulate", self.write("spec.yaml", text), "--json", "--trajectory", "t")
        self.assertEqual(done.returncode, 0, done.stderr)
        metrics = {metric["quantity"]: metric for metric in json.loads(done.stdout)["metrics"]}
        return metrics

    def spec(self, cw, at="[0.3, 0.1]", more=""):
        return TEXT.format(space="planar", gravity="[0, -9.81]", o="[0, 0]", c="[0.2, 0]", I=0.02, axis="", at=at, cw=cw, more=more)

    def solid_spec(self, cw, axis, at="[0.3, 0.1, 0.05]"):
        return TEXT.format(space="spatial", gravity="[0, 0, 0]", o="[0, 0, 0]", c="[0.2, 0, 0]", I="[0.02, 0.02, 0.02]",
                           axis=f", axis: {axis}", at=at, cw=cw, more="")

    def test_solids_weigh_and_turn_like_clouds_of_small_cubes(self):
        """Planar and spatial, against the same run with the mass, place and inertia of a cloud."""
        for text, (density, inside, radius, half) in SOLIDS.items():
            volume, centre, inertia = cloud(inside, (-radius, -radius, -half), (radius, radius, half))
            mass, inertia = density * volume, density * inertia
            at = [0.3 + centre[0], 0.1 + centre[1]]
            got = self.torque(self.spec(f"shape: {{{text}}}"))
            expected = self.torque(self.spec(f"mass: {mass}, inertia: {inertia[2, 2]}", f"[{at[0]}, {at[1]}]"))
            # 140 cubes across: their staircase is off by less than a third of a cell's share
            self.assertAlmostEqual(got["torque[J]"]["peak"] / expected["torque[J]"]["peak"], 1, delta=3e-3, msg=text)
            for axis in ("[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"):
                got = self.torque(self.solid_spec(f"shape: {{{text}}}", axis))
                numbers = ", ".join(str(inertia[i, i]) for i in range(3))
                expected = self.torque(self.solid_spec(f"mass: {mass}, inertia: [{numbers}]", axis, f"[{at[0]}, {at[1]}, 0.05]"))
                self.assertAlmostEqual(got["torque[J]"]["peak"] / expected["torque[J]"]["peak"], 1, delta=3e-3, msg=text + axis)

    def test_a_turned_solid_is_that_about_the_other_axis(self):
        upright = self.torque(self.solid_spec("shape: {cylinder: {diameter: 0.2, thickness: 0.3, material: steel, axis: [0, 1, 0]}}", "[0, 0, 1]"))
        mass = 7850 * math.pi / 4 * 0.04 * 0.3
        numbers = [mass * (0.04 / 16 + 0.09 / 12), mass * 0.04 / 8, mass * (0.04 / 16 + 0.09 / 12)]
        same = self.torque(self.solid_spec(f"mass: {mass!r}, inertia: {numbers!r}", "[0, 0, 1]"))
        self.assertAlmostEqual(upright["torque[J]"]["peak"] / same["torque[J]"]["peak"], 1, delta=1e-12)

    def test_a_sector_that_moves_with_the_payload_keeps_its_shape(self):
        """`to` is a place of its axis, as `at` is: the same run with the mass at the centre (4 sin(phi/2)/(3 phi) (R3 - r3)/(R2 - r2))."""
        outer, inner, half = 0.1, 0.04, 1.05
        mass = 5000 * 0.05 * half * (outer**2 - inner**2)
        centre = 2 * math.sin(half) / (3 * half) * (outer**3 - inner**3) / (outer**2 - inner**2)
        inertia = mass * (outer**2 + inner**2) / 2 - mass * centre**2
        moves = ", adapt: {{cw: {{to: [{}, 0], start: 0.2, duration: 0.5}}}}}}}}"
        cases = (("shape: {sector: {diameter: 0.2, inner_diameter: 0.08, thickness: 0.05, opening: 2.1, density: 5000, direction: [-1, 0]}}", 0),
                 (f"mass: {mass!r}, inertia: {inertia!r}", centre))
        sector, point = (self.torque(self.spec(cw, f"[{-0.2 - back!r}, 0]").replace("{J: 1}}}}", "{J: 1}}" + moves.format(-0.3 - back)))
                         for cw, back in cases)
        for quantity in ("torque[J]", "force[cw]", "shaking_moment"):
            self.assertAlmostEqual(sector[quantity]["peak"] / point[quantity]["peak"], 1, delta=1e-12, msg=quantity)

    def test_a_free_diameter_balances_exactly(self):
        """rho pi/4 D^2 t a = m c, and the disc clears a post."""
        done = run("design", os.path.join(CONFIGS, "stock-counterweight.yaml"), "--json")
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout[:2000])
        got = json.loads(done.stdout)
        numbers = {number["path"]: number["value"] for number in got["free_numbers"]}
        diameter = next(value for path, value in numbers.items() if "diameter" in path)
        place = numbers["parameters.a"] * 1e-3
        self.assertAlmostEqual(7850 * math.pi / 4 * diameter**2 * 0.02 * place / (0.8 * 0.12), 1, delta=1e-8)
        clearance = next(limit["value"] for limit in got["constraints"] if "post" in limit["text"])
        # nearest to the post where the link lies level, at a sample of the motion
        self.assertAlmostEqual(clearance, 0.18 - place - diameter / 2, delta=1e-9)
        # the least mass is at the largest place: of a + D/2 = 175 mm, or at the bound of a
        best = min(0.17, largest_place())
        self.assertAlmostEqual(place, best, delta=1e-5)

    def test_clearances_are_those_of_surfaces(self):
        more = "payloads: {p: {body: link, at: [-0.3, 0], shape: {plate: {length: 0.1, width: 0.06, thickness: 0.01, material: steel}}}}"
        text = self.spec("shape: {cylinder: {diameter: 0.2, thickness: 0.02, material: steel}}", "[0.3, 0]", more)
        text = text.replace("O: [0, 0]}}\nbodies", "O: [0, 0], A: [0.45, 0], B: [0.6, -1], C: [0.6, 1]}}\nbodies")
        expected = {"clearance(cw, ground.A, t)": 0.05, "clearance(cw, ground.B to ground.C, t)": 0.2, "clearance(cw, p, t)": 0.45,
                    "clearance(p, ground.O, t)": 0.25}
        limits = ", ".join(f"'{name} >= 0.001'" for name in expected)
        text = text.replace("mass: 1,", "mass: {free: [1, 2]},") + f"design: {{minimize: total-mass, subject_to: [{limits}]}}\n"
        done = run("design", self.write("clear.yaml", text), "--json")
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout[:2000])
        for limit, value in zip(json.loads(done.stdout)["constraints"], expected.values()):
            self.assertAlmostEqual(limit["value"], value, delta=1e-9, msg=limit["text"])

    def test_mistakes(self):
        for cw, message in (("shape: {ball: {diameter: 1}}", "expected cylinder, ring, sector or plate"),
                            ("shape: {cylinder: {diameter: 0.1, thickness: 0.1}}", "'material', 'density'"),
                            ("shape: {cylinder: {diameter: 0.1, thickness: 0.1, material: stel}}", "'steel'"),
                            ("shape: {ring: {diameter: 0.1, inner_diameter: 0.2, thickness: 0.1, material: steel}}", "at most the 'diameter'"),
                            ("mass: 1, shape: {cylinder: {diameter: 0.1, thickness: 0.1, material: steel}}", "no 'mass' with 'shape'")):
            self.assert_failure(run("check", self.write("spec.yaml", self.spec(cw))), 3, "counterweights.cw", message)


def largest_place():
    """a with a + D/2 = 0.175 and 7850 pi/4 D^2 0.02 a = 0.8 0.12, the larger one."""
    low, high = 0.1, 0.175
    for _ in range(100):
        a = 0.5 * (low + high)
        diameter = math.sqrt(0.8 * 0.12 / (7850 * math.pi / 4 * 0.02 * a))
        low, high = (a, high) if a + diameter / 2 < 0.175 else (low, a)
    return low


if __name__ == "__main__":
    unittest.main()
