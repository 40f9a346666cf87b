// SPDX-License-Identifier: MIT
// Kernels along one axis, as integers whose sum is known exactly.
#ifndef OPENNTC_STF_KERNELS_H
#define OPENNTC_STF_KERNELS_H

#include "StfTypes.h"
#include "openntc/Portability.h"
#include "openntc/TexelCoords.h"

NTC_NAMESPACE_BEGIN

/// The taps of a kernel: texels first ... first + count - 1, before addressing, with weights of which `unit`
/// is the reciprocal of the sum.
struct NtcStfAxis {
    int first;
    int count;
    float unit;
    int weights[NTC_STF_MOST_TAPS];
};

NTC_FUNCTION float NtcStfGetWeight(NtcStfAxis axis, int tap) {
    return NtcMultiply(float(axis.weights[tap]), axis.unit);
}

/// f^3 in 2^-24, rounded down, of f in 2^-16 below 1.
NTC_FUNCTION int NtcStfCube(uint f) {
    uint square = f * f;
    return int(((square >> 16) * f + (((square & 0xFFFFu) * f) >> 16)) >> 8);
}

/// The weight of one tap of a Gaussian before the sum is known, in 2^-24. `place`: its distance in texels.
/// What the edge would have is subtracted, which makes the filter continuous.
NTC_FUNCTION int NtcStfGetGaussian(float place, float exponent, float edge) {
    float weight = exp(place * place * exponent) - edge;
    return weight > 0.0f ? int(weight * 16777216.0f) : 0;
}

/// The kernel's taps at a coordinate.
NTC_FUNCTION NtcStfAxis NtcStfGetAxis(NtcStfSampler settings, NtcTexelCoord coord) {
    NtcStfAxis axis;
    for (int k = 0; k < NTC_STF_MOST_TAPS; k++)
        axis.weights[k] = 0;
    if (settings.kernelType == uint(NTC_KERNEL_NEAREST)) {
        axis.first = coord.texel;
        axis.count = 1;
        axis.unit = 1.0f;
        axis.weights[0] = 1;
        return axis;
    }
    NtcTexelCoord start = NtcGetBilinearCoord(coord);
    int f = int(start.fraction);
    if (settings.kernelType == uint(NTC_KERNEL_BILINEAR)) {
        axis.first = start.texel;
        axis.count = 2;
        axis.unit = 1.52587890625e-5f; // 2^-16
        axis.weights[0] = 65536 - f;
        axis.weights[1] = f;
        return axis;
    }
#if NTC_STF_MOST_TAPS >= 4
    if (settings.kernelType == uint(NTC_KERNEL_GAUSSIAN)) {
        int radius = min(max(settings.radius, 1), NTC_STF_MOST_TAPS / 2);
        float sigma = settings.sigma >= 0.5f ? settings.sigma : 0.5f; // narrower, the weights may vanish
        float exponent = -0.5f / (sigma * sigma);
        float edge = exp(float(radius * radius) * exponent);
        int sum = 0;
        axis.first = start.texel - radius + 1;
        axis.count = 2 * radius;
        for (int k = 0; k < 2 * radius; k++) {
            float place = float(k - radius + 1) - float(f) * 1.52587890625e-5f;
            axis.weights[k] = NtcStfGetGaussian(place, exponent, edge);
            sum += axis.weights[k];
        }
        axis.unit = 1.0f / float(sum);
        return axis;
    }
    const int one = 16777216;
    int t1 = f * 256;
    int t2 = int((start.fraction * start.fraction) >> 8);
    int t3 = NtcStfCube(start.fraction);
    axis.first = start.texel - 1;
    axis.count = 4;
    if (settings.kernelType == uint(NTC_KERNEL_CUBIC)) {
        axis.unit = 9.93410754e-9f; // 1 / (6 * 2^24)
        axis.weights[0] = f == 0 ? one : NtcStfCube(65536u - start.fraction);
        axis.weights[1] = 4 * one - 6 * t2 + 3 * t3;
        axis.weights[3] = t3;
        axis.weights[2] = 6 * one - axis.weights[0] - axis.weights[1] - axis.weights[3];
    } else if (settings.kernelType == uint(NTC_KERNEL_CATMULL_ROM)) {
        axis.unit = 2.98023224e-8f; // 1 / (2 * 2^24)
        axis.weights[0] = min(2 * t2 - t1 - t3, 0);
        axis.weights[1] = 2 * one - 5 * t2 + 3 * t3;
        axis.weights[3] = min(t3 - t2, 0);
        axis.weights[2] = 2 * one - axis.weights[0] - axis.weights[1] - axis.weights[3];
    } else {
        axis.unit = 3.31136918e-9f; // 1 / (18 * 2^24)
        axis.weights[0] = one - 9 * t1 + 15 * t2 - 7 * t3;
        axis.weights[1] = 16 * one - 36 * t2 + 21 * t3;
        axis.weights[3] = 7 * t3 - 6 * t2;
        axis.weights[2] = 18 * one - axis.weights[0] - axis.weights[1] - axis.weights[3];
    }
#endif
    return axis;
}

// Which weights a draw is made from.
#define NTC_STF_ALL 0 // magnitudes
#define NTC_STF_POSITIVE 1
#define NTC_STF_NEGATIVE 2 // magnitudes of negative ones

/// What a tap counts in a draw.
NTC_FUNCTION uint NtcStfGetMass(NtcStfAxis axis, int tap, uint part) {
    int weight = axis.weights[tap];
    if (part == uint(NTC_STF_NEGATIVE))
        return weight < 0 ? uint(-weight) : 0u;
    return weight >= 0 ? uint(weight) : (part == uint(NTC_STF_ALL) ? uint(-weight) : 0u);
}

NTC_FUNCTION uint NtcStfGetTotal(NtcStfAxis axis, uint part) {
    uint total = 0u;
    for (int k = 0; k < axis.count; k++)
        total += NtcStfGetMass(axis, k, part);
    return total;
}

/// The first tap at which the sum of masses exceeds random / 65536 of their total: a draw, by inversion. The
/// product is cut to 32 bits without changing what it is compared with; totals are below 2^29.
NTC_FUNCTION int NtcStfDraw(NtcStfAxis axis, uint random, uint part) {
    uint total = NtcStfGetTotal(axis, part);
    uint at = random * (total >> 16) + ((random * (total & 0xFFFFu)) >> 16);
    uint sum = 0u;
    int chosen = -1;
    for (int k = 0; k < axis.count; k++) {
        sum += NtcStfGetMass(axis, k, part);
        if (chosen < 0 && at < sum)
            chosen = k;
    }
    return max(chosen, 0); // a part without mass has no draw
}

/// True for kernels with negative weights.
NTC_FUNCTION bool NtcStfIsSigned(NtcStfSampler settings) {
    return settings.kernelType == uint(NTC_KERNEL_CATMULL_ROM) ||
           settings.kernelType == uint(NTC_KERNEL_MITCHELL);
}

NTC_NAMESPACE_END

#endif
