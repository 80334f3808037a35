"""scripts/animate draws mechanisms in motion: the README's picture is what it makes today, and the drawn links hang together."""

import math
import pathlib
import re
import shlex
import subprocess
import sys
import unittest
import xml.etree.ElementTree as xml

from _module import Case, config

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/animate"
SVG = "{http://www.w3.org/2000/svg}"


class Animate(Case):
    def draw(self, *words):
        target = self.path("drawn.svg")
        done = subprocess.run([sys.executable, str(SCRIPT), *words, "-o", target], capture_output=True, text=True, check=False, cwd=ROOT)
        self.assertEqual(done.returncode, 0, done.stderr)
        return pathlib.Path(target).read_text(encoding="utf-8")

    def test_the_picture_of_the_readme_is_made_by_the_command_in_the_script(self):
        command = re.search(r"^  scripts/animate (.*?) -o docs/pictures/forbal2\.svg", SCRIPT.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL).group(1)
        drawn = self.draw(*shlex.split(command.replace("\\\\\n", " ")))
        self.assertEqual(drawn, (ROOT / "docs/pictures/forbal2.svg").read_text(encoding="utf-8"))
        panels = xml.fromstring(drawn).findall(f"{SVG}g")
        self.assertEqual(["force" in {part.get("class") for part in panel.iter()} for panel in panels], [True, False, False])

    def test_links_hang_together_at_every_key_frame(self):
        drawn = self.draw(config("four-bar.yaml") + ":cycloid", "--label", "a <four-bar>")
        self.assertNotIn("<script", drawn)
        (panel,) = xml.fromstring(drawn).findall(f"{SVG}g")
        self.assertEqual(panel.find(f"{SVG}text").text, "a <four-bar>")
        frames = dict(re.findall(r"@keyframes (\w+)\{(.*?\})\}", drawn))
        ends = []  # of every link at every frame
        for body in (group for group in panel.findall(f"{SVG}g") if group.find(f"{SVG}path[@class='link']") is not None):
            shape = body.find(f"{SVG}path[@class='link']").get("d")
            points = [tuple(map(float, pair)) for pair in re.findall(r"(-?[\d.]+) (-?[\d.]+)", shape)]
            moves = re.findall(r"translate\((-?[\d.]+)px,(-?[\d.]+)px\) rotate\((-?[\d.]+)deg\)", frames[body.get("class")])
            ends.append([[(float(x) + px * math.cos(a) - py * math.sin(a), float(y) + px * math.sin(a) + py * math.cos(a)) for px, py in points]
                         for x, y, a in ((x, y, math.radians(float(turn))) for x, y, turn in moves)])
        crank, coupler, rocker = ends
        self.assertGreater(len(crank), 20)
        for frame in zip(crank, coupler, rocker):
            for one, other in ((frame[0], frame[1]), (frame[1], frame[2])):
                nearest = min(math.dist(p, q) for p in one for q in other)
                self.assertLess(nearest, 0.06)  # numbers are written to 0.01 px and 0.01 deg, half of which is 0.02 px on a link of 200 px

    def test_a_mechanism_in_space_is_refused(self):
        done = subprocess.run([sys.executable, str(SCRIPT), config("delta.yaml"), "-o", self.path("x.svg")], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is not planar", done.stderr)


if __name__ == "__main__":
    unittest.main()
