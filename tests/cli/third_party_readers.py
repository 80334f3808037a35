"""The programs that users open result files with open them."""

import os
import subprocess
import unittest
import warnings

import h5py
import netCDF4
import numpy
import xarray

from _program import CONFIGS, SPEC, Case, run

LABELS = {"coordinate", "joint", "actuator", "axis", "quaternion", "coordinate_unit", "actuator_unit"}


class Readers(Case):
    def result(self, spec=SPEC, *options):
        done = run("simulate", spec, "-t", "cycloid", "--samples", "21", "-o", self.path("a.h5"), *options)
        self.assert_quiet_success(done)
        return self.path("a.h5")

    def test_h5py(self):
        with h5py.File(self.result()) as result:
            self.assertEqual(result.attrs["Conventions"], "balance-1")
            self.assertEqual(result["joint_force"].shape, (21, 9, 2))
            self.assertEqual([d[0].name for d in result["joint_force"].dims], ["/time", "/joint", "/axis"])
            self.assertEqual(list(result["actuator"].asstr()), ["A1", "A2", "A3"])
            self.assertEqual(result["shaking_force"].attrs["units"], "N")
            for name, item in [*result.items(), *result["metrics"].items()]:
                if isinstance(item, h5py.Dataset):
                    self.assertIsInstance(item.attrs["units"], str, name)
                    self.assertTrue(item.attrs["long_name"], name)
                    for dimension in item.dims if not item.is_virtual and "CLASS" not in item.attrs else []:
                        self.assertEqual(len(dimension), 1, name)

    def test_netcdf4(self):
        for options in ([], ["--compress"]):
            with netCDF4.Dataset(self.result(SPEC, *options, "--force")) as result:
                self.assertEqual({name: len(d) for name, d in result.dimensions.items()},
                                 {"time": 21, "coordinate": 9, "joint": 9, "actuator": 3, "axis": 2})
                self.assertEqual(result["joint_force"].dimensions, ("time", "joint", "axis"))
                self.assertEqual(result["joint_moment"].dimensions, ("time", "joint"))
                self.assertEqual(list(result["axis"][:]), ["x", "y"])
                self.assertEqual(result["metrics"]["peak"].dimensions, ("quantity",))
                self.assertEqual(result["metrics"]["energy"].dimensions, ())
                for variable in result.variables.values():
                    self.assertTrue(variable.units and variable.long_name)
                    if variable.name not in LABELS:
                        self.assertTrue(numpy.isfinite(variable[:]).all(), variable.name)

    def test_netcdf4_reads_spatial_mechanisms_with_joints_of_several_coordinates(self):
        with netCDF4.Dataset(self.result(os.path.join(CONFIGS, "stewart.yaml"))) as result:
            self.assertEqual(result["tool_orientation"].dimensions, ("time", "quaternion"))
            self.assertEqual(result["joint_moment"].dimensions, ("time", "joint", "axis"))
            self.assertEqual(result["joint_position"].units, "mixed")
            self.assertEqual(set(result["coordinate_unit"][:]), {"rad", "m"})
            self.assertGreater(len(result.dimensions["coordinate"]), len(result.dimensions["joint"]))

    def test_xarray(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with xarray.open_dataset(self.result(), engine="netcdf4") as result:
                self.assertEqual(set(result.coords), {"time", "coordinate", "joint", "actuator", "axis"})
                self.assertEqual(result.torque.sel(actuator="A2").dims, ("time",))
                self.assertEqual(float(result.time[-1]), 0.1)
                self.assertEqual(result.shaking_moment.attrs["units"], "N m")
            with xarray.open_dataset(self.path("a.h5"), group="metrics", engine="netcdf4") as metrics:
                peak = float(metrics.peak.sel(quantity="shaking_force"))
        with h5py.File(self.path("a.h5")) as result:
            largest = numpy.linalg.norm(result["shaking_force"], axis=1).max()
        self.assertAlmostEqual(peak, largest, places=9)

    def test_ncdump_and_h5dump(self):
        path = self.result()
        for tool in (["ncdump", path], ["h5dump", path], ["h5ls", "-r", path]):
            done = subprocess.run(tool, capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), tool)
            self.assertIn("shaking_force", done.stdout)
        header = subprocess.run(["ncdump", "-k", path], capture_output=True, text=True, check=True).stdout
        self.assertEqual(header, "netCDF-4\n")

    def test_the_order_of_creation_is_kept(self):
        with h5py.File(self.result()) as result:
            names = []
            result.id.links.visit(lambda name: names.append(name.decode()), idx_type=h5py.h5.INDEX_CRT_ORDER)
        self.assertEqual(names[:2], ["time", "coordinate"])
        self.assertLess(names.index("joint_position"), names.index("com_position"))


if __name__ == "__main__":
    unittest.main()
