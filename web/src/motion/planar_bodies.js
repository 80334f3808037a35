// Links, joints and the ground they stand on.
import {hull, rollingRadius} from "../data/shape.js";
import {drawWheel} from "./planar_wheels.js";

const slides = (joint) => joint.type === "prismatic" || joint.type === "pin-slot";

/** A body is the rounded shape around its points. One with a single point is its joint: a block, or nothing of its own. */
export function drawBodies(stage) {
  const {view, pen, palette} = stage;
  for (let body = 1; body < view.geometry.bodies.length; ++body) {
    const corners = hull(view.outlines[body].map((p) => stage.at(body, p)));
    if (corners.length < 2) continue;
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

/** Where something slides: slots with their pins in them, and blocks on their guides. */
export function drawSliders(stage) {
  const {view} = stage;
  for (const joint of view.geometry.joints) {
    if (rollingRadius(view.geometry, joint) > 0) drawWheel(stage, joint);
    else if (joint.type === "pin-slot") slot(stage, joint);
    if (joint.type === "prismatic") block(stage, joint);
  }
}

/** A rectangle around the sliding point, along the guide. */
function along(stage, joint, from, to, half, paint) {
  const {pen, view} = stage;
  const [x, y] = stage.place(view.poses.point(stage.sample, joint.first, joint.point_first));
  const d = view.poses.direction(stage.sample, joint.first, joint.axis);
  pen.save();
  pen.translate(x, y);
  pen.rotate(-Math.atan2(d[1], d[0]));
  pen.beginPath();
  pen.roundRect(from, -half, to - from, 2 * half, Math.min(half, 3));
  paint();
  pen.restore();
}

function block(stage, joint) {
  const {pen, palette, view} = stage;
  const at = view.slide(joint, stage.sample) * stage.scale;
  along(stage, joint, at - 1.5 * stage.width, at + 1.5 * stage.width, 0.95 * stage.width, () => {
    pen.fillStyle = palette.link;
    stage.ink(palette["link-edge"], 1.25);
    pen.fill();
    pen.stroke();
  });
}

/** As long as the motion needs it. */
function slot(stage, joint) {
  const {pen, palette, view} = stage;
  const [low, high] = view.travel(joint);
  const half = 0.62 * stage.width;
  along(stage, joint, low * stage.scale - 1.3 * stage.width, high * stage.scale + 1.3 * stage.width, half + 2, () => {
    pen.fillStyle = palette.panel;
    stage.ink(palette["link-edge"], 1.5);
    pen.fill();
    pen.stroke();
  });
}

export function drawJoints(stage) {
  const {view, pen, palette} = stage;
  const actuated = new Set(view.geometry.actuated);
  const r = 0.42 * stage.width;
  view.geometry.joints.forEach((joint, index) => {
    if (slides(joint) && joint.first !== 0) guide(stage, joint);
    if (joint.type === "fixed") return;
    const at = stage.at(joint.second, joint.point_second);
    if (joint.type === "prismatic") {
      if (actuated.has(index)) dot(stage, at, r, palette.accent);
      return;
    }
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

function dot(stage, at, r, colour) {
  stage.circle(at, r);
  stage.pen.fillStyle = colour;
  stage.pen.fill();
}

/** Bearings with hatching below them, guides of sliding joints, and the ground's other points as crosses. */
export function drawGround(stage) {
  const {view} = stage;
  for (const joint of view.geometry.joints) {
    if (slides(joint) && joint.first === 0) guide(stage, joint);
    if (joint.first !== 0 && joint.second !== 0) continue;
    if (slides(joint) || joint.type === "planar") continue;
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
  const [low, high] = view.travel(joint);
  const room = 0.15 * view.length;
  const end = (t) => stage.place([origin[0] + t * d[0], origin[1] + t * d[1]]);
  stage.ink(palette.faint, 1.25, [7, 5]);
  stage.path([end(low - room), end(high + room)]);
  pen.stroke();
  pen.setLineDash([]);
}
