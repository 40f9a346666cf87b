// SPDX-License-Identifier: MIT
// Errors of outputs, and what training descends: as encode/detail/TrainNetwork.h.
#ifndef OPENNTC_TRAIN_LOSS_H
#define OPENNTC_TRAIN_LOSS_H

// A lane has two neighbouring outputs of a texel.
uint NtcErrorOutput() {
    return 2u * (gl_LocalInvocationIndex & 7u);
}
uint NtcErrorTexel() {
    return gl_LocalInvocationIndex >> 3;
}

/// Where a tile's references are: `index` is its place in a submission's list.
uint NtcPlaceReference(uint tile, uint index) {
    return (gStep.flags & NTC_TRAIN_STREAMED) != 0u ? index : tile;
}
/// A channel's reference, 0 ... 1.
float NtcTrainReference(uint reference, int channel, uint texel) {
    uint at = (reference * uint(gConstants.channels) + uint(channel)) * uint(NTC_TRAIN_TILE_TEXELS) + texel;
    return float(gReferences.words[at >> 1] >> (16u * (at & 1u)) & 0xFFFFu) * (1.0 / 65535.0);
}

const float kMaskLow = 0.05, kMaskHigh = 0.95, kMaskKnee = 0.03;

float NtcClipMaskError(float error, float wanted) {
    if (wanted < kMaskLow)
        return max(error, 0.0);
    return wanted > kMaskHigh ? min(error, 0.0) : error;
}
float NtcWeighMaskError(float error, float wanted) {
    if (wanted < kMaskLow)
        return error + gStep.maskPush * max(error - kMaskKnee, 0.0);
    return wanted > kMaskHigh ? error + gStep.maskPush * min(error + kMaskKnee, 0.0) : error;
}

/// Of a lane's two outputs.
struct NtcTrainErrors {
    vec2 gradients;
    vec2 squares; // in stored units
};

/// Output `o` of a texel, from the sums of the last layer.
float NtcTrainOutput(uint texel, uint o) {
    precise float value = sSums[texel * NTC_TRAIN_SUMS + o] + gRows.values[NTC_TRAIN_ROWS + 192u + o];
    value *= gRows.values[192u + o];
    return value;
}

/// What a lane's two outputs should be, read before it is needed: the references come from far.
struct NtcTrainTargets {
    vec2 wanted;
    bvec2 count;
};

NtcTrainTargets NtcReadTargets(uint reference, uint strip, uvec2 record) {
    NtcTrainTargets targets = NtcTrainTargets(vec2(0.0), bvec2(false));
    uint t = NtcErrorTexel(), texel = 32u * strip + t;
    if (!NtcPlaceTexel(record, strip, t).inside)
        return targets;
    bool discarded =
        gConstants.maskIndex >= 0 && NtcTrainReference(reference, gConstants.maskIndex, texel) <= 0.0;
    [[unroll]] for (uint i = 0u; i < 2u; i++) {
        int channel = gConstants.channelOf[NtcErrorOutput() + i];
        if (channel < 0 || (discarded && channel != gConstants.maskIndex))
            continue;
        targets.wanted[i] = NtcTrainReference(reference, channel, texel);
        targets.count[i] = true;
    }
    return targets;
}

#if !NTC_TRAIN_TRIES
NtcTrainErrors NtcMeasureErrors(NtcTrainTargets targets) {
    NtcTrainErrors errors = NtcTrainErrors(vec2(0.0), vec2(0.0));
    [[unroll]] for (uint i = 0u; i < 2u; i++) {
        uint o = NtcErrorOutput() + i;
        if (!targets.count[i])
            continue;
        float error = NtcTrainOutput(NtcErrorTexel(), o) - targets.wanted[i];
        float weighed = error;
        if (gConstants.channelOf[o] == gConstants.oneSided) {
            error = NtcClipMaskError(error, targets.wanted[i]);
            weighed = NtcWeighMaskError(error, targets.wanted[i]);
        }
        errors.gradients[i] = weighed * gConstants.gain[o];
        errors.squares[i] = error * error * gConstants.squaredRange[o];
    }
    return errors;
}
#else
/// What training descends, of a lane's two outputs.
float NtcMeasureLoss(NtcTrainTargets targets) {
    float loss = 0.0;
    [[unroll]] for (uint i = 0u; i < 2u; i++) {
        uint o = NtcErrorOutput() + i;
        if (!targets.count[i])
            continue;
        float wanted = targets.wanted[i];
        float error = NtcTrainOutput(NtcErrorTexel(), o) - wanted;
        float squares = error * error;
        if (gConstants.channelOf[o] == gConstants.oneSided) {
            error = NtcClipMaskError(error, wanted);
            float excess = max(abs(error) - kMaskKnee, 0.0);
            bool isExact = wanted < kMaskLow || wanted > kMaskHigh;
            squares = error * error + (isExact ? gStep.maskPush : 0.0) * (excess * excess);
        }
        loss += squares * gConstants.gain[o];
    }
    return loss;
}
#endif

#endif
