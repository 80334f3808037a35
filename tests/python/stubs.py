"""The stubs say what the compiled module has, and the module's own Python fits its types."""

import os
import subprocess
import sys
import tempfile
import unittest

import balance_mechanisms


# Other people's types take half a minute to read and are not the question.
SETTINGS = """[mypy]
strict = True
disallow_any_generics = False
warn_return_any = False
[mypy-numpy.*,pandas.*,xarray.*]
follow_imports = skip
ignore_missing_imports = True
"""

# What pybind11 makes of every class.
ALLOWED = r"""balance_mechanisms\._native\.[A-Z]\w*
balance_mechanisms\._native\.[A-Z]\w*\.__init__
"""


class Stubs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.settings, self.allowed = (os.path.join(folder.name, name) for name in ("settings", "allowed"))
        for name, text in ((self.settings, SETTINGS), (self.allowed, ALLOWED)):
            with open(name, "w", encoding="utf-8") as file:
                file.write(text)

    def run_module(self, module, *arguments):
        folder = os.path.dirname(os.path.dirname(balance_mechanisms.__file__))
        done = subprocess.run([sys.executable, "-m", module, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, check=False, cwd=folder)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_stubs_are_those_of_the_module(self):
        self.run_module("mypy.stubtest", "balance_mechanisms._native", "--ignore-missing-stub", "--ignore-positional-only",
                        "--mypy-config-file", self.settings, "--allowlist", self.allowed)

    def test_types_fit(self):
        self.run_module("mypy", "--config-file", self.settings, "--cache-dir=/dev/null", "-p", "balance_mechanisms")

    def test_everything_public_has_a_docstring(self):
        for name in balance_mechanisms.__all__:
            one = getattr(balance_mechanisms, name)
            if name == "GOALS":
                continue
            self.assertTrue(one.__doc__, name)
            for member, value in vars(one).items() if isinstance(one, type) else ():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    self.assertTrue(value.__doc__, f"{name}.{member}")


if __name__ == "__main__":
    unittest.main()
