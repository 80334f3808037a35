"""Runs the program as a user would. The environment names it: BALANCE, and the mechanisms' folder: CONFIGS."""

import os
import re
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["BALANCE"]
CONFIGS = os.environ["CONFIGS"]
# How many times as long as an ordinary build a sanitized one may take.
SLOWNESS = int(os.environ.get("SLOWNESS", "1"))
SPEC = os.path.join(CONFIGS, "3rrr.yaml")


def run(*arguments, **options):
    """The finished process with its stdout and stderr as text."""
    options.setdefault("stdout", subprocess.PIPE)
    options.setdefault("stderr", subprocess.PIPE)
    return subprocess.run([PROGRAM, *arguments], text=True, check=False, timeout=120 * SLOWNESS, **options)


def unwrapped(text):
    """The text with the lines that are continued, with blanks at their beginning, on one line each."""
    return re.sub(r"\n +", " ", text)


def config(name, *changes):
    """A mechanism of the project with some of its text replaced: pairs of a pattern, which must be there, and a replacement."""
    with open(os.path.join(CONFIGS, name), encoding="utf-8") as file:
        text = file.read()
    for pattern, replacement in changes:
        text, count = re.subn(pattern, lambda _, r=replacement: r, text, flags=re.DOTALL)
        assert count, pattern
    return text


class Case(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = self._folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def assert_quiet_success(self, done):
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def assert_failure(self, done, code, *parts):
        """The exit code, and every part in what stderr says."""
        self.assertEqual(done.returncode, code, done.stderr)
        for part in parts:
            self.assertIn(part, done.stderr)
