"""A mechanism in absolute coordinates: the pose of every body is unknown, every joint is a set of constraints.

The state of n bodies is p (n, 3), the world position of each body's origin, and R (n, 3, 3), its rotation. Velocities
are (v, w) per body, world axes, stacked to 6 n numbers, the ground included. Everything that returns rows is safe for
complex arguments, so its time derivative comes from a complex step.
"""
import numpy as np

from spec import JOINT_COORDINATES, Spec

Z = np.array([0, 0, 1.0])


def rotation_about(vector):
    """The rotation by |vector| about vector."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    K = skew(vector / angle)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rotation_vector(R):
    """The inverse of rotation_about, for rotations by less than pi."""
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine, cosine = np.linalg.norm(axis), (np.trace(R) - 1) / 2
    return axis if sine < 1e-12 else axis / sine * np.arctan2(sine, cosine)


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def across(u):
    """Two unit vectors that complete u to a right-handed frame."""
    a = cross(u, np.eye(3)[np.argmin(np.abs(u))])
    a /= np.linalg.norm(a)
    return a, cross(u, a)


class Rows:
    """Collects values and rows of constraints or rates on the 6 n velocities."""
    def __init__(self, bodies):
        self.values, self.rows, self.bodies = [], [], bodies

    def add(self, value, *terms):
        """terms: (body, coefficients of v, coefficients of w)."""
        row = np.zeros(6 * self.bodies, dtype=complex)
        for body, on_v, on_w in terms:
            row[6 * body:6 * body + 3] += on_v
            row[6 * body + 3:6 * body + 6] += on_w
        self.values.append(value)
        self.rows.append(row)


class Mechanism:
    def __init__(self, path):
        spec = self.spec = Spec(path)
        self.planar, self.gravity = spec.planar, spec.gravity
        self.joints = list(spec.joints())
        self.names = spec.coordinate_names()
        index = self.names.index
        raw = spec.raw
        self.actuators = [index(name) for name in raw.get("actuators") or []]
        number = spec.number
        self.couplings = [(index(c["joint"]), spec.leaders(c), number(c.get("offset", 0)))
                          for c in raw.get("couplings") or []] + list(spec.wheels())
        self.friction = [(index(name), spec.number(f.get("viscous", 0)), spec.number(f.get("coulomb", 0)))
                         for name, f in (raw.get("friction") or {}).items()]
        self.assembly = {index(name): spec.number(v) for name, v in (raw.get("assembly") or {}).items()}
        self.loads, self.springs = list(spec.loads()), list(spec.springs())
        self.lumps = [[]] + [spec.lumps(name) for name in spec.body_names[1:]]
        self.tool = None
        if raw.get("tool"):
            body, point = raw["tool"].split(".", 1)
            self.tool = (spec.body_names.index(body), spec.point(body, point))
        self.spec_joints, self.spec_coordinates = len(self.joints), len(self.names)
        for disc in spec.discs():
            self._add_disc(disc)
        for joint in self.joints:
            joint["sides"] = across(Z if self.planar else joint["axis"])
        self.coordinate_joint = [k for k, joint in enumerate(self.joints) for _ in JOINT_COORDINATES[joint["kind"]]]
        self.angular = [part not in ("slide", "x", "y")
                        for joint in self.joints for part in JOINT_COORDINATES[joint["kind"]]]
        self.near = None   # the coordinates that angles stay close to
        self.n = len(self.lumps)
        self.mass = sum(m for lumps in self.lumps for m, _, _ in lumps)
        per_body = [0, 1, 5] if self.planar else range(6)
        self.columns = np.array([6 * body + k for body in range(1, self.n) for k in per_body])

    def _add_disc(self, disc):
        """A disc is one more body on one more revolute joint, geared to what it follows."""
        self.lumps.append([(disc["mass"], np.zeros(3), disc["inertia"])])
        self.joints.append(dict(name=disc["name"], kind="revolute", first=disc["carrier"], second=len(self.lumps) - 1,
                                p=disc["at"], q=np.zeros(3), axis=disc["axis"], axis2=None, rotation=np.eye(3)))
        self.names.append(disc["name"])
        self.couplings.append((len(self.names) - 1, disc["leaders"], 0.0))

    @staticmethod
    def led(coupling, values):
        """What the coupling makes of its leaders' values, rates or rows."""
        return sum(ratio * values[leader] for leader, ratio in coupling[1].items())

    # joints

    def _gap(self, joint, p, R):
        """Second joint point minus first, and the terms of its rate in direction d (fixed in the world)."""
        i, j = joint["first"], joint["second"]
        arm_i, arm_j = R[i] @ joint["p"], R[j] @ joint["q"]
        gap = p[j] + arm_j - p[i] - arm_i
        return gap, lambda d: ((j, d, cross(arm_j, d)), (i, -d, -cross(arm_i, d)))

    def constraints(self, p, R):
        """Every joint's constraint equations; (values, rows, joint of each row)."""
        out, owner = Rows(self.n), []
        for k, joint in enumerate(self.joints):
            before = len(out.rows)
            (self._constrain_planar if self.planar else self._constrain_spatial)(joint, p, R, out)
            owner += [k] * (len(out.rows) - before)
        return np.array(out.values), np.array(out.rows), owner

    def _constrain_planar(self, joint, p, R, out):
        i, j, kind = joint["first"], joint["second"], joint["kind"]
        gap, rate = self._gap(joint, p, R)
        if kind in ("revolute", "fixed"):
            for d in np.eye(3)[:2]:
                out.add(d @ gap, *rate(d))
        elif kind != "planar":
            self._hold(R[i] @ cross(Z, joint["axis"]), gap, rate, i, out)
        if kind in ("prismatic", "fixed"):
            x, y = R[i] @ joint["rotation"][:, 0], R[j][:, 1]
            out.add(x @ y, (j, 0, cross(y, x)), (i, 0, -cross(y, x)))

    @staticmethod
    def _hold(direction, gap, rate, i, out):
        """The gap has no component along a direction of body i."""
        out.add(direction @ gap, *rate(direction), (i, 0, cross(direction, gap)))

    def _constrain_spatial(self, joint, p, R, out):
        i, j, kind, u = joint["first"], joint["second"], joint["kind"], joint["axis"]
        gap, rate = self._gap(joint, p, R)
        sides = [R[i] @ a for a in joint["sides"]]
        if kind in ("revolute", "fixed", "universal", "spherical"):
            for d in np.eye(3):
                out.add(d @ gap, *rate(d))
        if kind in ("prismatic", "cylindrical"):
            for side in sides:
                self._hold(side, gap, rate, i, out)
        if kind == "planar":
            self._hold(R[i] @ u, gap, rate, i, out)
        pairs = []   # vectors of body i and of body j that keep their angle
        home = R[j] @ joint["rotation"].T
        if kind in ("revolute", "cylindrical", "planar"):
            pairs = [(side, home @ u, 0) for side in sides]
        if kind in ("prismatic", "fixed"):
            pairs = [(R[i][:, a], home[:, b], 0) for a, b in ((0, 1), (1, 2), (2, 0))]
        if kind == "universal":
            pairs = [(R[i] @ u, home @ joint["axis2"], u @ joint["axis2"])]
        for x, y, value in pairs:
            out.add(x @ y - value, (j, 0, cross(y, x)), (i, 0, -cross(y, x)))

    def upside_down(self, R):
        """Joints whose orientation conditions are met by the turned-over body, which the constraints cannot tell."""
        found = []
        for joint in self.joints:
            held = {"prismatic": np.eye(3)[0], "fixed": np.eye(3)[0]}
            if not self.planar:
                held.update({kind: joint["axis"] for kind in ("revolute", "cylindrical", "planar")})
            u = held.get(joint["kind"])
            if u is not None and (R[joint["first"]] @ u) @ (R[joint["second"]] @ joint["rotation"].T @ u) < 0:
                found.append(joint["name"])
        return found

    def rates(self, p, R):
        """Rows that give every coordinate's rate."""
        out = Rows(self.n)
        for joint in self.joints:
            self._rate(joint, p, R, out)
        return np.array(out.rows)

    def _rate(self, joint, p, R, out):
        i, j, kind = joint["first"], joint["second"], joint["kind"]
        gap, rate = self._gap(joint, p, R)
        u = R[i] @ (Z if self.planar else joint["axis"])

        def turn(d):
            out.add(0, (j, 0, d), (i, 0, -d))

        def slide(d):
            out.add(0, *rate(d), (i, 0, cross(d, gap)))

        home = R[j] @ joint["rotation"].T
        if kind in ("prismatic", "pin-slot", "cylindrical"):
            along = R[i] @ joint["axis"]
        if kind == "planar":
            v = R[i] @ joint["axis2"]
            slide(v)
            slide(cross(u, v))
        if kind in ("prismatic", "pin-slot"):
            slide(along)
        if kind in ("revolute", "pin-slot", "cylindrical", "planar"):
            turn(u)
        if kind == "cylindrical":
            slide(along)
        if kind == "universal":
            axes = np.array([u, home @ joint["axis2"]])
            for d in np.linalg.solve(axes @ axes.T, axes):
                turn(d)
        if kind == "spherical":
            x, z = R[i][:, 0], home[:, 2]
            y = cross(z, x)
            for d in np.linalg.inv(np.array([x, y / np.sqrt(y @ y), z])).T:
                turn(d)

    def coordinates(self, p, R, near=None):
        """Every coordinate; angles as close as possible to those of `near`."""
        q = np.array([value for joint in self.joints for value in self._coordinate(joint, p, R)])
        if near is not None:
            q = np.where(self.angular, q + 2 * np.pi * np.round((near - q) / (2 * np.pi)), q)
        return q

    def _coordinate(self, joint, p, R):
        i, j, kind = joint["first"], joint["second"], joint["kind"]
        gap = R[i].T @ self._gap(joint, p, R)[0]
        E = R[i].T @ R[j] @ joint["rotation"].T
        u, v = (Z if self.planar else joint["axis"]), joint["axis2"]

        def angle(axis, start, end):
            return np.arctan2(cross(axis, start) @ end, start @ end - (axis @ start) * (axis @ end))

        side = joint["sides"][0]
        turn, slide = angle(u, side, E @ side), joint["axis"] @ gap
        if kind == "universal":
            w = E @ v
            return angle(u, v - (u @ v) * u, w), angle(w, u - (u @ v) * w, E @ u)
        if kind == "spherical":
            return np.arctan2(-E[1, 2], E[2, 2]), np.arcsin(E[0, 2]), np.arctan2(-E[0, 1], E[0, 0])
        if kind == "planar":
            return v @ gap, cross(u, v) @ gap, turn
        return {"revolute": (turn,), "prismatic": (slide,), "fixed": (), "pin-slot": (slide, turn),
                "cylindrical": (turn, slide)}[kind]

    # bodies

    def com(self, p, R):
        return sum(m * (p[b] + R[b] @ c) for b, lumps in enumerate(self.lumps) for m, c, _ in lumps) / self.mass

    def com_rows(self, R):
        out = Rows(self.n)
        for d in np.eye(3):
            out.add(0, *[(b, m / self.mass * d, m / self.mass * cross(R[b] @ c, d))
                         for b, lumps in enumerate(self.lumps) for m, c, _ in lumps])
        return np.array(out.rows)

    def tool_rows(self, R):
        """Velocity of the tool point, angular velocity of its body."""
        body, place = self.tool
        out = Rows(self.n)
        for d in np.eye(3):
            out.add(0, (body, d, cross(R[body] @ place, d)))
        for d in np.eye(3):
            out.add(0, (body, 0, d))
        return np.array(out.rows)

    def move(self, p, R, step):
        """The pose after a small displacement of the free columns."""
        full = np.zeros(6 * self.n)
        full[self.columns] = step
        full = full.reshape(self.n, 6)
        return p + full[:, :3], np.array([rotation_about(d) @ r for d, r in zip(full[:, 3:], R)])

    def place(self, q):
        """A pose in which as many joints as possible have the coordinates q: bodies are placed one after another, first
        those whose orientation a joint holds."""
        order = sorted(range(len(self.joints)), key=lambda k: self.joints[k]["kind"] not in ("prismatic", "fixed"))
        p, R, known = np.zeros((self.n, 3)), np.array([np.eye(3)] * self.n), {0}
        while len(known) < self.n:
            for k in order:
                joint = self.joints[k]
                i, j = joint["first"], joint["second"]
                if (i in known) == (j in known):
                    continue
                values = [q[c] for c, owner in enumerate(self.coordinate_joint) if owner == k]
                E, r = self._displacement(joint, values)
                if i in known:
                    R[j] = R[i] @ E @ joint["rotation"]
                    p[j] = p[i] + R[i] @ (joint["p"] + r) - R[j] @ joint["q"]
                else:
                    R[i] = R[j] @ joint["rotation"].T @ E.T
                    p[i] = p[j] + R[j] @ joint["q"] - R[i] @ (joint["p"] + r)
                known |= {i, j}
        return p, R

    def _displacement(self, joint, q):
        kind, u, v, about = joint["kind"], joint["axis"], joint["axis2"], rotation_about
        rest = np.zeros(3)
        x, y, z = np.eye(3)
        return {
            "revolute": lambda: (about(q[0] * (Z if self.planar else u)), rest),
            "prismatic": lambda: (np.eye(3), q[0] * u),
            "fixed": lambda: (np.eye(3), rest),
            "pin-slot": lambda: (about(q[1] * Z), q[0] * u),
            "cylindrical": lambda: (about(q[0] * u), q[1] * u),
            "universal": lambda: (about(q[0] * u) @ about(q[1] * v), rest),
            "spherical": lambda: (about(q[0] * x) @ about(q[1] * y) @ about(q[2] * z), rest),
            "planar": lambda: (about(q[2] * u), q[0] * v + q[1] * cross(u, v)),
        }[kind]()
