// Bundles the page: planar.js without and spatial.js with three.js, one style sheet.
//   node build.mjs <folder with node_modules, where the bundles go>
import {readFileSync} from "node:fs";
import {createRequire} from "node:module";
import {dirname, join, resolve} from "node:path";
import {fileURLToPath} from "node:url";

const target = resolve(process.argv[2]);
const source = join(dirname(fileURLToPath(import.meta.url)), "src");
const esbuild = createRequire(join(target, "package.json"))("esbuild");

/** Name, version and licence of a package whose code a bundle holds: whoever passes a page on passes them on, too. */
function notice(name) {
  const folder = join(target, "node_modules", name);
  const {version} = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  return `${name} ${version}\n\n${readFileSync(join(folder, "LICENSE"), "utf8").trim()}`;
}

const bundles = {planar: ["uplot"], spatial: ["uplot", "three"]};
for (const [name, packages] of Object.entries(bundles)) {
  await bundle({
    entryPoints: [join(source, `${name}.js`)],
    banner: {js: `/*! This page holds\n\n${packages.map(notice).join("\n\n")}\n*/`},
  });
}
await bundle({entryPoints: [join(source, "page.css")]});

function bundle(what) {
  return esbuild.build({
    outdir: join(target, "bundle"),
    nodePaths: [join(target, "node_modules")],
    bundle: true,
    minify: true,
    format: "iife",
    target: "chrome110",
    charset: "utf8",
    legalComments: "inline",
    logLevel: "warning",
    ...what,
  });
}
