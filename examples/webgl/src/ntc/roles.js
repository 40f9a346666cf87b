// SPDX-License-Identifier: MIT
// What a texture is for, by its name: materials of the metallic-roughness model.

const PACKED = [
  { word: /(^|[^a-z])(orm|arm)([^a-z]|$)|occlusionroughnessmetal/, roles: ["occlusion", "roughness", "metalness"] },
  { word: /(^|[^a-z])(rma)([^a-z]|$)/, roles: ["roughness", "metalness", "occlusion"] },
  { word: /(metal\w*rough|metallicroughness)/, roles: [null, "roughness", "metalness"] }, // glTF: green and blue
];
const SINGLE = [
  { word: /normal|(^|[^a-z])nrm/, role: "normal", channels: [2, 3] },
  { word: /emissi/, role: "emissive", channels: [3, 4] },
  { word: /base.?colou?r|albedo|diffuse|colou?r/, role: "baseColor", channels: [3, 4] },
  { word: /rough/, role: "roughness", channels: [1, 4] },
  { word: /metal/, role: "metalness", channels: [1, 4] },
  { word: /occlusion|(^|[^a-z])ao([^a-z]|$)/, role: "occlusion", channels: [1, 4] },
  { word: /opacity|alpha|mask/, role: "opacity", channels: [1, 1] },
];

/**
 * @param textures of openTextureSet.
 * @returns {object} role to first channel: baseColor, normal, emissive (3 channels), roughness, metalness, occlusion, opacity.
 *   normalChannels is 2 where z is to be computed.
 */
export function guessRoles(textures) {
  const roles = {};
  const take = (role, channel) => {
    if (role !== null && roles[role] === undefined) roles[role] = channel;
  };
  for (const { name, firstChannel, channels } of textures) {
    const lower = name.toLowerCase();
    const packed = PACKED.find(({ word }) => word.test(lower));
    if (packed && channels >= 3) {
      packed.roles.forEach((role, i) => take(role, firstChannel + i));
      continue;
    }
    const single = SINGLE.find(({ word, channels: [least, most] }) => word.test(lower) && channels >= least && channels <= most);
    if (!single) continue;
    take(single.role, firstChannel);
    if (single.role === "normal") roles.normalChannels = channels;
    if (single.role === "baseColor" && channels === 4) take("opacity", firstChannel + 3);
  }
  return roles;
}
