"""What the tests of the Python module share. The environment names the program (BALANCE) and the mechanisms' folder (CONFIGS)."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "cli"))
from _program import CONFIGS, Case as ProgramCase, run  # noqa: E402


def config(name):
    return os.path.join(CONFIGS, name)


class Case(ProgramCase):
    """A test with a folder of its own, in which it works."""

    def program(self, *arguments):
        done = run(*arguments)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.stdout

    def latex(self, *arguments):
        """What the program prints for a document, without the lines that let its pages break, which notebooks do not know."""
        text = self.program(*arguments, "--latex")
        self.assertTrue(text.startswith("\\begingroup\\allowdisplaybreaks\n") and text.endswith("\\endgroup\n"), text)
        return text.split("\n", 1)[1].removesuffix("\\endgroup\n")
