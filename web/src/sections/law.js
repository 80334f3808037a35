// The law that was found for the mechanism: which limit holds the motion back, and when that changes.
import {h} from "../dom.js";
import {isDone} from "../data/decode.js";
import {format, withUnit} from "../data/numbers.js";
import {titleOf} from "../charts/quantities.js";
import {plural} from "./overview.js";
import {limitClass, phasePlane} from "./phase.js";

const most = 40;
const limit = (name) => {
  if (!name) return "none: a law in between";
  const [quantity, of] = name.replace("]", "").split("[");
  return of ? `${titleOf(quantity)}, ${of}` : titleOf(quantity);
};

function heading(law, key) {
  const what = law.of ? `gentlest: peak of ${titleOf(law.of).toLowerCase()} ${withUnit(law.peak, law.unit, 6)} in ${withUnit(law.duration, "s", 6)}`
    : `fastest within the limits: ${withUnit(law.duration, "s", 6)}`;
  return `Law found${key ? `, ${key}` : ""}: ${what}, ${plural(law.switches.length, "switch", "switches")}`;
}

function lawTable(law, key) {
  const head = ["Limit reached", "From [s]", "To [s]", "Path from [%]", "To [%]"];
  const cell = (x) => h("td", {class: "number"}, format(x, 6));
  const rows = law.stretches.slice(0, most).map((s) => h("tr", {}, h("th", {scope: "row"}, h("span", {class: `limit-key ${limitClass(law, s.limit)}`}), limit(s.limit)),
    [s.begin, s.end, 100 * s.from, 100 * s.to].map(cell)));
  const more = law.stretches.length - rows.length;
  return h("div", {class: "law"}, h("div", {class: "table-box"}, h("table", {}, h("caption", {}, heading(law, key)),
    h("thead", {}, h("tr", {}, head.map((text, i) => h("th", {scope: "col", class: i ? "number" : ""}, text)))),
    h("tbody", {}, rows))), more > 0 ? h("p", {class: "note"}, `and ${more} more`) : null);
}

const steadyNote = (law, key) => h("p", {class: "note"},
  `Law of steady momentum${key ? `, ${key}` : ""}: ${withUnit(law.momentum, "N m s", 6)} in ${withUnit(law.duration, "s", 6)}`);

const corridorNote = (c, key) => h("p", {class: "note"},
  `Corridor${key ? `, ${key}` : ""}: the motion leaves the path by up to ${withUnit(c.used, c.unit, 6)} of ${withUnit(c.width, c.unit, 6)}; `
  + `${c.of === "duration" ? "duration" : `peak of ${titleOf(c.of).toLowerCase()}`} ${withUnit(c.value, c.value_unit, 6)} instead of `
  + `${withUnit(c.on_path, c.value_unit, 6)}; ${c.agreeing} of ${plural(c.starts, "start", "starts")} converged to it`);

/** For each run of the trajectory its way within a corridor, a table of the law that was found and, with limits, its phase plane; nothing of what is prescribed. */
export function lawTables({before, after}) {
  const both = isDone(before) && isDone(after);
  return [["before", before], ["after", after]].filter(([, run]) => isDone(run)).flatMap(([name, run]) => {
    const key = both ? name : "";
    const law = run.found_law;
    return [run.found_corridor && corridorNote(run.found_corridor, key),
      law && (law.momentum ? steadyNote(law, key) : lawTable(law, key)), phasePlane(run, key)];
  }).filter(Boolean);
}
