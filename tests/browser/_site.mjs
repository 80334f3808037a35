// Opens pages of the site in a folder, all of them with BALANCE_WHOLE=1, as a reader does from a disk, and names what the console says. Arguments: folder.
import {readdirSync} from "node:fs";
import {join, relative} from "node:path";
import {pathToFileURL} from "node:url";
import {launch} from "./_browser.mjs";
import {draw} from "./_sampling.mjs";

const folder = process.argv[2];
const all = readdirSync(folder, {recursive: true}).filter((name) => name.endsWith(".html")).sort();
// a page in every folder at least
const pages = draw("pages of the site", all, 0.3, (name) => [name.split("/").slice(0, -1).join("/")]);
const browser = await launch();
const page = await (await browser.newContext()).newPage();
let open = "", complaints = 0;
const complain = (text) => {
  ++complaints;
  console.log(`${open}: ${text}`);
};
page.on("console", (message) => {
  // A machine without a graphics card draws slowly, which the browser mentions.
  if (!/GPU stall due to ReadPixels|Multiple readback operations/.test(message.text())) complain(`${message.type()}: ${message.text()}`);
});
page.on("pageerror", (error) => complain(String(error)));
page.on("requestfailed", (request) => complain(`not found: ${relative(folder, request.url())}`));
page.on("request", (request) => {
  if (!/^(file|data|blob):/.test(request.url())) complain(`asks for ${request.url()}`);
});
for (open of pages) await page.goto(pathToFileURL(join(folder, open)).href, {waitUntil: "load"});
await browser.close();
console.log(`${pages.length} pages, ${complaints} complaints`);
process.exit(complaints ? 1 : 0);
