// SPDX-License-Identifier: MIT
// Frames and their running mean. A frame is drawn in bands of rows, so that no call keeps a slow device for long; while something
// moves, with fewer pixels.
import { FloatType, GLSL3, NearestFilter, ShaderMaterial, Vector2, WebGLRenderTarget } from "three";
import { FullScreenPass } from "../ntc/pass.js";
import { PRESENT_FRAGMENT } from "./presentShader.js";

const MEAN_FRAGMENT = `
uniform sampler2D frame;
uniform sampler2D before;
uniform float weight;
out vec4 mean;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 now = texelFetch(frame, at, 0);
  mean = weight >= 1.0 ? now : mix(texelFetch(before, at, 0), now, weight);
}`;
const TARGET = { type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter };

/** Part i of Halton's sequence of a base, 0 … 1. */
function halton(i, base) {
  let sum = 0;
  for (let part = 1 / base; i > 0; i = Math.floor(i / base), part /= base) sum += part * (i % base);
  return sum;
}

export class FrameAverage {
  constructor(renderer) {
    this.renderer = renderer;
    this.frame = new WebGLRenderTarget(1, 1, { ...TARGET, depthBuffer: true });
    this.means = [0, 1].map(() => new WebGLRenderTarget(1, 1, { ...TARGET, depthBuffer: false }));
    this.meanPass = new FullScreenPass(
      new ShaderMaterial({
        glslVersion: GLSL3,
        uniforms: { frame: { value: this.frame.texture }, before: { value: null }, weight: { value: 1 } },
        vertexShader: FullScreenPass.VERTEX,
        fragmentShader: MEAN_FRAGMENT,
        depthTest: false,
      }),
    );
    this.presentPass = new FullScreenPass(
      new ShaderMaterial({
        uniforms: {
          mean: { value: null }, mode: { value: 0 }, part: { value: new Vector2(1, 1) }, size: { value: new Vector2(1, 1) },
        },
        vertexShader: FullScreenPass.VERTEX,
        fragmentShader: PRESENT_FRAGMENT,
        depthTest: false,
      }),
    );
    this.width = this.height = 1;
    this.restart(1);
  }

  resize(width, height) {
    if (width === this.width && height === this.height) return;
    this.width = width;
    this.height = height;
    for (const target of [this.frame, ...this.means]) target.setSize(width, height);
    this.restart(1);
  }

  /** Forgets all frames; the next ones have `scale` of the pixels a side. */
  restart(scale) {
    this.frames = 0; // complete ones
    this.row = 0; // of the frame that is being drawn
    this.partWidth = Math.max(1, Math.round(this.width * scale));
    this.partHeight = Math.max(1, Math.round(this.height * scale));
  }

  /** Draws up to `rows` rows of the next frame; true if that completed it. @returns {{pixels: number, complete: boolean}} */
  draw(scene, camera, rows) {
    const count = Math.min(rows, this.partHeight - this.row);
    const { frame, partWidth, partHeight } = this;
    frame.viewport.set(0, 0, partWidth, partHeight);
    frame.scissor.set(0, this.row, partWidth, count);
    frame.scissorTest = true;
    const jitter = this.frames === 0 ? [0, 0] : [halton(this.frames, 2) - 0.5, halton(this.frames, 3) - 0.5];
    camera.setViewOffset(partWidth, partHeight, ...jitter, partWidth, partHeight);
    this.renderer.setRenderTarget(frame);
    this.renderer.setClearColor(0, 0);
    this.renderer.render(scene, camera);
    this.renderer.setRenderTarget(null);
    camera.clearViewOffset();
    this.row += count;
    const complete = this.row >= partHeight;
    if (complete) this.add();
    return { pixels: count * partWidth, complete };
  }

  add() {
    const [before, after] = this.means;
    const { uniforms } = this.meanPass.material;
    uniforms.before.value = before.texture;
    uniforms.weight.value = 1 / (this.frames + 1);
    this.meanPass.render(this.renderer, after);
    this.means = [after, before];
    this.frames++;
    this.row = 0;
  }

  /** Shows the mean. @param {"lit" | "encode" | "raw"} mode tone mapping and sRGB, sRGB alone, or the numbers as they are. */
  present(mode) {
    const { uniforms } = this.presentPass.material;
    uniforms.mean.value = this.means[0].texture;
    uniforms.mode.value = ["lit", "encode", "raw"].indexOf(mode);
    uniforms.part.value.set(this.partWidth, this.partHeight);
    uniforms.size.value.set(this.width, this.height);
    this.presentPass.render(this.renderer, null);
  }
}
