// The mechanism in the plane, on a canvas.
import {colour, sizeObserver} from "../dom.js";
import {drawBodies, drawGround, drawJoints, drawSliders} from "./planar_bodies.js";
import {drawCouplings, drawLoads} from "./planar_couplings.js";
import {drawDiscs, drawLumps, drawSprings} from "./planar_parts.js";
import {drawAxes, drawForce, drawLabels, drawTraces, scaleBar} from "./planar_overlay.js";
import {SvgPen} from "./svg_pen.js";
import {saveCanvas, saveText} from "../data/save.js";

const colours = ["ink", "faint", "rule", "paper", "panel", "accent", "link", "link-edge", "weight", "disc", "com", "tool",
  "force", "payload", "gear", "load"];

const margin = 44, minHeight = 300; // [px]

export class PlanarStage {
  formats = ["png", "svg"];

  constructor(element) {
    this.element = element;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    element.append(this.canvas);
    this.pen = this.canvas.getContext("2d");
    this.sample = 0;
    this.layers = {};
    sizeObserver(() => this.fit()).observe(element);
  }

  setView(view) {
    this.view = view;
    this.fit();
  }

  setLayers(layers) {
    this.layers = layers;
    this.draw();
  }

  setTheme() {
    this.fit();
  }

  /** The whole motion fits into the canvas, with room for the force. */
  fit() {
    this.limitHeight();
    const {clientWidth: width, clientHeight: height} = this.element;
    if (!this.view || width === 0 || height === 0) return;
    const ratio = Math.max(devicePixelRatio || 1, 2);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const {low, high} = this.view.bounds();
    const spanX = Math.max(high[0] - low[0], 1e-9);
    const spanY = Math.max(high[1] - low[1], 1e-9);
    this.scale = Math.min((width - 2 * margin) / spanX, (height - 2 * margin) / spanY);
    const middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    this.place = (p) => [width / 2 + this.scale * (p[0] - middle[0]), height / 2 - this.scale * (p[1] - middle[1])];
    this.size = [width, height];
    this.ratio = ratio;
    this.palette = Object.fromEntries(colours.map((name) => [name, colour(name)]));
    this.draw();
  }

  /** A wide motion leaves nothing empty above and below it. */
  limitHeight() {
    const {clientWidth: width} = this.element;
    if (!this.view || width === 0) return;
    const {low, high} = this.view.bounds();
    const needed = 2 * margin + ((width - 2 * margin) * (high[1] - low[1])) / Math.max(high[0] - low[0], 1e-9);
    this.element.style.maxHeight = `${Math.ceil(Math.max(needed, minHeight))}px`;
  }

  draw(sample = this.sample) {
    this.sample = sample;
    if (!this.view || !this.place) return;
    const {pen} = this;
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.clearRect(0, 0, ...this.size);
    pen.lineJoin = pen.lineCap = "round";
    // A link's width in pixels: thin enough for small pictures, calm in large ones.
    this.width = Math.min(Math.max(0.055 * this.view.length * this.scale, 5), 13);
    if (this.layers.axes) drawAxes(this);
    drawGround(this);
    drawCouplings(this);
    if (this.layers.traces) drawTraces(this);
    drawSprings(this);
    drawLumps(this, "behind");
    drawBodies(this);
    drawDiscs(this);
    drawSliders(this);
    drawJoints(this);
    drawLumps(this, "marks");
    if (this.layers.loads) drawLoads(this);
    if (this.layers.force) drawForce(this);
    if (this.layers.labels) drawLabels(this);
    scaleBar(this);
  }

  /** The picture as it is now: "png" or "svg". */
  save(kind, name) {
    if (kind === "png") {
      saveCanvas(this.canvas, this.palette.panel, `${name}.png`);
      return;
    }
    const canvas = this.pen;
    this.pen = new SvgPen(...this.size, this.palette.panel);
    this.draw();
    saveText(String(this.pen), "image/svg+xml", `${name}.svg`);
    this.pen = canvas;
    this.draw();
  }

  /** A point of a body on the screen. */
  at(body, p) {
    return this.place(this.view.poses.point(this.sample, body, p));
  }

  path(points, closed = false) {
    this.pen.beginPath();
    points.forEach(([x, y], i) => (i === 0 ? this.pen.moveTo(x, y) : this.pen.lineTo(x, y)));
    if (closed) this.pen.closePath();
  }

  circle([x, y], r) {
    this.pen.beginPath();
    this.pen.arc(x, y, Math.max(r, 0), 0, 2 * Math.PI);
  }

  arrow(from, to, length, colour) {
    const u = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    const head = Math.min(11, 0.6 * length);
    const neck = [to[0] - head * u[0], to[1] - head * u[1]];
    this.ink(colour, 3);
    this.path([from, neck]);
    this.pen.stroke();
    const side = 0.45 * head;
    this.path([to, [neck[0] - side * u[1], neck[1] + side * u[0]], [neck[0] + side * u[1], neck[1] - side * u[0]]], true);
    this.pen.fillStyle = colour;
    this.pen.fill();
  }

  ink(stroke, width = 1, dash = []) {
    this.pen.strokeStyle = stroke;
    this.pen.lineWidth = width;
    this.pen.setLineDash(dash);
  }
}
