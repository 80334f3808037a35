// Several loads: what the design comes to with each, and how numbers follow the load.
import {h} from "../dom.js";
import {format, formatIn, inBrackets, withUnit} from "../data/numbers.js";

const size = {width: 640, height: 220, left: 64, right: 12, top: 12, bottom: 36};
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

function svg(tag, attributes, text = "") {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  return element;
}

function chart(adaptive, name, range, units) {
  const all = [...new Set(adaptive.numbers.map((n) => units[n.path]))];
  const unit = all.length === 1 ? all[0] : ""; // numbers of several units are SI
  const courses = adaptive.numbers.map((n, i) => courseOf(n, i, adaptive, name, range));
  const values = courses.flat().map(([, v]) => v);
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const x = (p) => size.left + ((p - range[0]) / (range[1] - range[0] || 1)) * (size.width - size.left - size.right);
  const y = (v) => size.height - size.bottom - ((v - low) / (high - low || 1)) * (size.height - size.top - size.bottom);
  const label = (anchor, px, py, text) => {
    const element = svg("text", {x: px, y: py, "text-anchor": anchor, "font-size": 12}, text);
    element.style.fill = "var(--soft)";
    return element;
  };
  const picture = svg("svg", {viewBox: `0 0 ${size.width} ${size.height}`, role: "img", width: "100%",
    "aria-label": adaptive.numbers.map((n) => `${n.path} from ${withUnit(n.least, units[n.path])} to ${withUnit(n.most, units[n.path])}`).join(", ")});
  courses.forEach((course, i) => {
    const line = svg("polyline", {points: course.map(([p, v]) => `${x(p)},${y(v)}`).join(" "), fill: "none", "stroke-width": 2});
    line.style.stroke = `var(--line-${i % palette})`;
    picture.append(line);
  });
  picture.append(label("end", size.left - 6, y(high) + 4, formatIn(high, unit)), label("end", size.left - 6, y(low) + 4, formatIn(low, unit)),
    label("start", size.left, size.height - 18, formatIn(range[0], units[name])), label("end", size.width - size.right, size.height - 18, formatIn(range[1], units[name])),
    label("middle", (size.left + size.width) / 2, size.height - 4, name + inBrackets(units[name])));
  return h("figure", {class: "chart"}, h("figcaption", {}, h("span", {class: "chart-title"}, `Adapted numbers${inBrackets(unit)} over the load`)), picture);
}

function lawTable(adaptive, units) {
  const rows = adaptive.numbers.map((n, i) => {
    const key = h("span", {"aria-hidden": "true"}, "— ");
    key.style.color = `var(--line-${i % palette})`;
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
  return h("section", {class: "card", id: "loads"}, h("h2", {}, "Load cases"), casesTable("With each load", cases, units),
    adaptive ? [lawTable(adaptive, units), names.length === 1 ? chart(adaptive, names[0], [Math.min(...loads), Math.max(...loads)], units) : null,
      adaptive.within_bounds ? null : h("p", {class: "note"}, "The law leaves the bounds of the free numbers."),
      adaptive.work === null ? null : h("p", {class: "note"},
        `Moving from the least to the largest loads takes ${withUnit(adaptive.work, "J", 4)} against gravity and springs, at the start pose.`),
      casesTable(`Not adapted, as for ${loadText(adaptive.own_load, units)}`, adaptive.not_adapted, units)] : null);
}
