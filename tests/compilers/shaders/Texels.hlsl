// SPDX-License-Identifier: MIT
// 16 numbers for every texel of a mip, for compilers whose output is run or looked at. Resources by slot, in D3D and in SPIR-V:
// 0 constants, 1 latents, 2 weights, 3 results, 4 what to decode.
//   TEXELS_ATTRIBUTES   the language has [[vk::binding]]
//   TEXELS_WORDS        buffers are arrays of words: WGSL has no others
//   TEXELS_OPAQUE       roundings are kept by a number that the compiler does not know
#if defined(TEXELS_ATTRIBUTES)
#define AT(slot) [[vk::binding(slot, 0)]]
#else
#define AT(slot)
#endif

AT(4) cbuffer Texels : register(b4) {
    uint gWidth;
    uint gHeight;
    int gMip;
    uint gZero;
};
#if defined(TEXELS_OPAQUE)
#define NTC_OPAQUE_ZERO gZero
#endif
#if defined(TEXELS_WORDS)
#define NtcBuffer StructuredBuffer<uint>
#define NtcBufferLoad(buffer, byteOffset) (buffer)[(byteOffset) >> 2]
#endif
#include "openntc/Inference.h"

AT(0) cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
#if defined(TEXELS_WORDS)
AT(1) StructuredBuffer<uint> gLatents : register(t1);
AT(2) StructuredBuffer<uint> gWeights : register(t2);
AT(3) RWStructuredBuffer<uint> gResults : register(u3);
#else
AT(1) ByteAddressBuffer gLatents : register(t1);
AT(2) ByteAddressBuffer gWeights : register(t2);
AT(3) RWByteAddressBuffer gResults : register(u3);
#endif

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    if (id.x >= gWidth * gHeight)
        return;
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0f;
    int2 texel = int2(int(id.x % gWidth), int(id.x / gWidth));
    NtcSampleTextureSet(desc, gLatents, 0u, gWeights, 0u, texel, gMip, false, outputs);
    NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) {
#if defined(TEXELS_WORDS)
        gResults[id.x * uint(NTC_MAX_CHANNELS) + c] = asuint(outputs[c]);
#else
        gResults.Store(4u * (id.x * uint(NTC_MAX_CHANNELS) + c), asuint(outputs[c]));
#endif
    }
}
