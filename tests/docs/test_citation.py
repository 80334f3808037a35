#!/usr/bin/env python3
"""CITATION.cff is valid (Citation File Format 1.2.0) and of this version; docs/paper.md has the form that JOSS asks for, every reference is used,
and its table holds what the program computes."""

import datetime
import json
import os
import re
import subprocess
import unittest

import yaml

from _console import ROOT

CONFIGS = os.environ["CONFIGS"]
# Keys of the format's schema, version 1.2.0.
REQUIRED = {"authors", "cff-version", "message", "title"}
ALLOWED = REQUIRED | {"abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license", "license-url", "preferred-citation",
                      "references", "repository", "repository-artifact", "repository-code", "type", "url", "version"}
SECTIONS = ["Summary", "Statement of need", "State of the field", "Example", "Validation", "References"]


def balance(*words):
    done = subprocess.run([os.environ["BALANCE"], *words, "--json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


class Citation(unittest.TestCase):
    def setUp(self):
        self.citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))

    def test_the_file_is_valid(self):
        self.assertLessEqual(REQUIRED, set(self.citation))
        self.assertLessEqual(set(self.citation), ALLOWED)
        self.assertEqual((self.citation["cff-version"], self.citation["type"]), ("1.2.0", "software"))
        for key in ("message", "title", "abstract", "version"):
            self.assertIsInstance(self.citation[key], str)
        self.assertTrue(all(isinstance(word, str) for word in self.citation["keywords"]))
        self.assertEqual(len(set(self.citation["keywords"])), len(self.citation["keywords"]))
        self.assertTrue(self.citation["authors"])
        for author in self.citation["authors"]:
            self.assertTrue("name" in author or {"family-names", "given-names"} & set(author))
        datetime.date.fromisoformat(self.citation["date-released"])  # a text: YAML's own dates are no part of the format

    def test_version_and_licence_are_the_project_s(self):
        project = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
        self.assertEqual(self.citation["version"], re.search(r"^ *VERSION ([\d.]+)", project, re.MULTILINE).group(1))
        self.assertEqual(f"{self.citation['license']} License", (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()[0])


class Paper(unittest.TestCase):
    def setUp(self):
        text = (ROOT / "docs/paper.md").read_text(encoding="utf-8")
        _, head, self.body = text.split("---\n", 2)
        self.head = yaml.safe_load(head)

    def test_it_has_the_form_of_the_journal(self):
        self.assertLessEqual({"title", "tags", "authors", "affiliations", "date", "bibliography"}, set(self.head))
        places = {place["index"] for place in self.head["affiliations"]}
        self.assertTrue(all(author["affiliation"] in places for author in self.head["authors"]))
        self.assertEqual(re.findall(r"^# (.*)$", self.body, re.MULTILINE), SECTIONS)
        self.assertLess(len(self.body.split()), 1100)  # two pages

    def test_every_reference_is_used_and_every_use_has_one(self):
        listed = re.findall(r"^@\w+\{(\w+),", (ROOT / "docs" / self.head["bibliography"]).read_text(encoding="utf-8"), re.MULTILINE)
        used = set(re.findall(r"@(\w+)", self.body))
        self.assertEqual(sorted(listed), sorted(used))

    def test_its_table_is_what_the_program_computes(self):
        rows = {row[0]: row[1:] for row in re.findall(r"^\| (\w[^|]*) \| ([\d., ]+) \| ([\d., ]+) \|$", self.body, re.MULTILINE)}
        published, free = f"{CONFIGS}/published/forbal2-published.yaml", f"{CONFIGS}/published/forbal2.yaml"
        design = balance("design", free)
        with open(published, encoding="utf-8") as file:
            weights = yaml.safe_load(file)["counterweights"].values()
        masses = [[weight["mass"] for weight in weights], [number["value"] for number in design["free_numbers"]]]
        before = {m["quantity"]: m["peak"] for m in balance("simulate", published, "-t", "cycloid")["metrics"]}
        changes = next(run["changes"] for run in design["trajectories"] if run["trajectory"] == "cycloid")
        after = {change["quantity"]: change["after"] for change in changes if change["figure"] == "peak"}
        for name, digits, values in (("added mass [kg]", 6, [sum(m) for m in masses]),
                                     ("largest torque along a 1 s motion [N m]", 4, [before["torque"], after["torque"]]),
                                     ("largest shaking moment [N m]", 4, [before["shaking_moment"], after["shaking_moment"]])):
            self.assertEqual([float(x) for x in rows[name]], [round(value, digits) for value in values], name)
        self.assertEqual([[float(x) for x in cell.split(",")] for cell in rows["counterweights [kg]"]], [[round(m, 5) for m in row] for row in masses])


class Template(unittest.TestCase):
    def test_the_issue_template_has_a_head(self):
        for page in (ROOT / ".github/ISSUE_TEMPLATE").glob("*.md"):
            _, head, _ = page.read_text(encoding="utf-8").split("---\n", 2)
            self.assertLessEqual({"name", "about"}, set(yaml.safe_load(head)))


if __name__ == "__main__":
    unittest.main()
