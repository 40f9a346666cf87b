// SPDX-License-Identifier: MIT
// Sharing (Wronski, Pharr and Akenine-Möller 2025): every lane reads the one texel that it drew and also
// uses those that its neighbours drew, weighed by its own filter over the different texels that are there.
// One decode a lane, much less noise where textures are magnified; biased, which no number of frames
// removes.
//
//   NTC_STF_DEFINE_SHARING(Name, Value, Context, Fetch)
// defines
//   Value Name(Context context, NtcStfWaveLane lane, uint span, NtcStfSampler settings,
//              NtcStfExtent extent, float2 uv, NtcStfFootprint footprint, uint4 random)
// span: how many lanes share, a power of two: 4 is a quad, 128 the whole wave. Called by every lane in
// uniform control flow, as collaboration is; lane.maxRounds is not used. Lanes that read two mips or several
// anisotropic taps, whose kernel has negative weights or reaches over a border, keep what they drew.
#ifndef OPENNTC_STF_SHARE_H
#define OPENNTC_STF_SHARE_H

#include "StfCollaborate.h"
#include "StfMultiTap.h"
#include "StfSample.h"
#include "StfWave.h"
#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

/// The weight that an axis gives a texel; taps that fold onto it add theirs.
NTC_FUNCTION float NtcStfWeighTexel(NtcStfAxis axis, int size, uint wrap, int texel) {
    int weight = 0;
    NTC_LOOP for (int k = 0; k < axis.count; k++) {
        if (NtcAddressTexel(axis.first + k, size, wrap) == texel)
            weight += axis.weights[k];
    }
    return NtcMultiply(float(weight), axis.unit);
}

/// The weight of a texel in a part of a lookup.
NTC_FUNCTION float NtcStfWeighTap(NtcStfSampler settings, NtcStfExtent extent, NtcStfPart part,
                                  NtcStfTap tap) {
    int width = NtcStfGetMipSize(extent.width, part.mip);
    int height = NtcStfGetMipSize(extent.height, part.mip);
    return NtcMultiply(NtcStfWeighTexel(part.x, width, settings.wrapX, tap.texel.x),
                       NtcStfWeighTexel(part.y, height, settings.wrapY, tap.texel.y));
}

/// True if a lookup may be made of shared texels: one mip, positive weights, no border in reach.
NTC_FUNCTION bool NtcStfMayShare(NtcStfSampler settings, NtcStfExtent extent, NtcStfFootprint footprint,
                                 NtcStfPart part) {
    bool isOutside = false;
    if (settings.wrapX == uint(NTC_WRAP_BORDER))
        isOutside =
            part.x.first < 0 || part.x.first + part.x.count > NtcStfGetMipSize(extent.width, part.mip);
    if (settings.wrapY == uint(NTC_WRAP_BORDER))
        isOutside = isOutside || part.y.first < 0 ||
                    part.y.first + part.y.count > NtcStfGetMipSize(extent.height, part.mip);
    return !isOutside && !NtcStfIsSigned(settings) && NtcStfCountParts(settings, extent, footprint) == 1u;
}

/// Another lane's tap.
NTC_FUNCTION NtcStfTap NtcStfReadTap(NtcStfTap tap, uint lane) {
    NtcStfTap other = tap;
    other.texel = int2(NtcWaveRead(tap.texel.x, lane), NtcWaveRead(tap.texel.y, lane));
    other.mip = NtcWaveRead(tap.mip, lane);
    return other;
}

NTC_FUNCTION bool NtcStfIsSameTap(NtcStfTap a, NtcStfTap b) {
    return a.texel.x == b.texel.x && a.texel.y == b.texel.y && a.mip == b.mip;
}

/// True if no lane below this one of its span offers the same texel. Borders are not offered.
NTC_FUNCTION bool NtcStfIsFirst(NtcStfTap tap, NtcStfWaveLane lane, bool isOffered, uint span) {
    uint ownLane = NtcWaveLane();
    uint begin = ownLane & ~(span - 1u);
    uint4 offers = NtcWaveBallot(isOffered);
    bool isFirst = isOffered;
    NTC_LOOP for (uint i = 0u; i < span && i < uint(NtcWaveSize()); i++) {
        uint other = begin + i;
        bool isThere = other < ownLane && NtcStfHasBit(offers, other & 127u);
        uint giver = isThere ? other : ownLane;
        NtcStfTap theirs = NtcStfReadTap(tap, giver);
        uint key = NtcWaveRead(lane.key, giver);
        if (isThere && key == lane.key && NtcStfIsSameTap(theirs, tap))
            isFirst = false;
    }
    return isFirst;
}

NTC_NAMESPACE_END

#define NTC_STF_DEFINE_SHARING(Name, Value, Context, Fetch)                                                  \
    NTC_FUNCTION Value Name(Context context, NtcStfWaveLane lane, uint span, NtcStfSampler settings,         \
                            NtcStfExtent extent, float2 uv, NtcStfFootprint footprint, uint4 random) {       \
        NtcStfPair pair = NtcStfSamplePair(settings, extent, uv, footprint, random);                         \
        NtcStfPart part = NtcStfGetPart(settings, extent, uv, footprint, 0u);                                \
        bool isShared = NtcStfMayShare(settings, extent, footprint, part);                                   \
        Value own;                                                                                           \
        NtcStfClear(own);                                                                                    \
        if (lane.isLive)                                                                                     \
            own = Fetch(context, pair.first);                                                                \
        uint ownLane = NtcWaveLane();                                                                        \
        uint begin = ownLane & ~(span - 1u);                                                                 \
        bool isOffered = lane.isLive && !pair.first.isBorder;                                                \
        uint4 offers = NtcWaveBallot(NtcStfIsFirst(pair.first, lane, isOffered, span));                      \
        Value sum;                                                                                           \
        NtcStfClear(sum);                                                                                    \
        float total = 0.0f;                                                                                  \
        NTC_LOOP for (uint i = 0u; i < span && i < uint(NtcWaveSize()); i++) {                               \
            uint other = begin + i;                                                                          \
            bool isThere = NtcStfHasBit(offers, other & 127u) && other < uint(NtcWaveSize());                \
            uint giver = isThere ? other : ownLane;                                                          \
            NtcStfTap theirs = NtcStfReadTap(pair.first, giver);                                             \
            uint key = NtcWaveRead(lane.key, giver);                                                         \
            Value value = NtcStfReadLane(own, giver);                                                        \
            if (isThere && key == lane.key && theirs.mip == part.mip) {                                      \
                float weight = NtcStfWeighTap(settings, extent, part, theirs);                               \
                NtcStfAdd(sum, value, weight);                                                               \
                total = NtcStfAddProduct(total, weight, 1.0f);                                               \
            }                                                                                                \
        }                                                                                                    \
        Value result;                                                                                        \
        NtcStfClear(result);                                                                                 \
        if (isShared && isOffered && total > 0.0f) {                                                         \
            NtcStfAdd(result, sum, 1.0f / total);                                                            \
        } else if (lane.isLive) {                                                                            \
            NtcStfAdd(result, own, pair.first.scale);                                                        \
            if (pair.second.scale != 0.0f)                                                                   \
                NtcStfAdd(result, Fetch(context, pair.second), pair.second.scale);                           \
        }                                                                                                    \
        return result;                                                                                       \
    }

#endif
