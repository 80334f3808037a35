"""What the tests of the Python module share. The environment names the program (BALANCE) and the mechanisms' folder (CONFIGS)."""

import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "cli"))
from _program import CONFIGS, run  # noqa: E402


def config(name):
    return os.path.join(CONFIGS, name)


class Case(unittest.TestCase):
    """A test with a folder of its own, in which it works."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = self._folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def program(self, *arguments):
        done = run(*arguments)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.stdout
