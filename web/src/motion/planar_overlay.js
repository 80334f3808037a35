// What is not the mechanism itself: traces, force, names, scale.
import {lengthText, roundLength} from "../data/numbers.js";

export function drawTraces(stage) {
  const {view, palette} = stage;
  trace(stage, view.column("tool_position"), palette.tool, [2, 4]);
  trace(stage, view.column("com_position"), palette.com, []);
}

/** The whole way faintly, what has been covered clearly. */
function trace(stage, columns, colour, dash) {
  if (!columns) return;
  const {pen, view} = stage;
  const place = (k) => stage.place([columns[0].values[k], columns[1].values[k]]);
  const step = Math.max(1, Math.floor(view.samples / 600));
  const line = (end) => {
    const points = [];
    for (let k = 0; k < end; k += step) points.push(place(k));
    points.push(place(end));
    stage.path(points);
    pen.stroke();
  };
  pen.globalAlpha = 0.35;
  stage.ink(colour, 1.5, dash);
  line(view.samples - 1);
  pen.globalAlpha = 1;
  stage.ink(colour, 2, dash);
  line(stage.sample);
  pen.setLineDash([]);
}

/** The shaking force at the centre of mass: the longest one takes a fifth of the picture. */
export function drawForce(stage) {
  const {view, pen, palette, sample} = stage;
  const com = stage.place(view.com(sample));
  const force = view.force(sample);
  const unit = (0.22 * Math.min(...stage.size)) / Math.max(view.forceScale, 1e-300);
  const [dx, dy] = [force[0] * unit, -force[1] * unit];
  const length = Math.hypot(dx, dy);
  if (length > 2) stage.arrow(com, [com[0] + dx, com[1] + dy], length, palette.force);
  comMark(stage, com);
  const tool = view.tool(sample);
  if (tool) {
    stage.circle(stage.place(tool), 4);
    stage.ink(palette.tool, 2);
    pen.stroke();
  }
}

/** The usual sign of a centre of mass: a circle with two dark quarters. */
function comMark(stage, [x, y]) {
  const {pen, palette} = stage;
  const r = 7;
  stage.circle([x, y], r);
  pen.fillStyle = palette.paper;
  pen.fill();
  pen.fillStyle = palette.com;
  for (const start of [0, Math.PI]) {
    pen.beginPath();
    pen.moveTo(x, y);
    pen.arc(x, y, r, start, start + Math.PI / 2);
    pen.fill();
  }
  stage.circle([x, y], r);
  stage.ink(palette.com, 1.5);
  pen.stroke();
}

export function drawLabels(stage) {
  const {view, pen, palette} = stage;
  pen.font = "12px system-ui, sans-serif";
  pen.textBaseline = "middle";
  const write = (text, [x, y], colour) => {
    pen.lineWidth = 3;
    pen.strokeStyle = palette.paper;
    pen.strokeText(text, x, y);
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
  };
  const beside = (p) => [p[0] + stage.width, p[1] - stage.width];
  for (const joint of view.geometry.joints) write(joint.name, beside(stage.at(joint.second, joint.point_second)), palette.ink);
  pen.font = "italic 12px system-ui, sans-serif";
  pen.textAlign = "center";
  for (let body = 1; body < view.geometry.bodies.length; ++body)
    write(view.geometry.bodies[body].name, stage.at(body, centre(view.outlines[body])), palette.faint);
  for (const part of [...view.geometry.attachments, ...view.geometry.discs])
    if (part.mass > 0) write(part.name, stage.at(part.body, part.position), palette.ink);
  pen.textAlign = "start";
}

function centre(points) {
  const sum = points.reduce((s, p) => s.map((x, i) => x + p[i]), [0, 0, 0]);
  return sum.map((x) => x / Math.max(points.length, 1));
}

/** The world's axes: at its origin where that is in the picture, else in the corner. */
export function drawAxes(stage) {
  const {pen, palette, size} = stage;
  const origin = stage.place([0, 0]);
  const room = 40;
  const inside = origin.every((x, i) => x > 8 && x < size[i] - 8);
  const [x, y] = inside ? origin : [size[0] - room - 14, size[1] - 18];
  pen.font = "italic 12px system-ui, sans-serif";
  pen.textBaseline = "middle";
  for (const [name, dx, dy] of [["x", 1, 0], ["y", 0, -1]]) {
    const tip = [x + room * dx, y + room * dy];
    stage.ink(palette.faint, 1.25);
    stage.path([[x, y], tip]);
    pen.stroke();
    const back = [tip[0] - 6 * dx, tip[1] - 6 * dy];
    stage.path([[back[0] + 3 * dy, back[1] + 3 * dx], tip, [back[0] - 3 * dy, back[1] - 3 * dx]]);
    pen.stroke();
    pen.fillStyle = palette.faint;
    pen.fillText(name, tip[0] + 5 * dx - 3 * Math.abs(dy), tip[1] + 9 * dy);
  }
}

/** A round length in the corner. */
export function scaleBar(stage) {
  const {pen, palette, scale, size} = stage;
  const length = roundLength(90 / scale);
  const [x, y] = [16, size[1] - 16];
  stage.ink(palette.faint, 1.25);
  stage.path([[x, y - 4], [x, y], [x + length * scale, y], [x + length * scale, y - 4]]);
  pen.stroke();
  pen.font = "11px system-ui, sans-serif";
  pen.fillStyle = palette.faint;
  pen.textBaseline = "alphabetic";
  pen.fillText(lengthText(length), x + 4, y - 7);
}
