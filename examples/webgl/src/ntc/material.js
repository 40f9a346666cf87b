// SPDX-License-Identifier: MIT
// MeshStandardMaterial whose textures are decoded in the fragment shader: lights, environment, fog and the rest are three.js's own.
import { DoubleSide, FrontSide, MeshStandardMaterial } from "three";
import { guessRoles } from "./roles.js";
import { channelOf } from "./textures.js";

function vectorOf(channel) {
  return `vec3(${[0, 1, 2].map((i) => channelOf("ntcTexel", channel + i)).join(", ")})`;
}

function normalText(roles) {
  const channel = (i) => channelOf("ntcTexel", roles.normal + i);
  return `
  vec3 mapN = vec3(${channel(0)}, ${channel(1)}, 0.0) * 2.0 - 1.0;
  mapN.z = ${roles.normalChannels === 2 ? "sqrt(saturate(1.0 - dot(mapN.xy, mapN.xy)))" : `${channel(2)} * 2.0 - 1.0`};
  mapN.y *= ntcNormalSign; // v runs down, green points up
  normal = normalize(tbn * mapN);`;
}

/** Chunks of three.js's shader and what stands in their place. */
function makeChunks(roles) {
  const chunks = {
    map_fragment: "NtcStfTexel ntcTexel = ntcSampleAt(vUv, true);\n",
    roughnessmap_fragment: "float roughnessFactor = roughness;\n",
    metalnessmap_fragment: "float metalnessFactor = metalness;\n",
  };
  if (roles.baseColor !== undefined) chunks.map_fragment += `diffuseColor.rgb *= ${vectorOf(roles.baseColor)};\n`;
  if (roles.opacity !== undefined) chunks.map_fragment += `if (${channelOf("ntcTexel", roles.opacity)} < 0.5) discard;\n`;
  for (const role of ["roughness", "metalness"])
    if (roles[role] !== undefined) chunks[`${role}map_fragment`] += `${role}Factor *= ${channelOf("ntcTexel", roles[role])};\n`;
  if (roles.smoothness !== undefined && roles.roughness === undefined)
    chunks.roughnessmap_fragment += `roughnessFactor *= 1.0 - ${channelOf("ntcTexel", roles.smoothness)};\n`;
  if (roles.normal !== undefined) chunks.normal_fragment_maps = normalText(roles);
  if (roles.emissive !== undefined) chunks.emissivemap_fragment = `totalEmissiveRadiance += ${vectorOf(roles.emissive)};\n`;
  if (roles.occlusion !== undefined)
    chunks.aomap_fragment = `
  float ambientOcclusion = ${channelOf("ntcTexel", roles.occlusion)};
  reflectedLight.indirectDiffuse *= ambientOcclusion;
  #if defined(USE_ENVMAP)
    reflectedLight.indirectSpecular *=
        computeSpecularOcclusion(saturate(dot(geometryNormal, geometryViewDir)), ambientOcclusion, material.roughness);
  #endif`;
  return chunks;
}

/**
 * A lit material. Texture coordinates are glTF's: v runs down from the upper edge.
 * @param {NtcTextures} textures
 * @param {object} options parameters of MeshStandardMaterial, and `roles` where the names of textures do not say them.
 */
export function makeNtcMaterial(textures, { roles = guessRoles(textures.set.textures), ...parameters } = {}) {
  const material = new MeshStandardMaterial({
    roughness: (roles.roughness ?? roles.smoothness) === undefined ? 0.7 : 1,
    metalness: roles.metalness === undefined ? 0 : 1,
    side: roles.opacity === undefined ? FrontSide : DoubleSide, // what is behind is seen through holes
    ...parameters,
  });
  const chunks = makeChunks(roles);
  material.defines.USE_UV = "";
  if (roles.normal !== undefined) material.defines.USE_NORMALMAP_TANGENTSPACE = "";
  material.userData.ntcNormalSign = { value: -1 };
  material.userData.ntcHasHoles = roles.opacity !== undefined;
  material.userData.ntcRoles = roles;
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, textures.uniforms, { ntcNormalSign: material.userData.ntcNormalSign });
    let text = shader.fragmentShader;
    for (const [chunk, replacement] of Object.entries(chunks)) {
      if (!text.includes(`#include <${chunk}>`)) throw new Error(`three.js: fragment shader without ${chunk}`);
      text = text.replace(`#include <${chunk}>`, replacement);
    }
    shader.fragmentShader = text.replace("void main() {", `${textures.functions}uniform float ntcNormalSign;\nvoid main() {`);
  };
  material.customProgramCacheKey = () => `ntc ${textures.set.network} ${textures.filterKey} ${JSON.stringify(roles)}`;
  textures.onFilterChange(() => (material.needsUpdate = true));
  return material;
}
