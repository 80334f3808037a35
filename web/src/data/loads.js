// What the surroundings do to the bodies at an instant.

/** Linear between a load's entries, held beyond them or repeated. */
function interpolate(load, rows, at) {
  const {arguments: all} = load;
  if (all.length === 0) return rows[0];
  const period = all.at(-1) - all[0];
  const now = load.is_periodic ? at - Math.floor((at - all[0]) / period) * period : at;
  if (now <= all[0]) return rows[0];
  const next = all.findIndex((x) => x > now);
  if (next < 0) return rows.at(-1);
  const part = (now - all[next - 1]) / (all[next] - all[next - 1]);
  return rows[next].map((x, i) => (1 - part) * rows[next - 1][i] + part * x);
}

/** Force and moment in world axes, and the world point that the force acts at. */
export function loadAt(view, load, sample) {
  const now = load.coordinate < 0 ? view.run.time[sample] : view.column("joint_position")[load.coordinate].values[sample];
  const turn = (v) => (load.frame === "body" ? fullDirection(view, load.body, v, sample) : v);
  return {
    at: view.poses.point(sample, load.body, load.point),
    force: turn(interpolate(load, load.force, now)),
    moment: turn(interpolate(load, load.moment, now)),
  };
}

/** Planar poses turn x and y only. */
function fullDirection(view, body, v, sample) {
  const turned = view.poses.direction(sample, body, v);
  return turned.length === 3 ? turned : [...turned, v[2]];
}

export const largestForce = (load) => Math.max(...load.force.map((f) => Math.hypot(...f)));
export const largestMoment = (load) => Math.max(...load.moment.map((m) => Math.hypot(...m)));
