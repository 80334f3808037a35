"""Trajectories: what one prescribes, and the motion that follows from it."""
import numpy as np

from laws import LAWS
from mechanism import rotation_about, rotation_vector
from solve import Unsolved, assemble, complex_step, gear_rows, gears, newton, pose_error, solve_rows, wrap

LARGEST_STEP = 0.3   # of any angle between two solutions [rad], as the velocity predicts it


def arc(start, via, end):
    """Centre and signed turn of the arc from start through via to end."""
    a, b = via - start, end - start
    normal = np.cross(a, b)
    rows = np.array([a, b, normal])
    centre = start + np.linalg.solve(rows, np.array([a @ a / 2, b @ b / 2, 0]))
    x, y = start - centre, end - centre
    z = normal / np.linalg.norm(normal)   # start, via, end run counter-clockwise about it
    return centre, np.remainder(np.arctan2(np.cross(x, y) @ z, x @ y), 2 * np.pi) * z


class Drive:
    """What a trajectory prescribes at a time: values, rates and accelerations of rows."""
    def __init__(self, mechanism, name):
        raw = mechanism.spec.raw
        entry = dict(raw["trajectories"][name])
        merged = {**raw["motion"], **entry}
        number = mechanism.spec.number
        self.mechanism, self.raw, self.kind, self.law = mechanism, entry, entry.get("drive", "tool"), LAWS[entry["law"]]
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
        self.joints, self.angle, self.points, self.turns = [], False, [], []
        named = ["x", "y", "z", "rx", "ry", "rz"]
        if self.kind == "joints":
            listed = list(start.get("joints", {}))
            self.joints = listed if len(listed) == dof else mechanism.actuators[:dof]
        elif "components" in self.raw:
            for name in self.raw["components"]:
                if name == "angle":
                    self.angle = True
                else:
                    (self.points if named.index(name) < 3 else self.turns).append(named.index(name) % 3)
        else:
            self.points = list(range(min(dof, self.axes)))
            rest = dof - len(self.points)
            if "remaining" in self.raw:
                self.joints = [mechanism.names.index(name) for name in self.raw["remaining"]]
            elif rest and mechanism.tool and mechanism.planar:
                self.angle = True
            elif mechanism.tool and rest == 1 and not mechanism.planar and self.kind == "tool":
                self.turns = [2]
            elif mechanism.tool and rest == 3:
                self.turns = [0, 1, 2]
            elif rest:
                self.joints = mechanism.actuators[-rest:]
        R_start = self.R0[mechanism.tool[0]] if mechanism.tool else np.eye(3)
        stops = [(0.0, self._values(self.p0, self.R0, self.q0), R_start)]
        if self.path != "line" and "waypoints" in self.path:
            for time, raw in zip(self.path["times"], self.path["waypoints"]):
                stated = self._stated(mechanism.spec.pose(raw), stops[-1])
                stops.append((mechanism.spec.number(time) / self.duration, *stated))
        if self.kind == "joints" and all(c in end.get("joints", {}) for c in self.joints):
            stops.append((1.0, *self._stated(end, stops[-1])))
        elif self.path != "line" and "circle" in self.path:
            stops.append((1.0, *stops[0][1:]))
        else:
            p1, R1, q1 = self._end_pose(start, end)
            stops.append((1.0, self._values(p1, R1, q1), R1[mechanism.tool[0]] if mechanism.tool else R_start))
        self.stops = stops

    def _stated(self, pose, before):
        """The prescribed scalars and the rotation that a pose states; the rest stays as before."""
        values, k = before[1].copy(), len(self.points)
        if self.points and self.kind in pose:
            values[:k] = pose[self.kind][self.points]
        if self.angle and "angle" in pose:
            values[k] = pose["angle"]
        for i, c in enumerate(self.joints):
            values[k + self.angle + i] = pose.get("joints", {}).get(c, values[k + self.angle + i])
        return values, pose.get("orientation", before[2])

    def _end_pose(self, start, end):
        """From the start pose to the end pose in small steps of the targets."""
        mechanism, q = self.mechanism, self.q0
        p, R = self.p0, self.R0
        now = {"joints": {c: q[c] for c in end.get("joints", {})}, "com": mechanism.com(p, R)}
        if mechanism.tool:
            body, place = mechanism.tool
            now.update(tool=p[body] + R[body] @ place, orientation=R[body])
            now.update(angle=np.arctan2(R[body][1, 0], R[body][0, 0]))
        for k in range(1, 31):
            x, target = k / 30, {}
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
            values += list(point[self.points])
        if self.angle:
            body = mechanism.tool[0]
            values.append(np.arctan2(R[body][1, 0], R[body][0, 0]))
        return np.array(values + [q[c] for c in self.joints])

    def rows(self, p, R):
        mechanism, parts = self.mechanism, []
        if self.points:
            parts.append((mechanism.com_rows(R) if self.kind == "com" else mechanism.tool_rows(R))[self.points])
        if self.angle:
            parts.append(mechanism.tool_rows(R)[5:])
        if self.joints:
            parts.append(mechanism.rates(p, R)[self.joints])
        if self.turns:
            parts.append(mechanism.tool_rows(R)[3:][self.turns])
        return np.vstack(parts)

    def at(self, time):
        """Values of the scalars; rates and accelerations of all rows; the prescribed rotation."""
        tau = time / self.duration
        leg = max(k for k, stop in enumerate(self.stops[:-1]) if tau >= stop[0])
        (t0, start, R_start), (t1, end, R_end) = self.stops[leg:leg + 2]
        s, ds, dds = self.law((tau - t0) / (t1 - t0))
        seconds = (t1 - t0) * self.duration
        ds, dds = ds / seconds, dds / seconds**2
        if self.path != "line" and "waypoints" not in self.path:
            value, rate, acceleration = self._around(s, ds, dds)
        else:
            value, rate, acceleration = start + s * (end - start), ds * (end - start), dds * (end - start)
        if not self.turns:
            return value, rate, acceleration, None
        turn = rotation_vector(R_end @ R_start.T)
        return (value, np.append(rate, ds * turn[self.turns]), np.append(acceleration, dds * turn[self.turns]),
                rotation_about(s * turn) @ R_start)

    def _around(self, s, ds, dds):
        """On a circle; whatever else is prescribed goes straight."""
        start, end, k = self.stops[0][1], self.stops[-1][1], len(self.points)
        home, there = np.zeros(3), np.zeros(3)
        home[self.points], there[self.points] = start[:k], end[:k]
        spec = self.mechanism.spec
        if "circle" in self.path:
            circle = self.path["circle"]
            centre, normal = spec.vector(circle["centre"]), spec.vector(circle.get("normal", [0, 0, 1]))
            turn = spec.number(circle["angle"]) * normal / np.linalg.norm(normal)
        else:
            centre, turn = arc(home, spec.vector(self.path["arc"]["via"]), there)
        r = rotation_about(s * turn) @ (home - centre)
        w, dw = ds * turn, dds * turn
        rate = np.cross(w, r)
        value, way = start + s * (end - start), end - start
        value[:k], rates, accelerations = (centre + r)[self.points], ds * way, dds * way
        rates[:k], accelerations[:k] = rate[self.points], (np.cross(dw, r) + np.cross(w, rate))[self.points]
        return value, rates, accelerations

    def errors(self, p, R, near, value, rotation):
        mechanism = self.mechanism
        now = self._values(p, R, mechanism.coordinates(p, R, near))
        error = now - value
        if self.angle:
            error[len(self.points)] = wrap(error[len(self.points)])
        if self.turns:
            error = np.append(error, -rotation_vector(rotation @ R[mechanism.tool[0]].T)[self.turns])
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
    p, R = mechanism.move(p, R, step)
    p, R = newton(mechanism, p, R, lambda p, R: (drive.errors(p, R, q, value, rotation), drive.rows(p, R)))
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
