// SPDX-License-Identifier: MIT
// What an application of one's own takes: openntc-three.js is this, built.
export { openTextureSet } from "./reader.js";
export { NtcTextures, channelOf, KERNELS } from "./textures.js";
export { makeNtcMaterial } from "./material.js";
export { guessRoles, namesOfRoles } from "./roles.js";
export { NtcDecoder } from "./decode.js";
