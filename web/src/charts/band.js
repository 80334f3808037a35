// Bands about lines: where values are likely to be when the numbers in the spec's tolerances are off.
import {colour} from "../dom.js";

const widths = [3, 1]; // deviations: the wide one first, the narrow one upon it
export const bandName = "±3σ of tolerances";
export const bandTitle = "Standard deviations of the numbers in the spec's tolerances: light up to 3, darker up to 1";

/** Lower and upper end of a line's band; of a magnitude not below zero. */
export function ends(line, index, width = widths[0]) {
  const half = width * line.deviation[index];
  return [Math.max(line.values[index] - half, line.least ?? -Infinity), line.values[index] + half];
}

/** The largest half of the widest band. */
export function widest(line) {
  return widths[0] * line.deviation.reduce((most, d) => Math.max(most, d), 0);
}

/** [low, high] of what is seen, with the bands of these lines. */
export function withBands(lines, from, to, low, high) {
  for (const line of lines)
    for (let i = from; i <= to; ++i) {
      const [down, up] = ends(line, i);
      [low, high] = [Math.min(low, down), Math.max(high, up)];
    }
  return [low, high];
}

/** Under the lines of a uPlot, within its frame. */
export function drawBands(plot, time, lines) {
  const pen = plot.ctx;
  const [from, to] = plot.series[0].idxs;
  pen.save();
  pen.beginPath();
  pen.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
  pen.clip();
  for (const line of lines)
    for (const width of widths) {
      const x = (i) => plot.valToPos(time[i], "x", true);
      const y = (i, end) => plot.valToPos(ends(line, i, width)[end], "y", true);
      const [first, last] = [Math.max(from - 1, 0), Math.min(to + 1, time.length - 1)];
      pen.beginPath();
      for (let i = first; i <= last; ++i) pen.lineTo(x(i), y(i, 1));
      for (let i = last; i >= first; --i) pen.lineTo(x(i), y(i, 0));
      pen.closePath();
      pen.globalAlpha = 0.16;
      pen.fillStyle = colour(`line-${line.colour}`);
      pen.fill();
    }
  pen.restore();
}
