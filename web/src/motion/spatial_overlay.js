// What is not the mechanism itself: floor, traces, force, centre of mass, names.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, ConeGeometry, CylinderGeometry, GridHelper, Group, Line, LineBasicMaterial,
  Mesh, MeshBasicMaterial, SRGBColorSpace, SphereGeometry, Sprite, SpriteMaterial, Vector3,
} from "three";
import {loadAt} from "../data/loads.js";
import {wheels} from "../data/shape.js";

const up = new Vector3(0, 1, 0);

/** Side of a square of the floor [m]: the scale of the picture. */
export const floorCell = (length) => 10 ** Math.floor(Math.log10(0.5 * length));

function floor(box, length, palette) {
  const size = box.getSize(new Vector3());
  const cell = floorCell(length);
  const cells = 2 * Math.ceil((0.55 * Math.max(size.x, size.y)) / cell);
  const grid = new GridHelper(cells * cell, cells, palette.faint, palette.rule);
  grid.rotation.x = Math.PI / 2;
  const middle = box.getCenter(new Vector3());
  grid.position.set(middle.x, middle.y, box.min.z - 0.06 * length);
  grid.material.transparent = true;
  grid.material.opacity = 0.7;
  return grid;
}

function trace(columns, samples, colour) {
  if (!columns) return null;
  const places = new Float32Array(3 * samples);
  for (let k = 0; k < samples; ++k) columns.forEach((c, i) => (places[3 * k + i] = c.values[k]));
  const line = (opacity) => {
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3));
    return new Line(geometry, new LineBasicMaterial({color: colour, transparent: true, opacity, depthTest: false}));
  };
  return {whole: line(0.35), done: line(1)};
}

// Inside a solid body it must be seen too.
const onTop = (color) => ({color, depthTest: false, transparent: true});

function arrow(thickness, colour) {
  const paint = new MeshBasicMaterial(onTop(colour));
  const shaft = new Mesh(new CylinderGeometry(thickness, thickness, 1, 16).translate(0, 0.5, 0), paint);
  const head = new Mesh(new ConeGeometry(2.6 * thickness, 7 * thickness, 20).translate(0, 3.5 * thickness, 0), paint);
  const group = new Group().add(shaft, head);
  const point = (from, along) => {
    const length = along.length();
    group.visible = length > 1e-9;
    const bare = Math.max(length - 7 * thickness, 1e-6);
    shaft.scale.set(1, bare, 1);
    head.position.set(0, bare, 0);
    group.position.copy(from);
    if (length > 0) group.quaternion.setFromUnitVectors(up, along.clone().normalize());
  };
  return {group, point};
}

/** A name that faces the reader. */
function label(text, palette, size) {
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d");
  const font = "500 44px system-ui, sans-serif";
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 16;
  canvas.height = 60;
  pen.font = font;
  pen.textBaseline = "middle";
  pen.lineWidth = 9;
  pen.strokeStyle = palette.paper;
  pen.strokeText(text, 8, 30);
  pen.fillStyle = palette.ink;
  pen.fillText(text, 8, 30);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({map, depthTest: false}));
  sprite.scale.set((size * canvas.width) / canvas.height, size, 1);
  return sprite;
}

/** The world's axes at its origin. */
function axes(length, palette) {
  const group = new Group();
  const size = 0.28 * length;
  for (const [name, direction] of [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]]) {
    const {group: made, point} = arrow(0.006 * length, palette.faint);
    const along = new Vector3(...direction).multiplyScalar(size);
    point(new Vector3(), along);
    const text = label(name, palette, 0.07 * length);
    text.position.copy(along).multiplyScalar(1.15);
    group.add(made, text);
  }
  return group;
}

/** Forces end where they act; a moment is an arrow with two heads along its axis. */
function loadArrows(view, palette, box) {
  const group = new Group();
  const longest = 0.22 * box.getSize(new Vector3()).length();
  const made = view.geometry.loads.map((load) => {
    const force = arrow(0.009 * view.length, palette.load);
    const moment = [arrow(0.009 * view.length, palette.load), arrow(0.009 * view.length, palette.load)];
    const text = label(load.name, palette, 0.065 * view.length);
    group.add(force.group, ...moment.map((m) => m.group), text);
    return {load, force, moment, text};
  });
  const move = (sample) => {
    for (const {load, force, moment, text} of made) {
      const now = loadAt(view, load, sample);
      const at = new Vector3(...now.at);
      const along = new Vector3(...now.force).multiplyScalar(longest / Math.max(view.loadScale, 1e-300));
      force.point(at.clone().sub(along), along);
      const turn = new Vector3(...now.moment).multiplyScalar((0.8 * longest) / Math.max(view.momentScale, 1e-300));
      moment[0].point(at, turn);
      moment[1].point(at, turn.clone().multiplyScalar(0.8));
      text.position.copy(at).sub(along).add(new Vector3(0, 0, 0.05 * view.length));
    }
  };
  return {group, move};
}

/** Wheels of coupled joints that turn, and a line between the two joints. */
function couplings(view, palette) {
  const group = new Group();
  const paint = new MeshBasicMaterial({color: palette.gear, transparent: true, opacity: 0.35});
  const ink = new LineBasicMaterial({color: palette.gear});
  const moves = [];
  for (const {coupling, leader, follower, turning} of view.couplings) {
    const made = wheels(coupling.ratio, 0, view.length);
    for (const [joint, r] of turning ? [[leader, made.leader], [follower, made.follower]] : []) {
      const wheel = new Mesh(new CylinderGeometry(r, r, 0.012 * view.length, 40), paint);
      group.add(wheel);
      moves.push((sample) => {
        wheel.position.set(...view.poses.point(sample, joint.second, joint.point_second));
        wheel.quaternion.setFromUnitVectors(up, new Vector3(...view.poses.direction(sample, joint.first, joint.axis)).normalize());
      });
    }
    const places = new BufferAttribute(new Float32Array(6), 3);
    const line = new Line(new BufferGeometry().setAttribute("position", places), ink);
    line.frustumCulled = false;
    group.add(line);
    moves.push((sample) => {
      places.setXYZ(0, ...view.poses.point(sample, leader.second, leader.point_second));
      places.setXYZ(1, ...view.poses.point(sample, follower.second, follower.point_second));
      places.needsUpdate = true;
    });
  }
  return {group, move: (sample) => moves.forEach((m) => m(sample))};
}

export function makeOverlay(view, palette, box) {
  const size = 0.02 * view.length;
  const tool = trace(view.column("tool_position"), view.samples, palette.tool);
  const com = trace(view.column("com_position"), view.samples, palette.com);
  const traces = new Group().add(...[tool, com].filter(Boolean).flatMap((t) => [t.whole, t.done]));
  const force = arrow(0.55 * size, palette.force);
  const centre = new Mesh(new SphereGeometry(1.5 * size, 24, 16), new MeshBasicMaterial(onTop(palette.com)));
  const labels = new Group();
  const named = view.geometry.joints.map((joint) => {
    const sprite = label(joint.name, palette, 0.075 * view.length);
    labels.add(sprite);
    return {sprite, joint};
  });
  const world = axes(view.length, palette);
  const loads = loadArrows(view, palette, box);
  const gears = couplings(view, palette);
  const longest = 0.3 * box.getSize(new Vector3()).length();

  force.group.renderOrder = 2;
  centre.renderOrder = 1;

  const move = (sample, layers) => {
    for (const t of [tool, com]) t?.done.geometry.setDrawRange(0, sample + 1);
    traces.visible = Boolean(layers.traces);
    const at = new Vector3(...view.com(sample));
    centre.position.copy(at);
    const unit = longest / Math.max(view.forceScale, 1e-300);
    force.point(at, new Vector3(...view.force(sample)).multiplyScalar(unit));
    force.group.visible &&= Boolean(layers.force);
    centre.visible = Boolean(layers.force);
    labels.visible = Boolean(layers.labels);
    world.visible = Boolean(layers.axes);
    loads.move(sample);
    loads.group.visible = Boolean(layers.loads);
    gears.move(sample);
    for (const {sprite, joint} of named) {
      const p = view.poses.point(sample, joint.second, joint.point_second);
      sprite.position.set(p[0], p[1], p[2] + 0.06 * view.length);
    }
  };
  return {objects: [floor(box, view.length, palette), world, loads.group, gears.group, traces, force.group, centre, labels], move};
}
