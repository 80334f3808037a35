"""Poses and trajectories: what a trajectory prescribes, and the motion that follows from it."""
import numpy as np

from laws import LAWS
from mechanism import rotation_about, rotation_vector

LARGEST_STEP = 0.3   # of any angle between two solutions [rad], as the velocity predicts it


class Unsolved(Exception):
    pass


def solve_rows(rows, values):
    return np.linalg.lstsq(rows, values, rcond=1e-11)[0]


def newton(mechanism, p, R, prescribe, largest=None):
    """Closes all joints and meets what `prescribe(p, R) -> (errors, rows)` asks for, by the smallest steps."""
    best = np.inf
    for _ in range(60):
        values, rows, _ = mechanism.constraints(p, R)
        gear_values, gear_rows = gears(mechanism, p, R)
        errors, drive_rows = prescribe(p, R)
        residual = np.concatenate([values, gear_values, errors])
        rows = np.vstack([rows, gear_rows, drive_rows]).real[:, mechanism.columns]
        step = -solve_rows(rows, residual)
        if largest:
            step *= min(1.0, largest / max(np.abs(step).max(), 1e-300))
        p, R = mechanism.move(p, R, step)
        size = np.abs(step).max()
        if size < 1e-9 and size >= best / 2:   # no longer getting better
            return p, R
        best = min(best, size)
        if size < 1e-14:
            return p, R
    raise Unsolved(f"no convergence, last step {size:.1e}, residual {np.abs(residual).max():.1e}")


def gears(mechanism, p, R):
    if not mechanism.couplings:
        return np.zeros(0), np.zeros((0, 6 * mechanism.n))
    q, G = mechanism.coordinates(p, R, mechanism.near), mechanism.rates(p, R)
    values = [q[follower] - ratio * q[leader] - offset for follower, leader, ratio, offset in mechanism.couplings]
    # a follower's angle is known up to whole turns
    values = [wrap(x) if mechanism.angular[c[0]] else x for x, c in zip(values, mechanism.couplings)]
    return np.array(values), gear_rows(mechanism, p, R)


def wrap(angle):
    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))


def stack(parts, width):
    errors = [np.atleast_1d(e) for e, _ in parts]
    rows = [np.atleast_2d(r) for _, r in parts]
    return (np.concatenate(errors), np.vstack(rows)) if parts else (np.zeros(0), np.zeros((0, width)))


def pose_error(mechanism, target, p, R, near):
    """Errors and rows of a pose target."""
    axes = 2 if mechanism.planar else 3
    parts = []
    if target.get("joints"):
        q, G = mechanism.coordinates(p, R, near), mechanism.rates(p, R)
        parts += [(q[c] - value, G[c]) for c, value in target["joints"].items()]
    if "com" in target:
        parts.append(((mechanism.com(p, R) - target["com"])[:axes], mechanism.com_rows(R)[:axes]))
    if mechanism.tool:
        body, place = mechanism.tool
        rows = mechanism.tool_rows(R)
        if "tool" in target:
            parts.append(((p[body] + R[body] @ place - target["tool"])[:axes], rows[:axes]))
        if "angle" in target:
            parts.append((wrap(np.arctan2(R[body][1, 0], R[body][0, 0]) - target["angle"]), rows[5]))
        if "orientation" in target:
            parts.append((-rotation_vector(target["orientation"] @ R[body].T), rows[3:]))
    return stack(parts, 6 * mechanism.n)


def assemble(mechanism, target):
    """A pose that meets the target, from the spec's rough joint values."""
    q = np.zeros(len(mechanism.names))
    rough = {**mechanism.assembly, **target.get("joints", {})}
    for c, value in rough.items():
        q[c] = value
    for follower, leader, ratio, offset in mechanism.couplings:
        q[follower] = ratio * q[leader] + offset
    mechanism.near = q
    p, R = mechanism.place(q)

    def soft(p, R):
        errors, rows = pose_error(mechanism, target, p, R, q)
        now, G = mechanism.coordinates(p, R, q), mechanism.rates(p, R)
        chosen = sorted(rough)
        pull = 1e-2 * np.array([now[c] - q[c] for c in chosen])
        return np.concatenate([errors, pull]), np.vstack([rows] + [1e-2 * G[[c]] for c in chosen])

    for _ in range(3):   # a few damped steps towards both, then exactly
        try:
            p, R = newton(mechanism, p, R, soft, largest=0.2)
        except Unsolved:
            pass
    return newton(mechanism, p, R, lambda p, R: pose_error(mechanism, target, p, R, q), largest=0.5)


class Drive:
    """What a trajectory prescribes at a time: values, rates and accelerations of rows."""
    def __init__(self, mechanism, name):
        raw = mechanism.spec.raw
        entry = dict(raw["trajectories"][name])
        merged = {**raw["motion"], **entry}
        number = mechanism.spec.number
        self.mechanism, self.kind, self.law = mechanism, entry.get("drive", "tool"), LAWS[entry["law"]]
        self.duration, self.samples = number(merged["duration"]), int(number(merged["samples"]))
        self.about = mechanism.spec.vector(merged.get("about", [0, 0, 0]))
        self.path = entry.get("path", "line")
        self.axes = 2 if mechanism.planar else 3
        start, end = mechanism.spec.pose(merged["from"]), mechanism.spec.pose(merged["to"])
        self.p0, self.R0 = assemble(mechanism, start)
        self.q0 = mechanism.coordinates(self.p0, self.R0, mechanism.near)
        mechanism.near = self.q0
        self.freedoms = self._freedoms()
        self._choose(start, end)

    def _freedoms(self):
        mechanism = self.mechanism
        rows = np.vstack([mechanism.constraints(self.p0, self.R0)[1], gears(mechanism, self.p0, self.R0)[1]])
        singular = np.linalg.svd(rows.real[:, mechanism.columns], compute_uv=False)
        return len(mechanism.columns) - int((singular > 1e-9 * singular[0]).sum())

    def _choose(self, start, end):
        """Which rows are prescribed, and their values at both ends."""
        mechanism, dof = self.mechanism, self.freedoms
        self.turns, self.joints, self.angle = False, [], False
        if self.kind == "joints":
            listed = list(start.get("joints", {}))
            self.joints = listed if len(listed) == dof else mechanism.actuators[:dof]
            self.points = 0
        else:
            self.points = min(dof, self.axes)
            rest = dof - self.points
            if rest and mechanism.tool and mechanism.planar:
                self.angle = True
            elif rest and mechanism.tool and rest == 3:
                self.turns = True
            elif rest:
                self.joints = mechanism.actuators[-rest:]
        self.start = self._values(self.p0, self.R0, self.q0)
        if self.kind == "joints" and all(c in end.get("joints", {}) for c in self.joints):
            self.end = np.array([end["joints"][c] for c in self.joints])
            return
        if self.path != "line":
            self.end = self.start
            return
        p1, R1, q1 = self._end_pose(start, end)
        self.end = self._values(p1, R1, q1)
        if self.turns:
            self.R_end = R1[mechanism.tool[0]]
            self.turn = rotation_vector(self.R_end @ self.R0[mechanism.tool[0]].T)

    def _end_pose(self, start, end):
        """From the start pose to the end pose in small steps of the targets."""
        mechanism, q = self.mechanism, self.q0
        p, R = self.p0, self.R0
        now = {"joints": {c: q[c] for c in end.get("joints", {})}, "com": mechanism.com(p, R)}
        if mechanism.tool:
            body, place = mechanism.tool
            now.update(tool=p[body] + R[body] @ place, angle=np.arctan2(R[body][1, 0], R[body][0, 0]), orientation=R[body])
        for k in range(1, 61):
            x, target = k / 60, {}
            for key, value in end.items():
                if key == "joints":
                    target[key] = {c: (1 - x) * now[key][c] + x * v for c, v in value.items()}
                elif key == "orientation":
                    target[key] = rotation_about(x * rotation_vector(value @ now[key].T)) @ now[key]
                else:
                    target[key] = (1 - x) * now[key] + x * value
            p, R = newton(mechanism, p, R, lambda p, R: pose_error(mechanism, target, p, R, q))
            q = mechanism.coordinates(p, R, q)
            mechanism.near = q
        mechanism.near = self.q0
        return p, R, q

    def _values(self, p, R, q):
        """Prescribed scalars at a pose: the point's coordinates, the tool's angle, joint coordinates."""
        mechanism, values = self.mechanism, []
        if self.points:
            body, place = mechanism.tool if mechanism.tool else (0, np.zeros(3))
            point = mechanism.com(p, R) if self.kind == "com" else p[body] + R[body] @ place
            values += list(point[:self.points])
        if self.angle:
            body = mechanism.tool[0]
            values.append(np.arctan2(R[body][1, 0], R[body][0, 0]))
        return np.array(values + [q[c] for c in self.joints])

    def rows(self, p, R):
        mechanism, parts = self.mechanism, []
        if self.points:
            parts.append((mechanism.com_rows(R) if self.kind == "com" else mechanism.tool_rows(R))[:self.points])
        if self.angle:
            parts.append(mechanism.tool_rows(R)[5:])
        if self.joints:
            parts.append(mechanism.rates(p, R)[self.joints])
        if self.turns:
            parts.append(mechanism.tool_rows(R)[3:])
        return np.vstack(parts)

    def at(self, time):
        """Values, rates, accelerations of the scalars; then rotation, angular velocity and acceleration."""
        s, ds, dds = self.law(time / self.duration)
        ds, dds = ds / self.duration, dds / self.duration**2
        if self.path == "line":
            way = self.end - self.start
            value, rate, acceleration = self.start + s * way, ds * way, dds * way
        else:
            value, rate, acceleration = self._around(s, ds, dds)
        if not self.turns:
            return value, rate, acceleration, None
        home = self.R0[self.mechanism.tool[0]]
        return value, np.append(rate, ds * self.turn), np.append(acceleration, dds * self.turn), rotation_about(s * self.turn) @ home

    def _around(self, s, ds, dds):
        circle, spec = self.path["circle"], self.mechanism.spec
        centre, normal = spec.vector(circle["centre"]), spec.vector(circle.get("normal", [0, 0, 1]))
        full = spec.number(circle["angle"])
        normal = normal / np.linalg.norm(normal)
        arm = np.zeros(3)
        arm[:self.points] = self.start[:self.points]
        arm = arm - centre
        r = rotation_about(s * full * normal) @ arm
        w, dw = ds * full * normal, dds * full * normal
        rate = np.cross(w, r)
        rest = np.zeros(len(self.start) - self.points)
        k = self.points
        return (np.append((centre + r)[:k], self.start[k:]), np.append(rate[:k], rest),
                np.append((np.cross(dw, r) + np.cross(w, rate))[:k], rest))

    def errors(self, p, R, near, value, rotation):
        mechanism = self.mechanism
        now = self._values(p, R, mechanism.coordinates(p, R, near))
        error = now - value
        if self.angle:
            error[self.points] = wrap(error[self.points])
        if self.turns:
            error = np.append(error, -rotation_vector(rotation @ R[mechanism.tool[0]].T))
        return error


def follow(drive, indices):
    """Yields the state at the chosen samples: index, time, p, R, q, velocities, accelerations, condition."""
    mechanism = drive.mechanism
    p, R, q, tau, velocity = drive.p0, drive.R0, drive.q0, 0.0, np.zeros(6 * mechanism.n)
    for index in sorted(indices):
        end = index / (drive.samples - 1)
        while True:
            x = min(end, tau + min(1 / 60, LARGEST_STEP / (drive.duration * np.abs(velocity).max() + 1e-300)))
            p, R, q, velocity, rows = advance(drive, p, R, q, velocity, tau, x)
            tau = x
            if x == end:
                break
        drift = complex_step(mechanism, lambda p, R: jacobian(drive, p, R), p, R, velocity)
        target = drive.at(end * drive.duration)[2]
        accelerations = np.zeros(6 * mechanism.n)
        accelerations[mechanism.columns] = solve_rows(rows, padded(rows, target) - drift @ velocity)
        singular = np.linalg.svd(rows, compute_uv=False)
        yield dict(index=index, time=end * drive.duration, p=p, R=R, q=q, velocity=velocity, acceleration=accelerations,
                   condition=singular[0] / singular[len(mechanism.columns) - 1])


def advance(drive, p, R, q, velocity, start, end):
    """The pose and the velocities at the part `end` of the duration, from those at `start`."""
    mechanism = drive.mechanism
    value, rate, _, rotation = drive.at(end * drive.duration)
    step = velocity[mechanism.columns] * (end - start) * drive.duration
    p, R = newton(mechanism, *mechanism.move(p, R, step), lambda p, R: (drive.errors(p, R, q, value, rotation), drive.rows(p, R)))
    now = mechanism.coordinates(p, R, q)
    if end > start and np.abs(now - q)[:mechanism.spec_coordinates].max() > 1:
        raise Unsolved(f"a jump at {end:.4g} of the duration: {dict(zip(mechanism.names, np.round(now - q, 3)))}")
    mechanism.near = now
    rows = jacobian(drive, p, R).real[:, mechanism.columns]
    velocity = np.zeros(6 * mechanism.n)
    velocity[mechanism.columns] = solve_rows(rows, padded(rows, rate))
    return p, R, now, velocity, rows


def padded(rows, drive_values):
    return np.concatenate([np.zeros(len(rows) - len(drive_values)), drive_values])


def jacobian(drive, p, R):
    """Rows of joints, gears and drive."""
    return np.vstack([drive.mechanism.constraints(p, R)[1], gear_rows(drive.mechanism, p, R), drive.rows(p, R)])


def gear_rows(mechanism, p, R):
    if not mechanism.couplings:
        return np.zeros((0, 6 * mechanism.n))
    G = mechanism.rates(p, R)
    return np.array([G[follower] - ratio * G[leader] for follower, leader, ratio, _ in mechanism.couplings])


def complex_step(mechanism, rows, p, R, velocity, size=1e-30):
    v = velocity.reshape(mechanism.n, 6)
    turned = np.array([r + 1j * size * np.cross(w, r.T).T for w, r in zip(v[:, 3:], R)])
    return rows(p + 1j * size * v[:, :3], turned).imag / size
