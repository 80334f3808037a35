// Vibrations: modes as a table, and over a sweep the frequencies with the lines of the orders, amplitudes and transmissibility.
import {h} from "../dom.js";
import {frame, responsiveChart, s, withRoom} from "../charts/axes.js";
import {format, formatIn, inBrackets, inShownUnit, unitText} from "../data/numbers.js";

const width = 520;
const lineCount = 6; // styles of lines

const known = (values) => values.filter((value) => value !== null && Number.isFinite(value));

/**
 * Lines and points over the values of a sweep.
 * @param lines [{label, style, values}], null where there is none
 * @param points [[value, y]]
 */
function chart({title, sweep, unit, lines, points = [], pointLabel = ""}) {
  const xs = sweep.values;
  const all = [0, ...lines.flatMap(({values}) => known(values)), ...points.map(([, y]) => y)];
  const legend = lines.map(({label, style}) => h("span", {class: "vibration-entry"}, h("span", {class: `key ${style}`}), ` ${label}`));
  const drawn = responsiveChart({xLabel: sweep.label, yLabel: title + inBrackets(unit), maxWidth: width, ratio: 0.45, draw: (wide, high) => {
    const {grid, x, y} = frame({width: wide, height: high, range: {x: [xs[0], xs.at(-1)], y: withRoom(all)}});
    const traces = lines.map(({values, style}) => s("polyline", {class: `vibration-line ${style}`,
      points: values.map((value, k) => (value === null ? null : `${x(xs[k])},${y(value)}`)).filter(Boolean).join(" ")}));
    const marks = points.map(([at, value]) => s("circle", {class: "vibration-point", cx: x(at), cy: y(value), r: 3}));
    return s("svg", {viewBox: `0 0 ${wide} ${high}`, class: "vibration-chart", role: "img", "aria-label": `${title} over ${sweep.label}`}, grid, traces, marks);
  }});
  return h("figure", {class: "vibration-figure"}, h("figcaption", {}, h("span", {class: "chart-title"}, title)), drawn,
    h("p", {class: "note"}, legend, points.length && pointLabel ? ` ○ ${pointLabel}` : ""));
}

const style = (n) => `line-${n % lineCount}`;

function sweepCharts(sweep) {
  const frequencies = sweep.frequencies.flatMap((list, k) => list.map((frequency) => [sweep.values[k], frequency]));
  const highest = Math.max(0, ...frequencies.map(([, frequency]) => frequency));
  const orderLines = sweep.orders.map((order, n) => ({label: `order ${format(order)}`, style: style(n),
    values: sweep.speeds.map((speed) => {
      const frequency = order * Math.abs(speed) / (2 * Math.PI);
      return frequency <= 1.25 * highest ? frequency : null;
    })})).filter(({values}) => known(values).length > 1);
  const amplitudes = sweep.amplitudes.map(({quantity, unit, linear, exact}) => {
    const lines = sweep.orders.map((order, n) => ({label: `order ${format(order)}`, style: style(n), values: linear.map((row) => inShownUnit(row[n], unit))}));
    const largest = Math.max(...lines.flatMap(({values}) => known(values)));
    const shown = lines.filter(({values}) => Math.max(...known(values)) > 1e-4 * largest);
    const points = exact.flatMap((row, k) => (row ? row.filter((_, n) => shown.includes(lines[n])).map((value) => [sweep.values[k], inShownUnit(value, unit)]) : []));
    return shown.length ? chart({title: `${quantity}, peak of every order`, sweep, unit, lines: shown, points, pointLabel: "exact"}) : null;
  });
  const transmitted = sweep.orders.map((order, n) => ({label: `order ${format(order)}`, style: style(n), values: sweep.transmissibility.map((row) => row[n])}))
    .filter(({values}) => known(values).length > 1);
  return h("div", {class: "vibration-charts"},
    chart({title: "Frequencies of modes and orders", sweep, unit: "Hz", lines: orderLines, points: frequencies, pointLabel: "mode"}), amplitudes,
    transmitted.length ? chart({title: "Transmissibility of the ground force", sweep, unit: "", lines: transmitted}) : null);
}

function modesTable(one) {
  const rows = one.modes.map((mode, k) => h("tr", {}, h("th", {scope: "row"}, String(k + 1)), h("td", {class: "number"}, format(mode.eigenvalue[0])),
    h("td", {class: "number"}, mode.frequency > 0 ? format(mode.frequency, 6) : "–"),
    h("td", {class: "number"}, mode.eigenvalue.some(Boolean) ? format(mode.damping_ratio) : "–"), h("td", {}, mode.text)));
  return h("div", {class: "table-box"}, h("table", {class: "metrics"}, h("caption", {}, `Modes of what ${one.trajectory} leaves free: ${one.stability}`),
    h("thead", {}, h("tr", {}, ["Mode", "Real part [1/s]", "Frequency [Hz]", "Damping ratio", "Shape"].map((text, i) =>
      h("th", {scope: "col", class: i > 0 && i < 4 ? "number" : ""}, text)))), h("tbody", {}, rows)));
}

function responseTable(response) {
  if (!response?.rows?.length) return null;
  const largest = new Map();
  for (const row of response.rows) largest.set(row.quantity, Math.max(largest.get(row.quantity) ?? 0, row.linear, row.exact ?? 0));
  const rows = response.rows.filter((row) => Math.max(row.linear, row.exact ?? 0) > 1e-6 * largest.get(row.quantity))
    .map((row) => h("tr", {}, h("th", {scope: "row"}, row.quantity), h("td", {class: "unit"}, unitText(row.unit)), h("td", {class: "number"}, format(row.order)),
      h("td", {class: "number"}, formatIn(row.linear, row.unit, 6)), h("td", {class: "number"}, formatIn(row.exact, row.unit, 6)),
      h("td", {class: "number"}, format(row.difference, 2))));
  return h("div", {class: "table-box"}, h("table", {class: "metrics"}, h("caption", {}, `Response to ${response.coordinate}: peak of every order, linear and exact`),
    h("thead", {}, h("tr", {}, ["Quantity", "Unit", "Order", "Linear", "Exact", "Difference"].map((text, i) =>
      h("th", {scope: "col", class: i > 1 ? "number" : ""}, text)))), h("tbody", {}, rows)));
}

/** Nothing without coordinates that are free. */
export function vibrationSection(data) {
  if (!data.vibrations?.length) return null;
  return h("section", {class: "card", id: "vibrations"}, h("h2", {}, "Vibrations"),
    h("p", {class: "note"}, "Linearised; the motion of every mode, exaggerated, is one of those that can be chosen above."),
    data.vibrations.map((one) => [modesTable(one), responseTable(one.response), one.sweep ? sweepCharts(one.sweep) : null]));
}
