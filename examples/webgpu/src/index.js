// SPDX-License-Identifier: MIT
// What an application of one's own takes: openntc-webgpu.js is this, built.
export { openTextureSet } from "../../webgl/src/ntc/reader.js";
export { NtcGpuDecoder, hasPackedDot } from "./decoder.js";
