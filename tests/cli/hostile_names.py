"""Names and texts of strangers: no command prints them so that a terminal, Markdown, a spreadsheet or XML takes them for more than text."""

import csv
import json
import pathlib
import re
import unittest
import xml.etree.ElementTree as ElementTree

from _program import Case, config, run

TITLE = r'"=cmd|x!A1\nFAKE: done \u001b[31m <script>alert(1)</script> $\\input{/etc/passwd}$ | a | b `x` ]]> &amp; \u202e"'
ARM = ("rr-tolerance.yaml", (r"(?m)^name: [^\n]*", "name: " + TITLE))


class HostileNames(Case):
    def assert_plain(self, text):
        self.assertNotRegex(text, r"[\x00-\x08\x0b-\x1f\x7f\u202e]")
        self.assertNotRegex(text, r"(?m)^FAKE")

    def test_a_title_is_one_line_of_every_command(self):
        spec = self.write("spec.yaml", config(*ARM))
        for command in (["check"], ["check", "--verify"], ["simulate", "--samples", "5"], ["tolerance", "--samples", "5"], ["equations"],
                        ["equations", "--code", "c"], ["equations", "--code", "python"], ["equations", "--latex"], ["equations", "--at", "start"],
                        ["conditions", "-g", "static"], ["conditions", "-g", "static", "--latex"], ["compare", spec, "--format", "text"],
                        ["compare", spec, "--format", "markdown"], ["compare", spec, "--format", "csv"], ["plot", "--script", "--title", "a\nFAKE\x1b"]):
            with self.subTest(command=command):
                done = run(command[0], spec, *command[1:])
                self.assertIn(done.returncode, (0, 1, 4), done.stderr)
                self.assert_plain(done.stdout)
                self.assert_plain(done.stderr)

    def test_the_files_of_a_suite_hold_text_alone(self):
        self.write("t.yaml", config(*ARM))
        suite = self.write("suite.yaml", f"name: {TITLE}\ncases: {{a: {{spec: t.yaml, samples: 11}}, b=1+1: {{spec: t.yaml, samples: 11, set: {{nothing: 1}}}}}}\n"
                                         'baseline: a\nrequire: ["peak(torque) <= 1.0 * base"]\n')
        done = run("batch", suite, "-o", self.path("out"))
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assert_plain(done.stdout)
        folder = pathlib.Path(self.path("out"))
        for name in ("summary.md", "summary.csv", "summary.json", "junit.xml"):
            self.assert_plain((folder / name).read_text(encoding="utf-8"))
        markdown = (folder / "summary.md").read_text(encoding="utf-8")
        self.assertNotRegex(markdown, r"<[a-zA-Z/!]|(?<!\\)\$|(?<!\\)`x`")
        self.assertEqual(len(re.findall(r"(?m)^# ", markdown)), 1)
        with open(folder / "summary.csv", encoding="utf-8", newline="") as file:
            for row in csv.reader(file):
                for cell in row:
                    self.assertNotRegex(cell, r"^[=+@\t]|^-(?!\d)")
        ElementTree.parse(folder / "junit.xml")
        json.loads((folder / "summary.json").read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
