// SPDX-License-Identifier: MIT
// The filters with all their texels: the reference of stochastic lookups, and what to use where nothing is
// averaged afterwards.
//
//   NTC_STF_DEFINE_FILTER(Name, Value, Context, Fetch)
// defines
//   Value Name(Context context, NtcStfSampler settings, NtcStfExtent extent, float2 uv,
//              NtcStfFootprint footprint)
// which calls `Value Fetch(Context context, NtcStfTap tap)` for every texel and adds. Fetch answers with the
// border's colour where tap.isBorder. Value: float, float2, float4, NtcStfTexel, or a type for which you
// write NtcStfClear and NtcStfAdd (and NtcStfReadLane for waves) like those below.
#ifndef OPENNTC_STF_MULTI_TAP_H
#define OPENNTC_STF_MULTI_TAP_H

#include "StfFootprint.h"
#include "StfKernels.h"
#include "StfSample.h"
#include "StfTypes.h"
#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

/// All 16 channels of a texture set.
struct NtcStfTexel {
    float4 channels0;
    float4 channels4;
    float4 channels8;
    float4 channels12;
};

NTC_FUNCTION float NtcStfAddProduct(float sum, float value, float weight) {
    NTC_PRECISE float next = sum + NtcMultiply(value, weight);
    return NtcKeep(next);
}

NTC_FUNCTION void NtcStfClear(NTC_OUT(float, value)) {
    value = 0.0f;
}
NTC_FUNCTION void NtcStfClear(NTC_OUT(float2, value)) {
    value = float2(0.0f, 0.0f);
}
NTC_FUNCTION void NtcStfClear(NTC_OUT(float4, value)) {
    value = float4(0.0f, 0.0f, 0.0f, 0.0f);
}
NTC_FUNCTION void NtcStfClear(NTC_OUT(NtcStfTexel, value)) {
    value.channels0 = float4(0.0f, 0.0f, 0.0f, 0.0f);
    value.channels4 = value.channels0;
    value.channels8 = value.channels0;
    value.channels12 = value.channels0;
}

/// sum += value * weight, product and sum rounded once each, so that whoever adds in the same order has the
/// same bits.
NTC_FUNCTION void NtcStfAdd(NTC_INOUT(float, sum), float value, float weight) {
    sum = NtcStfAddProduct(sum, value, weight);
}
NTC_FUNCTION void NtcStfAdd(NTC_INOUT(float2, sum), float2 value, float weight) {
    sum = float2(NtcStfAddProduct(sum.x, value.x, weight), NtcStfAddProduct(sum.y, value.y, weight));
}
NTC_FUNCTION void NtcStfAdd(NTC_INOUT(float4, sum), float4 value, float weight) {
    sum = float4(NtcStfAddProduct(sum.x, value.x, weight), NtcStfAddProduct(sum.y, value.y, weight),
                 NtcStfAddProduct(sum.z, value.z, weight), NtcStfAddProduct(sum.w, value.w, weight));
}
NTC_FUNCTION void NtcStfAdd(NTC_INOUT(NtcStfTexel, sum), NtcStfTexel value, float weight) {
    NtcStfAdd(sum.channels0, value.channels0, weight);
    NtcStfAdd(sum.channels4, value.channels4, weight);
    NtcStfAdd(sum.channels8, value.channels8, weight);
    NtcStfAdd(sum.channels12, value.channels12, weight);
}

/// A part of a lookup: one mip of one anisotropic tap.
struct NtcStfPart {
    NtcStfAxis x;
    NtcStfAxis y;
    int mip;
    float weight;
};

/// True if a lookup reads two mips.
NTC_FUNCTION bool NtcStfReadsTwoMips(NtcStfSampler settings, NtcStfExtent extent, NtcStfFootprint footprint) {
    return settings.mips == uint(NTC_MIPS_LINEAR) && footprint.lod > 0 &&
           footprint.lod < (extent.levels - 1) * 65536 && (footprint.lod & 0xFFFF) != 0;
}

/// How many parts a lookup has, 1 ... 32.
NTC_FUNCTION uint NtcStfCountParts(NtcStfSampler settings, NtcStfExtent extent, NtcStfFootprint footprint) {
    return NtcStfReadsTwoMips(settings, extent, footprint) ? 2u * footprint.taps : footprint.taps;
}

/// A part of a lookup; its weight times a tap's of x and a tap's of y is what a texel counts.
NTC_FUNCTION NtcStfPart NtcStfGetPart(NtcStfSampler settings, NtcStfExtent extent, float2 uv,
                                      NtcStfFootprint footprint, uint index) {
    bool isTwo = NtcStfReadsTwoMips(settings, extent, footprint);
    uint tap = isTwo ? index >> 1 : index;
    int mip = NtcStfDrawMip(settings, extent, footprint.lod, 0u);
    int share = 65536;
    if (isTwo) {
        int coarser = footprint.lod & 0xFFFF;
        share = (index & 1u) != 0u ? coarser : 65536 - coarser;
        mip += int(index & 1u);
    }
    NtcStfPlace place = NtcStfGetPlace(settings, extent, NtcStfGetTapPlace(uv, footprint, tap), mip);
    NtcStfPart part;
    part.x = NtcStfGetAxis(settings, place.x);
    part.y = NtcStfGetAxis(settings, place.y);
    part.mip = mip;
    // 2^-16 and 2 are exact: one rounding.
    part.weight = NtcMultiply(float(share) * 1.52587890625e-5f, 2.0f * NtcStfGetHalfStep(footprint.taps));
    return part;
}

/// How many texels a lookup reads with all its taps.
NTC_FUNCTION uint NtcStfGetTapCount(NtcStfSampler settings, NtcStfExtent extent, NtcStfFootprint footprint) {
    uint side = settings.kernelType == uint(NTC_KERNEL_NEAREST)    ? 1u
                : settings.kernelType == uint(NTC_KERNEL_BILINEAR) ? 2u
                : settings.kernelType == uint(NTC_KERNEL_GAUSSIAN)
                    ? 2u * uint(min(max(settings.radius, 1), NTC_STF_MOST_TAPS / 2))
                    : 4u;
    return side * side * NtcStfCountParts(settings, extent, footprint);
}

/// Texel `index` of a lookup with its weight as scale; weights add up to 1. For engines that gather
/// addresses first; NTC_STF_DEFINE_FILTER makes each part once.
NTC_FUNCTION NtcStfTap NtcStfGetTap(NtcStfSampler settings, NtcStfExtent extent, float2 uv,
                                    NtcStfFootprint footprint, uint index) {
    uint taps =
        NtcStfGetTapCount(settings, extent, footprint) / NtcStfCountParts(settings, extent, footprint);
    NtcStfPart part = NtcStfGetPart(settings, extent, uv, footprint, index / taps);
    int column = int(index % taps) % part.x.count;
    int row = int(index % taps) / part.x.count;
    NtcStfTap tap = NtcStfPlaceTap(settings, extent, part.x.first + column, part.y.first + row, part.mip);
    tap.scale =
        NtcMultiply(NtcMultiply(NtcStfGetWeight(part.x, column), NtcStfGetWeight(part.y, row)), part.weight);
    return tap;
}

NTC_NAMESPACE_END

#define NTC_STF_DEFINE_FILTER(Name, Value, Context, Fetch)                                                   \
    NTC_FUNCTION Value Name(Context context, NtcStfSampler settings, NtcStfExtent extent, float2 uv,         \
                            NtcStfFootprint footprint) {                                                     \
        Value sum;                                                                                           \
        NtcStfClear(sum);                                                                                    \
        uint parts = NtcStfCountParts(settings, extent, footprint);                                          \
        NTC_LOOP for (uint i = 0u; i < parts; i++) {                                                         \
            NtcStfPart part = NtcStfGetPart(settings, extent, uv, footprint, i);                             \
            Value all;                                                                                       \
            NtcStfClear(all);                                                                                \
            NTC_LOOP for (int y = 0; y < part.y.count; y++) {                                                \
                Value row;                                                                                   \
                NtcStfClear(row);                                                                            \
                NTC_LOOP for (int x = 0; x < part.x.count; x++) {                                            \
                    Value texel = Fetch(context, NtcStfPlaceTap(settings, extent, part.x.first + x,          \
                                                                part.y.first + y, part.mip));                \
                    NtcStfAdd(row, texel, NtcStfGetWeight(part.x, x));                                       \
                }                                                                                            \
                NtcStfAdd(all, row, NtcStfGetWeight(part.y, y));                                             \
            }                                                                                                \
            NtcStfAdd(sum, all, part.weight);                                                                \
        }                                                                                                    \
        return sum;                                                                                          \
    }

#endif
