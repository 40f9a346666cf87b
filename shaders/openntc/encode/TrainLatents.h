// SPDX-License-Identifier: MIT
// The latents of texels: where they are, noise and rounding, and the sums of their gradients.
#ifndef OPENNTC_TRAIN_LATENTS_H
#define OPENNTC_TRAIN_LATENTS_H

/// PCG's output permutation over one LCG step, as encode/detail/Random.h.
uint NtcTrainHash(uint value) {
    value = value * 747796405u + 2891336453u;
    value = ((value >> ((value >> 28) + 4u)) ^ value) * 277803737u;
    return (value >> 22) ^ value;
}

/// A texel of a strip.
struct NtcTrainTexel {
    uint mip;
    uvec2 place;
    bool inside; // the image; else it repeats the last one
};

NtcTrainTexel NtcPlaceTexel(uvec2 record, uint strip, uint texel) {
    NtcTrainTexel t;
    t.mip = record.x;
    uvec2 size = uvec2(gMips.mips[t.mip].width, gMips.mips[t.mip].height);
    uvec2 wanted = uvec2((record.y & 0xFFFFu) + (texel & 15u), (record.y >> 16) + 2u * strip + (texel >> 4));
    t.place = min(wanted, size - 1u);
    t.inside = t.place == wanted;
    return t;
}

#if NTC_TRAIN_TRIES
/// Levels that a feature of a corner's pixel is moved by: `corners` has the change of all features.
#define NTC_TRAIN_CHANGE(corners, corner, feature, low)                                                      \
    (((gStep.flags & NTC_TRAIN_MOVE) != 0u && (gStep.move & 1u) == low && gStep.move >> 3 == (feature))      \
         ? corners.change[corner]                                                                            \
         : 0.0)
#else
#define NTC_TRAIN_CHANGE(corners, corner, feature, low) 0.0
#endif

/// Network input of a latent before weighting: its level, rounded or with noise of one step.
float NtcTrainLatent(uint at, NtcTrainQuantiser q, float change) {
    precise float level = gLatents.values[at] * q.scale;
    if ((gStep.flags & NTC_TRAIN_ROUND) != 0u) {
        level = floor(level + 0.5);
        level = clamp(level, q.lowest, q.highest);
        level = clamp(level + change, q.lowest, q.highest);
    } else {
        level += float(NtcTrainHash(gStep.noise + at) >> 8) * (1.0 / 16777216.0) - 0.5;
    }
    level *= q.levelInput;
    return level;
}

#if !NTC_TRAIN_TRIES
void NtcAddLatentGradient(uint at, float gradient) {
    const float limit = 4194304.0; // 512 of the largest fit a sum
    int value = int(round(clamp(gradient * NTC_TRAIN_LATENT_UNIT, -limit, limit)));
    if (value != 0)
        atomicAdd(gLatentGradients.values[at], value);
}
#endif

#endif
