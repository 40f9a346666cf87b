// SPDX-License-Identifier: MIT
// One call of a filtering function per item, in the common subset: shaders run it on a device, tests run the
// C++ build of the same source. Results are words.
#ifndef OPENNTC_TESTS_FILTER_CASES_H
#define OPENNTC_TESTS_FILTER_CASES_H

#include "openntc/StochasticFiltering.h"

#define FILTER_PCG 0u
#define FILTER_STRETCH 1u
#define FILTER_COORD 2u
#define FILTER_LOG2 3u
#define FILTER_FOOTPRINT 4u
#define FILTER_SAMPLE 5u
#define FILTER_PAIR 6u
#define FILTER_PART 7u
#define FILTER_EXACT 8u
#define FILTER_RANDOM 9u
#define FILTER_TAP 10u
#define FILTER_KINDS 11u
#define FILTER_WORDS 36

#if defined(__cplusplus)
namespace openntc {
#define FILTER_FIELD_UINT std::uint32_t
#define FILTER_FIELD_INT std::int32_t
#else
#define FILTER_FIELD_UINT uint
#define FILTER_FIELD_INT int
#endif

struct FilterItem { // 112 bytes; floats are bits
    FILTER_FIELD_UINT kind;
    FILTER_FIELD_UINT kernel;
    FILTER_FIELD_UINT mips;
    FILTER_FIELD_UINT wrapX;
    FILTER_FIELD_UINT wrapY;
    FILTER_FIELD_UINT sigma;
    FILTER_FIELD_INT radius;
    FILTER_FIELD_UINT maxAnisotropy;
    FILTER_FIELD_INT lodBias;
    FILTER_FIELD_INT width;
    FILTER_FIELD_INT height;
    FILTER_FIELD_INT levels;
    FILTER_FIELD_UINT u;
    FILTER_FIELD_UINT v;
    FILTER_FIELD_INT lod;
    FILTER_FIELD_UINT taps;
    FILTER_FIELD_UINT axisX;
    FILTER_FIELD_UINT axisY;
    FILTER_FIELD_UINT r0; // random numbers, or words of whatever is tested
    FILTER_FIELD_UINT r1;
    FILTER_FIELD_UINT r2;
    FILTER_FIELD_UINT r3;
    FILTER_FIELD_UINT dudx;
    FILTER_FIELD_UINT dvdx;
    FILTER_FIELD_UINT dudy;
    FILTER_FIELD_UINT dvdy;
    FILTER_FIELD_UINT index;
    FILTER_FIELD_UINT unused;
};

#if defined(__cplusplus)
}
#endif

NTC_NAMESPACE_BEGIN

/// A texel's value, 0 ... 1 in 24 bits; the border's is 1/4.
NTC_FUNCTION float4 FilterFetch(uint seed, NtcStfTap tap) {
    if (tap.isBorder)
        return float4(0.25f, 0.25f, 0.25f, 0.25f);
    uint4 words = NtcStfPcg4d(uint(tap.texel.x), uint(tap.texel.y), uint(tap.mip), seed);
    return float4(float(words.x >> 8) * 5.9604645e-8f, float(words.y >> 8) * 5.9604645e-8f,
                  float(words.z >> 8) * 5.9604645e-8f, float(words.w >> 8) * 5.9604645e-8f);
}

NTC_STF_DEFINE_FILTER(FilterExact, float4, uint, FilterFetch)

NTC_FUNCTION NtcStfSampler GetFilterSampler(FilterItem item) {
    NtcStfSampler settings;
    settings.kernelType = item.kernel;
    settings.mips = item.mips;
    settings.wrapX = item.wrapX;
    settings.wrapY = item.wrapY;
    settings.sigma = asfloat(item.sigma);
    settings.radius = item.radius;
    settings.maxAnisotropy = item.maxAnisotropy;
    settings.lodBias = item.lodBias;
    return settings;
}

NTC_FUNCTION NtcStfFootprint GetFilterFootprint(FilterItem item) {
    NtcStfFootprint footprint;
    footprint.lod = item.lod;
    footprint.taps = item.taps;
    footprint.axis = float2(asfloat(item.axisX), asfloat(item.axisY));
    return footprint;
}

NTC_FUNCTION void WriteFilterTap(NtcStfTap tap, int at, NTC_INOUT_ARRAY(uint, r, FILTER_WORDS)) {
    r[at] = uint(tap.texel.x);
    r[at + 1] = uint(tap.texel.y);
    r[at + 2] = uint(tap.mip);
    r[at + 3] = tap.isBorder ? 1u : 0u;
    r[at + 4] = asuint(tap.scale);
}

NTC_FUNCTION void WriteFilterAxis(NtcStfAxis axis, int size, uint wrap, int at,
                                  NTC_INOUT_ARRAY(uint, r, FILTER_WORDS)) {
    for (int k = 0; k < axis.count; k++) {
        r[at + k] = uint(NtcAddressTexel(axis.first + k, size, wrap));
        r[at + 8 + k] = uint(axis.weights[k]);
    }
}

/// Kinds that are not lookups.
NTC_FUNCTION void RunFilterNumbers(FilterItem item, NTC_INOUT_ARRAY(uint, r, FILTER_WORDS)) {
    if (item.kind == FILTER_PCG) {
        uint4 three = NtcStfPcg3d(item.r0, item.r1, item.r2);
        uint4 four = NtcStfPcg4d(item.r0, item.r1, item.r2, item.r3);
        r[0] = NtcStfPcg(item.r0);
        r[1] = three.x;
        r[2] = three.y;
        r[3] = three.z;
        r[4] = four.x;
        r[5] = four.y;
        r[6] = four.z;
        r[7] = four.w;
    } else if (item.kind == FILTER_STRETCH) {
        NtcStfDecision decision = NtcStfStretch(item.r0, item.r1);
        r[0] = decision.isTaken ? 1u : 0u;
        r[1] = decision.rest;
    } else if (item.kind == FILTER_LOG2) {
        r[0] = uint(NtcStfLog2(asfloat(item.u)));
    } else if (item.kind == FILTER_RANDOM) {
        uint4 hashed = NtcStfRandomHashed(int2(item.width, item.height), item.r0, item.index, item.r1);
        uint4 even = NtcStfRandomR2(uint4(item.r0, item.r1, item.r2, item.r3), item.index);
        uint4 noise = NtcStfWidenNoise(uint4(item.r0 & 255u, item.r1 & 255u, item.r2 & 255u, item.r3 & 255u),
                                       item.index);
        uint4 lane = NtcStfRotateLane(even, item.r0 & 127u);
        r[0] = hashed.x;
        r[1] = hashed.y;
        r[2] = hashed.z;
        r[3] = hashed.w;
        r[4] = even.x;
        r[5] = even.y;
        r[6] = even.z;
        r[7] = even.w;
        r[8] = noise.x;
        r[9] = noise.y;
        r[10] = noise.z;
        r[11] = noise.w;
        r[12] = lane.x;
        r[13] = lane.y;
    }
}

NTC_FUNCTION void RunFilterItem(FilterItem item, NTC_OUT_ARRAY(uint, r, FILTER_WORDS)) {
    for (int i = 0; i < FILTER_WORDS; i++)
        r[i] = 0u;
    RunFilterNumbers(item, r);
    NtcStfSampler settings = GetFilterSampler(item);
    NtcStfExtent extent = NtcStfMakeExtent(item.width, item.height, item.levels);
    NtcStfFootprint footprint = GetFilterFootprint(item);
    float2 uv = float2(asfloat(item.u), asfloat(item.v));
    uint4 random = uint4(item.r0, item.r1, item.r2, item.r3);
    if (item.kind == FILTER_COORD) {
        NtcTexelCoord coord = NtcGetTexelCoord(uv.x, uint(item.width), item.wrapX);
        NtcTexelCoord from = NtcGetBilinearCoord(coord);
        r[0] = uint(coord.texel);
        r[1] = coord.fraction;
        r[2] = uint(from.texel);
        r[3] = from.fraction;
        for (int k = 0; k < 4; k++)
            r[4 + k] = uint(NtcAddressTexel(from.texel + k - 1, item.width, item.wrapX));
    } else if (item.kind == FILTER_FOOTPRINT) {
        NtcStfFootprint made =
            NtcStfGetFootprint(settings, extent, float2(asfloat(item.dudx), asfloat(item.dvdx)),
                               float2(asfloat(item.dudy), asfloat(item.dvdy)));
        r[0] = uint(made.lod);
        r[1] = made.taps;
        r[2] = asuint(made.axis.x);
        r[3] = asuint(made.axis.y);
    } else if (item.kind == FILTER_SAMPLE) {
        NtcStfPlace place = NtcStfDrawPlace(settings, extent, uv, footprint, random);
        uint tap = (random.w * footprint.taps) >> 16;
        float2 at = NtcStfGetTapPlace(uv, footprint, tap);
        WriteFilterTap(NtcStfSample(settings, extent, uv, footprint, random), 0, r);
        r[5] = tap;
        r[6] = asuint(at.x);
        r[7] = asuint(at.y);
        r[8] = NtcStfGetTotal(NtcStfGetAxis(settings, place.x), uint(NTC_STF_ALL));
        r[9] = NtcStfGetTotal(NtcStfGetAxis(settings, place.y), uint(NTC_STF_ALL));
    } else if (item.kind == FILTER_PAIR) {
        NtcStfPair pair = NtcStfSamplePair(settings, extent, uv, footprint, random);
        WriteFilterTap(pair.first, 0, r);
        WriteFilterTap(pair.second, 5, r);
    } else if (item.kind == FILTER_PART) {
        uint parts = NtcStfCountParts(settings, extent, footprint);
        NtcStfPart part =
            NtcStfGetPart(settings, extent, uv, footprint, item.index < parts ? item.index : 0u);
        r[0] = uint(part.mip);
        r[1] = asuint(part.weight);
        r[2] = parts;
        r[3] = uint(part.x.count);
        WriteFilterAxis(part.x, NtcStfGetMipSize(item.width, part.mip), item.wrapX, 4, r);
        WriteFilterAxis(part.y, NtcStfGetMipSize(item.height, part.mip), item.wrapY, 20, r);
    } else if (item.kind == FILTER_EXACT) {
        float4 value = FilterExact(item.index, settings, extent, uv, footprint);
        r[0] = asuint(value.x);
        r[1] = asuint(value.y);
        r[2] = asuint(value.z);
        r[3] = asuint(value.w);
    } else if (item.kind == FILTER_TAP) {
        uint count = NtcStfGetTapCount(settings, extent, footprint);
        WriteFilterTap(NtcStfGetTap(settings, extent, uv, footprint, item.index % count), 0, r);
        r[5] = count;
    }
}

NTC_NAMESPACE_END

#endif
