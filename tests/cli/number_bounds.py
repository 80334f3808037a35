"""Every number that an option takes is bounded, and what is no such number is refused at once, in words that name the option."""

import itertools
import os
import re
import unittest

from _program import CONFIGS, SPEC, Case, run
from _sampling import draw

# What a command needs besides its options, for those that have options with numbers.
OPERANDS = {
    "batch": [os.path.join(CONFIGS, "suites", sorted(os.listdir(os.path.join(CONFIGS, "suites")))[0])],
    "check": [SPEC], "conditions": [SPEC], "control": [SPEC], "design": [SPEC], "equations": [SPEC], "report": [SPEC],
    "identify": [os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "identification", "data", name) for name in ("5r-spec.yaml", "5r-train.csv")],
    "excite": [SPEC], "modes": [SPEC], "simulate": [SPEC], "tolerance": [SPEC],
}
# What else an option needs before it is looked at.
COMPANIONS = {"--time": ["--at", "start"], "--seed": ["--monte-carlo", "10"]}
NUMBER = re.compile(r"(?:-\w, ?)?(--[a-z-]+) (T|N|S|SECONDS|SIZE|I/N|WxH|X,Y\[,Z\])(?:\s|$)")
NO_NUMBERS = ("", " ", "nan", "-nan", "inf", "-inf", "1e400", "-1e400", "0x10", "1e", "ten", "1 2", "--", "9" * 400)


def number_options():
    """Command, option and the word that stands for its value."""
    for command in OPERANDS:
        for option, value in sorted(set(NUMBER.findall(run(command, "--help").stdout))):
            yield command, option, value


class NumberBounds(Case):
    def refused(self, command, option, text):
        companions = COMPANIONS.get(option, []) if option != "--seed" or command == "tolerance" else []
        done = run(command, *OPERANDS[command], *companions, f"{option}={text}")
        self.assertEqual((done.returncode, done.stdout), (2, ""), (command, option, text, done.stderr))
        self.assertIn(option, done.stderr, (command, option, text))
        self.assertLess(len(done.stderr), 1000, (command, option, text))

    def test_what_is_no_number_is_refused(self):
        options = list(number_options())
        self.assertGreater(len(options), 15)
        cases = itertools.product(options, NO_NUMBERS)
        for (command, option, _), text in draw("no numbers", cases, 0.1, set):
            with self.subTest(command=command, option=option, text=text):
                self.refused(command, option, text)

    def test_durations_have_the_bounds_of_the_spec(self):
        for text in ("5e-324", "1e-30", "0.99e-9", "1.01e9", "1e300", "0", "-1"):
            for command in ("simulate", "control"):
                self.refused(command, "--duration", text)
            spec = self.write("spec.yaml", config_with_duration(text))
            done = run("check", spec)
            self.assert_failure(done, 3, "duration")
        for text in ("1e-9", "1e9"):
            self.assertEqual(run("simulate", SPEC, "--duration", text, "--samples", "11").returncode, 0, text)

    def test_samples_have_the_bounds_of_the_spec(self):
        for text in ("1", "0", "-5", "100000001", "1e3", "2.5"):
            for command in ("simulate", "control", "tolerance"):
                self.refused(command, "--samples", text)


def config_with_duration(text):
    with open(SPEC, encoding="utf-8") as file:
        return re.sub(r"duration: [^\n,}]+", f"duration: {text}", file.read(), count=1)


if __name__ == "__main__":
    unittest.main()
