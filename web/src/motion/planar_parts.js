// Counterweights, payloads, discs and springs.
import {discRadius} from "../data/shape.js";

/** Counterweights are discs whose area follows their mass; payloads are squares of that area. */
export function drawLumps(stage, layer) {
  const {view, pen, palette} = stage;
  for (const lump of view.geometry.attachments) {
    const [x, y] = stage.at(lump.body, lump.position);
    const r = view.massRadius(lump.mass) * stage.scale;
    const counterweight = lump.kind === "counterweight";
    if (layer === "marks") {
      if (r > 3) mark(stage, [x, y], Math.min(0.5 * r, 5));
      continue;
    }
    if (counterweight) arm(stage, lump, [x, y]);
    if (lump.shape) solid(stage, lump);
    else if (counterweight) stage.circle([x, y], r);
    else square(pen, x, y, 0.886 * r);
    pen.globalAlpha = 0.85;
    pen.fillStyle = counterweight ? palette.weight : palette.payload;
    pen.fill();
    pen.globalAlpha = 1;
    stage.ink(palette["link-edge"], 1);
    pen.stroke();
  }
}

/** The outline of a solid: a path in the stage's units. */
function solid(stage, lump) {
  const {shape, position, body} = lump;
  const [c, s] = shape.direction;
  const at = (u, v) => stage.at(body, [position[0] + c * u - s * v, position[1] + s * u + c * v, 0]);
  const arc = (radius, from, to) =>
    Array.from({length: 41}, (_, i) => {
      const angle = from + ((to - from) * i) / 40;
      return at(radius * Math.cos(angle) - shape.axis_distance, radius * Math.sin(angle));
    });
  const [R, r, half] = [shape.diameter / 2, shape.inner_diameter / 2, shape.opening / 2];
  if (shape.kind === "plate") {
    const [l, w] = [shape.length / 2, shape.width / 2];
    stage.path([at(-l, -w), at(l, -w), at(l, w), at(-l, w), at(-l, -w)]);
  } else if (shape.kind === "sector") {
    stage.path([...arc(R, -half, half), ...arc(r, half, -half), arc(R, -half, half)[0]]);
  } else {
    stage.path(r > 0 ? [...arc(R, 0, 2 * Math.PI), ...arc(r, 2 * Math.PI, 0)] : arc(R, 0, 2 * Math.PI));
  }
}

function square(pen, x, y, half) {
  pen.beginPath();
  pen.roundRect(x - half, y - half, 2 * half, 2 * half, Math.min(3, half));
}

/** A thin arm to the nearest point of the body that carries it. */
function arm(stage, lump, at) {
  const points = stage.view.outlines[lump.body].map((p) => stage.at(lump.body, p));
  if (points.length === 0 || lump.mass <= 0) return;
  const near = points.reduce((a, b) => (Math.hypot(a[0] - at[0], a[1] - at[1]) <= Math.hypot(b[0] - at[0], b[1] - at[1]) ? a : b));
  stage.path([at, near]);
  stage.ink(stage.palette["link-edge"], 0.5 * stage.width + 2);
  stage.pen.stroke();
  stage.ink(stage.palette.link, 0.5 * stage.width);
  stage.pen.stroke();
}

function mark(stage, [x, y], r) {
  const {pen, palette} = stage;
  stage.ink(palette.paper, 1.25);
  stage.path([[x - r, y], [x + r, y]]);
  pen.stroke();
  stage.path([[x, y - r], [x, y + r]]);
  pen.stroke();
}

/** A disc is a circle with a spoke that shows how it turns. */
export function drawDiscs(stage) {
  const {view, pen, palette} = stage;
  for (const disc of view.geometry.discs) {
    const at = stage.at(disc.body, disc.position);
    const r = discRadius(disc, view.length) * stage.scale;
    const angle = view.poses.angle(stage.sample, disc.body) + view.discAngle(disc, stage.sample) * (disc.axis[2] < 0 ? -1 : 1);
    stage.circle(at, r);
    pen.globalAlpha = 0.28;
    pen.fillStyle = palette.disc;
    pen.fill();
    pen.globalAlpha = 1;
    stage.ink(palette.disc, 1.75);
    pen.stroke();
    const tip = [at[0] + r * Math.cos(angle), at[1] - r * Math.sin(angle)];
    stage.path([at, tip]);
    pen.stroke();
    stage.circle([at[0] + 0.78 * (tip[0] - at[0]), at[1] + 0.78 * (tip[1] - at[1])], Math.min(2.6, 0.2 * r));
    pen.fillStyle = palette.disc;
    pen.fill();
  }
}

/** A zigzag along a line of this length. @returns places: along it and beside it */
function zigzag(length, width) {
  const turns = 9;
  return Array.from({length: 2 * turns + 1}, (_, i) => {
    const side = i === 0 || i === 2 * turns ? 0 : i % 2 === 0 ? width : -width;
    return [length * (0.12 + (0.76 * i) / (2 * turns)), side];
  });
}

/** The parts of a dashpot: the rod with its piston, and the pot. */
function dashpot(length, width) {
  const [piston, bottom, rim] = [0.5 * length, 0.62 * length, 0.38 * length];
  return [
    [[0, 0], [piston, 0], [piston, 0.8 * width], [piston, -0.8 * width]],
    [[rim, width], [bottom, width], [bottom, -width], [rim, -width]],
    [[bottom, 0], [length, 0]],
  ];
}

/** Springs as a zigzag and dampers as a dashpot between their two ends; a spring's damper lies beside it. */
export function drawSprings(stage) {
  const {view, pen, palette} = stage;
  const {springs, force_elements: elements} = view.geometry;
  const isBeside = (damper) => [...springs, ...elements].some((s) => s !== damper && s.name === damper.name);
  for (const spring of [...springs, ...elements]) {
    if (spring.coordinate >= 0) continue; // in a joint
    const a = stage.at(spring.first, spring.point_first);
    const b = stage.at(spring.second, spring.point_second);
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (length < 1) continue;
    const u = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const width = 0.45 * stage.width;
    const shift = spring.is_damper && isBeside(spring) ? 2.2 * width : 0;
    const place = ([t, side]) => [a[0] + t * u[0] - (side + shift) * u[1], a[1] + t * u[1] + (side + shift) * u[0]];
    const lines = spring.is_damper ? dashpot(length, width) : [[[0, 0], ...zigzag(length, width), [length, 0]]];
    for (const line of lines) {
      stage.path(line.map(place));
      stage.ink(palette.faint, 1.4);
      pen.stroke();
    }
    for (const end of [a, b]) {
      stage.circle(end, 3);
      pen.fillStyle = palette.faint;
      pen.fill();
    }
  }
}
