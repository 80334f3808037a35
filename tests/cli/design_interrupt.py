"""Ctrl-C ends a search: what was found by then is told, and that it was not the time that ended it."""

import json
import signal
import subprocess
import time
import unittest

from _program import PROGRAM, Case
from design_robust import arm
from endings import FOLDED

LONG = "search: {seconds: 600, restarts: 1000}"


class Interrupt(Case):
    def interrupted(self, design, *options):
        # so many places that no machine is done with all starts before it is interrupted
        text = arm(design + ", " + LONG, "{cw.mass: 5%}").replace("[0, 1]}, samples: 11", "[0, 1]}, samples: 5001")
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


if __name__ == "__main__":
    unittest.main()
