// Stage, transport and the switches between them: the mechanism moving.
import {choice, h, toggle} from "../dom.js";
import {withUnit} from "../data/numbers.js";
import {csv, fileName, runColumns, saveText} from "../data/save.js";
import {onTheme} from "../theme.js";
import {transport} from "./transport.js";
import {View} from "./view.js";

const keys = "Space: play or pause. Arrow keys: step (with Shift: ten samples). Home, End: start, end. + and −: zoom the charts, 0: reset the zoom.";

export class Player {
  constructor(data, clock, Stage) {
    this.data = data;
    this.clock = clock;
    this.layers = {traces: true, force: true, loads: true, axes: true, labels: false};
    this.stageBox = h("div", {
      class: "stage", id: "stage", tabindex: "0", role: "group", "aria-label": "The mechanism in motion", "aria-describedby": "keys",
    });
    this.caption = h("p", {class: "stage-reading", id: "stage-reading"});
    this.variants = h("div", {class: "variants"});
    this.element = h("section", {class: "card player", "aria-label": "Animation"}, this.stageBox, this.caption,
      h("div", {class: "screen-only"}, transport(clock),
        h("div", {class: "layers"}, this.variants, this.switches()),
        this.savers = h("div", {class: "layers savers"}),
        h("p", {class: "note", id: "keys"}, keys)));
    this.stage = this.makeStage(Stage);
    this.addSavers();
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
    const names = {traces: "Traces", force: "Shaking force", loads: "Loads", axes: "Axes", labels: "Names"};
    if (this.data.mechanism.before.loads.length === 0) delete names.loads;
    return Object.entries(names).map(([layer, text]) =>
      toggle(text, this.layers[layer], (on) => {
        this.layers[layer] = on;
        this.stage?.setLayers(this.layers);
      }, {"data-layer": layer}));
  }

  /** The picture as it stands, and the run as a table. */
  addSavers() {
    const button = (text, name, action) => {
      const made = h("button", {type: "button", class: "quiet", "data-save": name}, text);
      made.addEventListener("click", action);
      return made;
    };
    for (const kind of this.stage?.formats ?? [])
      this.savers.append(button(`Picture as ${kind.toUpperCase()}`, kind, () => this.stage.save(kind, this.fileName())));
    this.savers.append(button("All values as CSV", "csv", () =>
      saveText(csv(this.view.run.time, runColumns(this.view.run)), "text/csv", `${this.fileName()}.csv`)));
  }

  fileName() {
    return fileName(this.data.title, this.trajectory, this.runs.length > 1 ? this.shown : "");
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
    // Beside what it was before the design, what is left of a force that vanished is nothing.
    const size = this.runs.length > 1 && force <= 1e-9 * this.view.forceScale ? 0 : force;
    this.caption.textContent = `Shaking force ${withUnit(size, "N")}`;
  }
}
