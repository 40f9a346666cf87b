// SPDX-License-Identifier: MIT
// Texels of a mip as numbers: all 16 outputs of the network, with the bits of the CPU decoders.
import { FloatType, GLSL3, NearestFilter, ShaderMaterial, WebGLRenderTarget } from "three";
import { FullScreenPass } from "./pass.js";

const FRAGMENT = `
layout(location = 0) out vec4 channels0;
layout(location = 1) out vec4 channels4;
layout(location = 2) out vec4 channels8;
layout(location = 3) out vec4 channels12;
uniform ivec2 ntcOrigin;
uniform int ntcDecodedMip;
void main() {
  float c[16];
  if (!NtcReadTexel(ivec2(gl_FragCoord.xy) + ntcOrigin, ntcDecodedMip, false, c))
    discard;
  channels0 = vec4(c[0], c[1], c[2], c[3]);
  channels4 = vec4(c[4], c[5], c[6], c[7]);
  channels8 = vec4(c[8], c[9], c[10], c[11]);
  channels12 = vec4(c[12], c[13], c[14], c[15]);
}`;
const ROWS_AT_A_TIME = 64;
const SPEED_SIDE = 512;

function makeTarget(width, height) {
  return new WebGLRenderTarget(width, height, {
    count: 4, type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
  });
}

export class NtcDecoder {
  constructor(renderer, textures) {
    this.renderer = renderer;
    this.set = textures.set;
    this.uniforms = { ...textures.uniforms, ntcOrigin: { value: [0, 0] }, ntcDecodedMip: { value: 0 } };
    this.pass = new FullScreenPass(
      new ShaderMaterial({
        glslVersion: GLSL3,
        uniforms: this.uniforms,
        vertexShader: FullScreenPass.VERTEX,
        fragmentShader: textures.functions + FRAGMENT,
        depthTest: false,
      }),
    );
  }

  get name() {
    return "WebGL 2";
  }

  draw(target, mip, x, y) {
    this.uniforms.ntcOrigin.value = [x, y];
    this.uniforms.ntcDecodedMip.value = mip;
    this.pass.render(this.renderer, target);
  }

  /** Texels x … x + width - 1, y … y + height - 1 of a mip: [y][x][16]. */
  decode(mip, x, y, width, height) {
    const target = makeTarget(width, height);
    this.draw(target, mip, x, y);
    const four = new Float32Array(width * height * 4);
    const all = new Float32Array(width * height * 16);
    for (let i = 0; i < 4; i++) {
      this.renderer.readRenderTargetPixels(target, 0, 0, width, height, four, undefined, i);
      for (let texel = 0; texel < width * height; texel++)
        all.set(four.subarray(4 * texel, 4 * texel + 4), 16 * texel + 4 * i);
    }
    target.dispose();
    return all;
  }

  /** A whole mip, some rows at a time so that the page stays alive. `onRows(y, rows, texels)` instead of the return value, if given. */
  async decodeMip(mip, onRows) {
    const width = Math.max(this.set.width >> mip, 1);
    const height = Math.max(this.set.height >> mip, 1);
    const all = onRows ? null : new Float32Array(width * height * 16);
    for (let y = 0; y < height; y += ROWS_AT_A_TIME) {
      const rows = Math.min(ROWS_AT_A_TIME, height - y);
      const texels = this.decode(mip, 0, y, width, rows);
      if (onRows) onRows(y, rows, texels);
      else all.set(texels, y * width * 16);
      await new Promise((resume) => setTimeout(resume));
    }
    return all;
  }

  /** Texels a second, with all 16 outputs written: part of mip 0, as often as half a second or more takes. */
  async measureSpeed() {
    const [width, height] = [this.set.width, this.set.height].map((side) => Math.min(side, SPEED_SIDE));
    const target = makeTarget(width, height);
    const pixel = new Float32Array(4);
    const measure = (count) => {
      const begin = performance.now();
      for (let i = 0; i < count; i++) this.draw(target, 0, 0, 0);
      this.renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel); // waits for all
      return (performance.now() - begin) / 1000;
    };
    measure(1); // compiles
    let count = 1;
    let seconds = measure(count);
    while (seconds < 0.5) {
      await new Promise((resume) => setTimeout(resume));
      count *= 2;
      seconds = measure(count);
    }
    target.dispose();
    return (count * width * height) / seconds;
  }

  dispose() {
    this.pass.dispose();
  }
}
