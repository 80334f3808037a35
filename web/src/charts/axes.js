// Axes of the drawn charts: round numbers, and a frame as wide as the page leaves room for.
import {h, sizeObserver} from "../dom.js";
import {format} from "../data/numbers.js";

/** h() for SVG. */
export function s(tag, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== undefined) element.setAttribute(name, value);
  element.append(...children.flat(Infinity).filter((c) => c !== null && c !== undefined));
  return element;
}

/** The smallest of 1, 2 or 5 times a power of ten that divides a range into at most so many parts. */
export function roundStep(span, parts) {
  const minStep = span / parts;
  const power = 10 ** Math.floor(Math.log10(minStep));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= minStep * (1 - 1e-9));
}

/** Round numbers within a range. */
export function ticks(low, high, parts) {
  if (!(high > low)) return [low];
  const step = roundStep(high - low, parts);
  const [first, last] = [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
  // A decimal number is nearer to what is meant than a sum of steps.
  return Array.from({length: last - first + 1}, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

/** A range with some room at both ends; of one value, or of values that differ by round-off, about it. */
export function withRoom(values, room = 0.06) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const size = Math.max(Math.abs(low), Math.abs(high));
  const spare = high - low > 1e-9 * size ? room * (high - low) : 0.2 * size || 1;
  // Nothing is shown beyond zero of what has no other sign.
  return [low >= 0 ? Math.max(low - spare, 0) : low - spare, high <= 0 ? Math.min(high + spare, 0) : high + spare];
}

const letter = 6.4; // width of a digit [px]
const below = 24, above = 10, beside = 14; // room for numbers under the frame, and for half of one over and beside it
const minSpacing = {x: 76, y: 30}; // of numbers [px]

/**
 * The frame of a chart with its grid and numbers.
 * @param range {x: [low, high], y: [low, high]} of what is shown
 * @return {grid, x, y}: elements, and the places of values in pixels
 */
export function frame({width, height, range}) {
  const parts = (axis, length) => Math.max(2, Math.floor(length / minSpacing[axis]));
  const rows = ticks(...range.y, parts("y", height - above - below));
  const left = 10 + letter * Math.max(...rows.map((v) => format(v).length));
  const columns = ticks(...range.x, parts("x", width - left - beside));
  const place = ([low, high], from, to) => (v) => from + ((v - low) / (high - low || 1)) * (to - from);
  const [right, bottom] = [width - beside, height - below];
  const [x, y] = [place(range.x, left, right), place(range.y, bottom, above)];
  const number = (value, at, anchor) => s("text", {class: "tick", x: at[0], y: at[1], "text-anchor": anchor}, format(value));
  const grid = [
    rows.map((v) => [s("line", {class: "grid", x1: left, x2: right, y1: y(v), y2: y(v)}), number(v, [left - 7, y(v) + 4], "end")]),
    columns.map((v) => [s("line", {class: "grid", x1: x(v), x2: x(v), y1: above, y2: bottom}), number(v, [x(v), bottom + 17], "middle")]),
    s("path", {class: "axis", d: `M${left},${above}V${bottom}H${right}`}),
  ].flat(2);
  return {grid, x, y};
}

/**
 * A chart that is drawn anew where its width changes, so that its letters stay as large as the page's.
 * @param draw (width, height) → SVG element
 */
export function responsiveChart({xLabel, yLabel, maxWidth, ratio, draw}) {
  const box = h("div", {class: "drawing"});
  let drawn = 0;
  const redraw = (width) => {
    if (width === drawn || width <= 0) return;
    drawn = width;
    box.replaceChildren(draw(width, Math.round(Math.max(170, ratio * width))));
  };
  redraw(maxWidth);
  sizeObserver(() => redraw(Math.min(Math.round(box.clientWidth), maxWidth))).observe(box);
  return h("div", {class: "drawn-chart"}, h("p", {class: "axis-label"}, yLabel), box, h("p", {class: "axis-label across"}, xLabel));
}
