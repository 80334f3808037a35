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

// The page's data are SI; what is shown is in the units of the spec, converted here and nowhere else.
let preferred = {};

/** @param units what takes the place of a factor of an SI unit: {m: {name: "mm", value: 0.001}, …} */
export function preferUnits(units) {
  preferred = units ?? {};
}

/** The name of a unit as shown and its value in SI: each factor of "N m", "rad/s", "kg m^2" is replaced. */
function shownUnit(unit) {
  let value = 1;
  let sign = 1;
  const name = (unit ?? "").split(/([ /])/).map((word) => {
    if (word === "/") sign = -1;
    const [factor, power] = word.split("^");
    const other = preferred[factor];
    if (!other) return word;
    value *= other.value ** (sign * Number(power ?? 1));
    return power === undefined ? other.name : `${other.name}^${power}`;
  }).join("");
  return {name, value};
}

/** An SI value in the unit that is shown. */
export const inShownUnit = (value, unit) => (Number.isFinite(value) ? value / shownUnit(unit).value : value);

/** The unit that is shown for an SI unit, with thin spaces and powers: "N m" → "N m" or "N mm"; "1" → nothing. */
export function unitText(unit) {
  if (!unit || unit === "1" || unit === "mixed") return "";
  return shownUnit(unit).name.replaceAll("^2", "²").replaceAll(" ", "\u202f");
}

/** " [mm]" for a heading; nothing without a unit. */
export const inBrackets = (unit) => (unitText(unit) ? ` [${unitText(unit)}]` : "");

/** An SI value as a number in the unit that is shown, for a place that names the unit elsewhere. */
export const formatIn = (value, unit, digits = 4) => format(inShownUnit(value, unit), digits);

/** A value that is already in the unit that is shown. */
export function withShownUnit(value, unit, digits = 4) {
  const name = unitText(unit);
  return name ? `${format(value, digits)}\u202f${name}` : format(value, digits);
}

/** An SI value with the unit that is shown. */
export const withUnit = (value, unit, digits = 4) => withShownUnit(inShownUnit(value, unit), unit, digits);

/** A length in the unit that is shown; small ones of SI in millimetres. */
export const lengthText = (length) => (unitText("m") === "m" && length < 1 ? `${format(1000 * length)} mm` : withUnit(length, "m"));

/** The largest 1, 2 or 5 times a power of ten of the unit that is shown that is not above a length [m]. */
export function roundLength(maxLength) {
  const unit = shownUnit("m").value;
  const power = 10 ** Math.floor(Math.log10(maxLength / unit));
  return unit * [5, 2, 1].map((f) => f * power).find((l) => l <= maxLength / unit);
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
