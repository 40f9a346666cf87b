// SPDX-License-Identifier: MIT
// The decoder for OpenGL 4.3: latents and weights are shader storage buffers 0 and 1, which only compute and (where the driver
// says so) fragment shaders read.
#define NTC_NO_LOOP_ATTRIBUTES
layout(std430, binding = 0) readonly buffer NtcLatentsBlock { uint words[]; } ntcLatents;
layout(std430, binding = 1) readonly buffer NtcWeightsBlock { uint words[]; } ntcWeights;
#define NtcBuffer uint
#define NtcBufferLoad(buffer, byteOffset) ((buffer) == 0u ? ntcLatents.words[(byteOffset) >> 2] : ntcWeights.words[(byteOffset) >> 2])
#include "openntc/Inference.h"

/// All channels of a texel, in storage colour space; false where there is no such texel.
bool SampleMaterial(NtcTextureSetConstants desc, ivec2 texel, int mip, out float channels[NTC_MAX_CHANNELS]) {
    return NtcSampleTextureSet(desc, 0u, 0u, 1u, 0u, texel, mip, false, channels);
}
