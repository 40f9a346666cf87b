// SPDX-License-Identifier: MIT
// How large the set is, and the same textures in other forms.
import { encodePng, toBytes } from "./png.js";

const BLOCK_BYTES = { BC1: 8, BC2: 16, BC3: 16, BC4: 8, BC5: 16, BC6H: 16, BC7: 16 };
const BYTES_A_CHANNEL = { UNORM8: 1, UNORM16: 2, FLOAT16: 2, FLOAT32: 4, UINT32: 4, UNKNOWN: 1 };

export function formatBytes(bytes) {
  if (bytes < 1024) return `${bytes} B`;
  return bytes < 1000 * 1024 ? `${(bytes / 1024).toFixed(1)} KiB` : `${(bytes / 1024 ** 2).toFixed(2)} MiB`;
}

export function formatRate(texels) {
  return texels < 1e6 ? `${Math.round(texels / 1e3)} thousand texels/s` : `${(texels / 1e6).toPrecision(3)} million texels/s`;
}

function eachMip({ width, height, mips }, bytesOf) {
  let sum = 0;
  for (let mip = 0; mip < mips; mip++) sum += bytesOf(Math.max(width >> mip, 1), Math.max(height >> mip, 1));
  return sum;
}

function blocks(width, height) {
  return Math.ceil(width / 4) * Math.ceil(height / 4);
}

/** Bytes of all mips: in BC7 alone, in the block formats that the file names, and as texels (three channels take the room of four). */
export function measureForms(set) {
  const sum = (bytesOf) => set.textures.reduce((all, texture) => all + eachMip(set, (w, h) => bytesOf(texture, w, h)), 0);
  return {
    bc7: sum((texture, w, h) => 16 * blocks(w, h)),
    named: sum((texture, w, h) => (BLOCK_BYTES[texture.blockFormat] ?? 16) * blocks(w, h)),
    texels: sum(({ channels, format }, w, h) => (channels === 3 ? 4 : channels) * BYTES_A_CHANNEL[format] * w * h),
  };
}

/** Parts of a texture that a PNG holds: four channels at most. */
function splitForPng({ firstChannel, channels }) {
  const part = (from) => ({ firstChannel: firstChannel + from, channels: Math.min(channels - from, 4) });
  return Array.from({ length: Math.ceil(channels / 4) }, (_, i) => part(4 * i));
}

/** The textures of mip 0 as PNG files of 8 bits: what they are at rest. @returns bytes of all. */
export async function measurePng(set, decoder) {
  const texels = await decoder.decodeMip(0);
  let sum = 0;
  for (const part of set.textures.flatMap(splitForPng))
    sum += (await encodePng(toBytes(texels, part), set.width, set.height, part.channels)).size;
  return sum;
}
