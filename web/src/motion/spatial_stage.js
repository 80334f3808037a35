// The mechanism in space, by WebGL.
import {
  AmbientLight, Box3, DirectionalLight, Group, HemisphereLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "three";
import {OrbitControls} from "three/addons/controls/OrbitControls.js";
import {choice, colour, h, sizeObserver} from "../dom.js";
import {makeBodies} from "./spatial_bodies.js";
import {floorCell, makeOverlay} from "./spatial_overlay.js";
import {lengthText} from "../data/numbers.js";
import {saveCanvas} from "../data/save.js";

const colours = ["ink", "faint", "rule", "paper", "panel", "accent", "link", "link-edge", "weight", "disc", "com", "tool",
  "force", "payload", "gear", "load"];
const directions = {oblique: [1.1, -1.5, 0.85], front: [0, -1, 0.02], side: [1, 0, 0.02], top: [0, -0.001, 1]};

export class SpatialStage {
  formats = ["png"];

  constructor(element) {
    this.element = element;
    this.renderer = new WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    element.append(this.renderer.domElement);
    this.camera = new PerspectiveCamera(32, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableZoom = true;
    this.controls.addEventListener("change", () => this.render());
    this.sample = 0;
    this.layers = {};
    sizeObserver(() => this.fit()).observe(element);
    element.append(choice("View from", Object.keys(directions).map((d) => ({value: d, text: d})), "oblique",
      (d) => this.look(d)));
    element.lastChild.classList.add("views", "screen-only");
    this.scaleNote = h("p", {class: "grid-note"});
    element.append(this.scaleNote);
  }

  setView(view) {
    const first = !this.view;
    this.view = view;
    this.build();
    this.fit();
    if (first) this.look("oblique");
  }

  setLayers(layers) {
    this.layers = layers;
    this.draw();
  }

  setTheme() {
    if (this.view) this.build();
    this.draw();
  }

  build() {
    this.palette = Object.fromEntries(colours.map((name) => [name, colour(name)]));
    this.scene = new Scene();
    this.scene.add(new AmbientLight(0xffffff, 0.9), new HemisphereLight(0xffffff, 0x888899, 1.1));
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(2, -3, 5);
    this.scene.add(sun);
    const {low, high} = this.view.bounds();
    this.box = new Box3(new Vector3(...low), new Vector3(...high));
    const cell = floorCell(this.view.length);
    this.scaleNote.textContent = `floor in squares of ${lengthText(cell)}`;
    this.bodies = makeBodies(this.view, this.palette);
    this.overlay = makeOverlay(this.view, this.palette, this.box);
    this.scene.add(new Group().add(...this.bodies.objects), ...this.overlay.objects);
  }

  /** The picture as it is now. */
  save(_, name) {
    this.render();
    saveCanvas(this.renderer.domElement, this.palette.panel, `${name}.png`);
  }

  /** From a named direction, everything in sight. */
  look(name) {
    const middle = this.box.getCenter(new Vector3());
    const radius = 0.5 * this.box.getSize(new Vector3()).length();
    const narrow = Math.min(this.camera.aspect, 1);
    const distance = (1.02 * radius) / Math.sin((this.camera.fov * Math.PI) / 360) / narrow;
    this.controls.target.copy(middle);
    this.camera.position.copy(new Vector3(...directions[name]).setLength(distance).add(middle));
    this.camera.near = 0.02 * distance;
    this.camera.far = 20 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.render();
  }

  fit() {
    const {clientWidth: width, clientHeight: height} = this.element;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.max(devicePixelRatio || 1, 1.5));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw(sample = this.sample) {
    this.sample = sample;
    if (!this.view || !this.scene) return;
    this.bodies.move(sample);
    this.overlay.move(sample, this.layers);
    this.render();
  }

  render() {
    if (this.scene) this.renderer.render(this.scene, this.camera);
  }
}
