// What both stages, canvas and WebGL, know of a run: geometry, poses, the force over time, the room that all of it needs.
import {Poses} from "../data/poses.js";
import {heaviest, outline, radius} from "../data/shape.js";

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
    return disc.ratio * columns[disc.follows].values[sample];
  }

  /** Shown on the same scales as others. */
  alike(views) {
    this.forceScale = Math.max(...views.map((v) => v.forceScale));
    const corner = (name, best) => [0, 1, 2].map((i) => best(...views.map((v) => v.box[name][i])));
    this.box = {low: corner("low", Math.min), high: corner("high", Math.max)};
  }

  bounds() {
    return this.box;
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
      for (const a of this.geometry.attachments)
        include(this.poses.point(k, a.body, a.position), this.massRadius(a.mass));
      include(this.com(k));
      include(this.tool(k));
    }
    return {low, high};
  }
}
