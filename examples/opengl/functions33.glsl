// SPDX-License-Identifier: MIT
// The decoder for OpenGL 3.3, which has no storage buffers: latents and weights are words of R32UI textures, 1024 a row. `precise`
// came with OpenGL 4.0, so a uniform that is zero keeps roundings apart (openntc/Portability.h).
#define NTC_NO_LOOP_ATTRIBUTES
#define NTC_NO_PRECISE
#define NTC_OPAQUE_ZERO ntcZero
uniform uint ntcZero;
#define NtcBuffer usampler2D
#define NtcBufferLoad(buffer, byteOffset) texelFetch(buffer, ivec2(int((byteOffset) >> 2) & 1023, int((byteOffset) >> 12)), 0).x
#include "openntc/Inference.h"

/// All channels of a texel, in storage colour space; false where there is no such texel.
bool SampleMaterial(NtcTextureSetConstants desc, usampler2D latents, usampler2D weights, ivec2 texel, int mip,
                    out float channels[NTC_MAX_CHANNELS]) {
    return NtcSampleTextureSet(desc, latents, 0u, weights, 0u, texel, mip, false, channels);
}
