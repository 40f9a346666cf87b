// SPDX-License-Identifier: MIT
// What tests of filtering share: samplers by name, distributions of texels over all random numbers, values.
#pragma once

#include "openntc/StochasticFiltering.h"

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

namespace openntc_tests {

namespace stf = openntc::shader;

inline constexpr std::uint32_t kWraps[] = {NTC_WRAP_REPEAT, NTC_WRAP_CLAMP, NTC_WRAP_MIRROR, NTC_WRAP_BORDER};

struct NamedFilter {
    const char* name;
    stf::NtcStfSampler settings;
};

/// The filters of the specification.
inline std::vector<NamedFilter> GetFilters(std::uint32_t wrap) {
    std::vector<NamedFilter> filters = {{"nearest", stf::NtcStfMakeSampler(NTC_KERNEL_NEAREST, wrap)},
                                        {"bilinear", stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, wrap)},
                                        {"trilinear", stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, wrap)},
                                        {"cubic", stf::NtcStfMakeSampler(NTC_KERNEL_CUBIC, wrap)},
                                        {"Catmull-Rom", stf::NtcStfMakeSampler(NTC_KERNEL_CATMULL_ROM, wrap)},
                                        {"Mitchell", stf::NtcStfMakeSampler(NTC_KERNEL_MITCHELL, wrap)},
                                        {"Gaussian", stf::NtcStfMakeGaussian(0.7f, wrap)},
                                        {"anisotropic", stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, wrap)}};
    filters[1].settings.mips = NTC_MIPS_NEAREST;
    filters[7].settings.maxAnisotropy = 16;
    return filters;
}

/// A coordinate whose even kernels begin at texel 5 with this fraction.
inline stf::NtcTexelCoord MakeShiftedCoord(std::uint32_t fraction) {
    stf::NtcTexelCoord coord;
    coord.texel = fraction >= 32768 ? 6 : 5;
    coord.fraction = (fraction + 32768) & 0xFFFFu;
    return coord;
}

/// How often each tap of an axis is drawn over all 65536 numbers.
inline std::vector<int> CountDraws(const stf::NtcStfAxis& axis, std::uint32_t part) {
    std::vector<int> counts(static_cast<std::size_t>(axis.count));
    for (std::uint32_t r = 0; r < 65536; ++r)
        ++counts[static_cast<std::size_t>(stf::NtcStfDraw(axis, r, part))];
    return counts;
}

/// A texel's value, 0 ... 1, white noise; the border's is 1/4.
inline double GetValue(const stf::NtcStfTap& tap) {
    if (tap.isBorder)
        return 0.25;
    const stf::uint4 words =
        stf::NtcStfPcg3d(static_cast<std::uint32_t>(tap.texel.x), static_cast<std::uint32_t>(tap.texel.y),
                         static_cast<std::uint32_t>(tap.mip) + 77);
    return words.x / 4294967296.0;
}

/// Mean and variance of a lookup, by all its taps.
struct FilterMoments {
    double mean = 0, variance = 0;
};

inline FilterMoments GetMoments(const stf::NtcStfSampler& settings, const stf::NtcStfExtent& extent,
                                stf::float2 uv, const stf::NtcStfFootprint& footprint) {
    const std::uint32_t count = stf::NtcStfGetTapCount(settings, extent, footprint);
    double mean = 0, square = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const stf::NtcStfTap tap = stf::NtcStfGetTap(settings, extent, uv, footprint, i);
        const double value = GetValue(tap);
        mean += double{tap.scale} * value;
        square += double{tap.scale} * value * value;
    }
    return {mean, square - mean * mean};
}

} // namespace openntc_tests
