// SPDX-License-Identifier: MIT
// A texture set on the GPU: two textures of words, the constants, and how it is sampled. Shared by all materials of the set.
import { DataTexture, NearestFilter, RedIntegerFormat, UnsignedIntType } from "three";
import functions from "openntc:functions";
import { makeConstants } from "./constants.js";

const WORDS_PER_ROW = 1024; // as functions.glsl has it

export const KERNELS = { nearest: 0, bilinear: 1, cubic: 2, "catmull-rom": 3, mitchell: 4, gaussian: 5 };

function makeWordTexture(bytes, what, mostRows) {
  const rows = Math.max(1, Math.ceil(bytes.length / (4 * WORDS_PER_ROW)));
  if (rows > mostRows)
    throw new Error(`${what}: ${bytes.length} bytes: at most ${mostRows * WORDS_PER_ROW * 4} in a texture of this device`);
  const words = new Uint32Array(rows * WORDS_PER_ROW);
  new Uint8Array(words.buffer).set(bytes);
  const texture = new DataTexture(words, WORDS_PER_ROW, rows, RedIntegerFormat, UnsignedIntType);
  texture.internalFormat = "R32UI";
  texture.minFilter = texture.magFilter = NearestFilter; // integers have no other
  texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  return texture;
}

/** Values of NtcStfSampler (openntc/filtering/StfTypes.h). */
function makeSampling() {
  return { kernelType: 0, mips: 1, wrapX: 0, wrapY: 0, sigma: 0.6, radius: 2, maxAnisotropy: 1, lodBias: 0 };
}

export class NtcTextures {
  /** @param set of openTextureSet. @param {number} mostRows the device's largest texture (renderer.capabilities.maxTextureSize). */
  constructor(set, mostRows = 2048) {
    this.set = set;
    this.kernel = "bilinear";
    this.stochastic = true;
    this.users = [];
    const latents = makeWordTexture(set.latents, "latents", mostRows);
    const weights = makeWordTexture(set.weights, "weights", mostRows);
    this.uniforms = {
      ntcZero: { value: 0 },
      ntcDesc: { value: makeConstants(set.constants) },
      ntcLatents: { value: latents },
      ntcWeights: { value: weights },
      ntcSampling: { value: makeSampling() },
      ntcRepeat: { value: 1 },
      ntcMip: { value: -1 }, // < 0: by derivatives
      ntcFrame: { value: 0 }, // another one for every frame that is averaged
    };
  }

  /** Bytes on the GPU: what a scene pays for the set. */
  get bytes() {
    return this.set.latents.length + this.set.weights.length + this.set.constants.length;
  }

  /**
   * The decoder's functions, for the fragment shader of any material. Kernel and number of texels are constants, so that compilers
   * leave out all others: materials say by onFilterChange that they have to be compiled again.
   */
  get functions() {
    return `${functions[this.set.network]}
const uint ntcKernel = ${KERNELS[this.kernel]}u;
const bool ntcStochastic = ${this.stochastic};
uniform NtcStfSampler ntcSampling;
uniform float ntcRepeat;
uniform int ntcMip;
uniform uint ntcFrame;
NtcStfTexel ntcSampleAt(vec2 uv, bool asLinear) {
  uv *= ntcRepeat;
  NtcStfSampler sampling = ntcSampling;
  sampling.kernelType = ntcKernel;
  return NtcLookUp(sampling, ntcMip, uv, dFdx(uv), dFdy(uv), ntcStochastic, NtcDraw(uvec2(gl_FragCoord.xy), ntcFrame), asLinear);
}
`;
  }

  /**
   * @param {{kernel?: string, anisotropy?: number, mip?: number, stochastic?: boolean, repeat?: number}} filter
   * @throws {Error} a kernel that is none of KERNELS.
   */
  setFilter({ kernel, anisotropy, mip, stochastic, repeat }) {
    if (kernel !== undefined && !Object.hasOwn(KERNELS, kernel))
      throw new Error(`kernel: ${kernel}: one of ${Object.keys(KERNELS).join(", ")}`);
    const sampling = this.uniforms.ntcSampling.value;
    if (anisotropy !== undefined) sampling.maxAnisotropy = anisotropy;
    if (mip !== undefined) this.uniforms.ntcMip.value = mip;
    if (repeat !== undefined) this.uniforms.ntcRepeat.value = repeat;
    const before = this.filterKey;
    this.kernel = kernel ?? this.kernel;
    this.stochastic = stochastic ?? this.stochastic;
    sampling.mips = this.kernel === "nearest" ? 0 : 1;
    if (this.filterKey !== before) for (const recompile of this.users) recompile();
  }

  /** What `functions` depends on besides the network. */
  get filterKey() {
    return `${this.kernel} ${this.stochastic}`;
  }

  /** `recompile` is called when `functions` has changed. */
  onFilterChange(recompile) {
    this.users.push(recompile);
  }

  dispose() {
    this.uniforms.ntcLatents.value.dispose();
    this.uniforms.ntcWeights.value.dispose();
  }
}

/** A channel of an NtcStfTexel, in GLSL. */
export function channelOf(texel, channel) {
  return `${texel}.channels${channel & ~3}.${"xyzw"[channel & 3]}`;
}
