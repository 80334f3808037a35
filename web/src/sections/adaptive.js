// Several loads: what the design comes to with each, and how numbers follow the load.
import {h} from "../dom.js";
import {frame, responsiveChart, s, withRoom} from "../charts/axes.js";
import {format, formatIn, inBrackets, inShownUnit, withUnit} from "../data/numbers.js";

const width = 760;
const points = 60;
const palette = 8;

const loadText = (loads, units) => Object.entries(loads).map(([name, value]) => `${name} = ${withUnit(value, units[name], 6)}`).join(", ");

/** @param units of the loads and of the motors' efforts, by name */
function casesTable(caption, cases, units) {
  const motors = Object.keys(cases[0].at_rest);
  const runs = cases[0].trajectories.map((t) => t.trajectory);
  const peak = (run) => run.metrics.find((m) => m.quantity === "torque");
  const head = ["Load", "Conditions", ...motors.map((m) => `${m}, largest at rest${inBrackets(units[m])}`), ...runs.map((r) => `${r}, peak torque`)];
  const rows = cases.map((one) => h("tr", {}, h("th", {scope: "row"}, loadText(one.loads, units)),
    h("td", {}, one.met ? "met" : `off by ${format(one.largest_residual, 2)}`),
    motors.map((m) => h("td", {class: "number"}, formatIn(one.at_rest[m], units[m], 6))),
    one.trajectories.map((run) => h("td", {class: "number"}, peak(run) ? withUnit(peak(run).peak, peak(run).unit, 6) : "–"))));
  return h("div", {class: "table-box"}, h("table", {}, h("caption", {}, caption),
    h("thead", {}, h("tr", {}, head.map((t, i) => h("th", {scope: "col", class: i > 1 ? "number" : ""}, t)))), h("tbody", {}, rows)));
}

const valueAt = (law, name, load) => law.terms.reduce((sum, t) => sum + t.coefficient * load ** (t.powers[name] ?? 0), 0);

/** [[load, value], …] of an adapted number over the range of the only number of the load. */
function courseOf(number, index, adaptive, name, [from, to]) {
  if (!number.law) return adaptive.table.rows.map((row) => [row.loads[name], row.values[index]]);
  return Array.from({length: points + 1}, (_, k) => from + ((to - from) * k) / points).map((p) => [p, valueAt(number.law, name, p)]);
}

function chart(adaptive, name, [from, to], units) {
  const all = [...new Set(adaptive.numbers.map((n) => units[n.path]))];
  const unit = all.length === 1 ? all[0] : ""; // numbers of several units are SI
  const shown = ([p, v]) => [inShownUnit(p, units[name]), inShownUnit(v, unit)];
  const courses = adaptive.numbers.map((n, i) => courseOf(n, i, adaptive, name, [from, to]).map(shown));
  const range = {x: [from, to].map((p) => inShownUnit(p, units[name])), y: withRoom(courses.flat().map(([, v]) => v))};
  const picture = responsiveChart({xLabel: name + inBrackets(units[name]), yLabel: `Adapted number${inBrackets(unit)}`, maxWidth: width, ratio: 0.34,
    draw: (wide, high) => {
      const {grid, x, y} = frame({width: wide, height: high, range});
      return s("svg", {viewBox: `0 0 ${wide} ${high}`, role: "img", class: "course",
        "aria-label": adaptive.numbers.map((n) => `${n.path} from ${withUnit(n.least, units[n.path])} to ${withUnit(n.most, units[n.path])}`).join(", ")},
      grid, courses.map((course, i) => s("polyline", {class: `course-line line-${i % palette}`, points: course.map(([p, v]) => `${x(p)},${y(v)}`).join(" ")})));
    }});
  return h("figure", {class: "load-chart"}, h("figcaption", {}, h("span", {class: "chart-title"}, "Adapted numbers over the load")), picture);
}

function lawTable(adaptive, units) {
  const rows = adaptive.numbers.map((n, i) => {
    const key = h("span", {class: `limit-key limit-${i % palette}`, "aria-hidden": "true"});
    return h("tr", {}, h("th", {scope: "row"}, key, n.path), h("td", {}, n.law ? n.law.text.replaceAll("-", "−") : "a table"),
      h("td", {class: "number"}, withUnit(n.least, units[n.path], 6)), h("td", {class: "number"}, withUnit(n.most, units[n.path], 6)));
  });
  return h("div", {class: "table-box"}, h("table", {}, h("caption", {}, "Law"),
    h("thead", {}, h("tr", {}, ["Number", "Follows the load by (SI)", "From", "To"].map((t, i) =>
      h("th", {scope: "col", class: i > 1 ? "number" : ""}, t)))), h("tbody", {}, rows)));
}

export function loadsSection(data) {
  const cases = data.design?.load_cases ?? [];
  if (!cases.length) return null;
  const {adaptive} = data.design;
  const names = Object.keys(cases[0].loads);
  const units = {...data.number_units};
  for (const c of data.mechanism.before.coordinates) units[c.name] = c.unit === "rad" ? "N m" : "N";
  const loads = cases.map((one) => one.loads[names[0]]);
  return h("section", {class: "card", id: "loads"}, h("h2", {}, "Load cases"), h("div", {class: "tables"}, casesTable("With each load", cases, units),
    adaptive ? [lawTable(adaptive, units), names.length === 1 ? chart(adaptive, names[0], [Math.min(...loads), Math.max(...loads)], units) : null,
      adaptive.within_bounds ? null : h("p", {class: "note"}, "The law leaves the bounds of the free numbers."),
      adaptive.work === null ? null : h("p", {class: "note"},
        `Moving from the least to the largest loads takes ${withUnit(adaptive.work, "J", 4)} against gravity and springs, at the start pose.`),
      casesTable(`Not adapted, as for ${loadText(adaptive.own_load, units)}`, adaptive.not_adapted, units)] : null));
}
