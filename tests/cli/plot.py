"""Pictures: what is in them, their sizes, and what is said when they cannot be drawn."""

import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

from _program import CONFIGS, SPEC, Case, run
from _sampling import draw, traits_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
SVG = "{http://www.w3.org/2000/svg}"


ARM_WITH_A_FREE_LENGTH = """\
name: arm
space: planar
bodies: {arm: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {O: [0, 0], T: [{free: [0.4, 0.6], start: 0.5}, 0]}}}
joints: {J: {type: revolute, connects: [ground.origin, arm.O]}}
actuators: [J]
tool: arm.T
counterweights: {cw: {on: arm, at: T, mass: 1}}
trajectories: {swing: {law: cycloidal, drive: joints, duration: 1, samples: 21, from: {joints: {J: 0}}, to: {joints: {J: 1}}}}
design: {minimize: {peak: torque, along: swing}}
"""


def setUpModule():
    global RUNS, CYCLOID, BANG, ARM
    RUNS = tempfile.TemporaryDirectory()
    CYCLOID, BANG, ARM = (os.path.join(RUNS.name, name) for name in ("cycloid.h5", "bang.h5", "arm.h5"))
    for spec, trajectory, file in ((SPEC, "cycloid", CYCLOID), (SPEC, "bang-bang", BANG),
                                   (os.path.join(CONFIGS, "spatial-rrr.yaml"), "cycloid", ARM)):
        assert run("simulate", spec, "-t", trajectory, "--samples", "101", "-q", "-o", file).returncode == 0


def tearDownModule():
    RUNS.cleanup()


def texts(svg):
    """What a reader reads in an SVG."""
    return ["".join(element.itertext()).strip() for element in ElementTree.parse(svg).iter(SVG + "text")]


@unittest.skipUnless(shutil.which("gnuplot"), "no gnuplot here")
class Pictures(Case):
    def plot(self, name, *arguments):
        done = run("plot", *arguments, "-o", self.path(name))
        self.assert_quiet_success(done)
        self.assertEqual(done.stdout, f"written: {self.path(name)}\n")
        return self.path(name)

    def test_an_svg_has_its_axes_units_and_legend(self):
        svg = self.plot("a.svg", CYCLOID, BANG, "--quantity", "shaking_force", "--quantity", "torque[A1]")
        found = texts(svg)
        for text in ("shaking force [N]", "torque A1 [N m]", "time [s]", "cycloid", "bang"):
            self.assertEqual(found.count(text), 1, found)
        self.assertEqual(ElementTree.parse(svg).find(SVG + "title").text, "shaking_force, torque[A1]")

    def test_labels_and_title_are_printed_as_they_are(self):
        strange = "a<b & 'c' `touch x` {/Bold d} e_f ²"
        svg = self.plot("a.svg", CYCLOID, BANG, "--quantity", "torque[A1]", "--label", strange, "--label", "$(touch x)",
                        "--title", strange)
        found = texts(svg)
        self.assertEqual(found.count(strange), 2, found)
        self.assertIn("$(touch x)", found)
        self.assertEqual(os.listdir(self.folder), ["a.svg"])

    def test_no_text_means_anything_to_gnuplot(self):
        """Quotes at either end, escapes, macros, marks of enhanced text."""
        odd = ["'x", "x'", "'", "''", "'\"", "\"'", "a'\\n", "'@x", "'_a^{b}", "'`touch x`", "a'b\\", "\\101'", "#'", "'%g"]
        labels = [word for label in odd for word in ("--label", label)]
        found = texts(self.plot("a.svg", *[CYCLOID] * len(odd), "--quantity", "shaking_force", *labels, "--title", "'x", "--size", "200x200"))
        for label in odd[1:]:
            self.assertEqual(found.count(label), 1, (label, found))
        self.assertEqual(found.count("'x"), 2)
        self.assertEqual(os.listdir(self.folder), ["a.svg"])
        self.assertEqual(ElementTree.parse(self.path("a.svg")).find(SVG + "title").text, "'x")

    def test_size_and_format(self):
        svg = ElementTree.parse(self.plot("a.svg", CYCLOID, "--size", "150x90")).getroot()
        self.assertEqual((svg.get("width"), svg.get("height")), ("150mm", "90mm"))
        with open(self.plot("a.png", CYCLOID, "--size", "127x50.8"), "rb") as file:
            head = file.read(24)
        self.assertEqual(head[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", head[16:]), (1500, 600))  # 300 pixels per inch
        with open(self.plot("a.pdf", CYCLOID, "--size", "127x50.8"), "rb") as file:
            pdf = file.read()
        self.assertTrue(pdf.startswith(b"%PDF-"))
        box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", pdf)
        self.assertAlmostEqual(float(box.group(1)), 360, delta=0.5)
        self.assertAlmostEqual(float(box.group(2)), 144, delta=0.5)

    def test_the_same_results_give_the_same_bytes(self):
        for suffix in ("svg", "pdf", "png"):
            with open(self.plot("a." + suffix, CYCLOID), "rb") as a, open(self.plot("b." + suffix, CYCLOID), "rb") as b:
                self.assertEqual(a.read(), b.read(), suffix)
        with open(self.path("a.pdf"), "rb") as file:
            self.assertIn(b"/CreationDate (D:19700101000000Z)", file.read())

    def test_a_jump_is_upright(self):
        done = run("plot", BANG, "--quantity", "com_acceleration.x", "--script")
        rows = [tuple(map(float, row.split())) for row in
                done.stdout.split("end_of_data\n")[1].splitlines()]
        self.assertEqual(len(rows), 102)
        self.assertEqual(rows[50][0], rows[51][0])
        self.assertAlmostEqual(rows[50][1], -rows[51][1], places=6)

    def test_paths_have_start_and_end(self):
        found = texts(self.plot("a.svg", CYCLOID, "--path"))
        for text in ("tool", "centre of mass", "start", "end", "x [m]", "y [m]"):
            self.assertEqual(found.count(text), 1, found)
        self.assertIn("z [m]", texts(self.plot("b.svg", ARM, "--path", "--plane", "yz")))

    def test_poses_are_drawn_along_the_path(self):
        found = texts(self.plot("a.svg", CYCLOID, "--path", "--poses"))
        for text in ("tool", "centre of mass", "start, t = 0 s", "t = 0.05 s", "end, t = 0.1 s", "x [m]", "y [m]"):
            self.assertEqual(found.count(text), 1, found)
        found = texts(self.plot("b.svg", CYCLOID, BANG, "--path", "--poses", "2"))
        for text in ("cycloid, start, t = 0 s", "bang, end, t = 0.1 s"):
            self.assertIn(text, found)
        found = texts(self.plot("c.svg", ARM, "--path", "--poses", "--plane", "isometric"))
        self.assertIn("isometric view, (y \N{MINUS SIGN} x)/\N{SQUARE ROOT}2 [m]", found)
        for suffix in ("png", "pdf"):
            self.assertGreater(os.path.getsize(self.plot("d." + suffix, CYCLOID, "--path", "--poses")), 5000)

    def test_the_number_of_poses_may_stand_anywhere(self):
        scripts = {run("plot", *words, "--path", "--script").stdout for words in (
            (CYCLOID, "--poses", "4"), ("--poses", "4", CYCLOID), ("--poses=4", CYCLOID), (CYCLOID, "--poses=4"))}
        self.assertEqual(len(scripts), 1)
        self.assertIn("t = 0.033, 0.067 s", scripts.pop())
        default = run("plot", "--path", "--poses", CYCLOID, "--script").stdout
        self.assertEqual(default, run("plot", CYCLOID, "--path", "--poses", "3", "--script").stdout)

    def test_runs_side_by_side(self):
        found = texts(self.plot("a.svg", CYCLOID, BANG, "--path", "--poses", "--side-by-side", "--label", "left", "--label", "right"))
        for text, times in (("left", 1), ("right", 1), ("start, t = 0 s", 1), ("x [m]", 2), ("y [m]", 1)):
            self.assertEqual(found.count(text), times, found)

    def test_poses_of_a_design_have_the_designed_mechanism(self):
        """The arm of 0.5 m becomes as short as its bounds allow."""
        spec = self.write("arm.yaml", ARM_WITH_A_FREE_LENGTH)
        self.assert_quiet_success(run("design", spec, "--h5", self.path("d.h5"), "-q"))
        lengths = []
        for when in ("before", "after"):
            done = run("plot", self.path(f"d.h5:{when}/swing"), "--path", "--poses", "1", "--script")
            self.assert_quiet_success(done)
            link = re.search(r"end_of_data\n(\S+) (\S+)\n(\S+) (\S+)\n\nend_of_data", done.stdout)
            x, y, u, v = map(float, link.groups())
            lengths.append(math.hypot(u - x, v - y))
        self.assertAlmostEqual(lengths[0], 0.5, places=6)
        self.assertAlmostEqual(lengths[1], 0.4, delta=0.011)

    def test_every_kind_of_mechanism_has_poses(self):
        specs = sorted(name for name in os.listdir(CONFIGS) if name.endswith(".yaml"))
        specs = [name for name in specs if "trajectories" in traits_of(os.path.join(CONFIGS, name))]
        for name in draw("mechanisms with poses", specs, 0.2, lambda name: traits_of(os.path.join(CONFIGS, name))):
            with self.subTest(name):
                done = run("plot", os.path.join(CONFIGS, name), "--path", "--poses", "2", "--script")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("nan", done.stdout)
                self.assertRegex(done.stdout, r"'end, t = [\d.]+ s'")

    def test_vectors_and_normalised_time(self):
        found = texts(self.plot("a.svg", ARM, "--quantity", "shaking_force", "--vectors", "both", "--x", "normalised"))
        for text in ("magnitude", "x", "y", "z", "time / duration"):
            self.assertIn(text, found)

    def test_orders_are_bars(self):
        spec = os.path.join(CONFIGS, "machines", "single-cylinder.yaml")
        done = run("simulate", spec, "--orders", "4", "--json", "-q")
        rows = json.loads(done.stdout)["orders"]["rows"]
        torque = {row["order"]: row["amplitude"] for row in rows if row["quantity"] == "torque[A]"}
        script = run("plot", spec, "--orders", "4", "--quantity", "torque", "--script").stdout
        # one rectangle for each order: its upper corners have the amplitude, its middle the order
        bars = [[tuple(map(float, pair)) for pair in re.findall(r"^ *([-+.e0-9]+)[ ,]+([-+.e0-9]+) *$", block, re.M)]
                for block in re.split(r"\n\s*\n|EOD|\be\b\n", script)]
        drawn = {round(sum(x for x, _ in set(bar)) / len(set(bar)), 6): max(y for _, y in bar) for bar in bars if len(set(bar)) == 4}
        for order, amplitude in torque.items():
            self.assertAlmostEqual(drawn[order], amplitude, delta=1e-5 * max(torque.values()))
        found = texts(self.plot("a.svg", spec, "--orders", "4", "--vectors", "both"))
        for text in ("order of A", "magnitude", "x", "y"):
            self.assertIn(text, found)

    def test_a_turning_moment_diagram_has_its_mean(self):
        found = texts(self.plot("a.svg", os.path.join(CONFIGS, "machines", "flywheel-press.yaml"), "--quantity", "torque", "--x", "angle"))
        self.assertIn("mean", found)
        self.assertIn("A [deg]", found)

    def test_runs_of_a_design_file_before_and_after(self):
        design = self.path("design.h5")
        spec = os.path.join(CONFIGS, "3rrr-proportional.yaml")
        self.assert_quiet_success(run("design", spec, "--h5", design, "-q"))
        found = texts(self.plot("a.svg", design + ":before/tool-bang", design + ":after/tool-bang", "--quantity",
                                "shaking_force"))
        self.assertIn("design before/tool-bang", found)
        self.assertIn("design after/tool-bang", found)

    def test_json_says_what_was_drawn(self):
        done = run("plot", CYCLOID, "-o", self.path("a.svg"), "--json")
        report = json.loads(done.stdout)
        self.assertEqual([panel["quantity"] for panel in report["panels"]], ["torque", "shaking_force", "shaking_moment"])
        self.assertEqual([line["label"] for line in report["panels"][0]["lines"]], ["A1", "A2", "A3"])
        self.assertEqual(report["files"], [self.path("a.svg")])

    def test_an_existing_picture_is_kept(self):
        svg = self.write("a.svg", "mine")
        self.assert_failure(run("plot", CYCLOID, "-o", svg), 5, svg)
        with open(svg, encoding="utf-8") as file:
            self.assertEqual(file.read(), "mine")
        self.assert_quiet_success(run("plot", CYCLOID, "-o", svg, "--force"))
        self.assertTrue(texts(svg))

    def test_settings_of_the_user_do_not_matter(self):
        self.write(".gnuplot", "set title 'mine'\n")
        environment = {**os.environ, "HOME": self.folder, "GNUTERM": "dumb", "LC_ALL": "de_DE.UTF-8"}
        self.assert_quiet_success(run("plot", CYCLOID, "-o", self.path("a.svg"), env=environment))
        with open(self.path("a.svg"), "rb") as a, open(self.plot("b.svg", CYCLOID), "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_figures_of_the_paper(self):
        def figures(*arguments):
            return subprocess.run([str(ROOT / "scripts" / "figures"), "--folder", self.folder, *arguments], text=True,
                                  capture_output=True, check=False)

        done = figures()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(sorted(p.name for p in pathlib.Path(self.folder).glob("*.svg")),
                         sorted(f"figure-{number}.svg" for number in range(4, 12)))
        self.assertIn("CoM guided, bang-bang", texts(self.path("figure-7.svg")))
        done = figures("10", "--format", "pdf")
        self.assertIn("figure-10.pdf: shaking force", done.stdout)
        self.assertEqual(len(list(pathlib.Path(self.folder).glob("*.pdf"))), 1)
        self.assertEqual(figures("12").returncode, 2)


class Mistakes(Case):
    def test_wrong_usage(self):
        svg = self.path("a.svg")
        for arguments, *parts in (
            ([CYCLOID], "--output is needed"),
            ([CYCLOID, "-o", self.path("a.gif")], ".svg, .pdf or .png"),
            ([CYCLOID, "-o", svg, "--quantity", "shaking_forc"], "has no such quantity", "nearest is 'shaking_force'"),
            ([CYCLOID, "-o", svg, "--quantity", "torque[A4]"], "nearest is 'torque[A"),
            ([CYCLOID, "-o", svg, "--x", "normalized"], "nearest is 'normalised'"),
            ([CYCLOID, "-o", svg, "--orders", "4"], "turns"),
            ([CYCLOID, "-o", svg, "--x", "angle"], "turns"),
            ([CYCLOID, "-o", svg, "--orders", "0"], "--orders"),
            ([CYCLOID, "-o", svg, "--orders", "4", "--x", "angle"], "--orders"),
            ([CYCLOID, "-o", svg, "--vectors", "magnitud"], "nearest is 'magnitude'"),
            ([CYCLOID, "-o", svg, "--path", "--plane", "xz"], "it has no plane xz"),
            ([CYCLOID, "-o", svg, "--plane", "xz"], "--path"),
            ([CYCLOID, "-o", svg, "--path", "--plane", "isometric"], "it has no view isometric"),
            ([CYCLOID, "-o", svg, "--path", "--plane", "iso"], "expected xy, xz, yz or isometric"),
            ([CYCLOID, "-o", svg, "--poses"], "--path"),
            ([CYCLOID, "-o", svg, "--side-by-side"], "--path"),
            ([CYCLOID, "-o", svg, "--path", "--poses", "0"], "--poses '0': expected a whole number from 1 to 50"),
            ([CYCLOID, "-o", svg, "--path", "--poses=2.5"], "--poses '2.5': expected a whole number from 1 to 50"),
            ([CYCLOID, "-o", svg, "--path", "--poses=many"], "--poses 'many': expected a whole number from 1 to 50"),
            (["-o", svg, "--path", "--poses", "4"], "no run given"),
            ([CYCLOID, "-o", svg, "--path", "--quantity", "torque"], "--path"),
            ([CYCLOID, "-o", svg, "--size", "12"], "--size '12': expected WIDTHxHEIGHT"),
            ([CYCLOID, "-o", svg, "--size", "1x1"], "from 30 to 1000"),
            ([CYCLOID, "-o", svg, "--size", "30x30"], "too small for these panels", "it takes "),
            ([CYCLOID, "-o", svg, "--font", "a'; system 'x'"], "--font"),
            ([CYCLOID, "-o", svg, "--font", "Times,1000"], "--font"),
            ([CYCLOID, "-o", svg, "--label", "a", "--label", "b"], "--label is given 2 times for 1 results"),
            ([ARM, CYCLOID, "-o", svg, "--quantity", "com_position.z"], CYCLOID, "nearest is"),
        ):
            with self.subTest(arguments=arguments):
                done = run("plot", *arguments)
                self.assert_failure(done, 2, *parts)
                self.assertEqual((done.stdout, os.listdir(self.folder)), ("", []))

    def test_a_missing_result_ends_with_5(self):
        self.assert_failure(run("plot", self.path("none.h5"), "-o", self.path("a.svg")), 5, "none.h5")

    def test_without_gnuplot_it_says_what_is_missing(self):
        os.mkdir(self.path("empty"))
        done = run("plot", CYCLOID, "-o", self.path("a.svg"), env={**os.environ, "PATH": self.path("empty")})
        self.assert_failure(done, 5, "gnuplot, which draws the pictures, is not in PATH", "apt install gnuplot-nox")
        self.assertEqual(os.listdir(self.folder), ["empty"])
        # The script needs none.
        done = run("plot", CYCLOID, "--script", env={**os.environ, "PATH": self.path("empty")})
        self.assert_quiet_success(done)

    def test_what_a_failing_gnuplot_says_is_passed_on(self):
        for script, part in (("echo 'no terminal' >&2; exit 3", "exit code 3): no terminal"), ("exit 0", "drew nothing"),
                             ("kill -9 $$", "signal 9")):
            fake = self.write("gnuplot", f"#!/bin/sh\n{script}\n")
            os.chmod(fake, 0o755)
            done = run("plot", CYCLOID, "-o", self.path("a.svg"), env={**os.environ, "PATH": self.folder + ":/bin"})
            self.assert_failure(done, 5, part)
            self.assertEqual(os.listdir(self.folder), ["gnuplot"])


if __name__ == "__main__":
    unittest.main()
