// What tests of the report's pages share. Arguments: program, folder of mechanisms, folder for pictures.
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {existsSync, mkdirSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {launch, open} from "./_browser.mjs";
import {whole} from "./_sampling.mjs";

export const [program, configs, folder] = process.argv.slice(2);
if (!existsSync(process.env.CHROMIUM ?? "")) {
  console.log("skipped: there is no Chromium here (scripts/setup installs it)");
  process.exit(77);
}
mkdirSync(folder, {recursive: true});
const only = process.env.ONLY;

/** Pages by their paths: a name stands for one spec, which is told once. */
const made = new Set();

/** @param more {spec: text of another spec than the config of that name, words: more arguments} */
function makePage(name, {spec, words = []} = {}) {
  const file = join(folder, `${name.replaceAll("/", "-")}${words.join("")}.html`);
  if (made.has(file)) return file;
  const given = spec ? join(folder, `${name}.yaml`) : join(configs, `${name}.yaml`);
  if (spec) writeFileSync(given, spec);
  execFileSync(program, ["report", given, ...words, "-o", file, "--force", "-q"]);
  made.add(file);
  return file;
}

export const browser = await launch();
let failed = 0;
export const failures = () => failed;

/** One test on one page; complaints of its console and requests for anything else are failures. */
export async function test(sentence, name, body, {spec, words, violates, ...options} = {}) {
  if (only && !sentence.includes(only)) return;
  try {
    const opened = await open(browser, makePage(name, {spec, words}), options);
    if (violates) assert.deepEqual(opened.complaints, [], "the console is silent before the test is not");
    await body(opened.page, opened);
    if (!violates) assert.deepEqual(opened.complaints, [], "the console is silent");
    assert.deepEqual(opened.foreign, [], "nothing else is fetched");
    opened.close();
    console.log(`ok      ${sentence}`);
  } catch (error) {
    ++failed;
    console.log(`FAILED  ${sentence}\n${error.stack}`);
  }
}

export const clock = (page) => page.evaluate(() => {
  const {sample, now, playing} = window.balanceReport.clock;
  return {sample, now, playing};
});
export const pressed = (page, selector) => page.locator(selector).getAttribute("aria-pressed");
/** Pictures for people, which no test looks at: with all tests only. */
export const shot = (page, name, fullPage = true) => whole && page.screenshot({path: join(folder, name), fullPage});

/** Differences between two pictures of the stage, as the share of pixels. */
export const stagePixels = (page) => page.locator("#stage canvas").first().screenshot();
