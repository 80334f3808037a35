"""`balance equations --speeds` without a pose, with loops: evaluated, and held against the matrices at a pose."""

import json
import os
import re
import shutil
import subprocess
import unittest

import numpy as np
from _formulas import parse
from _program import CONFIGS, Case, run

FIVE_BAR = os.path.join(CONFIGS, "5r.yaml")
FOUR_BAR = os.path.join(CONFIGS, "four-bar.yaml")
SLIDER_CRANK = os.path.join(CONFIGS, "slider-crank.yaml")
PLANAR = os.path.join(CONFIGS, "3rrr.yaml")


class SpeedsWithLoops(Case):
    def sheet(self, spec, speeds, *call):
        done = run("equations", spec, "--only", "speeds", "--speeds", speeds, "--json", *call)
        self.assert_quiet_success(done)
        return json.loads(done.stdout)

    def evaluated(self, told, values):
        """The formulas one after the other: a name that none before defines is an error here."""
        known = dict(values)
        for section in told["sections"]:
            self.assertFalse(section["too_long"], section["meaning"])
            for formula in section["formulas"]:
                expression = parse(formula["formula"])
                known[formula["name"]] = float(expression.subs({s: known[s.name] for s in expression.free_symbols}))
            known.update({name: 0.0 for name in section["zero"]})
        return known

    def hold(self, spec, speeds, pose="start", call=(), tolerance=1e-9):
        """M, w, z and what follows from the independent speeds, at a pose. Both are computed apart, with other numbers of terms:
        the tolerance is the one with which the program compares them at other poses."""
        told = self.sheet(spec, speeds, "--all", *call)
        self.assertLess(told["checked"]["error"], tolerance)
        self.assertGreater(told["checked"]["states"], 0)
        done = run("equations", spec, "--at", pose, "--only", "inertia,velocity,gravity", "--speeds", speeds, "--json", *call)
        self.assert_quiet_success(done)
        at = json.loads(done.stdout)
        own = at["in_speeds"]
        values = dict(told["symbols"])
        values.update({name.replace(".", "_"): value for name, value in at["configuration"].items()})
        found = self.evaluated(told, values)
        n = len(own["independent"])
        self.assertEqual(np.array(own["M"]).shape, (n, n))

        def close(name, expected, scale, reference):
            self.assertAlmostEqual(found[name] / scale, expected / scale, delta=tolerance, msg=f"{name} of {reference}")
        M, w = np.array(own["M"]), np.array(own["D"])
        z_scale = max(1e-300, np.abs(own["z"]["sum"]).max(), np.abs(own["rates"]).max() * np.abs(at["z"]["sum"]).max())
        for i in range(n):
            close(f"z{i + 1}", own["z"]["sum"][i], max(z_scale, 1e-12), spec)
            for j in range(i, n):
                close(f"M{i + 1}{j + 1}", M[i][j], np.abs(M).max(), spec)
                for k in range(n):
                    close(f"w{k + 1}{i + 1}{j + 1}", w[k][i][j], max(np.abs(w).max(), np.abs(M).max()), spec)
        C, c = np.array(own["C"]), np.array(own["c"])
        for row, speed in enumerate(own["speeds"]):
            if speed in own["independent"]:
                continue
            for i in range(n):
                close(f"Cbar{row + 1}{i + 1}", C[row][i], np.abs(C).max(), spec)
                for j in range(i, n):
                    close(f"cbar{row + 1}{i + 1}{j + 1}", c[row][i][j], max(np.abs(c).max(), np.abs(C).max()), spec)
        return told, found

    def test_the_tool_of_the_5r(self):
        told, found = self.hold(FIVE_BAR, "x: tool.x, y: tool.y")
        self.assertIn("Delta_W", found)
        notes = " ".join(told["notes"])
        self.assertIn("where Delta_W vanishes, the speeds do not determine the motion", notes)

    def test_the_inertia_that_the_5rs_tool_feels(self):
        """The kinetic energy is the same in both speeds: p M p = q' M' q' with p = W q'."""
        _, found = self.hold(FIVE_BAR, "x: tool.x, y: tool.y")
        done = json.loads(run("equations", FIVE_BAR, "--at", "start", "--only", "inertia", "--json").stdout)
        W = np.array([[found["Wbar11"], found["Wbar12"]], [found["Wbar21"], found["Wbar22"]]])
        M = np.array([[found["M11"], found["M12"]], [found["M12"], found["M22"]]])
        np.testing.assert_allclose(W.T @ M @ W, done["M"], rtol=1e-10)

    def test_a_point_of_the_four_bars_coupler(self):
        for speeds in ("v: coupler.E.x", "v: coupler.E.u", "w: coupler.angle", "x: com.x", "v: {coupler.E.y: 2, A: 0.3}"):
            self.hold(FOUR_BAR, speeds)

    def test_the_platform_of_the_3rrr(self):
        self.hold(PLANAR, "x: tool.x, y: tool.y, w: tool.angle")

    def test_the_slide_of_a_slider_crank(self):
        """At the dead centres the slide stands: C31, its rate per that of the crank, vanishes."""
        told, found = self.hold(SLIDER_CRANK, "s: S")
        self.assertIn("where C31 vanishes, the speeds do not determine the motion", " ".join(told["notes"]))
        self.assertAlmostEqual(found["M11"] * found["C31"] ** 2, found["Mhat11"], delta=1e-15)
        still = run("equations", SLIDER_CRANK, "--at", "A=0,B=0,S=0.4", "--only", "inertia", "--speeds", "s: S")
        self.assertEqual(still.returncode, 4)

    def test_a_redundant_set_of_the_5r(self):
        told, found = self.hold(FIVE_BAR, "x: tool.x, y: tool.y, a: A1")
        self.assertIn("a follow: Cbar_ij times speed j", told["sections"][-1]["meaning"])
        # the rate of A1 is V's row of it
        self.assertAlmostEqual(found["Cbar31"], found["V11"], delta=1e-12)
        self.hold(FIVE_BAR, "a: A1, x: tool.x, y: tool.y, again: {tool.x: 2}")

    def test_a_balanced_mechanism_whose_weights_cancel(self):
        """z is the round-off of terms that cancel: these are its scale, not what is left of them."""
        spec = os.path.join(CONFIGS, "published", "forbal2-published.yaml")
        told = self.sheet(spec, "x: tool.x, y: tool.y")
        self.assertLess(told["checked"]["error"], 1e-9)

    def test_factors_that_depend_on_the_pose(self):
        self.hold(FIVE_BAR, 'p: {A1: "cos(A1)", tool.x: 1}, y: tool.y')

    def test_loops_in_space(self):
        for name, speeds in (("spatial-slider-crank", "s: S"), ("four-bar-in-space", "v: coupler.E.y"), ("four-bar-in-space", "w: coupler.rz"),
                             ("rccc", "v: coupler.C.x"), ("bricard", "v: tool.x")):
            self.hold(os.path.join(CONFIGS, name + ".yaml"), speeds)

    def test_other_independent_coordinates_give_the_same_equations(self):
        _, one = self.hold(FIVE_BAR, "x: tool.x, y: tool.y")
        _, other = self.hold(FIVE_BAR, "x: tool.x, y: tool.y", call=("--independent", "A1,B1"))
        for name in ("M11", "M12", "M22", "w111", "w122", "w212", "z1", "z2"):
            self.assertAlmostEqual(one[name], other[name], delta=1e-9 * max(1, abs(one[name])))

    def test_nothing_is_defined_twice(self):
        """With all sections, `speeds` refers to what `solved` and `reduced` have defined."""
        done = run("equations", FIVE_BAR, "--speeds", "x: tool.x, y: tool.y", "--json")
        self.assert_quiet_success(done)
        told = json.loads(done.stdout)
        names = {s["section"]: [f["name"] for f in s["formulas"]] for s in told["sections"]}
        self.assertIn("Mhat11", names["reduced"])
        self.assertNotIn("Mhat11", names["speeds"])
        self.assertFalse(set(names["speeds"]) & (set(names["reduced"]) | set(names["solved"])))
        self.assertLess(told["checked"]["error"], 1e-9)

    def test_formulas_share_no_name_with_parameters(self):
        with open(FIVE_BAR) as file:
            text = file.read()
        for name in ("Mhat11", "Delta_W", "V11", "N111", "H111"):
            spec = self.write("named.yaml", text.replace("a11", name))
            done = run("equations", spec, "--only", "speeds", "--speeds", "x: tool.x, y: tool.y", "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertLess(json.loads(done.stdout)["checked"]["error"], 1e-9)

    def test_too_long_a_case_says_so(self):
        done = run("equations", os.path.join(CONFIGS, "stewart.yaml"), "--only", "speeds", "--speeds",
                   "x: tool.x, y: tool.y, z: tool.z, a: tool.rx, b: tool.ry, c: tool.rz")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("terms", done.stdout)

    def test_what_cannot_be_is_refused(self):
        done = run("equations", FIVE_BAR, "--only", "speeds", "--speeds", "x: P, y: A1")
        self.assertEqual(done.returncode, 4)
        self.assertIn("closes a loop", done.stderr)
        done = run("equations", FIVE_BAR, "--only", "speeds", "--speeds", "x: tool.x, y: {tool.x: 2}")
        self.assertEqual(done.returncode, 4)
        self.assertIn("the speeds do not determine the motion", done.stderr)

    def test_a_speed_that_the_loops_keep_at_zero_is_named(self):
        """A parallelogram's coupler does not turn; what is left of it is round-off, which no formula should divide by."""
        done = run("equations", os.path.join(CONFIGS, "parallelogram.yaml"), "--only", "speeds", "--speeds", "w: coupler.angle")
        self.assertEqual(done.returncode, 4)
        self.assertIn("the speed w is zero wherever the loops close", done.stderr)

    def latex(self, *call):
        done = run("equations", *call, "--only", "speeds", "--latex")
        self.assert_quiet_success(done)
        return done.stdout

    def test_latex(self):
        text = self.latex(FIVE_BAR, "--speeds", "x: tool.x, y: tool.y, a: A1")
        self.assertEqual(text.count("{"), text.count("}"))
        for words in (r"\hat M_{11} = ", r"\bar W_{11} = ", r"\Delta_{W} = ", r"\bar C_{31} = ", r"\bar c_{311} = "):
            self.assertIn(words, text)
        self.assertIsNone(re.search(r"(?<!\\)\b(Delta|[A-Za-z]?(tilde|bar|hat))(?=[\d_{])", re.sub("%.*", "", text)))

    @unittest.skipUnless(shutil.which("pdflatex"), "no TeX")
    def test_tex_takes_the_formulas(self):
        with open(self.path("page.tex"), "w") as file:
            file.write("\\documentclass{article}\\usepackage{amsmath}\\begin{document}\n")
            file.write(self.latex(FIVE_BAR, "--speeds", "x: tool.x, y: tool.y, a: A1"))
            file.write(self.latex(PLANAR, "--speeds", "x: tool.x, y: tool.y, w: tool.angle", "--all"))
            file.write("\\end{document}\n")
        done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"], text=True, check=False,
                              cwd=os.path.dirname(self.path("page.tex")), capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout[-2000:])


if __name__ == "__main__":
    unittest.main()
