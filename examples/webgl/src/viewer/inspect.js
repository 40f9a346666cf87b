// SPDX-License-Identifier: MIT
// A texture alone, without light: as it is, a reference image, both beside each other, or their difference.
import { DoubleSide, ShaderMaterial } from "three";

const VERTEX = `
varying vec2 vUv;
void main() {
  vUv = uv;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const FRAGMENT = `
varying vec2 vUv;
uniform ivec2 shown;       // first channel and number of channels
uniform bool asLinear;
uniform int compared;      // 0 decoded, 1 reference, 2 split, 3 difference
uniform sampler2D reference;
uniform ivec2 referenceShown;
uniform float gain;
uniform float splitAt;     // pixels from the left

float pick(NtcStfTexel texel, int channel) {
  vec4 four = channel < 4 ? texel.channels0 : channel < 8 ? texel.channels4 : channel < 12 ? texel.channels8 : texel.channels12;
  int i = channel & 3;
  return i == 0 ? four.x : i == 1 ? four.y : i == 2 ? four.z : four.w;
}

vec3 pickColor(NtcStfTexel texel) {
  float first = pick(texel, shown.x);
  if (shown.y == 1)
    return vec3(first);
  return vec3(first, pick(texel, shown.x + 1), shown.y == 2 ? 0.0 : pick(texel, shown.x + 2));
}

vec3 pickReference(vec4 value) {
  int i = referenceShown.x;
  if (referenceShown.y == 1)
    return vec3(i == 0 ? value.r : i == 1 ? value.g : i == 2 ? value.b : value.a);
  return vec3(value.rg, referenceShown.y == 2 ? 0.0 : value.b);
}

vec3 toLinear(vec3 value) {
  return mix(value / 12.92, pow((value + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), value));
}

void main() {
  vec3 ours = pickColor(ntcSampleAt(vUv, asLinear)); // derivatives: before anything diverges
  vec2 uv = vUv * ntcRepeat;
  vec4 texel = compared == 3 ? textureLod(reference, uv, float(max(ntcMip, 0))) : texture(reference, uv);
  vec3 theirs = pickReference(texel);
  if (compared == 3)
    ours = abs(ours - theirs) * gain;
  else if (compared == 1 || (compared == 2 && gl_FragCoord.x >= splitAt))
    ours = asLinear ? toLinear(theirs) : theirs;
  if (compared == 2 && abs(gl_FragCoord.x - splitAt) < 1.0)
    ours = vec3(1.0); // where one ends and the other begins
  gl_FragColor = vec4(ours, 1.0);
}`;
const COMPARISONS = ["decoded", "reference", "split", "difference"];

export class InspectMaterial extends ShaderMaterial {
  constructor(textures) {
    super({
      uniforms: {
        ...textures.uniforms,
        shown: { value: [0, 3] },
        asLinear: { value: false },
        compared: { value: 0 },
        reference: { value: null },
        referenceShown: { value: [0, 3] },
        gain: { value: 8 },
        splitAt: { value: 0 },
      },
      vertexShader: VERTEX,
      fragmentShader: textures.functions + FRAGMENT,
      side: DoubleSide,
    });
    textures.onFilterChange(() => {
      this.fragmentShader = textures.functions + FRAGMENT;
      this.needsUpdate = true;
    });
  }

  /**
   * @param texture of the set. @param {string} channel "all", or one of "rgba".
   * @param {{texture: Texture} | undefined} reference
   * @returns {"encode" | "raw"} how the result is to be presented.
   */
  show(texture, channel, { reference, comparison, gain, splitAt }) {
    const one = "rgba".indexOf(channel);
    const { uniforms } = this;
    const difference = reference && comparison === "difference";
    const isAlpha = one === 3;
    const space = isAlpha ? texture.alphaColorSpace : texture.colorSpace;
    const asLinear = !difference && (space !== "linear" || texture.format.startsWith("FLOAT"));
    uniforms.shown.value = one < 0 ? [texture.firstChannel, texture.channels] : [texture.firstChannel + one, 1];
    uniforms.referenceShown.value = one < 0 ? [0, texture.channels] : [one, 1];
    uniforms.reference.value = reference?.texture ?? null;
    uniforms.compared.value = reference ? COMPARISONS.indexOf(comparison) : 0;
    uniforms.asLinear.value = asLinear;
    uniforms.gain.value = gain;
    uniforms.splitAt.value = splitAt;
    return asLinear ? "encode" : "raw";
  }
}
