// SPDX-License-Identifier: MIT
// What is hard about drawing one texel in the place of a filter: that its probability is its weight, and
// where it is. Each case compares with the definition in real numbers, or texel by texel.
#include "HardCases.h"

#include "openntc/StochasticFiltering.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace numerics {

namespace {

namespace stf = openntc::shader;

/// A kernel's weight at a distance in texels, as its formula says.
double GetRealWeight(std::uint32_t kernel, double distance) {
    const double d = std::fabs(distance),
                 b = kernel == NTC_KERNEL_CUBIC ? 1 : (kernel == NTC_KERNEL_MITCHELL ? 1.0 / 3 : 0);
    const double c = kernel == NTC_KERNEL_CUBIC ? 0 : (kernel == NTC_KERNEL_MITCHELL ? 1.0 / 3 : 0.5);
    if (kernel == NTC_KERNEL_BILINEAR)
        return std::max(1 - d, 0.0);
    if (d >= 2)
        return 0;
    // Mitchell and Netravali 1988: B-spline (1, 0), Catmull-Rom (0, 1/2), theirs (1/3, 1/3).
    if (d < 1)
        return ((12 - 9 * b - 6 * c) * d * d * d + (-18 + 12 * b + 6 * c) * d * d + 6 - 2 * b) / 6;
    return ((-b - 6 * c) * d * d * d + (6 * b + 30 * c) * d * d + (-12 * b - 48 * c) * d + 8 * b + 24 * c) /
           6;
}

Measurement MeasureTapProbabilities() {
    Measurement measurement;
    for (std::uint32_t kernel = NTC_KERNEL_BILINEAR; kernel <= NTC_KERNEL_MITCHELL; ++kernel) {
        for (const std::uint32_t fraction : {0u, 1u, 2u, 777u, 13107u, 32767u, 32768u, 50001u, 65535u}) {
            const stf::NtcTexelCoord coord{fraction >= 32768 ? 6 : 5, (fraction + 32768) & 0xFFFFu};
            const stf::NtcStfAxis axis =
                stf::NtcStfGetAxis(stf::NtcStfMakeSampler(kernel, NTC_WRAP_CLAMP), coord);
            double counts[4] = {}, norm = 0;
            for (std::uint32_t random = 0; random < 65536; ++random)
                counts[stf::NtcStfDraw(axis, random, NTC_STF_ALL)] += 1;
            const double place = 5 + fraction / 65536.0;
            for (int k = 0; k < axis.count; ++k)
                norm += std::fabs(GetRealWeight(kernel, axis.first + k - place));
            for (int k = 0; k < axis.count; ++k) {
                const double weight = std::fabs(GetRealWeight(kernel, axis.first + k - place)) / norm;
                measurement.worst = std::max(measurement.worst, std::fabs(counts[k] - 65536 * weight));
            }
        }
    }
    return measurement;
}

/// Texel of an index by walking there, a step at a time.
int Walk(int index, int size, std::uint32_t wrap) {
    int texel = 0, step = 1;
    for (int i = 0; i != index; i += index > 0 ? 1 : -1) {
        if (wrap == NTC_WRAP_REPEAT) {
            texel = (texel + (index > 0 ? 1 : size - 1)) % size;
        } else if (wrap == NTC_WRAP_CLAMP) {
            texel = index > 0 ? std::min(texel + 1, size - 1) : 0;
        } else { // a mirror stands between two texels: the one at the edge comes twice
            if (index < 0 && i == 0)
                continue; // the first step down meets texel 0 again
            const int next = texel + step;
            if (next < 0 || next >= size)
                step = -step;
            else
                texel = next;
        }
    }
    return texel;
}

Measurement MeasureFilterEdges() {
    Measurement measurement;
    for (std::uint32_t wrap = NTC_WRAP_REPEAT; wrap <= NTC_WRAP_MIRROR; ++wrap) {
        for (const int size : {1, 2, 3, 5, 37}) {
            for (int index = -80; index <= 80; ++index)
                measurement.worst +=
                    stf::NtcAddressTexel(index, size, wrap) == Walk(index, size, wrap) ? 0 : 1;
        }
    }
    // u = 1 with clamping reads the last texel twice, with repeating the last and the first: the pair of u =
    // 0.
    for (const std::uint32_t size : {1u, 7u, 4096u}) {
        const auto pair = [size](float u, std::uint32_t wrap, int k) {
            const stf::NtcTexelCoord first = stf::NtcGetBilinearCoord(stf::NtcGetTexelCoord(u, size, wrap));
            return stf::NtcAddressTexel(first.texel + k, static_cast<int>(size), wrap);
        };
        const int last = static_cast<int>(size) - 1;
        measurement.worst += pair(1, NTC_WRAP_CLAMP, 0) == last && pair(1, NTC_WRAP_CLAMP, 1) == last ? 0 : 1;
        for (const float u : {0.0f, 1.0f})
            measurement.worst +=
                pair(u, NTC_WRAP_REPEAT, 0) == last && pair(u, NTC_WRAP_REPEAT, 1) == 0 ? 0 : 1;
    }
    return measurement;
}

/// How far coordinates are from u * size, of what is allowed: 1 + size / 256 units of 2^-16 texel.
Measurement MeasureCoordinates() {
    Measurement measurement;
    std::uint32_t state = 9;
    for (int i = 0; i < 200000; ++i) {
        state = state * 747796405u + 2891336453u;
        const std::uint32_t size = 1 + (state >> 18);
        state = state * 747796405u + 2891336453u;
        const float u =
            (static_cast<float>(state >> 8) / 16777216.0f - 0.5f) * static_cast<float>(1 << (i % 7));
        const stf::NtcTexelCoord coord = stf::NtcGetTexelCoord(u, size, NTC_WRAP_CLAMP);
        const double exact = double{u} * size; // 38 bits
        const double off = std::fabs(coord.texel + coord.fraction / 65536.0 - exact) * 65536;
        measurement.worst = std::max(measurement.worst, off / (1 + size / 256.0));
    }
    return measurement;
}

Measurement MeasureNegativeWeights() {
    Measurement measurement;
    const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(64, 64, 1);
    for (std::uint32_t kernel = NTC_KERNEL_CATMULL_ROM; kernel <= NTC_KERNEL_MITCHELL; ++kernel) {
        const stf::NtcStfSampler settings = stf::NtcStfMakeSampler(kernel, NTC_WRAP_REPEAT);
        for (int i = 0; i < 4096; ++i) {
            const stf::float2 uv(static_cast<float>(i % 64) / 4096.0f, static_cast<float>(i / 64) / 4096.0f);
            const stf::NtcStfPair pair =
                stf::NtcStfSamplePair(settings, extent, uv, stf::NtcStfMakeFootprint(settings, extent, 0),
                                      {0, 0, 0, static_cast<std::uint32_t>(i) * 16});
            const double sum = double{pair.first.scale} + double{pair.second.scale};
            measurement.worst = std::max(measurement.worst, std::fabs(sum - 1));
        }
    }
    return measurement;
}

Measurement MeasureDerivatives() {
    Measurement measurement;
    const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                         3e38f};
    const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(300, 200, 9);
    for (const std::uint32_t anisotropy : {1u, 2u, 16u}) {
        stf::NtcStfSampler settings = stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT);
        settings.maxAnisotropy = anisotropy;
        const auto expect = [&](stf::float2 ddx, stf::float2 ddy, int lod) {
            const stf::NtcStfFootprint footprint = stf::NtcStfGetFootprint(settings, extent, ddx, ddy);
            measurement.worst += footprint.lod == lod && footprint.taps <= anisotropy ? 0 : 1;
        };
        expect({0, 0}, {0, 0}, 0);
        for (const float value : bad) {
            for (const float sign : {1.0f, -1.0f}) {
                expect({value * sign, 0}, {0, value}, 8 * 65536);
                expect({0, value * sign}, {value, 0}, 8 * 65536);
            }
        }
    }
    return measurement;
}

constexpr HardCase kFilterCases[] = {
    {"filtering-probabilities",
     "A texel in the place of a filter must be drawn with its weight as probability, or means converge to "
     "something else.",
     "Noise of 8 bits used alone (off by up to 1/256 a weight); decisions in floats, which lose bits as they "
     "are reused.",
     "Weights are integers, and a draw compares integers: over all 65536 numbers each tap is counted.", 1.01,
     MeasureTapProbabilities},
    {"filtering-edges", "Kernels reach beyond the texture, and beyond mips of one texel several times.",
     "Clamping coordinates to 0 ... 1 before a kernel that is wider than bilinear; % of negative numbers.",
     "Texels are addressed one by one, after the kernel: walked to a step at a time here.", 0,
     MeasureFilterEdges},
    {"filtering-coordinates",
     "u times the size, rounded, has no fraction left where u is large: texels jump, and differ from device "
     "to device.",
     "frac(u * size) in binary32.",
     "Whole periods are taken off first, exactly; the error is held against 1 + size / 256 units of 2^-16 "
     "texel.",
     1, MeasureCoordinates},
    {"filtering-negative-weights", "With negative weights, single texels with signs make noise of constants.",
     "Catmull-Rom with one texel: a white wall has a variance of up to 1.44.",
     "A texel of the positive weights and one of the negative ones, scaled by Q and 1 - Q.", 0x1p-21,
     MeasureNegativeWeights},
    {"filtering-derivatives",
     "Derivatives of 0, infinite ones and NaN, which a fract() by hand or a degenerate triangle makes.",
     "log2 of 0; max() and comparisons that drop NaN or keep it, by device.",
     "Squared lengths are compared as bits without their sign, and the logarithm is made of integers: NaN is "
     "the coarsest mip.",
     0, MeasureDerivatives}};

} // namespace

std::span<const HardCase> ListFilterCases() {
    return kFilterCases;
}

} // namespace numerics
