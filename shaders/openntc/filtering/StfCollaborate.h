// SPDX-License-Identifier: MIT
// Collaborative filtering (Akenine-Möller, Ebelin, Pharr and Wronski 2025): the lanes of a wave divide the
// different texels of all their filters among themselves, decode each once, and pass them round. The result
// has the bits of NTC_STF_DEFINE_FILTER with the same Fetch.
//
//   NTC_STF_DEFINE_COLLABORATION(Name, Value, Context, Fetch)
// defines
//   Value Name(Context context, NtcStfWaveLane lane, NtcStfSampler settings, NtcStfExtent extent, float2 uv,
//              NtcStfFootprint footprint, uint4 random)
// Every lane of the wave calls it, in uniform control flow: derivatives are taken before, and alpha tests
// come after. settings.kernelType and .radius are the same in all lanes; all else may differ. A lane decodes
// for others with its own context, so whatever of it changes what Fetch returns (texture, material) belongs
// into lane.key. Fetch is called where lanes have diverged: it must not need the whole wave itself.
//
// Where a lane's texels would take more than lane.maxRounds decodes of each lane that needs them, it reads
// one stochastic texel with `random` instead (two with negative weights): unbiased.
#ifndef OPENNTC_STF_COLLABORATE_H
#define OPENNTC_STF_COLLABORATE_H

#include "StfMultiTap.h"
#include "StfSample.h"
#include "StfWave.h"
#include "openntc/Portability.h"

// Most decodes of a lane; 1 ... 128. What maxRounds is limited to, and its default.
#if !defined(NTC_STF_MAX_ROUNDS)
#define NTC_STF_MAX_ROUNDS 2
#endif

// 1: boxes with no more cells than lanes are decoded whole, which spares lists of what is needed of them,
// for a few decodes more where textures are turned against the screen.
#if !defined(NTC_STF_WHOLE_BOXES)
#define NTC_STF_WHOLE_BOXES 0
#endif

NTC_NAMESPACE_BEGIN

/// What a lane is in its wave.
struct NtcStfWaveLane {
    uint key;       // what differs between lanes and changes what Fetch returns; 0 if nothing does
    bool isLive;    // false for helper lanes: !gl_HelperInvocation
    uint maxRounds; // 1 ... NTC_STF_MAX_ROUNDS
};

NTC_FUNCTION NtcStfWaveLane NtcStfMakeWaveLane(uint key, bool isLive) {
    NtcStfWaveLane lane;
    lane.key = key;
    lane.isLive = isLive;
    lane.maxRounds = uint(NTC_STF_MAX_ROUNDS);
    return lane;
}

/// How the lanes with one key and mip divide their texels. Slot s of them belongs to the group's lane s %
/// lanes, as its texel number s / lanes.
struct NtcStfPlan {
    bool isMember; // of the group
    bool isExact;  // else there are too many texels
    uint rounds;   // decodes of a lane
    uint lanes;    // of the group
    uint4 group;   // which
    uint owned;    // texels of this lane
    int2 texels[NTC_STF_MAX_ROUNDS];
    uint slots[NTC_STF_MOST_TAPS * NTC_STF_MOST_TAPS]; // of this lane's taps, row by row; border: none
};

/// Taps of an axis after addressing; -1: border.
struct NtcStfPlaces {
    int texels[NTC_STF_MOST_TAPS];
};

NTC_FUNCTION NtcStfPlaces NtcStfGetPlaces(NtcStfAxis axis, int size, uint wrap) {
    NtcStfPlaces places;
    for (int k = 0; k < NTC_STF_MOST_TAPS; k++)
        places.texels[k] = k < axis.count ? NtcAddressTexel(axis.first + k, size, wrap) : -1;
    return places;
}

/// What all lanes of a group know of their texels.
struct NtcStfBox {
    int left;
    int top;
    int width;
    int height;
    bool isSmall; // no more than 128 cells
};

NTC_FUNCTION NtcStfBox NtcStfGetBox(NtcStfPart part, bool isMember) {
    const int beyond = 1 << 28;
    NtcStfBox box;
    box.left = NtcWaveMin(isMember ? part.x.first : beyond);
    box.top = NtcWaveMin(isMember ? part.y.first : beyond);
    box.width = NtcWaveMax(isMember ? part.x.first : -beyond) - box.left + part.x.count;
    box.height = NtcWaveMax(isMember ? part.y.first : -beyond) - box.top + part.y.count;
    box.isSmall = box.width <= 128 && box.height <= 128 && box.width * box.height <= 128;
    return box;
}

/// Slots by a bit for every cell of the box: bits are counted instead of looking for texels.
NTC_FUNCTION void NtcStfPlanBox(NtcStfSampler settings, NtcStfExtent extent, NtcStfPart part, NtcStfBox box,
                                uint most, NTC_INOUT(NtcStfPlan, plan)) {
    int width = NtcStfGetMipSize(extent.width, part.mip);
    int height = NtcStfGetMipSize(extent.height, part.mip);
    NtcStfPlaces columns = NtcStfGetPlaces(part.x, width, settings.wrapX);
    NtcStfPlaces rows = NtcStfGetPlaces(part.y, height, settings.wrapY);
    uint4 own = uint4(0u, 0u, 0u, 0u);
    NTC_LOOP for (int y = 0; y < part.y.count; y++) {
        NTC_LOOP for (int x = 0; x < part.x.count; x++) {
            int cell = (part.y.first + y - box.top) * box.width + part.x.first + x - box.left;
            plan.slots[y * part.x.count + x] = uint(cell);
            if (plan.isMember && columns.texels[x] >= 0 && rows.texels[y] >= 0)
                own = own | NtcStfMakeBit(uint(cell));
        }
    }
    uint4 cells = uint4(NtcWaveOr(own.x), NtcWaveOr(own.y), NtcWaveOr(own.z), NtcWaveOr(own.w));
    uint slots = NtcStfCountAll(cells);
#if NTC_STF_WHOLE_BOXES
    if (uint(box.width * box.height) <= plan.lanes) {
        slots = uint(box.width * box.height);
        cells = uint4(0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu);
    }
#endif
    plan.isExact = slots <= most;
    if (!plan.isExact)
        return;
    plan.rounds = (slots + plan.lanes - 1u) / plan.lanes;
    if (!plan.isMember)
        return;
    NTC_LOOP for (int k = 0; k < part.x.count * part.y.count; k++) plan.slots[k] =
        NtcStfCountBelow(cells, plan.slots[k]);
    uint rank = NtcStfCountBelow(plan.group, NtcWaveLane());
    NTC_LOOP for (uint slot = rank; slot < slots; slot += plan.lanes) {
        int cell = int(NtcStfFindBit(cells, slot));
        plan.texels[plan.owned] = int2(NtcAddressTexel(box.left + cell % box.width, width, settings.wrapX),
                                       NtcAddressTexel(box.top + cell / box.width, height, settings.wrapY));
        plan.owned += 1u;
    }
}

/// Slots by a list of texels, for texels that lie apart: as many turns as there are different ones.
NTC_FUNCTION void NtcStfPlanList(NtcStfSampler settings, NtcStfExtent extent, NtcStfPart part, uint most,
                                 NTC_INOUT(NtcStfPlan, plan)) {
    NtcStfPlaces columns = NtcStfGetPlaces(part.x, NtcStfGetMipSize(extent.width, part.mip), settings.wrapX);
    NtcStfPlaces rows = NtcStfGetPlaces(part.y, NtcStfGetMipSize(extent.height, part.mip), settings.wrapY);
    const uint unserved = 0xFFFFFFFFu;
    int taps = part.x.count * part.y.count;
    uint rank = NtcStfCountBelow(plan.group, NtcWaveLane());
    uint slots = 0u;
    bool isFull = false;
    for (int k = 0; k < taps; k++)
        plan.slots[k] = unserved;
    NTC_LOOP for (int tap = 0; tap < taps; tap++) {
        int column = columns.texels[tap % part.x.count];
        int row = rows.texels[tap / part.x.count];
        bool isTap = plan.isMember && column >= 0 && row >= 0;
        uint4 waiting = NtcWaveBallot(isTap && plan.slots[tap] == unserved);
        NTC_LOOP while (!isFull && NtcStfCountAll(waiting) != 0u) {
            isFull = slots == most;
            if (!isFull) {
                uint first = NtcStfFindBit(waiting, 0u);
                int2 texel = int2(NtcWaveRead(column, first), NtcWaveRead(row, first));
                NTC_LOOP for (int k = 0; k < taps; k++) {
                    if (columns.texels[k % part.x.count] == texel.x &&
                        rows.texels[k / part.x.count] == texel.y)
                        plan.slots[k] = slots;
                }
                if (plan.isMember && slots % plan.lanes == rank) {
                    plan.texels[slots / plan.lanes] = texel;
                    plan.owned += 1u;
                }
                slots += 1u;
                waiting = NtcWaveBallot(isTap && plan.slots[tap] == unserved);
            }
        }
    }
    plan.isExact = !isFull;
    plan.rounds = isFull ? 0u : (slots + plan.lanes - 1u) / plan.lanes;
    if (isFull)
        plan.owned = 0u;
}

/// The plan of the first waiting lane's group: of all waiting lanes with its key and mip. At least one lane
/// waits.
NTC_FUNCTION NtcStfPlan NtcStfMakePlan(NtcStfSampler settings, NtcStfExtent extent, NtcStfPart part,
                                       NtcStfWaveLane lane, bool isWaiting) {
    NtcStfPlan plan;
    uint first = NtcStfFindBit(NtcWaveBallot(isWaiting), 0u);
    uint key = NtcWaveRead(lane.key, first);
    int mip = NtcWaveRead(part.mip, first);
    plan.isMember = isWaiting && lane.key == key && part.mip == mip;
    plan.isExact = false;
    plan.rounds = 0u;
    plan.group = NtcWaveBallot(plan.isMember);
    plan.lanes = NtcStfCountAll(plan.group);
    plan.owned = 0u;
    for (int i = 0; i < NTC_STF_MAX_ROUNDS; i++)
        plan.texels[i] = int2(0, 0);
    for (int k = 0; k < NTC_STF_MOST_TAPS * NTC_STF_MOST_TAPS; k++)
        plan.slots[k] = 0u;
    uint rounds = lane.maxRounds < uint(NTC_STF_MAX_ROUNDS) ? lane.maxRounds : uint(NTC_STF_MAX_ROUNDS);
    uint most = NtcWaveRead(rounds, first) * plan.lanes;
    NtcStfBox box = NtcStfGetBox(part, plan.isMember);
    if (box.isSmall)
        NtcStfPlanBox(settings, extent, part, box, most, plan);
    else
        NtcStfPlanList(settings, extent, part, most, plan);
    return plan;
}

/// The tap that reads a texel of a plan.
NTC_FUNCTION NtcStfTap NtcStfGetOwnedTap(NtcStfPlan plan, int mip, uint index) {
    NtcStfTap tap;
    tap.texel = plan.texels[index];
    tap.mip = mip;
    tap.scale = 1.0f;
    tap.isBorder = tap.texel.x < 0 || tap.texel.y < 0;
    return tap;
}

NTC_NAMESPACE_END

// Texels of all rounds are decoded first; then taps are added in the order of the filter that has all its
// taps.
#define NTC_STF_DEFINE_COLLABORATION(Name, Value, Context, Fetch)                                            \
    NTC_FUNCTION Value Name(Context context, NtcStfWaveLane lane, NtcStfSampler settings,                    \
                            NtcStfExtent extent, float2 uv, NtcStfFootprint footprint, uint4 random) {       \
        Value sum;                                                                                           \
        NtcStfClear(sum);                                                                                    \
        bool isOpen = lane.isLive;                                                                           \
        uint parts = isOpen ? NtcStfCountParts(settings, extent, footprint) : 0u;                            \
        uint most = uint(NtcWaveMax(int(parts)));                                                            \
        NTC_LOOP for (uint i = 0u; i < most; i++) {                                                          \
            NtcStfPart part = NtcStfGetPart(settings, extent, uv, footprint, i < parts ? i : 0u);            \
            bool isWaiting = isOpen && i < parts;                                                            \
            NTC_LOOP while (NtcStfCountAll(NtcWaveBallot(isWaiting)) != 0u) {                                \
                NtcStfPlan plan = NtcStfMakePlan(settings, extent, part, lane, isWaiting);                   \
                Value decoded[NTC_STF_MAX_ROUNDS];                                                           \
                NTC_LOOP for (uint d = 0u; d < uint(NTC_STF_MAX_ROUNDS); d++) {                              \
                    NtcStfClear(decoded[d]);                                                                 \
                    if (d < plan.owned)                                                                      \
                        decoded[d] = Fetch(context, NtcStfGetOwnedTap(plan, part.mip, d));                   \
                }                                                                                            \
                Value all;                                                                                   \
                NtcStfClear(all);                                                                            \
                NTC_LOOP for (int y = 0; y < part.y.count && plan.isExact; y++) {                            \
                    Value row;                                                                               \
                    NtcStfClear(row);                                                                        \
                    NTC_LOOP for (int x = 0; x < part.x.count; x++) {                                        \
                        NtcStfTap tap =                                                                      \
                            NtcStfPlaceTap(settings, extent, part.x.first + x, part.y.first + y, part.mip);  \
                        uint slot = plan.slots[y * part.x.count + x];                                        \
                        bool isRead = plan.isMember && !tap.isBorder;                                        \
                        uint giver =                                                                         \
                            isRead ? NtcStfFindBit(plan.group, slot % plan.lanes) : uint(NtcWaveLane());     \
                        Value texel;                                                                         \
                        NtcStfClear(texel);                                                                  \
                        NTC_LOOP for (uint d = 0u; d < plan.rounds; d++) {                                   \
                            Value other = NtcStfReadLane(decoded[d], giver);                                 \
                            if (isRead && slot / plan.lanes == d)                                            \
                                texel = other;                                                               \
                        }                                                                                    \
                        if (tap.isBorder)                                                                    \
                            texel = Fetch(context, tap);                                                     \
                        NtcStfAdd(row, texel, NtcStfGetWeight(part.x, x));                                   \
                    }                                                                                        \
                    NtcStfAdd(all, row, NtcStfGetWeight(part.y, y));                                         \
                }                                                                                            \
                if (plan.isMember) {                                                                         \
                    NtcStfAdd(sum, all, part.weight);                                                        \
                    isOpen = plan.isExact;                                                                   \
                    isWaiting = false;                                                                       \
                }                                                                                            \
            }                                                                                                \
        }                                                                                                    \
        if (lane.isLive && !isOpen) {                                                                        \
            NtcStfPair pair = NtcStfSamplePair(settings, extent, uv, footprint, random);                     \
            NtcStfClear(sum);                                                                                \
            NtcStfAdd(sum, Fetch(context, pair.first), pair.first.scale);                                    \
            if (pair.second.scale != 0.0f)                                                                   \
                NtcStfAdd(sum, Fetch(context, pair.second), pair.second.scale);                              \
        }                                                                                                    \
        return sum;                                                                                          \
    }

#endif
