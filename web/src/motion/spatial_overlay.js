// What is not the mechanism itself: floor, traces, force, centre of mass, names.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, ConeGeometry, CylinderGeometry, GridHelper, Group, Line, LineBasicMaterial,
  Mesh, MeshBasicMaterial, SRGBColorSpace, SphereGeometry, Sprite, SpriteMaterial, Vector3,
} from "three";

const up = new Vector3(0, 1, 0);

function floor(box, length, palette) {
  const size = box.getSize(new Vector3());
  const cell = 10 ** Math.floor(Math.log10(0.5 * length));
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
    for (const {sprite, joint} of named) {
      const p = view.poses.point(sample, joint.second, joint.point_second);
      sprite.position.set(p[0], p[1], p[2] + 0.06 * view.length);
    }
  };
  return {objects: [floor(box, view.length, palette), traces, force.group, centre, labels], move};
}
