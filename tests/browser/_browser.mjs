// A page in headless Chromium; every complaint of the page's console is kept.
import {createRequire} from "node:module";
import {join} from "node:path";
import {pathToFileURL} from "node:url";

const packages = process.env.PAGE_PACKAGES;
const {chromium} = createRequire(join(packages, "package.json"))("playwright-core");

const switches = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--enable-unsafe-swiftshader"];

export const launch = () => chromium.launch({executablePath: process.env.CHROMIUM, headless: true, args: switches});

let kept; // one page shows all files: a renderer for each of them takes longer than most tests

async function freePage(browser) {
  if (kept?.busy) {  // a test has failed in it
    await kept.context.close();
    kept = undefined;
  }
  if (!kept) {
    const context = await browser.newContext();
    context.setDefaultTimeout(120_000); // a busy machine is slow, not wrong
    kept = {context, page: await context.newPage()};
  }
  kept.busy = true;
  return kept.page;
}

/** Opens a file; the page must not ask for anything else. */
export async function open(browser, file, {viewport = {width: 1400, height: 900}, colorScheme = "light"} = {}) {
  const page = await freePage(browser);
  await page.setViewportSize(viewport);
  await page.emulateMedia({media: null, colorScheme});
  await page.mouse.move(0, 0);
  const complaints = [];
  const asked = [];
  page.on("console", (message) => {
    // Taking pictures slows the page down, which the browser mentions.
    if (/GPU stall due to ReadPixels|Multiple readback operations/.test(message.text())) return;
    if (["error", "warning"].includes(message.type())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => asked.push(request.url()));
  const url = pathToFileURL(file).href;
  const began = performance.now();
  await page.goto(url);
  await page.waitForFunction(() => window.balanceReport?.board?.charts.length > 0);
  const seconds = (performance.now() - began) / 1000;
  const foreign = asked.filter((u) => u !== url && !u.startsWith("data:") && !u.startsWith("blob:"));
  const close = () => {
    for (const event of ["console", "pageerror", "request"]) page.removeAllListeners(event);
    kept.busy = false;
  };
  return {page, complaints, foreign, seconds, close};
}
