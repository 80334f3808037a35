"""Random mechanisms whose formulas and programs are held against the engine at other numbers."""

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile

from _program import run

AXES = ("[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]", "[1, 2, 3]", "[0.6, 0, -0.8]", "[u, 1, 0.5]", "[u, 0, 0]")
POSE = 0.4  # rad or m, of the coordinates, their rates and accelerations


def spec(seed):
    """A chain, its joints of all simple kinds, with discs, springs, counterweights; numbers plain, of parameters or free, some zero."""
    rng = random.Random(seed)
    planar = rng.random() < 0.4
    links = rng.randint(1, 3 if planar else 4)
    names = {}

    def number(low, high, zero=0.0):
        value = 0 if rng.random() < zero else round(rng.uniform(low, high), 3)
        kind = rng.random()
        if kind < 0.5:
            return str(value)
        name = f"p{len(names)}"
        names[name] = f"{{free: [{min(value, low)}, {high}], start: {value}}}" if kind > 0.9 else str(value)
        return name if rng.random() < 0.7 else f'"2 * {name} / 2"'

    def vector(low, high, zero):
        return "[" + ", ".join(number(low, high, zero) for _ in range(2 if planar else 3)) + "]"

    bodies, joints, extra = [], [], {"discs": [], "springs": [], "counterweights": []}
    for k in range(1, links + 1):
        inertia = "0.04" if planar else "[0.04, 0.05, 0.045]"
        bodies.append(f"  b{k}: {{mass: {number(1, 3)}, com: {vector(-0.2, 0.2, 0.3)}, inertia: {inertia}, points: {{A: {vector(-0.1, 0.1, 0.7)}, "
                      f"B: {vector(0.1, 0.5, 0.3)}, C: {vector(0.1, 0.5, 0.3)}}}}}")
        slides = rng.random() < 0.25
        before = "ground.O" if k == 1 else f"b{k - 1}.{rng.choice('BC')}"
        axis = f", axis: {rng.choice(AXES)}" if not planar else ", axis: [1, u]" if slides else ""
        joints.append(f"  J{k}: {{type: {'prismatic' if slides else 'revolute'}, connects: [{before}, b{k}.A]{axis}}}")
        if rng.random() < 0.4:
            at = rng.choice(("A", "B", vector(-0.1, 0.1, 0.4)))
            extra["counterweights"].append(f"  c{k}: {{body: b{k}, at: {at}, mass: {{free: [0, 5]}}}}")
        if rng.random() < 0.4:
            moments = number(0.01, 0.02) if planar else f"{{axial: {number(0.01, 0.017)}, transverse: {number(0.009, 0.012)}}}"
            turns = "" if planar else f", axis: {rng.choice(AXES)}"
            extra["discs"].append(f"  d{k}: {{body: b{k}, at: B, follows: J{rng.randint(1, k)}, ratio: {number(1, 4)}, inertia: {moments}{turns}}}")
        if rng.random() < 0.5:
            length = rng.choice(("0", "0.2", "{free: [0, 0.3], start: 0}"))
            extra["springs"].append(f"  s{k}: {{between: [ground.S, b{k}.{rng.choice('BC')}], stiffness: {number(50, 90, 0.2)}, free_length: {length}}}")
    gravity, base, hook = vector(-9.81, 9.81, 0.3), vector(-0.1, 0.1, 0.7), vector(0.5, 0.9, 0)
    parameters = ", ".join(f"{name}: {value}" for name, value in {"u": "0.3", **names}.items())
    text = [f"space: {'planar' if planar else 'spatial'}", f"gravity: {gravity}", f"parameters: {{{parameters}}}",
            f"ground: {{points: {{O: {base}, S: {hook}}}}}", "bodies:", *bodies, "joints:", *joints]
    for section, members in extra.items():
        text += [f"{section}:", *members] if members else []
    return "\n".join([*text, f"actuators: [{', '.join(f'J{k}' for k in range(1, links + 1))}]", ""]), links, list(names)


def program_torques(text, links):
    """What a printed Python program says of the state that `engine_torques` asks about."""
    call = f"\nprint(__import__('json').dumps(torques(prepare(GIVEN), [{POSE}] * {links}, [{POSE}] * {links}, [{POSE}] * {links})))\n"
    found = subprocess.run([sys.executable, "-c", text.split("\nif __name__")[0] + call], text=True, check=True, capture_output=True)
    return json.loads(found.stdout)


def engine_torques(path, links, changes):
    state = ",".join(f"J{k}={POSE}" for k in range(1, links + 1))
    done = run("equations", path, "--at", state, "--rates", state, "--accelerations", state, "--only", "torques", "--json", *changes)
    return [one["sum"] for one in json.loads(done.stdout)["torques"].values()] if done.returncode == 0 else done.stderr


def fault(seed):
    """What is wrong with the formulas or programs of one mechanism, or nothing."""
    text, links, names = spec(seed)
    rng = random.Random(-seed)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "spec.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        changes = [part for name in names if rng.random() < 0.3 for part in ("--set", f"{name}={rng.choice((0.1, 0.7, 1.3))}")]
        if not isinstance(engine_torques(path, links, changes), list):
            changes = []  # no mechanism
        formulas = run("equations", path, *changes)
        if formulas.returncode not in (0, 4) or (formulas.returncode == 4 and "too long" not in formulas.stderr):
            return f"formulas: {formulas.returncode} {formulas.stderr.strip()}"
        python = run("equations", path, "--code", "python", *changes)
        if python.returncode != 0:
            return f"Python: {python.returncode} {python.stderr.strip()}"
        expected, found = engine_torques(path, links, changes), program_torques(python.stdout, links)
        if not isinstance(expected, list):
            return f"no torques: {expected.strip()}"
        # as a part of the largest of a state of similar size: torques themselves may vanish
        scale = max(1e-3, *map(abs, expected))
        if any(abs(a - b) > 1e-9 * scale for a, b in zip(expected, found, strict=True)):
            return f"Python: {found} in place of {expected}"
        if shutil.which("cc"):
            c = run("equations", path, "--code", "c", *changes)
            if c.returncode != 0:
                return f"C: {c.returncode} {c.stderr.strip()}"
            program = os.path.join(folder, "program")
            built = subprocess.run(["cc", "-std=c99", "-x", "c", "-", "-lm", "-o", program], input=c.stdout, text=True, check=False, capture_output=True)
            if built.returncode != 0:
                return f"C: {built.stderr.strip()[:300]}"
            tested = subprocess.run([program], text=True, check=False, capture_output=True)
            if tested.returncode != 0:
                return f"C: {tested.stdout.strip()}"
    return None
