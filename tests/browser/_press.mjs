// Tests of report.mjs, too: what is drawn and listed, saved and printed, and what a page forbids itself.
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {join} from "node:path";
import {clock, folder, pressed, shot, test} from "./_pages.mjs";
import {draw} from "./_sampling.mjs";

// ---- a press with a load over time, gears, a spring and friction: all that may be drawn and listed ----

const press = `
name: press with everything
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0], G: [0, -0.2], W: [-0.15, 0], S: [0.2, -0.3]}}
bodies:
  crank: {mass: 2, com: [0.02, 0], inertia: 0.0015, points: {O: [0, 0], P: [0.04, 0]}}
  ram: {mass: 6, com: [0, -0.06], inertia: 0.02, points: {S: [0, 0], T: [0, -0.2]}}
  wheel: {mass: 1, com: [0, 0], inertia: 0.001, points: {C: [0, 0], R: [0.03, 0]}}
joints:
  crank: {type: revolute, connects: [ground.O, crank.O]}
  pin: {type: pin-slot, connects: [ram.S, crank.P], axis: [1, 0]}
  guide: {type: prismatic, connects: [ground.G, ram.T], axis: [0, 1]}
  wheel: {type: revolute, connects: [ground.W, wheel.C]}
couplings:
  - {joint: wheel, follows: crank, ratio: -2}
actuators: [crank]
tool: ram.T
loads:
  press: {on: ram, at: T, table: [[0, 0, 0], [0.08, 0, 0], [0.1, 0, 800], [0.12, 0, 0]]}
springs:
  back: {between: [ground.S, ram.T], stiffness: 300, free_length: 0.05}
friction:
  guide: {viscous: 3, coulomb: 2}
motion: {duration: 0.2, samples: 201, from: {joints: {crank: 0}}, to: {joints: {crank: 2 * pi}}}
trajectories: {turn: {law: uniform, drive: joints}}
`;

/** Share of a picture's pixels that are about this colour. */
const share = (page, name) => page.evaluate((name) => {
  const canvas = document.querySelector("#stage canvas");
  const wanted = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(wanted.slice(i, i + 2), 16));
  const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let found = 0;
  for (let i = 0; i < data.length; i += 4)
    if (data[i + 3] > 200 && Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 12) ++found;
  return found;
}, name);

await test("loads, gears and sliders are drawn, and can be hidden (D5)", "press", async (page) => {
  const at = (seconds) => page.evaluate((t) => window.balanceReport.clock.seek(t), seconds);
  await at(0.02);
  const quiet = await share(page, "load");
  await at(0.1);
  const pushed = await share(page, "load");
  assert.ok(pushed > quiet + 300, `an arrow of 800 N: ${quiet} → ${pushed} pixels`);
  assert.ok((await share(page, "gear")) > 200, "two wheels");
  await shot(page, "press.png");
  await page.click('[data-layer="loads"]');
  assert.equal(await share(page, "load"), 0);
  const tables = await page.locator("#mechanism table caption").allTextContents();
  for (const wanted of ["Springs", "Gears and belts", "Loads", "Friction"]) assert.ok(tables.includes(wanted), tables.join());
  const text = await page.locator("#mechanism").textContent();
  for (const wanted of ["up to 800", "300", "\u22122", "4 times"]) assert.ok(text.includes(wanted), wanted);
}, {spec: press});

await test("pictures and values can be saved (D5)", "press", async (page) => {
  const saved = async (selector) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(selector).first().click()]);
    return {name: download.suggestedFilename(), bytes: readFileSync(await download.path())};
  };
  const png = await saved('[data-save="png"]');
  assert.equal(png.name, "press-with-everything-turn.png");
  assert.equal(png.bytes.subarray(1, 4).toString(), "PNG");
  const svg = (await saved('[data-save="svg"]')).bytes.toString();
  assert.match(svg, /^<svg xmlns="http:\/\/www.w3.org\/2000\/svg"[^>]*>[\s\S]*<\/svg>\n$/);
  assert.ok((svg.match(/<path /g) ?? []).length > 20);
  assert.ok(!/NaN|undefined/.test(svg));
  const csv = (await saved('[data-save="csv"]')).bytes.toString().trimEnd().split("\r\n");
  assert.equal(csv.length, 202);
  assert.match(csv[0], /^time \[s\],/);
  const column = csv[0].split(",").indexOf("torque[crank] [N m]");
  const there = await page.evaluate(() => window.balanceReport.board.charts[0].lines[0].values[77]);
  assert.ok(Math.abs(Number(csv[78].split(",")[column]) - there) <= 1e-6 * Math.abs(there));
  const chart = await saved(".chart-tools .tool:nth-child(2)");
  assert.match(chart.bytes.toString(), /^time \[s\],/);
  assert.equal((await saved(".chart-tools .tool:nth-child(1)")).bytes.subarray(1, 4).toString(), "PNG");
}, {spec: press});

await test("space plays after a click on a button, and presses the button that the keyboard is on (D5)", "press", async (page) => {
  await page.click('[data-layer="traces"]');
  const traces = await pressed(page, '[data-layer="traces"]');
  await page.keyboard.press(" ");
  assert.equal((await clock(page)).playing, true);
  assert.equal(await pressed(page, '[data-layer="traces"]'), traces);
  await page.click("#play");
  assert.equal((await clock(page)).playing, false);
  await page.keyboard.press(" ");
  assert.equal((await clock(page)).playing, true);
  await page.keyboard.press(" ");
  await page.locator('[data-layer="labels"]').focus();
  await page.keyboard.press(" ");
  assert.equal(await pressed(page, '[data-layer="labels"]'), "true");
  assert.equal((await clock(page)).playing, false);
}, {spec: press});

await test("a chart of very many lines stays small and says what it shows (D5)", "delta", async (page) => {
  await page.locator(".board summary").click();
  await page.click('.chips [data-chart="joint_position"]');
  const chart = page.locator('.chart[data-chart="joint_position"]');
  const {height} = await chart.boundingBox();
  assert.ok(height < 420, `${height} px high`);
  assert.match(await chart.locator(".crowd-count").textContent(), /^8 of \d\d lines$/);
  await chart.locator(".crowd .tool").first().click();
  assert.match(await chart.locator(".crowd-count").textContent(), /^(\d\d) of \1 lines$/);
  assert.match(await page.locator(".grid-note").textContent(), /floor in squares of \d+ mm/);
});

await test("a table that goes on beyond the edge says so, and can be scrolled by keyboard (D5)", "5r-design", async (page) => {
  const box = page.locator("#metrics .table-box").first();
  assert.equal(await box.evaluate((e) => e.classList.contains("cut")), true);
  assert.match(await box.evaluate((e) => getComputedStyle(e, "::before").content), /Scroll sideways/);
  assert.equal(await box.getAttribute("tabindex"), "0");
  await box.evaluate((e) => (e.scrollLeft = 1e4));
  await page.waitForFunction((e) => e.classList.contains("at-end"), await box.elementHandle());
}, {viewport: {width: 390, height: 844}});

await test("folded sections are open on paper (D5)", "press", async (page) => {
  assert.equal(await page.locator("#spec pre").isVisible(), false);
  await page.pdf({path: join(folder, "press.pdf"), format: "A4"});
  await page.emulateMedia({media: "print"});
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  assert.equal(await page.locator("#spec pre").isVisible(), true);
  assert.equal(await page.locator("#spec pre").evaluate((e) => e.scrollHeight <= e.clientHeight + 2), true);
  await page.evaluate(() => dispatchEvent(new Event("afterprint")));
  await page.emulateMedia({media: "screen"});
  assert.equal(await page.locator("#spec pre").isVisible(), false);
}, {spec: press});

await test("of a controlled run, controller and errors come first (D4)", "control-rrr", async (page) => {
  const tiles = await page.locator(".figures .figure").allTextContents();
  assert.match(tiles[0], /^Controllertorque/);
  assert.match(tiles[0], /computed-torque/);
  assert.match(tiles[1], /^Peak tool error/);
  assert.match(tiles[2], /^Peak tracking error/);
  const charts = await page.locator(".chart").evaluateAll((all) => all.map((c) => c.dataset.chart));
  assert.equal(charts[0], "tool_error");
  assert.equal(charts[1], "tracking_error");
  assert.match(await page.locator(".about").textContent(), /followed by controller torque \(computed-torque\)/);
  assert.equal(await page.locator("#metrics caption").first().textContent(), "Control");
  await shot(page, "control-rrr.png");
}, {words: ["-t", "cycloid", "--controller", "torque"]});

await test("what is round-off is nothing: no figure, no curve, no arrow (D2)", "planar-rrr", async (page) => {
  const tiles = (await page.locator(".figures .figure").allTextContents()).join(" ");
  assert.match(tiles, /Peak shaking force0\s?\u202f?N/);
  assert.doesNotMatch(tiles, /10\u207b/);
  await page.evaluate(() => window.balanceReport.clock.seek(0.23));
  assert.equal(await page.locator("#stage-reading").textContent(), "Shaking force 0\u202fN");
  assert.equal(await share(page, "force"), 0);
  const flat = await page.evaluate(() => window.balanceReport.board.charts.find((c) => c.chart.id === "shaking_force").lines
    .every((l) => l.values.every((v) => v === 0)));
  assert.equal(flat, true);
  const [low, high] = await page.evaluate(() => {
    const {min, max} = window.balanceReport.board.charts.find((c) => c.chart.id === "shaking_force").plot.scales.y;
    return [min, max];
  });
  assert.ok(low <= -0.5 && high >= 0.5, "nothing is not magnified");
  await shot(page, "planar-rrr.png");
});

for (const name of draw("pages with a policy", ["5r-design", "delta", "press"], 0.3))
  await test(`the page of ${name} keeps its own policy: nothing but its script and style (C12)`, name, async (page) => {
    const policy = await page.locator('meta[http-equiv="Content-Security-Policy"]').getAttribute("content");
    assert.match(policy, /^default-src 'none'; script-src 'sha256-[A-Za-z0-9+/]{43}='; style-src 'sha256-[A-Za-z0-9+/]{43}=';/);
    assert.doesNotMatch(policy, /unsafe/);
    // The console has complained of nothing so far (the caller looks); a foreign script and style are refused.
    const refused = await page.evaluate(async () => {
      const seen = [];
      document.addEventListener("securitypolicyviolation", (e) => seen.push(e.effectiveDirective));
      const script = document.createElement("script");
      script.textContent = "window.foreign = 1";
      document.body.append(script);
      document.body.setAttribute("onclick", "window.foreign = 2");
      document.body.click();
      await fetch("https://example.org/").catch(() => {});
      await new Promise((done) => setTimeout(done, 50));
      return {seen, foreign: window.foreign};
    });
    assert.equal(refused.foreign, undefined);
    assert.ok(refused.seen.includes("script-src-elem") && refused.seen.includes("script-src-attr") && refused.seen.includes("connect-src"),
      refused.seen.join());
  }, {spec: name === "press" ? press : undefined, violates: true});
