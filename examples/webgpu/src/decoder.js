// SPDX-License-Identifier: MIT
// Texture sets decoded by WebGPU: mips as numbers with the bits of the CPU decoders, or as textures.
import shaders from "openntc:wgsl";
import { PICK_SHADER } from "./pick.js";

const OUTPUTS = 16; // of the network, for each texel
const GROUP = 8; // texels a side, as Texels.comp has it
const TEXELS_AT_A_TIME = 1 << 18; // 16 MiB of outputs
const SPEED_SIDE = 512;
const PACKED_DOT = "fn NtcDot4Emulated(a: u32, b: u32) -> i32 {\n    return dot4I8Packed(a, b);\n}\n";

/** True if this browser's WGSL multiplies four bytes at once. */
export function hasPackedDot() {
  return navigator.gpu?.wgslLanguageFeatures?.has("packed_4x8_integer_dot_product") ?? false;
}

function makeBuffer(device, bytes, usage) {
  const buffer = device.createBuffer({ size: Math.max(16, Math.ceil(bytes.byteLength / 4) * 4), usage, mappedAtCreation: true });
  new Uint8Array(buffer.getMappedRange()).set(new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength));
  buffer.unmap();
  return buffer;
}

async function makePipeline(device, code) {
  const module = device.createShaderModule({ code });
  return device.createComputePipelineAsync({ layout: "auto", compute: { module, entryPoint: "main" } });
}

function dispatch(encoder, pipeline, device, resources, width, height) {
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  const entries = resources.map((resource, binding) => ({ binding, resource }));
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
  pass.dispatchWorkgroups(Math.ceil(width / GROUP), Math.ceil(height / GROUP));
  pass.end();
}

export class NtcGpuDecoder {
  /**
   * @param {GPUDevice} device latents and weights must fit into its maxStorageBufferBindingSize.
   * @param {object} set of openTextureSet.
   * @param {{packedDot?: boolean}} options whether to use dot4I8Packed; the bits are the same.
   * @throws {Error} one line: a limit of the device, or what it says against the shader.
   */
  static async create(device, set, { packedDot = hasPackedDot() } = {}) {
    const most = device.limits.maxStorageBufferBindingSize;
    for (const what of ["latents", "weights"])
      if (set[what].length > most) throw new Error(`${what}: ${set[what].length} bytes: at most ${most} on this device`);
    const { before, dot, after } = shaders[set.network];
    const decode = await makePipeline(device, before + (packedDot ? PACKED_DOT : dot) + after);
    return new NtcGpuDecoder(device, set, packedDot, { decode, pick: await makePipeline(device, PICK_SHADER) });
  }

  /** Use create. */
  constructor(device, set, packedDot, pipelines) {
    this.device = device;
    this.set = set;
    this.packedDot = packedDot;
    this.pipelines = pipelines;
    this.constants = makeBuffer(device, set.constants, GPUBufferUsage.UNIFORM);
    this.latents = makeBuffer(device, set.latents, GPUBufferUsage.STORAGE);
    this.weights = makeBuffer(device, set.weights, GPUBufferUsage.STORAGE);
  }

  get name() {
    return this.packedDot ? "WebGPU, dot4I8Packed" : "WebGPU";
  }

  getMipSize(mip) {
    return [this.set.width, this.set.height].map((side) => Math.max(side >> mip, 1));
  }

  /** @returns {GPUBuffer} room for the outputs of so many texels, 64 bytes each, that decodeToBuffer can fill. */
  makeTexels(count) {
    return this.device.createBuffer({ size: count * OUTPUTS * 4, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC });
  }

  /** Records: texels x … x + width - 1, y … y + height - 1 of a mip into `texels`: [y][x][16] binary32 numbers. */
  decodeToBuffer(encoder, texels, mip, x, y, width, height) {
    const part = makeBuffer(this.device, Int32Array.of(x, y, width, height, mip, 0, 0, 0), GPUBufferUsage.UNIFORM);
    const resources = [this.constants, this.latents, this.weights, texels, part].map((buffer) => ({ buffer }));
    dispatch(encoder, this.pipelines.decode, this.device, resources, width, height);
  }

  /** The same as numbers on the CPU. @returns {Promise<Float32Array>} */
  async decode(mip, x, y, width, height) {
    const { device } = this;
    const texels = this.makeTexels(width * height);
    const copy = device.createBuffer({ size: texels.size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = device.createCommandEncoder();
    this.decodeToBuffer(encoder, texels, mip, x, y, width, height);
    encoder.copyBufferToBuffer(texels, 0, copy, 0, texels.size);
    device.queue.submit([encoder.finish()]);
    await copy.mapAsync(GPUMapMode.READ);
    const all = new Float32Array(copy.getMappedRange().slice(0));
    texels.destroy();
    copy.destroy();
    return all;
  }

  /** Rows of a mip that are decoded at once: visit(y, rows). */
  async eachPart(mip, visit) {
    const [width, height] = this.getMipSize(mip);
    const most = Math.max(1, Math.floor(TEXELS_AT_A_TIME / width));
    for (let y = 0; y < height; y += most) await visit(y, Math.min(most, height - y));
  }

  /** A whole mip: [y][x][16]. `onRows(y, rows, texels)` instead of the return value, if given. */
  async decodeMip(mip, onRows) {
    const [width, height] = this.getMipSize(mip);
    const all = onRows ? null : new Float32Array(width * height * OUTPUTS);
    await this.eachPart(mip, async (y, rows) => {
      const texels = await this.decode(mip, 0, y, width, rows);
      if (onRows) onRows(y, rows, texels);
      else all.set(texels, y * width * OUTPUTS);
    });
    return all;
  }

  /**
   * A texture of the set with all its mips, 8 bits a channel, numbers as stored: a view of format rgba8unorm-srgb reads sRGB colours
   * as light. Channels that it lacks are 0, alpha 1.
   * @param {object} texture one of set.textures, of four channels at most, and not of floats, which 8 bits do not hold.
   * @returns {Promise<GPUTexture>}
   * @throws {Error} one line: what this texture has.
   */
  async decodeToTexture(texture) {
    const { device, set } = this;
    if (texture.channels > 4) throw new Error(`${texture.name}: ${texture.channels} channels: a texture has 1 ... 4`);
    if (texture.format.startsWith("FLOAT"))
      throw new Error(`${texture.name}: ${texture.format}: textures of 8 bits hold 0 ... 1; decodeToBuffer gives its numbers`);
    const picture = device.createTexture({
      size: [set.width, set.height], mipLevelCount: set.mips, format: "rgba8unorm", viewFormats: ["rgba8unorm-srgb"],
      usage: GPUTextureUsage.STORAGE_BINDING | GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_SRC,
    });
    for (let mip = 0; mip < set.mips; mip++) {
      const [width] = this.getMipSize(mip);
      const view = picture.createView({ format: "rgba8unorm", baseMipLevel: mip, mipLevelCount: 1, usage: GPUTextureUsage.STORAGE_BINDING });
      await this.eachPart(mip, async (y, rows) => {
        const encoder = device.createCommandEncoder();
        const texels = this.makeTexels(width * rows);
        this.decodeToBuffer(encoder, texels, mip, 0, y, width, rows);
        const words = Uint32Array.of(y, width, rows, texture.firstChannel, texture.channels);
        const pick = makeBuffer(device, words, GPUBufferUsage.UNIFORM);
        dispatch(encoder, this.pipelines.pick, device, [{ buffer: texels }, { buffer: pick }, view], width, rows);
        device.queue.submit([encoder.finish()]);
        texels.destroy(); // once that is done
        await device.queue.onSubmittedWorkDone();
      });
    }
    return picture;
  }

  /** Texels a second, with all 16 outputs written: part of mip 0, as often as half a second or more takes. */
  async measureSpeed() {
    const { device } = this;
    const [width, height] = this.getMipSize(0).map((side) => Math.min(side, SPEED_SIDE));
    const texels = this.makeTexels(width * height);
    const measure = async (count) => {
      const begin = performance.now();
      const encoder = device.createCommandEncoder();
      for (let i = 0; i < count; i++) this.decodeToBuffer(encoder, texels, 0, 0, 0, width, height);
      device.queue.submit([encoder.finish()]);
      await device.queue.onSubmittedWorkDone();
      return (performance.now() - begin) / 1000;
    };
    await measure(1); // the device's own compiler
    let count = 1;
    let seconds = await measure(count);
    while (seconds < 0.5) {
      count *= 2;
      seconds = await measure(count);
    }
    texels.destroy();
    return (count * width * height) / seconds;
  }

  dispose() {
    for (const buffer of [this.constants, this.latents, this.weights]) buffer.destroy();
  }
}
