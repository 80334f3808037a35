// What the surroundings do to the bodies at an instant.

/** Linear between a load's entries, held beyond them. */
function between(time, rows, now) {
  if (time.length === 0) return rows[0];
  if (now <= time[0]) return rows[0];
  const next = time.findIndex((t) => t > now);
  if (next < 0) return rows.at(-1);
  const part = (now - time[next - 1]) / (time[next] - time[next - 1]);
  return rows[next].map((x, i) => (1 - part) * rows[next - 1][i] + part * x);
}

/** Force and moment in world axes, and the world point that the force acts at. */
export function loadAt(view, load, sample) {
  const now = view.run.time[sample];
  const turn = (v) => (load.frame === "body" ? fullDirection(view, load.body, v, sample) : v);
  return {
    at: view.poses.point(sample, load.body, load.point),
    force: turn(between(load.time, load.force, now)),
    moment: turn(between(load.time, load.moment, now)),
  };
}

/** Planar poses turn x and y only. */
function fullDirection(view, body, v, sample) {
  const turned = view.poses.direction(sample, body, v);
  return turned.length === 3 ? turned : [...turned, v[2]];
}

export const largestForce = (load) => Math.max(...load.force.map((f) => Math.hypot(...f)));
export const largestMoment = (load) => Math.max(...load.moment.map((m) => Math.hypot(...m)));
