"""The same bytes whenever, wherever and however often something is computed, on one thread or many."""

import glob
import os
import shutil
import subprocess
import tempfile
import unittest

from _program import CONFIGS, SPEC, Case, run
from _sampling import draw, traits_of
from _untimed import untimed

SPECS = ["3rrr.yaml", "3rrr-redistributed.yaml", "5r-design.yaml", "delta.yaml", "four-bar-in-space.yaml", "rr-design.yaml"]

# The system's library of mathematics then works without the instructions that fuse products with sums.
OLD_PROCESSOR = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX,-AVX512F"

SUITE = """
name: everything at once
matrix:
  spec: [specs/3rrr.yaml, specs/delta.yaml, specs/four-bar-in-space.yaml]
  samples: 51
cases:
  balanced: {spec: specs/rr-design.yaml, samples: 51, design: true}
"""


def german_locale(folder):
    """Decimal commas: the environment of a German user, as far as this machine can make it."""
    path = os.path.join(folder, "de_DE.UTF-8")
    try:
        subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", path], capture_output=True, timeout=60, check=True)
    except (OSError, subprocess.SubprocessError):
        pass  # the names alone must not matter either
    german = {name: "de_DE.UTF-8" for name in ("LC_ALL", "LANG", "LC_NUMERIC")}
    # The C library does not free what it knows of LOCPATH; a sanitized program should not be blamed for it.
    return {"LOCPATH": folder, "ASAN_OPTIONS": "detect_leaks=0", **german}


class Determinism(Case):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.locale = german_locale(folder.name)

    def setUp(self):
        super().setUp()
        self.worlds = []
        plain = {"PATH": os.environ["PATH"]}
        rubbish = {**plain, **self.locale, "MALLOC_PERTURB_": "165", "MALLOC_ARENA_MAX": "1", "TZ": "Asia/Tokyo",
                   "COLUMNS": "40", "HOME": "/nonexistent", "OMP_NUM_THREADS": "7", "TMPDIR": self.folder,
                   "GLIBC_TUNABLES": OLD_PROCESSOR}
        for k, environment in enumerate((plain, rubbish, {**os.environ, "MALLOC_PERTURB_": "90"})):
            place = tempfile.mkdtemp(prefix="x" * (1 + 30 * k), dir=self.folder)
            os.mkdir(os.path.join(place, "specs"))
            for spec in SPECS:
                shutil.copy(os.path.join(CONFIGS, spec), os.path.join(place, "specs"))
            with open(os.path.join(place, "suite.yaml"), "w", encoding="utf-8") as file:
                file.write(SUITE)
            self.worlds.append((place, environment))

    def everywhere(self, *arguments, codes=(0,), outputs=()):
        """Runs it in all worlds; stdout and the outputs have the same bytes in each."""
        seen = []
        for place, environment in self.worlds:
            done = run(*arguments, cwd=place, env=environment)
            self.assertIn(done.returncode, codes, done.stderr)
            content = [done.stdout, done.stderr]
            for output in outputs:
                with open(os.path.join(place, output), "rb") as file:
                    content.append(file.read())
            seen.append(content)
        for other in seen[1:]:
            for name, one, two in zip(("stdout", "stderr", *outputs), seen[0], other):
                self.assertTrue(one == two, f"{' '.join(arguments)}: {name} differs")

    def test_runs(self):
        for spec in ("3rrr.yaml", "delta.yaml", "four-bar-in-space.yaml"):
            self.everywhere("simulate", f"specs/{spec}", "--samples", "101", "-o", "run.h5", "--csv", "run.csv", "--force",
                            outputs=("run.h5", "run.csv"))
            self.everywhere("simulate", f"specs/{spec}", "--samples", "31", "--json")

    def test_configs_on_an_old_processor(self):
        differing, specs = [], sorted(glob.glob(os.path.join(CONFIGS, "*.yaml")))
        self.assertGreater(len(specs), 30)
        for spec in draw("configs on an old processor", specs, 0.2, traits_of):
            runs = [run("simulate", spec, "--samples", "65", "--csv", "-", env=environment)
                    for environment in (dict(os.environ), {**os.environ, "GLIBC_TUNABLES": OLD_PROCESSOR})]
            self.assertEqual(runs[0].returncode, 0, spec)
            if runs[0].stdout != runs[1].stdout:
                differing.append(os.path.basename(spec))
        self.assertEqual(differing, [])

    def test_checks_and_conditions(self):
        for spec in ("3rrr.yaml", "four-bar-in-space.yaml", "5r-design.yaml"):
            self.everywhere("check", f"specs/{spec}", "--json")
            self.everywhere("conditions", f"specs/{spec}", "--goal", "force", "--json")
        self.everywhere("conditions", "specs/5r-design.yaml", "--goal", "gyroscopic", "--latex")

    def test_designs(self):
        for spec in ("5r-design.yaml", "rr-design.yaml"):
            self.everywhere("design", f"specs/{spec}", "-o", "balanced.yaml", "--h5", "design.h5", "--force", "--json",
                            codes=(0, 1), outputs=("balanced.yaml", "design.h5"))

    def test_searches(self):
        self.everywhere("design", "specs/5r-design.yaml", "--goal", "static", "--minimize", "{peak: torque, along: cycloid}",
                        "--json", codes=(0, 1))

    def test_pictures_and_pages(self):
        self.everywhere("simulate", "specs/3rrr.yaml", "--samples", "51", "-o", "run.h5", "--force")
        self.everywhere("plot", "run.h5", "--script")
        if run("report", SPEC, "-o", self.path("page.html")).returncode == 5:
            self.skipTest("built without the page")
        self.everywhere("report", "specs/rr-design.yaml", "--samples", "51", "-o", "page.html", codes=(0, 1),
                        outputs=("page.html",))

    def test_batches_on_any_number_of_threads(self):
        def contents(folder):
            out = {}
            for where, _, names in os.walk(folder):
                for name in names:
                    with open(os.path.join(where, name), "rb") as file:
                        out[os.path.relpath(os.path.join(where, name), folder)] = file.read()
            return out

        results = []
        for jobs in ("1", "2", "4"):
            for place, environment in self.worlds[:2]:
                folder = os.path.join(place, f"results-{jobs}")
                done = run("batch", "suite.yaml", "-j", jobs, "-o", f"results-{jobs}", "--quiet", cwd=place, env=environment)
                self.assertEqual(done.returncode, 0, done.stderr)
                results.append(contents(folder))
        self.assertEqual(len([name for name in results[0] if name.endswith(".h5")]), 4)
        for other in results[1:]:
            self.assertEqual(sorted(other), sorted(results[0]))
            for name, data in results[0].items():
                self.assertTrue(untimed(data) == untimed(other[name]), f"{name} differs")


if __name__ == "__main__":
    unittest.main()
