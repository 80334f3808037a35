"""One mechanism written in several systems of units: numbers for programs are the same SI numbers, text is in the units of the spec."""

import csv
import json
import math
import re
import unittest

from _program import Case, run

DEG = math.pi / 180
# name: the section `units`, SI values of length, mass, angle and force, and the names with which text shows moments, stiffness and the like
SYSTEMS = {
    "si": ("", dict(m=1, kg=1, rad=1, N=1), {}),
    "mm": ("units: {length: mm, mass: g, angle: deg, force: N}", dict(m=1e-3, kg=1e-3, rad=DEG, N=1),
           {"N": "N", "N m": "N mm", "kg": "g", "kg m^2": "g mm^2", "m": "mm", "rad": "deg", "N m/rad": "N mm/deg", "W": "W", "J": "J"}),
    "in": ("units: {length: in, mass: lb, angle: deg, force: lbf}", dict(m=0.0254, kg=0.45359237, rad=DEG, N=4.4482216152605),
           {"N": "lbf", "N m": "lbf in", "kg": "lb", "kg m^2": "lb in^2", "m": "in", "rad": "deg", "N m/rad": "lbf in/deg",
            "W": "lbf in/s", "J": "lbf in"}),
}
SPEC = """
name: arm with a slide
space: planar
{units}
gravity: [0, {gravity}]
ground: {{points: {{O: [0, 0]}}}}
bodies:
  link: {{mass: {m2}, com: [{l1}, 0], inertia: {j}, points: {{O: [0, 0], P: [{l2}, 0]}}}}
  slider: {{mass: {m1}, com: [{l3}, {l4}], inertia: {j2}, points: {{P: [0, 0], H: [{l1}, 0]}}}}
joints:
  R: {{type: revolute, connects: [ground.O, link.O]}}
  S: {{type: prismatic, connects: [link.P, slider.P], axis: [1, 0]}}
actuators: [R, S]
tool: slider.H
assembly: {{R: {a1}, S: {l3}}}
counterweights:
  cw: {{body: link, at: [{{free: [-{l2}, -{l3}]}}, 0], mass: {{free: [0, {m40}], start: {m1}}}}}
loads:
  cut: {{body: slider, at: H, force: [{f5}, 0], frame: world}}
springs:
  t: {{joint: R, stiffness: {k}, preload: {t1}}}
friction:
  R: {{coulomb: {t1}}}
motion: {{duration: 1, samples: 51, from: {{joints: {{R: {a1}, S: {l3}}}}}, to: {{joints: {{R: {a2}, S: {l1}}}}}}}
trajectories:
  cycloid: {{law: cycloidal, drive: joints}}
tolerances: {{link.mass: 1%, "link.com[0]": {l4}}}
design: {{minimize: [{{peak: "torque[R]", along: cycloid}}]}}
"""


def spec(system):
    units, si, _ = SYSTEMS[system]
    m, kg, rad, n = (si[u] for u in ("m", "kg", "rad", "N"))
    values = dict(gravity=-9.81 / m, m1=1.25 / kg, m2=2 / kg, m40=40 / kg, l1=0.2 / m, l2=0.5 / m, l3=0.05 / m, l4=0.002 / m,
                  j=0.03 / (kg * m * m), j2=0.004 / (kg * m * m), a1=0.3 / rad, a2=1.1 / rad, f5=5 / n, k=4 / (n * m / rad), t1=0.6 / (n * m))
    return SPEC.format(units=units, **{name: repr(value) for name, value in values.items()})


def numbers(value, path=()):
    """Every number of a JSON document with its path."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return
    if isinstance(value, (int, float)):
        yield path, value
        return
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        yield from numbers(item, (*path, key))


def rows(text, columns):
    """Rows of a table whose cells are separated by two blanks or more."""
    return [cells for cells in (re.split(r" {2,}", line.strip()) for line in text.splitlines()) if len(cells) == columns]


class Units(Case):
    @classmethod
    def setUpClass(cls):
        cls.commands = {
            "simulate": [], "simulate --at": ["--at", "start"], "check": [], "conditions": ["--goal", "static"], "tolerance": [],
            "equations": ["--at", "start"], "control": ["--controller", "computed-torque"],
        }

    def setUp(self):
        super().setUp()
        self.specs = {name: self.write(f"{name}.yaml", spec(name)) for name in SYSTEMS}

    def answer(self, command, system, *options):
        done = run(command.split()[0], self.specs[system], *self.commands.get(command, []), *options)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.stdout

    def test_json_is_the_same_si_whatever_the_units(self):
        for command in self.commands:
            if command == "control":  # an integrator chooses other steps for other roundings
                continue
            expected = dict(numbers(json.loads(self.answer(command, "si", "--json"))))
            for system in ("mm", "in"):
                found = dict(numbers(json.loads(self.answer(command, system, "--json"))))
                self.assertEqual(expected.keys(), found.keys(), command)
                for path, value in expected.items():
                    # gaps of singular values are what rounding leaves, and a spring that is turned for ever has no largest torque
                    if any(word in str(path) for word in ("gap", "singular", "residual", "staying")):
                        continue
                    self.assertAlmostEqual(found[path], value, delta=1e-11 * abs(value) + 1e-10, msg=(command, system, path))

    def test_figures_are_the_si_ones_times_the_factor(self):
        table = rows(self.answer("simulate", "si", "--verbose"), 6)[1:]
        self.assertGreater(len(table), 10)
        for system in ("mm", "in"):
            names = SYSTEMS[system][2]
            found = {cells[0]: cells for cells in rows(self.answer("simulate", system, "--verbose"), 6)}
            si = {row["quantity"]: row for row in json.loads(self.answer("simulate", system, "--json"))["metrics"]}
            for quantity, unit, *_ in table:
                expected = names.get(unit) or unit.replace("m/", names["m"] + "/")
                self.assertEqual(found[quantity][1], expected, quantity)
                self.assertAlmostEqual(float(found[quantity][2]), si[quantity]["peak"] / self.factor(system, unit),
                                       delta=1e-5 * abs(float(found[quantity][2])) + 1e-9, msg=quantity)

    def factor(self, system, unit):
        """Of the unit that text shows in place of an SI unit."""
        si = SYSTEMS[system][1]
        value = {"N": si["N"], "N m": si["N"] * si["m"], "m/s": si["m"], "m/s^2": si["m"], "1": 1, "rad": si["rad"], "kg": si["kg"]}
        energy = si["N"] * si["m"] if system == "in" else 1
        return {**value, "W": energy, "J": energy}[unit]

    def test_si_can_be_asked_for(self):
        for command in self.commands:
            if command == "control":
                continue
            expected = self.answer(command, "si")
            found = self.answer(command, "mm", "--units", "si")
            # but for lines to paste into the spec, and what rounding leaves
            drop = r"(?m)^.*(assembly:|gap | at rest$).*\n"
            self.assertEqual(re.sub(drop, "", found), re.sub(drop, "", expected), command)

    def test_a_dimension_has_one_unit_in_a_text(self):
        for system, foreign in (("mm", r"\b(rad|kg|m|N m|in|lb)\b"), ("in", r"\b(rad|kg|m|N|N m|mm|g|J|W)\b")):
            for command in self.commands:
                text = self.answer(command, system)
                units = set(re.findall(r"\[([^\]\d%]+)\]", text)) - {"R", "S", "x", "y", "t"}
                for row in (*rows(text, 6), *rows(text, 3)):
                    units.add(row[1])
                for unit in units:
                    for word in re.findall(r"[A-Za-z]+", unit):
                        self.assertIsNone(re.fullmatch(foreign, word) if unit != "at" else None, (command, system, unit))

    def test_what_remains_is_stated_in_the_units_of_the_spec(self):
        text = self.answer("conditions", "mm")
        self.assertIn("(k = 69.8132 N mm/deg, preload = ", text)
        self.assertIn("load cut (fx = 5 N)", text)
        self.assertIn("load cut (fx = 1.12404 lbf)", self.answer("conditions", "in"))

    def test_a_proof_of_impossibility_is_in_the_units_of_the_spec(self):
        """4 lb at 6 in against at most 1 lb at 4 in: at least 20 lb in remain."""
        path = self.write("short.yaml", """
space: planar
units: {length: in, mass: lb, force: lbf, angle: deg}
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 4, com: [6, 0], inertia: 60, points: {A: [0, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
counterweights: {cw: {body: link, at: [-4, 0], mass: {free: [0, 1]}}}
actuators: [J]
design: {goal: force}
""")
        for options, bound in ((), "20 lb in"), (("--units", "si"), "0.23 kg m"):
            text = " ".join(run("design", path, *options).stdout.split())
            self.assertIn(f"link.mx + cw.mx = 0 cannot hold within the bounds: the left-hand side is at least {bound} ", text)
            self.assertEqual(text.count("cannot hold"), 1)

    def test_check_speaks_the_language_of_the_spec(self):
        text = self.answer("check", "mm")
        self.assertRegex(text, r"size +500 mm")
        self.assertRegex(text, r"total mass +4500 g")
        self.assertRegex(text, r"R = 17\.1887 deg, S = 50 mm")
        self.assertRegex(self.answer("check", "in"), r"size +19\.685 in")

    def test_a_design_has_units_and_writes_the_spec_in_its_own(self):
        results = {}
        for system in SYSTEMS:
            output = self.path(f"{system}-designed.yaml")
            done = run("design", self.specs[system], "-o", output)
            self.assertEqual(done.returncode, 0, done.stderr)
            results[system] = json.loads(run("design", self.specs[system], "--json").stdout)["free_numbers"]
            lines = [re.split(r" {2,}", line) for line in done.stdout.splitlines() if line.startswith("counterweights.")]
            si = SYSTEMS[system][1]
            for number, cells, unit in zip(results[system], lines, ("m", "kg")):  # a long path goes on in the next line
                factor = si[unit]
                self.assertTrue(number["path"].startswith(cells[0]), cells)
                self.assertEqual(cells[1], SYSTEMS[system][2].get(unit, unit))
                self.assertAlmostEqual(float(cells[5]), number["value"] / factor, delta=1e-5 * abs(number["value"] / factor))
            designed = json.loads(run("simulate", output, "--json").stdout)
            self.assertEqual(designed["outcome"]["status"], "done")
        for system in ("mm", "in"):
            for mine, expected in zip(results[system], results["si"]):
                self.assertAlmostEqual(mine["value"], expected["value"], delta=1e-5 * abs(expected["value"]))

    def test_files_for_programs_are_si(self):
        for system in ("si", "mm"):
            self.assertEqual(run("simulate", self.specs[system], "--csv", self.path(f"{system}.csv")).returncode, 0)
        with open(self.path("si.csv"), encoding="utf-8") as one, open(self.path("mm.csv"), encoding="utf-8") as two:
            first, second = list(csv.reader(one)), list(csv.reader(two))
        self.assertEqual(first[0], second[0])
        for a, b in zip(first[1:], second[1:]):
            for x, y in zip(a, b):
                self.assertAlmostEqual(float(x), float(y), delta=1e-11 * abs(float(x)) + 1e-10)

    def test_axes_of_a_plot_are_in_the_units_of_the_spec(self):
        def script(system, *options):
            return run("plot", self.specs[system], "--script", *options).stdout
        self.assertIn("[N mm]", script("mm", "--quantity", "torque[R]"))
        self.assertIn("[lbf in]", script("in", "--quantity", "torque[R]"))
        self.assertIn("[N m]", script("mm", "--quantity", "torque[R]", "--units", "si"))
        self.assertIn("x [mm]", script("mm", "--path"))
        stored = self.path("run.h5")
        self.assertEqual(run("simulate", self.specs["mm"], "-o", stored).returncode, 0)
        self.assertIn("[N mm]", run("plot", stored, "--script", "--quantity", "torque[R]").stdout)
        both = run("plot", self.specs["mm"], self.specs["in"], "--script", "--quantity", "torque[R]").stdout
        self.assertIn("[N m]", both)  # no units in common

    def test_the_page_of_a_report_has_si_data_and_the_units_to_show(self):
        pages = {}
        for system, options in (("si", ()), ("mm", ()), ("mm", ("--units", "si"))):
            output = self.path("page.html")
            done = run("report", self.specs[system], "-t", "cycloid", "--samples", "11", "-o", output, "--force", *options)
            if done.returncode == 5:
                self.skipTest("built without the page")
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(output, encoding="utf-8") as file:
                data = re.search(r'id="balance-data">(.*?)</script>', file.read(), re.DOTALL).group(1)
            pages[system, bool(options)] = json.loads(data)
        shown = pages["mm", False]["units"]
        self.assertEqual((shown["m"], shown["kg"]), ({"name": "mm", "value": 0.001}, {"name": "g", "value": 0.001}))
        self.assertAlmostEqual(shown["rad"]["value"], DEG)
        self.assertEqual(pages["mm", True]["units"], {})
        self.assertEqual(pages["si", False]["units"], {})
        self.assertEqual(pages["mm", False]["number_units"], {"counterweights.cw.at[0]": "m", "counterweights.cw.mass": "kg",
                                                              "bodies.link.mass": "kg", "bodies.link.com[0]": "m"})
        peaks = [{m["quantity"]: m["peak"] for m in page["trajectories"][0]["before"]["metrics"]} for page in pages.values()]
        for other in peaks[1:]:
            for quantity, peak in peaks[0].items():
                self.assertAlmostEqual(other[quantity], peak, delta=1e-9 * abs(peak) + 1e-9)

    def test_inches_without_a_unit_of_force_are_shown_with_pounds(self):
        text = spec("in").replace(", force: lbf", "")
        done = run("simulate", self.write("poundals.yaml", text))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"shaking_force +lbf ")

    def test_other_words_are_refused(self):
        self.assert_failure(run("check", self.specs["mm"], "--units", "SI"), 2, "--units", "nearest is 'si'")


if __name__ == "__main__":
    unittest.main()
