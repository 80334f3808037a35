"""Ctrl-C ends a search: what was found by then is told, and that it was not the time that ended it."""

import json
import re
import signal
import subprocess
import time
import unittest

from _program import PROGRAM, Case, run
from _search_problems import problem
from design_robust import arm
from endings import FOLDED

LONG = "search: {seconds: 600, restarts: 1000}"


class Interrupt(Case):
    def interrupted(self, design, *options):
        # so many places that no machine is done with all starts before it is interrupted
        text = arm(design + ", " + LONG, "{cw.mass: 5%}").replace("[0, 1]}, samples: 11", "[0, 1]}, samples: 5001")
        return self.interrupted_text(text, *options)

    def interrupted_text(self, text, *options):
        spec = self.write("spec.yaml", text)
        with subprocess.Popen([PROGRAM, "design", spec, *options], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            time.sleep(2)
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, err)
        return out

    def test_a_design_says_after_how_long(self):
        robust = "minimize: {mean_plus: 3, of: {rms: torque, over: workspace}}"
        text = self.interrupted(robust)
        self.assertRegex(text, r"\noptimality: stopped: interrupted after [1-9](\.\d+)? s \(")
        self.assertNotIn("may take", text)
        told = json.loads(self.interrupted(robust, "--json"))
        self.assertEqual((told["optimality"], told["search"]["ended_by"]), ("stopped", "interrupt"))

    def test_a_balanced_design_is_not_lost(self):
        """With free lengths, where an end of a start is made exact only afterwards."""
        for seed in (16, 352):
            with self.subTest(problem=seed):
                text = problem(seed).replace("samples: 31", "samples: 151").replace("design: {", "design: {" + LONG + ", ")
                text = re.sub(r"at: \[-0[^]]*\], mass", "at: [{free: [-0.25, 0.05]}, {free: [-0.1, 0.1]}], mass", text)
                short = json.loads(run("design", self.write("short.yaml", text), "--json", "--seconds", "0.5").stdout)
                told = json.loads(self.interrupted_text(text, "--json"))
                self.assertEqual((short["status"], told["status"]), ("balanced", "balanced"))

    def test_before_the_search_there_is_nothing_to_write(self):
        """A fold that is followed step by step takes seconds, and is interrupted in the midst of a motion."""
        robust = "design: {minimize: {mean_plus: 3, of: {rms: torque, along: arc}}}\ntolerances: {cw.mass: 1%}\n"
        spec = self.write("folded.yaml", FOLDED + robust)
        with subprocess.Popen([PROGRAM, "design", spec, "-g", "force"], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as process:
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
        self.assertEqual((process.returncode, out), (130, ""), err)
        self.assertIn("interrupted, nothing written", err)

    def test_so_does_a_front(self):
        text = self.interrupted("front: [added-mass, {mean_plus: 3, of: {rms: torque, over: workspace}}]")
        self.assertRegex(text, r"optimality: stopped: the points found until it was interrupted, after [1-9](\.\d+)? s\n")

    def test_so_does_a_front_beside_load_cases(self):
        front = "front: {of: [{peak: shaking_moment, along: go}, {peak: torque, along: go}], points: 100}, for: {cargo: [0, 0.4]}"
        text = problem(12).split("design: {")[0].replace("samples: 31", "samples: 4001") + f"design: {{{front}, {LONG}}}\n"
        told = json.loads(self.interrupted_text(text, "--json"))
        self.assertGreater(len(told["front"]["points"]), 0)


if __name__ == "__main__":
    unittest.main()
