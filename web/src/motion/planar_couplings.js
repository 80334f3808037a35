// Gears and belts between joint coordinates, slots, and what the surroundings do: loads.
import {loadAt} from "../data/loads.js";
import {format, withUnit} from "../data/numbers.js";
import {wheels} from "../data/shape.js";

export function drawCouplings(stage) {
  const {view, palette} = stage;
  for (const {leader, follower, coupling, turning} of view.couplings) {
    const a = view.poses.point(stage.sample, leader.second, leader.point_second);
    const b = view.poses.point(stage.sample, follower.second, follower.point_second);
    const [from, to] = [stage.place(a), stage.place(b)];
    const distance = Math.hypot(a[0] - b[0], a[1] - b[1]);
    const made = wheels(coupling.ratio, distance, view.length);
    if (!turning || !made.touching) belt(stage, from, to, made, turning);
    if (!turning) continue;
    gear(stage, from, made.leader * stage.scale, view.turnOf(coupling.leader, leader, stage.sample));
    gear(stage, to, made.follower * stage.scale, view.turnOf(coupling.follower, follower, stage.sample));
    if (stage.layers.labels) note(stage, [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2], `ratio ${format(coupling.ratio)}`, palette.gear);
  }
}

/** A pitch circle with teeth that show how it turns. */
function gear(stage, [x, y], r, angle) {
  const {pen, palette} = stage;
  stage.circle([x, y], r);
  pen.globalAlpha = 0.12;
  pen.fillStyle = palette.gear;
  pen.fill();
  pen.globalAlpha = 1;
  stage.ink(palette.gear, 1.25);
  pen.stroke();
  const teeth = Math.min(Math.max(Math.round(r / 2.5), 10), 40);
  const tooth = Math.min(4, 0.14 * r);
  for (let k = 0; k < teeth; ++k) {
    const a = -angle + (2 * Math.PI * k) / teeth;
    const [c, s] = [Math.cos(a), Math.sin(a)];
    stage.path([[x + (r - tooth) * c, y + (r - tooth) * s], [x + (r + tooth) * c, y + (r + tooth) * s]]);
    stage.ink(palette.gear, k === 0 ? 3 : 1.25);
    pen.stroke();
  }
}

/** Two lines along both wheels; one where something slides. */
function belt(stage, from, to, made, turning) {
  const d = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(...d);
  if (length < 1) return;
  const n = [-d[1] / length, d[0] / length];
  stage.ink(stage.palette.gear, 1.25, [6, 4]);
  for (const side of turning ? [-1, 1] : [0]) {
    const edge = (p, r) => [p[0] + side * r * stage.scale * n[0], p[1] + side * r * stage.scale * n[1]];
    stage.path([edge(from, made.leader), edge(to, made.follower)]);
    stage.pen.stroke();
  }
  stage.pen.setLineDash([]);
}

function note(stage, [x, y], text, colour) {
  const {pen, palette} = stage;
  pen.font = "12px system-ui, sans-serif";
  pen.textBaseline = "middle";
  pen.lineWidth = 3;
  pen.strokeStyle = palette.paper;
  pen.strokeText(text, x, y);
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
}

/** Forces as arrows that end where they act, moments as arcs; the longest takes a sixth of the picture. */
export function drawLoads(stage) {
  const {view, pen, palette} = stage;
  for (const load of view.geometry.loads) {
    const {at, force, moment} = loadAt(view, load, stage.sample);
    const tip = stage.place(at);
    const unit = (0.17 * Math.min(...stage.size)) / Math.max(view.loadScale, 1e-300);
    const [dx, dy] = [force[0] * unit, -force[1] * unit];
    const length = Math.hypot(dx, dy);
    if (length > 2) {
      const tail = [tip[0] - dx, tip[1] - dy];
      stage.arrow(tail, tip, length, palette.load);
      note(stage, [tail[0] + 6, tail[1] - 6], `${load.name} ${withUnit(Math.hypot(force[0], force[1]), "N", 3)}`, palette.load);
    } else {
      stage.circle(tip, 3.5);
      stage.ink(palette.load, 1.5);
      pen.stroke();
      if (!moment[2]) note(stage, [tip[0] + 7, tip[1] - 8], `${load.name} 0`, palette.load);
    }
    if (moment[2]) turnArrow(stage, tip, moment[2], load);
  }
}

function turnArrow(stage, [x, y], moment, load) {
  const {pen, palette} = stage;
  const r = 22;
  const share = Math.min(Math.abs(moment) / Math.max(stage.view.momentScale, 1e-300), 1);
  const sweep = 0.4 + 1.3 * Math.PI * share;
  const sign = moment > 0 ? -1 : 1; // the screen's y points down
  const at = (a) => [x + r * Math.cos(a), y + r * Math.sin(a)];
  const points = Array.from({length: 25}, (_, i) => at((sign * sweep * i) / 24));
  stage.path(points);
  stage.ink(palette.load, 2.5);
  pen.stroke();
  const before = points.at(-4);
  stage.arrow(before, points.at(-1), Math.hypot(points.at(-1)[0] - before[0], points.at(-1)[1] - before[1]) + 6, palette.load);
  note(stage, [x + r + 6, y], `${load.name} ${withUnit(moment, "N m", 3)}`, palette.load);
}
