"""Starter specs: every kind is listed, and each is a mechanism that can be checked, moved and designed."""

import json
import os
import unittest

import yaml

from _program import CONFIGS, Case, run

KINDS = ["arm", "four-bar", "slider-crank", "5r", "3rrr", "spatial-arm", "delta"]


class Starters(Case):
    def test_without_a_kind_all_are_listed_with_what_they_are(self):
        done = run("new")
        self.assert_quiet_success(done)
        rows = [line.split(maxsplit=1) for line in done.stdout.split("\n\n")[0].splitlines()]
        self.assertEqual([kind for kind, _ in rows], KINDS)
        listed = json.loads(run("new", "--json").stdout)["kinds"]
        self.assertEqual([[row["kind"], row["summary"]] for row in listed], rows)

    def test_every_starter_file_is_a_kind(self):
        files = os.listdir(os.path.join(CONFIGS, "starters"))
        self.assertEqual(sorted(files), sorted(kind + ".yaml" for kind in KINDS))

    def test_a_starter_is_its_file_with_comments(self):
        for kind in KINDS:
            done = run("new", kind)
            self.assert_quiet_success(done)
            with open(os.path.join(CONFIGS, "starters", kind + ".yaml"), encoding="utf-8") as file:
                self.assertEqual(done.stdout, file.read())
            self.assertGreaterEqual(done.stdout.count("# "), 8, kind)
            self.assertEqual(json.loads(run("new", kind, "--json").stdout)["spec"], done.stdout)

    def test_a_wrong_kind_gets_the_nearest(self):
        self.assert_failure(run("new", "fourbar"), 2, "there is no starter 'fourbar'", "nearest is 'four-bar'")
        self.assert_failure(run("new", "-o", self.path("a.yaml")), 2, "--output needs a KIND: ")

    def test_a_starter_is_written_to_a_file(self):
        out = self.path("a.yaml")
        done = run("new", "four-bar", "-o", out)
        self.assert_quiet_success(done)
        self.assertEqual(done.stdout, f"written: {out}\n")
        with open(out, encoding="utf-8") as file:
            self.assertEqual(file.read(), run("new", "four-bar").stdout)
        self.assert_failure(run("new", "delta", "-o", out), 5, out)
        self.assert_quiet_success(run("new", "delta", "--force", "-o", out))
        self.assertEqual(run("new", "delta", "-o", "-").stdout, run("new", "delta").stdout)

    def test_every_starter_does_what_its_comments_say(self):
        for kind in KINDS:
            text = run("new", kind).stdout
            spec = self.write(kind + ".yaml", text)
            commands = [line[1:].split("  ")[1].split() for line in text.splitlines() if line.startswith("#   balance")]
            self.assertGreaterEqual({command[1] for command in commands}, {"check", "design", "simulate"})
            for command in commands:
                with self.subTest(kind=kind, command=command):
                    words = [spec if word == "spec.yaml" else self.path(word) if word == "balanced.yaml" else word
                             for word in command[1:]]
                    self.assert_quiet_success(run(*words, *(["--force"] if "-o" in words else [])))

    def test_every_trajectory_of_every_starter_can_be_run(self):
        for kind in KINDS:
            text = run("new", kind).stdout
            spec = self.write(kind + ".yaml", text)
            for trajectory in yaml.safe_load(text)["trajectories"]:
                with self.subTest(kind=kind, trajectory=trajectory):
                    self.assert_quiet_success(run("simulate", spec, "-t", trajectory))

    def test_a_designed_starter_is_balanced_and_has_no_free_number_left(self):
        for kind in KINDS:
            with self.subTest(kind=kind):
                text = run("new", kind).stdout
                spec, balanced = self.write(kind + ".yaml", text), self.path("balanced.yaml")
                goal = yaml.safe_load(text)["design"]["goal"]
                self.assert_quiet_success(run("design", spec, "--goal", goal, "-o", balanced, "--force"))
                with open(balanced, encoding="utf-8") as file:
                    self.assertEqual(yaml.safe_load(file.read()).keys(), yaml.safe_load(text).keys())
                conditions = json.loads(run("conditions", balanced, "--json").stdout)["conditions"]
                self.assertGreater(len(conditions), 0)
                self.assertTrue(all(condition["met"] for condition in conditions))


if __name__ == "__main__":
    unittest.main()
