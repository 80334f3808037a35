// The bound over all lengths: what it says, and how bound and best design approached each other.
import {h} from "../dom.js";
import {frame, responsiveChart, s, withRoom} from "../charts/axes.js";
import {format, inBrackets, inShownUnit, withUnit} from "../data/numbers.js";

const width = 520;

/** Corners of a line that keeps each value until the next one. */
function steps(xs, ys) {
  return xs.flatMap((x, k) => (k === 0 ? [[x, ys[k]]] : [[x, ys[k - 1]], [x, ys[k]]]));
}

function chart(progress, name, unit, best) {
  const seconds = progress.map((one) => one.seconds);
  const lines = [["bound", progress.map((one) => one.lower_bound)], ["best", progress.map((one) => one.best)]]
    .map(([kind, values]) => {
      const known = values.map((value, k) => [seconds[k], value]).filter(([, value]) => value !== null);
      return {kind, xs: known.map(([x]) => x), ys: known.map(([, value]) => inShownUnit(value, unit))};
    });
  const all = lines.flatMap(({ys}) => ys);
  return responsiveChart({xLabel: "computing time [s]", yLabel: name + inBrackets(unit), maxWidth: width, ratio: 0.4, draw: (wide, high) => {
    const {grid, x, y} = frame({width: wide, height: high, range: {x: [0, Math.max(...seconds)], y: withRoom(all)}});
    const drawn = lines.map(({kind, xs, ys}) => s("polyline", {class: `bound-line ${kind}`,
      points: steps(xs, ys).map(([a, b]) => `${x(a)},${y(b)}`).join(" ")}));
    return s("svg", {viewBox: `0 0 ${wide} ${high}`, class: "bound-chart", role: "img",
      "aria-label": `Lower bound and ${best} design over ${format(Math.max(...seconds))} s of computing`}, grid, drawn);
  }});
}

/** Nothing without a bound. */
export function boundOverLengths(design) {
  const bound = design.length_bound;
  if (!bound || bound.reason) return null;
  const best = bound.unit === "kg" ? "lightest" : "best";
  const said = bound.impossible ? "No lengths within the bounds can be balanced"
    : `No lengths within the bounds need less than ${withUnit(bound.lower_bound, bound.unit, 6)}`;
  const gap = bound.relative_gap === null || bound.relative_gap <= 0 ? "" : `, ${format(100 * bound.relative_gap, 2)} % below the ${best} design`;
  const grows = bound.progress.length > 2;
  return h("figure", {class: "bound"}, h("figcaption", {}, h("span", {class: "chart-title"}, "Bound over all lengths")),
    h("p", {class: "note"}, `${said}${gap}; ${bound.coverage}.`),
    grows ? chart(bound.progress, design.objective.name, bound.unit, best) : null,
    grows ? h("p", {class: "note"}, h("span", {class: "key bound"}), " lower bound, ", h("span", {class: "key best"}), ` ${best} design found`) : null);
}
