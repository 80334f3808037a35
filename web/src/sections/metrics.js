// Figures of every run as tables.
import {h} from "../dom.js";
import {isDone} from "../data/decode.js";
import {effortName, format, formatIn, inBrackets, ratio, ratioText, unitText} from "../data/numbers.js";
import {titleOf} from "../charts/quantities.js";
import {lawTables} from "./law.js";
import {orderCharts} from "./orders.js";

const main = ["torque", "force", "torque_residual", "force_residual", "power", "shaking_force", "shaking_moment", "ground_force", "ground_moment", "kinetic_energy"];
const tracking = ["tracking_error", "tool_error", "tool_angle_error", "sliding_variable", "torque_variation", "force_variation", "saturation"];

function label({quantity, unit}) {
  const [name, of] = quantity.replace("]", "").split("[");
  const title = titleOf(effortName(name, unit)).replace(/, magnitude|, desired minus actual/, "");
  return of ? `${title}, ${of}` : title;
}

/** What a design leaves of a force that vanished is shown as zero; round-off is zero already. */
function clean(value, other) {
  return Math.abs(value) <= 1e-9 * Math.abs(other) ? 0 : value;
}

const cell = (text, extra = "") => h("td", {class: `number ${extra}`}, text);

function ratioCell(before, after) {
  const value = ratio(before, after);
  const kind = value === null ? "" : value < 0.999 ? "better" : value > 1.001 ? "worse" : "";
  return cell(ratioText(value), kind);
}

function comparisonRow(before, after) {
  const cells = ["peak", "rms"].flatMap((figure) => {
    const was = clean(before[figure], after[figure]);
    const is = clean(after[figure], before[figure]);
    return [cell(formatIn(was, before.unit)), cell(formatIn(is, before.unit)), ratioCell(was, is)];
  });
  return h("tr", {}, h("th", {scope: "row"}, label(before)), h("td", {class: "unit"}, unitText(before.unit)), cells);
}

function plainRow(m) {
  return h("tr", {}, h("th", {scope: "row"}, label(m)), h("td", {class: "unit"}, unitText(m.unit)),
    cell(formatIn(m.peak, m.unit)), cell(format(m.peak_time)), [m.rms, m.mean, m.range].map((x) => cell(formatIn(x, m.unit))));
}

const heads = {
  plain: [["Quantity", "Unit", "Peak", "at [s]", "Rms", "Mean", "Range"]],
  both: [["Quantity", "Unit", "Peak before", "after", "ratio", "Rms before", "after", "ratio"]],
};

function table(caption, kind, rows) {
  return h("div", {class: "table-box"}, h("table", {class: "metrics"}, h("caption", {}, caption),
    h("thead", {}, heads[kind].map((line) => h("tr", {}, line.map((text, i) =>
      h("th", {scope: "col", class: i > 1 ? "number" : ""}, text))))),
    h("tbody", {}, rows)));
}

/** The figures of one trajectory. */
function trajectoryTables(trajectory) {
  const {before, after} = trajectory;
  const both = isDone(before) && isDone(after);
  const list = (isDone(after) ? after : before).metrics;
  const old = new Map(isDone(before) ? before.metrics.map((m) => [m.quantity, m]) : []);
  const make = (m) => (both && old.has(m.quantity) ? comparisonRow(old.get(m.quantity), m) : plainRow(m));
  const kind = both ? "both" : "plain";
  const among = (names) => (m) => names.includes(m.quantity.split("[")[0]);
  const errors = list.filter(among(tracking));
  const rest = list.filter((m) => !among(main)(m) && !among(tracking)(m));
  return [
    errors.length ? table("Control", kind, errors.map(make)) : null,
    table("Motors and frame", kind, list.filter(among(main)).map(make)),
    rest.length ? h("details", {class: "more"}, h("summary", {}, "Motion of the centre of mass, joint reactions"),
      table("Further figures", kind, rest.map(make))) : null,
  ];
}

/** @param controlled runs are under control: how well they follow comes first */
export function metricsSection(controlled) {
  const body = h("div", {});
  const title = h("h2", {"data-short": "Figures"});
  const element = h("section", {class: "card", id: "metrics"}, title, body);
  const show = (trajectory) => {
    element.hidden = Boolean(trajectory.mode); // whose efforts have no meaning
    title.textContent = controlled ? `Figures under control, along ${trajectory.name}` : `Figures along ${trajectory.name}`;
    body.replaceChildren(h("div", {class: "tables"}, lawTables(trajectory), trajectoryTables(trajectory).filter(Boolean)), orderCharts(trajectory) ?? "");
  };
  return {element, show};
}

/** Peaks of all trajectories side by side; nothing for a single one. */
export function trajectoriesTable(data) {
  const runs = data.trajectories.filter((t) => !t.mode).flatMap((t) =>
    [["before", t.before], ["after", t.after]].filter(([, run]) => isDone(run))
      .map(([key, run]) => ({name: t.name, key: t.before && t.after ? key : "", run})));
  if (runs.length < 2) return null;
  const controlled = runs.some(({run}) => run.metrics.some((m) => m.quantity === "tracking_error"));
  const quantities = [...(controlled ? ["tracking_error"] : []), "torque", "shaking_force", "shaking_moment"];
  const find = (run, q) => run.metrics.find((m) => m.quantity === q);
  const units = quantities.map((q) => runs.map(({run}) => find(run, q)?.unit).find(Boolean));
  const rows = runs.map(({name, key, run}) => h("tr", {}, h("th", {scope: "row"}, [name, key].filter(Boolean).join(", ")),
    quantities.map((q, i) => {
      const m = find(run, q);
      return units[i] ? cell(m ? formatIn(m.peak, units[i]) : "–") : null;
    }), cell(formatIn(run.energy, "J"))));
  const head = ["Trajectory", ...quantities.map((q, i) => units[i] && titleOf(effortName(q, units[i])) + inBrackets(units[i])), `Energy moved${inBrackets("J")}`];
  return h("section", {class: "card", id: "trajectories"}, h("h2", {"data-short": "Trajectories"}, "Peaks of all trajectories"),
    h("div", {class: "table-box"}, h("table", {class: "metrics"}, h("caption", {}, "Largest magnitudes"),
      h("thead", {}, h("tr", {}, head.filter(Boolean).map((t, i) => h("th", {scope: "col", class: i ? "number" : ""}, t)))),
      h("tbody", {}, rows))));
}
