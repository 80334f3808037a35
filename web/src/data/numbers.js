// Numbers as a reader wants them.

const minus = "\u2212";

/** Four significant digits; very large and very small ones with a power of ten. */
export function format(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  let text;
  if (size >= 1e6 || size < 1e-4) {
    const [mantissa, power] = value.toExponential(digits - 1).split("e");
    text = `${mantissa.replace(/\.?0+$/, "")} × 10${superscript(Number(power))}`;
  } else {
    text = Number(value.toPrecision(digits)).toString();
  }
  return text.replace("-", minus);
}

function superscript(power) {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return (power < 0 ? "⁻" : "") + [...String(Math.abs(power))].map((d) => digits[Number(d)]).join("");
}

/** "N m" → "N m" with a thin space, "m/s^2" → "m/s²", "1" → nothing. */
export function unitText(unit) {
  if (!unit || unit === "1" || unit === "mixed") return "";
  return unit.replaceAll("^2", "²").replaceAll(" ", "\u202f");
}

export function withUnit(value, unit, digits = 4) {
  const name = unitText(unit);
  return name ? `${format(value, digits)}\u202f${name}` : format(value, digits);
}

/** after / before as a reader's ratio; a quantity that vanished is 0. */
export function ratio(before, after) {
  if (!Number.isFinite(before) || !Number.isFinite(after) || before === 0) return null;
  return after / before;
}

export function ratioText(value) {
  if (value === null) return "–";
  if (value === 0) return "0";
  if (value < 5e-4) return "< 0.001";
  return value < 10 ? value.toFixed(3) : format(value, 3);
}

/** What an actuator's effort is called: that of a slide is a force. */
export const effortName = (quantity, unit) => (unit === "N" ? quantity.replace(/^torque/, "force") : quantity);
