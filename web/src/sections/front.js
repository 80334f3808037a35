// The trade-off between figures: its points as a chart and as a table, of which one is chosen and shown with its numbers.
import {h} from "../dom.js";
import {frame, responsiveChart, s, withRoom} from "../charts/axes.js";
import {formatIn, inBrackets, inShownUnit, withUnit} from "../data/numbers.js";

const width = 640;
const label = (figure) => figure.name + inBrackets(figure.unit);

const told = (front, point) => front.figures.map((f, j) => `${f.name} ${withUnit(point.values[j], f.unit, 6)}`).join(", ");

/**
 * One figure over another.
 * @param drawn is given the points' elements, in their order, whenever they are drawn
 */
function chart(front, [across, up], drawn) {
  const {points, figures} = front;
  const values = (j) => points.map((p) => inShownUnit(p.values[j], figures[j].unit));
  const [xs, ys] = [values(across), values(up)];
  return responsiveChart({xLabel: label(figures[across]), yLabel: label(figures[up]), maxWidth: width, ratio: 0.55, draw: (wide, high) => {
    const {grid, x, y} = frame({width: wide, height: high, range: {x: withRoom(xs), y: withRoom(ys)}});
    const places = points.map((_, k) => [x(xs[k]), y(ys[k])]);
    const marks = places.map(([px, py], k) => s("g", {class: "front-point", role: "button", "data-point": k, transform: `translate(${px} ${py})`,
      "aria-label": `Point ${points[k].point}: ${told(front, points[k])}`}, s("circle", {class: "reach", r: 14}), s("circle", {class: "dot", r: 6})));
    drawn(marks);
    return s("svg", {viewBox: `0 0 ${wide} ${high}`, class: "front-chart", role: "group",
      "aria-label": `${figures[up].name} over ${figures[across].name}: ${points.length} designs to choose from`}, grid,
    figures.length === 2 ? s("polyline", {class: "front-line", points: places.map((p) => p.join(",")).join(" ")}) : null, marks);
  }});
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
  const choosers = [];
  const marks = new Map(); // of each chart
  let chosen = front.middle - 1;
  const list = table(front, choosers);
  const shown = h("div", {class: "front-details", role: "status"});
  const paint = () => {
    for (const mark of [...marks.values()].flat()) {
      const isChosen = Number(mark.dataset.point) === chosen;
      mark.setAttribute("aria-pressed", String(isChosen));
      mark.setAttribute("tabindex", isChosen ? "0" : "-1"); // one stop of the tab key; arrows go on from it
    }
  };
  const choose = (k) => {
    chosen = k;
    shown.replaceChildren(...details(front, front.points[k], data.number_units));
    choosers.forEach((button, i) => button.setAttribute("aria-pressed", String(i === k)));
    paint();
  };
  for (const [k, button] of choosers.entries()) button.addEventListener("click", () => choose(k));
  function listen(pair, drawn) {
    const focused = marks.get(pair)?.some((mark) => mark === document.activeElement);
    marks.set(pair, drawn);
    drawn.forEach((mark, k) => {
      mark.addEventListener("click", () => choose(k));
      mark.addEventListener("keydown", (event) => {
        const step = steps[event.key];
        if (!step && event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        event.stopPropagation(); // elsewhere these keys move the mechanism
        const next = Math.min(drawn.length - 1, Math.max(0, k + (step ?? 0)));
        choose(next);
        drawn[next].focus();
      });
    });
    paint();
    if (focused) requestAnimationFrame(() => drawn[chosen].focus());
  }
  const charts = pairs.map((pair) => chart(front, pair, (drawn) => listen(pair, drawn)));
  choose(chosen);
  return h("section", {class: "card", id: "front"}, h("h2", {}, "Trade-off"),
    h("p", {class: "lead"}, `${front.points.length} designs; the one shown at first is nearest to the minima of all figures and is the design on this page.`,
      front.stopped ? " The search ended before all were found." : ""),
    h("div", {class: `front-top${charts.length > 1 ? " several" : ""}`}, h("div", {class: "front-charts"}, charts), shown), list);
}
