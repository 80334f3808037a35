"""Numbers in the wrong unit are legal, and are warned of."""

import glob
import json
import os
import re
import unittest

from _program import CONFIGS, Case, config, run
from _sampling import WHOLE, draw, traits_of

# What a unit of length becomes that is read a thousand times as large.
THOUSAND = {"m": "km", "mm": "m", "um": "mm"}


def configs():
    return sorted(glob.glob(os.path.join(CONFIGS, "*.yaml")))


def enlarged(text):
    """The spec with every length a thousand times as long, by its unit; nothing if that cannot be said."""
    unit = re.search(r"^units:.*?length: *(\w+)", text, flags=re.MULTILINE)
    if unit is None:
        return None if re.search(r"^units:", text, flags=re.MULTILINE) else "units: {length: km}\n" + text
    return text[:unit.start(1)] + THOUSAND[unit[1]] + text[unit.end(1):] if unit[1] in THOUSAND else None


class Plausible(Case):
    def check(self, spec):
        return run("check", spec, "--json")

    def test_no_mechanism_of_the_project_is_warned_of_and_each_a_thousand_times_as_large_is(self):
        tried = 0
        for spec in draw("plausible configs", configs(), 0.2, traits_of):
            with open(spec, encoding="utf-8") as file:
                text = file.read()
            if "include:" in text or "catalogue:" in text:  # what they name is not beside the enlarged spec
                continue
            done = self.check(spec)
            self.assertEqual([w for w in json.loads(done.stdout)["warnings"] if "largest dimension" in w or " turns" in w or "gravity" in w or "inertia" in w], [], spec)
            large = enlarged(text)
            if large is None:
                continue
            tried += 1
            done = self.check(self.write("large.yaml", large))
            self.assertIn("the mechanism's largest dimension is", done.stderr, spec)
        self.assertGreater(tried, 20 if WHOLE else 5)

    def test_the_size_is_shown(self):
        done = run("check", os.path.join(CONFIGS, "3rrr.yaml"))
        size = re.search(r"^size +(\S+) m, its largest dimension$", done.stdout, flags=re.MULTILINE)
        self.assertTrue(size, done.stdout)
        self.assertAlmostEqual(float(size[1]), json.loads(self.check(os.path.join(CONFIGS, "3rrr.yaml")).stdout)["size"], places=5)

    def test_an_inertia_of_square_millimetres_is_warned_of(self):
        spec = self.write("inertia.yaml", config("four-bar.yaml", (r"inertia: *\"[^\"]+\"", "inertia: 1000")))
        self.assertRegex(run("check", spec).stderr, r"bodies\.\w+: an inertia of 1000 kg m\^2 with a mass of \S+ kg is that of a body of more than")

    def test_degrees_taken_for_radians_are_warned_of(self):
        spec = self.write("degrees.yaml", config("four-bar.yaml", (r"from: *\{joints: \{(\w+): [^}]+\}\}", "from: {joints: {A: 90}}")))
        self.assertIn("A is 90 rad, 14.3 turns: is it in degrees", run("check", spec).stderr)


if __name__ == "__main__":
    unittest.main()
