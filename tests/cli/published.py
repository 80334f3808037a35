#!/usr/bin/env python3
"""Mechanisms with published numbers: every spec is sound, every row of the suite's sample holds, and a wrong number is found."""

import json
import os
import re
import subprocess
import unittest
from concurrent.futures import ThreadPoolExecutor

from _program import CONFIGS, PROGRAM, Case
from _published import SPECS, SUITE, read_cases, spec_of, traits_of, write_suite
from _sampling import WHOLE, draw

# Minutes of search, or 60000 steps of an open loop: in the whole, and in the gate `published`.
SLOW = {"virtual-counterweight-design"}


def run(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)


class Specs(unittest.TestCase):
    def test_check_accepts_every_spec_and_warns_of_impossible_inertias_alone(self):
        names = sorted(name for name in os.listdir(SPECS) if name.endswith(".yaml"))
        self.assertGreater(len(names), 90)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            answers = list(pool.map(lambda name: run("check", os.path.join(SPECS, name)), names))
        for name, answer in zip(names, answers):
            with self.subTest(name):
                self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
                for warning in re.findall(r"^warning: .*", answer.stderr, re.MULTILINE):
                    self.assertIn(".inertia: kept as given: no body can have this inertia", warning)

    def test_every_spec_says_its_source_and_is_in_the_suite(self):
        used = {os.path.basename(spec_of(content)) for content in read_cases().values()}
        for name in sorted(name for name in os.listdir(SPECS) if name.endswith(".yaml")):
            with self.subTest(name), open(os.path.join(SPECS, name), encoding="utf-8") as file:
                head = re.match(r"(#.*\n)+", file.read())[0]
                self.assertRegex(head, r"\n# Source: ")
                self.assertRegex(head, r"\n# (Printed|Right|Published)\b")
                self.assertIn(name, used)


class Suite(Case):
    def setUp(self):
        super().setUp()
        self.cases = read_cases()

    def batch(self, suite):
        """Exit code, summary and what was said of a batch."""
        done = run("batch", suite, "-o", self.path("results"), "--metrics-only", "--quiet", "-j", "2")
        with open(self.path("results/summary.json"), encoding="utf-8") as file:
            return done.returncode, json.load(file), done.stdout + done.stderr

    def test_every_printed_number_of_the_sample_holds(self):
        names = [name for name in self.cases if WHOLE or name not in SLOW]
        chosen = draw("published cases", names, 0.15, lambda name: traits_of(self.cases[name]))
        suite = self.path("suite.yaml")
        write_suite(self.cases, chosen, suite)
        code, summary, said = self.batch(suite)
        self.assertEqual((code, said), (0, ""))
        rows = [row for case in summary["cases"] for row in case.get("published", [])]
        self.assertGreater(len(rows), len(chosen))
        self.assertTrue(all(row["holds"] for row in rows))

    def test_a_wrong_number_is_found(self):
        content, count = re.subn(r"exact: 6\.9053599\b", "exact: 6.9053699", self.cases["K15-2"])
        self.assertEqual(count, 1)
        suite = self.path("suite.yaml")
        write_suite({**self.cases, "K15-2": content}, ["K15-2"], suite)
        code, summary, said = self.batch(suite)
        self.assertEqual(code, 1)
        self.assertEqual([row["what"] for row in summary["cases"][0]["published"] if not row["holds"]], ["piston speed"])
        self.assertIn("piston speed", said)

    def test_the_suite_lists_every_case(self):
        listed = run("batch", SUITE, "--list")
        self.assertEqual(listed.returncode, 0, listed.stderr)
        self.assertEqual(listed.stdout.split(), list(self.cases))
        self.assertTrue(os.path.isdir(CONFIGS))


if __name__ == "__main__":
    unittest.main()
