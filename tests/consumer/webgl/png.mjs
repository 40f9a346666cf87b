// SPDX-License-Identifier: MIT
import assert from "node:assert/strict";
import { inflateSync } from "node:zlib";

/** A PNG of 8 bits as the specification reads it: every chunk's length, header, and rows after undoing their filters. */
export function decodePng(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  assert.deepEqual([...bytes.subarray(0, 8)], [137, 80, 78, 71, 13, 10, 26, 10]);
  const chunks = {};
  let at = 8;
  for (; at < bytes.length; at += 12 + view.getUint32(at)) {
    const type = String.fromCharCode(...bytes.subarray(at + 4, at + 8));
    chunks[type] = Buffer.concat([chunks[type] ?? Buffer.alloc(0), bytes.subarray(at + 8, at + 8 + view.getUint32(at))]);
  }
  assert.equal(at, bytes.length);
  assert.deepEqual(Object.keys(chunks), ["IHDR", "IDAT", "IEND"]);
  const header = new DataView(chunks.IHDR.buffer, chunks.IHDR.byteOffset, chunks.IHDR.length);
  const [width, height] = [header.getUint32(0), header.getUint32(4)];
  const step = { 0: 1, 4: 2, 2: 3, 6: 4 }[chunks.IHDR[9]];
  const rows = inflateSync(chunks.IDAT);
  const stride = width * step;
  assert.equal(rows.length, (stride + 1) * height);
  const pixels = new Uint8Array(stride * height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < stride; x++) {
      const a = x >= step ? pixels[y * stride + x - step] : 0;
      const b = y > 0 ? pixels[(y - 1) * stride + x] : 0;
      const c = x >= step && y > 0 ? pixels[(y - 1) * stride + x - step] : 0;
      const p = a + b - c;
      const near = [a, b, c].reduce((best, v) => (Math.abs(p - v) < Math.abs(p - best) ? v : best));
      const prediction = [0, a, b, (a + b) >> 1, near][rows[y * (stride + 1)]];
      pixels[y * stride + x] = rows[y * (stride + 1) + 1 + x] + prediction;
    }
  return { width, height, channels: step, pixels };
}
