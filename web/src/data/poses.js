// Where bodies are at a sample. Planar poses are x, y, angle; spatial ones x, y, z and a quaternion w, x, y, z.

export class Poses {
  constructor(values, bodies, space) {
    this.values = values;
    this.bodies = bodies;
    this.planar = space === "planar";
    this.width = this.planar ? 3 : 7;
  }

  offset(sample, body) {
    return (sample * this.bodies + body) * this.width;
  }

  /** World position of a point fixed to a body. */
  point(sample, body, p) {
    const v = this.values;
    const o = this.offset(sample, body);
    if (this.planar) {
      const c = Math.cos(v[o + 2]);
      const s = Math.sin(v[o + 2]);
      return [v[o] + c * p[0] - s * p[1], v[o + 1] + s * p[0] + c * p[1]];
    }
    const [x, y, z] = rotate([v[o + 3], v[o + 4], v[o + 5], v[o + 6]], p);
    return [v[o] + x, v[o + 1] + y, v[o + 2] + z];
  }

  /** World direction of a vector fixed to a body. */
  direction(sample, body, d) {
    const origin = this.point(sample, body, [0, 0, 0]);
    return this.point(sample, body, d).map((x, i) => x - origin[i]);
  }

  angle(sample, body) {
    return this.values[this.offset(sample, body) + 2];
  }
}

function rotate([w, x, y, z], p) {
  const tx = 2 * (y * p[2] - z * p[1]);
  const ty = 2 * (z * p[0] - x * p[2]);
  const tz = 2 * (x * p[1] - y * p[0]);
  return [
    p[0] + w * tx + y * tz - z * ty,
    p[1] + w * ty + z * tx - x * tz,
    p[2] + w * tz + x * ty - y * tx,
  ];
}
