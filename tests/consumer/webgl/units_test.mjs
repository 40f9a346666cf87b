// SPDX-License-Identifier: MIT
// node units_test.mjs EXAMPLE: what of the viewer needs no browser.
import assert from "node:assert/strict";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { decodePng } from "./png.mjs";

const source = (name) => import(pathToFileURL(join(process.argv[2], "src", name)));
const { encodePng, toBytes } = await source("viewer/png.js");
const { measurePng } = await source("viewer/sizes.js");
const { DEFAULTS, makeLink, parseLink } = await source("viewer/link.js");
const { guessRoles, namesOfRoles } = await source("ntc/roles.js");
const { makeConstants } = await source("ntc/constants.js");
const { kindOf, sortFiles } = await source("viewer/files.js");

for (let channels = 1; channels <= 4; channels++) {
  const [width, height] = [13, 9];
  let state = channels;
  const pixels = Uint8Array.from({ length: width * height * channels }, (_, i) => {
    state = (state * 1103515245 + 12345) >>> 0;
    return i % 3 === 0 ? state >>> 24 : (i * 7) & 255; // noise and gradients: every filter is chosen somewhere
  });
  const file = await encodePng(pixels, width, height, channels);
  assert.deepEqual(decodePng(new Uint8Array(await file.arrayBuffer())), { width, height, channels, pixels });
}
await assert.rejects(encodePng(new Uint8Array(5), 1, 1, 5), { message: "5 channels: a PNG has 1 ... 4" });
{ // the files that hold a texture of six channels
  const set = { width: 3, height: 1, textures: [{ firstChannel: 2, channels: 6 }, { firstChannel: 0, channels: 1 }, { firstChannel: 9, channels: 0 }] };
  const texels = Float32Array.from({ length: 48 }, (_, i) => ((i * 37) % 100) / 99);
  const bytes = await measurePng(set, { decodeMip: async () => texels });
  const sizes = [[2, 4], [6, 2], [0, 1]].map(async ([firstChannel, channels]) =>
    (await encodePng(toBytes(texels, { firstChannel, channels }), 3, 1, channels)).size);
  assert.equal(bytes, (await Promise.all(sizes)).reduce((sum, size) => sum + size));
}
{
  const texels = new Float32Array(16);
  texels.set([-0.5, 1.5, 0.5], 4);
  assert.deepEqual([...toBytes(texels, { firstChannel: 4, channels: 3 })], [0, 255, 128]);
}

// Links give back what they were made of, and nothing but what is allowed.
{
  const changed = {
    ...DEFAULTS, view: "textures", shape: "cube", onShape: true, texture: "Base & Colour#1", channel: "g", mip: 3, kernel: "catmull-rom",
    anisotropy: 8, stochastic: false, repeat: 2.5, light: -40, exposure: 0.5, flipNormal: true, comparison: "split", gain: 16, split: 0.25,
    modelMaterial: "a, b", gpu: "webgl",
  };
  for (const key of Object.keys(DEFAULTS)) assert.notEqual(changed[key], DEFAULTS[key], key);
  const link = makeLink(changed, "dir/a b.ntc", [1, -2.5, 3]);
  assert.deepEqual(parseLink(link), { state: changed, file: "dir/a b.ntc", camera: [1, -2.5, 3] });
  assert.equal(makeLink({ ...DEFAULTS }, "", []), "#");
  const hostile = parseLink("#view=x&shape=__proto__&mip=NaN&gain=1e9&split=-3&camera=1,,x&exposure=Infinity&stochastic=maybe");
  assert.deepEqual(hostile, { state: { ...DEFAULTS, gain: 64, split: 0, stochastic: false }, file: "", camera: [] });
}

// What textures are for.
{
  const texture = (name, firstChannel, channels) => ({ name, firstChannel, channels });
  assert.deepEqual(
    guessRoles([texture("BaseColor", 0, 4), texture("Roughness", 5, 1), texture("Metalness", 4, 1), texture("Normal", 8, 3), texture("Occlusion", 11, 1)]),
    { baseColor: 0, opacity: 3, roughness: 5, metalness: 4, normal: 8, normalChannels: 3, occlusion: 11 },
  );
  assert.deepEqual(guessRoles([texture("wood_ORM", 3, 3), texture("wood_nrm", 6, 2), texture("wood_albedo", 0, 3)]), {
    occlusion: 3, roughness: 4, metalness: 5, normal: 6, normalChannels: 2, baseColor: 0,
  });
  assert.deepEqual(guessRoles([texture("Helmet_MetalRough", 3, 3), texture("Normalized height", 6, 1)]), { roughness: 4, metalness: 5 });
  const converted = [texture("BaseColor", 0, 3), texture("MetallicRoughness", 4, 2), texture("Normal", 8, 3), texture("Occlusion", 11, 1)];
  const roles = guessRoles(converted); // channels of `ntc convert-gltf`
  assert.deepEqual(roles, { baseColor: 0, metalness: 4, roughness: 5, normal: 8, normalChannels: 3, occlusion: 11 });
  assert.deepEqual(converted.map((of) => namesOfRoles(roles, of)), [["baseColor"], ["metalness", "roughness"], ["normal"], ["occlusion"]]);
  assert.deepEqual(guessRoles([texture("T_Wall_BC", 0, 3), texture("T_Wall_N_2k", 3, 2), texture("T_Wall_R", 5, 1), texture("T_Wall_AO_01", 6, 1)]), {
    baseColor: 0, normal: 3, normalChannels: 2, roughness: 5, occlusion: 6,
  });
  assert.deepEqual(guessRoles([texture("Car_MaskMap", 4, 4), texture("Car_BaseMap", 0, 4), texture("SheenColor", 8, 3)]), {
    metalness: 4, occlusion: 5, smoothness: 7, baseColor: 0, opacity: 3,
  });
  assert.deepEqual(guessRoles([texture("SpecularColor", 0, 3), texture("ClearcoatNormal", 3, 3), texture("thin", 6, 3)]), {});
  assert.deepEqual(guessRoles([]), {});
}

// Every word of the constants lands in one field.
{
  const words = new Int32Array(156).map((_, i) => i + 1);
  const constants = makeConstants(new Uint8Array(words.buffer));
  assert.equal(constants.highResEncoding.numFeatures, 1);
  assert.equal(constants.lowResNeuralMips[0].dataOffset, 49);
  assert.equal(constants.colorMips[15].neuralMip, 141);
  assert.equal(constants.imageWidth, 149);
  assert.equal(constants.padding1, 156);
}

assert.equal(kindOf(Uint8Array.from("glTF....", (c) => c.charCodeAt(0))), "model");
assert.equal(kindOf(Uint8Array.of(0x89, 0x50, 0x4e, 0x47)), "image");
assert.equal(kindOf(new Uint8Array(0)), "set");
assert.equal(kindOf(Buffer.from('\n{ "asset"')), "model");
{
  const read = (name, text) => ({ file: { name }, bytes: Buffer.from(text, "latin1") });
  const image = "\x89PNG";
  const names = (all) => sortFiles(all).opened.map(({ file }) => file.name);
  assert.deepEqual(names([read("a.png", image), read("b.glb", "glTF"), read("c.ntc", "NTEX")]), ["c.ntc", "a.png", "b.glb"]);
  const dropped = [read("a.bin", "{}"), read("a.gltf", "{"), read("a.png", image), read("c.ntc", "NTEX"), read("d.ntc", "")];
  assert.deepEqual(names(dropped), ["c.ntc", "d.ntc", "a.gltf"]);
  assert.deepEqual([...sortFiles(dropped).files.keys()], ["a.bin", "a.png"]);
}
console.log("units: passed");
