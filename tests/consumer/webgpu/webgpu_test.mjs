// SPDX-License-Identifier: MIT
// node webgpu_test.mjs MODULE DOCUMENTATION NTC CHROMIUM SET…: openntc-webgpu.js in Chromium. Of every set all outputs of every texel of
// mips up to MOST_TEXELS have the bits of `ntc sample`, with dot4I8Packed and without; textures of sets without larger mips are those
// numbers in 8 bits; a set with a wrong weight is noticed; the page of DOCUMENTATION says a texel of the first set, which is also
// decoded for its speed.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Browser } from "../webgl/browser.mjs";
import { sampleMip, sampleTexels } from "../webgl/samples.mjs";
import { withSite } from "../webgl/site.mjs";

const [module, documentation, ntc, chromium, ...sets] = process.argv.slice(2);
const here = fileURLToPath(new URL(".", import.meta.url));
const expected = new Map(); // by path
const MOST_TEXELS = 128 * 128; // SwiftShader decodes some 20 000 a second

function read(path) {
  if (path === "/index.html") return '<!DOCTYPE html><script type="module" src="/page.js"></script>';
  if (path === "/documented.html") return /```html\n([^]*?)```/.exec(readFileSync(documentation, "utf8"))[1];
  if (path === "/page.js") return readFileSync(join(here, "page.js"));
  if (path === "/openntc-webgpu.js") return readFileSync(module);
  const set = sets.find((file) => path.endsWith(`/${basename(file)}`));
  return set ? readFileSync(set) : expected.get(path);
}

async function checkSet(browser, file, hasPackedDot) {
  const name = basename(file);
  const set = await browser.run(`tests.open("/sets/${name}")`);
  const sizes = Array.from({ length: set.mips }, (_, mip) => [set.width, set.height].map((side) => Math.max(side >> mip, 1)));
  const firstMip = sizes.findIndex(([width, height]) => width * height <= MOST_TEXELS);
  for (let mip = firstMip; mip < set.mips; mip++) {
    const [width, height] = sizes[mip];
    expected.set(`/expected/${name}/${mip}`, Buffer.from(sampleMip(ntc, file, mip, width, height).buffer));
  }
  for (const packed of hasPackedDot ? [true, false] : [false]) {
    const { compared, different } = await browser.run(`tests.compareBits("${name}", ${firstMip}, ${packed}, false)`);
    assert.equal(different, 0, `${name}: ${different} of ${compared} numbers differ, dot4I8Packed: ${packed}`);
    console.log(`${name}: ${set.network}, mips ${firstMip} to ${set.mips - 1}${packed ? ", dot4I8Packed" : ""}: ${compared} numbers, none different`);
  }
  if (firstMip > 0) return undefined;
  const textures = await browser.run(`tests.compareTextures("${name}")`);
  if (textures.refusal) return assert.match(textures.refusal, new RegExp(`: ${Math.max(textures.channels, 5)} channels: a texture has 1 ... 4$`));
  return assert.equal(textures.different, 0, `${name}: ${textures.different} of ${textures.compared} bytes of a texture differ`);
}

async function checkDocumented(browser, address) {
  await browser.go(`${address}documented.html`);
  const shown = await browser.run(`(async () => {
    const element = document.getElementById("texel");
    for (let i = 0; i < 600 && element.textContent === ""; i++) await new Promise((resume) => setTimeout(resume, 100));
    return element.textContent;
  })()`);
  const texel = sampleTexels(ntc, sets[0], ["0 10 20"]);
  assert.equal(shown, texel.join(" "));
}

const browser = new Browser(chromium, "swiftshader", 400, 300);
try {
  await withSite(read, async (address) => {
    await browser.open(address, 400, 300);
    const gpu = await browser.run("tests.start()");
    if (!gpu) return console.log("SKIP: consumer_webgpu: this Chromium has no WebGPU adapter");
    for (const file of sets) await checkSet(browser, file, gpu.hasPackedDot);
    const control = await browser.run(`tests.compareBits("${basename(sets.at(-1))}", 0, false, true)`);
    assert.ok(control.different > 0, "a wrong weight was not noticed");
    assert.match(await browser.run("tests.refuse()"), /^latents: \d+ bytes: at most 16 on this device$/);
    await browser.run(`tests.open("/sets/${basename(sets[0])}")`);
    for (const packed of gpu.hasPackedDot ? [true, false] : [false]) {
      const texels = await browser.run(`tests.measureSpeed(${packed})`);
      const form = packed ? ", dot4I8Packed" : "";
      console.log(`${basename(sets[0])}: WebGPU${form}: ${(texels / 1e6).toFixed(3)} million texels a second on ${gpu.name}`);
    }
    await checkDocumented(browser, address);
    return assert.deepEqual(browser.getComplaints(), []);
  });
} catch (error) {
  console.error(browser.logs.join("\n"));
  throw error;
} finally {
  await browser.close();
}
