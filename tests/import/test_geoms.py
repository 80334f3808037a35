"""Masses of MJCF bodies that follow from their geoms, against integrals over the shapes."""

import unittest

import numpy as np
import yaml

from _spec import ImportCase, run

MODEL = """<mujoco>
  <compiler {compiler}/>
  <default><geom density="{density}"/><default class="light"><geom density="50"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="link" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      {inside}
    </body>
  </worldbody>
</mujoco>
"""


def integrated(radius, low, high):
    """Volume and moments about x and z of a solid of revolution about z, whose radius is a function; by Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    z, w = (high + low) / 2 + (high - low) / 2 * nodes, (high - low) / 2 * weights
    r = radius(z)
    return np.pi * w @ r**2, np.pi * w @ (r**4 / 4 + r**2 * z**2), np.pi * w @ r**4 / 2


class Geoms(ImportCase):
    def imported_link(self, inside, compiler="angle='radian'", density=1000):
        path = self.write("model.xml", MODEL.format(inside=inside, compiler=compiler, density=density))
        return self.imported(path)["bodies"]["link"]

    def assert_link(self, link, mass, com, inertia):
        self.assertAlmostEqual(link["mass"], mass, delta=1e-13 * mass)
        np.testing.assert_allclose(link.get("com", [0, 0, 0]), com, atol=1e-14)
        xx, yy, zz, xy, xz, yz = [*link["inertia"], 0, 0, 0][:6]
        np.testing.assert_allclose([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], inertia, rtol=0,
                                   atol=1e-12 * np.abs(inertia).max())

    def test_every_shape_is_its_integral(self):
        a, r, h = 0.05, 0.04, 0.1
        ball = integrated(lambda z: np.sqrt(a * a - z * z), -a, a)
        rod = integrated(lambda z: r + 0 * z, -h, h)
        caps = integrated(lambda z: np.sqrt(np.maximum(r * r - (z - h) ** 2, 0)), h, h + r)
        capsule = [rod[k] + 2 * caps[k] for k in range(3)]
        for geom, (volume, across, along) in (
                (f'<geom size="{a}"/>', ball), (f'<geom type="cylinder" size="{r} {h}"/>', rod),
                (f'<geom type="capsule" size="{r} {h}"/>', capsule),
                (f'<geom type="capsule" size="{r}" fromto="0 0 {h} 0 0 {-h}"/>', capsule)):
            self.assert_link(self.imported_link(geom), 1000 * volume, [0, 0, 0], 1000 * np.diag([across, across, along]))

    def test_boxes_and_ellipsoids(self):
        s = np.array([0.05, 0.1, 0.02])
        square = np.diag(s**2)
        for kind, volume, part in (("box", 8 * s.prod(), 3), ("ellipsoid", 4 / 3 * np.pi * s.prod(), 5)):
            mass = 1000 * volume
            link = self.imported_link(f'<geom type="{kind}" size="{s[0]} {s[1]} {s[2]}"/>')
            self.assert_link(link, mass, [0, 0, 0], mass / part * (np.trace(square) * np.eye(3) - square))

    def test_several_geoms_add_up_where_they_are(self):
        inside = """<frame pos="0.1 0 0" euler="0 0 1.5707963267948966">
            <geom class="light" type="box" size="0.1 0.02 0.03" pos="0.2 0 0"/></frame>
          <geom type="sphere" size="0.05" mass="2" pos="0 0 -0.1"/>
          <geom type="sphere" size="3" mass="0"/>
          <geom type="sphere" size="3" group="4"/>"""
        link = self.imported_link(inside, compiler="angle='radian' inertiagrouprange='0 3'")
        box = 50 * 8 * 0.1 * 0.02 * 0.03
        masses, places = np.array([box, 2]), np.array([[0.1, 0.2, 0], [0, 0, -0.1]])
        com = masses @ places / masses.sum()
        turned = np.array([0.02, 0.1, 0.03]) ** 2  # the box lies along y
        inertia = box / 3 * np.diag(turned.sum() - turned) + 2 * 0.4 * 0.05**2 * np.eye(3)
        for m, p in zip(masses, places - com):
            inertia = inertia + m * (p @ p * np.eye(3) - np.outer(p, p))
        self.assert_link(link, masses.sum(), com, inertia)

    def test_the_compiler_says_whom_to_believe(self):
        inside = '<inertial pos="0 0 0" mass="7" diaginertia="1 1 1"/><geom size="0.1" mass="2"/>'
        self.assertEqual(self.imported_link(inside)["mass"], 7)
        self.assertAlmostEqual(self.imported_link(inside, compiler="inertiafromgeom='true'")["mass"], 2, delta=1e-15)

    def test_what_cannot_be_weighed_is_told(self):
        for geom, said in (('<geom type="mesh" mesh="m"/>', "a mesh"), ('<geom type="capsule" size="0.1"/>', "2 positive numbers"),
                           ('<geom size="-1"/>', "1 positive numbers"), ('<geom size="1e200"/>', "computed with"),
                           ('<geom size="1e-200" mass="1"/>', "computed with"), ('<geom size="1" density="-1"/>', "≥ 0"),
                           ('<geom type="capsule" size="0.1" fromto="0 0 0 0 0 0"/>', "differ")):
            path = self.write("model.xml", MODEL.format(inside=geom, compiler="", density=1000))
            self.assert_failure(run("import", path), 3, "model.xml:", said)

    def test_a_note_says_so(self):
        path = self.write("model.xml", MODEL.format(inside='<geom size="0.1"/>', compiler="", density=1000))
        self.assertIn("follows from 1 geom", run("import", path, "-o", self.path("x.yaml")).stdout)
        with open(self.path("x.yaml"), encoding="utf-8") as file:
            self.assertEqual(len(yaml.safe_load(file)["bodies"]), 1)


if __name__ == "__main__":
    unittest.main()
