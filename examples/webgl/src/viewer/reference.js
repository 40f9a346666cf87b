// SPDX-License-Identifier: MIT
// An image to compare a texture with.
import {
  FloatType, GLSL3, LinearMipmapLinearFilter, NearestFilter, RepeatWrapping, ShaderMaterial, Texture, WebGLRenderTarget,
} from "three";
import { FullScreenPass } from "../ntc/pass.js";

const COPY_FRAGMENT = `
uniform sampler2D image;
out vec4 value;
void main() {
  value = texelFetch(image, ivec2(gl_FragCoord.xy), 0);
}`;

/** The image of a file as a texture of 8-bit numbers, unchanged by colour management and alpha. */
export async function loadReference(blob, name, set) {
  let bitmap;
  try {
    bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  } catch {
    throw new Error(`${name}: no image that this browser reads`);
  }
  if (bitmap.width !== set.width || bitmap.height !== set.height)
    throw new Error(`${name}: ${bitmap.width} x ${bitmap.height}: the texture set has ${set.width} x ${set.height}`);
  const texture = new Texture(bitmap);
  Object.assign(texture, {
    flipY: false, generateMipmaps: true, minFilter: LinearMipmapLinearFilter, magFilter: NearestFilter,
    wrapS: RepeatWrapping, wrapT: RepeatWrapping, needsUpdate: true,
  });
  return { name, texture };
}

/** The image's texels, rows from the top: [y][x][4], 0 … 1. */
function readTexels(renderer, texture, width, height) {
  const pass = new FullScreenPass(
    new ShaderMaterial({
      glslVersion: GLSL3, uniforms: { image: { value: texture } }, vertexShader: FullScreenPass.VERTEX, fragmentShader: COPY_FRAGMENT,
      depthTest: false,
    }),
  );
  const target = new WebGLRenderTarget(width, height, { type: FloatType, depthBuffer: false });
  pass.render(renderer, target);
  const texels = new Float32Array(width * height * 4);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, texels);
  target.dispose();
  pass.dispose();
  return texels;
}

/** Peak signal-to-noise ratio of mip 0 of a texture, dB: numbers as stored, unrounded, over all its channels. */
export async function measurePsnr(renderer, decoder, texture, reference) {
  const { width, height } = decoder.set;
  const theirs = readTexels(renderer, reference.texture, width, height);
  let sum = 0;
  await decoder.decodeMip(0, (y, rows, texels) => {
    for (let i = 0; i < rows * width; i++)
      for (let c = 0; c < texture.channels; c++) {
        const difference = texels[16 * i + texture.firstChannel + c] - theirs[4 * (y * width + i) + c];
        sum += difference * difference;
      }
  });
  return -10 * Math.log10(sum / (width * height * texture.channels));
}
