// SPDX-License-Identifier: MIT
// Compute pass: decodes a rectangle of one mip into textures of any format.
//
// Set 0: 0 NtcDecompressConstants (uniform, 448 bytes), 1 latents (a buffer, or a texture:
// openntc/LatentFetch.h), 2 weights. Set 1, binding 0: an array of 16 images, the n-th for output n of the
// dispatch. Those behind outputCount are not touched, but Vulkan wants something bound there, the first one
// for example. Constants, dispatch and key: MakeDecompressionPass
// (include/openntc/passes/DecompressionPass.h). The device needs shaderStorageImageWriteWithoutFormat.
//
// NTC_DECOMPRESS_IMAGES: the array has that many images, an output's `image` is its element, and the device
// needs shaderStorageImageArrayDynamicIndexing too.
//
// Compile per NETWORK_VERSION and NTC_MATH and, as everywhere, per NTC_OUTPUT_MASK and NTC_LATENT_SLICES if
// wanted; with NTC_DOT4_SPIRV and NTC_WIDE_WEIGHT_LOADS or NTC_WEIGHT_FETCH as the key says; and with
// NTC_DECOMPRESS_CONVERT=0 (DecompressionPass::GetOwnDefines) where no output is of another colour space than
// what is stored: outputs that are remain unwritten.
//
// On cooperative matrices (NTC_MATH_COOPMAT_INT8, NTC_MATH_COOPMAT_INT8_HALF) the weights are those of
// inference/CooperativeMatrices.h, any number of workgroups along x decodes all, and the device needs what
// passes/DecodeBlocks.comp says.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifndef NTC_SINGLE_MIP
#define NTC_SINGLE_MIP 1
#endif
#ifndef NTC_LINEARISE
#define NTC_LINEARISE 0
#endif
#ifndef NTC_CLAMP_TEXELS
#define NTC_CLAMP_TEXELS 0
#endif
#ifndef NTC_SUBGROUP_DECODES_ONE_SET
#define NTC_SUBGROUP_DECODES_ONE_SET 1
#endif
#include "openntc/MathModes.h"
#if NTC_MATH == NTC_MATH_COOPMAT_INT8 || NTC_MATH == NTC_MATH_COOPMAT_INT8_HALF
#include "MatrixBuffers.h"
#endif
#include "openntc/Inference.h"
#include "DecompressTexel.h"

#if NTC_SINGLE_MIP != 1
#error NTC_SINGLE_MIP must be 1: the constants are those of one mip
#endif

#if !NTC_WITH_COOPMAT
layout(local_size_x = NTC_DECOMPRESS_GROUP_WIDTH, local_size_y = NTC_DECOMPRESS_GROUP_HEIGHT) in;
#endif

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcDecompressConstants gPass;
};
#if defined(NTC_DECOMPRESS_IMAGES)
layout(set = 1, binding = 0) writeonly uniform image2D gImages[NTC_DECOMPRESS_IMAGES];
#else
layout(set = 1, binding = 0) writeonly uniform image2D gImages[NTC_DECOMPRESS_OUTPUTS];
#endif

#if NTC_WITH_COOPMAT
void writeTile(uint tile);
#define NTC_COOPMAT_TILE writeTile
#include "openntc/NetworkCoopMat.h"
#define NTC_DECODE_BLOCK NtcVisitNetworkCoopMat
#include "DecodeStrips.h"

layout(local_size_x = 32 * NTC_COOPMAT_SUBGROUPS) in;

uint gUnwritten = 0u; // bit n: output n would have to be converted, and nothing is better than wrong texels
uint gPlain = 0u;     // bit n: output n is four outputs of the network as they are

void storeTexel(int i, ivec2 destination, vec4 texel) {
    NTC_UNROLL for (int first = 0; first < NTC_DECOMPRESS_OUTPUTS; first += 4) {
        if ((i >> 2) == (first >> 2)) {
            NTC_UNROLL for (int n = first; n < first + 4; n++) {
                if (n == i) // an index that is known when the shader is compiled
#if defined(NTC_DECOMPRESS_IMAGES)
                    imageStore(gImages[gPass.outputs[n].image], destination, texel);
#else
                    imageStore(gImages[n], destination, texel);
#endif
            }
        }
    }
}

// 16 texels: lanes 0 ... 15 write the first of two outputs, the others the second.
void writeTile(uint tile) {
    uint lane = NtcGetLane();
    ivec2 place = ivec2(NtcGetBlockTexel(16u * tile + (lane & 15u)));
    if (place.x >= gPass.width || place.y >= gPass.height)
        return;
    ivec2 destination = ivec2(gPass.destinationLeft, gPass.destinationTop) + place;
    NTC_LOOP for (int i = int(lane >> 4); i < gPass.outputCount; i += 2) {
        if (((gUnwritten >> uint(i)) & 1u) != 0u)
            continue;
        vec4 texel;
        if (((gPlain >> uint(i)) & 1u) != 0u) {
            texel = NtcGetTileOutputs(lane & 15u, gPass.outputs[i].channels & 15u);
        } else {
            NtcDecompressOutput o = gPass.outputs[i];
            uint noise = NtcGetOutputNoise(o, ivec2(gPass.left, gPass.top) + place, gPass.desc.imageWidth);
            NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
                int channel = NtcGetOutputChannel(o, k);
                float value = NtcGetTileOutput(lane & 15u, uint(channel));
                texel[k] = NtcMakeComponent(o, gPass.desc.channelColorSpaces, k, channel, value, noise);
            }
        }
        storeTexel(i, destination, texel);
    }
}

void main() {
    NtcLoadCoopMatWeights();
    for (int i = 0; i < gPass.outputCount; i++) {
        gPlain |= NtcIsPlainOutput(gPass.outputs[i], gPass.desc.channelColorSpaces) ? 1u << uint(i) : 0u;
#if !NTC_DECOMPRESS_CONVERT
        gUnwritten |= NtcIsConverted(gPass.outputs[i], gPass.desc.channelColorSpaces) ? 1u << uint(i) : 0u;
#endif
    }
    NtcDecodeStrips(NtcGetMip(gPass.desc, 0), gPass.left, gPass.top, uint(gPass.width), uint(gPass.height));
}
#else
void writeTexel(ivec2 place, float outputs[NTC_MAX_CHANNELS]) {
    if (place.x >= gPass.width || place.y >= gPass.height)
        return;
    ivec2 source = ivec2(gPass.left, gPass.top) + place;
    ivec2 destination = ivec2(gPass.destinationLeft, gPass.destinationTop) + place;
    NTC_LOOP for (int i = 0; i < gPass.outputCount; i++) {
        NtcDecompressOutput o = gPass.outputs[i];
#if !NTC_DECOMPRESS_CONVERT
        if (NtcIsConverted(o, gPass.desc.channelColorSpaces))
            continue; // this shader cannot, and nothing is better than wrong texels
#endif
        vec4 texel =
            NtcMakeOutputTexel(o, gPass.desc.channelColorSpaces, outputs, source, gPass.desc.imageWidth);
#if defined(NTC_DECOMPRESS_IMAGES)
        imageStore(gImages[o.image], destination, texel);
#else
        NTC_UNROLL for (int n = 0; n < NTC_DECOMPRESS_OUTPUTS; n++) {
            if (n == i) // an index that is known when the shader is compiled
                imageStore(gImages[n], destination, texel);
        }
#endif
    }
}

// The texel to decode: lanes beyond the rectangle stay with the others and decode its last column or row.
ivec2 getTexel(ivec2 place) {
    return ivec2(gPass.left, gPass.top) + min(place, ivec2(gPass.width - 1, gPass.height - 1));
}

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
#if NTC_TEXELS_PER_INVOCATION > 1
    place.x *= NTC_TEXELS_PER_INVOCATION;
    ivec2 texels[NTC_TEXELS_PER_INVOCATION];
    NTC_UNROLL for (int t = 0; t < NTC_TEXELS_PER_INVOCATION; t++) texels[t] = getTexel(place + ivec2(t, 0));
    float all[NTC_TEXELS_OUTPUTS];
    if (!NtcSampleTextureSetTexels(gPass.desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texels, 0, false, all))
        return;
    NTC_UNROLL for (int t = 0; t < NTC_TEXELS_PER_INVOCATION; t++) {
        float outputs[NTC_MAX_CHANNELS];
        NTC_UNROLL for (int c = 0; c < NTC_MAX_CHANNELS; c++) outputs[c] = all[NTC_MAX_CHANNELS * t + c];
        writeTexel(place + ivec2(t, 0), outputs);
    }
#else
    float outputs[NTC_MAX_CHANNELS];
    if (NtcSampleTextureSet(gPass.desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, getTexel(place), 0, false, outputs))
        writeTexel(place, outputs);
#endif
}
#endif
