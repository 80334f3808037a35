// What is drawn of a mechanism, the same for canvas and WebGL: sizes follow masses.

/** Points of a body that matter for its outline: named ones and those of its joints, without repetitions. */
export function outline(geometry, body) {
  const points = geometry.bodies[body].points.map((p) => p.position);
  for (const joint of geometry.joints) {
    if (joint.first === body) points.push(joint.point_first);
    if (joint.second === body) points.push(joint.point_second);
  }
  const near = 1e-9 + 1e-6 * geometry.length;
  return points.filter((p, i) => points.findIndex((q) => distance(p, q) < near) === i);
}

export function distance(a, b) {
  return Math.hypot(...a.map((x, i) => x - b[i]));
}

/** The heaviest lump of any variant: what radii are measured by. */
export function heaviest(mechanism) {
  const lumps = Object.values(mechanism).flatMap((g) => (g ? g.attachments.map((a) => a.mass) : []));
  const bodies = Object.values(mechanism).flatMap((g) => (g ? g.bodies.map((b) => b.mass) : []));
  return Math.max(...lumps, ...bodies, 1e-12);
}

/** Planar: the area follows the mass; spatial: the volume. */
export function radius(mass, heaviestMass, length, space) {
  if (mass <= 0) return 0;
  const share = (mass / heaviestMass) ** (space === "planar" ? 1 / 2 : 1 / 3);
  return (space === "planar" ? 0.17 : 0.11) * length * share;
}

/** A solid disc of this mass and inertia has this radius; kept within what can be drawn. */
export function discRadius(disc, length) {
  const solid = disc.mass > 0 && disc.axial > 0 ? Math.sqrt((2 * disc.axial) / disc.mass) : 0;
  return Math.min(Math.max(solid, 0.06 * length), 0.35 * length);
}

/** Radii of the two wheels of a coupling: they touch where the ratio is negative and the distance allows it. */
export function wheels(ratio, apart, length) {
  const size = Math.min(Math.max(Math.abs(ratio), 0.2), 5); // leader's radius over the follower's
  const touching = ratio < 0 && apart > 0.02 * length && apart < 3 * length;
  const sum = touching ? apart : 0.3 * length;
  return {leader: (sum * size) / (1 + size), follower: sum / (1 + size), touching};
}

/** Convex hull of points in the plane, counter-clockwise (Andrew's monotone chain). */
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  if (sorted.length < 3) return sorted;
  const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain.at(-2), chain.at(-1), p) <= 1e-15) chain.pop();
      chain.push(p);
    }
    chain.pop();
    return chain;
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

/** How far a joint's slide goes for a turn by one radian, if it rolls; else 0. */
export function rollingRadius(geometry, joint) {
  if (joint.type !== "pin-slot") return 0;
  const own = geometry.coordinates.flatMap((c, k) => (geometry.joints[c.joint] === joint ? [k] : []));
  const rolls = ({follower, leaders, ratio, offset}) =>
    follower === own[0] && leaders.length === 1 && leaders[0].coordinate === own[1] && ratio < 0 && offset === 0;
  const coupling = geometry.couplings.find(rolls);
  return coupling ? -coupling.ratio * coupling.leaders[0].ratio : 0;
}
