// One chart: lines over time with a playhead, a legend of buttons and the values under the pointer.
import uPlot from "uplot";
import {colour, h} from "../dom.js";
import {format, unitText, withUnit} from "../data/numbers.js";
import {linesOf} from "./quantities.js";

const height = 190;
const palette = 8;
const roundOff = 1e-9; // of the largest value of the chart: nothing but rounding is left

/** @param variants [{key, label, run}]: one, or before and after */
export class Chart {
  constructor(chart, variants, clock, group) {
    this.chart = chart;
    this.clock = clock;
    this.group = group;
    this.lines = variants.flatMap(({key, label, run}) =>
      linesOf(run, chart).map((line, i) => ({...line, variant: key, label: nameOf(line, label, chart), colour: i % palette})));
    this.time = variants[0].run.time;
    this.compares = variants.length > 1;
    this.roundOff = roundOff * Math.max(...this.lines.map((l) => peak(l.values)), 0);
    this.plotBox = h("div", {class: "plot"});
    this.legend = h("div", {class: "legend", role: "group", "aria-label": `Lines of ${chart.title}`});
    this.readings = this.lines.map(() => h("span", {class: "value"}));
    this.element = h("figure", {class: "chart", "data-chart": chart.id, "aria-label": chart.title},
      h("figcaption", {}, h("span", {class: "chart-title"}, chart.title),
        h("span", {class: "chart-unit"}, unitText(chart.unit))),
      this.plotBox, this.legend);
    this.hovered = null;
    this.addLegend();
  }

  /** Dashed where there is something to compare with. */
  isOld(line) {
    return this.compares && line.variant === "before";
  }

  /** Once the element is in the page and has a width. */
  draw() {
    this.plot?.destroy();
    const shown = this.plot ? this.plot.series.slice(1).map((s) => s.show) : this.lines.map(() => true);
    this.plot = new uPlot(this.options(shown), [this.time, ...this.lines.map((l) => l.values)], this.plotBox);
    this.head = h("div", {class: "playhead"});
    this.plot.over.append(this.head);
    this.listen();
    this.paintLegend();
    this.move();
  }

  options(shown) {
    const line = colour("rule");
    const axis = {
      stroke: colour("faint"), font: "11px system-ui, sans-serif",
      grid: {stroke: line, width: 1}, ticks: {stroke: line, width: 1, size: 4},
    };
    return {
      width: Math.max(this.plotBox.clientWidth, 160),
      height,
      legend: {show: false},
      scales: {x: {time: false}},
      cursor: {
        sync: {key: this.group.key},
        drag: {x: true, y: false, dist: 6},
        points: {size: 7},
        focus: {prox: 16},
      },
      focus: {alpha: 0.35},
      axes: [
        {...axis, size: 30, values: (_, ticks) => ticks.map((t) => `${format(t)}`)},
        {...axis, size: 58, values: (_, ticks) => ticks.map((t) => format(t))},
      ],
      series: [{}, ...this.lines.map((l, i) => ({
        show: shown[i],
        label: l.label,
        stroke: colour(`line-${l.colour}`),
        width: this.isOld(l) ? 1.25 : 1.75,
        dash: this.isOld(l) ? [5, 4] : undefined,
        points: {show: false},
      }))],
      hooks: {
        setCursor: [(u) => this.hover(u.cursor.left >= 0 ? u.cursor.idx : null)],
        setScale: [(u, key) => {
          if (key === "x" && u.status) this.group.zoomed(this, u.scales.x.min, u.scales.x.max);
          this.move();
        }],
      },
    };
  }

  /** A click seeks, a drag zooms. */
  listen() {
    let from = null;
    this.plot.over.addEventListener("mousedown", (e) => (from = e.clientX));
    this.plot.over.addEventListener("click", (e) => {
      if (from !== null && Math.abs(e.clientX - from) > 4) return;
      this.clock.seek(this.plot.posToVal(e.clientX - this.plot.over.getBoundingClientRect().left, "x"));
    });
  }

  addLegend() {
    this.buttons = this.lines.map((line, i) => {
      const swatch = h("span", {class: this.isOld(line) ? "swatch before" : "swatch", "aria-hidden": "true"});
      const button = h("button", {type: "button", class: "key", "aria-pressed": "true", "data-line": line.label},
        swatch, h("span", {class: "name"}, line.label), this.readings[i]);
      button.addEventListener("click", () => this.show(i, button.getAttribute("aria-pressed") !== "true"));
      return button;
    });
    this.legend.append(...this.buttons);
  }

  paintLegend() {
    this.buttons.forEach((button, i) => button.style.setProperty("--line", colour(`line-${this.lines[i].colour}`)));
  }

  show(i, on) {
    this.buttons[i].setAttribute("aria-pressed", String(on));
    this.plot.setSeries(i + 1, {show: on});
  }

  zoom(min, max) {
    const x = this.plot.scales.x;
    if (x.min !== min || x.max !== max) this.plot.setScale("x", {min, max});
  }

  hover(index) {
    this.hovered = index;
    this.read();
  }

  /** The playhead follows the clock. */
  move() {
    if (!this.plot || !this.head) return;
    const at = this.plot.valToPos(this.clock.now, "x");
    const inside = at >= -0.5 && at <= this.plot.over.clientWidth + 0.5;
    this.head.style.display = inside ? "" : "none";
    this.head.style.transform = `translateX(${at}px)`;
    this.read();
  }

  /** Values under the pointer, else at the playhead. */
  read() {
    const index = this.hovered ?? this.clock.sample;
    this.lines.forEach((line, i) => {
      const text = withUnit(this.clean(line.values[index]), this.chart.unit);
      if (this.readings[i].textContent !== text) this.readings[i].textContent = text;
    });
  }

  clean(value) {
    return Math.abs(value) <= this.roundOff ? 0 : value;
  }

  resize(width) {
    if (this.plot && width > 0 && width !== this.plot.width) {
      this.plot.setSize({width, height});
      this.move();
    }
  }
}

function nameOf(line, variant, chart) {
  const own = line.name === "value" ? "" : line.name;
  return [own, variant].filter(Boolean).join(" ") || chart.title.replace(/ \(.*/, "");
}

function peak(values) {
  let largest = 0;
  for (const v of values) largest = Math.max(largest, Math.abs(v));
  return largest;
}
