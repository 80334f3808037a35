"""Nothing that is taken away from a spec ends the interpreter, nor is an error of the program's own: questions are asked in a child process."""

import json
import os
import random
import subprocess
import sys
import unittest

from _module import Case, CONFIGS

import _taken_away
from _sampling import SEED, WHOLE

CASES, AT_ONCE = (240, 12) if WHOLE else (60, 20)
# Asks all questions of the specs whose paths it is given, says each before it asks, and what is not one of the documented exceptions.
CHILD = """
import sys
import warnings
import numpy as np
import balance_mechanisms as bm

warnings.simplefilter("ignore")
QUESTIONS = {
    "check": lambda spec: spec.check(),
    "dof": lambda spec: (spec.mechanism.dof, spec.mechanism.total_mass, spec.mechanism.parameters, spec.mechanism.bodies),
    "simulate": lambda spec: spec.simulate(samples=3).metrics,
    "natural": lambda spec: spec.simulate(samples=3, formulation="natural"),
    "control": lambda spec: spec.control("none", samples=3),
    "pd": lambda spec: spec.control("pd", samples=3),
    "tolerance": lambda spec: spec.tolerance(samples=3),
    "at rest": lambda spec: spec.tolerance(at_rest=True),
    "state": lambda spec: state(bm.InverseDynamics(spec.mechanism)),
    "parts": lambda spec: bm.parts(spec),
}
for goal in bm.GOALS:
    QUESTIONS[f"conditions {goal}"] = lambda spec, goal=goal: spec.conditions(goal).latex()


def state(engine):
    zeros = np.zeros(engine.dof)
    for ask in (lambda: engine.rows(zeros[None], zeros[None], zeros[None]), lambda: engine.at(zeros, zeros, zeros), lambda: engine.mass_matrix(zeros),
                lambda: engine.bias(zeros, zeros), lambda: engine.regressor(zeros, zeros, zeros)):
        try:
            ask()
        except bm.MechanismError:
            pass


for path, name in zip(sys.argv[1::2], sys.argv[2::2]):
    try:
        spec = bm.load(path)
    except bm.SpecError:
        continue
    print(path, name, flush=True)
    try:
        QUESTIONS[name](spec)
    except (bm.SpecError, bm.MechanismError):
        pass
    except ValueError as error:
        if not str(error):
            raise
"""


class TakenAway(Case):
    def test_a_sample_of_all_specs(self):
        questions = ["check", "dof", "simulate", "natural", "control", "pd", "tolerance", "at rest", "state", "parts",
                     *(f"conditions {goal}" for goal in ("force", "moment", "static", "dynamic"))]
        cases = [(case, name) for case in _taken_away.cases() for name in questions]
        cases = random.Random(SEED).sample(cases, CASES)
        for part in os.scandir(CONFIGS):
            if not part.name.endswith(".yaml"):
                os.symlink(part.path, self.path(part.name))
        findings = []
        while cases:
            words, asked = [], {}
            for (path, way), name in cases[:AT_ONCE]:
                spec = _taken_away.taken(_taken_away.read(os.path.join(CONFIGS, path)), way)
                words += [self.write(f"{len(asked)}.yaml", spec), name]
                asked[f"{words[-2]} {name}"] = (path, way, name)
            del cases[:AT_ONCE]
            done = subprocess.run([sys.executable, "-c", CHILD, *words], capture_output=True, text=True, check=False, timeout=300)
            if done.returncode != 0:
                last = done.stdout.splitlines()[-1] if done.stdout else words[0]
                findings.append((asked.get(last, last), done.returncode, done.stderr[-500:]))
        self.assertEqual(findings, [], f"SEED={SEED} " + json.dumps(findings, indent=1))


if __name__ == "__main__":
    unittest.main()
