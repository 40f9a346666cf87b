// SPDX-License-Identifier: MIT
// What passes on cooperative matrices read, in the place of Buffers.h's declarations: set 0, binding 1
// latents, a buffer or with NTC_LATENT_FETCH a texture, and binding 2 the weights of
// inference/CooperativeMatrices.h. Include before Inference.h.
#ifndef OPENNTC_MATRIX_BUFFERS_H
#define OPENNTC_MATRIX_BUFFERS_H

#include "openntc/LatentFetch.h"

#define NTC_DECODES_BLOCKS 1
#define NTC_COOPMAT_WEIGHTS gWeights.vectors
#define NtcBuffer uint
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
layout(set = 0, binding = 1) uniform sampler2DArray gLatents;
#define NtcSampleLatents(latents, latentsOffset, uv, layer, level)                                           \
    textureLod(gLatents, vec3(uv, float(layer)), float(level))
#define NtcBufferLoad(buffer, byteOffset) 0u // of code that is never called
#else
layout(set = 0, binding = 1, std430) readonly buffer Latents {
    uint words[];
}
gLatents;
#define NtcBufferLoad(buffer, byteOffset) gLatents.words[(byteOffset) >> 2]
#endif
layout(set = 0, binding = 2, std430) readonly buffer Weights {
    uvec4 vectors[];
}
gWeights;

#endif
