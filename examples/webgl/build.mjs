// SPDX-License-Identifier: MIT
// node build.mjs MODULES READER.wasm FUNCTIONS WGSL.json SAMPLES OUTPUT: one page without other files (viewer.html), and the modules for
// applications of one's own (openntc-three.js, openntc-webgpu.js). MODULES has node_modules with three and esbuild.
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const [modules, reader, functions, wgsl, samples, output] = process.argv.slice(2);
if (output === undefined) {
  console.error("usage: node build.mjs MODULES READER.wasm FUNCTIONS WGSL.json SAMPLES OUTPUT");
  process.exit(2);
}
const here = dirname(fileURLToPath(import.meta.url));
const esbuild = createRequire(join(modules, "package.json"))("esbuild");

/** The flattened decoder of every network, as JavaScript. */
function readFunctions() {
  const texts = {};
  for (const name of readdirSync(functions)) {
    const network = /NETWORK_VERSION=(\d+).*\.glsl$/.exec(name);
    if (network) texts[network[1]] = readFileSync(join(functions, name), "utf8");
  }
  return `export default ${JSON.stringify(texts)};`;
}

function readSamples() {
  const files = readdirSync(samples).filter((name) => name.endsWith(".ntc"));
  const imports = files.map((name, i) => `import s${i} from ${JSON.stringify(join(samples, name))};`);
  return `${imports.join("\n")}\nexport default {${files.map((name, i) => `${JSON.stringify(name)}: s${i}`)}};`;
}

const built = {
  name: "built",
  setup(build) {
    build.onResolve({ filter: /^openntc:/ }, ({ path }) => ({ path, namespace: "openntc" }));
    build.onLoad({ filter: /./, namespace: "openntc" }, ({ path }) => {
      if (path === "openntc:reader.wasm") return { contents: readFileSync(reader), loader: "binary" };
      if (path === "openntc:wgsl") return { contents: readFileSync(wgsl), loader: "json" };
      if (path === "openntc:functions") return { contents: readFunctions(), loader: "js" };
      return { contents: readSamples(), loader: "js", resolveDir: here };
    });
  },
};
const common = {
  bundle: true,
  minify: true,
  target: "es2022",
  legalComments: "inline",
  nodePaths: [join(modules, "node_modules")],
  loader: { ".ntc": "binary" },
  plugins: [built],
  logLevel: "warning",
};

const page = await esbuild.build({ ...common, entryPoints: [join(here, "src/viewer/main.js")], format: "iife", write: false });
const styles = await esbuild.build({ ...common, entryPoints: [join(here, "viewer.css")], write: false });
const script = page.outputFiles[0].text.replaceAll("</script", "<\\/script");
const html = readFileSync(join(here, "viewer.html"), "utf8")
  .replace("/* style */", () => styles.outputFiles[0].text)
  .replace("/* script */", () => script);
mkdirSync(output, { recursive: true });
writeFileSync(join(output, "viewer.html"), html);
for (const [name, entry] of [["three", "src/ntc/index.js"], ["webgpu", "../webgpu/src/index.js"]])
  await esbuild.build({
    ...common, entryPoints: [join(here, entry)], format: "esm", external: ["three"], outfile: join(output, `openntc-${name}.js`),
  });
console.log(`viewer.html ${html.length} bytes`);
