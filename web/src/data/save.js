// What a reader takes along: pictures and tables as files.

import {effortName} from "./numbers.js";

function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A name that every system takes: "3RRR planar, cycloid" → "3rrr-planar-cycloid". */
export function fileName(...parts) {
  const text = parts.filter(Boolean).join("-").normalize("NFKD").toLowerCase().replace(/[^a-z0-9]+/g, "-");
  return text.replace(/^-+|-+$/g, "") || "balance";
}

export const saveText = (text, type, name) => save(new Blob([text], {type: `${type};charset=utf-8`}), name);

/** A canvas on a ground of its own: pictures are put on any page. */
export function saveCanvas(canvas, ground, name) {
  const copy = document.createElement("canvas");
  copy.width = canvas.width;
  copy.height = canvas.height;
  const pen = copy.getContext("2d");
  pen.fillStyle = ground;
  pen.fillRect(0, 0, copy.width, copy.height);
  pen.drawImage(canvas, 0, 0);
  copy.toBlob((blob) => save(blob, name), "image/png");
}

/** A field of CSV: in quotes if it needs them, and never a formula. */
function field(text) {
  const safe = /^[=+\-@\t]/.test(text) ? `'${text}` : text;
  return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

/** Samples are stored with seven digits. */
const digits = (value) => String(Number(value.toPrecision(7)));

/**
 * Lines over time as CSV.
 * @param columns [{name, unit, values}]
 */
export function csv(time, columns) {
  const lines = [["time [s]", ...columns.map((c) => `${c.name} [${c.unit}]`)].map(field).join(",")];
  for (let k = 0; k < time.length; ++k)
    lines.push([String(time[k]), ...columns.map((c) => (k < c.values.length ? digits(c.values[k]) : ""))].join(","));
  return `${lines.join("\r\n")}\r\n`;
}

/** Every value of a run. */
export function runColumns(run) {
  return [...run.series.values()].flatMap((series) => series.columns.map((c) => ({
    name: c.name === "value" ? series.quantity : `${effortName(series.quantity, c.unit)}[${c.name}]`,
    unit: c.unit, values: c.values,
  })));
}
