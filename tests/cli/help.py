"""Help texts, manual pages and shell completions: they say the same, because one definition makes all of them."""

import os
import re
import shutil
import subprocess
import unittest

from _program import CONFIGS, Case, run


def commands():
    """The commands that `balance --help` lists."""
    listed = run("--help").stdout.split("Examples:\n", 1)[0]
    return re.findall(r"^  ([a-z0-9-]+)  ", listed, re.MULTILINE)


def options(command):
    """Long and short names that `balance <command> --help` lists."""
    text = run(command, "--help").stdout
    heads = re.findall(r"^  (-\S+(?:,-\S+)*)", text, re.MULTILINE)
    return sorted(name for head in heads for name in head.split(","))


def page(command=""):
    return run("man", *([command] if command else [])).stdout


def shown(roff):
    """The page as a reader sees it."""
    done = subprocess.run(["groff", "-man", "-Tascii", "-P-c", "-P-b", "-P-u", "-ww", "-rLL=200n"], input=roff, text=True,
                          capture_output=True, check=True)
    return done.stdout, done.stderr


class Help(Case):
    def test_every_command_has_examples_that_begin_with_its_name(self):
        self.assertGreaterEqual(len(commands()), 5)
        for command in commands():
            with self.subTest(command=command):
                done = run(command, "--help")
                self.assert_quiet_success(done)
                examples = done.stdout.split("Examples:\n", 1)[1].splitlines()
                self.assertGreaterEqual(len(examples), 2)
                for example in examples:
                    self.assertRegex(example, rf"^  (.* )?balance {command}( |$)")

    def test_every_option_of_an_example_exists(self):
        for command in commands():
            for example in run(command, "--help").stdout.split("Examples:\n", 1)[1].splitlines():
                words = example.split("balance " + command, 1)[1].split("|")[0]
                for option in re.findall(r"(?<!\S)--?[a-zA-Z][\w-]*", re.sub(r"'[^']*'", "", words)):
                    self.assertIn(option, options(command), example)

    def test_every_help_fits_a_terminal_and_is_read_at_once(self):
        for command in ([], *([name] for name in [*commands(), "man", "completion"])):
            lines = run(*command, "--help").stdout.splitlines()
            self.assertLessEqual(len(lines), 60 if command else 45, command)
            for line in lines:
                self.assertLessEqual(len(line), 80, line)

    def test_the_program_alone_prints_its_help(self):
        bare = run()
        self.assert_quiet_success(bare)
        self.assertEqual(bare.stdout, run("--help").stdout)
        self.assertEqual(bare.stdout, run("help").stdout)
        for group in ("Describe", "Balance", "Move", "Compare", "Show"):
            self.assertIn(f"\n{group}:\n  ", bare.stdout)

    def test_hidden_commands_are_hidden_but_have_help(self):
        for command in ("man", "completion"):
            self.assertNotIn(command, commands())
            self.assertIn("Examples:", run(command, "--help").stdout)
        self.assertNotIn("completion", run().stdout)
        self.assert_failure(run("completion", "bsh"), 2, "nearest is 'bash'")
        self.assert_failure(run("man", "simulat"), 2, "nearest is 'simulate'")


@unittest.skipUnless(shutil.which("groff"), "no groff here")
class ManualPages(Case):
    def test_groff_has_nothing_to_warn_of(self):
        for command in ["", *commands()]:
            with self.subTest(command=command):
                self.assertEqual(shown(page(command))[1], "")

    def test_a_page_shows_every_option_and_every_example(self):
        for command in commands():
            text = shown(page(command))[0]
            with self.subTest(command=command):
                for option in options(command):
                    self.assertRegex(text, rf"(?m)^ +(\S+, )*{option}( |,|$)")
                for example in run(command, "--help").stdout.split("Examples:\n", 1)[1].splitlines():
                    self.assertIn(example.strip(), text)

    def test_the_program_page_lists_commands_and_exit_codes(self):
        text = shown(page())[0]
        for command in commands():
            self.assertRegex(text, rf"(?m)^ +{command}\b")
        codes = text.split("EXIT STATUS")[1].split("SEE ALSO")[0]
        self.assertEqual(re.findall(r"(?m)^ +(\d) ", codes), list("012345"))

    def test_all_pages_are_written_to_a_folder_and_are_the_same_each_time(self):
        self.assert_quiet_success(run("man", "--all", self.folder))
        self.assertEqual(sorted(os.listdir(self.folder)), sorted(["balance.1", *(f"balance-{c}.1" for c in commands())]))
        for command in commands():
            with open(self.path(f"balance-{command}.1"), encoding="utf-8") as file:
                self.assertEqual(file.read(), page(command))
        self.assert_quiet_success(run("man", "--all", self.path("none")))
        self.assertEqual(len(os.listdir(self.path("none"))), 1 + len(commands()))


class Bash(Case):
    def complete(self, *words, folder=None):
        """What bash offers for the last word. `=` is a word of its own, as where readline breaks words."""
        script = self.write("balance.bash", run("completion", "bash").stdout)
        program = (f"set -u; source {script}; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _balance; "
                   "printf '%s\\n' \"${COMPREPLY[@]}\"")
        done = subprocess.run(["bash", "-c", program, "bash", "balance", *words], text=True, capture_output=True,
                              check=False, cwd=folder or self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return sorted(line for line in done.stdout.splitlines() if line)

    def test_commands(self):
        self.assertEqual(self.complete(""), sorted(commands()))
        self.assertEqual(self.complete("sim"), ["simulate"])
        self.assertEqual(self.complete("--v"), ["--version"])

    def test_every_option_of_every_command(self):
        for command in commands():
            self.assertEqual(self.complete(command, "-"), options(command), command)
        self.assertEqual(self.complete("simulate", "a.yaml", "--samples", "5", "--forc"), ["--force"])

    def test_values_of_fixed_sets(self):
        goals = self.complete("design", "--goal", "")
        self.assertIn("fully-gyroscopic-independent", goals)
        self.assertEqual(goals, self.complete("conditions", "-g", ""))
        self.assertEqual(self.complete("design", "a.yaml", "--goal", "=", "prop"), ["proportional"])
        self.assertEqual(self.complete("design", "a.yaml", "--goal", "="), goals)
        self.assertEqual(self.complete("design", "--strategy", "m"), ["modular"])
        self.assertIn("slsqp", self.complete("design", "--algorithm", ""))
        self.assertEqual(self.complete("new", "s"), ["slider-crank", "spatial-arm"])
        self.assertEqual(self.complete("simulate", "--samples", ""), [])

    def test_every_value_offered_is_accepted(self):
        for goal in self.complete("conditions", "--goal", ""):
            self.assertNotEqual(run("conditions", os.path.join(CONFIGS, "rr.yaml"), "--goal", goal).returncode, 2, goal)

    def test_files_where_they_belong(self):
        for name in ("a.yaml", "b.yml", "c.h5", "with blank.yaml"):
            self.write(name, "")
        os.mkdir(self.path("folder"))
        specs = ["a.yaml", "b.yml", "folder", "with blank.yaml"]
        self.assertEqual(self.complete("check", ""), specs)
        self.assertEqual(self.complete("simulate", "-t", "cycloid", "--set", "l=1", ""), specs)
        self.assertEqual(self.complete("simulate", "--samples", "=", "5", "w"), ["with blank.yaml"])
        self.assertEqual(self.complete("simulate", "a.yaml", "-o", "c"), ["c.h5"])
        self.assertEqual(self.complete("check", "a.yaml", ""), options("check"))


class OtherShells(Case):
    def script(self, shell):
        done = run("completion", shell)
        self.assert_quiet_success(done)
        return done.stdout

    def test_every_command_and_option_is_there(self):
        zsh, fish = self.script("zsh"), self.script("fish")
        for command in commands():
            self.assertIn(f"\n        {command})\n", zsh)
            case = zsh.split(f"\n        {command})\n")[1].split(";;")[0]
            lines = [line for line in fish.splitlines() if f"__fish_seen_subcommand_from {command}'" in line]
            for option in options(command):
                with self.subTest(command=command, option=option):
                    self.assertRegex(case, rf"{option}[=+]?\[")
                    flag = f" -l {option[2:]} " if option.startswith("--") else f" -s {option[1:]} "
                    self.assertTrue(any(flag in line for line in lines), flag)

    @unittest.skipUnless(shutil.which("zsh"), "no zsh here")
    def test_zsh_reads_it(self):
        script = self.write("_balance", self.script("zsh"))
        done = subprocess.run(["zsh", "-n", script], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    @unittest.skipUnless(shutil.which("fish"), "no fish here")
    def test_fish_completes_with_it(self):
        for name in ("a.yaml", "c.h5"):
            self.write(name, "")
        script = self.write("balance.fish", self.script("fish"))
        home = {**os.environ, "HOME": self.folder, "XDG_CONFIG_HOME": self.folder, "XDG_DATA_HOME": self.folder}

        def complete(line):
            done = subprocess.run(["fish", "--no-config", "-c", f"source {script}; complete -C '{line}'"], text=True,
                                  capture_output=True, check=False, cwd=self.folder, env=home)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            return sorted(row.split("\t")[0] for row in done.stdout.splitlines())

        self.assertEqual(complete("balance "), sorted(commands()))
        self.assertIn("proportional", complete("balance design --goal "))
        self.assertEqual(complete("balance simulate --sa"), ["--samples"])
        self.assertEqual(complete("balance new s"), ["slider-crank", "spatial-arm"])
        self.assertIn("a.yaml", complete("balance check a"))


if __name__ == "__main__":
    unittest.main()
