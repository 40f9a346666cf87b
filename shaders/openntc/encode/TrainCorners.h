// SPDX-License-Identifier: MIT
// Generation 1: which latents a texel reads, its network inputs, and the way back of their gradients. The
// decoder's arithmetic.
#ifndef OPENNTC_TRAIN_CORNERS_H
#define OPENNTC_TRAIN_CORNERS_H

/// The four pixels of a grid that a texel reads, and their weights in steps of 1/256.
struct NtcTrainCorners {
    uvec4 pixels; // latents of feature 0
    vec4 weights;
#if NTC_TRAIN_TRIES
    vec4 change; // of the levels, where the pixel is of the class that is moved
#endif
};

NtcTrainCorners NtcPlaceCorners(NtcTrainGrid grid, uvec2 place) {
    uvec2 x = gTaps.taps[grid.tapsX + place.x], y = gTaps.taps[grid.tapsY + place.y];
    float fx = uintBitsToFloat(x.y), fy = uintBitsToFloat(y.y);
    precise float gx = 1.0 - fx;
    precise float gy = 1.0 - fy;
    precise vec4 exact = vec4(gx * gy, fx * gy, gx * fy, fx * fy);
    NtcTrainCorners corners;
    corners.weights = trunc(exact * 256.0) * (1.0 / 256.0);
    uint upper = grid.base + (y.x & 0xFFFFu) * grid.width, lower = grid.base + (y.x >> 16) * grid.width;
    corners.pixels =
        uvec4(upper, upper, lower, lower) + uvec4(x.x & 0xFFFFu, x.x >> 16, x.x & 0xFFFFu, x.x >> 16);
#if NTC_TRAIN_TRIES
    uvec4 odd = uvec4(x.x & 1u, x.x >> 16 & 1u, y.x & 1u, y.x >> 16 & 1u);
    bvec4 isOf = equal(
        odd, uvec4(gStep.move >> 1 & 1u, gStep.move >> 1 & 1u, gStep.move >> 2 & 1u, gStep.move >> 2 & 1u));
    corners.change =
        gStep.levels * vec4(isOf.x && isOf.z, isOf.y && isOf.z, isOf.x && isOf.w, isOf.y && isOf.w);
#endif
    return corners;
}

float NtcTrainInput(uint slot, NtcTrainTexel t, NtcTrainCorners high, NtcTrainCorners low) {
    uint highInputs = 4u * uint(gConstants.highFeatures), lowFeatures = uint(gConstants.lowFeatures);
    if (slot < highInputs) {
        uint corner = slot / uint(gConstants.highFeatures);
        uint feature = slot - corner * uint(gConstants.highFeatures);
        uint at = high.pixels[corner] + feature * gMips.mips[t.mip].high.plane;
        precise float product =
            NtcTrainLatent(at, gConstants.high, NTC_TRAIN_CHANGE(high, corner, feature, 0u)) *
            high.weights[corner];
        return floor(product);
    }
    slot -= highInputs;
    if (slot < lowFeatures) {
        uint offset = slot * gMips.mips[t.mip].low.plane;
        precise float sum = 0.0;
        [[unroll]] for (uint c = 0u; c < 4u; c++) sum +=
            NtcTrainLatent(low.pixels[c] + offset, gConstants.low, NTC_TRAIN_CHANGE(low, c, slot, 1u)) *
            low.weights[c];
        return floor(sum);
    }
    slot -= lowFeatures;
    if (slot < 12u) {
        uint coordinate = (slot & 1u) == 0u ? t.place.x : t.place.y;
        return float(gMips.mips[t.mip].waves[(slot >> 1) * 16u + (coordinate & 15u)]);
    }
    return slot < 14u ? float(gMips.mips[t.mip].lodInput) : 0.0;
}

/// Inputs of the strip's texels: eight lanes a texel.
void NtcGatherInputs(uvec2 record, uint strip) {
    uint texel = gl_LocalInvocationIndex >> 3;
    NtcTrainTexel t = NtcPlaceTexel(record, strip, texel);
    NtcTrainCorners high = NtcPlaceCorners(gMips.mips[t.mip].high, t.place);
    NtcTrainCorners low = NtcPlaceCorners(gMips.mips[t.mip].low, t.place);
    uint row = 4u * texel * NTC_TRAIN_WIDE;
    [[dont_unroll]] for (uint pair = gl_LocalInvocationIndex & 7u; pair < uint(NTC_TRAIN_INPUTS) / 2u;
                         pair += 8u) {
        vec2 inputs =
            vec2(NtcTrainInput(2u * pair, t, high, low), NtcTrainInput(2u * pair + 1u, t, high, low));
        sHalves[(row + pair) >> 2][pair & 3u] = packHalf2x16(inputs);
    }
}

#if !NTC_TRAIN_TRIES
/// Gradients of the latents from those of inputs [first, first + 64), which are in sSums. Whole numbers:
/// any order of the additions gives the same sums.
void NtcScatterGradients(uvec2 record, uint strip, uint first) {
    uint texel = gl_LocalInvocationIndex >> 3;
    NtcTrainTexel t = NtcPlaceTexel(record, strip, texel);
    NtcTrainCorners high = NtcPlaceCorners(gMips.mips[t.mip].high, t.place);
    NtcTrainCorners low = NtcPlaceCorners(gMips.mips[t.mip].low, t.place);
    uint highInputs = 4u * uint(gConstants.highFeatures);
    uint last = min(first + 64u, highInputs + uint(gConstants.lowFeatures));
    [[dont_unroll]] for (uint slot = first + (gl_LocalInvocationIndex & 7u); slot < last; slot += 8u) {
        float gradient = sSums[texel * NTC_TRAIN_SUMS + slot - first] * (1.0 / 127.5);
        if (gradient == 0.0)
            continue;
        if (slot < highInputs) {
            uint corner = slot / uint(gConstants.highFeatures);
            uint feature = slot - corner * uint(gConstants.highFeatures);
            NtcAddLatentGradient(high.pixels[corner] + feature * gMips.mips[t.mip].high.plane,
                                 gradient * high.weights[corner]);
        } else {
            uint offset = (slot - highInputs) * gMips.mips[t.mip].low.plane;
            [[unroll]] for (uint c = 0u; c < 4u; c++)
                NtcAddLatentGradient(low.pixels[c] + offset, gradient * low.weights[c]);
        }
    }
}
#endif

#endif
