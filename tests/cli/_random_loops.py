"""Random mechanisms with loops whose formulas and programs are held against the engine at other numbers and states."""

import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile

from _program import run

AXES = ("[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]", "[1, 2, 3]", "[0.6, 0, -0.8]", "[1, -1, 0.5]")
FREEDOMS = {"revolute": 1, "prismatic": 1, "cylindrical": 2, "universal": 2, "spherical": 3}


class Spec:
    """A mechanism whose loops close where all coordinates are zero: every body's axes are the world's there."""

    def __init__(self, seed):
        self.rng = random.Random(seed)
        self.planar = self.rng.random() < 0.6
        self.parameters, self.bodies, self.joints, self.actuated = {}, {}, [], []
        self.ground = {}
        self.make_loop(self.joint_types())
        if self.planar and self.rng.random() < 0.35:
            self.add_dyad()
        self.extra = {"counterweights": [], "discs": [], "springs": [], "couplings": []}
        self.add_elements()

    def joint_types(self):
        """Of one loop with one or two freedoms."""
        if self.planar:
            types = ["revolute"] * self.rng.choice((4, 4, 5))
            if self.rng.random() < 0.3:
                types[self.rng.randrange(1, len(types))] = "prismatic"
            return types
        while True:
            types = ["revolute"] + [self.rng.choice(list(FREEDOMS)) for _ in range(self.rng.choice((2, 3, 3)))]
            free = sum(map(FREEDOMS.get, types)) - 6
            # a body between two spherical joints spins, one of four freedoms in a row needs no loop
            if free in (1, 2) and types.count("spherical") < 2:
                return types

    def number(self, value):
        """A plain number, or a parameter with that value."""
        value = round(value, 4)
        if self.rng.random() < 0.6:
            return str(value)
        name = f"p{len(self.parameters)}"
        self.parameters[name] = value
        return name

    def vector(self, values):
        return "[" + ", ".join(self.number(x) for x in values) + "]"

    def place(self, k, count):
        """The k-th corner of a loop."""
        angle, radius = 2 * math.pi * k / count + self.rng.uniform(-0.3, 0.3), self.rng.uniform(0.25, 0.45)
        return [radius * math.cos(angle), radius * math.sin(angle), *([] if self.planar else [self.rng.uniform(-0.15, 0.15)])]

    def add_body(self, name, origin):
        self.bodies[name] = (origin, {})

    def point(self, body, place):
        """The name of a point of a body, or of the ground."""
        origin, points = ([0, 0, 0], self.ground) if body == "ground" else self.bodies[body]
        name = f"P{len(points)}"
        points[name] = self.vector([a - b for a, b in zip(place, origin)])
        return f"{body}.{name}"

    def join(self, name, kind, first, second, place):
        text = f"  {name}: {{type: {kind}, connects: [{self.point(first, place)}, {self.point(second, place)}]"
        if kind == "universal":
            text += ", axis: [0, 0, 1], axis2: [0, 1, 0]"
        elif kind != "spherical" and not self.planar:
            text += f", axis: {self.rng.choice(AXES)}"
        elif kind == "prismatic":
            text += f", axis: {self.rng.choice(('[1, 0]', '[0.6, 0.8]'))}"
        self.joints.append(text + "}")

    def make_loop(self, types):
        count = len(types)
        places = [self.place(k, count) for k in range(count)]
        for k in range(1, count):
            self.add_body(f"b{k}", places[k - 1])
        names = ["ground", *self.bodies, "ground"]
        for k, kind in enumerate(types):
            self.join(f"J{k}", kind, names[k], names[k + 1], places[k])
        self.freedoms = sum(map(FREEDOMS.get, types)) - (3 if self.planar else 6)
        simple = [k for k, kind in enumerate(types) if FREEDOMS[kind] == 1]
        self.actuated = [f"J{k}" for k in simple[: self.freedoms + (self.rng.random() < 0.15)]]

    def add_dyad(self):
        """Two more bodies between two others: a second loop, as many freedoms."""
        first, second = self.rng.sample(["ground", *self.bodies], 2)
        ends = [[self.rng.uniform(-0.5, 0.5), self.rng.uniform(0.4, 0.6)] for _ in range(2)]
        middle = [(a + b) / 2 + self.rng.choice((-0.3, 0.3)) for a, b in zip(*ends)]
        self.add_body("c1", ends[0])
        self.add_body("c2", middle)
        self.join("K1", "revolute", first, "c1", ends[0])
        self.join("K2", "revolute", "c1", "c2", middle)
        self.join("K3", "revolute", "c2", second, ends[1])

    def add_elements(self):
        last = list(self.bodies)[-1]
        corner = self.vector([0.1, -0.05, 0.02][: 2 if self.planar else 3])
        if self.rng.random() < 0.5:
            self.extra["counterweights"].append(f"  w: {{body: b1, at: {corner}, mass: {self.number(1.5)}}}")
        if self.rng.random() < 0.4:
            moments = self.number(0.02) if self.planar else "{axial: 0.02, transverse: 0.012}"
            axis = "" if self.planar else f", axis: {self.rng.choice(AXES)}"
            self.extra["discs"].append(f"  d: {{body: b1, at: {corner}, follows: {self.actuated[0]}, ratio: {self.number(-2)}, inertia: {moments}{axis}}}")
        if self.rng.random() < 0.4:
            hook = self.point("ground", [0.6, 0.5, 0.1][: 2 if self.planar else 3]).split(".")[1]
            end = next(iter(self.bodies[last][1]))
            self.extra["springs"].append(f"  s: {{between: [ground.{hook}, {last}.{end}], stiffness: {self.number(60)}, free_length: {self.rng.choice(('0', '0.2'))}}}")
        if self.rng.random() < 0.3:
            self.extra["springs"].append(f"  t: {{joint: {self.actuated[0]}, stiffness: {self.number(5)}, rest: 0.2}}")

    def text(self):
        inertia = "0.03" if self.planar else "[0.03, 0.035, 0.04]"
        lines = [f"space: {'planar' if self.planar else 'spatial'}", f"gravity: {[1.5, -9.81] if self.planar else [0, 1.5, -9.81]}", "bodies:"]
        for name, (_, points) in self.bodies.items():
            com = self.vector([self.rng.uniform(-0.1, 0.1) for _ in range(2 if self.planar else 3)])
            inside = ", ".join(f"{point}: {at}" for point, at in points.items())
            lines.append(f"  {name}: {{mass: {self.number(self.rng.uniform(0.5, 2))}, com: {com}, inertia: {inertia}, points: {{{inside}}}}}")
        lines += ["joints:", *self.joints]
        for section, members in self.extra.items():
            lines += [f"{section}:", *members] if members else []
        ground = ", ".join(f"{point}: {at}" for point, at in self.ground.items())
        parameters = ", ".join(f"{name}: {value}" for name, value in {"unused": 1, **self.parameters}.items())
        lines += [f"ground: {{points: {{{ground}}}}}", f"parameters: {{{parameters}}}", f"actuators: [{', '.join(self.actuated)}]", ""]
        return "\n".join(lines)


def engine(path, changes, state):
    """The independent coordinates, actuators and torques that `--at` finds at a state; a text if there is none."""
    done = run("equations", path, *state, "--only", "torques", "--json", *changes)
    if done.returncode != 0:
        return done.stderr
    answer = json.loads(done.stdout)
    return {"independent": answer["independent"], "pose": list(answer["configuration"].values()), "torques": {name: one["sum"] for name, one in answer.get("torques", {}).items()}}


def python_torques(text, values, rates, accelerations):
    """What a printed Python program says: torques of the motors, in their order, and the pose."""
    call = f"\nprint(__import__('json').dumps(torques(prepare(GIVEN), {values}, {rates}, {accelerations})))\n"
    done = subprocess.run([sys.executable, "-c", text.split("\nif __name__")[0] + call], text=True, check=False, capture_output=True)
    return json.loads(done.stdout) if done.returncode == 0 else done.stderr.strip().splitlines()[-1]


def runs(language, text, folder):
    """What a program's own test says; nothing if it is passed."""
    if language == "python":
        done = subprocess.run([sys.executable, "-"], input=text, text=True, check=False, capture_output=True)
    else:
        program = os.path.join(folder, "program")
        built = subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-x", "c", "-", "-lm", "-o", program], input=text, text=True, check=False,
                               capture_output=True)
        if built.returncode != 0:
            return built.stderr.strip()[:300]
        done = subprocess.run([program], text=True, check=False, capture_output=True)
    return None if done.returncode == 0 else f"{done.stdout} {done.stderr}".strip()


def fault(seed):
    """What is wrong with the formulas or programs of one mechanism, or nothing."""
    spec = Spec(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "spec.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(spec.text())
        return compare(path, spec, folder, random.Random(-seed))


def compare(path, spec, folder, rng):
    zero = ["--at", ",".join(f"{name}=0" for name in spec.actuated[: spec.freedoms])]
    start = engine(path, [], zero)
    if not isinstance(start, dict) or len(start["independent"]) != spec.freedoms:
        return None  # singular, or it has other freedoms than counted
    for sections in ("reduced", "solved,efforts"):
        formulas = run("equations", path, "--only", sections)
        if formulas.returncode not in (0, 4) or (formulas.returncode == 4 and "too long" not in formulas.stderr):
            return f"{sections}: {formulas.returncode} {formulas.stderr.strip()}"
    changes = [part for name, value in spec.parameters.items() if rng.random() < 0.3 for part in ("--set", f"{name}={value * rng.uniform(0.95, 1.05):.4f}")]
    names = start["independent"]
    state = {key: [round(rng.uniform(-size, size), 3) for _ in names] for key, size in (("--at", 0.15), ("--rates", 1), ("--accelerations", 2))}
    call = [part for key, row in state.items() for part in (key, ",".join(f"{name}={x}" for name, x in zip(names, row)))]
    expected = engine(path, changes, call)
    for language in ("python", "c") if shutil.which("cc") else ("python",):
        for coordinates in ("independent", "all"):
            code = run("equations", path, "--code", language, "--coordinates", coordinates, *changes)
            if code.returncode != 0:
                if "no pose" in code.stderr or not isinstance(expected, dict):
                    continue  # these numbers close no loops
                return f"{language}: {code.returncode} {code.stderr.strip()}"
            if wrong := runs(language, code.stdout, folder):
                return f"{language}, {coordinates}: {wrong}"
            if language == "c" or coordinates == "all" or not isinstance(expected, dict) or not expected["torques"]:
                continue
            found = python_torques(code.stdout, *state.values())
            right = list(expected["torques"].values())
            if isinstance(found, str) and "NotSolved" in found:
                continue  # a singularity lies between the start and this state
            if isinstance(found, list):
                found, pose = found
                if any(min(abs(math.remainder(a - b, 2 * math.pi)) for b in expected["pose"]) > 1e-6 for a in pose):
                    continue  # another assembly mode is nearer to the rough values than the one that continues the start's
            if isinstance(found, str) or any(abs(a - b) > 1e-9 * max(1e-2, *map(abs, right)) for a, b in zip(found, right, strict=True)):
                return f"{language}: {found} in place of {right}"
    return None
