"""Specs as they come out of a careless edit: shipped mechanisms with tokens, values or their structure changed, and what may not follow from it."""

import collections
import json
import os
import pathlib
import random
import re
import subprocess
import tempfile

CONFIGS = pathlib.Path(os.environ["CONFIGS"])
PROGRAM = os.environ["BALANCE"]

TOKEN = re.compile(r"[A-Za-z_][\w-]*|\d+\.?\d*(?:[eE][-+]?\d+)?|\S")
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
ODD_TOKENS = ["", "~", "[]", "{}", "''", "[", "}", ":", ",", "- ", "?", "|", "*a", "&a 1", "!!binary x", "!x 1", "%", "@", "`", "\"", "'", "#", "\t",
              "yes", "nan", ".inf", "-", "0,4", "1 2", "x" * 300, "ä", "\x01", "{free: [0, 1]}", "{free: [1, 0]}", "{free: {values: [1, 2]}}",
              "[0, 0]", "[1, 2, 3]", "{x: 1}", "ground", "null", "<<", "1e9999", "(" * 200, "sin()", "a b", "2 * pi", "2024-01-01", "0x10", "1_000"]
ODD_NUMBERS = ["0", "-1", "1e-300", "1e300", "5e-324", "-0", "1e9", "1e-9", "3", "2", "1000", "nan", "inf", ".nan", "1/0", "sqrt(-1)", "0/0", "1e400", "''"]

# Every command in every form, with a file for its output. None may take long.
FORMS = {
    "check": [[], ["--json"], ["--verify"], ["--set", "l=0.1"]],
    "simulate": [["--samples", "5"], ["--samples", "5", "--json"], ["--samples", "5", "-o", "OUT.h5"], ["--samples", "3", "--csv", "OUT.csv"],
                 ["--samples", "5", "--formulation", "natural"], ["--samples", "4", "--split", "--poses", "-o", "OUT.h5"]],
    "control": [["--samples", "3", "--steps", "300"], ["--samples", "3", "--steps", "300", "--json"]],
    "equations": [[], ["--json"], ["--latex"], ["--code", "c"], ["--code", "python"], ["--at", "start"], ["--at", "start", "--json"],
                  ["--at", "start", "-o", "OUT.h5"], ["--only", "conditions"]],
    "conditions": [["-g", "static"], ["-g", "force", "--json"], ["-g", "force-moment", "--latex"], ["-g", "static", "--numbers"]],
    "design": [["--seconds", "0.5"], ["--seconds", "0.5", "--json", "-g", "force"], ["--seconds", "0.5", "-g", "static", "-o", "OUT.yaml"],
               ["--seconds", "0.5", "-g", "static", "--h5", "OUT.h5"]],
    "tolerance": [["--samples", "5"], ["--samples", "5", "--json"], ["--at-rest"], ["--samples", "3", "--monte-carlo", "2"]],
    "modes": [["--exact", "0"], ["--exact", "0", "--json"], ["--orders", "2", "-o", "OUT.h5"]],
    "export": [["-o", "OUT.xml"], ["-o", "OUT.sdf", "--json"], ["-o", "OUT.urdf"]],
    "excite": [["--limit", "rate=2", "--evaluations", "3", "--starts", "1"],
               ["--limit", "rate=2", "--evaluations", "2", "--starts", "1", "--json", "-o", "OUT.yaml"]],
    "compare": [["ORIGINAL"], ["ORIGINAL", "--json", "--require", "peak(torque) <= base"]],
    "plot": [["--script", "--quantity", "shaking_force"], ["--path", "--script"]],
    "report": [["--samples", "3", "-o", "OUT.html"]],
    "import": [[], ["--json"]],
    "batch": [["-o", "OUT", "-q"], ["--list", "--json", "-o", "OUT"]],
}

# A mistake has a place; what is not there, or follows from several numbers, has none.
PLACE = re.compile(r"^\S*\.(yaml|csv|txt):\d+:\d+: |^\S*\.yaml: (tolerances: missing|there is nothing to design|there is no motion|an expression in the spec has no value|trajectories\.)|^--set \w+: ", re.MULTILINE)

Trial = collections.namedtuple("Trial", "config text command options")
Outcome = collections.namedtuple("Outcome", "code out err left")


def sources():
    """The shipped specs that are read and run at once."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(CONFIGS.glob("*.yaml"))}
    slow = ("stewart", "bricard", "watt-six-bar", "squeezer", "3rrr-legs", "delta-legs")
    return {name: text for name, text in texts.items() if not name.startswith(slow)}


def change_token(text, dice):
    tokens = list(TOKEN.finditer(text))
    one = dice.choice(tokens)
    new = dice.choice(ODD_TOKENS) if dice.random() < 0.4 else dice.choice(tokens)[0]
    return text[:one.start()] + new + text[one.end():]


def change_value(text, dice):
    numbers = list(NUMBER.finditer(text))
    if not numbers:
        return text
    one = dice.choice(numbers)
    value = float(one[0])
    new = dice.choice([*ODD_NUMBERS, f"{-value:g}", f"{1e3 * value:g}", f"{value * dice.uniform(-2, 2):.4g}", f"{value:g}deg", one[0].replace(".", ",")])
    return text[:one.start()] + new + text[one.end():]


def change_structure(text, dice):
    lines = text.splitlines(keepends=True)
    i, j = dice.randrange(len(lines)), dice.randrange(len(lines))
    kind = dice.randrange(6)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(j, lines[i])
    elif kind == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif kind == 3:
        lines[i] = " " * dice.randrange(5) + lines[i].lstrip(" ")
    elif kind == 4:
        entries = lines[i].split(",")
        del entries[dice.randrange(len(entries))]
        lines[i] = ",".join(entries)
    else:
        del lines[min(i, j):max(i, j)]
    return "".join(lines)


def make_trial(seed, texts):
    """The same seed gives the same trial."""
    dice = random.Random(seed)
    command = dice.choice(sorted(FORMS))
    config = dice.choice(sorted(name for name in texts if command != "tolerance" or "\ntolerances:" in texts[name]))
    text = texts[config]
    for _ in range(dice.choice([1, 1, 1, 2, 4])):
        text = dice.choice([change_token, change_value, change_value, change_structure])(text, dice)
    return Trial(config, text, command, dice.choice(FORMS[command]))


def run_trial(trial, folder, seconds=60):
    """Writes the spec as it is named in the project, so that its parts and tables are found, and runs the command on it."""
    folder = pathlib.Path(folder)
    for name in ("parts",):
        if not (folder / name).exists():
            (folder / name).symlink_to(CONFIGS / name)
    spec = folder / "mutant.yaml"
    spec.write_text(trial.text, encoding="utf-8")
    operand = spec
    if trial.command == "batch":
        operand = folder / "suite.yaml"
        operand.write_text("cases: {a: {spec: mutant.yaml, samples: 5}}\n", encoding="utf-8")
    before = set(folder.iterdir())
    options = [str(CONFIGS / trial.config) if word == "ORIGINAL" else word.replace("OUT", str(folder / "out")) for word in trial.options]
    try:
        done = subprocess.run([PROGRAM, trial.command, str(operand), *options], capture_output=True, check=False, timeout=seconds, cwd=folder)
        code, out, err = done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")
    except subprocess.TimeoutExpired:
        code, out, err = None, "", ""
    left = sorted(path.name for path in set(folder.iterdir()) - before)
    for name in left:
        subprocess.run(["rm", "-r", str(folder / name)], check=True)
    return Outcome(code, out, err, left)


def faults_of(trial, outcome):
    """What no input may lead to."""
    code, out, err, left = outcome
    faults = []
    if code is None:
        return ["it does not end"]
    if code not in range(6):
        return [f"exit code {code}: {err[-200:]}"]
    if "internal error" in out + err or "Sanitizer" in err:
        faults.append(re.search(r"internal error.*|.*Sanitizer.*", out + err)[0])
    if code == 3 and trial.command not in ("batch", "import") and not PLACE.search(err):
        faults.append("no file:line:column: " + err[:200])
    if "--json" in trial.options and (out or code in (0, 1)):
        try:
            json.loads(out)
        except ValueError:
            faults.append("no JSON: " + out[:100])
    if code >= 2 and trial.command != "batch" and left:
        faults.append(f"it fails and leaves {left}")
    if code == 2 and trial.command not in ("compare", "plot", "control", "batch", "import", "simulate", "design", "conditions", "tolerance", "check"):
        faults.append("a spec is called wrong usage: " + err[:200])
    return faults


def describe(seed, trial, faults):
    return f"seed {seed}: {trial.command} {' '.join(trial.options)} of {trial.config}: {'; '.join(faults)}"


def run_many(seeds, told=print):
    """Trials by seed. @return what was wrong, seed and text of each; how often each command ended with each code"""
    texts, failed, codes = sources(), [], collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            trial = make_trial(seed, texts)
            outcome = run_trial(trial, folder)
            codes[trial.command, outcome.code] += 1
            faults = faults_of(trial, outcome)
            if faults:
                failed.append((seed, trial, faults))
                told(describe(seed, trial, faults))
    return failed, codes
