"""A page names whose code it holds, with their licence."""

import os
import unittest

from _program import CONFIGS, Case, run


class Notices(Case):
    def test_a_page_holds_the_licences_of_what_is_bundled_in_it(self):  # (C12)
        for spec, holders in (("rr.yaml", ["uplot 1.", "Leon Sorokin"]),
                              ("spatial-rrr.yaml", ["uplot 1.", "Leon Sorokin", "three 0.", "three.js authors"])):
            page = self.path("page.html")
            done = run("report", os.path.join(CONFIGS, spec), "-t", "cycloid", "--samples", "11", "-o", page, "--force")
            if "was built without the scripts of the page" in done.stderr:
                self.skipTest("built without the page")
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(page, encoding="utf-8") as file:
                text = file.read()
            for holder in [*holders, "The above copyright notice and this permission notice shall be included in"]:
                self.assertIn(holder, text, spec)


if __name__ == "__main__":
    unittest.main()
