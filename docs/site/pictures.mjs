// Pictures of mechanisms from their pages, two fifths through the motion. Arguments: folder of pages, folder for pictures.
import {readdirSync} from "node:fs";
import {basename, join} from "node:path";
import {launch, open} from "../../tests/browser/_browser.mjs";

const [pages, pictures] = process.argv.slice(2);
const browser = await launch();
for (const file of readdirSync(pages)) {
  const name = basename(file, ".html");
  const {page, close} = await open(browser, join(pages, file), {viewport: {width: 1100, height: 800}, colorScheme: "light"});
  await page.evaluate(() => {
    const {clock} = window.balanceReport;
    clock.seek(0.4 * clock.duration);
    document.querySelectorAll("#stage .views").forEach((e) => e.remove());
  });
  await page.locator("#stage canvas").first().screenshot({path: join(pictures, `${name}.png`)});
  await close();
}
await browser.close();
