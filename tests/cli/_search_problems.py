"""Seeded design problems of planar linkages and arms, quick to search: few samples, few free numbers, all other numbers at random."""

import math
import random

KINDS = ("four-bar", "five-bar", "six-bar", "arm")
GOALS = ("force", "static", "dynamic", None)
QUANTITIES = ("shaking_force", "shaking_moment", "torque")


def wind(angle):
    return math.remainder(angle, 2 * math.pi)


def meet(p, q, a, b, side):
    """Where two links of lengths a from p and b from q meet."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    far = math.hypot(dx, dy)
    along = (far**2 + a**2 - b**2) / (2 * far)
    beside = side * math.sqrt(a**2 - along**2)
    return p[0] + (along * dx - beside * dy) / far, p[1] + (along * dy + beside * dx) / far


def direction(p, q):
    return math.atan2(q[1] - p[1], q[0] - p[0])


class Linkage:
    def __init__(self, dice, couplers_free):
        self.dice, self.couplers_free = dice, couplers_free
        self.bodies, self.joints, self.lengths = [], [], []
        self.ground, self.inputs, self.assembly, self.held = {"A": (0, 0)}, {}, {}, []

    def vary(self, value):
        return value * self.dice.uniform(0.95, 1.05)

    def body(self, name, first, second, length, more=""):
        """A link along x with its centre of mass near the middle, its mass and moment of inertia about those of a rod of 4 kg/m."""
        mass = self.vary(4 * length)
        inertia, beside = repr(mass * length**2 / 10), self.dice.uniform(-0.02, 0.02)
        # a coupler that is as two point masses at its joints can be balanced by what turns about the pivots
        if self.couplers_free and name.startswith("coupler"):
            inertia, beside = f"{{free: [0.001, 0.2], start: {inertia}}}", 0.0
        com = f"[{self.vary(0.5 * length)!r}, {beside!r}]"
        self.bodies.append(f"  {name}: {{mass: {mass!r}, com: {com}, inertia: {inertia}, "
                           f"points: {{{first}: [0, 0], {second}: [{self.length(name, length)}, 0]{more}}}}}")

    def length(self, name, value):
        self.lengths.append((f"l_{name}", value))
        return f"l_{name}"

    def joint(self, name, first, second):
        self.joints.append(f"  {name}: {{type: revolute, connects: [{first}.{name}, {second}.{name}]}}")

    def dyad(self, base, angle, pivot, names, joints, bodies, side, more=""):
        """A crank about base at the angle, a coupler, and a rocker about the pivot; returns the rocker's angle and its far joint."""
        crank, coupler, rocker = (self.vary(n) for n in names)
        end = base[0] + crank * math.cos(angle), base[1] + crank * math.sin(angle)
        top = meet(end, pivot, coupler, rocker, side)
        a, b, c, d = joints
        if bodies[0]:
            self.body(bodies[0], a, b, crank)
            self.joint(a, "ground", bodies[0])
        self.body(bodies[1], b, c, coupler)
        self.body(bodies[2], d, c, rocker, more)
        self.joint(b, bodies[0], bodies[1])
        self.joint(c, bodies[1], bodies[2])
        self.joint(d, "ground", bodies[2])
        self.assembly[b], self.assembly[d] = wind(direction(end, top) - angle), direction(pivot, top)
        self.ground[d] = pivot
        return self.assembly[d], top


def four_bar(linkage):
    linkage.inputs = {"A": 0.5}
    linkage.dyad((0, 0), 0.5, (0.4, 0), (0.1, 0.35, 0.25), "ABCD", ("crank", "coupler", "rocker"), 1)
    linkage.held = [("crank", "A"), ("rocker", "D")]
    return linkage


def six_bar(linkage):
    """Watt's, with a ternary link on the ground: its rocker drives a second coupler and rocker."""
    linkage.inputs = {"A": 0.5}
    angle, _ = linkage.dyad((0, 0), 0.5, (0.4, 0), (0.1, 0.35, 0.25), "ABCD", ("crank", "coupler", "rocker"), 1,
                            ", E: [0.12, -0.16]")
    far = (0.4 + 0.12 * math.cos(angle) + 0.16 * math.sin(angle), 0.12 * math.sin(angle) - 0.16 * math.cos(angle))
    pivot, second, third = (0.8, 0.0), linkage.vary(0.3), linkage.vary(0.28)
    top = meet(far, pivot, second, third, 1)
    linkage.body("coupler2", "E", "F", second)
    linkage.body("rocker2", "G", "F", third)
    linkage.joint("E", "rocker", "coupler2")
    linkage.joint("F", "coupler2", "rocker2")
    linkage.joint("G", "ground", "rocker2")
    linkage.ground["G"] = pivot
    linkage.assembly.update(E=wind(direction(far, top) - angle), G=direction(pivot, top))
    linkage.held = [("crank", "A"), ("rocker", "D"), ("rocker2", "G")]
    return linkage


def five_bar(linkage):
    linkage.inputs = {"A": 2.0, "E": 1.1}
    a, b, c, d = (linkage.vary(n) for n in (0.25, 0.4, 0.4, 0.25))
    left = a * math.cos(2.0), a * math.sin(2.0)
    right = 0.3 + d * math.cos(1.1), d * math.sin(1.1)
    top = meet(left, right, b, c, 1)
    linkage.body("crank", "A", "B", a)
    linkage.body("coupler", "B", "C", b)
    linkage.body("coupler2", "D", "C", c)
    linkage.body("crank2", "E", "D", d)
    for joint, first, second in (("A", "ground", "crank"), ("B", "crank", "coupler"), ("C", "coupler", "coupler2"),
                                 ("D", "crank2", "coupler2"), ("E", "ground", "crank2")):
        linkage.joint(joint, first, second)
    linkage.ground["E"] = (0.3, 0)
    linkage.assembly.update(B=wind(direction(left, top) - 2.0), D=wind(direction(right, top) - 1.1))
    linkage.held = [("crank", "A"), ("crank2", "E")]
    return linkage


def arm(linkage):
    linkage.inputs = {"A": -0.3, "B": 1.2}
    linkage.body("link1", "A", "B", linkage.vary(0.4))
    linkage.body("link2", "B", "C", linkage.vary(0.3))
    linkage.joint("A", "ground", "link1")
    linkage.joint("B", "link1", "link2")
    linkage.held = [("link1", "A"), ("link2", "B")]
    return linkage


MAKERS = {"four-bar": four_bar, "five-bar": five_bar, "six-bar": six_bar, "arm": arm}


def interval(dice, lower, upper):
    return f"{{free: [{lower!r}, {upper!r}], start: {dice.uniform(lower, upper)!r}}}"


def objective(dice, goal, load_cases):
    if goal and not load_cases and dice.random() < 0.4:
        return "added-mass"
    # where the force or all of it is balanced, only the torque is left to be made small
    quantity = "torque" if goal == "dynamic" else dice.choice(QUANTITIES[1:] if goal else QUANTITIES)
    return f"{{{dice.choice(('peak', 'rms'))}: {quantity}, along: go}}"


def problem(seed):
    """A spec with 2 to 10 free numbers. Its kind and its goal follow from the seed in turn, the rest is drawn."""
    dice = random.Random(seed)
    kind, goal = KINDS[seed % len(KINDS)], GOALS[seed // len(KINDS) % len(GOALS)]
    linkage = MAKERS[kind](Linkage(dice, goal == "dynamic"))
    load_cases, lengths_free = dice.random() < 0.15, dice.random() < 0.4
    figure = objective(dice, goal, load_cases)
    places_free = dice.random() < 0.6
    weights, discs = [], []
    for k, (body, pivot) in enumerate(linkage.held):
        place = (f"[{interval(dice, -0.25, 0.05)}, {interval(dice, -0.1, 0.1)}]" if places_free
                 else f"[{dice.uniform(-0.2, -0.1)!r}, {dice.uniform(-0.02, 0.02)!r}]")
        weights.append(f"  w{k}: {{on: {body}, at: {place}, mass: {{free: [0, 25], start: {dice.uniform(0, 3)!r}}}}}")
        if goal == "dynamic":
            discs.append(f"  g{k}: {{on: {body}, at: {pivot}, follows: {pivot}, ratio: {interval(dice, -40.0, -1.0)}, mass: 0.5, "
                         "inertia: 0.01}")
    parameters = [f"{name}: {value!r}" for name, value in linkage.lengths]
    if lengths_free:
        name, value = dice.choice(linkage.lengths)
        k = [n for n, _ in linkage.lengths].index(name)
        parameters[k] = f"{name}: {{free: [{0.95 * value!r}, {1.05 * value!r}], start: {value!r}}}"
    parameters.append("cargo: 0.3")
    last = linkage.bodies[-1].split(":")[0].strip()
    design = [f"minimize: {figure}"]
    if goal:
        design.append(f"goal: {goal}")
    if load_cases:
        design.append("across: mean, for: {cargo: [0, 0.4]}")
    elif dice.random() < 0.3:
        design.append(f"subject_to: [added-mass <= {dice.uniform(2, 15)!r}]" if figure != "added-mass"
                      else f"subject_to: [\"peak(torque, go) <= {dice.uniform(5, 40)!r}\"]")
    elif dice.random() < 0.3:
        design.append(f"choose: {{counterweights: {dice.choice(['1', 'least'])}}}")
    start = ", ".join(f"{j}: {a!r}" for j, a in linkage.inputs.items())
    end = ", ".join(f"{j}: {a + 1.0!r}" if j != "E" else f"{j}: {a + 0.4!r}" for j, a in linkage.inputs.items())
    assembly = ", ".join(f"{j}: {a!r}" for j, a in {**linkage.inputs, **linkage.assembly}.items())
    ground = ", ".join(f"{name}: [{x!r}, {y!r}]" for name, (x, y) in linkage.ground.items())
    return "\n".join([
        f"name: {kind} of seed {seed}", "space: planar", "gravity: [0, -9.81]",
        f"parameters: {{{', '.join(parameters)}}}", f"ground: {{points: {{{ground}}}}}", "bodies:", *linkage.bodies,
        "joints:", *linkage.joints, "counterweights:", *weights, *(["discs:", *discs] if discs else []),
        f"payloads:\n  load: {{body: {last}, at: [0.1, 0.02], mass: cargo}}",
        f"actuators: [{', '.join(linkage.inputs)}]", f"assembly: {{{assembly}}}",
        f"motion: {{duration: 0.5, samples: 31, from: {{joints: {{{start}}}}}, to: {{joints: {{{end}}}}}}}",
        "trajectories: {go: {law: cycloidal, drive: joints}}", f"design: {{{', '.join(design)}}}", ""])
