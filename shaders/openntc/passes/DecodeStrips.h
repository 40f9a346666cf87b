// SPDX-License-Identifier: MIT
// Passes that decode a rectangle on cooperative matrices: its blocks of 8 x 4 texels, one a subgroup, and
// the network's inputs of a lane's texel. Include after NetworkCoopMat.h.
#ifndef OPENNTC_DECODE_STRIPS_H
#define OPENNTC_DECODE_STRIPS_H

#include "openntc/InputsInt8.h"
#include "openntc/NetworkCoopMat.h"

uvec2 gNtcBlock; // the subgroup's block: its first texel in the rectangle

/// The lane's texel of the block, in the rectangle or beyond it.
uvec2 NtcGetBlockTexel(uint lane) {
    return gNtcBlock + uvec2(lane & 7u, lane >> 3);
}

#if NTC_LATENT_FETCH == NTC_LATENTS_BUFFER
NtcAxisTaps NtcUnpackTaps(uint pixels, uint fraction) {
    NtcAxisTaps taps;
    taps.first = int(pixels & 0xFFFFu);
    taps.second = int(pixels >> 16);
    taps.fraction = uintBitsToFloat(fraction);
    return taps;
}
uint NtcPackTaps(NtcAxisTaps taps) {
    return uint(taps.first) | (uint(taps.second) << 16); // both are below 2^16
}
#endif

/// The axis inputs that another lane has made.
NtcAxisInputs NtcReadAxisInputs(NtcAxisInputs own, uint lane) {
    NtcAxisInputs inputs;
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
    inputs.coordinate = uintBitsToFloat(NtcReadLane(floatBitsToUint(own.coordinate), lane));
#else
    inputs.highRes = NtcUnpackTaps(NtcReadLane(NtcPackTaps(own.highRes), lane),
                                   NtcReadLane(floatBitsToUint(own.highRes.fraction), lane));
    inputs.lowRes = NtcUnpackTaps(NtcReadLane(NtcPackTaps(own.lowRes), lane),
                                  NtcReadLane(floatBitsToUint(own.lowRes.fraction), lane));
#endif
    uint both = NtcReadLane(own.waves[0] | (own.waves[1] << 8), lane);
    inputs.waves[0] = both & 0x00FF00FFu;
    inputs.waves[1] = (both >> 8) & 0x00FF00FFu;
    inputs.waves[2] = NtcReadLane(own.waves[2], lane);
    return inputs;
}

/// Calls NTC_DECODE_BLOCK(inputs), a function that is defined before, for all blocks of the workgroup's
/// subgroups, with all lanes; gNtcBlock says which one. left, top: of the rectangle in the mip. Beyond the
/// rectangle lanes have the inputs of its last column or row. Nothing where the mip's latents are missing.
void NtcDecodeStrips(NtcMip mip, int left, int top, uint width, uint height) {
    if (!NtcHasInputs(mip)) // alike for all
        return;
    uint across = (width + 7u) / 8u;
    uint down = (height + 3u) / 4u;
    uint subgroups = gl_NumWorkGroups.x * uint(NTC_COOPMAT_SUBGROUPS);
    // A subgroup takes up to eight blocks, one below the other: they share their columns, and a lane has made
    // one of their rows. Fewer where there would be nothing for some subgroups.
    uint turns = clamp(across * down / subgroups, 1u, 8u);
    uint strips = across * ((down + turns - 1u) / turns);
    uint lane = NtcGetLane();
    for (uint strip = gl_WorkGroupID.x * uint(NTC_COOPMAT_SUBGROUPS) + NtcGetSubgroup(); strip < strips;
         strip += subgroups) {
        gNtcBlock = uvec2(8u * (strip % across), 4u * turns * (strip / across));
        uint x = min(gNtcBlock.x + (lane & 7u), width - 1u);
        uint y = min(gNtcBlock.y + lane, height - 1u);
        NtcAxisInputs column = NtcMakeAxisInputs(NETWORK_VERSION, mip, left + int(x), 0u);
        NtcAxisInputs ownRow = NtcMakeAxisInputs(NETWORK_VERSION, mip, top + int(y), 1u);
        for (uint turn = 0u; turn < turns && gNtcBlock.y < height; turn++) {
            NtcAxisInputs row = NtcReadAxisInputs(ownRow, 4u * turn + (lane >> 3));
            uint inputs[NTC_MAX_INPUT_WORDS];
            [[unroll]] for (uint i = 0u; i < uint(NTC_MAX_INPUT_WORDS); i++) inputs[i] = 0u;
            NtcCombineAxisInputs(NETWORK_VERSION, mip, 0u, 0u, column, row, inputs);
            NTC_DECODE_BLOCK(inputs);
            gNtcBlock.y += 4u;
        }
    }
}

#endif
