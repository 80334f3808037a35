"""Standard input and output as files, words that people try, and help that fits (D6)."""

import fcntl
import os
import pty
import shutil
import signal
import struct
import subprocess
import termios
import unittest

from _program import CONFIGS, PROGRAM, Case, run

SPEC = os.path.join(CONFIGS, "four-bar.yaml")


def piped(*arguments, text="", binary=False):
    done = subprocess.run([PROGRAM, *arguments], input=text.encode(), capture_output=True, check=False, timeout=60)
    return done.returncode, done.stdout if binary else done.stdout.decode(), done.stderr.decode()


class OnTerminal:
    """A command on a terminal of so many columns."""

    def __init__(self, *arguments, columns=80):
        self.parent, child = pty.openpty()
        fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
        self.process = subprocess.Popen([PROGRAM, *arguments], stdin=child, stdout=child, stderr=child)
        os.close(child)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.parent)

    def read_until(self, words):
        """What it prints until it has printed these words, or to its end."""
        text = b""
        while words is None or words.encode() not in text:
            try:
                block = os.read(self.parent, 65536)
            except OSError:
                block = b""
            if not block:
                self.process.wait()
                break
            text += block
        return text.decode().replace("\r\n", "\n")


def on_terminal(*arguments, columns=80):
    """What a command prints on a terminal of so many columns."""
    with OnTerminal(*arguments, columns=columns) as terminal:
        text = terminal.read_until(None)
    return terminal.process.returncode, text


class Streams(Case):
    def test_a_spec_is_read_from_standard_input(self):
        with open(SPEC, encoding="utf-8") as file:
            text = file.read()
        self.assertEqual(piped("check", "-", text=text)[:2], (0, run("check", SPEC).stdout))
        code, _, error = piped("check", "-", text="space: plana\n")
        self.assertEqual(code, 3)
        self.assertTrue(error.startswith("<stdin>:1:"), error)

    def test_samples_go_to_standard_output_and_the_summary_beside_them(self):
        self.assert_quiet_success(run("simulate", SPEC, "-t", "cycloid", "--csv", self.path("a.csv")))
        code, table, error = piped("simulate", SPEC, "-t", "cycloid", "--csv", "-")
        with open(self.path("a.csv"), encoding="utf-8") as file:
            self.assertEqual((code, table), (0, file.read()))
        self.assertIn("shaking_force", error)
        code, data, _ = piped("simulate", SPEC, "-t", "cycloid", "-o", "-", binary=True)
        self.assertEqual((code, data[:8]), (0, b"\x89HDF\r\n\x1a\n"))
        with open(self.path("piped.h5"), "wb") as file:
            file.write(data)
        self.assert_quiet_success(run("simulate", SPEC, "-t", "cycloid", "-o", self.path("named.h5")))
        self.assert_quiet_success(run("compare", self.path("named.h5"), self.path("piped.h5")))
        self.assertEqual(sorted(os.listdir(self.folder)), ["a.csv", "named.h5", "piped.h5"])
        self.assertFalse(os.path.exists("-"))

    def test_nothing_is_said_to_be_written_to_standard_output(self):
        """(D6) What goes there needs no words beside it; a file of its own does."""
        a, b = self.path("a.h5"), self.path("b.h5")
        for file in (a, b):
            self.assert_quiet_success(run("simulate", SPEC, "-t", "cycloid", "--samples", "11", "-q", "-o", file))
        commands = [["simulate", SPEC, "-t", "cycloid", "--samples", "11", "-o", "-"],
                    ["compare", a, b, "--format", "csv", "-o", "-"],
                    ["report", SPEC, "-t", "cycloid", "-o", "-"],
                    ["design", os.path.join(CONFIGS, "rr.yaml"), "-o", "-"]]
        if shutil.which("gnuplot"):
            commands.append(["plot", a, "-o", "-"])
        for command in commands:
            code, data, error = piped(*command, binary=True)
            self.assertEqual(code, 0, (command, error))
            self.assertTrue(data, command)
            self.assertNotIn("written", str(error), command)

    def test_a_design_goes_through_a_pipe(self):
        spec = os.path.join(CONFIGS, "rr.yaml")
        with open(spec, encoding="utf-8") as file:
            text = file.read()
        code, balanced, _ = piped("design", "-", "-o", "-", text=text)
        self.assertEqual(code, 0)
        self.assertEqual(piped("check", "-", text=balanced)[0], 0)

    def test_standard_output_takes_one_thing(self):
        self.assert_failure(run("simulate", SPEC, "-o", "-", "--csv", "-"), 2, "standard output")
        self.assert_failure(run("simulate", SPEC, "-o", "-", "--json"), 2, "standard output")
        code, text = on_terminal("simulate", SPEC, "-o", "-")
        self.assertEqual(code, 2)
        self.assertIn("terminal", text)

    def test_words_that_people_try(self):
        self.assertEqual(run("help").stdout, run("--help").stdout)
        self.assertEqual(run("help", "design").stdout, run("design", "--help").stdout)
        self.assertEqual(run("-V").stdout, run("--version").stdout)
        self.assert_failure(run("--verbose"), 2, "--verbose", "--quiet")

    def test_help_fits_the_terminal(self):
        for columns in (60, 80, 100):
            for command in ([], ["simulate"], ["batch"], ["design"], ["plot"]):
                code, text = on_terminal(*command, "--help", columns=columns)
                self.assertEqual(code, 0)
                for line in text.split("Examples:")[0].splitlines():
                    self.assertLessEqual(len(line), columns, line)
        words = run("simulate", "--help").stdout.split()
        self.assertEqual(on_terminal("simulate", "--help", columns=60)[1].split(), words)

    def test_a_suite_from_standard_input_says_where_its_results_go(self):
        """(D6)"""
        suite = f"cases: {{a: {{spec: {CONFIGS}/four-bar.yaml, samples: 11}}}}"
        self.assert_failure(run("batch", "-", input=suite), 2, "--output is needed for a suite from standard input")
        self.assertEqual(run("batch", "-", "--list", input=suite).stdout, "a\n")
        self.assert_quiet_success(run("batch", "-", "-o", self.path("out"), input=suite))

    def test_the_list_of_commands_fits_one_screen(self):
        self.assertLessEqual(len(run("--help").stdout.splitlines()), 45)

    def assert_progress_on_a_terminal_only(self, *arguments):
        """Of the same run on a terminal, there with --quiet, and through pipes: they are interrupted when the first has shown how far it is."""
        with OnTerminal(*arguments, "--quiet") as quiet, OnTerminal(*arguments) as shown, subprocess.Popen(
                [PROGRAM, *arguments, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as piped_run:
            text = shown.read_until(" %")
            self.assertIn(" %", text)
            for process in (quiet.process, shown.process, piped_run):
                process.send_signal(signal.SIGINT)
            self.assertNotIn(" %", quiet.read_until(None))
            shown.read_until(None)
            self.assertNotIn(" %", "".join(piped_run.communicate(timeout=60)))
        for process in (quiet.process, shown.process, piped_run):
            self.assertEqual(process.returncode, 128 + signal.SIGINT)  # none was done before
        return text

    def test_a_long_run_shows_how_far_it_is_on_a_terminal_only(self):
        self.assert_progress_on_a_terminal_only("simulate", os.path.join(CONFIGS, "3rrr.yaml"), "-t", "cycloid", "--samples", "3000000")

    def test_a_long_run_under_control_shows_how_far_it_is_on_a_terminal_only(self):
        """A8."""
        text = self.assert_progress_on_a_terminal_only("control", os.path.join(CONFIGS, "3rrr.yaml"), "-t", "cycloid", "-c", "none",
                                                       "--samples", "1500000", "--steps", "1000000000")
        self.assertIn("cycloid: ", text)


if __name__ == "__main__":
    unittest.main()
