// SPDX-License-Identifier: MIT
// node wgsl.mjs MODULES TEXTS OUTPUT.json: Texels.comp, flattened for each network, as WGSL by naga. MODULES has node_modules with
// web-naga. OUTPUT.json: for each network the text before, of and after the function that multiplies four bytes, of which
// src/decoder.js has another one.
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, texts, output] = process.argv.slice(2);
if (output === undefined) {
  console.error("usage: node wgsl.mjs MODULES TEXTS OUTPUT.json");
  process.exit(2);
}
const folder = join(modules, "node_modules/web-naga");
const naga = await import(pathToFileURL(join(folder, "web_naga.js")));
await naga.default({ module_or_path: readFileSync(join(folder, "web_naga_bg.wasm")) });

const DOT = /fn NtcDot4Emulated\(\w+: u32, \w+: u32\) -> i32 \{\n[^]*?\n\}\n/;

function translate(text) {
  const wgsl = naga.GlslFrontend.new().parse(text, naga.ShaderStage.Compute).to_wgsl();
  const found = DOT.exec(wgsl);
  if (!found) throw new Error("naga's text has no function NtcDot4Emulated");
  return { before: wgsl.slice(0, found.index), dot: found[0], after: wgsl.slice(found.index + found[0].length) };
}

const shaders = {};
for (const name of readdirSync(texts)) {
  const network = /NETWORK_VERSION=(\d+).*\.glsl$/.exec(name);
  if (network) shaders[network[1]] = translate(readFileSync(join(texts, name), "utf8"));
}
writeFileSync(output, JSON.stringify(shaders));
