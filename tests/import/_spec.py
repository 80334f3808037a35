"""An imported spec, moved as a file of expected numbers says."""

import os
import sys

import h5py
import numpy as np
import yaml

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from _program import Case, run  # noqa: E402  (the folder beside)

CASES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cases")


def case(name):
    return os.path.join(CASES, name)


class ImportCase(Case):
    def imported(self, *arguments):
        """The spec that an import writes, as YAML says it."""
        path = self.path("imported.yaml")
        done = run("import", *arguments, "-o", path, "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(path, encoding="utf-8") as file:
            return yaml.safe_load(file)

    def moved(self, spec, actuators, start, travel, duration=1.0, assembly=None):
        """Time series of a run without friction and springs, along the cycloidal law."""
        spec = {key: value for key, value in spec.items() if key not in ("friction", "springs")}
        spec["actuators"] = list(actuators)
        if assembly is not None:
            spec["assembly"] = {**spec.get("assembly", {}), **assembly}
        poses = [dict(zip(actuators, values)) for values in (start, np.add(start, travel))]
        spec["motion"] = {"duration": duration, "samples": 1001,
                          "from": {"joints": {k: float(v) for k, v in poses[0].items()}},
                          "to": {"joints": {k: float(v) for k, v in poses[1].items()}}}
        done = run("simulate", self.write("moved.yaml", yaml.safe_dump(spec, sort_keys=False)), "--trajectory", "cycloid",
                   "-o", self.path("out.h5"), "--force", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        return h5py.File(self.path("out.h5"), "r")

    def assert_near(self, found, expected, scale, what, tolerance=1e-9):
        found, expected = np.asarray(found, float), np.asarray(expected, float)
        self.assertLessEqual(np.abs(found - expected).max(), tolerance * max(scale, 1e-12), f"{what}: {found} {expected}")
