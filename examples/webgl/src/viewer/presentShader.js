// SPDX-License-Identifier: MIT
// The mean to the screen: tone mapping, sRGB, and the background where nothing was drawn.
export const PRESENT_FRAGMENT = `
uniform sampler2D mean;
uniform int mode;
uniform vec2 part; // what of the mean is there, pixels
uniform vec2 size; // of the screen
varying vec2 vUv;

vec4 fetchMean(vec2 uv) {
  if (part == size)
    return texelFetch(mean, ivec2(gl_FragCoord.xy), 0);
  vec2 at = uv * part - 0.5;
  ivec2 first = ivec2(floor(at)), last = ivec2(part) - 1;
  vec2 f = fract(at);
  ivec2 low = clamp(first, ivec2(0), last), high = clamp(first + 1, ivec2(0), last);
  return mix(mix(texelFetch(mean, low, 0), texelFetch(mean, ivec2(high.x, low.y), 0), f.x),
             mix(texelFetch(mean, ivec2(low.x, high.y), 0), texelFetch(mean, high, 0), f.x), f.y);
}

void main() {
  vec4 sum = fetchMean(vUv);
  gl_FragColor = vec4(sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0), 1.0);
  if (mode == 0) {
    #include <tonemapping_fragment>
  }
  if (mode != 2) {
    #include <colorspace_fragment>
  }
  vec2 centred = (vUv - vec2(0.5, 0.45)) * vec2(size.x / size.y, 1.0);
  vec3 background = mix(vec3(0.157, 0.165, 0.184), vec3(0.071, 0.075, 0.086), smoothstep(0.0, 0.85, length(centred)));
  background += (fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5) / 255.0; // no bands
  gl_FragColor = vec4(mix(background, clamp(gl_FragColor.rgb, 0.0, 1.0), sum.a), 1.0);
}`;
