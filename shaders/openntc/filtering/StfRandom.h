// SPDX-License-Identifier: MIT
// Random numbers for stochastic lookups. A lookup takes four of 16 bits: x and y choose the texel along the
// axes, z the mip, w the anisotropic tap or the sign. All channels of a texture set, and all textures that
// share coordinates, size and filter, must be read with the same numbers: their texels belong together.
#ifndef OPENNTC_STF_RANDOM_H
#define OPENNTC_STF_RANDOM_H

#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

/// PCG's output of a word (Jarzynski and Olano 2020).
NTC_FUNCTION uint NtcStfPcg(uint value) {
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

/// Three words of three (the same authors' pcg3d); w is 0.
NTC_FUNCTION uint4 NtcStfPcg3d(uint x, uint y, uint z) {
    x = x * 1664525u + 1013904223u;
    y = y * 1664525u + 1013904223u;
    z = z * 1664525u + 1013904223u;
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x += y * z;
    y += z * x;
    z += x * y;
    return uint4(x, y, z, 0u);
}

/// Four words of four.
NTC_FUNCTION uint4 NtcStfPcg4d(uint x, uint y, uint z, uint w) {
    x = x * 1664525u + 1013904223u;
    y = y * 1664525u + 1013904223u;
    z = z * 1664525u + 1013904223u;
    w = w * 1664525u + 1013904223u;
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    w ^= w >> 16;
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    return uint4(x, y, z, w);
}

/// The numbers of a lookup out of two words.
NTC_FUNCTION uint4 NtcStfSplitWords(uint a, uint b) {
    return uint4(a >> 16, a & 0xFFFFu, b >> 16, b & 0xFFFFu);
}

/// Hashed numbers: independent from frame to frame. `lookup`: another one for every lookup of other texture
/// coordinates in a pixel, 0 ... 255; `frame` counts to 65535.
NTC_FUNCTION uint4 NtcStfRandomHashed(int2 pixel, uint frame, uint lookup, uint seed) {
    uint4 words = NtcStfPcg3d(uint(pixel.x), uint(pixel.y), frame + 65536u * (lookup + 256u * seed));
    return NtcStfSplitWords(words.x, words.y);
}

/// Numbers that fill their ranges evenly over frames: R2 (Roberts 2018) in x and y, the golden ratio in z,
/// the square root of two in w; no whole-number relation joins the four steps, so that together they fill
/// the four dimensions. `base`: four words that do not change from frame to frame, such as NtcStfPcg4d of
/// pixel, lookup and seed, or blue noise (Cranley and Patterson's rotation).
NTC_FUNCTION uint4 NtcStfRandomR2(uint4 base, uint frame) {
    return uint4((base.x + frame * 0xC13FA9A9u) >> 16, (base.y + frame * 0x91E10DA6u) >> 16,
                 (base.z + frame * 0x9E3779B9u) >> 16, (base.w + frame * 0x6A09E667u) >> 16);
}

/// R2 from lane to lane of a wave, for lanes that share texels: each rotates the numbers that all of them
/// have.
NTC_FUNCTION uint4 NtcStfRotateLane(uint4 random, uint lane) {
    return uint4((random.x + lane * 0xC140u) & 0xFFFFu, (random.y + lane * 0x91E1u) & 0xFFFFu, random.z,
                 random.w);
}

/// Numbers of 8 bits, as noise textures have them, made 16 bits wide: alone they would bias every weight by
/// up to 1/256. `hash`: any hashed word.
NTC_FUNCTION uint4 NtcStfWidenNoise(uint4 noise, uint hash) {
    return uint4((noise.x << 8) | (hash & 255u), (noise.y << 8) | ((hash >> 8) & 255u),
                 (noise.z << 8) | ((hash >> 16) & 255u), (noise.w << 8) | (hash >> 24));
}

/// A decision, and the number that is left for further ones.
struct NtcStfDecision {
    bool isTaken;
    uint rest; // 0 ... 65535
};

/// Decides with probability threshold / 65536, 1 ... 65535, by a word; what is left of it is uniform again,
/// exactly: one good number can make all decisions of a lookup.
NTC_FUNCTION NtcStfDecision NtcStfStretch(uint word, uint threshold) {
    NtcStfDecision decision;
    uint edge = threshold << 16;
    decision.isTaken = word < edge;
    decision.rest = decision.isTaken ? word / threshold : (word - edge) / (65536u - threshold);
    return decision;
}

NTC_NAMESPACE_END

#endif
