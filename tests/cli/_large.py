"""Specs of mechanisms that grow: chains of rods, and four-bars in a row."""

LAW = "trajectories: {cycloid: {law: cycloidal, drive: joints}}"


def chain(bodies, *, motors=None, turn=0.5):
    """A planar chain of rods, each hinged to the one before, every joint with a motor.

    @param motors how many joints have one, from the ground on; not given: all
    @param turn how far all joints together turn [rad]
    """
    motors = bodies if motors is None else motors
    lines = ["space: planar", "gravity: [0, -9.81]", "bodies:"]
    for b in range(1, bodies + 1):
        lines.append(f"  b{b}: {{mass: {1 + 0.1 * (b % 7):.1f}, com: [0.08, 0.02], inertia: 0.004, points: {{A: [0, 0], B: [0.2, 0]}}}}")
    lines.append("joints:")
    for b in range(1, bodies + 1):
        before = "ground.origin" if b == 1 else f"b{b - 1}.B"
        lines.append(f"  J{b}: {{type: revolute, connects: [{before}, b{b}.A]}}")
    lines.append(f"actuators: [{', '.join(f'J{b}' for b in range(1, motors + 1))}]")
    start = ", ".join(f"J{b}: {0.01 * (b % 5 - 2):.2f}" for b in range(1, bodies + 1))
    end = ", ".join(f"J{b}: {0.01 * (b % 5 - 2) + turn / bodies * (1 - b % 3):.9f}" for b in range(1, bodies + 1))
    lines.append(f"motion: {{duration: 1, samples: 21, from: {{joints: {{{start}}}}}, to: {{joints: {{{end}}}}}}}")
    lines.append(LAW)
    return "\n".join(lines) + "\n"


def ladder(loops):
    """Four-bars in a row, the rocker of each the crank of the next, one motor for all; every one is a parallelogram."""
    lines = ["space: planar", "gravity: [0, -9.81]", "ground:", "  points:"]
    lines += [f"    G{k}: [{0.3 * k:.1f}, 0]" for k in range(loops + 1)]
    lines.append("bodies:")
    for k in range(loops + 1):
        lines.append(f"  rocker{k}: {{mass: 1, com: [0.08, 0.02], inertia: 0.004, points: {{A: [0, 0], B: [0.2, 0]}}}}")
        if k > 0:
            lines.append(f"  coupler{k}: {{mass: 1, com: [0.12, 0.03], inertia: 0.009, points: {{A: [0, 0], B: [0.3, 0]}}}}")
    lines.append("joints:")
    lines.append("  G0: {type: revolute, connects: [ground.G0, rocker0.A]}")
    for k in range(1, loops + 1):
        lines.append(f"  G{k}: {{type: revolute, connects: [ground.G{k}, rocker{k}.A]}}")
        lines.append(f"  C{k}: {{type: revolute, connects: [rocker{k - 1}.B, coupler{k}.A]}}")
        lines.append(f"  D{k}: {{type: revolute, connects: [coupler{k}.B, rocker{k}.B]}}")
    lines.append("actuators: [G0]")
    rough = ", ".join(f"G{k}: 1.2, C{k}: -1.2" for k in range(1, loops + 1))
    lines.append(f"assembly: {{G0: 1.2, {rough}}}")
    lines.append("motion: {duration: 1, samples: 21, from: {joints: {G0: 1.2}}, to: {joints: {G0: 1.8}}}")
    lines.append(LAW)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":  # for a look by hand: _large.py chain 2000 > chain.yaml
    import sys
    sys.stdout.write({"chain": chain, "ladder": ladder}[sys.argv[1]](int(sys.argv[2])))
