// SPDX-License-Identifier: MIT
// node material_test.mjs PAGE MODULES NTC CHROMIUM FOLDER SET: what the shaders show. The viewer's flat view of every texture of
// the set is what `ntc decode` writes; the material of openntc-three.js, beside PAGE, is three.js's own with the decoded texels as
// textures. Planted faults must be noticed. MODULES has node_modules with three.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { FLAT_VIEW, Flat } from "./flat.mjs";
import { sampleMip } from "./samples.mjs";
import { withSite } from "./site.mjs";

const [page, modules, ntc, chromium, folder, file] = process.argv.slice(2);
const SIDE = 256; // of the set
const here = fileURLToPath(new URL(".", import.meta.url));
const IMPORTS = JSON.stringify({ imports: { three: "/node_modules/three/build/three.module.js" } });
const INDEX = `<!DOCTYPE html><script type="importmap">${IMPORTS}</script><script type="module" src="/material.js"></script>`;

/** Light that is one step of 8 bits in sRGB where the curve is steepest, halved: pictures differ by that step at most. */
const ALLOWED = 0.5 / 255 / 12.92;
const SOUND = ["sound", "two channels of the normal"];
const FAULTS = [
  "roughness and metalness swapped", "no occlusion", "no emission", "green of the normal turned round", "sRGB taken for light",
];

async function checkTextures(browser, stored, light) {
  const bytes = readFileSync(file);
  const flat = await Flat.open(browser, bytes, stored, light);
  const decoded = join(folder, "decoded");
  execFileSync(ntc, ["decode", file, "-o", decoded]);
  const compared = await flat.check(decoded);
  console.log(`${basename(file)}: flat: ${compared} numbers of 8 bits, none another one than ntc decode's`);
  await flat.checkFaults();
}

async function checkMaterial(browser, texels) {
  const read = (path) => {
    if (path === "/index.html") return INDEX;
    if (path === "/texels") return Buffer.from(texels.buffer);
    const from = { "/set": file, "/material.js": join(here, "material.js"), "/openntc-three.js": join(dirname(page), "openntc-three.js") };
    const place = from[path] ?? join(modules, path);
    return existsSync(place) ? readFileSync(place) : undefined;
  };
  await withSite(read, async (address) => {
    await browser.go(address);
    const names = await browser.run('tests.open("/set", "/texels")');
    assert.deepEqual(names.toSorted(), ["BaseColor", "Emissive", "Metalness", "Normal", "Occlusion", "Roughness"]);
    for (const form of [...SOUND, ...FAULTS]) {
      const { largest, beyond, drawn, pixels } = await browser.run(`tests.compare(${JSON.stringify(form)}, ${ALLOWED})`);
      assert.ok(drawn > pixels / 4 && drawn < pixels, `${drawn} of ${pixels} pixels are drawn`); // the set has holes
      if (SOUND.includes(form)) assert.equal(beyond, 0, `${form}: ${beyond} pixels are not three.js's, by up to ${largest}`);
      else assert.ok(beyond > pixels / 8, `${form}: only ${beyond} of ${pixels} pixels show it`);
      console.log(`${basename(file)}: material, ${form}: ${beyond} of ${drawn} pixels differ, by up to ${largest.toPrecision(2)}`);
    }
  });
}

const browser = new Browser(chromium, "llvmpipe", 400, 300);
try {
  const [stored, light] = [[], ["--linear"]].map((options) => sampleMip(ntc, file, 0, SIDE, SIDE, ...options));
  await browser.open(`${pathToFileURL(page)}#${FLAT_VIEW}`, 400, 300);
  await checkTextures(browser, stored, light);
  await checkMaterial(browser, light);
  assert.deepEqual(browser.getComplaints(), []);
} catch (error) {
  console.error(browser.logs.join("\n"));
  throw error;
} finally {
  await browser.close();
}
