// What the mechanism is, in a line and a few figures.
import {h} from "../dom.js";
import {isDone} from "../data/decode.js";
import {format, ratio, ratioText, unitText, withUnit} from "../data/numbers.js";

const plural = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;

export function subtitle(data) {
  const check = data.check;
  const parts = [data.space === "planar" ? "Planar mechanism" : "Spatial mechanism"];
  if (check.degrees_of_freedom !== undefined)
    parts.push(`${plural(check.degrees_of_freedom, "degree")} of freedom`, plural(check.bodies, "moving body", "moving bodies"),
      plural(check.joints, "joint"), check.loops.length ? plural(check.loops.length, "loop") : "no loop");
  return parts.join(" · ");
}

const figure = (name, value, note) =>
  h("div", {class: "figure"}, h("dt", {}, name), h("dd", {}, value), note ? h("dd", {class: "figure-note"}, note) : null);

/** Peak of a quantity in the first trajectory that has one. */
function peak(trajectory, key, quantity) {
  return trajectory?.[key]?.metrics?.find((m) => m.quantity === quantity);
}

function change(before, value, unit) {
  const after = Math.abs(value) <= 1e-9 * Math.abs(before) ? 0 : value; // what rounding leaves
  const times = ratio(before, after);
  if (Math.abs(times - 1) < 5e-4) return withUnit(after, unit);
  return [
    h("span", {class: "was"}, format(before)), " → ", withUnit(after, unit),
    times === null ? null : h("span", {class: "times"}, `× ${ratioText(times)}`),
  ];
}

export function figures(data) {
  const shown = [];
  const mass = data.design?.mass;
  shown.push(mass ? figure("Moving mass", change(mass.before, mass.after, "kg"))
    : figure("Moving mass", withUnit(data.check.total_mass ?? data.mass, "kg")));
  const trajectory = data.trajectories.find((t) => isDone(t.before) && (!t.after || isDone(t.after)))
    ?? data.trajectories.find((t) => isDone(t.before) || isDone(t.after));
  for (const [quantity, name] of [["torque", "Peak torque"], ["shaking_force", "Peak shaking force"],
    ["shaking_moment", "Peak shaking moment"]]) {
    const before = peak(trajectory, "before", quantity);
    const after = peak(trajectory, "after", quantity);
    const any = after ?? before;
    if (!any) continue;
    const value = before && after ? change(before.peak, after.peak, any.unit) : withUnit(any.peak, any.unit);
    shown.push(figure(name, value, `along ${trajectory.name}`));
  }
  return h("dl", {class: "figures"}, shown);
}

const row = (name, ...cells) => h("tr", {}, h("th", {scope: "row"}, name), cells.map((c) => h("td", {}, c)));

function table(caption, head, rows) {
  return h("div", {class: "table-box"}, h("table", {}, h("caption", {}, caption),
    h("thead", {}, h("tr", {}, head.map((c) => h("th", {scope: "col"}, c)))), h("tbody", {}, rows)));
}

const place = (p, planar) => p.slice(0, planar ? 2 : 3).map((x) => format(x)).join(", ");

function kinematics(check) {
  if (check.degrees_of_freedom === undefined) return null;
  const facts = [
    ["Degrees of freedom", `${check.degrees_of_freedom} by rank, ${check.degrees_of_freedom_by_counting} by counting`],
    ["Spanning tree", check.tree_joints.join(", ")],
    ...check.loops.map((loop) => [`Loop closed at ${loop.cut_joint}`, `${loop.bodies.join(" – ")}; ${plural(loop.closure_equations, "equation")}`]),
    ...check.redundant.map((text) => ["Redundant", text]),
    ...check.idle.map((text) => ["Idle", text]),
  ];
  return h("dl", {class: "facts"}, facts.map(([name, text]) => [h("dt", {}, name), h("dd", {}, text)]).flat());
}

/** Bodies, joints and what was added to them. */
export function mechanismSection(data) {
  const planar = data.space === "planar";
  const before = data.mechanism.before;
  const geometry = data.mechanism.after ?? before;
  const changed = (was, is, text) => (data.mechanism.after && text(was) !== text(is)
    ? [h("span", {class: "was"}, text(was)), " → ", text(is)] : text(is));
  const vector = (p) => place(p, planar);
  const inertia = (b) => b.inertia.map((x) => format(x)).join(", ");
  const bodies = geometry.bodies.slice(1).map((body, i) => {
    const old = before.bodies[i + 1];
    return row(body.name, changed(old.mass, body.mass, format), changed(old.com, body.com, vector), changed(old, body, inertia));
  });
  const joints = geometry.joints.map((joint, j) =>
    row(joint.name, joint.type, `${geometry.bodies[joint.first].name} – ${geometry.bodies[joint.second].name}`,
      geometry.actuated.includes(j) ? "motor" : ""));
  const lumps = [
    ...geometry.attachments.map((a, i) => row(a.name, a.kind, geometry.bodies[a.body].name,
      changed(before.attachments[i].mass, a.mass, format), changed(before.attachments[i].position, a.position, vector))),
    ...geometry.discs.map((d, i) => row(d.name, ["disc, ratio ", changed(before.discs[i].ratio, d.ratio, format)],
      geometry.bodies[d.body].name, changed(before.discs[i].mass, d.mass, format),
      changed(before.discs[i].position, d.position, vector))),
  ];
  const axes = planar ? "x, y" : "x, y, z";
  return h("section", {class: "card", id: "mechanism"}, h("h2", {}, "Mechanism"), kinematics(data.check),
    h("div", {class: "tables"},
      table("Bodies", ["Body", "Mass [kg]", `Centre of mass ${axes} [m]`, `Inertia about it [${unitText("kg m^2")}]`], bodies),
      table("Joints", ["Joint", "Type", "Connects", "Driven by"], joints),
      lumps.length ? table("Counterweights, payloads and discs", ["Name", "Kind", "On", "Mass [kg]", `At ${axes} [m]`], lumps) : null));
}
