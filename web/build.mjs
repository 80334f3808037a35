// Bundles the page: planar.js without and spatial.js with three.js, one style sheet.
//   node build.mjs <folder with node_modules, where the bundles go>
import {createRequire} from "node:module";
import {dirname, join, resolve} from "node:path";
import {fileURLToPath} from "node:url";

const target = resolve(process.argv[2]);
const source = join(dirname(fileURLToPath(import.meta.url)), "src");
const esbuild = createRequire(join(target, "package.json"))("esbuild");

await esbuild.build({
  entryPoints: ["planar.js", "spatial.js", "page.css"].map((name) => join(source, name)),
  outdir: join(target, "bundle"),
  nodePaths: [join(target, "node_modules")],
  bundle: true,
  minify: true,
  format: "iife",
  target: "chrome110",
  charset: "utf8",
  legalComments: "inline",
  logLevel: "warning",
});
