// SPDX-License-Identifier: MIT
// node dawn_test.mjs MODULE PACKAGE NTC SET…: openntc-webgpu.js without a browser, in Dawn (PACKAGE: npm's webgpu) on Mesa's OpenGL ES.
// Of every set all outputs of every texel and mip have the bits of `ntc sample`, with dot4I8Packed and without. Says how fast it decodes.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { countDifferentWords, sampleMip } from "../webgl/samples.mjs";

const [module, packageFolder, ntc, ...sets] = process.argv.slice(2);
const { create, globals } = createRequire(import.meta.url)(packageFolder);
Object.assign(globalThis, globals);
const gpu = create(["backend=opengles"]); // Dawn on Vulkan wants more than lavapipe of Debian 12 has
Object.defineProperty(globalThis, "navigator", { value: { gpu }, configurable: true });
const { NtcGpuDecoder, hasPackedDot, openTextureSet } = await import(pathToFileURL(module));

async function countDifferent(decoder, file) {
  let compared = 0, different = 0;
  for (let mip = 0; mip < decoder.set.mips; mip++) {
    const texels = await decoder.decodeMip(mip);
    different += countDifferentWords(texels, sampleMip(ntc, file, mip, ...decoder.getMipSize(mip)));
    compared += texels.length;
  }
  return { compared, different };
}

const adapter = await gpu.requestAdapter({ featureLevel: "compatibility" });
if (!adapter) {
  console.log("SKIP: consumer_webgpu_dawn: Dawn has no adapter for OpenGL ES here");
  process.exit(0);
}
const device = await adapter.requestDevice();
for (const file of sets) {
  const set = await openTextureSet(readFileSync(file));
  for (const packedDot of hasPackedDot() ? [true, false] : [false]) {
    const decoder = await NtcGpuDecoder.create(device, set, { packedDot });
    const { compared, different } = await countDifferent(decoder, file);
    assert.equal(different, 0, `${basename(file)}: ${decoder.name}: ${different} of ${compared} numbers differ`);
    console.log(`${basename(file)}: ${set.networkName}: ${decoder.name}: ${compared} numbers, none different`);
    if (file === sets[0]) {
      const texels = await decoder.measureSpeed();
      console.log(`${basename(file)}: ${decoder.name}: ${(texels / 1e6).toFixed(2)} million texels a second on ${adapter.info.description}`);
    }
    const floats = { name: "Glow", firstChannel: 0, channels: 3, format: "FLOAT16" };
    await assert.rejects(decoder.decodeToTexture(floats), /^Error: Glow: FLOAT16: textures of 8 bits hold 0 \.\.\. 1/);
    decoder.dispose();
  }
}
process.exit(0); // Dawn's threads would keep the process
