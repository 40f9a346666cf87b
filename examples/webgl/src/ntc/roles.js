// SPDX-License-Identifier: MIT
// What a texture is for, by its name: materials of the metallic-roughness model. Names as `ntc encode` knows them (docs/manifest.md).

/** Words of a name, in lower case: /…/ within it, or as a whole behind a separator. */
const behind = (words) => new RegExp(`(^|[^a-z])(${words})([^a-z]|$)`);

/** Several roles in one texture of so many channels. */
const PACKED = [
  { word: behind("orm|arm"), channels: [3, 4], roles: ["occlusion", "roughness", "metalness"] },
  { word: /occlusionroughnessmetal/, channels: [3, 4], roles: ["occlusion", "roughness", "metalness"] },
  { word: behind("rma|rmao"), channels: [3, 4], roles: ["roughness", "metalness", "occlusion"] },
  { word: behind("mra|mrao"), channels: [3, 4], roles: ["metalness", "roughness", "occlusion"] },
  { word: /metal\w*rough/, channels: [3, 4], roles: [null, "roughness", "metalness"] }, // glTF's images: green and blue
  { word: /metal\w*rough/, channels: [2, 2], roles: ["metalness", "roughness"] }, // of `ntc convert-gltf`
  { word: /metal\w*(smooth|gloss)/, channels: [4, 4], roles: ["metalness", null, null, "smoothness"] },
  { word: /metal\w*(smooth|gloss)/, channels: [2, 2], roles: ["metalness", "smoothness"] },
  { word: /specular\w*(smooth|gloss)/, channels: [4, 4], roles: [null, null, null, "smoothness"] },
  { word: /mask_?map/, channels: [4, 4], roles: ["metalness", "occlusion", null, "smoothness"] }, // Unity's HDRP
];
const OTHER = /specular|sheen|subsurface|coat|iridescence|anisotropy|height/; // of other models
const SINGLE = [
  { word: /normal/, short: "n|nm|nrm|norm", role: "normal", channels: [2, 4] },
  { word: /emissi/, short: "e|emi", role: "emissive", channels: [3, 4] },
  { word: /base.?(colou?r|map)|albedo|diffuse|colou?r|maintex/, short: "d|diff|bc|c|col|alb", role: "baseColor", channels: [3, 4] },
  { word: /smooth|gloss/, short: "", role: "smoothness", channels: [1, 4] },
  { word: /rough/, short: "r", role: "roughness", channels: [1, 4] },
  { word: /metal/, short: "m|mt|mtl", role: "metalness", channels: [1, 4] },
  { word: /occlusion/, short: "o|ao|occ", role: "occlusion", channels: [1, 4] },
  { word: /opacity|alpha|mask|transparency/, short: "a", role: "opacity", channels: [1, 1] },
];

function fits({ channels: [least, most] }, channels) {
  return channels >= least && channels <= most;
}

/** [role, channel of the texture] */
function rolesOf({ name, channels }) {
  const lower = name.toLowerCase().replace(/([_\-. ]\d+k?)+$/, ""); // T_Wall_D_01, T_Wall_D_2k
  const packed = PACKED.find((entry) => entry.word.test(lower) && fits(entry, channels));
  if (packed) return packed.roles.map((role, i) => [role, i]).filter(([role]) => role !== null);
  if (OTHER.test(lower)) return [];
  const short = /[_\-. ]([a-z]+)$/.exec(lower)?.[1] ?? "";
  const names = ({ word, short: all }) => word.test(lower) || (short !== "" && all.split("|").includes(short));
  const single = SINGLE.find((entry) => names(entry) && fits(entry, channels));
  if (!single) return [];
  return single.role === "baseColor" && channels === 4 ? [["baseColor", 0], ["opacity", 3]] : [[single.role, 0]];
}

/**
 * @param textures of openTextureSet.
 * @returns {object} role to first channel: baseColor, normal, emissive (3 channels), roughness or smoothness, metalness, occlusion,
 *   opacity. normalChannels is 2 where z is to be computed.
 */
export function guessRoles(textures) {
  const roles = {};
  for (const texture of textures)
    for (const [role, channel] of rolesOf(texture)) {
      if (roles[role] !== undefined) continue;
      roles[role] = texture.firstChannel + channel;
      if (role === "normal") roles.normalChannels = Math.min(texture.channels, 3);
    }
  return roles;
}

/** The roles that a texture has among those of guessRoles. */
export function namesOfRoles(roles, { firstChannel, channels }) {
  const isWithin = ([role, at]) => role !== "normalChannels" && at >= firstChannel && at < firstChannel + channels;
  return Object.entries(roles).filter(isWithin).map(([role]) => role);
}
