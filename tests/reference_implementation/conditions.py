"""Balancing conditions in absolute coordinates: a second opinion on `balance conditions`.

Shares nothing with the program but the spec: no tree, no recursion. What bodies carry is written as their momentum, linear
in the inertial parameters; inertia forces are its rate, by a complex step; what joints allow is the null space of all
constraints. A goal's rows at random configurations span the space of its conditions.
"""
import numpy as np

from mechanism import skew
from solve import Unsolved, assemble, complex_step, gear_rows, newton
from spec import carrier

SYMBOLS = ["m", "mx", "my", "mz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"]   # about the frame's origin
PLANAR = {"m": 0, "mx": 1, "my": 2, "J": 6}
POWER = {"m": 0, "mx": 1, "my": 1, "mz": 1}   # of the length in the unit, the others' is 2
AXES = "xyz"
STRIDE = 0.25      # of a walk, in radians or the mechanism's lengths
APART = 3          # strides between configurations that are used
FEWEST = 12        # configurations for one goal
RANK = 2e-10       # singular values below this part of the largest are round-off
REGULAR = 3e-3     # smallest singular value of constraints where a walk goes on, the largest being 1


class NoConditions(Exception):
    pass


def inertia_bases():
    bases = []
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        E = np.zeros((3, 3))
        E[i, j] = E[j, i] = 1
        bases.append(E)
    return bases


BASES = inertia_bases()


def momentum(p, R, v, w):
    """Linear momentum, and angular momentum about the world's origin, per unit of a body's ten parameters; 6 × 10."""
    out = np.zeros((6, 10), dtype=np.result_type(p, R, v, w))
    turned = skew(w) @ R                       # rates of the body's axes
    out[:3, 0], out[:3, 1:4] = v, turned
    out[3:, 0], out[3:, 1:4] = np.cross(p, v), skew(p) @ turned - skew(v) @ R
    local = R.T @ w
    out[3:, 4:] = np.stack([R @ (E @ local) for E in BASES], axis=1)
    return out


def about_origin(p, wrench):
    """The same with the moment about the body's own origin."""
    out = wrench.copy()
    out[3:] -= skew(p) @ wrench[:3]
    return out


def inertia_force(p, R, v, w, a, dw, size=1e-30):
    """Rate of the momentum per unit of the parameters, moment about the body's origin."""
    turned = R + 1j * size * (skew(w) @ R)
    rate = momentum(p + 1j * size * v, turned, v + 1j * size * a, w + 1j * size * dw).imag / size
    return about_origin(p, rate)


class Bearers:
    """Whose parameters there are: (owner, body that carries them), and the springs."""
    def __init__(self, mechanism):
        raw, names = mechanism.spec.raw, mechanism.spec.body_names
        found = [("bodies", name, b) for b, name in enumerate(names) if b]
        for section in ("counterweights", "payloads"):
            found += [(section, name, names.index(carrier(item))) for name, item in (raw.get(section) or {}).items()]
        first = len(names)
        found += [("discs", name, first + k) for k, name in enumerate(raw.get("discs") or {})]
        springs = [("springs", name, k) for k, name in enumerate(raw.get("springs") or {})]
        every = [name for _, name, _ in found + springs]

        def owner(section, name):
            return f"{section}.{name}" if every.count(name) > 1 else name

        self.bodies = {owner(section, name): body for section, name, body in found}
        self.springs = {owner(section, name): k for section, name, k in springs}


def every_name(mechanism):
    """All parameters, springs between points by their stiffness alone."""
    bearers = Bearers(mechanism)
    symbols = PLANAR if mechanism.planar else SYMBOLS
    return [f"{owner}.{s}" for owner in bearers.bodies for s in symbols] + [
        f"{owner}.{s}" for owner, k in bearers.springs.items()
        for s in (("k", "preload") if "joint" in mechanism.springs[k] else ("k",))]


def values(mechanism, names):
    """The parameters' values."""
    spec, found = mechanism.spec, {}
    raw, bearers = spec.raw, Bearers(mechanism)

    def put(owner, mass, place, inertia):
        about_frame = inertia + mass * (place @ place * np.eye(3) - np.outer(place, place))
        entries = [mass, *(mass * place), *(np.sum(about_frame * E) / np.sum(E) for E in BASES)]
        found.update({f"{owner}.{symbol}": entry for symbol, entry in zip(SYMBOLS, entries)})
        found[f"{owner}.J"] = entries[6]

    for owner, body in bearers.bodies.items():
        name = owner.rsplit(".", 1)[-1]
        section = owner.split(".")[0] if "." in owner else next(
            s for s in ("bodies", "counterweights", "payloads", "discs") if name in (raw.get(s) or {}))
        item = raw[section][name]
        if section == "discs":
            put(owner, *mechanism.lumps[body][0])
            continue
        mass, at_origin = spec.number(item["mass"]), np.zeros(3)
        place = spec.vector(item["com"]) if section == "bodies" else spec.point(carrier(item), item["at"])
        put(owner, mass, place, spec.inertia(item.get("inertia"), mass, place if section == "bodies" else at_origin))
    for owner, k in bearers.springs.items():
        spring = mechanism.springs[k]
        found[f"{owner}.k"] = stiffness = spring["stiffness"]
        if "joint" in spring:
            found[f"{owner}.preload"] = spring["preload"]
            continue
        for i, x in enumerate(AXES):
            found[f"{owner}.ka{x}"] = stiffness * spring["p"][i]
            found[f"{owner}.kb{x}"] = stiffness * spring["q"][i]
            found.update({f"{owner}.ka{x}b{y}": stiffness * spring["p"][i] * spring["q"][j]
                          for j, y in enumerate(AXES)})
    return np.array([found[name] for name in names])


class Columns:
    """The parameters, in the order of a list of names such as link1.mx; a loose spring has more than its stiffness."""
    def __init__(self, mechanism, names):
        self.mechanism, self.names = mechanism, names
        bearers = Bearers(mechanism)
        self.inertial, self.springs, self.power = [], [], []
        expected = {f"{owner}.{symbol}" for owner in bearers.bodies
                    for symbol in (PLANAR if mechanism.planar else SYMBOLS)}
        expected |= {f"{owner}.k" for owner in bearers.springs}
        if missing := expected - set(names):
            raise NoConditions(f"parameters are missing: {sorted(missing)}")
        for column, name in enumerate(names):
            owner, symbol = name.rsplit(".", 1)
            if owner in bearers.springs:
                self.springs.append((column, bearers.springs[owner], symbol))
                self.power.append((self.spring_power(mechanism.springs[bearers.springs[owner]], symbol), 1))
            else:
                slot = PLANAR[symbol] if mechanism.planar else SYMBOLS.index(symbol)
                self.inertial.append((column, bearers.bodies[owner], slot))
                self.power.append((POWER.get(symbol, 2), 0))

    def spring_power(self, spring, symbol):
        """Of the length in the parameter's unit, besides N/m."""
        if "joint" in spring:
            return 2 if self.mechanism.angular[spring["joint"]] else {"k": 0, "preload": 1}[symbol]
        return symbol.count("a") + symbol.count("b")

    def spread(self, per_body):
        """From (bodies, rows, 10) to rows × parameters."""
        out = np.zeros((per_body.shape[1], len(self.names)))
        for column, body, slot in self.inertial:
            out[:, column] = per_body[body, :, slot]
        return out

    def units(self, length, acceleration):
        """What makes the columns comparable."""
        return np.array([length**power * (acceleration / length if spring else 1) for power, spring in self.power])


class Sample:
    """A configuration and the velocities that the joints allow there."""
    def __init__(self, mechanism, p, R, near):
        self.mechanism, self.p, self.R, self.near = mechanism, p, R, near
        rows = closed_rows(mechanism, p, R).real[:, mechanism.columns]
        _, S, Vt = np.linalg.svd(rows, full_matrices=True)
        self.rank = int((S > 1e-9 * S[0]).sum())
        self.regular = S[self.rank - 1] / S[0]
        self.allowed = np.zeros((6 * mechanism.n, len(mechanism.columns) - self.rank))
        self.allowed[mechanism.columns] = Vt[self.rank:].T

    def motors(self):
        """The allowed velocities at which one motor turns with unit speed; well held or None."""
        mechanism = self.mechanism
        S = mechanism.rates(self.p, self.R).real[mechanism.actuators] @ self.allowed
        if S.shape[0] != S.shape[1]:
            raise NoConditions("not one actuator per degree of freedom")
        return self.allowed @ np.linalg.inv(S) if np.linalg.cond(S) < 100 else None


def closed_rows(mechanism, p, R):
    return np.vstack([mechanism.constraints(p, R)[1], gear_rows(mechanism, p, R)])


def is_open(mechanism):
    return sum(joint["second"] > 0 for joint in mechanism.joints) == mechanism.n - 1 == len(mechanism.joints)


def configurations(mechanism, seed=3):
    """Endless: anywhere for open chains, else along a random walk from the assembled pose that keeps clear of singular
    configurations, where other branches of the mechanism's motions begin."""
    rng = np.random.default_rng(seed)
    length = size_of(mechanism)
    if is_open(mechanism):
        while True:
            q = np.array([rng.uniform(-np.pi, np.pi) if turning else rng.uniform(-length, length)
                          for turning in mechanism.angular])
            for coupling in mechanism.couplings:
                q[coupling[0]] = mechanism.led(coupling, q) + coupling[2]
            mechanism.near = q
            yield Sample(mechanism, *mechanism.place(q), q)
    here = begin(mechanism, rng)
    direction, taken, blocked = draw(here, rng), 0, 0
    while True:
        step = STRIDE * direction / np.abs(direction * weights(mechanism, length)).max()
        there = walk(mechanism, here, step)
        if there is None or there.rank != here.rank or there.regular < REGULAR:
            direction = -direction if here.allowed.shape[1] == 1 else draw(here, rng)
            blocked += 1
            if blocked > 500:
                raise Unsolved("the mechanism does not get anywhere")
            continue
        here, taken = there, taken + 1
        direction = here.allowed @ (here.allowed.T @ direction)
        direction /= np.linalg.norm(direction)
        if here.allowed.shape[1] > 1:
            direction = 0.7 * direction + 0.3 * draw(here, rng)
        if taken % APART == 0:
            blocked = 0
            yield here


def begin(mechanism, rng):
    """The assembled pose, or one near it if that is singular: there, all constraints but one small step are met."""
    p, R = assemble(mechanism, {})
    q = mechanism.coordinates(p, R, mechanism.near)
    mechanism.near = q
    here = Sample(mechanism, p, R, q)
    for _ in range(20):
        there = walk(mechanism, here, 0.1 * draw(here, rng))
        if there is not None and (there.rank > here.rank or here.regular < REGULAR):
            here = there
    return here


def draw(sample, rng):
    direction = sample.allowed @ rng.normal(size=sample.allowed.shape[1])
    return direction / np.linalg.norm(direction)


def weights(mechanism, length):
    return np.tile([1 / length] * 3 + [1] * 3, mechanism.n)


def size_of(mechanism):
    """Of the mechanism's joints and springs [m]."""
    elements = mechanism.joints + [spring for spring in mechanism.springs if "joint" not in spring]
    return max(max(np.linalg.norm(e["p"]), np.linalg.norm(e["q"])) for e in elements)


def walk(mechanism, sample, step):
    nothing = np.zeros(0), np.zeros((0, 6 * mechanism.n))
    p, R = mechanism.move(sample.p, sample.R, step[mechanism.columns])
    mechanism.near = sample.near
    try:
        p, R = newton(mechanism, p, R, lambda p, R: nothing)
    except Unsolved:
        return None
    q = mechanism.coordinates(p, R, sample.near)
    if np.abs(q - sample.near)[:mechanism.spec_coordinates].max() > 2 or mechanism.upside_down(R):
        return None
    mechanism.near = q
    return Sample(mechanism, p, R, q)


class Goals:
    """Rows that must vanish, sample by sample."""
    def __init__(self, mechanism, names, tree_joints=None):
        """tree_joints: names of the joints whose coordinates' accelerations a gyroscopic balance is written in."""
        self.mechanism, self.columns = mechanism, Columns(mechanism, names)
        self.tree_joints = tree_joints
        self.reference = None
        self.rng = np.random.default_rng(7)

    def rows(self, goal, sample):
        """(rows × parameters, rows × extra unknowns), or None where the motors do not hold the mechanism."""
        fully, kind = goal.startswith("fully-"), goal.removeprefix("fully-")
        none = np.zeros((0, 4 if self.mechanism.planar else 9))
        C = sample.motors() if fully or kind in ("decoupled", "gyroscopic-independent") else sample.allowed
        if C is None:
            return None
        velocity = sample.allowed @ self.rng.normal(size=sample.allowed.shape[1])
        parts = []
        if kind in ("static", "gyroscopic", "gyroscopic-independent", "decoupled"):
            parts.append(self.weight(sample, C))
        if kind in ("gyroscopic", "decoupled"):
            parts.append(self.efforts(sample, C, velocity, self.tree_bias(sample, velocity)))
        if kind == "gyroscopic-independent":
            parts.append(self.efforts(sample, C, velocity, self.motor_bias(sample, velocity)))
        if kind == "decoupled" or fully:
            felt = self.inertia(sample, C)
            n = C.shape[1]
            if kind == "decoupled":
                parts += [felt[r * n + s][None] for r in range(n) for s in range(r)]
            if fully:
                self.reference = felt if self.reference is None else self.reference
                parts.append(felt - self.reference)
        if kind in ("force", "dynamic"):
            parts += self.momenta(sample, slice(0, 3))
        if kind in ("moment", "dynamic"):
            parts += self.momenta(sample, slice(3, 6))
        if kind in ("proportional", "affine"):
            return self.following(sample, kind == "affine")
        rows = np.vstack(parts)
        return rows, np.zeros((len(rows), none.shape[1]))

    def project(self, virtual, per_body):
        """Virtual power of the bodies' wrenches (n, 6, 10) at each column of virtual velocities."""
        n = self.mechanism.n
        return self.columns.spread(np.einsum("bik,bip->bkp", virtual.reshape(n, 6, -1), per_body))

    def weight(self, sample, C):
        """What weight and springs ask of the motors: the rate of the potential energy."""
        g, n = self.mechanism.gravity, self.mechanism.n
        per_body = np.zeros((n, 6, 10))
        for b in range(1, n):
            per_body[b, :3, 0] = -g
            per_body[b, 3:, 1:4] = -np.cross(sample.R[b].T, g).T
        out = self.project(C, per_body)
        for k in range(C.shape[1]):
            v = C[:, k].reshape(n, 6)
            size = 1e-30
            p = sample.p + 1j * size * v[:, :3]
            R = np.array([r + 1j * size * skew(w) @ r for w, r in zip(v[:, 3:], sample.R)])
            for column, spring, symbol in self.columns.springs:
                if "joint" in self.mechanism.springs[spring]:
                    c = self.mechanism.springs[spring]["joint"]
                    rate = self.mechanism.rates(sample.p, sample.R)[c].real @ C[:, k]
                    out[k, column] += rate * (sample.near[c] if symbol == "k" else -1)
                    continue
                out[k, column] += self.spring_energy(self.mechanism.springs[spring], symbol, p, R).imag / size
        return out

    def spring_energy(self, spring, symbol, p, R):
        """Per unit of the stiffness, or of its products with the end points a and b."""
        i, j = spring["first"], spring["second"]
        loose = any(s != "k" for _, k, s in self.columns.springs if self.mechanism.springs[k] is spring)
        if symbol == "k":
            line = p[i] - p[j] + (0 if loose else R[i] @ spring["p"] - R[j] @ spring["q"])
            square = line @ line
            return square / 2 if loose else (np.sqrt(square) - spring["free_length"])**2 / 2
        letters = symbol[1:]
        if len(letters) == 4:      # a x b y
            return -R[i][:, AXES.index(letters[1])] @ R[j][:, AXES.index(letters[3])]
        line, axis = p[i] - p[j], AXES.index(letters[1])
        return line @ R[i][:, axis] if letters[0] == "a" else -line @ R[j][:, axis]

    def efforts(self, sample, C, velocity, acceleration):
        n = self.mechanism.n
        V, A = velocity.reshape(n, 6), acceleration.reshape(n, 6)
        per_body = np.array([inertia_force(sample.p[b], sample.R[b], V[b, :3], V[b, 3:], A[b, :3], A[b, 3:])
                             for b in range(n)])
        return self.project(C, per_body)

    def bias(self, sample, velocity, rows_at):
        """The accelerations with which the values of rows keep their rates; least norm."""
        rows = rows_at(sample.p, sample.R).real
        drift = complex_step(self.mechanism, rows_at, sample.p, sample.R, velocity) @ velocity
        out = np.zeros(6 * self.mechanism.n)
        columns = self.mechanism.columns
        out[columns], _, rank, _ = np.linalg.lstsq(rows[:, columns], -drift, rcond=1e-9)
        miss = np.abs(rows[:, columns] @ out[columns] + drift).max()
        if rank < len(columns) or miss > 1e-7 * max(1, np.abs(drift).max()):
            raise NoConditions("the accelerations do not follow from those of the coordinates")
        return out

    def motor_bias(self, sample, velocity):
        mechanism = self.mechanism
        return self.bias(sample, velocity, lambda p, R: np.vstack([closed_rows(mechanism, p, R),
                                                                   mechanism.rates(p, R)[mechanism.actuators]]))

    def tree_bias(self, sample, velocity):
        """The joints beyond the tree are open for the accelerations: those of the tree's coordinates are zero."""
        mechanism = self.mechanism
        in_tree = [self.tree_joints is None or k >= mechanism.spec_joints or joint["kind"] == "fixed"
                   or joint["name"] in self.tree_joints for k, joint in enumerate(mechanism.joints)]
        chosen = [c for c, k in enumerate(mechanism.coordinate_joint) if in_tree[k]]

        def rows_at(p, R):
            _, rows, owner = mechanism.constraints(p, R)
            return np.vstack([rows[[in_tree[k] for k in owner]], mechanism.rates(p, R)[chosen]])

        return self.bias(sample, velocity, rows_at)

    def inertia(self, sample, C):
        """Entries of Cᵀ M C, row by row."""
        n, nothing = self.mechanism.n, np.zeros(3)
        blocks = []
        for s in range(C.shape[1]):
            A = C[:, s].reshape(n, 6)
            blocks.append(self.project(C, np.array([about_origin(sample.p[b], momentum(
                sample.p[b], sample.R[b], A[b, :3], A[b, 3:])) for b in range(n)])))
        return np.stack(blocks, axis=1).reshape(-1, len(self.columns.names))

    def momenta(self, sample, part):
        n = self.mechanism.n
        if self.mechanism.planar:
            part = [0, 1] if part.start == 0 else [5]
        blocks = []
        for k in range(sample.allowed.shape[1]):
            V = sample.allowed[:, k].reshape(n, 6)
            per_body = np.array([momentum(sample.p[b], sample.R[b], V[b, :3], V[b, 3:]) for b in range(n)])
            blocks.append(self.columns.spread(per_body[:, part]))
        return blocks

    def following(self, sample, turning):
        """The tool's velocity and, if the CoM may follow the rotation too, the rates of its body's axes."""
        axes = 2 if self.mechanism.planar else 3
        rates = self.mechanism.tool_rows(sample.R).real @ sample.allowed
        known = [rates[:axes]]
        if turning:
            R = sample.R[self.mechanism.tool[0]]
            known += [np.cross(rates[3:].T, R[:, k]).T[:axes] for k in range(axes)]
        known = np.vstack(known)
        blocks = self.momenta(sample, slice(0, 3))
        extra = [np.kron(np.eye(axes), known[:, k]) for k in range(sample.allowed.shape[1])]
        return np.vstack(blocks), -np.vstack(extra)


def row_space(rows, extra):
    """Orthonormal basis of the rows for which some value of the extra unknowns makes everything vanish; gap."""
    largest = np.linalg.norm(rows, 2) if rows.size else 0   # what round-off is measured by
    if extra.any():
        U, S, _ = np.linalg.svd(extra, full_matrices=True)
        rows = U[:, int((S > 1e-9 * S[0]).sum()):].T @ rows
    if largest == 0:
        return np.zeros((0, rows.shape[1])), np.inf
    _, S, Vt = np.linalg.svd(rows, full_matrices=False)
    rank = int((S > RANK * largest).sum())
    kept = S[rank - 1] if rank else largest
    return Vt[:rank], kept / max(S[rank] if rank < len(S) else 0, 1e-16 * largest)


def derive(mechanism, goal, names, samples, tree_joints=None):
    """Row space of the conditions in scaled columns: (basis, gap, units of the columns)."""
    goals = Goals(mechanism, names, tree_joints)
    g = np.linalg.norm(mechanism.gravity)
    units = goals.columns.units(size_of(mechanism), g if g > 0 else 1.0)
    rows, extra = [], []
    for sample in samples:
        found = goals.rows(goal, sample)
        if found is None:
            continue
        rows.append(found[0] * units)
        extra.append(found[1])
        if len(rows) >= FEWEST and (sum(map(len, rows)) > 2 * len(names) + 20 or not np.vstack(rows).any()):
            break
    return *row_space(np.vstack(rows), np.vstack(extra)), units
