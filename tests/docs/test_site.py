#!/usr/bin/env python3
"""The site is built without a warning, none of its links is broken, and what checks the links can fail."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from _console import ROOT

sys.path[:0] = [str(ROOT / "docs/site"), str(ROOT / "tests/cli")]

import links  # noqa: E402  (found by the line above)
from _published import read_cases, write_suite  # noqa: E402
from _sampling import WHOLE, draw  # noqa: E402

PACKAGES = pathlib.Path(os.environ["BALANCE"]).resolve().parent / "web"
BROWSES = (PACKAGES / "node_modules/playwright-core").is_dir() and shutil.which("chromium") and shutil.which("node")
DRAWS = BROWSES and WHOLE  # the gate `site` draws every mechanism


class Site(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_it_is_built_and_every_link_leads_somewhere(self):
        mechanisms = draw("mechanisms in the gallery", ["four-bar", "delta"], 0.5)
        options = ["--only", ",".join(mechanisms), "--folder", str(self.folder), *([] if DRAWS else ["--without-pictures"]),
                   "--validation", self.summary_of("K15-2", "S12-1d", "tinyrobotics-4_link")]
        done = subprocess.run([str(ROOT / "scripts/site"), *options], capture_output=True, text=True, check=False,
                              env={**os.environ, "PAGE_PACKAGES": str(PACKAGES)})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn(" 0 broken links", done.stdout)
        html = self.folder / "html"
        for page in (ROOT / "docs").rglob("*.md"):
            name = page.relative_to(ROOT / "docs").with_suffix(".html")
            if str(name) not in ("README.html", "paper.html", "site/index.html"):
                self.assertTrue((html / name).is_file(), name)
        for name in mechanisms:
            self.assertIn("Peak shaking force", (html / f"gallery/{name}.html").read_text(encoding="utf-8"))
            if DRAWS:
                self.assertGreater((html / f"_images/{name}.png").stat().st_size, 5000)
                self.assertTrue((html / f"gallery/pages/{name}.html").is_file())
        validation = (html / "validation.html").read_text(encoding="utf-8")
        for part in ("6.833 m/s", "6.9053599 m/s", "+1.06\N{NO-BREAK SPACE}%", '<a href="specs/K15-2.yaml">', "improved, with proof", "13.5038"):
            self.assertIn(part, validation)
        if BROWSES:
            self.assert_silent(html)

    def summary_of(self, *names):
        """What `balance batch` says of some of the published cases."""
        write_suite(read_cases(), names, self.folder / "suite.yaml")
        done = subprocess.run([os.environ["BALANCE"], "batch", str(self.folder / "suite.yaml"), "-o", str(self.folder / "results"), "--metrics-only", "--quiet"],
                              capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return str(self.folder / "results/summary.json")

    def assert_silent(self, html):
        """Opens every page: the browser's console says nothing."""
        done = subprocess.run(["node", str(ROOT / "tests/browser/_site.mjs"), str(html)], capture_output=True, text=True, check=False,
                              env={**os.environ, "PAGE_PACKAGES": str(PACKAGES), "CHROMIUM": shutil.which("chromium")})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"^\d\d+ pages, 0 complaints\n$")

    def test_what_cannot_be_built_is_told(self):
        site = [str(ROOT / "scripts/site"), "--folder", str(self.folder)]
        for options, surroundings, code, said in (
                (["--without-pictures", "--only", "four-bar,nothing"], {}, 2, "site: there is no configs/nothing.yaml"),
                ([], {"BALANCE": "/nowhere/balance"}, 5, "site: there is no /nowhere/balance; scripts/demo builds it"),
                ([], {"PAGE_PACKAGES": "/nowhere", "CHROMIUM": "/bin/true"}, 5, "site: drawing takes ")):
            done = subprocess.run([*site, *options], capture_output=True, text=True, check=False, env={**os.environ, **surroundings})
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertTrue(done.stderr.startswith(said), done.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_link_that_leads_nowhere_is_found(self):
        (self.folder / "styles").mkdir()
        (self.folder / "styles/own.css").write_text("a { background: url(missing.png) } b { background: url(own.css) }", encoding="utf-8")
        (self.folder / "other.html").write_text('<h1 id="there">There</h1>', encoding="utf-8")
        (self.folder / "index.html").write_text(
            '<a href="other.html#there">good</a> <a href="other.html#gone">place</a> <a href="none.html">file</a> '
            '<a href="https://example.org">elsewhere</a> <script src="https://example.org/x.js"></script> <a href="../outside.html">out</a>',
            encoding="utf-8")
        self.assertEqual(sorted(links.broken(self.folder)), [
            "index.html: ../outside.html", "index.html: https://example.org/x.js is fetched from elsewhere", "index.html: none.html",
            "index.html: other.html#gone", "styles/own.css: missing.png"])


if __name__ == "__main__":
    unittest.main()
