// All charts of a run: which are shown, zoomed together, at the clock's time.
import uPlot from "uplot";
import {h, sizeObserver, toggle} from "../dom.js";
import {onTheme} from "../theme.js";
import {Chart} from "./chart.js";
import {errors, firstShown, listCharts} from "./quantities.js";

export class Board {
  /** @param about {title, controlled}: of runs under control the errors come first */
  constructor(clock, about) {
    this.clock = clock;
    this.about = about;
    this.key = uPlot.sync("balance").key;
    this.charts = [];
    this.shown = null;
    this.range = null;
    this.choices = h("div", {class: "chips", role: "group", "aria-label": "Charts shown"});
    this.list = h("div", {class: "charts"});
    this.reset = h("button", {type: "button", class: "quiet", id: "reset-zoom", disabled: true}, "Reset zoom");
    this.reset.addEventListener("click", () => this.resetZoom());
    this.element = h("div", {class: "board"}, this.list,
      h("details", {class: "more screen-only"}, h("summary", {}, "Choose charts"), this.choices));
    clock.onChange(() => this.charts.forEach((c) => c.move()));
    onTheme(() => this.redraw());
    sizeObserver(() => this.charts.forEach((c) => c.resize(c.plotBox.clientWidth))).observe(this.list);
  }

  /** @param variants as Chart's */
  setRuns(variants) {
    this.variants = variants;
    const available = listCharts(variants[0].run, this.about.controlled);
    this.shown ??= new Set(this.about.controlled ? [...errors, ...firstShown] : firstShown);
    this.choices.replaceChildren(...available.map((chart) =>
      toggle(chart.title, this.isShown(chart), (on) => this.choose(chart, on), {"data-chart": chart.id})));
    this.available = available;
    this.range = null;
    this.rebuild();
  }

  isShown(chart) {
    return this.shown.has(chart.id) || this.shown.has(chart.quantity);
  }

  choose(chart, on) {
    if (on) this.shown.add(chart.id);
    else [chart.id, chart.quantity].forEach((id) => this.shown.delete(id));
    this.rebuild();
  }

  rebuild() {
    for (const chart of this.charts) chart.plot?.destroy();
    this.charts = this.available.filter((c) => this.isShown(c)).map((c) => new Chart(c, this.variants, this.clock, this));
    this.list.replaceChildren(...this.charts.map((c) => c.element));
    this.redraw();
  }

  redraw() {
    const range = this.range;
    this.following = true;
    for (const chart of this.charts) chart.draw();
    this.following = false;
    if (range) this.setRange(...range);
  }

  /** One chart was zoomed: the others follow. */
  zoomed(source, min, max) {
    if (this.following) return;
    this.setRange(min, max, source);
  }

  setRange(min, max, source = null) {
    const {time, duration} = this.clock;
    const whole = min <= time[0] && max >= duration;
    this.range = whole ? null : [min, max];
    this.reset.disabled = whole;
    this.following = true;
    for (const chart of this.charts) if (chart !== source && chart.plot) chart.zoom(min, max);
    queueMicrotask(() => (this.following = false));
  }

  resetZoom() {
    this.setRange(this.clock.time[0], this.clock.duration);
  }

  /** Around the clock's time; factors below one show more detail. */
  zoomBy(factor) {
    const {time, duration, now} = this.clock;
    const [min, max] = this.range ?? [time[0], duration];
    const width = Math.min((max - min) * factor, duration - time[0]);
    if (width < 4 * (time[1] - time[0])) return;
    const left = Math.min(Math.max(now - width / 2, time[0]), duration - width);
    this.setRange(left, left + width);
  }
}
