// SPDX-License-Identifier: MIT
// PNG files of 8 bits a channel, of 1 to 4 channels: canvases have four, multiplied by alpha.

const COLOR_TYPES = { 1: 0, 2: 4, 3: 2, 4: 6 }; // grey, grey and alpha, RGB, RGBA
const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n;
});

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) crc = CRC_TABLE[(crc ^ byte) & 255] ^ (crc >>> 8);
  return ~crc >>> 0;
}

function makeChunk(type, data) {
  const chunk = new Uint8Array(data.length + 12);
  const view = new DataView(chunk.buffer);
  view.setUint32(0, data.length);
  for (let i = 0; i < 4; i++) chunk[4 + i] = type.charCodeAt(i);
  chunk.set(data, 8);
  view.setUint32(data.length + 8, crc32(chunk.subarray(4, data.length + 8)));
  return chunk;
}

function paeth(a, b, c) {
  const pa = Math.abs(b - c), pb = Math.abs(a - c), pc = Math.abs(a + b - 2 * c);
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/** Predictions of a byte by its neighbours left, above, above left. */
const PREDICTORS = [() => 0, (a) => a, (a, b) => b, (a, b) => (a + b) >> 1, paeth];

/** Each row with the filter whose bytes, as signed numbers, have the smallest sum: what libpng does. */
function filterRows(pixels, rowBytes, height, step) {
  const filtered = new Uint8Array((rowBytes + 1) * height);
  const trial = new Uint8Array(rowBytes);
  for (let y = 0; y < height; y++) {
    const at = y * rowBytes;
    let least = Infinity;
    for (let type = 0; type < 5; type++) {
      const predict = PREDICTORS[type];
      let sum = 0;
      for (let x = 0; x < rowBytes; x++) {
        const a = x >= step ? pixels[at + x - step] : 0;
        const b = y > 0 ? pixels[at + x - rowBytes] : 0;
        const c = x >= step && y > 0 ? pixels[at + x - rowBytes - step] : 0;
        const rest = (pixels[at + x] - predict(a, b, c)) & 255;
        trial[x] = rest;
        sum += rest < 128 ? rest : 256 - rest;
      }
      if (sum >= least) continue;
      least = sum;
      filtered[y * (rowBytes + 1)] = type;
      filtered.set(trial, y * (rowBytes + 1) + 1);
    }
  }
  return filtered;
}

async function compress(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate")); // zlib's format
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {Uint8Array} pixels [y][x][channels]. @returns {Promise<Blob>} @throws {Error} channels that no PNG has. */
export async function encodePng(pixels, width, height, channels) {
  if (COLOR_TYPES[channels] === undefined) throw new Error(`${channels} channels: a PNG has 1 ... 4`);
  const header = new Uint8Array(13);
  const view = new DataView(header.buffer);
  view.setUint32(0, width);
  view.setUint32(4, height);
  header.set([8, COLOR_TYPES[channels]], 8);
  const data = await compress(filterRows(pixels, width * channels, height, channels));
  const signature = Uint8Array.of(0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a);
  const chunks = [makeChunk("IHDR", header), makeChunk("IDAT", data), makeChunk("IEND", new Uint8Array())];
  return new Blob([signature, ...chunks], { type: "image/png" });
}

/** A texture of decoded texels ([16] each) in 8 bits, as `ntc decode` writes it. */
export function toBytes(texels, texture) {
  const count = texels.length / 16;
  const { firstChannel, channels } = texture;
  const pixels = new Uint8Array(count * channels);
  for (let i = 0; i < count; i++)
    for (let c = 0; c < channels; c++)
      pixels[i * channels + c] = Math.round(Math.min(Math.max(texels[16 * i + firstChannel + c], 0), 1) * 255);
  return pixels;
}
