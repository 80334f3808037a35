// What the mechanism is made of, as tables.
import {h} from "../dom.js";
import {format, formatIn, inBrackets, unitText, withUnit} from "../data/numbers.js";
import {largestForce, largestMoment} from "../data/loads.js";
import {plural} from "./overview.js";

const row = (name, ...cells) => h("tr", {}, h("th", {scope: "row"}, name), cells.map((c) => h("td", {}, c)));

function table(caption, head, rows) {
  return h("div", {class: "table-box"}, h("table", {}, h("caption", {}, caption),
    h("thead", {}, h("tr", {}, head.map((c) => h("th", {scope: "col"}, c)))), h("tbody", {}, rows)));
}

const place = (p, planar) => p.slice(0, planar ? 2 : 3).map((x) => formatIn(x, "m")).join(", ");

/** Static and couple unbalance, and the balance quality of ISO 21940-11. */
function unbalanceText(rotor) {
  const couple = rotor.couple_unbalance === null ? [] : [`couple ${withUnit(rotor.couple_unbalance, "kg m^2")}`];
  const grades = rotor.qualities.map((one) => `G ${format(one.quality)} mm/s along ${one.trajectory}`);
  return [`static ${withUnit(rotor.static_unbalance, "kg m")}`, ...couple, ...grades].join("; ");
}

function kinematics(check) {
  if (check.degrees_of_freedom === undefined) return null;
  const facts = [
    ["Degrees of freedom", `${check.degrees_of_freedom} by rank, ${check.degrees_of_freedom_by_counting} by counting`],
    ["Spanning tree", check.tree_joints.join(", ")],
    ...check.loops.map((loop) => [`Loop closed at ${loop.cut_joint}`, `${loop.bodies.join(" – ")}; ${plural(loop.closure_equations, "equation")}`]),
    ...check.redundant.map((text) => ["Redundant", text]),
    ...check.passive_freedoms.map((text) => ["Passive freedom", text]),
    ...check.rotors.map((rotor) => [`Unbalance of ${rotor.body}`, unbalanceText(rotor)]),
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
  const mass = (m) => formatIn(m, "kg");
  const inertia = (b) => b.inertia.map((x) => formatIn(x, "kg m^2")).join(", ");
  const bodies = geometry.bodies.slice(1).map((body, i) => {
    const old = before.bodies[i + 1];
    return row(body.name, changed(old.mass, body.mass, mass), changed(old.com, body.com, vector), changed(old, body, inertia));
  });
  const joints = geometry.joints.map((joint, j) =>
    row(joint.name, joint.type, `${geometry.bodies[joint.first].name} – ${geometry.bodies[joint.second].name}`,
      geometry.actuated.includes(j) ? "motor" : ""));
  const lumps = [
    ...geometry.attachments.map((a, i) => row(a.name, a.kind, geometry.bodies[a.body].name,
      changed(before.attachments[i].mass, a.mass, mass), changed(before.attachments[i].position, a.position, vector))),
    ...geometry.discs.map((d, i) => row(d.name, ["disc, ratio ", changed(before.discs[i].ratio, d.ratio, format)],
      geometry.bodies[d.body].name, changed(before.discs[i].mass, d.mass, mass),
      changed(before.discs[i].position, d.position, vector))),
  ];
  const axes = planar ? "x, y" : "x, y, z";
  const on = (body) => geometry.bodies[body].name;
  return h("section", {class: "card", id: "mechanism"}, h("h2", {}, "Mechanism"), kinematics(data.check),
    h("div", {class: "tables"},
      table("Bodies", ["Body", `Mass${inBrackets("kg")}`, `Centre of mass ${axes}${inBrackets("m")}`, `Inertia about it${inBrackets("kg m^2")}`], bodies),
      table("Joints", ["Joint", "Type", "Connects", "Driven by"], joints),
      lumps.length ? table("Counterweights, payloads and discs", ["Name", "Kind", "On", `Mass${inBrackets("kg")}`, `At ${axes}${inBrackets("m")}`], lumps) : null,
      others(geometry, before, changed, vector, on)));
}

/** Springs, dampers, couplings, loads and friction; tables without lines are left out. */
function others(geometry, before, changed, vector, on) {
  const name = (coordinate) => geometry.coordinates[coordinate].name;
  const turns = (coordinate) => geometry.coordinates[coordinate].unit === "rad";
  const springs = geometry.springs.flatMap((s, i) => (s.coordinate >= 0 ? [] : [row(s.name, `${on(s.first)} – ${on(s.second)}`,
    changed(before.springs[i], s, (x) => withUnit(x.stiffness, "N/m")), changed(before.springs[i], s, (x) => withUnit(x.free_length, "m")),
    changed(before.springs[i], s, (x) => vector(x.point_first)), changed(before.springs[i], s, (x) => vector(x.point_second)))]));
  const inJoints = geometry.springs.flatMap((s, i) => (s.coordinate < 0 ? [] : [row(s.name, name(s.coordinate),
    changed(before.springs[i], s, (x) => withUnit(x.stiffness, turns(s.coordinate) ? "N m/rad" : "N/m")),
    changed(before.springs[i], s, (x) => withUnit(x.preload, turns(s.coordinate) ? "N m" : "N")))]));
  const tables = geometry.force_elements.flatMap((s, i) => (s.is_damper ? [] : [row(s.name,
    s.coordinate < 0 ? `${on(s.first)} – ${on(s.second)}` : name(s.coordinate), s.rows,
    changed(before.force_elements[i], s, (x) => withUnit(x.largest, s.coordinate >= 0 && turns(s.coordinate) ? "N m" : "N")))]));
  const dampers = geometry.force_elements.flatMap((s, i) => (s.is_damper ? [row(s.name, `${on(s.first)} – ${on(s.second)}`,
    changed(before.force_elements[i], s, (x) => withUnit(x.damping, "N s/m")),
    changed(before.force_elements[i], s, (x) => vector(x.point_first)), changed(before.force_elements[i], s, (x) => vector(x.point_second)))] : []));
  const couplings = geometry.couplings.flatMap((c) => c.leaders.map((led) => row(name(c.follower), name(led.coordinate),
    format(c.ratio * led.ratio, 6), withUnit(c.offset, geometry.coordinates[c.follower].unit))));
  const loads = geometry.loads.map((l) => row(l.name, on(l.body), vector(l.point), largest(l.force, largestForce(l), "N"),
    largest(l.moment, largestMoment(l), "N m"), l.frame === "world" ? "world" : "the body", when(l, geometry)));
  const friction = geometry.friction.map((f) => row(name(f.coordinate), withUnit(f.viscous, turns(f.coordinate) ? "N m s/rad" : "N s/m"),
    f.coulomb === f.coulomb_backward ? withUnit(f.coulomb, turns(f.coordinate) ? "N m" : "N")
      : `${withUnit(f.coulomb, turns(f.coordinate) ? "N m" : "N")} forwards, ${withUnit(f.coulomb_backward, turns(f.coordinate) ? "N m" : "N")} backwards`));
  return [
    springs.length ? table("Springs", ["Spring", "Between", "Stiffness", "Free length", `From${inBrackets("m")}`, `To${inBrackets("m")}`], springs) : null,
    inJoints.length ? table("Springs in joints", ["Spring", "In", "Stiffness", "At zero"], inJoints) : null,
    tables.length ? table("Springs with a table", ["Spring", "Between or in", "Rows", "Largest force"], tables) : null,
    dampers.length ? table("Dampers", ["Damper", "Between", "Damping", `From${inBrackets("m")}`, `To${inBrackets("m")}`], dampers) : null,
    couplings.length ? table("Gears and belts", ["Follower", "Leader", "Ratio", "Offset"], couplings) : null,
    loads.length ? table("Loads", ["Load", "On", `At${inBrackets("m")}`, "Force", "Moment", "In the axes of", "When"], loads) : null,
    friction.length ? table("Friction", ["In", "Viscous", "Dry"], friction) : null,
  ];
}

/** A constant vector itself, of a changing one the largest size. */
function largest(list, size, unit) {
  if (size === 0) return "–";
  if (list.length > 1) return `up to ${withUnit(size, unit)}`;
  const used = list[0].map((x, i) => (x === 0 ? null : `${"xyz"[i]} ${formatIn(x, unit)}`)).filter(Boolean);
  return `${used.join(", ")}\u202f${unitText(unit)}`;
}

function when(load, geometry) {
  const rows = load.arguments;
  if (rows.length === 0) return "always";
  const coordinate = geometry.coordinates[load.coordinate];
  const range = `${format(rows[0])} to ${format(rows.at(-1))} ${coordinate ? coordinate.unit : "s"}`;
  if (!coordinate) return `${plural(rows.length, "time")}, ${range}`;
  return `over ${coordinate.name}, ${range}${load.is_periodic ? ", repeated" : ""}`;
}
