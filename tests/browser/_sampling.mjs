// Which part of many cases `scripts/test` tries; `scripts/soak whole` tries all of them. cli/_sampling.py is the same for scripts.
import {createHash} from "node:crypto";

export const whole = process.env.BALANCE_WHOLE === "1";
const seed = process.env.SEED ?? "1";

/** The whole, or a sample of at least this share of the cases, in their order. Every trait of any case is one of a drawn case. */
export function draw(what, cases, share, traitsOf = () => []) {
  if (whole) return cases;
  const place = (i) => createHash("sha256").update(`${seed} ${what} ${i}`).digest("hex");
  const order = [...cases.keys()].sort((a, b) => (place(a) < place(b) ? -1 : 1));
  const missing = new Set(cases.flatMap(traitsOf));
  const news = (i) => traitsOf(cases[i]).filter((trait) => missing.has(trait)).length;
  const drawn = new Set();
  while (missing.size > 0) {
    const most = order.reduce((best, i) => (news(i) > news(best) ? i : best));
    drawn.add(most);
    traitsOf(cases[most]).forEach((trait) => missing.delete(trait));
  }
  for (const i of order) if (drawn.size < share * cases.length) drawn.add(i);
  console.error(`${what}: ${drawn.size} of ${cases.length}, drawn with SEED=${seed}; BALANCE_WHOLE=1 tries all`);
  return cases.filter((_, i) => drawn.has(i));
}
