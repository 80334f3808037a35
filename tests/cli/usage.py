"""Options, help, exit codes and who says what where."""

import json
import os
import re
import signal
import subprocess
import time
import unittest

from _four_bar import SHORT, four_bar
from _program import CONFIGS, PROGRAM, SPEC, Case, run, unwrapped
from _sampling import draw, traits_of

# A four-bar that cannot be assembled.
BROKEN = SHORT + """\
motion: {duration: 1, samples: 11, from: {joints: {A: 0}}, to: {joints: {A: 1}}}
trajectories: {turn: {law: cycloidal, drive: joints}}
"""


class Usage(Case):
    def test_help_and_version_are_results(self):
        self.assertIn("balance simulate", run("--help").stdout)
        for command in ("check", "compare", "conditions", "design", "simulate"):
            done = run(command, "--help")
            self.assert_quiet_success(done)
            self.assertIn("balance " + command, done.stdout)
        done = run("--version")
        self.assert_quiet_success(done)
        self.assertRegex(done.stdout, r"^balance \d+\.\d+\.\d+\n$")

    def test_check_names_the_joint_that_stays_open(self):
        """(D6) A loop that cannot be closed: which joint, and by how much at best."""
        for lengths, gap in (((1, 0.2, 0.2, 0.2), 0.4), ((0.5, 0.1, 0.9, 0.2), 0.1), ((0.3, 0.7, 0.15, 0.2), 0.05)):
            done = run("check", self.write("open.yaml", four_bar(*lengths)))
            self.assertEqual(done.returncode, 4, done.stderr)
            found = re.search(r"the loops cannot be closed: joint ([ABCD]) stays open by (\S+) m", done.stdout + done.stderr)
            self.assertTrue(found, done.stdout + done.stderr)
            self.assertAlmostEqual(float(found[2]), gap, places=5)

    def test_wrong_usage_ends_with_2_and_says_what_is_wrong(self):
        for arguments, part in (
            (["simulat", SPEC], "nearest is 'simulate'"),
            (["foo", SPEC], "'foo' is not a command: expected new, check, "),
            (["--quiet"], "balance has no option '--quiet'"),
            (["--force", "check", SPEC], "balance has no option '--force'"),
            (["--hlep"], "balance has no option '--hlep'; nearest is '--help'"),
            (["check"], "no spec given"),
            (["check", SPEC, "--nosuch"], "balance check has no option '--nosuch'\n"),
            (["check", "--jsno", SPEC], "balance check has no option '--jsno'; nearest is '--json'"),
            (["simulate", SPEC, "--trajektory", "cycloid"], "balance simulate has no option '--trajektory'; nearest is '--trajectory'"),
            (["simulate", SPEC, "--traj=cycloid"], "balance simulate has no option '--traj'; nearest is '--trajectory'"),
            (["check", SPEC, SPEC], f"unexpected argument '{SPEC}': balance check takes SPEC\n"),
            (["check", SPEC, "simulate", SPEC], "unexpected argument 'simulate'"),
            (["simulate", SPEC, "-o"], "--output needs a value: FILE"),
            (["simulate", SPEC, "-o", "a.h5", "-o", "b.h5"], "--output is given more than once"),
            (["simulate", SPEC, "--json=perhaps"], "--json takes no value"),
            (["plot", SPEC, "--path", "--phase", "-o", "a.svg"], "--path and --phase cannot be combined"),
            (["export", SPEC], "balance export needs --output FILE: the file to write"),
            (["tolerance", SPEC, "--seed", "3"], "--seed needs --monte-carlo"),
            (["tolerance", SPEC, "--seed", "-3"], "--seed: expected a whole number from 0 to 9007199254740991, found '-3'"),
            (["compare", "a.h5", "b.h5", "--format", "markdwon"], "--format: expected text, markdown, csv, json or junit, found 'markdwon'; nearest is 'markdown'"),
            (["design", SPEC, "--seconds", "0,5"], "--seconds: expected a number from 0.001 to 1000000000, found '0,5'; use a decimal point: 0.5"),
            (["simulate", SPEC, "--samples", "2.5"], "--samples: expected a whole number from 2 to "),
            (["check", SPEC, "--set", "length=1"], "--set length: "),
            (["check", SPEC, "--set", "l=1+"], "--set l: "),
            (["check", SPEC, "--set", "l"], "--set needs name=value, not 'l'"),
            (["simulate", SPEC, "-t", "cycloid", "--samples", "1"], "--samples"),
            (["simulate", SPEC, "-t", "cycloid", "--samples", "many"], "--samples"),
            (["simulate", SPEC, "-t", "cycloid", "--duration", "0"], "--duration: expected a number from 1e-09 to 1000000000, found '0'"),
            (["simulate", SPEC, "-t", "cycloid", "--duration", "nan"], "--duration: expected a number from 1e-09 to 1000000000, found 'nan'"),
            (["simulate", SPEC, "-t", "cycloid", "--about", "1,2,3"], "--about needs x,y in metres, not '1,2,3'"),
            (["simulate", SPEC, "-t", "cycloid", "--about", "1,x"], "--about needs x,y"),
            (["simulate", SPEC, "-t", "cycloid", "--compress"], "--output"),
            (["simulate", SPEC, "-t", "cyclod"], "has no trajectory 'cyclod', only "),
            (["simulate", SPEC, "-t", "cyclod"], "nearest is 'cycloid'"),
        ):
            with self.subTest(arguments=arguments):
                done = run(*arguments)
                self.assert_failure(done, 2, part)
                self.assertEqual(done.stdout, "")

    def test_no_text_of_the_parser_is_left(self):
        """Every way to call every command wrongly that its own options make possible."""
        theirs = re.compile(r"is required|requires|excludes|not expected|Could not convert|not in range|missing$|At Most|: At least|--help for|required but", re.IGNORECASE | re.MULTILINE)
        calls = []
        listed = run("--help").stdout.split("Examples:\n", 1)[0]
        for command in re.findall(r"^  ([a-z0-9-]+)  ", listed, re.MULTILINE):
            heads = re.findall(r"^  (-\S+)( [A-Z]\S*)?", run(command, "--help").stdout, re.MULTILINE)
            calls += [[command], [command, "--xyz"], [command, "a", "b", "c", "d", "--xyz"]]
            for names, value in heads:
                name = names.split(",")[-1]
                calls += ([[command, SPEC, name], [command, SPEC, name + "=?"], [command, SPEC, name, "?", name, "?"]] if value else
                          [[command, SPEC, name + "=?"]])

        def command_and_option(call):
            return {call[0], *(word.split("=")[0] for word in call[2:3])}

        for call in draw("wrong calls", calls, 0.2, command_and_option):
            done = run(*call, cwd=self.folder)
            self.assertIn(done.returncode, range(6), call)
            if done.returncode == 2:
                self.assertNotRegex(done.stderr, theirs, call)

    def test_a_missing_operand_is_looked_for_in_the_folder(self):
        said = "error: no spec given; this folder contains spec.yaml\nbalance simulate --help shows the usage\n"
        self.write("spec.yaml", "")
        done = run("simulate", "--trajectory", "cycloid", cwd=self.folder)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", said))
        self.write("other.yml", "")
        self.assert_failure(run("check", cwd=self.folder), 2, "no spec given; this folder contains other.yml, spec.yaml\n")
        self.write("run.h5", "")
        self.assert_failure(run("plot", cwd=self.folder), 2, "no run given; this folder contains other.yml, run.h5, spec.yaml\n")
        for i in range(9):
            self.write(f"{i}.yaml", "")
        self.assert_failure(run("batch", cwd=self.folder), 2, "no suite given: balance batch needs the suite, a YAML file\n")

    def test_ctrl_c_says_that_nothing_is_written(self):
        out = self.path("out.h5")
        for number in (signal.SIGINT, signal.SIGTERM):
            with subprocess.Popen([PROGRAM, "simulate", SPEC, "--samples", "2000001", "-q", "-o", out], stderr=subprocess.PIPE, text=True) as process:
                time.sleep(0.3)
                process.send_signal(number)
                self.assertEqual(process.communicate(timeout=60)[1], "interrupted, nothing written\n")
            self.assertEqual((process.returncode, os.listdir(self.folder)), (128 + number, []))

    def test_a_spec_is_named_with_its_trajectory(self):
        with_colon = run("simulate", SPEC + ":bang-bang", "--samples", "11", "--json")
        self.assert_quiet_success(with_colon)
        self.assertEqual(json.loads(with_colon.stdout)["trajectory"], "bang-bang")
        self.assert_failure(run("simulate", SPEC + ":bang-bang", "-t", "cycloid"), 2, "two trajectories are named: 'bang-bang' and 'cycloid'")
        self.assert_failure(run("simulate", SPEC + ":bong-bang"), 2, "nearest is 'bang-bang'")

    def test_a_wrong_spec_ends_with_3_at_file_line_and_column(self):
        spec = self.write("wrong.yaml", "space: planar\nbodies: {a: {mas: 1}}\n")
        for command in ("check", "simulate"):
            done = run(command, spec)
            self.assert_failure(done, 3)
            self.assertRegex(done.stderr, r"^" + spec + r":\d+:\d+: ")
            self.assertEqual(done.stdout, "")

    def test_a_spec_without_a_motion_cannot_be_simulated(self):
        spec = self.write("still.yaml", BROKEN.split("motion:", maxsplit=1)[0])
        self.assert_failure(run("simulate", spec), 3, spec, "no motion")

    def test_a_mechanism_that_cannot_do_it_ends_with_4_and_writes_nothing(self):
        spec = self.write("short.yaml", BROKEN)
        done = run("simulate", spec, "-t", "turn", "-o", self.path("out.h5"))
        self.assert_failure(done, 4)
        self.assertTrue(done.stderr.startswith("error: "), done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(os.listdir(self.folder), ["short.yaml"])
        self.assert_failure(run("check", spec), 4, "error: ")

    def test_a_missing_spec_ends_with_5(self):
        self.assert_failure(run("check", self.path("none.yaml")), 5, self.path("none.yaml"), "No such file")

    def test_json_errors_are_one_document_on_stdout_and_the_message_on_stderr(self):
        short = self.write("short.yaml", BROKEN)
        wrong = self.write("wrong.yaml", "space: plana\n")
        for kind, code, arguments in (
            ("usage", 2, ["check", "--nosuch", SPEC]),
            ("usage", 2, ["simulate", SPEC, "-t", "cyclod"]),
            ("spec", 3, ["check", wrong]),
            ("mechanism", 4, ["simulate", short, "-t", "turn"]),
            ("mechanism", 4, ["check", short]),
            ("system", 5, ["check", self.path("none.yaml")]),
        ):
            with self.subTest(arguments=arguments):
                done = run(*arguments, "--json")
                error = json.loads(done.stdout)["error"]
                self.assertEqual((done.returncode, error["kind"]), (code, kind))
                self.assertIn(error["message"], done.stderr)
                if kind == "mechanism":
                    self.assertIn(error["status"], ("not-assembled", "unreachable"))

    def test_check_says_what_the_mechanism_is(self):
        done = run("check", SPEC)
        self.assert_quiet_success(done)
        # 7 coordinates, two loops of two equations each: three freedoms; every leg has two elbows.
        freedom = "degrees of freedom  3 (7 coordinates - 4 independent of 4 closure equations); by counting 3\n"
        self.assertIn(freedom, unwrapped(done.stdout))
        self.assertEqual(done.stdout.count("assembly: {"), 8)
        report = json.loads(run("check", SPEC, "--json").stdout)
        self.assertEqual((report["degrees_of_freedom"], len(report["loops"]), len(report["modes"])), (3, 2, 8))
        self.assertAlmostEqual(report["total_mass"], 9, places=12)
        # P3 section 4.1: the centre of mass where H starts
        self.assertAlmostEqual(report["com"][0], -0.0669026392, places=9)
        self.assertAlmostEqual(report["com"][1], -0.0386231395, places=9)

    def test_every_assembly_line_picks_its_mode(self):
        report = json.loads(run("check", SPEC, "--json").stdout)
        with open(SPEC, encoding="utf-8") as file:
            lines = file.read().splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith("assembly:"))
        for mode in report["modes"]:
            spec = self.write("mode.yaml", "\n".join([*lines[:start], mode["assembly"], *lines[start + 1:]]))
            picked = [m for m in json.loads(run("check", spec, "--json").stdout)["modes"] if m["selected"]]
            self.assertEqual(len(picked), 1)
            for name, value in mode["coordinates"].items():
                self.assertAlmostEqual(picked[0]["coordinates"][name], value, places=6)

    def test_without_a_trajectory_the_first_one_is_taken_and_said(self):
        done = run("simulate", SPEC, "--samples", "11")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"^note: no --trajectory given: using '.*', the first in the spec\n$")
        self.assertEqual(run("simulate", SPEC, "--samples", "11", "--quiet").stderr, "")

    def test_a_parameter_can_be_overridden(self):
        report = json.loads(run("check", "--set", "l=0.2", SPEC, "--set", "xg=0.1", "--json").stdout)
        with open(SPEC, encoding="utf-8") as file:
            text = file.read()
        spec = self.write("longer.yaml", text.replace("{l: 0.18", "{l: 0.2").replace("xg: 0.09", "xg: 0.1"))
        written = json.loads(run("check", spec, "--json").stdout)
        self.assertEqual(report["start"], written["start"])
        self.assertNotEqual(report["start"], json.loads(run("check", SPEC, "--json").stdout)["start"])

    def test_overrides_change_the_run(self):
        def metrics(*options):
            done = run("simulate", SPEC, "-t", "cycloid", "--json", *options)
            self.assert_quiet_success(done)
            result = json.loads(done.stdout)
            return result, {metric["quantity"]: metric for metric in result["metrics"]}

        result, base = metrics("--samples", "2001")
        self.assertEqual((result["samples"], result["duration"], result["files"]), (2001, 0.1, []))
        # The published figures for this motion, recomputed by two formulations
        self.assertAlmostEqual(base["shaking_force"]["peak"], 869.7458473278, places=6)
        self.assertAlmostEqual(base["shaking_force"]["peak_time"], 0.07505, places=12)
        self.assertAlmostEqual(base["shaking_moment"]["peak"], 57.30320609995, places=6)
        _, slow = metrics("--samples", "2001", "--duration", "0.2")
        # Twice the time: a quarter of every acceleration
        self.assertAlmostEqual(slow["shaking_force"]["peak"], base["shaking_force"]["peak"] / 4, places=6)
        moved, elsewhere = metrics("--samples", "2001", "--about", "-1,0.5")
        self.assertEqual(moved["about"], [-1, 0.5])
        self.assertEqual(elsewhere["shaking_force"], base["shaking_force"])
        self.assertNotAlmostEqual(elsewhere["shaking_moment"]["peak"], base["shaking_moment"]["peak"], places=3)

    def test_every_config_can_be_asked_for_json(self):
        specs = [os.path.join(CONFIGS, name) for name in sorted(os.listdir(CONFIGS)) if name.endswith(".yaml")]
        for spec in draw("configs as JSON", specs, 0.2, traits_of):
            self.assertIsInstance(json.loads(run("check", spec, "--json").stdout), dict, spec)

    def test_a_result_that_does_not_arrive_is_a_failure(self):
        for arguments in (["--help"], ["--version"], ["check", SPEC], ["check", SPEC, "--json"],
                          ["simulate", SPEC, "-t", "cycloid", "--samples", "11"], ["check", "--nosuch", "--json"]):
            with self.subTest(arguments=arguments), open("/dev/full", "w", encoding="utf-8") as full:
                self.assert_failure(run(*arguments, stdout=full), 5)

    def test_a_closed_stdout_is_a_failure_and_no_file_takes_its_place(self):
        out = self.path("out.h5")
        done = run("simulate", SPEC, "-t", "cycloid", "--samples", "11", "-o", out, stdout=None,
                   preexec_fn=lambda: os.close(1))
        self.assert_failure(done, 5, "standard output")
        with open(out, "rb") as file:
            self.assertNotIn(b"quantity  ", file.read())


if __name__ == "__main__":
    unittest.main()
