"""Newton's method in absolute coordinates, pose targets, the assembly of a mechanism."""
import numpy as np

from mechanism import rotation_vector


class Unsolved(Exception):
    pass


def solve_rows(rows, values):
    return np.linalg.lstsq(rows, values, rcond=1e-11)[0]


def newton(mechanism, p, R, prescribe, largest=None, exact=True):
    """Closes all joints and meets what `prescribe(p, R) -> (errors, rows)` asks for, by the smallest steps. If it
    cannot be met exactly, the nearest pose is fine only if not `exact`."""
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
        if size < 1e-14 or (size < 1e-9 and size >= best / 2):   # no longer getting better
            if exact and np.abs(residual).max() > 1e-8:
                break
            return p, R
        best = min(best, size)
    raise Unsolved(f"no convergence, last step {size:.1e}, residual {np.abs(residual).max():.1e}")


def gears(mechanism, p, R):
    if not mechanism.couplings:
        return np.zeros(0), np.zeros((0, 6 * mechanism.n))
    q, G = mechanism.coordinates(p, R, mechanism.near), mechanism.rates(p, R)
    values = [q[c[0]] - mechanism.led(c, q) - c[2] for c in mechanism.couplings]
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
    for coupling in mechanism.couplings:
        q[coupling[0]] = mechanism.led(coupling, q) + coupling[2]
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
            p, R = newton(mechanism, p, R, soft, largest=0.2, exact=False)
        except Unsolved:
            pass
    p, R = newton(mechanism, p, R, lambda p, R: pose_error(mechanism, target, p, R, q), largest=0.5)
    if mechanism.upside_down(R):
        raise Unsolved(f"assembled upside down: {', '.join(mechanism.upside_down(R))}")
    return p, R


def gear_rows(mechanism, p, R):
    if not mechanism.couplings:
        return np.zeros((0, 6 * mechanism.n))
    G = mechanism.rates(p, R)
    return np.array([G[c[0]] - mechanism.led(c, G) for c in mechanism.couplings])


def complex_step(mechanism, rows, p, R, velocity, size=1e-30):
    v = velocity.reshape(mechanism.n, 6)
    turned = np.array([r + 1j * size * np.cross(w, r.T).T for w, r in zip(v[:, 3:], R)])
    return rows(p + 1j * size * v[:, :3], turned).imag / size
