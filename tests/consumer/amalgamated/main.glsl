// SPDX-License-Identifier: MIT
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform Constants { NtcTextureSetConstants desc; };
layout(binding = 3, rgba8) writeonly uniform image2D result;

void main() {
    int2 texel = int2(gl_GlobalInvocationID.xy);
    uint random = NtcStfRandomHashed(texel, 0u, 0u, 1u).x;
    float outputs[NTC_MAX_CHANNELS];
    if (NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel + int2(random & 1u), 0, false, outputs))
        imageStore(result, texel, float4(outputs[0], outputs[1], outputs[2], 1.0));
}
