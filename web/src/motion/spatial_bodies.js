// Solids for bodies, joints, counterweights and discs.
import {
  BoxGeometry, CylinderGeometry, ExtrudeGeometry, Group, Matrix4, Mesh, MeshStandardMaterial, Quaternion, Shape,
  SphereGeometry, Vector3,
} from "three";
import {ConvexGeometry} from "three/addons/geometries/ConvexGeometry.js";
import {discRadius, hull} from "../data/shape.js";

const up = new Vector3(0, 1, 0);
const vector = (p) => new Vector3(...p);

function material(colour, opacity = 1) {
  return new MeshStandardMaterial({color: colour, roughness: 0.55, metalness: 0.08, opacity, transparent: opacity < 1});
}

/** A rod from a to b. */
export function rod(a, b, radius, paint) {
  const d = vector(b).sub(vector(a));
  const mesh = new Mesh(new CylinderGeometry(radius, radius, Math.max(d.length(), 1e-9), 20), paint);
  mesh.quaternion.setFromUnitVectors(up, d.clone().normalize());
  mesh.position.copy(vector(a).add(vector(b)).multiplyScalar(0.5));
  return mesh;
}

function ball(p, radius, paint) {
  const mesh = new Mesh(new SphereGeometry(radius, 24, 16), paint);
  mesh.position.copy(vector(p));
  return mesh;
}

/** Axes in which flat points have no third coordinate; null if they are not flat. */
function flatAxes(points, thickness) {
  const o = points[0];
  const u = points.map((p) => p.clone().sub(o)).sort((a, b) => b.length() - a.length())[0].clone().normalize();
  const away = points.map((p) => p.clone().sub(o).cross(u)).sort((a, b) => b.length() - a.length())[0];
  if (away.length() < 1e-6 * thickness) return null;
  const n = away.clone().normalize();
  if (points.some((p) => Math.abs(p.clone().sub(o).dot(n)) > 0.2 * thickness)) return null;
  return {o, u, v: n.clone().cross(u), n};
}

/** Two points: a rod; flat ones: a plate; others: their hull. */
function solid(points, width, paint) {
  const parts = points.map((p) => ball(p, width, paint));
  if (points.length === 2) parts.push(rod(points[0], points[1], width, paint));
  if (points.length < 3) return parts;
  const places = points.map(vector);
  const axes = flatAxes(places, width);
  if (!axes) {
    const line = places.every((p) => p.clone().sub(places[0]).cross(places[1].clone().sub(places[0])).length() < 1e-9);
    if (line) return [...parts, ...points.slice(1).map((p) => rod(points[0], p, width, paint))];
    return [...parts, new Mesh(new ConvexGeometry(places), paint)];
  }
  const flat = hull(places.map((p) => [p.clone().sub(axes.o).dot(axes.u), p.clone().sub(axes.o).dot(axes.v)]));
  const shape = new Shape();
  flat.forEach(([x, y], i) => (i === 0 ? shape.moveTo(x, y) : shape.lineTo(x, y)));
  const plate = new Mesh(new ExtrudeGeometry(shape, {depth: 1.1 * width, bevelEnabled: false}), paint);
  const frame = new Matrix4().makeBasis(axes.u, axes.v, axes.u.clone().cross(axes.v));
  frame.setPosition(axes.o.clone().addScaledVector(axes.u.clone().cross(axes.v), -0.55 * width));
  plate.applyMatrix4(frame);
  const edges = points.length < 8 ? flat.map((_, i) => i) : [];
  const back = ([x, y]) => axes.o.clone().addScaledVector(axes.u, x).addScaledVector(axes.v, y).toArray();
  return [...parts, plate, ...edges.map((i) => rod(back(flat[i]), back(flat[(i + 1) % flat.length]), width, paint))];
}

function jointSolid(joint, width, paint) {
  const at = joint.point_first;
  if (/spherical|universal/.test(joint.type)) return ball(at, 1.75 * width, paint);
  const axis = vector(joint.axis);
  if (joint.type === "prismatic" || joint.type === "fixed") {
    const box = new Mesh(new BoxGeometry(3 * width, 4 * width, 3 * width), paint);
    box.quaternion.setFromUnitVectors(up, axis);
    box.position.copy(vector(at));
    return box;
  }
  const half = axis.clone().multiplyScalar(2.1 * width);
  return rod(vector(at).sub(half).toArray(), vector(at).add(half).toArray(), 1.7 * width, paint);
}

/** What rolls on a plane: a disc with a spoke, or a sphere with a spot. */
function rollingSolid(joint, width, palette) {
  const solid = new Group();
  const r = joint.radius;
  const paint = material(palette.disc, 0.55);
  const mark = material(palette["link-edge"]);
  if (joint.spin) {
    solid.add(new Mesh(new CylinderGeometry(r, r, 0.9 * width, 48), paint));
    solid.add(rod([0, 0, 0], [r, 0, 0], 0.55 * width, mark));
    solid.quaternion.setFromUnitVectors(up, vector(joint.spin));
  } else {
    solid.add(ball([0, 0, 0], r, paint));
    solid.add(ball([r, 0, 0], 0.9 * width, mark));
  }
  solid.position.copy(vector(joint.point_second));
  return solid;
}

/** A solid disc with a dark spoke on both faces. */
function discSolid(disc, length, width, palette) {
  const r = discRadius(disc, length);
  const spin = new Group();
  spin.add(new Mesh(new CylinderGeometry(r, r, 0.9 * width, 40), material(palette.disc, 0.55)));
  spin.add(rod([0, 0, 0], [r, 0, 0], 0.55 * width, material(palette["link-edge"])));
  spin.add(ball([0.75 * r, 0, 0], 0.9 * width, material(palette["link-edge"])));
  const axis = vector(disc.axis);
  return {spin, upright: new Quaternion().setFromUnitVectors(up, axis), axis};
}

function lumpSolid(lump, view, palette) {
  const r = view.massRadius(lump.mass);
  if (r <= 0) return null;
  if (lump.kind === "counterweight") return ball(lump.position, r, material(palette.weight));
  const box = new Mesh(new BoxGeometry(1.6 * r, 1.6 * r, 1.6 * r), material(palette.payload, 0.9));
  box.position.copy(vector(lump.position));
  return box;
}

/** The ground: what carries its joints. A single one stands on a post. */
function base(view, width, palette) {
  const feet = view.geometry.joints.flatMap((j) =>
    (j.first === 0 ? [j.point_first] : []).concat(j.second === 0 ? [j.point_second] : []));
  const places = feet.filter((p, i) => feet.findIndex((q) => vector(q).distanceTo(vector(p)) < 1e-9) === i);
  const paint = material(palette.faint, 0.35);
  if (places.length > 1) return solid(places, 0.6 * width, paint);
  const floor = view.bounds().low[2] - 0.06 * view.length;
  return places.filter((p) => p[2] - floor > width).map((p) => rod(p, [p[0], p[1], floor], 0.9 * width, paint));
}

/** Between the two parts of a sliding joint, and along springs and dampers: a thin rod that grows and shrinks. */
function telescopes(view, width, palette) {
  const {joints, springs, force_elements: elements} = view.geometry;
  const sliding = joints.filter((j) => j.type === "prismatic" || j.type === "cylindrical");
  const make = (part, radius, paint) => {
    const mesh = new Mesh(new CylinderGeometry(radius, radius, 1, 16), paint);
    const move = (sample) => {
      const a = vector(view.poses.point(sample, part.first, part.point_first));
      const d = vector(view.poses.point(sample, part.second, part.point_second)).sub(a);
      mesh.visible = d.length() > 1e-9;
      mesh.scale.set(1, Math.max(d.length(), 1e-9), 1);
      mesh.quaternion.setFromUnitVectors(up, d.clone().normalize());
      mesh.position.copy(a).addScaledVector(d, 0.5);
    };
    return {mesh, move};
  };
  return [
    ...sliding.map((j) => make(j, 0.5 * width, material(palette["link-edge"]))),
    ...[...springs, ...elements].filter((s) => s.coordinate < 0).map((s) => make(s, 0.3 * width, material(palette.faint))),
  ];
}

/** Everything that moves with the bodies. */
export function makeBodies(view, palette) {
  const {geometry} = view;
  const width = 0.022 * view.length;
  const groups = geometry.bodies.map(() => new Group());
  const link = material(palette.link);
  geometry.bodies.forEach((_, b) => {
    if (b > 0) groups[b].add(...solid(view.outlines[b], width, link));
  });
  groups[0].add(...base(view, width, palette));
  const actuated = new Set(geometry.actuated);
  geometry.joints.forEach((joint, j) => {
    if (joint.radius) {
      groups[joint.second].add(rollingSolid(joint, width, palette));
      return;
    }
    groups[joint.first].add(jointSolid(joint, width, material(actuated.has(j) ? palette.accent : palette["link-edge"])));
  });
  for (const lump of geometry.attachments) {
    const mesh = lumpSolid(lump, view, palette);
    if (!mesh) continue;
    groups[lump.body].add(mesh);
    const near = nearestPoint(view.outlines[lump.body], lump.position);
    if (near) groups[lump.body].add(rod(near, lump.position, 0.5 * width, link));
  }
  const discs = geometry.discs.map((disc) => {
    const made = discSolid(disc, view.length, width, palette);
    made.spin.position.copy(vector(disc.position));
    groups[disc.body].add(made.spin);
    return {disc, ...made};
  });
  const links = telescopes(view, width, palette);
  const move = (sample) => {
    moveBodies(view, groups, discs, sample);
    for (const link of links) link.move(sample);
  };
  return {objects: [...groups, ...links.map((l) => l.mesh)], move};
}

function nearestPoint(points, p) {
  const distance = (q) => vector(q).distanceTo(vector(p));
  return points.reduce((best, q) => (best === null || distance(q) < distance(best) ? q : best), null);
}

function moveBodies(view, groups, discs, sample) {
  groups.forEach((group, b) => {
    const o = view.poses.offset(sample, b);
    const v = view.poses.values;
    group.position.set(v[o], v[o + 1], v[o + 2]);
    group.quaternion.set(v[o + 4], v[o + 5], v[o + 6], v[o + 3]);
  });
  for (const {disc, spin, upright, axis} of discs)
    spin.quaternion.setFromAxisAngle(axis, view.discAngle(disc, sample)).multiply(upright);
}
