// SPDX-License-Identifier: MIT
// Stability: experimental
// Mip chains, filtered in linear light.
#pragma once

#include "openntc/image/ColorEncoding.h"
#include "openntc/image/MipFilter.h"

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

/// The average of the area of each destination texel. `weights`, when there are as many as texels, are alpha:
/// a texel counts by its area times its weight (below 0: not at all), and by its area alone where all weights
/// are 0.
inline std::vector<float> AverageAreas(std::span<const float> source, int width, int height,
                                       std::span<const float> weights) {
    const int w = std::max(width / 2, 1), h = std::max(height / 2, 1);
    std::vector<float> result(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    for (int y = 0; y < h; ++y) {
        const AreaTaps rows = MakeAreaTaps(y, height, h);
        for (int x = 0; x < w; ++x) {
            const AreaTaps columns = MakeAreaTaps(x, width, w);
            float sum = 0.0f, weighted = 0.0f, weight = 0.0f;
            for (int j = 0; j < rows.count; ++j) {
                const std::size_t begin =
                    static_cast<std::size_t>(rows.first + j) * static_cast<std::size_t>(width);
                for (int i = 0; i < columns.count; ++i) {
                    const std::size_t at = begin + static_cast<std::size_t>(columns.first + i);
                    const float area = rows.weights[j] * columns.weights[i];
                    sum += area * source[at];
                    if (weights.size() == source.size()) {
                        const float share = area * std::max(weights[at], 0.0f);
                        weighted += share * source[at];
                        weight += share;
                    }
                }
            }
            if (weight > 0.0f)
                sum = weighted / weight;
            result[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
                sum;
        }
    }
    return result;
}

/// The Kaiser filter. Its negative lobes never leave the range of the source. With `weights` a texel is the
/// filtered product with alpha over the filtered alpha; where that is less than half a step of 8 bits, the
/// average of the area.
inline std::vector<float> FilterKaiser(std::span<const float> source, int width, int height,
                                       std::span<const float> weights, MipWrap wrap) {
    const AxisFilter columns = MakeKaiserFilter(width, std::max(width / 2, 1), wrap),
                     rows = MakeKaiserFilter(height, std::max(height / 2, 1), wrap);
    std::vector<float> result;
    if (weights.size() != source.size()) {
        result = FilterPlane(source, width, columns, rows);
    } else {
        constexpr float kVisible = 0.5f / 255.0f;
        std::vector<float> alpha(weights.begin(), weights.end()), product(source.begin(), source.end());
        for (std::size_t i = 0; i < alpha.size(); ++i) {
            alpha[i] = std::max(alpha[i], 0.0f);
            product[i] *= alpha[i];
        }
        alpha = FilterPlane(alpha, width, columns, rows);
        product = FilterPlane(product, width, columns, rows);
        result = AverageAreas(source, width, height, weights);
        for (std::size_t i = 0; i < result.size(); ++i) {
            if (alpha[i] >= kVisible)
                result[i] = product[i] / alpha[i];
        }
    }
    const auto [lowest, highest] = std::minmax_element(source.begin(), source.end());
    for (float& value : result)
        value = std::clamp(value, *lowest, *highest);
    return result;
}

} // namespace detail

/// One channel of the next smaller mip: texels are filtered in linear light and stored re-encoded. `source`
/// holds width x height values in rows. `weights`, when there are as many, are alpha, so that what cannot be
/// seen does not bleed into what can.
inline std::vector<float> MakeNextMip(std::span<const float> source, int width, int height, ColorSpace space,
                                      std::span<const float> weights = {}, MipRule rule = {}) {
    std::vector<float> linear(source.begin(), source.end());
    if (space != ColorSpace::Linear) {
        for (float& value : linear)
            value = DecodeColor(space, value);
    }
    std::vector<float> result = rule.filter == MipFilter::Kaiser
                                    ? detail::FilterKaiser(linear, width, height, weights, rule.wrap)
                                    : detail::AverageAreas(linear, width, height, weights);
    if (space != ColorSpace::Linear) {
        for (float& value : result)
            value = EncodeColor(space, value);
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
