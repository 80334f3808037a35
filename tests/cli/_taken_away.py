"""Specs with something taken away, the ways to ask about them, and what every answer must be."""

import itertools
import json
import os
import pathlib
import re
import subprocess
import tempfile

import yaml

from _program import CONFIGS, PROGRAM, SLOWNESS

# README.md, "exit code"; 128 + n is none of them.
EXIT_CODES = {0, 1, 2, 3, 4, 5}
PLAIN = re.compile(r"[A-Za-z_][\w.]*|[-+]?[\d.]+(e[-+]?\d+)?")
# Sections of a spec that name joints, and what is left of them when one is gone.
OF_JOINTS = ("actuators", "assembly", "friction", "couplings", "springs", "constraints", "control")
OF_MOTION = ("motion", "trajectories", "control", "controllers", "design", "tolerances", "requirements")


def read(path):
    """The spec as nested lists, mappings and texts."""
    with open(path, encoding="utf-8") as file:
        return yaml.load(file, Loader=yaml.BaseLoader)


def text(node):
    """YAML in one line, scalars as they were."""
    if isinstance(node, dict):
        return "{" + ", ".join(f"{text(key)}: {text(value)}" for key, value in node.items()) + "}"
    if isinstance(node, list):
        return "[" + ", ".join(map(text, node)) + "]"
    return node if PLAIN.fullmatch(node) else json.dumps(node, ensure_ascii=False)


def spec_text(spec):
    return "".join(f"{key}: {text(value)}\n" for key, value in spec.items())


def specs():
    """Every spec of the project, by its path in CONFIGS."""
    folder = pathlib.Path(CONFIGS)
    found = [*folder.glob("*.yaml"), *folder.glob("poses/*.yaml"), *folder.glob("starters/*.yaml"), *folder.glob("machines/*.yaml")]
    return sorted(str(path.relative_to(folder)) for path in found)


def mentions(node, name):
    """Whether the node says the name of a joint, or of one of its coordinates."""
    if isinstance(node, dict):
        return any(mentions(part, name) for pair in node.items() for part in pair)
    if isinstance(node, list):
        return any(mentions(part, name) for part in node)
    return re.search(rf"(?<![\w.]){re.escape(name)}(?!\w)", node) is not None


def without_mention(node, name):
    """The node without those of its parts that say the name."""
    if isinstance(node, dict):
        return {key: without_mention(value, name) for key, value in node.items()
                if not mentions(key, name) and not (isinstance(value, str) and mentions(value, name))}
    if isinstance(node, list):
        return [without_mention(part, name) for part in node if not mentions(part, name)]
    return node


def without_joint(spec, name):
    spec["joints"] = {key: value for key, value in spec["joints"].items() if key != name}
    for section in (*OF_JOINTS, "motion", "trajectories"):
        if section in spec:
            spec[section] = without_mention(spec[section], name)


def without_mobility(spec):
    """Every joint holds."""
    for joint in spec.get("joints", {}).values():
        kept = {key: value for key, value in joint.items() if key in ("connects", "angle", "rotation")}
        joint.clear()
        joint.update({"type": "fixed"}, **kept)
    for section in (*OF_JOINTS, "motion", "trajectories", "discs"):
        spec.pop(section, None)
    spec["actuators"] = []


def at_start(node):
    """Free numbers at their start, or in the middle."""
    if isinstance(node, dict) and "free" in node and set(node) <= {"free", "start", "step"}:
        sizes = node["free"]
        low, high = (sizes["values"][0],) * 2 if isinstance(sizes, dict) else sizes
        return node.get("start", f"({low} + {high}) / 2")
    if isinstance(node, dict):
        return {key: at_start(value) for key, value in node.items()}
    return [at_start(part) for part in node] if isinstance(node, list) else node


def massless(body):
    body["mass"] = "0"
    body.pop("inertia", None)


def point(body, planar):
    body["inertia"] = "0" if planar else ["0", "0", "0"]


def ways_to_take(spec):
    """Names of what can be taken away, with the function that takes it from a copy of the spec."""
    def set_to(key, value):
        return lambda s: s.__setitem__(key, value)

    def all_bodies(change):
        return lambda s: [change(body) for body in s.get("bodies", {}).values() if isinstance(body, dict)]

    planar = spec.get("space") == "planar"
    ways = {"nothing": lambda s: None, "gravity": lambda s: s.pop("gravity", None), "actuators": set_to("actuators", []),
            "mobility": without_mobility, "tool": lambda s: s.pop("tool", None),
            "all masses": all_bodies(massless), "all extents": all_bodies(lambda body: point(body, planar)),
            "free numbers": lambda s: s.update(at_start(s)),
            "all but two samples": lambda s: s.get("motion", {}).__setitem__("samples", "2"),
            "all but one sample": lambda s: s.get("motion", {}).__setitem__("samples", "1")}
    for section in ("motion", "assembly", "counterweights", "payloads", "springs", "loads", "couplings", "parameters"):
        if section in spec:
            ways[section] = lambda s, key=section: s.pop(key)
    for body in spec.get("bodies", {}):
        if isinstance(spec["bodies"][body], dict):
            ways[f"mass of {body}"] = lambda s, key=body: massless(s["bodies"][key])
            ways[f"extent of {body}"] = lambda s, key=body: point(s["bodies"][key], planar)
    for joint in spec.get("joints", {}):
        ways[f"joint {joint}"] = lambda s, key=joint: without_joint(s, key)
    return ways


def taken(spec, way):
    """The spec's text without it."""
    copy = json.loads(json.dumps(spec))
    ways_to_take(spec)[way](copy)
    return spec_text(copy)


# Every command in its forms; {spec} and {out} stand for paths. What is searched and drawn at random is short.
SEARCH = "--seconds 1 --starts 2"
GOALS = ("force", "moment", "static", "dynamic")
FORMS = (
    "check {spec}", "check {spec} --json", "check {spec} --verify",
    "modes {spec} --exact 0", "modes {spec} --exact 0 --json",
    *(f"export {{spec}} -o {{out}}.{suffix}" for suffix in ("xml", "sdf", "urdf")), "export {spec} -o {out}.xml --json",
    "excite {spec} --limit rate=2 --evaluations 3 --starts 1", "excite {spec} --limit rate=2 --evaluations 3 --starts 1 --json -o {out}.yaml",
    "simulate {spec}", "simulate {spec} --json", "simulate {spec} --split --csv {out}.csv --json", "simulate {spec} --samples 2 -o {out}.h5 --split",
    "simulate {spec} --samples 2 --csv {out}.csv", "simulate {spec} --formulation natural --json",
    *(f"conditions {{spec}} -g {goal}{form}" for goal in GOALS for form in ("", " --json", " --latex")),
    "conditions {spec}", "conditions {spec} --json --strategy modular -g force",
    *(f"design {{spec}} -g {goal} {SEARCH}{form}" for goal in GOALS for form in ("", " --json -o {out}.yaml --h5 {out}.h5")),
    f"design {{spec}} {SEARCH} --json",
    "equations {spec}", "equations {spec} --json", "equations {spec} --latex", "equations {spec} --code c", "equations {spec} --code python",
    "equations {spec} --numbers", "equations {spec} --expand --json", "equations {spec} --at start", "equations {spec} --at start --json",
    "equations {spec} --at end --latex", "equations {spec} --at start -o {out}.h5", "equations {spec} --only conditions",
    "equations {spec} --only reduced", "equations {spec} --only solved,efforts", "equations {spec} --code c --coordinates all",
    "tolerance {spec}", "tolerance {spec} --json", "tolerance {spec} --at-rest --json", "tolerance {spec} --monte-carlo 3 --samples 5",
    "tolerance {spec} -o {out}.h5",
    "control {spec} --json", "control {spec} -c none", "control {spec} -c pd --json", "control {spec} -c computed-torque -o {out}.h5",
    "report {spec} -o {out}.html --samples 5 --seconds 1", "plot {spec} -o {out}.svg", "compare {spec} {spec} --json",
)


class Judge:
    """Runs the program, and says what is wrong with how it ended."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        for part in pathlib.Path(CONFIGS).iterdir():
            if part.suffix != ".yaml":
                (self.folder / part.name).symlink_to(part)

    def run(self, spec, form):
        """What is wrong, or None. @param spec its text"""
        path, before = self.folder / "taken.yaml", {entry.name for entry in self.folder.iterdir()} | {"taken.yaml"}
        path.write_text(spec, encoding="utf-8")
        arguments = form.format(spec=path, out=self.folder / "out").split()
        max_seconds = 60
        try:
            done = subprocess.run([PROGRAM, *arguments], capture_output=True, check=False, timeout=max_seconds * SLOWNESS, cwd=self.folder)
            return self.fault(done, arguments, [entry for entry in self.folder.iterdir() if entry.name not in before])
        except subprocess.TimeoutExpired:
            return f"does not end within {max_seconds} s"
        finally:  # whatever came of it, the next case finds an empty folder
            for entry in self.folder.iterdir():
                if entry.name not in before:
                    entry.unlink()

    @staticmethod
    def fault(done, arguments, written):
        errors = done.stderr.decode("utf-8", "replace")
        if done.returncode < 0:
            return f"died of signal {-done.returncode}"
        if done.returncode not in EXIT_CODES:
            return f"exit code {done.returncode}"
        if "internal error" in errors or b"internal error" in done.stdout:
            return "internal error: " + errors.strip()[-300:]
        if done.returncode == 5:  # files and system are as they should be
            return f"exit code {done.returncode}: " + errors.strip()[-300:]
        if done.returncode != 0 and not errors.strip() and not done.stdout.strip():
            return f"exit code {done.returncode} without a word"
        if "--json" in arguments:
            try:
                json.loads(done.stdout, parse_constant=lambda name: float(name))
            except ValueError as error:
                return f"no JSON: {error}; {done.stdout[:200]!r}"
        asked = {os.path.basename(word) for word in arguments if "/out." in word}
        names = {entry.name for entry in written}
        if names - asked:
            return f"leaves {sorted(names - asked)}"
        if done.returncode == 0 and asked - names and arguments[0] not in ("design", "compare"):
            return f"does not write {sorted(asked - names)}"
        # a controlled run that ends early leaves the samples up to there (docs/control.md)
        early = arguments[0] == "control" and done.returncode == 4
        if done.returncode in (3, 4) and names and not early:
            return f"exit code {done.returncode}, and leaves {sorted(names)}"
        return None


def cases():
    """(path of the spec in CONFIGS, what is taken away) of all of them."""
    for path in specs():
        for way in ways_to_take(read(os.path.join(CONFIGS, path))):
            yield path, way


def all_cases():
    return [(path, way, form) for (path, way), form in itertools.product(cases(), FORMS)]


def find(chosen, until=lambda: False):
    """Findings of the cases: (spec, what is taken away, form, what is wrong). @param until asked before each whether to stop"""
    with tempfile.TemporaryDirectory() as folder:
        judge, read_specs, tried = Judge(folder), {}, 0
        findings = []
        for path, way, form in chosen:
            if until():
                break
            spec = read_specs.setdefault(path, read(os.path.join(CONFIGS, path)))
            fault = judge.run(taken(spec, way), form)
            tried += 1
            if fault:
                findings.append((path, way, form, fault))
        return findings, tried
