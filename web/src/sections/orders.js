// Orders of a motion at constant speed: amplitudes as bars, before and after a design side by side, and as a table.
import {h} from "../dom.js";
import {frame, responsiveChart, s, withRoom} from "../charts/axes.js";
import {isDone} from "../data/decode.js";
import {effortName, format, formatIn, inBrackets, inShownUnit} from "../data/numbers.js";
import {titleOf} from "../charts/quantities.js";
import {plural} from "./overview.js";

const width = 360;
const groupWidth = 0.7; // of the distance between orders

function title(quantity, unit) {
  const [name, of] = quantity.replace("]", "").split("[");
  const text = titleOf(effortName(name, unit)).replace(", magnitude", "");
  return of ? `${text}, ${of}` : text;
}

/** Rows of whole quantities by their names; of vectors those of their largest magnitude. */
function wholes({rows}) {
  const groups = new Map();
  for (const row of rows) {
    if (row.component) continue;
    if (!groups.has(row.quantity)) groups.set(row.quantity, []);
    groups.get(row.quantity).push(row);
  }
  return groups;
}

function bars(label, unit, series) {
  const orders = series[0].rows.map((row) => row.order);
  const spacing = orders[0];
  const heights = series.flatMap(({rows}) => rows.map((row) => inShownUnit(row.amplitude, unit)));
  if (!heights.some((value) => value > 0)) return null;
  return responsiveChart({xLabel: "order", yLabel: label + inBrackets(unit), maxWidth: width, ratio: 0.5, draw: (wide, high) => {
    const range = {x: [0, orders.at(-1) + spacing], y: [0, withRoom([0, ...heights])[1]]};
    const {grid, x, y} = frame({width: wide, height: high, range});
    const one = (groupWidth * (x(spacing) - x(0))) / series.length;
    const drawn = series.flatMap(({kind, rows}, k) => rows.map((row) => {
      const top = y(inShownUnit(row.amplitude, unit));
      return s("rect", {class: `order-bar ${kind}`, x: x(row.order) + (k - series.length / 2) * one, width: Math.max(one - 1, 1), y: top, height: y(0) - top});
    }));
    return s("svg", {viewBox: `0 0 ${wide} ${high}`, role: "img", class: "orders-chart", "aria-label": `Amplitudes of the orders of: ${label}`}, grid, drawn);
  }});
}

function table(groups, both) {
  const head = ["Quantity", "Order", both ? "Before" : "Amplitude", both && "After"].filter(Boolean);
  const rows = groups.flatMap(({label, unit, series}) => series[0].rows.map((row, n) => h("tr", {}, h("th", {scope: "row"}, label + inBrackets(unit)),
    h("td", {class: "number"}, format(row.order)), series.map(({rows: all}) => h("td", {class: "number"}, formatIn(all[n].amplitude, unit))))));
  return h("details", {class: "more"}, h("summary", {}, "The same in numbers"),
    h("div", {class: "table-box"}, h("table", {}, h("caption", {}, "Orders"),
      h("thead", {}, h("tr", {}, head.map((text, i) => h("th", {scope: "col", class: i ? "number" : ""}, text)))), h("tbody", {}, rows))));
}

/** Nothing for runs in which nothing turns at constant speed. */
export function orderCharts({before, after}) {
  const runs = [["before", before], ["after", after]].filter(([, run]) => isDone(run) && run.orders);
  if (runs.length === 0) return null;
  const [, {orders}] = runs[0];
  const groups = [...wholes(orders)].map(([quantity, rows]) => ({
    label: title(quantity, rows[0].unit),
    unit: rows[0].unit,
    series: runs.map(([kind, run]) => ({kind, rows: wholes(run.orders).get(quantity)})).filter((one) => one.rows),
  }));
  const charts = groups.map(({label, unit, series}) => bars(label, unit, series)).filter(Boolean);
  if (charts.length === 0) return null;
  return h("figure", {class: "orders"}, h("figcaption", {}, h("span", {class: "chart-title"}, `Orders of the angle of ${orders.coordinate}`)),
    h("p", {class: "note"}, `An order n repeats n times per turn; the run makes ${plural(orders.turns, "turn")}. Amplitudes are peak values, of vectors the largest magnitude.`),
    runs.length > 1 ? h("p", {class: "note"}, h("span", {class: "key before"}), " before, ", h("span", {class: "key after"}), " after") : null,
    h("div", {class: "order-charts"}, charts), table(groups, runs.length > 1));
}
