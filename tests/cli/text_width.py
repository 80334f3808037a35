"""Text for people fits a terminal of 80 columns: every command, every mechanism."""

import glob
import os
import unittest

from _program import CONFIGS, Case, run
from _sampling import draw

WIDTH = 80


def specs():
    found = [os.path.basename(path) for path in glob.glob(os.path.join(CONFIGS, "*.yaml"))]
    for folder in ("poses", "machines"):
        found += [f"{folder}/{os.path.basename(path)}" for path in glob.glob(os.path.join(CONFIGS, folder, "*.yaml"))]
    return draw("mechanisms whose text is measured", sorted(found), 0.15)


class TextWidth(Case):
    def assert_fits(self, *arguments):
        environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
        done = run(*arguments, env=environment)
        for line in done.stdout.splitlines():
            self.assertLessEqual(len(line), WIDTH, f"{' '.join(arguments)}\n{line}")
        return done

    def test_every_command_on_every_mechanism(self):
        for name in specs():
            path = os.path.join(CONFIGS, name)
            with self.subTest(spec=name):
                self.assert_fits("check", path)
                self.assert_fits("check", path, "--verbose")
                self.assert_fits("conditions", path)
                self.assert_fits("equations", path, "--at", "start")
                self.assert_fits("simulate", path)
                self.assert_fits("simulate", path, "--verbose")
                self.assert_fits("simulate", path, "--at", "start")
                with open(path, encoding="utf-8") as file:
                    text = file.read()
                if "free:" in text:
                    self.assert_fits("design", path, "--seconds", "0.3")
                if "\ncontrollers:" in text:
                    self.assert_fits("control", path)
                if "\ntolerances:" in text:
                    self.assert_fits("tolerance", path, "--monte-carlo", "20")

    def test_comparisons_and_formulas(self):
        one, two = (os.path.join(CONFIGS, name) for name in ("3rrr.yaml:cycloid", "3rrr-proportional.yaml:cycloid"))
        self.assert_fits("compare", one, two)
        self.assert_fits("equations", os.path.join(CONFIGS, "planar-rrr.yaml"), "--only", "inertia,gravity,conditions")
        self.assert_fits("equations", os.path.join(CONFIGS, "3rrr.yaml"), "--at", "start", "--only", "redundant,natural,regressor")

    def test_nothing_is_said_of_what_there_is_none_of(self):
        path = os.path.join(CONFIGS, "rr-balanced.yaml")
        brief, verbose = run("check", path).stdout, run("check", path, "--verbose").stdout
        self.assertNotRegex(brief, r"(?m) none$")
        self.assertRegex(verbose, r"(?m)^passive freedoms +none$")
        self.assertEqual([line for line in verbose.splitlines() if not line.endswith(" none")], brief.splitlines())
        path = os.path.join(CONFIGS, "scara.yaml")
        brief, verbose = run("simulate", path).stdout.splitlines(), run("simulate", path, "--verbose").stdout.splitlines()
        self.assertEqual([line for line in verbose if line in brief], brief)  # the same lines, and others between them
        for line in verbose:
            if line not in brief:
                self.assertRegex(line, r"\[.*\].* 0\.00000 .* 0\.00000 .*0\.00000$")

    def test_long_names_are_wrapped_and_numbers_are_not_cut(self):
        name = "the_upper_arm_of_the_left_leg_of_the_platform_on_which_everything_rests"
        with open(os.path.join(CONFIGS, "rr.yaml"), encoding="utf-8") as file:
            text = file.read().replace("R1", name)
        done = self.assert_fits("simulate", self.write("long.yaml", text))
        self.assertEqual(done.returncode, 0, done.stderr)
        figures = [line.split()[-4:] for line in done.stdout.splitlines() if "N m" in line]
        expected = run("simulate", os.path.join(CONFIGS, "rr.yaml")).stdout
        self.assertEqual(figures, [line.split()[-4:] for line in expected.splitlines() if "N m" in line])


if __name__ == "__main__":
    unittest.main()
