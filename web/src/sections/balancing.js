// Conditions and the design that meets them.
import {boundOverLengths} from "./bound.js";
import {h, unseen} from "../dom.js";
import {format, formatIn, unitText, withUnit} from "../data/numbers.js";

/** "crank1.mx" as m with what it belongs to: mx of crank1. */
function parameter(name) {
  const dot = name.lastIndexOf(".");
  return h("span", {class: "symbol"}, h("i", {}, name.slice(dot + 1)), h("sub", {}, name.slice(0, dot)));
}

function coefficient(term, first) {
  const text = term.name ?? String(Number(term.coefficient.toPrecision(6)));
  const negative = text.startsWith("-");
  const bare = negative ? text.slice(1) : text;
  const sum = /[+]|.-/.test(bare.replace(/\([^()]*\)/g, ""));
  const sign = negative ? (first ? "−" : " − ") : first ? "" : " + ";
  return [sign, bare === "1" ? "" : h("span", {class: "coefficient"}, powers(sum ? `(${bare})` : bare)), bare === "1" ? "" : "\u2009"];
}

const powers = (text) => text.replace(/\^([0-9])/g, (_, digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(digit)]);

function equation(condition) {
  const terms = condition.terms.map((term, i) =>
    h("span", {class: "term"}, coefficient(term, i === 0), parameter(term.parameter)));
  return h("span", {class: "equation", role: "math", "aria-label": condition.text}, terms, h("span", {class: "term"}, " = 0"));
}

function state(condition) {
  return condition.met
    ? h("span", {class: "state met"}, "met")
    : h("span", {class: "state open"}, `off by ${format(Math.abs(condition.residual), 2)}`);
}

const goals = (goal) => [goal].flat().join(", ");

export function conditionsSection(data) {
  const source = data.design ?? data.conditions;
  if (!source?.conditions || [source.goal].flat().length === 0) return null;
  const shown = source.conditions.filter((c) => !c.by_definition);
  const held = source.conditions.length - shown.length;
  const free = shown.some((c) => c.free.length);
  const after = Boolean(data.design);
  const head = [unseen("No."), "Condition", after ? "Before" : null, after ? "After" : "Now", free ? "Depends on" : null];
  const rows = shown.map((c, i) => h("tr", {}, h("td", {class: "count"}, String(i + 1)), h("td", {}, equation(c)),
    after ? h("td", {class: "number"}, before(c)) : null, h("td", {}, state(c)),
    free ? h("td", {class: "paths"}, c.free.length ? c.free.join(", ") : "nothing free") : null));
  const symbols = source.symbols.map((s) => h("span", {class: "term"}, h("i", {}, s.name), ` = ${withUnit(s.value, s.unit, 6)}`));
  const count = source.conditions.length;
  return h("section", {class: "card", id: "conditions"}, h("h2", {"data-short": "Conditions"}, "Balancing conditions"),
    h("p", {class: "lead"}, `Goal: ${goals(source.goal)}. `,
      `${meaning(data)} Necessary and sufficient: ${count} independent ${count === 1 ? "condition" : "conditions"} on ${source.parameters.length} inertial parameters.`),
    rows.length ? h("div", {class: "table-box"}, h("table", {class: "conditions"}, h("caption", {}, "Sums that must vanish"),
      h("thead", {}, h("tr", {}, head.filter((t) => t !== null).map((t) => h("th", {scope: "col"}, t)))), h("tbody", {}, rows))) : null,
    stays(source.staying ?? []),
    symbols.length ? h("p", {class: "note symbols"}, "where ", symbols.flatMap((s, i) => (i ? [", ", s] : [s]))) : null,
    h("p", {class: "note"}, "m is a body's mass; mx, my, mz its first moments and J or Ixx … Iyz its inertia about the body frame's origin. ",
      "“Off by” is relative to the size of a condition's terms.",
      held ? ` ${held} more hold for every disc that is symmetrical about its axis.` : ""),
    (source.notes ?? []).map((text) => h("p", {class: "note"}, text)));
}

/** What loads, friction and springs ask for whatever the masses are, with the largest efforts. */
function stays(list) {
  if (!list.length) return null;
  const most = (e) => `up to ${withUnit(e.peak, e.unit, 6)} at ${e.actuator} ${e.along ? `along ${e.along}` : "at rest"}`;
  const unknown = (u) => `not known along ${u.along}: ${u.reason}`;
  return h("div", {class: "staying"}, h("p", {}, "Cannot be balanced by masses or springs and remains:"),
    h("ul", {}, list.map((one) => h("li", {}, [one.text, ...one.efforts.map(most), ...one.unknown.map(unknown)].join("; ")))));
}

function before(condition) {
  const value = condition.residual_before;
  if (value === null || value === undefined) return "–";
  return Math.abs(value) < 1e-10 ? "met" : format(Math.abs(value), 2);
}

function meaning(data) {
  const texts = data.conditions?.meaning ?? data.meaning ?? [];
  return texts.map((t) => `${t[0].toUpperCase()}${t.slice(1)}.`).join(" ");
}

const verdicts = {
  balanced: "Balanced",
  compromise: "A compromise",
  impossible: "Cannot be balanced",
  "not-found": "Nothing found",
  "not-asked": "No goal",
};

function bounds(number) {
  const share = (x) => `${(100 * (x - number.lower)) / Math.max(number.upper - number.lower, 1e-300)}%`;
  const mark = (name, x) => {
    const element = h("span", {class: name});
    element.style.left = share(x); // as an attribute the page's own policy would forbid it
    return element;
  };
  return h("span", {class: "range", "aria-hidden": "true"}, mark("range-was", number.before), mark("range-is", number.value));
}

export function designSection(data) {
  const design = data.design;
  if (!design) return null;
  const rows = design.free_numbers.map((n) => {
    const unit = data.number_units[n.path];
    const number = (value) => h("td", {class: "number"}, formatIn(value, unit));
    return h("tr", {}, h("th", {scope: "row"}, n.path), h("td", {class: "unit"}, unitText(unit)), number(n.before),
      h("td", {class: "number strong"}, formatIn(n.value, unit, 6)), number(n.lower), h("td", {class: "range-cell"}, bounds(n)), number(n.upper),
      h("td", {}, n.at_bound ? `at its ${n.at_bound} bound` : ""));
  });
  const objective = design.objective;
  const facts = [
    ["Moving mass", `${formatIn(design.mass.before, "kg")} → ${withUnit(design.mass.after, "kg")}`],
    ["Moments of inertia", `${formatIn(design.inertia.before, "kg m^2")} → ${withUnit(design.inertia.after, "kg m^2")}`],
  ];
  if (objective.name) facts.push([`${objective.global ? "Least" : "Minimized:"} ${objective.name}`, `${withUnit(objective.value, objective.unit, 6)}, ${proofState(objective)}`]);
  return h("section", {class: "card", id: "design"}, h("h2", {}, "Design"),
    h("p", {class: `verdict ${design.status}`}, h("strong", {}, verdicts[design.status] ?? design.status), design.reason ? ` — ${design.reason}.`.replace("..", ".") : "."),
    design.proof && !design.reason.includes(design.proof.sentence) ? h("p", {class: "note"}, design.proof.sentence) : null,
    h("dl", {class: "facts"}, facts.map(([n, t]) => [h("dt", {}, n), h("dd", {}, t)]).flat()),
    partsTable(design.parts),
    boundOverLengths(design),
    rows.length === 0 ? null : h("div", {class: "table-box"}, h("table", {}, h("caption", {}, "Free numbers"),
      h("thead", {}, h("tr", {}, ["Number", "Unit", "Before", "Designed", "From", unseen("Between the bounds"), "To", unseen("At a bound")].map((t, i) =>
        h("th", {scope: "col", class: [2, 3, 4, 6].includes(i) ? "number" : ""}, t)))), h("tbody", {}, rows))),
    unstated(design.free_numbers));
}

/** The bill of materials; null without catalogues. */
function partsTable(parts) {
  if (!parts) return null;
  const price = (value, currency) => value === null ? "–" : `${format(value)} ${currency}`.trim();
  const mass = (value) => value === null ? "–" : withUnit(value, "kg");
  const rows = parts.list.map((part) => h("tr", {}, h("th", {scope: "row"}, part.element), h("td", {}, part.catalogue), h("td", {class: "strong"}, part.part),
    h("td", {class: "number"}, String(part.count)), h("td", {class: "number"}, mass(part.mass)), h("td", {class: "number"}, price(part.price, part.currency))));
  const total = h("tr", {}, h("th", {scope: "row"}, "All parts"), h("td"), h("td"), h("td"), h("td", {class: "number"}, mass(parts.mass)),
    h("td", {class: "number"}, price(parts.price, parts.currency)));
  return h("div", {class: "table-box"}, h("table", {}, h("caption", {}, "Parts"),
    h("thead", {}, h("tr", {}, ["Element", "Catalogue", "Part", "Number", "Mass of one", "Price of one"].map((t, i) =>
      h("th", {scope: "col", class: i > 2 ? "number" : ""}, t)))), h("tbody", {}, rows, total)),
    parts.searched ? h("p", {class: "note"}, `${parts.combinations} combinations of rows${parts.proved ? ", of which this one is proved to be the best" : ""}.`) : null);
}

/** How near to the best a design is proved to be. */
function proofState({global, value, gap}) {
  if (global) return "proved to be the best";
  const share = gap === null ? NaN : gap / Math.abs(value);
  return share <= 0.5 ? `proved to be within ${format(100 * share, 2)} % of the best` : "not shown to be the best";
}

/** What "before" is where nobody has said it. */
function unstated(numbers) {
  const paths = numbers.filter((n) => n.before_from === "middle").map((n) => n.path);
  return paths.length ? h("p", {class: "note"}, `Before: in the middle of the bounds, without a start: ${paths.join(", ")}.`) : null;
}

