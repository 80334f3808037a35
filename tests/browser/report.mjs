// The report's pages in Chromium with real clicks and keys. Arguments: program, folder of mechanisms, folder for pictures.
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {statSync} from "node:fs";
import {join} from "node:path";
import {browser, clock, configs, failures, folder, pressed, program, shot, stagePixels, test} from "./_pages.mjs";
import {draw} from "./_sampling.mjs";

await test("the page of the 3RRR is small and opens quickly", "3rrr", async (page, {seconds}) => {
  const size = statSync(join(folder, "3rrr.html")).size;
  console.log(`        ${(size / 1e6).toFixed(2)} MB, open after ${seconds.toFixed(2)} s`);
  assert.ok(size < 2e6);
  assert.ok(seconds < 10, "a machine under load may be slow, but not that slow");
  assert.equal(await page.title(), "3RRR planar parallel manipulator");
  await shot(page, "3rrr-light.png");
});

/** One row of a dataset of the result file of the same run. */
function stored(name, dataset, row, columns) {
  const file = join(folder, `${name}.h5`);
  execFileSync(program, ["simulate", join(configs, `${name}.yaml`), "-t", "cycloid", "-o", file, "--force", "-q"]);
  const text = execFileSync("h5dump", ["-d", dataset, "-s", `${row},0`, "-c", `1,${columns}`, "-m", "%.17g", "-y", "-w", "0", file]);
  return /DATA \{([^}]*)\}/.exec(text.toString())[1].trim().split(",").map(Number);
}

for (const name of draw("ends of animations", ["3rrr", "delta"], 0.5))
  await test(`the animation of ${name} ends where the result file does`, name, async (page) => {
    await page.locator("#stage").focus();
    await page.keyboard.press("End");
    const {sample, tool, joints} = await page.evaluate(() => {
      const {sample} = window.balanceReport.clock;
      const {view} = window.balanceReport.player;
      const {geometry, poses} = view;
      const joints = geometry.joints.map((j) =>
        [poses.point(sample, j.first, j.point_first), poses.point(sample, j.second, j.point_second)]);
      return {sample, joints, tool: poses.point(sample, geometry.tool.body, geometry.tool.position)};
    });
    const there = stored(name, "tool_position", sample, tool.length);
    tool.forEach((x, i) => assert.ok(Math.abs(x - there[i]) < 1e-6, `${tool} ${there}`));
    // All joints of these two mechanisms turn in a point: their bodies meet there.
    for (const [a, b] of joints) a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < 1e-6));
  });

await test("play moves the mechanism and the playheads, pause stops both", "3rrr", async (page) => {
  const still = await stagePixels(page);
  const head = () => page.locator(".playhead").first().evaluate((e) => e.getBoundingClientRect().x);
  const left = await head();
  await page.click("#play");
  await page.waitForFunction(() => window.balanceReport.clock.sample > 100);
  await page.click("#play");
  const stopped = await clock(page);
  assert.equal(stopped.playing, false);
  assert.ok((await head()) > left + 5);
  assert.ok(!still.equals(await stagePixels(page)), "the picture changed");
  await page.waitForTimeout(150);
  assert.equal((await clock(page)).sample, stopped.sample);
});

await test("scrubbing, clicking a chart and keys all set the one time", "3rrr", async (page) => {
  await page.locator("#scrub").scrollIntoViewIfNeeded();
  const box = await page.locator("#scrub").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  assert.ok(Math.abs((await clock(page)).sample - 500) < 15);
  const over = await page.locator(".chart .u-over").nth(1).boundingBox();
  await page.mouse.click(over.x + 0.25 * over.width, over.y + 40);
  assert.ok(Math.abs((await clock(page)).now - 0.025) < 0.002);
  assert.ok(Math.abs(Number(await page.inputValue("#scrub")) - 250) < 20);
  await page.locator("#stage").focus();
  await page.keyboard.press("Home");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+ArrowRight");
  assert.equal((await clock(page)).sample, 11);
  await page.keyboard.press("End");
  assert.equal((await clock(page)).sample, 1000);
  await page.keyboard.press("Home");
  await page.keyboard.press(" ");
  assert.equal((await clock(page)).playing, true);
  await page.keyboard.press(" ");
  assert.equal((await clock(page)).playing, false);
});

await test("a legend's button hides its line, by mouse and by keyboard", "3rrr", async (page) => {
  const key = page.locator('[data-chart="torque"] [data-line="A2"]');
  const shown = () => page.evaluate(() => window.balanceReport.board.charts[0].plot.series[2].show);
  await key.click();
  assert.equal(await key.getAttribute("aria-pressed"), "false");
  assert.equal(await shown(), false);
  await key.focus();
  await page.keyboard.press("Enter");
  assert.equal(await key.getAttribute("aria-pressed"), "true");
  assert.equal(await shown(), true);
});

await test("dragging zooms all charts, and the button shows everything again", "3rrr", async (page) => {
  const ranges = () => page.evaluate(() => window.balanceReport.board.charts.map((c) => [c.plot.scales.x.min, c.plot.scales.x.max]));
  const over = await page.locator(".chart .u-over").first().boundingBox();
  await page.mouse.move(over.x + 0.2 * over.width, over.y + 50);
  await page.mouse.down();
  await page.mouse.move(over.x + 0.6 * over.width, over.y + 60, {steps: 5});
  await page.mouse.up();
  for (const [min, max] of await ranges()) {
    assert.ok(Math.abs(min - 0.02) < 0.002 && Math.abs(max - 0.06) < 0.002, `${min} … ${max}`);
  }
  await page.click("#reset-zoom");
  for (const [min, max] of await ranges()) assert.deepEqual([min, max], [0, 0.1]);
  await page.locator("#stage").focus();
  await page.keyboard.press("+");
  assert.ok((await ranges())[2][1] - (await ranges())[2][0] < 0.051);
  await page.keyboard.press("0");
  assert.deepEqual((await ranges())[2], [0, 0.1]);
});

await test("the legend reads the values under the pointer", "3rrr", async (page) => {
  const over = await page.locator(".chart .u-over").first().boundingBox();
  await page.mouse.move(over.x + 0.3 * over.width, over.y + 50);
  const {shown, there} = await page.evaluate(() => {
    const chart = window.balanceReport.board.charts[0];
    return {shown: chart.readings[0].textContent, there: chart.lines[0].values[chart.plot.cursor.idx]};
  });
  assert.ok(Math.abs(parseFloat(shown.replace("−", "-")) - there) < 1e-3 * Math.abs(there), `${shown} ${there}`);
});

await test("what friction asks for stands beside the conditions", "rubbing", async (page) => {
  const text = await page.locator("#conditions .staying").innerText();
  assert.match(text, /Cannot be balanced by masses or springs and remains:/);
  assert.match(text, /friction.*J.*up to 0\.5\sN\sm\sat J along go/s);
}, {spec: `space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
actuators: [J]
friction: {J: {coulomb: 0.5}}
motion: {duration: 1, samples: 11, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
trajectories: {go: {law: cycloidal, drive: joints}}
design: {goal: gyroscopic}
`});

await test("another trajectory and another chart are a click away", "3rrr", async (page) => {
  await page.click('.segment[data-value="bang-bang"]');
  assert.match(await page.locator(".about").textContent(), /bang-bang law on the centre of mass/);
  assert.match(await page.locator("#metrics h2").textContent(), /bang-bang/);
  await page.locator(".board summary").click();
  await page.click('.chips [data-chart="power"]');
  assert.equal(await page.locator(".chart").count(), 4);
  await page.click('.chips [data-chart="torque"]');
  assert.equal(await page.locator('.chart[data-chart="torque"]').count(), 0);
});

await test("before and after can be told apart and switched", "5r-design", async (page) => {
  await page.evaluate(() => window.balanceReport.clock.seekSample(150));
  assert.ok((await page.locator(".swatch.before").count()) > 0);
  const after = await stagePixels(page);
  await page.click('.variants [data-value="before"]');
  assert.ok(!after.equals(await stagePixels(page)));
  assert.match(await page.locator(".verdict").textContent(), /Balanced/);
  await page.click('.variants [data-value="after"]');
  await shot(page, "5r-design-light.png");
});

await test("a design of the trade-off can be chosen in its chart, in its table and by keyboard", "four-bar-front", async (page) => {
  const chosen = () => page.locator(".front-details strong").first().textContent();
  await page.locator(".front-point").nth(2).click();
  assert.equal(await chosen(), "Point 3");
  await page.keyboard.press("ArrowRight");
  assert.equal(await chosen(), "Point 4");
  await page.locator("#front table button").nth(7).click();
  assert.equal(await chosen(), "Point 8");
  await page.locator(".front-point[tabindex='0']").focus();
  await page.keyboard.press("ArrowLeft");
  assert.equal(await chosen(), "Point 7");
  const {points} = await page.evaluate(() => window.balanceReport.data.front.front);
  const shown = await page.locator(".front-details tbody td").first().textContent();
  assert.ok(Math.abs(parseFloat(shown.replace("\u2212", "-")) - points[6].free_numbers[0].value) < 1e-4);
  await shot(page, "four-bar-front-light.png");
});

await test("the theme follows the system and its button", "planar-rrr-design", async (page) => {
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await ground();
  await shot(page, "planar-rrr-dark.png");
  await page.click(".actions button:first-child");
  assert.notEqual(await ground(), dark);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "light");
}, {colorScheme: "dark"});

for (const name of draw("turned pages", ["delta", "spatial-rrr-design"], 0.5))
  await test(`${name} moves in space and can be turned`, name, async (page) => {
    await page.evaluate(() => window.balanceReport.clock.seekSample(200));
    const first = await stagePixels(page);
    await shot(page, `${name}.png`, false);
    await page.click('.views [data-value="top"]');
    assert.ok(!first.equals(await stagePixels(page)));
    const box = await page.locator("#stage").boundingBox();
    const from = await page.evaluate(() => window.balanceReport.player.stage.camera.position.toArray());
    await page.mouse.move(box.x + 150, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 260, box.y + 260, {steps: 4});
    await page.mouse.up();
    assert.notDeepEqual(await page.evaluate(() => window.balanceReport.player.stage.camera.position.toArray()), from);
  });

await test("focus is visible, and every control has a name", "5r-design", async (page) => {
  for (let i = 0; i < 12; ++i) {
    await page.keyboard.press("Tab");
    const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
    assert.notEqual(outline, "none");
  }
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, summary, [tabindex='0']")]
    .filter((e) => !(e.getAttribute("aria-label") || e.textContent.trim())).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  assert.equal(await page.locator("table:not(:has(caption))").count(), 0);
});

await test("beside the charts the animation fills the window", "3rrr", async (page) => {
  const left = await page.evaluate(() => innerHeight - document.querySelector(".player").offsetHeight);
  assert.ok(left >= 16 && left < 80, `${left} px around it`);
}, {viewport: {width: 1400, height: 900}});

await test("names of strangers are text, whatever they look like", "names", async (page) => {
  const title = await page.title();
  assert.match(title, /<\/script><script>document\.title='PWNED1'/);
  assert.equal(await page.evaluate(() => document.querySelectorAll("img, script[src], iframe, object").length), 0);
  const text = await page.locator("main").innerText();
  for (const name of ["constructor", "hasOwnProperty", "valueOf", "prototype", "innerHTML"]) assert.ok(text.includes(name), name);
  await page.evaluate(() => document.querySelectorAll("details").forEach((d) => (d.open = true)));
  await page.click('.segment[data-value="document"]');
  await page.click('[data-layer="labels"]');
  assert.equal(await page.title(), title);
}, {spec: `name: "</script><script>document.title='PWNED1'</script><img src=x onerror=\\"document.title='PWNED2'\\">\${alert(1)} {{7*7}} <!-- ]]> \\u2028 & \\" '"
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0], onerror: [0.1, 0]}}
bodies:
  constructor: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0], B: [0.3, 0]}}
  hasOwnProperty: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {B: [0, 0], toString: [0.3, 0]}}
joints:
  valueOf: {type: revolute, connects: [ground.O, constructor.A]}
  prototype: {type: revolute, connects: [constructor.B, hasOwnProperty.B]}
actuators: [valueOf, prototype]
tool: hasOwnProperty.toString
counterweights: {alert: {body: constructor, at: [-0.1, 0], mass: {free: [0, 5]}}}
payloads: {eval: {body: hasOwnProperty, at: toString, mass: 0.2}}
loads: {script: {body: constructor, at: B, force: [1, 0]}}
motion: {duration: 0.5, samples: 21, from: {joints: {valueOf: 0, prototype: 0.3}}, to: {joints: {valueOf: 0.5, prototype: 1}}}
trajectories: {innerHTML: {law: cycloidal, drive: joints}, document: {law: cubic, drive: joints}}
design: {goal: static}
`});

await test("a narrow window has no sideways scrolling", "5r-design", async (page) => {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `${wide} px too wide`);
  await shot(page, "5r-design-narrow.png");
}, {viewport: {width: 390, height: 844}});

await test("paper is light, with charts and without controls", "5r-design", async (page) => {
  await page.pdf({path: join(folder, "5r-design.pdf"), format: "A4"});
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  await page.emulateMedia({media: "print"});
  assert.equal(await page.locator("#play").isVisible(), false);
  assert.equal(await page.locator(".chart canvas").first().isVisible(), true);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "light");
  await shot(page, "5r-design-print.png");
}, {colorScheme: "dark"});

await import("./_press.mjs");
/** Numbers of all axes: of charts over time as they are drawn, of others as their texts say. */
const axisNumbers = (page) => page.evaluate(() => {
  const powers = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const value = (text) => {
    const [mantissa, power] = text.replaceAll("−", "-").split(" × 10");
    return Number(mantissa) * 10 ** (power ? Number([...power].map((c) => (c === "⁻" ? "-" : powers.indexOf(c))).join("")) : 0);
  };
  const axes = window.balanceReport.board.charts.flatMap(({chart, plot}) =>
    plot.axes.map((axis, i) => ({of: `${chart.id} ${"xy"[i]}`, texts: axis._values.filter((t) => t !== null)})));
  document.querySelectorAll(".drawing svg").forEach((svg, k) => {
    const ticks = [...svg.querySelectorAll(".tick")];
    for (const anchor of ["end", "middle"])
      axes.push({of: `drawing ${k} ${anchor}`, texts: ticks.filter((t) => t.getAttribute("text-anchor") === anchor).map((t) => t.textContent)});
  });
  return axes.map(({of, texts}) => ({of, texts, values: texts.map(value)}));
});

/** Steps of 1, 2 or 5 times a power of ten from multiple to multiple, at least two numbers, no two alike. */
function assertRound({of, texts, values}) {
  const told = `${of}: ${texts.join(" ")}`;
  assert.ok(values.length >= 2, told);
  assert.equal(new Set(texts).size, texts.length, told);
  const sorted = [...values].sort((a, b) => a - b);
  const step = (sorted.at(-1) - sorted[0]) / (sorted.length - 1);
  const mantissa = Number((step / 10 ** Math.floor(Math.log10(step) + 1e-9)).toPrecision(6));
  assert.ok([1, 2, 5].includes(mantissa), told);
  for (const one of sorted) assert.ok(Math.abs(one / step - Math.round(one / step)) < 1e-4, told);
}

/** Pairs of texts that lie upon one another, and texts cut off by the edge of their drawing or element. */
const spoiltTexts = (page) => page.evaluate(() => {
  const texts = [];
  for (const element of document.querySelectorAll("main *, header *")) {
    const own = [...element.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
    if (!own.length || element.closest(".unseen, .skip, .stage, select, pre") || !element.checkVisibility()) continue;
    const cut = element.closest(".table-box, .legend.crowded")?.getBoundingClientRect();
    for (const node of own) {
      const range = document.createRange();
      range.selectNodeContents(node);
      for (const {left, right, top, bottom} of range.getClientRects()) {
        const box = cut ? {left: Math.max(left, cut.left), right: Math.min(right, cut.right), top: Math.max(top, cut.top), bottom: Math.min(bottom, cut.bottom)}
          : {left, right, top, bottom};
        if (box.right - box.left > 1 && box.bottom - box.top > 1) texts.push({...box, element, text: node.data.trim().slice(0, 30)});
      }
    }
  }
  const spoilt = [];
  texts.sort((a, b) => a.top - b.top);
  for (let i = 0; i < texts.length; ++i)
    for (let j = i + 1; j < texts.length && texts[j].top < texts[i].bottom - 2; ++j) {
      const [a, b] = [texts[i], texts[j]];
      if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1.5) spoilt.push(`"${a.text}" and "${b.text}" overlap`);
    }
  for (const {element, text, left, right} of texts) {
    const svg = element.closest(".drawing svg")?.getBoundingClientRect();
    if (svg && (left < svg.left - 1 || right > svg.right + 1)) spoilt.push(`"${text}" leaves its drawing`);
    if (!svg && !element.closest(".table-box") && (left < -1 || right > innerWidth + 1)) spoilt.push(`"${text}" leaves the window`);
  }
  return spoilt;
});

await test("orders of a motion at constant speed are bars, and the same in numbers", "machines/single-cylinder", async (page) => {
  const {data} = await page.evaluate(() => window.balanceReport);
  const rows = data.trajectories[0].before.orders.rows.filter((row) => !row.component && row.quantity === "torque[A]");
  assert.equal(rows.length, 8);
  const heights = await page.locator(".orders-chart[aria-label*='Actuator torque'] .order-bar").evaluateAll((bars) => bars.map((bar) => Number(bar.getAttribute("height"))));
  const largest = (values) => values.indexOf(Math.max(...values));
  assert.equal(largest(heights), largest(rows.map((row) => row.amplitude)));
  assert.equal(await page.locator(".orders table tbody tr").count() % 8, 0);
});

await test("a motion from one place to another has no orders", "5r-design", async (page) => assert.equal(await page.locator(".orders").count(), 0));

const drawings = ["machines/single-cylinder", "four-bar-front", "rr-adaptive", "slider-crank", "scara-design", "rr-tolerance", "stewart", "control-5r"];
for (const name of draw("pages with axes", drawings, 0.4, (page) => (page === "four-bar-front" ? ["front"] : page === "rr-adaptive" ? ["loads"] : [])))
  for (const width of [1280, 390])
    await test(`numbers of the axes of ${name} are round and no texts overlap, ${width} px wide`, name, async (page) => {
      await page.waitForTimeout(100); // drawings follow the width one frame later
      (await axisNumbers(page)).forEach(assertRound);
      assert.deepEqual(await spoiltTexts(page), []);
      await page.evaluate(() => window.balanceReport.board.zoomBy(1 / 16));
      (await axisNumbers(page)).filter(({of}) => of.endsWith(" x")).forEach(assertRound);
    }, {viewport: {width, height: 900}});

await test("a wide motion leaves no empty room above and below it", "slider-crank", async (page) => {
  const {height, needed, wide} = await page.evaluate(() => {
    const {view, stageBox} = window.balanceReport.player;
    const {low, high} = view.bounds();
    const margins = 88, {clientWidth: width, clientHeight: height} = stageBox;
    return {height, wide: (high[0] - low[0]) / (high[1] - low[1]), needed: margins + ((width - margins) * (high[1] - low[1])) / (high[0] - low[0])};
  });
  assert.ok(wide > 1.5);
  assert.ok(height <= Math.max(needed, 300) + 1, `${height} of ${needed}`);
});

await browser.close();
console.log(failures() ? `${failures()} failed` : "all passed");
process.exit(failures() ? 1 : 0);
