// The phase plane of a path: the rate over the place, the law, and the largest rate that limits leave; the same as a table.
import {h} from "../dom.js";
import {frame, responsiveChart, s} from "../charts/axes.js";
import {numbers} from "../data/decode.js";
import {format} from "../data/numbers.js";

const width = 560;
const headroom = 1.4; // over the law; the ceiling goes on beyond it
const tableRows = 10;
const roundOff = 1e-9; // of the largest value: a law at rest
const lines = 8; // colours

/** Class of a limit's colour, among those of a law. */
export function limitClass(law, limit) {
  return `limit-${[...new Set(law.stretches.map((one) => one.limit))].indexOf(limit) % lines}`;
}

/** The value over a rising list of places. */
function at(places, values, place) {
  let k = 1;
  while (k < places.length - 1 && places[k] < place) ++k;
  const width = places[k] - places[k - 1];
  const part = width > 0 ? Math.min(Math.max((place - places[k - 1]) / width, 0), 1) : 1;
  const value = (1 - part) * values[k - 1] + part * values[k];
  return Number.isFinite(value) ? value : Infinity;
}

/** The columns of a phase plane, in this order. */
const decoded = (plane) => ["place", "rate", "ceiling_place", "ceiling", "time"].map((k) => numbers(plane[k]));

/** Of columns, which may be too long for Math.max. */
const largest = (values) => values.reduce((max, v) => Math.max(max, v), 0);

/** Runs of points below the top. */
function pieces(places, values, top) {
  const all = [];
  let now = null;
  places.forEach((place, k) => {
    const inside = values[k] <= top;
    if (inside && !now) all.push((now = []));
    if (inside) now.push([place, values[k]]);
    else now = null;
  });
  return all;
}

function picture([place, rate, ceilingPlace, ceiling, time], law, label) {
  const top = headroom * largest(rate);
  const between = (from, to) => [[from, at(time, rate, from)]].concat([...time].flatMap((t, k) => (t > from && t < to ? [[t, rate[k]]] : [])), [[to, at(time, rate, to)]])
    .map(([t, v]) => [at(time, place, t), v]);
  return responsiveChart({xLabel: "fraction of the path covered", yLabel: "its rate [1/s]", maxWidth: width, ratio: 0.5, draw: (wide, high) => {
    const {grid, x, y} = frame({width: wide, height: high, range: {x: [0, 1], y: [0, top]}});
    const path = (points, attributes) => s("path", {d: points.map(([a, b], i) => `${i ? "L" : "M"}${x(a).toFixed(1)} ${y(b).toFixed(1)}`).join(""), ...attributes});
    const curves = law?.stretches.length ? law.stretches.map((one) => path(between(one.begin, one.end), {class: `law-line ${limitClass(law, one.limit)}`}))
      : [path([...place].map((p, k) => [p, rate[k]]), {class: "law-line limit-0"})];
    const switches = (law?.switches ?? []).map((t) => s("circle", {class: "switch", cx: x(at(time, place, t)), cy: y(at(time, rate, t)), r: 3.5}));
    return s("svg", {viewBox: `0 0 ${wide} ${high}`, role: "img", "aria-label": label, class: "phase"},
      grid, pieces([...ceilingPlace], [...ceiling], top).map((points) => path(points, {class: "ceiling"})), curves, switches);
  }});
}

function table([place, rate, ceilingPlace, ceiling, time]) {
  const zero = [time, rate].map((values) => roundOff * largest(values));
  const rows = Array.from({length: tableRows + 1}, (_, i) => i / tableRows).map((p) => {
    const most = ceiling.length ? at(ceilingPlace, ceiling, p) : NaN;
    return h("tr", {}, h("th", {scope: "row", class: "number"}, format(100 * p, 3)),
      [at(place, time, p), at(place, rate, p)].map((v, j) => h("td", {class: "number"}, format(Math.abs(v) < zero[j] ? 0 : v, 4))),
      h("td", {class: "number"}, most === Infinity ? "any" : format(most, 4)));
  });
  return h("details", {class: "more", open: true}, h("summary", {}, "The same in numbers"),
    h("div", {class: "table-box"}, h("table", {}, h("caption", {}, "Rate along the path"),
      h("thead", {}, h("tr", {}, ["Path [%]", "Time [s]", "Rate [1/s]", "Largest within limits [1/s]"].map((text) => h("th", {scope: "col", class: "number"}, text)))),
      h("tbody", {}, rows))));
}

/** Nothing for runs without limits. */
export function phasePlane(run, key) {
  if (!run.phase_plane) return null;
  const columns = decoded(run.phase_plane);
  const switches = run.found_law?.switches.length ?? 0;
  const label = `Phase plane${key ? `, ${key}` : ""}: the law's rate along the path, below the largest rate within the limits`;
  return h("figure", {class: "law"}, h("div", {}, picture(columns, run.found_law, label),
    h("figcaption", {class: "note"}, `${label} (dashed)${switches ? "; rings are switches, colours those of the limits above" : ""}.`)), table(columns));
}
