// Which charts a run can have, and their lines.

import {effortName, inBrackets} from "../data/numbers.js";

const titles = {
  torque: "Actuator torque",
  force: "Actuator force",
  power: "Actuator power",
  shaking_force: "Shaking force",
  shaking_moment: "Shaking moment",
  shaking_moment_com: "Shaking moment about the centre of mass",
  total_torque: "Torque, root of the sum of squares",
  ground_force: "Force on the frame, with weight",
  ground_moment: "Moment on the frame, with weight",
  com_position: "Centre of mass, position",
  com_velocity: "Centre of mass, velocity",
  com_acceleration: "Centre of mass, acceleration",
  tool_position: "Tool, position",
  joint_position: "Joint position",
  joint_velocity: "Joint velocity",
  joint_acceleration: "Joint acceleration",
  joint_force: "Joint reaction, magnitude",
  kinetic_energy: "Kinetic energy",
  potential_energy: "Potential energy",
  mobility: "Mobility (zero at a singularity)",
  tracking_error: "Tracking error of the joints, desired minus actual",
  tool_error: "Tracking error of the tool, desired minus actual",
  tool_angle_error: "Tracking error of the tool's angle",
  desired_position: "Joint position, desired",
  desired_tool_position: "Tool position, desired",
  sliding_variable: "Sliding variable",
  torque_variation: "Torque, sum of all changes",
  force_variation: "Force, sum of all changes",
  torque_measured: "Torque, measured",
  force_measured: "Force, measured",
  torque_residual: "Torque, measured minus computed",
  force_residual: "Force, measured minus computed",
  saturation: "Torque at its limit",
  energy: "Energy",
};
export const errors = ["tool_error", "tracking_error"];
export const firstShown = ["torque", "shaking_force", "shaking_moment"];
const vectors = new Set(["shaking_force", "ground_force", "com_velocity", "com_acceleration", "tool_error"]);
const scalar = new Set(["kinetic_energy", "potential_energy", "mobility"]);

export function titleOf(quantity) {
  return titles[quantity] ?? quantity.replaceAll("_", " ");
}

/** Charts: a quantity with several units (turning and sliding joints) has one for each. */
export function listCharts(run, controlled = false) {
  const charts = [];
  const all = [...run.series.values()];
  const isError = (series) => Number(errors.includes(series.quantity));
  if (controlled) all.sort((a, b) => isError(b) - isError(a) || errors.indexOf(a.quantity) - errors.indexOf(b.quantity));
  for (const series of all) {
    const units = [...new Set(series.columns.map((c) => c.unit))];
    for (const unit of units)
      charts.push({
        id: units.length > 1 ? `${series.quantity}:${unit}` : series.quantity,
        quantity: series.quantity,
        unit,
        heading: titleOf(effortName(series.quantity, unit)),
        title: titleOf(effortName(series.quantity, unit)) + (units.length > 1 ? inBrackets(unit) : ""),
      });
  }
  return charts;
}

function magnitude(columns) {
  return columns[0].values.map((_, i) => Math.hypot(...columns.map((c) => c.values[i])));
}

/** The lines of a chart in one run. */
export function linesOf(run, chart) {
  const series = run.series.get(chart.quantity);
  if (!series) return [];
  const columns = series.columns.filter((c) => c.unit === chart.unit);
  const off = run.deviation?.get(chart.quantity)?.columns.filter((c) => c.unit === chart.unit) ?? [];
  const lines = columns.map((c, i) => ({
    name: scalar.has(chart.quantity) || (columns.length === 1 && c.name === "value") ? "value" : c.name,
    values: c.values,
    deviation: off[i]?.values,
  }));
  if (vectors.has(chart.quantity) && lines.length > 1)
    lines.push({name: "magnitude", values: magnitude(columns), deviation: off.length ? magnitude(off) : undefined, least: 0});
  return lines;
}
