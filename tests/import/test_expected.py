"""Imported files move with the efforts, forces and momenta that an independent reader and dynamics found for them."""

import json
import unittest

import numpy as np

from _spec import ImportCase, case, run


class Expected(ImportCase):
    def agrees(self, name, *arguments, mass):
        """Every sample to 1e-9 of the largest value of its kind."""
        with open(case(name + ".expected.json"), encoding="utf-8") as file:
            expected = json.load(file)
        spec = self.imported(*arguments)
        with self.moved(spec, expected["actuators"], expected["start"], expected["travel"], expected["T"]) as result:
            names = [one.decode() for one in result["actuator"][:]]
            order = [names.index(one) for one in expected["actuators"]]
            time = result["time"][:]
            found = {"tau": result["torque"][:, order], "F": result["shaking_force"][:], "N": result["shaking_moment"][:],
                     "com": result["com_position"][:]}
        for key, values in found.items():
            values = values.reshape(len(time), -1)
            scale = np.abs(values).max()
            for sample in expected["samples"]:
                row = int(np.argmin(np.abs(time - sample["t"])))
                self.assertAlmostEqual(time[row], sample["t"], places=12)
                wanted = np.array(sample[key])
                # planar: two components of a vector, the one of a moment
                if values.shape[1] == 1 and key == "N":
                    wanted = wanted[2:]
                wanted = wanted[:values.shape[1]] if key != "tau" else wanted
                self.assert_near(values[row], wanted, scale, f"{name}: {key} at {sample['t']}")
        check = json.loads(run("check", self.path("moved.yaml"), "--json").stdout)
        self.assertEqual(check["degrees_of_freedom"], expected["dof"])
        self.assertAlmostEqual(check["total_mass"] / mass, 1, places=9)

    def test_a_tree_with_a_mimic_joint(self):
        self.agrees("panda", case("panda.urdf"), mass=16.822132)

    def test_a_closure_between_markers(self):
        self.agrees("five-bar", case("five-bar.urdf"), "--loops", case("five-bar.loops.yaml"), mass=104.283281225)

    def test_default_classes_and_connected_places(self):
        self.agrees("2f85", case("2f85.xml"), "--actuate",
                    "right_driver_joint,right_spring_link_joint,left_spring_link_joint", mass=0.12255886)

    def test_a_motor_and_places_in_the_world(self):
        self.agrees("chrono-slider-crank", case("chrono-slider-crank.yaml"), "--actuate", "ground_crank,ground_ball", mass=3.5)

    def test_natural_coordinates(self):
        self.agrees("mbse-pendulum3", case("mbse-pendulum3.yaml"), mass=6)


if __name__ == "__main__":
    unittest.main()
