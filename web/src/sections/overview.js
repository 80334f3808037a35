// What the mechanism is, in a line and a few figures.
import {h} from "../dom.js";
import {isDone} from "../data/decode.js";
import {formatIn, ratio, ratioText, withUnit} from "../data/numbers.js";

export const plural = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;

export function subtitle(data) {
  const check = data.check;
  const parts = [data.space === "planar" ? "Planar mechanism" : "Spatial mechanism"];
  if (check.degrees_of_freedom !== undefined)
    parts.push(`${plural(check.degrees_of_freedom, "degree")} of freedom`, plural(check.bodies, "moving body", "moving bodies"),
      plural(check.joints, "joint"), check.loops.length ? plural(check.loops.length, "loop") : "no loop");
  return parts.join(" · ");
}

const figure = (name, value, note) =>
  h("div", {class: "figure"}, h("dt", {}, name), h("dd", {}, value), note ? h("dd", {class: "figure-note"}, note) : null);

function change(before, value, unit) {
  const after = Math.abs(value) <= 1e-9 * Math.abs(before) ? 0 : value; // what rounding leaves
  const times = ratio(before, after);
  if (Math.abs(times - 1) < 5e-4) return withUnit(after, unit);
  return [
    h("span", {class: "was"}, formatIn(before, unit)), " → ", withUnit(after, unit),
    times === null ? null : h("span", {class: "times"}, `× ${ratioText(times)}`),
  ];
}

/** Peaks of a quantity by itself or of the motors: those that turn and those that push have no common worst. */
function worst(run, quantity) {
  const all = run?.metrics?.filter((m) => m.quantity === quantity || m.quantity.startsWith(`${quantity}[`)) ?? [];
  const whole = all.filter((m) => m.quantity === quantity);
  const list = whole.length ? whole : [...all].sort((a, b) => a.peak - b.peak);
  return new Map(list.map((m) => [m.unit, m]));
}

/** Peaks of quantities, one for each of their units, before and after a design where there are both. `note` is of a metric. */
function peakFigures(trajectory, quantities, note) {
  return quantities.flatMap(([quantity, name]) => {
    const [before, after] = ["before", "after"].map((key) => worst(trajectory?.[key], quantity));
    // The worst effort of all motors is called a torque, also where all of them push.
    const peaks = [...(after.size ? after : before).values()].filter((m) => !(quantity === "torque" && m.unit === "N"));
    return peaks.map((m) => {
      const was = after.size && before.get(m.unit);
      return figure(name, was ? change(was.peak, m.peak, m.unit) : withUnit(m.peak, m.unit), note(m));
    });
  });
}

/** How well a controller follows: of the tool where there is one, and of the motors. */
const trackingFigures = (trajectory) => peakFigures(trajectory, [["tool_error", "Peak tool error"], ["tracking_error", "Peak tracking error"]],
  (m) => `rms ${withUnit(m.rms, m.unit)}, along ${trajectory.name}`);

export function figures(data) {
  const shown = [];
  const mass = data.design?.mass;
  shown.push(mass ? figure("Moving mass", change(mass.before, mass.after, "kg"))
    : figure("Moving mass", withUnit(data.check.total_mass ?? data.mass, "kg")));
  const trajectory = data.trajectories.find((t) => isDone(t.before) && (!t.after || isDone(t.after)))
    ?? data.trajectories.find((t) => isDone(t.before) || isDone(t.after));
  if (data.controller) shown.unshift(figure("Controller", data.controller.name, data.controller.type), ...trackingFigures(trajectory));
  shown.push(...peakFigures(trajectory, [["torque", "Peak torque"], ["force", "Peak actuator force"], ["shaking_force", "Peak shaking force"],
    ["shaking_moment", "Peak shaking moment"]], () => `along ${trajectory.name}`));
  return h("dl", {class: "figures"}, shown);
}
