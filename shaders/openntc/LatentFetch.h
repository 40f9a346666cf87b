// SPDX-License-Identifier: MIT
// How shaders read the latents of generations 2 and 3: values of NTC_LATENT_FETCH.
//
//   NTC_LATENTS_BUFFER    a byte buffer, filtered by LatentMips.h: the same bits on every device
//   NTC_LATENTS_TEXTURE   an array texture of 4-bit texels, filtered by the device as LibNTC 0.8 and 0.9 do:
//                         fewer loads and less arithmetic, and results that depend on the precision of the
//                         device's weights. Texels outside of a mip wrap; slices are not for textures
//
// The texture (inference/LatentTextures.h has its size and the copies from the bytes of ReadLatents): level n
// is latent mip n, layer l has features 4 l ... 4 l + 3 in bits 0 ... 15 of a texel. Its format is
// VK_FORMAT_A4R4G4B4_UNORM_PACK16, which is DXGI_FORMAT_B4G4R4A4_UNORM; where a device lacks it
// VK_FORMAT_B4G4R4A4_UNORM_PACK16, which every one has, through a view with the components r = G, g = R,
// b = A, a = B. Sampler: linear, repeating, levels nearest.
//
// GLSL: `ntcLatentTexture`, a sampler2DArray, is declared in the place of the latents' storage buffer. An
// engine's own binding, always in HLSL: before the first include define
//   NtcSampleLatents(latents, latentsOffset, uv, layer, level)   float4 of the format's r, g, b, a
// where latents and latentsOffset are what the caller of NtcSampleTextureSet gave, such as a texture's index;
// uv is a float2, layer and level are uint.
//
// Numbers only: C++ includes this file too. Defaults and what follows from them are in Switches.h.
#ifndef OPENNTC_LATENT_FETCH_H
#define OPENNTC_LATENT_FETCH_H

#define NTC_LATENTS_BUFFER 1
#define NTC_LATENTS_TEXTURE 2

#endif
