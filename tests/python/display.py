"""What a notebook shows: tables with units in HTML and LaTeX, of every spec, with nothing of a spec's text as markup; and tables for pandas."""

import html.parser
import os
import subprocess
import unittest

import numpy

import balance_mechanisms as bm

from _module import CONFIGS, Case, config
from _sampling import draw

ARM = """
name: 'arm <b>& 50 % of $_#^~\\{}'
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 2, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0], E: [0.2, 0]}}
joints:
  A_1: {type: revolute, connects: [ground.O, upper.A]}
actuators: [A_1]
tool: upper.E
counterweights: {cw: {body: upper, at: [{free: [-0.3, -0.1]}, 0], mass: {free: [0, 4]}}}
motion: {duration: 1, samples: 11, from: {joints: {A_1: 0}}, to: {joints: {A_1: 1}}}
design: {goal: static, minimize: added-mass}
"""
FRONT = ARM.replace("goal: static, minimize: added-mass", "front: [added-mass, {rms: torque, along: cycloid}]")


class Reader(html.parser.HTMLParser):
    """Cells of all tables by row; raises for tags that are not closed in order, or are none of ours."""

    def __init__(self, text):
        super().__init__()
        self.open, self.rows, self.text = [], [], ""
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        assert tag in ("table", "caption", "thead", "tbody", "tr", "th", "td", "p", "pre"), tag
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.text += data
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def find_row(shown, first):
    return next(row for row in Reader(shown._repr_html_()).rows if row[0] == first)


def everything(spec):
    """All that a notebook can show of a spec."""
    yield spec
    yield spec.mechanism
    for goal in ("force", "static"):
        try:
            yield spec.conditions(goal)
        except bm.MechanismError:
            pass
    for trajectory in spec.trajectories[:1]:
        try:
            yield spec.simulate(trajectory["name"], samples=5)
            yield spec.state("start", trajectory=trajectory["name"])
        except (bm.MechanismError, ValueError):
            pass


class Shown(Case):
    def test_of_all_specs_every_row_is_complete(self):
        names = sorted(name for name in os.listdir(CONFIGS) if name.endswith(".yaml"))
        for name in draw("specs shown", names, 0.1):
            for shown in everything(bm.load(config(name))):
                with self.subTest(name, shown=shown):
                    rows = Reader(shown._repr_html_()).rows
                    self.assertTrue(rows)
                    self.assertTrue(all(len(row) >= 3 for row in rows), rows)
                    text = shown._repr_latex_()
                    self.assertEqual(text.count(r"\begin{"), text.count(r"\end{"))

    def test_a_name_is_text_and_no_markup(self):
        spec = bm.load(ARM)
        design = spec.design(seed=1)
        for shown in (spec, spec.mechanism, design, spec.conditions(), design.after["cycloid"], bm.load(FRONT).front(seed=1), spec.check()):
            self.assertIn("arm <b>& 50 %", Reader(shown._repr_html_()).text)
            self.assertNotIn("<b>", shown._repr_html_())

    def test_tex_takes_what_is_shown(self):
        spec = bm.load(ARM)
        design = spec.design(seed=1)
        shown = [spec, design, spec.conditions(), design.after["cycloid"], bm.load(FRONT).front(seed=1), bm.load(config("3rrr.yaml")), *spec.conditions().conditions]
        text = "\n\n".join(one._repr_latex_() for one in shown)
        with open(self.path("shown.tex"), "w", encoding="utf-8") as file:
            file.write("\\documentclass{article}\n\\usepackage[utf8]{inputenc}\n\\usepackage{amsmath}\n\\begin{document}\n" + text + "\n\\end{document}\n")
        done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "shown.tex"], cwd=self.folder, capture_output=True, text=True,
                              errors="replace", check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-1500:])

    def test_of_a_run_the_figures_with_units(self):
        run = bm.load(config("scara.yaml")).simulate("cycloid", samples=11)
        self.assertEqual(find_row(run, "quantity")[:3], ["quantity", "unit", "peak"])
        for name in ("torque[J1]", "force[J3]", "com_acceleration"):
            unit, peak = run.metrics[name].unit, run.metrics[name].peak
            self.assertEqual(find_row(run, name)[1:3], [unit.replace("^2", "²"), f"{peak:.6g}"])
        state = bm.load(config("rr.yaml")).state({"R1": 0.3, "R2": 0.4})
        self.assertEqual(find_row(state, "torque[R1]"), ["torque[R1]", "N m", f"{state['torque[R1]'][0]:.6g}"])

    def test_of_a_design_the_numbers_with_units(self):
        design = bm.load(ARM).design(seed=1)
        table = design.to_pandas()
        for path, unit in (("counterweights.cw.mass", "kg"), ("counterweights.cw.at[0]", "m")):
            self.assertEqual(find_row(design, path)[1], unit)
            self.assertEqual(table.loc[path, "unit"], unit)
            self.assertEqual(find_row(design, path)[-1], f"{design.values[path]:.6g}")
            self.assertEqual(table.loc[path, "value"], design.values[path])

    def test_of_a_front_the_points_as_they_are_counted(self):
        front = bm.load(config("four-bar-front.yaml")).front()
        self.assertIn("rms of shaking_force along steady [N]", find_row(front, "index"))
        for index, point in enumerate(front.points):
            self.assertEqual(find_row(front, str(index))[1:3], [f"{value:.6g}" for value in point["values"]])
        units = front.to_pandas().attrs["units"]
        self.assertEqual(units["rms of shaking_moment along steady [N m]"], "N m")
        self.assertEqual(units["counterweights.cw1.mass"], "kg")

    def test_of_conditions_the_program_s_latex(self):
        conditions = bm.load(config("5r.yaml")).conditions("static")
        self.assertEqual(conditions._repr_latex_(), self.latex("conditions", config("5r.yaml"), "--goal", "static"))
        for k, one in enumerate(conditions.conditions):
            self.assertEqual(find_row(conditions, str(k + 1))[1:3], [one.text, "yes" if one.met else "no"])
            self.assertIn(one.latex, one._repr_latex_())

    def test_of_an_import_its_findings(self):
        imported = bm.import_(os.path.join(os.path.dirname(__file__), "..", "import", "cases", "2f85.xml"))
        rows = Reader(imported._repr_html_()).rows[1:]
        self.assertEqual([row[2:] for row in rows], [[one["subject"], one["message"]] for one in imported.findings])

    def test_more_rows_than_a_summary_has_are_counted(self):
        run = bm.load(config("stewart.yaml")).simulate(samples=5)
        rows = Reader(run._repr_html_()).rows
        shown = len(rows) - 2  # heads, and the last row
        self.assertEqual(rows[-1][0], f"… {len(run.metrics) - shown} more")


class Tables(Case):
    def test_a_run_has_the_columns_units_of_its_dataset(self):
        for name in ("scara.yaml", "3rrr.yaml", "delta.yaml"):
            run = bm.load(config(name)).simulate("cycloid", samples=11)
            table, data = run.to_pandas(), run.to_xarray()
            units = table.attrs["units"]
            self.assertEqual(list(units), ["time", *table.columns])
            self.assertEqual(units["time"], "s")
            self.assertEqual(table.attrs["trajectory"], "cycloid")
            for column in table.columns:
                numpy.testing.assert_array_equal(table[column], run[column])
                quantity = column.split("[")[0].split(".")[0]
                if quantity in data and data[quantity].attrs["units"] != "mixed":
                    self.assertEqual(units[column], data[quantity].attrs["units"], column)

    def test_a_slide_has_units_of_length(self):
        units = bm.load(config("scara.yaml")).simulate("cycloid", samples=11).to_pandas().attrs["units"]
        self.assertEqual([units[f"joint_velocity[{joint}]"] for joint in ("J2", "J3")], ["rad/s", "m/s"])
        self.assertEqual([units[name] for name in ("torque[J2]", "force[J3]")], ["N m", "N"])

    def test_the_older_name_gives_the_same_table(self):
        spec = bm.load(config("rr.yaml"))
        run = spec.simulate(samples=11)
        self.assertTrue(run.to_dataframe().equals(run.to_pandas()))
        self.assertTrue(run.metrics_to_dataframe().equals(run.metrics_to_pandas()))
        conditions = spec.conditions("static")
        self.assertTrue(conditions.to_dataframe().equals(conditions.to_pandas()))


if __name__ == "__main__":
    unittest.main()
