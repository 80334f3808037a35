// The page's data: one JSON block whose samples are base64 of little-endian floats (docs/report.md).

function bytes(text) {
  const binary = atob(text);
  const result = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) result[i] = binary.charCodeAt(i);
  return result.buffer;
}

/** A column of numbers: {f64: …} or {f32: …}. */
export function numbers(packed) {
  return packed.f64 !== undefined ? new Float64Array(bytes(packed.f64)) : new Float32Array(bytes(packed.f32));
}

function decodeSeries(series, rows) {
  const all = numbers(series.values);
  const columns = series.columns.map((name, i) => ({
    name,
    unit: series.units[series.units.length === 1 ? 0 : i],
    values: all.subarray(i * rows, (i + 1) * rows),
  }));
  return {...series, columns};
}

function decodeSamples(run) {
  const time = numbers(run.time);
  const series = new Map(run.series.map((s) => [s.quantity, decodeSeries(s, time.length)]));
  const deviation = new Map((run.deviation ?? []).map((s) => [s.quantity, decodeSeries(s, time.length)]));
  return {time, poses: numbers(run.poses), series, deviation};
}

/** Samples are decoded when they are first looked at: of many trajectories one is shown. */
function decodeRun(run) {
  if (!run || run.outcome.status !== "done") return run;
  let decoded = null;
  const lazily = (name) => [name, {enumerable: true, get: () => (decoded ??= decodeSamples(run))[name]}];
  return Object.defineProperties({...run}, Object.fromEntries(["time", "poses", "series", "deviation"].map(lazily)));
}

/** The JSON block; samples are arrays of numbers. */
export function readData(document) {
  const data = JSON.parse(document.getElementById("balance-data").textContent);
  data.trajectories = data.trajectories.map((t) => ({...t, before: decodeRun(t.before), after: decodeRun(t.after)}));
  return data;
}

export const isDone = (run) => Boolean(run) && run.outcome.status === "done";
