// SPDX-License-Identifier: MIT

/** Some of the outputs of each texel to a picture, rounded to 8 bits as a PNG of them would be. */
export const PICK_SHADER = `
struct Pick { top: u32, width: u32, height: u32, first: u32, count: u32 }
@group(0) @binding(0) var<storage, read> texels: array<f32>;
@group(0) @binding(1) var<uniform> pick: Pick;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= pick.width || id.y >= pick.height) {
    return;
  }
  let first = (id.y * pick.width + id.x) * 16u + pick.first;
  var color = vec4f(0.0, 0.0, 0.0, 1.0);
  for (var i = 0u; i < pick.count; i++) {
    color[i] = floor(clamp(texels[first + i], 0.0, 1.0) * 255.0 + 0.5) / 255.0;
  }
  textureStore(picture, vec2u(id.x, pick.top + id.y), color);
}`;
