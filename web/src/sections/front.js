// The trade-off between figures: its points as a chart and as a table, of which one is chosen and shown with its numbers.
import {h} from "../dom.js";
import {formatIn, inBrackets, withUnit} from "../data/numbers.js";

const size = {width: 640, height: 360, left: 76, right: 20, top: 16, bottom: 52};
const label = (figure) => figure.name + inBrackets(figure.unit);

function svg(tag, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** A value's place on an axis, with room beside the outermost points. */
function scale(values, from, to) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = 0.06 * (high - low || Math.abs(high) || 1);
  return Object.assign((v) => from + ((v - low + room) / (high - low + 2 * room)) * (to - from), {low, high});
}

const told = (front, point) => front.figures.map((f, j) => `${f.name} ${withUnit(point.values[j], f.unit, 6)}`).join(", ");

/** One figure over another; `marks` become the points, in their order. */
function chart(front, [across, up], marks) {
  const {points, figures} = front;
  const x = scale(points.map((p) => p.values[across]), size.left, size.width - size.right);
  const y = scale(points.map((p) => p.values[up]), size.height - size.bottom, size.top);
  const text = (anchor, px, py, words) => svg("text", {x: px, y: py, "text-anchor": anchor}, words);
  const picture = svg("svg", {viewBox: `0 0 ${size.width} ${size.height}`, class: "front-chart", role: "group",
    "aria-label": `${figures[up].name} over ${figures[across].name}: ${points.length} designs to choose from`});
  picture.append(svg("path", {class: "axis", d: `M${size.left},${size.top}V${size.height - size.bottom}H${size.width - size.right}`}));
  const places = points.map((p) => [x(p.values[across]), y(p.values[up])]);
  if (figures.length === 2) picture.append(svg("polyline", {class: "front-line", points: places.map((p) => p.join(",")).join(" ")}));
  picture.append(
    text("end", size.left - 8, y(y.high) + 4, formatIn(y.high, figures[up].unit)), text("end", size.left - 8, y(y.low) + 4, formatIn(y.low, figures[up].unit)),
    text("middle", x(x.low), size.height - size.bottom + 18, formatIn(x.low, figures[across].unit)), text("middle", x(x.high), size.height - size.bottom + 18, formatIn(x.high, figures[across].unit)),
    text("middle", (size.left + size.width) / 2, size.height - 8, label(figures[across])),
    svg("text", {transform: `translate(14 ${(size.top + size.height - size.bottom) / 2}) rotate(-90)`, "text-anchor": "middle"}, label(figures[up])));
  marks.push(places.map(([px, py], k) => svg("g", {class: "front-point", role: "button", "data-point": k, transform: `translate(${px} ${py})`,
    "aria-label": `Point ${points[k].point}: ${told(front, points[k])}`}, svg("circle", {class: "reach", r: 14}), svg("circle", {class: "dot", r: 6}))));
  picture.append(...marks.at(-1));
  return picture;
}

function table(front, choosers) {
  const head = ["Point", ...front.figures.map(label), "Optimality", "At least"];
  const rows = front.points.map((p, k) => {
    const button = h("button", {type: "button", class: "chip", "data-point": String(k)}, `Point ${p.point}`);
    choosers.push(button);
    const bound = p.lower_bound === null ? "–" : withUnit(p.lower_bound, front.figures[p.minimized].unit, 6);
    return h("tr", {}, h("th", {scope: "row"}, button), p.values.map((v, j) => h("td", {class: "number"}, formatIn(v, front.figures[j].unit, 6))),
      h("td", {}, p.optimality), h("td", {class: "number"}, bound));
  });
  return h("div", {class: "table-box"}, h("table", {}, h("caption", {}, "Designs, none better than another in all figures"),
    h("thead", {}, h("tr", {}, head.map((t, i) => h("th", {scope: "col", class: i && i !== head.length - 2 ? "number" : ""}, t)))),
    h("tbody", {}, rows)));
}

/** The chosen point's numbers. */
function details(front, point, units) {
  const rows = point.free_numbers.map((n) => h("tr", {}, h("th", {scope: "row"}, n.path), h("td", {class: "number strong"}, withUnit(n.value, units[n.path], 6))));
  return [h("p", {}, h("strong", {}, `Point ${point.point}`), `: ${told(front, point)}. `,
    "Written by ", h("code", {}, `balance design … --point ${point.point} -o FILE`), "."),
  h("div", {class: "table-box"}, h("table", {}, h("caption", {}, `Free numbers of point ${point.point}`),
    h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Number"), h("th", {scope: "col", class: "number"}, "Value"))), h("tbody", {}, rows)))];
}

const steps = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1};

export function frontSection(data) {
  const front = data.front?.front;
  if (!front?.points.length) return null;
  const pairs = front.figures.length === 2 ? [[0, 1]] : [[0, 1], [0, 2], [1, 2]];
  const marks = [], choosers = [];
  const charts = pairs.map((pair) => chart(front, pair, marks));
  const list = table(front, choosers);
  const shown = h("div", {class: "front-details", role: "status"});
  const choose = (k) => {
    shown.replaceChildren(...details(front, front.points[k], data.number_units));
    choosers.forEach((button, i) => button.setAttribute("aria-pressed", String(i === k)));
    for (const mark of marks.flat()) {
      const chosen = Number(mark.dataset.point) === k;
      mark.setAttribute("aria-pressed", String(chosen));
      mark.setAttribute("tabindex", chosen ? "0" : "-1"); // one stop of the tab key; arrows go on from it
    }
  };
  for (const [k, button] of choosers.entries()) button.addEventListener("click", () => choose(k));
  for (const of of marks)
    of.forEach((mark, k) => {
      mark.addEventListener("click", () => choose(k));
      mark.addEventListener("keydown", (event) => {
        const step = steps[event.key];
        if (!step && event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        event.stopPropagation(); // elsewhere these keys move the mechanism
        const next = Math.min(of.length - 1, Math.max(0, k + (step ?? 0)));
        choose(next);
        of[next].focus();
      });
    });
  choose(front.middle - 1);
  return h("section", {class: "card", id: "front"}, h("h2", {}, "Trade-off"),
    h("p", {class: "lead"}, `${front.points.length} designs; the one shown at first is nearest to the minima of all figures and is the design on this page.`,
      front.stopped ? " The search ended before all were found." : ""),
    h("div", {class: "front-charts"}, charts), shown, list);
}
