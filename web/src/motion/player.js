// Stage, transport and the switches between them: the mechanism moving.
import {choice, h, toggle} from "../dom.js";
import {withUnit} from "../data/numbers.js";
import {onTheme} from "../theme.js";
import {transport} from "./transport.js";
import {View} from "./view.js";

const keys = "Space: play or pause. Arrow keys: step (with Shift ten samples). Home, End: start, end. + and −: zoom the charts, 0: all of them.";

export class Player {
  constructor(data, clock, Stage) {
    this.data = data;
    this.clock = clock;
    this.layers = {traces: true, force: true, labels: false};
    this.stageBox = h("div", {
      class: "stage", id: "stage", tabindex: "0", role: "group", "aria-label": "The mechanism in motion", "aria-describedby": "keys",
    });
    this.caption = h("p", {class: "stage-reading", id: "stage-reading"});
    this.variants = h("div", {class: "variants"});
    this.element = h("section", {class: "card player", "aria-label": "Animation"}, this.stageBox, this.caption,
      h("div", {class: "screen-only"}, transport(clock),
        h("div", {class: "layers"}, this.variants, this.switches()),
        h("p", {class: "note", id: "keys"}, keys)));
    this.stage = this.makeStage(Stage);
    clock.onChange(() => this.move());
    onTheme(() => this.stage?.setTheme());
  }

  /** WebGL may be missing; the rest of the page does not need it. */
  makeStage(Stage) {
    try {
      return new Stage(this.stageBox);
    } catch (error) {
      this.stageBox.append(h("p", {class: "note stage-missing"}, `This browser cannot draw the mechanism: ${error.message}`));
      return null;
    }
  }

  switches() {
    const names = {traces: "Traces", force: "Shaking force", labels: "Names"};
    return Object.entries(names).map(([layer, text]) =>
      toggle(text, this.layers[layer], (on) => {
        this.layers[layer] = on;
        this.stage?.setLayers(this.layers);
      }, {"data-layer": layer}));
  }

  /** @param runs [{key, label, run}] */
  setRuns(runs) {
    this.runs = runs;
    const before = this.shown ?? "after";
    this.shown = runs.some((r) => r.key === before) ? before : runs[0].key;
    this.variants.replaceChildren();
    if (runs.length > 1)
      this.variants.append(choice("Shown", runs.map(({key, label}) => ({value: key, text: label})), this.shown, (key) => {
        this.shown = key;
        this.show();
      }));
    this.show();
  }

  show() {
    // One scale and one frame for before and after: the pictures can be compared.
    const all = this.runs.map(({key, run}) => new View(this.data, key, run));
    this.view = all[this.runs.findIndex((r) => r.key === this.shown)];
    this.view.alike(all);
    this.stage?.setView(this.view);
    this.stage?.setLayers(this.layers);
    this.move();
  }

  move() {
    if (!this.view) return;
    const sample = Math.min(this.clock.sample, this.view.samples - 1);
    this.stage?.draw(sample);
    const force = Math.hypot(...this.view.force(sample));
    const size = force <= 1e-9 * this.view.forceScale ? 0 : force; // what rounding leaves is nothing
    this.caption.textContent = `Shaking force ${withUnit(size, "N")}`;
  }
}
