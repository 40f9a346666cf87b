// SPDX-License-Identifier: MIT
// Compute pass: the HLSL twin of DecompressToTextures.comp, same resources and results. Entry point main.
//
// glslangValidator: -D -S comp -e main -DNTC_HLSL=1 --no-storage-format, for vulkan1.1. DXC: -T cs_6_4
// -E main -spirv. Registers: b0 constants, t1 latents, t2 weights, u0 ... textures in space1.
#ifndef NTC_SINGLE_MIP
#define NTC_SINGLE_MIP 1
#endif
#ifndef NTC_LINEARISE
#define NTC_LINEARISE 0
#endif
#ifndef NTC_CLAMP_TEXELS
#define NTC_CLAMP_TEXELS 0
#endif
#include "openntc/Inference.h"
#include "DecompressTexel.h"

#if NTC_SINGLE_MIP != 1
#error NTC_SINGLE_MIP must be 1: the constants are those of one mip
#endif
#if defined(NTC_DECOMPRESS_IMAGES)
#define NTC_DECOMPRESS_ARRAY NTC_DECOMPRESS_IMAGES
#else
#define NTC_DECOMPRESS_ARRAY NTC_DECOMPRESS_OUTPUTS
#endif

[[vk::binding(0, 0)]] cbuffer Constants : register(b0) {
    NtcDecompressConstants gPass;
};
[[vk::binding(1, 0)]] ByteAddressBuffer gLatents : register(t1);
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);
#if defined(__hlsl_dx_compiler)
[[vk::image_format("unknown")]]
#endif
[[vk::binding(0, 1)]] RWTexture2D<float4> gImages[NTC_DECOMPRESS_ARRAY] : register(u0, space1);

void writeTexel(int2 place, float outputs[NTC_MAX_CHANNELS]) {
    if (place.x >= gPass.width || place.y >= gPass.height)
        return;
    int2 source = int2(gPass.left, gPass.top) + place;
    int2 destination = int2(gPass.destinationLeft, gPass.destinationTop) + place;
    NTC_LOOP for (int i = 0; i < gPass.outputCount; i++) {
        NtcDecompressOutput o = gPass.outputs[i];
#if !NTC_DECOMPRESS_CONVERT
        if (NtcIsConverted(o, gPass.desc.channelColorSpaces))
            continue; // this shader cannot, and nothing is better than wrong texels
#endif
        float4 texel =
            NtcMakeOutputTexel(o, gPass.desc.channelColorSpaces, outputs, source, gPass.desc.imageWidth);
#if defined(NTC_DECOMPRESS_IMAGES)
        gImages[o.image][destination] = texel;
#else
        NTC_UNROLL for (int n = 0; n < NTC_DECOMPRESS_OUTPUTS; n++) {
            if (n == i) // an index that is known when the shader is compiled
                gImages[n][destination] = texel;
        }
#endif
    }
}

// The texel to decode: lanes beyond the rectangle stay with the others and decode its last column or row.
int2 getTexel(int2 place) {
    return int2(gPass.left, gPass.top) + min(place, int2(gPass.width - 1, gPass.height - 1));
}

[numthreads(NTC_DECOMPRESS_GROUP_WIDTH, NTC_DECOMPRESS_GROUP_HEIGHT, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    int2 place = int2(id.xy);
#if NTC_TEXELS_PER_INVOCATION > 1
    place.x *= NTC_TEXELS_PER_INVOCATION;
    int2 texels[NTC_TEXELS_PER_INVOCATION];
    NTC_UNROLL for (int t = 0; t < NTC_TEXELS_PER_INVOCATION; t++) texels[t] = getTexel(place + int2(t, 0));
    float all[NTC_TEXELS_OUTPUTS];
    NTC_UNROLL for (int z = 0; z < NTC_TEXELS_OUTPUTS; z++) all[z] = 0.0f;
    if (!NtcSampleTextureSetTexels(gPass.desc, gLatents, 0u, gWeights, 0u, texels, 0, false, all))
        return;
    NTC_UNROLL for (int n = 0; n < NTC_TEXELS_PER_INVOCATION; n++) {
        float outputs[NTC_MAX_CHANNELS];
        NTC_UNROLL for (int c = 0; c < NTC_MAX_CHANNELS; c++) outputs[c] = all[NTC_MAX_CHANNELS * n + c];
        writeTexel(place + int2(n, 0), outputs);
    }
#else
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0f;
    if (NtcSampleTextureSet(gPass.desc, gLatents, 0u, gWeights, 0u, getTexel(place), 0, false, outputs))
        writeTexel(place, outputs);
#endif
}
