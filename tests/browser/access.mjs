// The report's pages for readers without a mouse, without sight, with a small screen or many trajectories, and with laws that were found.
// Arguments: program, folder of mechanisms, folder for pictures.
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {createRequire} from "node:module";
import {join} from "node:path";
import {browser, clock, configs, failures, shot, test} from "./_pages.mjs";
import {draw} from "./_sampling.mjs";

const require = createRequire(join(process.env.PAGE_PACKAGES, "package.json"));
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

/** Opens everything, and waits until the page has looked at the new sizes: it does a frame after they are known, which is one after this. */
const unfold = (page) => page.evaluate(async () => {
  document.querySelectorAll("details").forEach((d) => (d.open = true));
  for (let frame = 0; frame < 3; ++frame) await new Promise(requestAnimationFrame);
});

/** What axe finds: rule, element and reason. */
async function violations(page) {
  await unfold(page);
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run());
  return found.violations.flatMap((v) => v.nodes.map((n) => `${v.impact} ${v.id}: ${n.target} ${n.failureSummary}`));
}

const threeRrr = readFileSync(join(configs, "3rrr.yaml"), "utf8");
const withTrajectories = (text) => `${threeRrr.slice(0, threeRrr.indexOf("trajectories:"))}trajectories:\n${text}`;

const looks = [["5r-design", "light", 1400], ["5r-design", "dark", 390], ["delta", "light", 390], ["delta", "dark", 1400],
  ["four-bar", "light", 390]];
for (const [name, colorScheme, width] of draw("pages for axe", looks, 0, (look) => look))
  await test(`axe finds nothing on the page of ${name}, ${colorScheme}, ${width} px wide, and nothing is beyond the edge`, name, async (page) => {
    assert.deepEqual(await violations(page), []);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${wide} px too wide`);
    await shot(page, `${name}-${colorScheme}-${width}.png`);
  }, {colorScheme, viewport: {width, height: 844}});

for (const colorScheme of draw("schemes of bands", ["light", "dark"], 0.5))
  await test(`bands of tolerances are told of, hidden and shown, and axe finds nothing, ${colorScheme}`, "rr-tolerance", async (page) => {
    assert.deepEqual(await violations(page), []);
    await shot(page, `rr-tolerance-${colorScheme}.png`);
    const torque = page.locator('.chart[data-chart="torque"]');
    assert.match(await torque.locator(".plot").getAttribute("aria-label"), /, within [\d.]+\u202fN\u202fm \(3σ of tolerances\)/);
    const key = torque.getByRole("button", {name: "±3σ of tolerances"});
    assert.equal(await key.getAttribute("aria-pressed"), "true");
    const pixels = () => torque.locator("canvas").evaluate((canvas) => canvas.toDataURL());
    const before = await pixels();
    await key.press("Enter");
    assert.equal(await key.getAttribute("aria-pressed"), "false");
    assert.notEqual(await pixels(), before);
    await key.press("Enter");
    assert.equal(await pixels(), before);
    assert.equal(await page.locator('.chart[data-chart="shaking_moment"] [data-band]').count(), 1);
  }, {colorScheme, viewport: {width: 1000, height: 844}});

await test("a page without tolerances has no bands", "3rrr", async (page) => {
  assert.equal(await page.locator("[data-band]").count(), 0);
});

await test("the keyboard reaches every control, in the order of the page, and shows where it is", "5r-design", async (page) => {
  await unfold(page);
  const wanted = await page.evaluate(() => {
    const all = [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex='0']")]
      .filter((e) => !e.disabled && e.checkVisibility());
    all.forEach((e, i) => (e.dataset.order = i));
    return all.length;
  });
  const reached = [];
  for (let i = 0; i < wanted; ++i) {
    await page.keyboard.press("Tab");
    const {order, seen} = await page.evaluate(() => {
      const {outlineStyle, outlineWidth} = getComputedStyle(document.activeElement);
      const {width, height} = document.activeElement.getBoundingClientRect();
      return {order: Number(document.activeElement.dataset.order),
        seen: outlineStyle !== "none" && parseFloat(outlineWidth) >= 2 && width > 1 && height > 1};
    });
    assert.ok(seen, `control ${order} shows its focus`);
    reached.push(order);
  }
  assert.deepEqual(reached, [...Array(wanted).keys()]);
});

await test("a screen reader is told of headings, charts and the trajectory, and not of every instant", "5r-design", async (page) => {
  const levels = await page.evaluate(() => [...document.querySelectorAll("h1, h2, h3, h4")].map((e) => Number(e.tagName[1])));
  assert.equal(levels[0], 1);
  levels.slice(1).forEach((level, i) => assert.ok(level > 1 && level <= levels[i] + 1));
  assert.match(await page.locator('.chart[data-chart="torque"] .plot').getAttribute("aria-label"), /^Actuator torque over 0\.5 s: A1 before up to [\d.]+/);
  assert.equal(await page.locator(".reading").getAttribute("aria-live"), "off");
  assert.equal(await page.locator('#motion [role="status"]').count(), 1);
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => location.hash), "#motion");
});

await test("twenty trajectories open quickly, and any of them is a choice away", "twenty", async (page, {seconds}) => {
  console.log(`        open after ${seconds.toFixed(2)} s`);
  assert.ok(seconds < 10, "a machine under load may be slow, but not that slow");
  const list = page.locator('select[aria-label="Trajectory"]');
  assert.equal(await list.locator("option").count(), 20);
  await list.selectOption("t17"); // cycloid and bang-bang come with every motion
  assert.match(await page.locator("#metrics h2").textContent(), /t17/);
  await page.locator("#stage").focus();
  await page.keyboard.press("End");
  assert.ok(Math.abs((await clock(page)).now - 0.27) < 1e-9);
}, {spec: withTrajectories(Array.from({length: 18}, (_, i) => `  t${i}: {law: ${["cycloidal", "3-4-5"][i % 2]}, drive: tool, duration: ${(10 + i) / 100}}\n`).join(""))});

await test("a law that was found says its switches and its limits", "found", async (page) => {
  const text = () => page.locator("#metrics div.law").innerText();
  assert.match(await text(), /Law found: fastest within the limits: 0\.1006\d*\ss, 1 switch\n/);
  assert.match(await text(), /Shaking force\s+0\s+0\.0503\d+\s+0\s+49\.696\d*\n/);
  const switches = await page.evaluate(() => window.balanceReport.data.trajectories[0].before.found_law.switches);
  // Where the law switches the centre of mass turns from speeding up to braking.
  const speed = await page.evaluate((t) => {
    const {time, series} = window.balanceReport.data.trajectories[0].before;
    const [x, y] = series.get("com_velocity").columns.map((c) => c.values);
    const sizes = [...time].map((_, i) => Math.hypot(x[i], y[i]));
    const fastest = sizes.indexOf(Math.max(...sizes));
    return Math.abs(time[fastest] - t) / (time[1] - time[0]);
  }, switches[0]);
  assert.ok(speed <= 1.5, `${speed} samples`);
  await page.click('.segment[data-value="gentle"]');
  assert.match(await text(), /gentlest: peak of shaking force 556\.14\d\sN in 0\.1\ss, 1 switch\n/);
  await page.click('.segment[data-value="plain"]');
  assert.equal(await page.locator("#metrics .law").count(), 0);
}, {spec: withTrajectories(`  fast: {law: fastest, drive: tool, limits: {shaking_force: 549.2528818391}}
  gentle: {law: gentlest, drive: tool, of: shaking_force, duration: 0.1}
  plain: {law: cycloidal, drive: tool}\n`)});

await browser.close();
console.log(failures() ? `${failures()} failed` : "all passed");
process.exit(failures() ? 1 : 0);
