// Links, joints and the ground they stand on.
import {hull} from "../data/shape.js";

const slides = (joint) => joint.type === "prismatic" || joint.type === "pin-slot";

/** A body is the rounded shape around its points. */
export function drawBodies(stage) {
  const {view, pen, palette} = stage;
  for (let body = 1; body < view.geometry.bodies.length; ++body) {
    const corners = hull(view.outlines[body].map((p) => stage.at(body, p)));
    const isBlock = corners.length === 1 && view.geometry.joints.some((j) => slides(j) && j.second === body);
    if (corners.length === 1 && !isBlock) continue;
    if (isBlock) {
      block(stage, body, corners[0]);
      continue;
    }
    stage.path(corners, corners.length > 2);
    stage.ink(palette["link-edge"], stage.width + 2.5);
    pen.stroke();
    stage.path(corners, corners.length > 2);
    stage.ink(palette.link, stage.width);
    pen.fillStyle = palette.link;
    if (corners.length > 2) pen.fill();
    pen.stroke();
  }
}

/** A body with a single point that slides is a block along its guide. */
function block(stage, body, [x, y]) {
  const {pen, palette, view} = stage;
  const joint = view.geometry.joints.find((j) => j.second === body && slides(j));
  const d = view.poses.direction(stage.sample, joint.first, joint.axis);
  pen.save();
  pen.translate(x, y);
  pen.rotate(-Math.atan2(d[1], d[0]));
  pen.beginPath();
  pen.roundRect(-1.5 * stage.width, -0.9 * stage.width, 3 * stage.width, 1.8 * stage.width, 3);
  pen.fillStyle = palette.link;
  stage.ink(palette["link-edge"], 1.25);
  pen.fill();
  pen.stroke();
  pen.restore();
}

export function drawJoints(stage) {
  const {view, pen, palette} = stage;
  const actuated = new Set(view.geometry.actuated);
  const r = 0.42 * stage.width;
  view.geometry.joints.forEach((joint, index) => {
    if (slides(joint) && joint.first !== 0) guide(stage, joint); // a slot in a moving body
    if (joint.type === "fixed" || joint.type === "prismatic") return;
    const at = stage.at(joint.second, joint.point_second);
    if (actuated.has(index)) {
      stage.circle(at, r + 3);
      pen.fillStyle = palette.accent;
      pen.fill();
    }
    stage.circle(at, r);
    pen.fillStyle = palette.paper;
    pen.fill();
    stage.ink(actuated.has(index) ? palette.paper : palette["link-edge"], 1.5);
    pen.stroke();
  });
}

/** Bearings with hatching below them, guides of sliding joints, and the ground's other points as crosses. */
export function drawGround(stage) {
  const {view} = stage;
  for (const joint of view.geometry.joints) {
    if (slides(joint) && joint.first === 0) guide(stage, joint);
    if (joint.first !== 0 && joint.second !== 0) continue;
    if (slides(joint)) continue;
    bearing(stage, stage.place(joint.first === 0 ? joint.point_first : joint.point_second));
  }
}

function bearing(stage, [x, y]) {
  const {pen, palette} = stage;
  const s = 1.3 * stage.width;
  stage.path([[x, y], [x - 0.8 * s, y + 1.35 * s], [x + 0.8 * s, y + 1.35 * s]], true);
  pen.fillStyle = palette.panel;
  stage.ink(palette.faint, 1.25);
  pen.fill();
  pen.stroke();
  hatch(stage, x - 1.2 * s, x + 1.2 * s, y + 1.35 * s, 0.55 * s);
}

function hatch(stage, left, right, y, depth) {
  const {pen, palette} = stage;
  stage.ink(palette.faint, 1.25);
  stage.path([[left, y], [right, y]]);
  pen.stroke();
  stage.ink(palette.faint, 0.9);
  for (let x = left + depth / 2; x <= right + 0.1; x += depth) {
    stage.path([[x, y], [x - depth / 1.4, y + depth]]);
    pen.stroke();
  }
}

/** The line that a slide runs along. */
function guide(stage, joint) {
  const {view, pen, palette} = stage;
  const origin = view.poses.point(stage.sample, joint.first, joint.point_first);
  const d = view.poses.direction(stage.sample, joint.first, joint.axis);
  let [low, high] = [Infinity, -Infinity];
  const step = Math.max(1, Math.floor(view.samples / 60));
  for (let k = 0; k < view.samples; k += step) {
    const o = view.poses.point(k, joint.first, joint.point_first);
    const e = view.poses.direction(k, joint.first, joint.axis);
    const p = view.poses.point(k, joint.second, joint.point_second);
    const along = (p[0] - o[0]) * e[0] + (p[1] - o[1]) * e[1];
    low = Math.min(low, along);
    high = Math.max(high, along);
  }
  const room = 0.15 * view.length;
  const end = (t) => stage.place([origin[0] + t * d[0], origin[1] + t * d[1]]);
  stage.ink(palette.faint, 1.25, [7, 5]);
  stage.path([end(low - room), end(high + room)]);
  pen.stroke();
  pen.setLineDash([]);
}
