// The whole page: sections, the player and the charts, all at one time.
import {choice, h} from "./dom.js";
import {isDone, readData} from "./data/decode.js";
import {preferUnits} from "./data/numbers.js";
import {Board} from "./charts/board.js";
import {Clock} from "./motion/clock.js";
import {Player} from "./motion/player.js";
import {listenToKeys} from "./motion/transport.js";
import {loadsSection} from "./sections/adaptive.js";
import {conditionsSection, designSection} from "./sections/balancing.js";
import {frontSection} from "./sections/front.js";
import {metricsSection, trajectoriesTable} from "./sections/metrics.js";
import {mechanismSection} from "./sections/mechanism.js";
import {figures, subtitle} from "./sections/overview.js";
import {vibrationSection} from "./sections/vibration.js";
import {hintAtHiddenColumns, unfoldOnPaper} from "./fit.js";
import {startTheme, themeButton} from "./theme.js";

function header(data) {
  const print = h("button", {type: "button", class: "quiet"}, "Print");
  print.addEventListener("click", () => window.print());
  return h("header", {class: "top"},
    h("div", {}, h("h1", {}, data.title || "Mechanism"), h("p", {class: "subtitle"}, subtitle(data))),
    h("div", {class: "actions screen-only"}, themeButton(), print));
}

function contents(sections) {
  const links = sections.filter(Boolean).map((s) => h("li", {}, h("a", {href: `#${s.id}`}, s.querySelector("h2").dataset.short ?? s.querySelector("h2").textContent)));
  return h("nav", {class: "contents screen-only", "aria-label": "Contents"}, h("ul", {}, links));
}

/** Runs of a trajectory that can be shown. */
function variantsOf(trajectory) {
  const all = [["before", trajectory.before], ["after", trajectory.after]].filter(([, run]) => isDone(run));
  const several = all.length > 1;
  return all.map(([key, run]) => ({key, run, label: several ? key : ""}));
}

function motionSection(data, clock, Stage, onTrajectory) {
  const runnable = data.trajectories.filter((t) => variantsOf(t).length > 0);
  const failed = data.trajectories.flatMap((t) => [["before", t.before], ["after", t.after]]
    .filter(([, run]) => run && !isDone(run))
    .map(([key, run]) => h("p", {class: "note"}, `${t.name}${t.after ? `, ${key}` : ""}: ${run.outcome.reason}`)));
  const heading = h("h2", {}, "Motion");
  const section = h("section", {id: "motion", class: "motion"}, heading);
  if (runnable.length === 0) {
    section.append(...failed, failed.length ? "" : h("p", {class: "note"}, "The spec has no motion."));
    return {section, board: null, player: null};
  }
  const player = new Player(data, clock, Stage);
  const board = new Board(clock, {title: data.title, controlled: Boolean(data.controller)});
  const about = h("p", {class: "about", role: "status"});
  const thinned = h("p", {class: "note thinned"});
  const choose = (name) => {
    const trajectory = runnable.find((t) => t.name === name);
    const variants = variantsOf(trajectory);
    const path = trajectory.drive === "none" ? "nothing driven" : `${trajectory.law} law on the ${trajectory.drive === "com" ? "centre of mass" : trajectory.drive}`;
    about.textContent = trajectory.mode ? trajectory.mode : data.controller ? `${path}, followed by controller ${data.controller.name} (${data.controller.type})` : path;
    const {run} = variants[0];
    thinned.textContent = run.samples > run.time.length
      ? `${run.samples.toLocaleString("en")} samples were computed; ${run.time.length.toLocaleString("en")} of them are shown, including every extreme.` : "";
    clock.setTimes(run.time);
    player.trajectory = name;
    player.setRuns(variants);
    board.setRuns(variants);
    onTrajectory(trajectory);
  };
  const bar = h("div", {class: "motion-bar"}, heading,
    runnable.length > 1 ? choice("Trajectory", runnable.map((t) => ({value: t.name, text: t.name})), runnable[0].name, choose)
      : h("span", {class: "only"}, runnable[0].name),
    about, h("span", {class: "screen-only push"}, board.reset));
  section.append(bar, ...failed, thinned, h("div", {class: "bench"}, player.element, board.element));
  return {section, board, player, begin: () => choose(runnable[0].name)};
}

function source(data) {
  return h("section", {class: "card", id: "spec"}, h("h2", {}, "Spec"),
    h("details", {class: "more"}, h("summary", {}, data.spec_file), h("pre", {tabindex: "0", role: "region", "aria-label": "Text of the spec"}, data.spec)),
    h("p", {class: "note"}, "Made by ", h("code", {}, data.command), `, balance ${data.version}.`));
}

export function buildPage(Stage) {
  const data = readData(document);
  preferUnits(data.units);
  startTheme();
  const clock = new Clock();
  const metrics = metricsSection(Boolean(data.controller));
  const motion = motionSection(data, clock, Stage, (trajectory) => metrics.show(trajectory));
  const sections = [motion.section, motion.board ? metrics.element : null, trajectoriesTable(data), vibrationSection(data), frontSection(data), designSection(data), loadsSection(data),
    conditionsSection(data), mechanismSection(data), source(data)];
  const skip = h("a", {class: "unseen skip screen-only", href: `#${motion.section.id}`}, "Skip to the motion");
  document.body.append(skip, header(data), h("main", {}, figures(data),
    data.notes.map((text) => h("p", {class: "note"}, text)), contents(sections), sections.filter(Boolean)));
  motion.begin?.();
  const {board} = motion;
  hintAtHiddenColumns(document);
  unfoldOnPaper();
  listenToKeys(clock, {by: (f) => board?.zoomBy(f), reset: () => board?.resetZoom()});
  // For programs that look at the page.
  window.balanceReport = {data, clock, player: motion.player, board};
}
