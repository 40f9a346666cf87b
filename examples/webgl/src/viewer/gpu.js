// SPDX-License-Identifier: MIT
// WebGPU where the browser has it: it decodes whole textures, the picture stays WebGL's.
import { NtcGpuDecoder } from "../../../webgpu/src/decoder.js";

let starting = null;

async function start() {
  const adapter = await navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
  if (!adapter) return null;
  const { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
  const device = await adapter.requestDevice({ requiredLimits: { maxStorageBufferBindingSize, maxBufferSize } });
  device.lost.then(() => (starting = null)); // the next set asks again
  return { device, isSoftware: adapter.info.isFallbackAdapter === true };
}

/**
 * @param {"auto" | "webgl" | "webgpu"} wanted "auto": not on processors, where WebGL's drivers are faster.
 * @returns {Promise<NtcGpuDecoder | null>} null where WebGL is to decode.
 * @throws {Error} why there is none although it is wanted.
 */
export async function makeGpuDecoder(set, wanted) {
  if (wanted === "webgl") return null;
  try {
    starting ??= start();
    const gpu = await starting;
    if (!gpu) throw new Error("this browser has no adapter");
    return wanted === "auto" && gpu.isSoftware ? null : await NtcGpuDecoder.create(gpu.device, set);
  } catch (error) {
    if (wanted === "auto") return null;
    throw new Error(`WebGPU: ${error.message}; WebGL 2 decodes`);
  }
}
