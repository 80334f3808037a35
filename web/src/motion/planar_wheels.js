// Wheels that roll on a line.
import {rollingRadius} from "../data/shape.js";

/** Its rim, and a spoke that shows how far it has turned; the line it rolls on. */
export function drawWheel(stage, joint) {
  const {pen, palette, view} = stage;
  const radius = rollingRadius(view.geometry, joint);
  const centre = stage.at(joint.second, joint.point_second);
  stage.circle(centre, radius * stage.scale);
  stage.ink(palette["link-edge"], 2);
  pen.stroke();
  const [x, y] = joint.point_second;
  stage.path([centre, stage.at(joint.second, [x + radius, y])]);
  stage.ink(palette["link-edge"], 1.25);
  pen.stroke();
  const origin = view.poses.point(stage.sample, joint.first, joint.point_first);
  const d = view.poses.direction(stage.sample, joint.first, joint.axis);
  const [low, high] = view.travel(joint);
  const touch = (t) => stage.place([origin[0] + t * d[0] + radius * d[1], origin[1] + t * d[1] - radius * d[0]]);
  stage.path([touch(low - radius), touch(high + radius)]);
  stage.ink(palette.faint, 1.25);
  pen.stroke();
}
