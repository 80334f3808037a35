// What both stages, canvas and WebGL, know of a run: geometry, poses, the force over time, the room that all of it needs.
import {Poses} from "../data/poses.js";
import {largestForce, largestMoment} from "../data/loads.js";
import {distance, heaviest, outline, radius, rollingRadius, wheels} from "../data/shape.js";

const points = (columns, sample) => columns.map((c) => c.values[sample]);

export class View {
  constructor(data, variant, run) {
    this.space = data.space;
    this.geometry = data.mechanism[variant] ?? data.mechanism.before;
    this.run = run;
    this.samples = run.time.length;
    this.poses = new Poses(run.poses, this.geometry.bodies.length, data.space);
    this.length = this.geometry.length;
    this.heaviest = heaviest(data.mechanism);
    this.outlines = this.geometry.bodies.map((_, b) => outline(this.geometry, b));
    this.forceScale = this.largest("shaking_force");
    this.loadScale = Math.max(0, ...this.geometry.loads.map(largestForce));
    this.momentScale = Math.max(0, ...this.geometry.loads.map(largestMoment));
    // one wheel for each leader that a belt runs over
    this.couplings = this.geometry.couplings.flatMap(({follower, ratio, leaders}) => leaders.map((led) => {
      const of = (c) => this.geometry.coordinates[c];
      const joint = (c) => this.geometry.joints[of(c).joint];
      return {coupling: {follower, leader: led.coordinate, ratio: ratio * led.ratio},
        leader: joint(led.coordinate), follower: joint(follower),
        turning: of(led.coordinate).unit === "rad" && of(follower).unit === "rad"};
    }));
    this.box = this.ownBounds();
  }

  column(quantity) {
    return this.run.series.get(quantity)?.columns ?? null;
  }

  at(quantity, sample) {
    const columns = this.column(quantity);
    return columns && points(columns, sample);
  }

  com(sample) {
    return this.at("com_position", sample);
  }

  tool(sample) {
    return this.at("tool_position", sample);
  }

  force(sample) {
    return this.at("shaking_force", sample);
  }

  largest(quantity) {
    let peak = 0;
    for (let k = 0; k < this.samples; ++k) peak = Math.max(peak, Math.hypot(...(this.at(quantity, k) ?? [0])));
    return peak;
  }

  massRadius(mass) {
    return radius(mass, this.heaviest, this.length, this.space);
  }

  /** Turn of a disc relative to its carrier. */
  discAngle(disc, sample) {
    const columns = this.column("joint_position");
    const sum = (total, {coordinate, ratio}) => total + ratio * columns[coordinate].values[sample];
    return disc.ratio * disc.follows.reduce(sum, 0);
  }

  /** How far a joint's second point is along its axis from the first. */
  slide(joint, sample) {
    const o = this.poses.point(sample, joint.first, joint.point_first);
    const d = this.poses.direction(sample, joint.first, joint.axis);
    const p = this.poses.point(sample, joint.second, joint.point_second);
    return o.reduce((sum, x, i) => sum + (p[i] - x) * d[i], 0);
  }

  /** The least and the largest of it in the whole run. */
  travel(joint) {
    this.travels ??= new Map();
    if (!this.travels.has(joint)) {
      const step = Math.max(1, Math.floor(this.samples / 200));
      const places = [];
      for (let k = 0; k < this.samples; k += step) places.push(this.slide(joint, k));
      places.push(this.slide(joint, this.samples - 1));
      this.travels.set(joint, [Math.min(...places), Math.max(...places)]);
    }
    return this.travels.get(joint);
  }

  /** Angle of the wheel that a turning coordinate moves, in the world (planar). */
  turnOf(coordinate, joint, sample) {
    return this.poses.angle(sample, joint.first) + this.column("joint_position")[coordinate].values[sample];
  }

  /** Shown on the same scales as others. */
  alike(views) {
    for (const scale of ["forceScale", "loadScale", "momentScale"]) this[scale] = Math.max(...views.map((v) => v[scale]));
    const corner = (name, best) => [0, 1, 2].map((i) => best(...views.map((v) => v.box[name][i])));
    this.box = {low: corner("low", Math.min), high: corner("high", Math.max)};
  }

  bounds() {
    return this.box;
  }

  includeWheels(sample, include) {
    for (const {coupling, leader, follower, turning} of this.couplings) {
      if (!turning) continue;
      const [a, b] = [leader, follower].map((j) => this.poses.point(sample, j.second, j.point_second));
      const made = wheels(coupling.ratio, distance(a, b), this.length);
      include(a, made.leader);
      include(b, made.follower);
    }
  }

  /** Corners of the box that everything stays in. */
  ownBounds() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    const include = (p, margin = 0) => p?.forEach((x, i) => {
      low[i] = Math.min(low[i], x - margin);
      high[i] = Math.max(high[i], x + margin);
    });
    const step = Math.max(1, Math.floor(this.samples / 120));
    for (let k = 0; k < this.samples; k += step) {
      this.outlines.forEach((list, b) => list.forEach((p) => include(this.poses.point(k, b, p))));
      for (const joint of this.geometry.joints)
        include(this.poses.point(k, joint.second, joint.point_second), rollingRadius(this.geometry, joint));
      for (const a of this.geometry.attachments)
        include(this.poses.point(k, a.body, a.position), this.massRadius(a.mass));
      for (const load of this.geometry.loads) include(this.poses.point(k, load.body, load.point), 0.12 * this.length);
      this.includeWheels(k, include);
      include(this.com(k));
      include(this.tool(k));
    }
    return {low, high};
  }
}
