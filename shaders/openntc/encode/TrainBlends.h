// SPDX-License-Identifier: MIT
// Generation 3: which latents of two mips a texel reads, its network inputs, and the way back of their
// gradients. The decoder's arithmetic.
#ifndef OPENNTC_TRAIN_BLENDS_H
#define OPENNTC_TRAIN_BLENDS_H

/// A texel's place along one axis of a grid: two neighbours, and the weight of the second in steps of 1/256.
struct NtcTrainTap {
    uvec2 pixels;
    float weight;
    int first; // the first one's coordinate before it wraps: -1 and above
};

NtcTrainTap NtcReadTap(uint at) {
    uvec2 words = gTaps.taps[at];
    NtcTrainTap tap;
    tap.pixels = uvec2(words.x & 0xFFFFu, words.x >> 16);
    tap.weight = float(words.y & 0xFFFFu) * (1.0 / 256.0);
    tap.first = int(words.y >> 16) - 1;
    return tap;
}

/// The four pixels of a grid that a texel reads, and their weights, which are exact in binary32.
struct NtcTrainBlend {
    uvec4 pixels; // latents of feature 0
    vec4 weights;
#if NTC_TRAIN_TRIES
    vec4 change; // of the levels, where the pixel is of the class that is moved
#endif
};

#if NTC_TRAIN_TRIES
/// Whether pixels of an axis are of the class that is moved: see AxisClass of encode/detail/LatentRefiner.h.
bvec2 NtcAreMoved(uvec2 pixels, uint count, uint odd) {
    uvec2 rotated = (pixels + count - gStep.turn % count) % count;
    uint movable = count > 1u ? count & ~1u : 1u;
    return bvec2(rotated.x < movable && (rotated.x & 1u) == odd,
                 rotated.y < movable && (rotated.y & 1u) == odd);
}
#endif

NtcTrainBlend NtcPlaceBlend(NtcTrainGrid grid, uvec2 place) {
    NtcTrainTap x = NtcReadTap(grid.tapsX + place.x), y = NtcReadTap(grid.tapsY + place.y);
    NtcTrainBlend blend;
    vec2 wx = vec2(1.0 - x.weight, x.weight);
    blend.weights = vec4(wx * (1.0 - y.weight), wx * y.weight);
    uvec2 rows = grid.base + y.pixels * grid.width;
    blend.pixels = uvec4(rows.x + x.pixels, rows.y + x.pixels);
#if NTC_TRAIN_TRIES
    bvec2 ofX = NtcAreMoved(x.pixels, grid.width, gStep.move >> 1 & 1u);
    bvec2 ofY = NtcAreMoved(y.pixels, grid.height, gStep.move >> 2 & 1u);
    blend.change = gStep.levels * vec4(ofX.x && ofY.x, ofX.y && ofY.x, ofX.x && ofY.y, ofX.y && ofY.y);
#endif
    return blend;
}

/// Input of a feature. `low`: 1 for the odd latent mip.
float NtcBlendFeature(NtcTrainBlend blend, uint feature, uint plane, uint low) {
    float levels[4];
    [[unroll]] for (uint c = 0u; c < 4u; c++) levels[c] = NtcTrainLatent(
        blend.pixels[c] + feature * plane, gConstants.high, NTC_TRAIN_CHANGE(blend, c, feature, low));
    precise float sum = 0.0;
    [[unroll]] for (uint c = 0u; c < 4u; c++) sum += levels[c] * blend.weights[c];
    return floor(sum) - 128.0;
}

/// Inputs of wave `pair` / 2 along both axes, at the texel or a quarter of a period later.
vec2 NtcTrainWaves(NtcTrainTexel t, uint pair) {
    precise vec2 at = vec2(t.place) * gMips.mips[t.mip].positionScale;
    at = at * float(1u << (pair >> 1)) + 0.25 * float(pair & 1u);
    precise vec2 wave = 2.0 * (at - floor(at)) - 1.0;
    precise vec2 scaled = wave * 127.5;
    return trunc(scaled);
}

void NtcStoreInputs(uint row, uint pair, vec2 inputs) {
    sHalves[(row + pair) >> 2][pair & 3u] = packHalf2x16(inputs);
}

/// Inputs of the strip's texels: eight lanes a texel, whose loads are all under way together.
void NtcGatherInputs(uvec2 record, uint strip) {
    uint lane = gl_LocalInvocationIndex & 7u, row = 4u * (gl_LocalInvocationIndex >> 3) * NTC_TRAIN_WIDE;
    NtcTrainTexel t = NtcPlaceTexel(record, strip, gl_LocalInvocationIndex >> 3);
    NtcTrainBlend high = NtcPlaceBlend(gMips.mips[t.mip].high, t.place);
    NtcTrainBlend low = NtcPlaceBlend(gMips.mips[t.mip].low, t.place);
    uint features = uint(gConstants.highFeatures); // of either mip, so that there are as many pairs
    uint highPlane = gMips.mips[t.mip].high.plane, lowPlane = gMips.mips[t.mip].low.plane;
    [[unroll]] for (uint i = 0u; i < 2u; i++) {
        uint pair = lane + 8u * i;
        if (pair < features) {
            bool isLow = 2u * pair >= features;
            NtcTrainBlend blend = high;
            if (isLow)
                blend = low;
            uint feature = isLow ? 2u * pair - features : 2u * pair, plane = isLow ? lowPlane : highPlane;
            NtcStoreInputs(row, pair,
                           vec2(NtcBlendFeature(blend, feature, plane, isLow ? 1u : 0u),
                                NtcBlendFeature(blend, feature + 1u, plane, isLow ? 1u : 0u)));
        }
    }
    vec2 others = vec2(0.0);
    if (lane < 6u)
        others = NtcTrainWaves(t, lane);
    else if (lane == 6u)
        others = vec2(gMips.mips[t.mip].lodInput);
    NtcStoreInputs(row, features + lane, others);
    if (features + 8u + lane < uint(NTC_TRAIN_USED) / 2u)
        NtcStoreInputs(row, features + 8u + lane, vec2(0.0));
}

#if !NTC_TRAIN_TRIES
uint NtcWrapLatent(int at, uint count) {
    return at < 0 ? count - 1u : uint(at) == count ? 0u : uint(at);
}

/// The rows of a grid that both rows of a strip read.
struct NtcTrainScatter {
    uint plane; // first latent of the feature
    uint width;
    uint height;
    NtcTrainTap rows[2];
};

void NtcAddColumnRow(NtcTrainScatter s, uint column, int row, float gradient) {
    NtcAddLatentGradient(s.plane + NtcWrapLatent(row, s.height) * s.width + column, gradient);
}
/// Adds the sums of a latent column's gradients in both rows of texels to up to four latents.
void NtcAddColumn(NtcTrainScatter s, int x, vec2 sums) {
    uint column = NtcWrapLatent(x, s.width);
    vec2 second = sums * vec2(s.rows[0].weight, s.rows[1].weight), first = sums - second;
    int distance = s.rows[1].first - s.rows[0].first;
    NtcAddColumnRow(s, column, s.rows[0].first, first.x + (distance == 0 ? first.y : 0.0));
    NtcAddColumnRow(s, column, s.rows[0].first + 1,
                    second.x + (distance == 0   ? second.y
                                : distance == 1 ? first.y
                                                : 0.0));
    if (distance > 1)
        NtcAddColumnRow(s, column, s.rows[1].first, first.y);
    if (distance > 0)
        NtcAddColumnRow(s, column, s.rows[1].first + 1, second.y);
}

/// Gradients of the latents from those of inputs, which are in sSums: a lane adds those of one input over
/// four columns of texels as far as they read the same latents. Whole numbers: any order of these sums gives
/// the same.
void NtcScatterGradients(uvec2 record, uint strip) {
    const uint columns = 4u;
    uint slot = gl_LocalInvocationIndex & 31u, column = columns * (gl_LocalInvocationIndex >> 5);
    uint features = uint(gConstants.highFeatures);
    if (slot >= 2u * features || column >= 16u)
        return;
    NtcTrainGrid grid = gMips.mips[record.x].high;
    if (slot >= features)
        grid = gMips.mips[record.x].low;
    NtcTrainScatter s;
    s.plane = grid.base + (slot >= features ? slot - features : slot) * grid.plane;
    s.width = grid.width;
    s.height = grid.height;
    [[unroll]] for (uint r = 0u; r < 2u; r++) s.rows[r] =
        NtcReadTap(grid.tapsY + NtcPlaceTexel(record, strip, 16u * r).place.y);
    int at = 0;
    vec2 left = vec2(0.0), right = vec2(0.0); // sums of latents `at` and at + 1 along a row
    [[dont_unroll]] for (uint i = 0u; i <= columns; i++) {
        uint texel = column + min(i, columns - 1u);
        NtcTrainTap tap = NtcReadTap(grid.tapsX + NtcPlaceTexel(record, strip, texel).place.x);
        int first = i < columns ? tap.first : at + 2; // the last time both are given away
        if (i == 0u)
            at = first;
        if (first != at) {
            NtcAddColumn(s, at, left);
            if (first != at + 1)
                NtcAddColumn(s, at + 1, right);
            left = first == at + 1 ? right : vec2(0.0);
            right = vec2(0.0);
            at = first;
        }
        vec2 gradients =
            vec2(sSums[texel * NTC_TRAIN_SUMS + slot], sSums[(texel + 16u) * NTC_TRAIN_SUMS + slot]);
        gradients *= 1.0 / 127.5;
        left += gradients * (1.0 - tap.weight);
        right += gradients * tap.weight;
    }
}
#endif

#endif
