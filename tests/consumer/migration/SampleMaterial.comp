// SPDX-License-Identifier: MIT
// The shader calls that docs/migrating-from-libntc.md shows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, rgba8) writeonly uniform image2D result;

// Stands in the page as it is.
void DecodeTexel(int2 texel, int mip) {
    float outputs[NTC_MAX_CHANNELS];
    bool toLinear = true;
    if (NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, mip, toLinear, outputs))
        imageStore(result, texel, vec4(outputs[0], outputs[1], outputs[2], 1.0));
}

void main() {
    int2 texel = int2(gl_GlobalInvocationID.xy);
    int2 size = NtcGetTextureDimensions(desc, 0);
    uint inputs[NTC_MAX_INPUT_WORDS];
    bool isPresent = NtcPrepareNetworkInputs(desc, NTC_LATENTS, 0u, texel, 0, inputs);
    if (isPresent && NtcGetTextureMipLevels(desc) > 0 && texel.x < size.x && texel.y < size.y &&
        NtcTextureSetHasChannels(desc, NtcGetChannelMask(0, 3)) && NtcGetValidChannelMask(desc) != 0u &&
        NtcConvertColorSpace(0.5f, NTC_COLOR_SPACE_SRGB, NTC_COLOR_SPACE_HLG) > 0.0f &&
        NtcConvertChannelToLinearColorSpace(0.5f, 0, desc.channelColorSpaces) > 0.0f)
        DecodeTexel(texel, 0);
}
