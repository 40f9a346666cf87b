// SPDX-License-Identifier: MIT
// Stability: experimental
// Mip chains by area filtering in linear light.
#pragma once

#include "openntc/image/ColorEncoding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::image {

/// Number of mips of a full chain, down to 1 x 1.
inline int GetFullMipCount(int width, int height) noexcept {
    int count = 1;
    while ((std::max(width, height) >> count) > 0)
        ++count;
    return count;
}

namespace detail {

/// What the source texels contribute to one destination texel along one axis: at most three of them.
struct AreaTaps {
    int first = 0, count = 0;
    float weights[3] = {};
};

/// Exact box filter from `source` to max(source / 2, 1) texels: pairs when even, three texels when odd.
inline AreaTaps MakeAreaTaps(int index, int source, int destination) {
    AreaTaps taps;
    const double step = static_cast<double>(source) / destination;
    const double begin = index * step, end = begin + step;
    taps.first = static_cast<int>(begin);
    for (int i = taps.first; i < source && i < end - 1e-9 && taps.count < 3; ++i) {
        const double covered = std::min<double>(end, i + 1) - std::max<double>(begin, i);
        taps.weights[taps.count++] = static_cast<float>(covered / step);
    }
    return taps;
}

} // namespace detail

/// One channel of the next smaller mip: texels are averaged by area in linear light and stored re-encoded.
/// `source` holds width x height values in rows. `weights`, when there are as many, are alpha: a texel counts
/// by its area times its weight (below 0: not at all), and by its area alone where all weights are 0.
inline std::vector<float> MakeNextMip(std::span<const float> source, int width, int height, ColorSpace space,
                                      std::span<const float> weights = {}) {
    const int w = std::max(width / 2, 1), h = std::max(height / 2, 1);
    std::vector<float> linear(source.begin(), source.end());
    if (space != ColorSpace::Linear) {
        for (float& value : linear)
            value = DecodeColor(space, value);
    }
    std::vector<float> result(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    for (int y = 0; y < h; ++y) {
        const detail::AreaTaps rows = detail::MakeAreaTaps(y, height, h);
        for (int x = 0; x < w; ++x) {
            const detail::AreaTaps columns = detail::MakeAreaTaps(x, width, w);
            float sum = 0.0f, weighted = 0.0f, weight = 0.0f;
            for (int j = 0; j < rows.count; ++j) {
                const std::size_t begin =
                    static_cast<std::size_t>(rows.first + j) * static_cast<std::size_t>(width);
                for (int i = 0; i < columns.count; ++i) {
                    const std::size_t at = begin + static_cast<std::size_t>(columns.first + i);
                    const float area = rows.weights[j] * columns.weights[i];
                    sum += area * linear[at];
                    if (weights.size() == source.size()) {
                        const float share = area * std::max(weights[at], 0.0f);
                        weighted += share * linear[at];
                        weight += share;
                    }
                }
            }
            if (weight > 0.0f)
                sum = weighted / weight;
            result[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
                EncodeColor(space, sum);
        }
    }
    return result;
}

/// Share of the texels that an alpha test lets through: 0 ... 1.
inline double MeasureCoverage(std::span<const float> alpha, float threshold) {
    const auto passed =
        std::count_if(alpha.begin(), alpha.end(), [&](float value) { return value >= threshold; });
    return alpha.empty() ? 0.0 : static_cast<double>(passed) / static_cast<double>(alpha.size());
}

/// Scales alpha so that as many texels as `coverage` asks for reach `threshold`, as nearly as equal values
/// allow (of two counts equally near the larger), and clamps what was scaled to at most 1 (or its largest
/// value, when that is more).
inline void ScaleToCoverage(std::vector<float>& alpha, float threshold, double coverage) {
    if (alpha.empty())
        return;
    std::vector<float> sorted = alpha;
    std::sort(sorted.begin(), sorted.end(), [](float a, float b) { return a > b; });
    const double wanted = coverage * static_cast<double>(sorted.size());
    // Ends of runs of equal values are the counts that a scale can reach; values of 0 reach nothing.
    std::size_t best = 0;
    for (std::size_t count = 1; count <= sorted.size() && sorted[count - 1] > 0.0f; ++count) {
        const bool possible = count == sorted.size() || sorted[count] < sorted[count - 1];
        if (possible &&
            std::fabs(static_cast<double>(count) - wanted) <= std::fabs(static_cast<double>(best) - wanted))
            best = count;
    }
    const float largest = std::max(sorted.front(), 1.0f);
    float scale = 1.0f;
    if (best > 0) {
        scale = threshold / sorted[best - 1];
        while (sorted[best - 1] * scale < threshold) // the quotient may have been rounded down
            scale = std::nextafter(scale, std::numeric_limits<float>::max());
    } else if (sorted.front() >= threshold) {
        scale = threshold / sorted.front();
        while (sorted.front() * scale >= threshold)
            scale = std::nextafter(scale, 0.0f);
    }
    for (float& value : alpha)
        value = std::min(value * scale, largest);
}

} // namespace openntc::image

#include "openntc/core/RestoreMacros.h"
