// SPDX-License-Identifier: MIT
// What the CPU decodes, and who has the same.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";

/** All outputs of texels ("mip x y") as `ntc sample` has them: [i][16]. `options`: more of its own. */
export function sampleTexels(ntc, file, texels, ...options) {
  const text = execFileSync(ntc, ["sample", file, "--texels", "-", "--csv", ...options], { input: texels.join("\n"), maxBuffer: 1 << 30 }).toString();
  const rows = text.trim().split("\n").slice(1);
  assert.equal(rows.length, texels.length);
  const values = new Float32Array(rows.length * 16); // of nine digits, which name a binary32
  rows.forEach((row, i) => values.set(row.split(",").slice(3).map(Number), 16 * i));
  return values;
}

/** The same of a whole mip: [y][x][16]. */
export function sampleMip(ntc, file, mip, width, height, ...options) {
  const texels = [];
  for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) texels.push(`${mip} ${x} ${y}`);
  return sampleTexels(ntc, file, texels, ...options);
}

export function countDifferentWords(a, b) {
  assert.equal(a.length, b.length);
  const [wa, wb] = [a, b].map((values) => new Uint32Array(values.buffer, values.byteOffset, values.length));
  return wa.reduce((count, word, i) => count + (word !== wb[i] ? 1 : 0), 0);
}
