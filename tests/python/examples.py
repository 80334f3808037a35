"""The examples of the pages on the Python module and on result files run in a folder that has nothing but what the clone has."""

import contextlib
import io
import os
import pathlib
import re
import unittest

from _module import CONFIGS, Case, run

ROOT = pathlib.Path(__file__).resolve().parents[2]

try:
    import xarray
except ModuleNotFoundError:
    xarray = None


def examples(page):
    """Every program of a page, and what the page says that it prints, or None: the block `text` that follows."""
    found = re.findall(r"^```python\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [(program, printed or None) for program, printed in found]


class Examples(Case):
    def setUp(self):
        super().setUp()
        os.environ["MPLBACKEND"] = "agg"
        os.symlink(CONFIGS, self.path("configs"))
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(self.folder)

    def run_all(self, page):
        names, everything = {}, ""
        for program, told in examples(page):
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(program, page, "exec"), names)
            if told is not None:
                self.assertEqual(printed.getvalue(), told)
            everything += printed.getvalue()
        return everything

    def test_python(self):
        self.assertIn("ok     peak(shaking_force) <= 0.1 * base", self.run_all("python.md"))
        self.assertTrue({"after.h5", "before-and-after.png"} <= set(os.listdir()))

    @unittest.skipUnless(xarray, "no xarray here")
    def test_result_files(self):
        self.assert_quiet_success(run("simulate", "configs/5r.yaml", "-t", "cycloid", "-q", "-o", "out.h5"))
        self.assert_quiet_success(run("design", "configs/5r-design.yaml", "-q", "--h5", "design.h5"))
        self.run_all("file-format.md")


if __name__ == "__main__":
    unittest.main()
