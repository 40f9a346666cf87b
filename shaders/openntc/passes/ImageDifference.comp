// SPDX-License-Identifier: MIT
// Compute pass: squared errors of two images, per channel, exact in whole numbers.
//
// Set 0: 0 and 1 the images (sampled, any float or normalised format), 2 results. A result is five 64-bit
// numbers, low word first, NTC_DIFFERENCE_SUMS: sums of squared errors of red, green, blue and alpha in units
// of 1 / steps^2, and the number of texels that cannot be measured (passes/ImageDifference.h). They are added
// to what is there, so that several rectangles can be one result: clear them before. Push constants:
// NtcImageDifferenceConstants. Dispatch ceil(width / 64) x ceil(height / 64) groups.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "ImageDifferenceTexel.h"

layout(local_size_x = NTC_DIFFERENCE_GROUP, local_size_y = NTC_DIFFERENCE_GROUP) in;

layout(set = 0, binding = 0) uniform texture2D gFirst;
layout(set = 0, binding = 1) uniform texture2D gSecond;
layout(set = 0, binding = 2, std430) buffer Results {
    uint words[];
} gResults;
layout(push_constant) uniform ImageDifferencePush {
    NtcImageDifferenceConstants gPush;
};

const uint kLanes = uint(NTC_DIFFERENCE_GROUP * NTC_DIFFERENCE_GROUP);
shared uvec2 gSums[kLanes];

void main() {
    NtcWideSum sums[NTC_DIFFERENCE_SUMS];
    NTC_UNROLL for (int s = 0; s < NTC_DIFFERENCE_SUMS; s++) sums[s] = NtcWideSum(0u, 0u);
    // Texels of an invocation lie a group apart, so that neighbours read neighbours.
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * (NTC_DIFFERENCE_GROUP * NTC_DIFFERENCE_TEXELS);
    NTC_LOOP for (int i = 0; i < NTC_DIFFERENCE_TEXELS * NTC_DIFFERENCE_TEXELS; i++) {
        ivec2 place = corner + ivec2(gl_LocalInvocationID.xy) +
                      NTC_DIFFERENCE_GROUP * ivec2(i % NTC_DIFFERENCE_TEXELS, i / NTC_DIFFERENCE_TEXELS);
        if (place.x < gPush.width && place.y < gPush.height) {
            uint errors[NTC_DIFFERENCE_SUMS];
            NtcMeasureTexel(texelFetch(gFirst, ivec2(gPush.firstLeft, gPush.firstTop) + place, 0),
                            texelFetch(gSecond, ivec2(gPush.secondLeft, gPush.secondTop) + place, 0),
                            gPush.steps, gPush.alphaThreshold, gPush.flags, errors);
            NTC_UNROLL for (int s = 0; s < NTC_DIFFERENCE_SUMS; s++) sums[s] =
                NtcAddWide(sums[s], errors[s], 0u);
        }
    }
    NTC_UNROLL for (int s = 0; s < NTC_DIFFERENCE_SUMS; s++) {
        gSums[gl_LocalInvocationIndex] = uvec2(sums[s].low, sums[s].high);
        NTC_LOOP for (uint half_ = kLanes / 2u; half_ > 0u; half_ >>= 1u) {
            barrier();
            if (gl_LocalInvocationIndex < half_) {
                uvec2 own = gSums[gl_LocalInvocationIndex];
                uvec2 other = gSums[gl_LocalInvocationIndex + half_];
                NtcWideSum both = NtcAddWide(NtcWideSum(own.x, own.y), other.x, other.y);
                gSums[gl_LocalInvocationIndex] = uvec2(both.low, both.high);
            }
        }
        if (gl_LocalInvocationIndex == 0u) {
            // Whoever makes the low word wrap round carries: whatever the order, the sum is right at the end.
            uvec2 all = gSums[0];
            uint word = gPush.word + 2u * uint(s);
            uint before = atomicAdd(gResults.words[word], all.x);
            atomicAdd(gResults.words[word + 1u], all.y + (before + all.x < before ? 1u : 0u));
        }
        barrier();
    }
}
