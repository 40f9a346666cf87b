// SPDX-License-Identifier: MIT
// What webgpu_test.mjs runs in the page.
import { NtcGpuDecoder, hasPackedDot, openTextureSet } from "/openntc-webgpu.js";

async function load(path) {
  return new Uint8Array(await (await fetch(path)).arrayBuffer());
}

const toWords = (bytes) => new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);

function countDifferent(a, b) {
  if (a.length !== b.length) return Infinity;
  return a.reduce((count, value, i) => count + (value !== b[i] ? 1 : 0), 0);
}

async function start() {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return null;
  const { vendor, architecture, device, description } = adapter.info;
  return { device: await adapter.requestDevice(), hasPackedDot: hasPackedDot(), name: [vendor, architecture, device, description].filter(Boolean).join(" ") };
}

/** The picture's mip as bytes: [y][x][4]. */
async function readTexture(device, picture, mip, width, height) {
  const bytesPerRow = Math.ceil((4 * width) / 256) * 256;
  const copy = device.createBuffer({ size: bytesPerRow * height, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
  const encoder = device.createCommandEncoder();
  encoder.copyTextureToBuffer({ texture: picture, mipLevel: mip }, { buffer: copy, bytesPerRow }, [width, height]);
  device.queue.submit([encoder.finish()]);
  await copy.mapAsync(GPUMapMode.READ);
  const rows = new Uint8Array(copy.getMappedRange());
  const bytes = new Uint8Array(4 * width * height);
  for (let y = 0; y < height; y++) bytes.set(rows.subarray(y * bytesPerRow, y * bytesPerRow + 4 * width), 4 * y * width);
  copy.destroy();
  return bytes;
}

/** A texture's channels of decoded texels in 8 bits, by binary32 steps as the shader has them. */
function toBytes(texels, { firstChannel, channels }) {
  const bytes = new Uint8Array(texels.length / 4);
  for (let i = 0; i < bytes.length / 4; i++) {
    bytes.set([0, 0, 0, 255], 4 * i);
    for (let c = 0; c < channels; c++) {
      const value = Math.fround(Math.min(Math.max(texels[16 * i + firstChannel + c], 0), 1) * 255);
      bytes[4 * i + c] = Math.floor(Math.fround(value + 0.5));
    }
  }
  return bytes;
}

window.tests = {
  start: async () => {
    window.gpu = await start();
    return window.gpu && { name: gpu.name, hasPackedDot: gpu.hasPackedDot };
  },
  open: async (path) => {
    window.set = await openTextureSet(await load(path));
    return { width: set.width, height: set.height, mips: set.mips, network: set.networkName };
  },
  /** Numbers of the mips from `firstMip` that differ from the expected ones. `damaged`: of a set with a wrong weight. */
  compareBits: async (name, firstMip, packedDot, damaged) => {
    const wrong = damaged ? { ...set, weights: set.weights.map((byte, i) => (i === 0 ? byte ^ 64 : byte)) } : set;
    const decoder = await NtcGpuDecoder.create(gpu.device, wrong, { packedDot });
    let compared = 0, different = 0;
    for (let mip = firstMip; mip < set.mips; mip++) {
      const texels = await decoder.decodeMip(mip);
      different += countDifferent(toWords(texels), toWords(await load(`/expected/${name}/${mip}`)));
      compared += texels.length;
    }
    decoder.dispose();
    return { compared, different };
  },
  /** Bytes of the last texture's mips that are not the rounded numbers; or why there is no such texture. */
  compareTextures: async (name) => {
    const decoder = await NtcGpuDecoder.create(gpu.device, set);
    let compared = 0, different = 0;
    const texture = set.textures.at(-1);
    const picture = await decoder.decodeToTexture(texture).catch(({ message }) => message);
    if (typeof picture === "string") return { refusal: picture, channels: texture.channels };
    for (let mip = 0; mip < set.mips; mip++) {
      const [width, height] = decoder.getMipSize(mip);
      const bytes = await readTexture(gpu.device, picture, mip, width, height);
      const expected = await load(`/expected/${name}/${mip}`);
      different += countDifferent(bytes, toBytes(new Float32Array(expected.buffer), texture));
      compared += bytes.length;
    }
    picture.destroy();
    decoder.dispose();
    return { compared, different };
  },
  measureSpeed: async (packedDot) => {
    const decoder = await NtcGpuDecoder.create(gpu.device, set, { packedDot });
    const texels = await decoder.measureSpeed();
    decoder.dispose();
    return texels;
  },
  /** The message for a set that is too large for the device. */
  refuse: () => {
    const device = { limits: { maxStorageBufferBindingSize: 16 } };
    return NtcGpuDecoder.create(device, set).then(() => "", (error) => error.message);
  },
};
