#!/usr/bin/env python3
"""Every command that README and docs show runs, or is one that another test runs; what is printed in a block `console` is what the program
prints; commands, options and scripts that a sentence names exist."""

import os
import re
import subprocess
import tempfile
import unittest

import yaml

from _console import ROOT, blocks, prose, run_page, workplace

DOCS = ROOT / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if page.parent.name != "site")
EVERYTHING = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *PAGES]
# Pages whose blocks `console` another test runs.
TUTORIALS = {DOCS / "how-to.md", *(DOCS / "tutorials").glob("[0-9]*.md")}
# A finding is what `import --strict` is asked for.
FINDS = {"balance import tests/import/cases/2f85.xml --strict --json": 1}
# How other commands in blocks begin, and what runs them.
RUN_BY = {
    "scripts/demo": "tests/docs/test_demo.py",
    "scripts/test": ".ci/run",
    "scripts/gates": ".ci/run",
    "scripts/setup": "tests/cli/setup_packages.sh",
    "scripts/package": "scripts/gates",
    "scripts/peers": "scripts/gates",
    "apt install ./build/": "scripts/gates",
    "apt-get update && apt-get install --yes ./": "scripts/gates",
    "python3 -m venv": "scripts/gates",
    "env/bin/pip install": "scripts/gates",
    "cmake --preset": "scripts/test",
    "cmake --build": "scripts/test",
    "ctest --preset": "scripts/test",
    "cmake --install": "tests/install/run.sh",
    "scripts/check-certificate ": "tests/cli/certificate.py",
    "snakemake ": "tests/docs/test_cluster.py",
    "job=": "tests/docs/test_cluster.py",
    "sbatch ": "tests/docs/test_cluster.py",
    "export PATH=": "tests/docs/_console.py",
}
# Blocks without a language that are no commands, by how they begin.
NO_COMMANDS = ("foundation ", "D11 = ", "arm.yaml:", "leg.yaml:", "# motion.csv", "#!/bin/bash")


def lines_of_commands(text):
    """Lines of blocks of commands; a line that ends in a backslash goes on."""
    for language, block in blocks(text):
        if language in ("", "bash") and not block.startswith(NO_COMMANDS):
            for line in block.replace("\\\n", " ").splitlines():
                if line.strip() and not line.startswith("#"):
                    yield re.sub(r"\s+# .*", "", line)


def mentions(text):
    """Commands of the program that sentences name."""
    return [mention.replace("\n", " ") for mention in re.findall(r"`balance ([a-z][^`]*)`", prose(text))]


class Commands(unittest.TestCase):
    def test_every_command_of_every_page_runs(self):
        count = 0
        for page in PAGES:
            with tempfile.TemporaryDirectory() as temporary:
                folder, environment = workplace(temporary)
                for command in lines_of_commands(page.read_text(encoding="utf-8")):
                    if command.startswith("balance "):
                        count += 1
                        with self.subTest(page=page.name, command=command):
                            done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False)
                            self.assertEqual(done.returncode, FINDS.get(command, 0), done.stderr + done.stdout[-500:])
        self.assertGreaterEqual(count, 20)

    def test_every_output_is_what_the_program_prints(self):
        for page in PAGES:
            text = page.read_text(encoding="utf-8")
            if page not in TUTORIALS and "```console" in text:
                with self.subTest(page=page.name), tempfile.TemporaryDirectory() as temporary:
                    differing, count, _ = run_page(text, *workplace(temporary))
                    self.assertFalse(differing, "\n".join(differing))
                    self.assertGreater(count, 0)

    def test_whole_commands_within_sentences_run(self):
        count = 0
        for page in (page for page in EVERYTHING if page.name != "equations.md"):  # run by scripts/check_equations
            with tempfile.TemporaryDirectory() as temporary:
                folder, environment = workplace(temporary)
                for mention in (m for m in mentions(page.read_text(encoding="utf-8")) if " configs/" in m):
                    count += 1
                    with self.subTest(page=page.name, mention=mention):
                        done = subprocess.run(["bash", "-c", f"balance {mention}"], cwd=folder, env=environment, capture_output=True, text=True, check=False)
                        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(count, 2)

    def test_other_commands_are_run_by_other_tests(self):
        for begin, runner in RUN_BY.items():
            self.assertTrue((ROOT / runner).exists(), f"{begin}: there is no {runner}")
        for page in EVERYTHING:
            for command in lines_of_commands(page.read_text(encoding="utf-8")):
                with self.subTest(page=page.name, command=command):
                    self.assertTrue(command.startswith(("balance ", *RUN_BY)), "nothing runs it: add its test to RUN_BY")

    def test_scripts_that_pages_name_exist(self):
        for page in EVERYTHING:
            for name in re.findall(r"`(scripts/[\w./-]+)", page.read_text(encoding="utf-8")):
                with self.subTest(page=page.name, name=name):
                    self.assertTrue((ROOT / name.rstrip("./")).exists())


class Mentions(unittest.TestCase):
    """The help of the program is its own word for what exists."""

    @classmethod
    def setUpClass(cls):
        cls.helps = {}

    def options(self, command):
        if command not in self.helps:
            done = subprocess.run([os.environ["BALANCE"], command, "--help"], capture_output=True, text=True, check=False)
            self.helps[command] = set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", done.stdout)) if done.returncode == 0 else None
        return self.helps[command]

    def test_commands_and_options_that_sentences_name_exist(self):
        count = 0
        for page in EVERYTHING:
            for mention in mentions(page.read_text(encoding="utf-8")):
                command, *words = mention.split()
                with self.subTest(page=page.name, mention=mention):
                    count += 1
                    known = self.options(command)
                    self.assertIsNotNone(known, f"there is no command {command}")
                    named = {word.strip("[]").partition("=")[0] for word in words if re.match(r"\[?--?[a-zA-Z]", word)}
                    self.assertLessEqual(named, known | {"--all"})  # of the hidden commands man and completion
        self.assertGreater(count, 60)

    def test_options_alone_belong_to_some_command(self):
        listed = subprocess.run([os.environ["BALANCE"], "--help"], capture_output=True, text=True, check=True).stdout
        known = set(re.findall(r"--[a-z][\w-]*", listed)).union(*(self.options(word) or set() for word in re.findall(r"^  ([a-z]+) ", listed, re.MULTILINE)))
        self.assertGreater(len(known), 40)
        others = set()  # of scripts and of other programs
        for script in (ROOT / "scripts").iterdir():
            if script.is_file():
                others |= set(re.findall(r"--[a-z][\w-]*", script.read_text(encoding="utf-8")))
        others |= {"--requeue", "--cluster", "--cluster-cancel", "--cluster-status", "--mem", "--time", "--install", "--prefix", "--system-site-packages"}
        for page in EVERYTHING:
            for option in re.findall(r"`(--[a-z][\w-]*)", prose(page.read_text(encoding="utf-8"))):
                with self.subTest(page=page.name, option=option):
                    self.assertTrue(option in known or option in others, "no command and no script has it")


class Fragments(unittest.TestCase):
    def test_every_fragment_of_a_spec_is_yaml(self):
        for page in [ROOT / "README.md", *PAGES]:
            for language, block in blocks(page.read_text(encoding="utf-8")):
                if language == "yaml":
                    with self.subTest(page=page.name, block=block[:40]):
                        yaml.safe_load(block)


if __name__ == "__main__":
    unittest.main()
