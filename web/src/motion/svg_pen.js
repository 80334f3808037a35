// Draws what is drawn on a canvas as SVG: the part of a 2D context that the planar stage uses.

const number = (x) => String(Math.round(100 * x) / 100);
const escaped = (text) => text.replace(/[&<>"]/g, (c) => ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
const anchors = {start: "start", center: "middle", end: "end"};

export class SvgPen {
  constructor(width, height, ground) {
    this.size = [width, height];
    this.parts = [`<rect width="${number(width)}" height="${number(height)}" fill="${ground}"/>`];
    this.state = {shift: [0, 0], turn: 0};
    this.saved = [];
    this.dash = [];
    Object.assign(this, {globalAlpha: 1, lineWidth: 1, lineJoin: "round", lineCap: "round", strokeStyle: "#000", fillStyle: "#000",
      font: "12px sans-serif", textAlign: "start", textBaseline: "alphabetic"});
    this.beginPath();
  }

  setTransform() {}
  clearRect() {}

  save() {
    this.saved.push({shift: [...this.state.shift], turn: this.state.turn});
  }

  restore() {
    this.state = this.saved.pop();
  }

  translate(x, y) {
    this.state.shift = this.placed(x, y);
  }

  rotate(angle) {
    this.state.turn += angle;
  }

  placed(x, y) {
    const {shift, turn} = this.state;
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    return [shift[0] + c * x - s * y, shift[1] + s * x + c * y];
  }

  text(x, y) {
    return this.placed(x, y).map(number).join(" ");
  }

  beginPath() {
    this.path = "";
  }

  moveTo(x, y) {
    this.path += `M${this.text(x, y)}`;
  }

  lineTo(x, y) {
    this.path += `${this.path ? "L" : "M"}${this.text(x, y)}`;
  }

  closePath() {
    this.path += "Z";
  }

  /** Whole circles in two halves: an arc that ends where it starts is none. */
  arc(x, y, r, from, to) {
    const at = (angle) => [x + r * Math.cos(angle), y + r * Math.sin(angle)];
    const middle = (from + to) / 2;
    const large = to - from > 2 * Math.PI - 1e-9 ? 0 : Number(to - from > Math.PI);
    this.lineOrMove(...at(from));
    const stops = large || to - from > 2 * Math.PI - 1e-9 ? [middle, to] : [to];
    for (const stop of stops) this.path += `A${number(r)} ${number(r)} 0 0 1 ${this.text(...at(stop))}`;
  }

  lineOrMove(x, y) {
    if (this.path) this.lineTo(x, y);
    else this.moveTo(x, y);
  }

  roundRect(x, y, width, height, radius) {
    const r = Math.min(radius, width / 2, height / 2);
    const corner = (cx, cy) => (this.path += `A${number(r)} ${number(r)} 0 0 1 ${this.text(cx, cy)}`);
    this.moveTo(x + r, y);
    this.lineTo(x + width - r, y);
    corner(x + width, y + r);
    this.lineTo(x + width, y + height - r);
    corner(x + width - r, y + height);
    this.lineTo(x + r, y + height);
    corner(x, y + height - r);
    this.lineTo(x, y + r);
    corner(x + r, y);
    this.closePath();
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  ink() {
    return `stroke="${this.strokeStyle}" stroke-width="${number(this.lineWidth)}" stroke-linejoin="round" stroke-linecap="round"`
      + (this.dash.length ? ` stroke-dasharray="${this.dash.map(number).join(" ")}"` : "") + this.alpha();
  }

  alpha() {
    return this.globalAlpha < 1 ? ` opacity="${number(this.globalAlpha)}"` : "";
  }

  stroke() {
    if (this.path) this.parts.push(`<path d="${this.path}" fill="none" ${this.ink()}/>`);
  }

  fill() {
    if (this.path) this.parts.push(`<path d="${this.path}" fill="${this.fillStyle}"${this.alpha()}/>`);
  }

  letters(text, x, y, paint) {
    const [px, py] = this.placed(x, y);
    const [, style, size] = /^(italic )?([0-9.]+)px/.exec(this.font) ?? [null, "", "12"];
    const down = this.textBaseline === "middle" ? 0.35 * Number(size) : 0;
    this.parts.push(`<text x="${number(px)}" y="${number(py + down)}" font-family="system-ui, sans-serif" font-size="${size}"`
      + `${style ? ' font-style="italic"' : ""} text-anchor="${anchors[this.textAlign] ?? "start"}" ${paint}>${escaped(text)}</text>`);
  }

  fillText(text, x, y) {
    this.letters(text, x, y, `fill="${this.fillStyle}"`);
  }

  strokeText(text, x, y) {
    this.letters(text, x, y, `fill="none" ${this.ink()}`);
  }

  toString() {
    const [width, height] = this.size.map(number);
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">\n`
      + `${this.parts.join("\n")}\n</svg>\n`;
  }
}
