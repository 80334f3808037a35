// One chart: lines over time with a playhead, a legend of buttons and the values under the pointer.
import uPlot from "uplot";
import {colour, h} from "../dom.js";
import {format, inShownUnit, unitText, withShownUnit} from "../data/numbers.js";
import {csv, fileName, saveCanvas, saveText} from "../data/save.js";
import {bandName, bandTitle, drawBands, widest, withBands} from "./band.js";
import {linesOf} from "./quantities.js";

const height = 206;
const increments = Array.from({length: 40}, (_, k) => [1, 2, 5].map((factor) => Number(`${factor}e${k - 20}`))).flat();
const palette = 8;
const many = 10; // lines more than a legend can name at a glance
const vanished = 1e-9; // of what a design started from: nothing is left

/** @param variants [{key, label, run}]: one, or before and after */
export class Chart {
  constructor(chart, variants, clock, group) {
    this.chart = chart;
    this.clock = clock;
    this.group = group;
    this.lines = variants.flatMap(({key, label, run}) =>
      linesOf(run, chart).map((line, i) => ({...converted(line, chart.unit), si: line, variant: key, label: nameOf(line, label, chart), colour: i % palette})));
    this.time = variants[0].run.time;
    this.compares = variants.length > 1;
    this.roundOff = this.compares ? vanished * Math.max(...this.lines.map((l) => peak(l.values)), 0) : 0;
    this.shown = this.firstShown();
    this.bands = this.lines.some((l) => l.deviation);
    this.plotBox = h("div", {class: "plot", role: "img", "aria-label": this.description()});
    this.legend = h("div", {class: "legend", role: "group", "aria-label": `Lines of ${chart.title}`});
    this.readings = this.lines.map(() => h("span", {class: "value"}));
    this.element = h("figure", {class: "chart", "data-chart": chart.id, "aria-label": chart.title},
      h("figcaption", {}, h("span", {class: "chart-title"}, chart.heading),
        h("span", {class: "chart-unit"}, unitText(chart.unit)),
        h("span", {class: "chart-tools screen-only"}, this.tool("PNG", "Save the chart as a picture", () => this.savePicture()),
          this.tool("CSV", "Save the chart's values as a table", () => this.saveTable()))),
      this.plotBox, this.crowd(), this.legend);
    this.hovered = null;
    this.addLegend();
  }

  /** Of very many lines the largest ones: the others are a click away. */
  firstShown() {
    if (this.lines.length <= many) return this.lines.map(() => true);
    const sizes = this.lines.map((l) => span(l.values));
    const least = [...sizes].sort((a, b) => b - a)[palette - 1];
    let left = palette;
    return sizes.map((size) => size >= least && left-- > 0);
  }

  /** What a picture of these lines says, in words. */
  description() {
    const {unit, title} = this.chart;
    const off = (l) => (l.deviation ? `, within ${withShownUnit(widest(l), unit)} (3σ of tolerances)` : "");
    const most = this.lines.slice(0, palette).map((l) => `${l.label} up to ${withShownUnit(peak(l.values), unit)}${off(l)}`);
    const rest = this.lines.length - most.length;
    return `${title} over ${format(this.time.at(-1))} s: ${most.join(", ")}${rest > 0 ? ` and ${rest} more` : ""}`;
  }

  tool(text, title, action) {
    const button = h("button", {type: "button", class: "tool", title, "aria-label": `${title}: ${this.chart.title}`}, text);
    button.addEventListener("click", action);
    return button;
  }

  /** Says how many of many lines are shown, and shows all or none. */
  crowd() {
    if (this.lines.length <= many) return "";
    this.legend.classList.add("crowded");
    this.count = h("span", {class: "crowd-count"});
    const every = (text, on) => this.tool(text, on ? "Show all lines" : "Hide all lines", () => this.lines.forEach((_, i) => this.show(i, on)));
    return h("div", {class: "crowd"}, this.count, h("span", {class: "screen-only"}, every("All", true), every("None", false)));
  }

  name() {
    return fileName(this.group.about.title, this.chart.id);
  }

  savePicture() {
    saveCanvas(this.plot.ctx.canvas, colour("panel"), `${this.name()}.png`);
  }

  saveTable() {
    const columns = this.lines.map((l) => ({name: l.label, unit: this.chart.unit, values: l.si.values}));
    for (const l of this.lines)
      if (l.deviation) columns.push({name: `${l.label}, standard deviation`, unit: this.chart.unit, values: l.si.deviation});
    saveText(csv(this.time, columns), "text/csv", `${this.name()}.csv`);
  }

  /** Dashed where there is something to compare with. */
  isOld(line) {
    return this.compares && line.variant === "before";
  }

  /** Once the element is in the page and has a width. */
  draw() {
    this.plot?.destroy();
    this.plot = new uPlot(this.options(this.shown), [this.time, ...this.lines.map((l) => l.values)], this.plotBox);
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
      scales: {x: {time: false}, y: {range: (plot, low, high) => room(...this.seen(plot, low, high))}},
      cursor: {
        sync: {key: this.group.key},
        drag: {x: true, y: false, dist: 6},
        points: {size: 7},
        focus: {prox: 16},
      },
      focus: {alpha: 0.35},
      axes: [
        {...axis, size: 28, incrs: increments, values: tickTexts, label: "time [s]", labelSize: 16, labelGap: 2, labelFont: axis.font},
        {...axis, size: 58, space: 24, incrs: increments, values: tickTexts},
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
        drawAxes: [(plot) => drawBands(plot, this.time, this.banded())],
        setCursor: [(u) => this.hover(u.cursor.left >= 0 ? u.cursor.idx : null)],
        setScale: [(u, key) => {
          if (key === "x" && u.status) this.group.zoomed(this, u.scales.x.min, u.scales.x.max);
          this.move();
        }],
      },
    };
  }

  /** Lines that have a band to be seen. */
  banded() {
    return this.bands ? this.lines.filter((l, i) => this.shown[i] && l.deviation) : [];
  }

  seen(plot, low, high) {
    const [from, to] = plot.series[0].idxs ?? [0, this.time.length - 1];
    return low === null || high === null ? [low, high] : withBands(this.banded(), from, to, low, high);
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
      const button = h("button", {type: "button", class: "key", "aria-pressed": String(this.shown[i]), "data-line": line.label},
        swatch, h("span", {class: "name"}, line.label), this.readings[i]);
      button.addEventListener("click", () => this.show(i, button.getAttribute("aria-pressed") !== "true"));
      return button;
    });
    this.legend.append(...this.buttons, this.bandKey());
    this.countLines();
  }

  /** The bands of all lines at once. */
  bandKey() {
    if (!this.bands) return "";
    const swatch = h("span", {class: "swatch band", "aria-hidden": "true"});
    const button = h("button", {type: "button", class: "key", "aria-pressed": "true", "data-band": "", title: bandTitle},
      swatch, h("span", {class: "name"}, bandName));
    button.addEventListener("click", () => {
      this.bands = !this.bands;
      button.setAttribute("aria-pressed", String(this.bands));
      const {min, max} = this.plot.scales.x;
      this.plot.setScale("x", {min, max}); // the height follows what is seen
      this.plot.redraw(false);
    });
    return button;
  }

  paintLegend() {
    this.buttons.forEach((button, i) => button.style.setProperty("--line", colour(`line-${this.lines[i].colour}`)));
  }

  show(i, on) {
    this.buttons[i].setAttribute("aria-pressed", String(on));
    this.shown[i] = on;
    this.plot.setSeries(i + 1, {show: on});
    this.countLines();
  }

  countLines() {
    if (this.count) this.count.textContent = `${this.shown.filter(Boolean).length} of ${this.lines.length} lines`;
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
      const text = withShownUnit(this.clean(line.values[index]), this.chart.unit);
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

/** A line in the unit that is shown. */
function converted(line, unit) {
  if (inShownUnit(1, unit) === 1) return line;
  const convert = (values) => values?.map((v) => inShownUnit(v, unit));
  return {...line, values: convert(line.values), deviation: convert(line.deviation)};
}

/** Numbers of an axis, with as many digits as tell one from the next. */
function tickTexts(_, values, axis, space, increment) {
  const largest = Math.max(...values.map(Math.abs));
  const digits = largest > 0 ? Math.min(15, Math.max(4, Math.ceil(Math.log10(largest / increment)) + 1)) : 4;
  return values.map((value) => format(Math.abs(value) < 1e-9 * increment ? 0 : value, digits));
}

function nameOf(line, variant, chart) {
  const own = line.name === "value" ? "" : line.name;
  return [own, variant].filter(Boolean).join(" ") || chart.title.replace(/ \(.*/, "");
}

/** The axis: with some room, and never zoomed into what is constant but for the last digits. */
function room(low, high) {
  if (low === null || high === null || !Number.isFinite(low) || !Number.isFinite(high)) return [-1, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  const wide = high - low;
  if (wide > 1e-6 * size) {
    const spare = 0.08 * wide;
    return [low >= 0 && low < spare ? 0 : low - spare, high <= 0 && -high < spare ? 0 : high + spare];
  }
  const middle = (low + high) / 2;
  const half = size > 0 ? 0.2 * size : 1;
  return [middle - half, middle + half];
}

function span(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const v of values) [low, high] = [Math.min(low, v), Math.max(high, v)];
  return high - low;
}

function peak(values) {
  let largest = 0;
  for (const v of values) largest = Math.max(largest, Math.abs(v));
  return largest;
}
