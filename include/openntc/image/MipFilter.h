// SPDX-License-Identifier: MIT
// Stability: experimental
// Filters from one mip to the next smaller one: exact areas, or a windowed sinc that keeps it sharper.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::image {

/// Box: the average of the area. Kaiser: a sinc in a Kaiser window, 3 texels of the smaller mip to each side
/// (alpha 4).
enum class MipFilter { Box, Kaiser };
/// What a filter sees beyond the edges: the texels of the other side, or the last texel. Box never looks
/// there.
enum class MipWrap { Wrap, Clamp };

/// How the mips of a channel are made.
struct MipRule {
    MipFilter filter = MipFilter::Box;
    MipWrap wrap = MipWrap::Wrap;
};

namespace detail {

inline constexpr double kKaiserWidth = 3.0, kKaiserAlpha = 4.0;

/// Modified Bessel function of the first kind, order 0.
inline double BesselI0(double x) {
    double sum = 1.0, term = 1.0;
    for (int k = 1; term > 1e-17 * sum; ++k) {
        const double factor = x / (2.0 * k);
        term *= factor * factor;
        sum += term;
    }
    return sum;
}

/// The Kaiser filter, not normalised, `x` texels of the smaller mip from its centre.
inline double GetKaiserWeight(double x) {
    constexpr double kPi = 3.14159265358979323846;
    const double t = x / kKaiserWidth;
    if (t < -1.0 || t > 1.0)
        return 0.0;
    const double sinc = std::fabs(x) < 1e-9 ? 1.0 : std::sin(kPi * x) / (kPi * x);
    return sinc * BesselI0(kKaiserAlpha * std::sqrt(1.0 - t * t)) / BesselI0(kKaiserAlpha);
}

/// Which source texels make each destination texel along one axis: `count` indices and weights for each,
/// weights of sum 1.
struct AxisFilter {
    int count = 0;
    std::vector<int> indices;
    std::vector<float> weights;
};

inline AxisFilter MakeKaiserFilter(int source, int destination, MipWrap wrap) {
    const double ratio = static_cast<double>(source) / destination;
    const double reach = kKaiserWidth * ratio;
    AxisFilter filter;
    filter.count = static_cast<int>(std::floor(2.0 * reach)) + 1;
    std::vector<double> weights(static_cast<std::size_t>(filter.count));
    for (int i = 0; i < destination; ++i) {
        const double center = (i + 0.5) * ratio - 0.5;
        const int first = static_cast<int>(std::ceil(center - reach));
        double sum = 0.0;
        for (int k = 0; k < filter.count; ++k) {
            const double weight = GetKaiserWeight((first + k - center) / ratio);
            weights[static_cast<std::size_t>(k)] = weight;
            sum += weight;
        }
        for (int k = 0; k < filter.count; ++k) {
            const int at = first + k;
            const int wrapped = (at % source + source) % source;
            filter.indices.push_back(wrap == MipWrap::Wrap ? wrapped : std::clamp(at, 0, source - 1));
            filter.weights.push_back(static_cast<float>(weights[static_cast<std::size_t>(k)] / sum));
        }
    }
    return filter;
}

/// width x height values, filtered along both axes.
inline std::vector<float> FilterPlane(std::span<const float> source, int width, const AxisFilter& columns,
                                      const AxisFilter& rows) {
    const auto w = static_cast<std::size_t>(width), columnTaps = static_cast<std::size_t>(columns.count),
               rowTaps = static_cast<std::size_t>(rows.count);
    const std::size_t outWidth = columns.indices.size() / columnTaps,
                      outHeight = rows.indices.size() / rowTaps;
    const std::size_t height = source.size() / w;
    std::vector<float> narrow(outWidth * height), result(outWidth * outHeight);
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < outWidth; ++x) {
            float sum = 0.0f;
            for (std::size_t k = x * columnTaps; k < (x + 1) * columnTaps; ++k)
                sum += columns.weights[k] * source[y * w + static_cast<std::size_t>(columns.indices[k])];
            narrow[y * outWidth + x] = sum;
        }
    }
    for (std::size_t y = 0; y < outHeight; ++y) {
        for (std::size_t k = y * rowTaps; k < (y + 1) * rowTaps; ++k) {
            const float* row = narrow.data() + static_cast<std::size_t>(rows.indices[k]) * outWidth;
            for (std::size_t x = 0; x < outWidth; ++x)
                result[y * outWidth + x] += rows.weights[k] * row[x];
        }
    }
    return result;
}

} // namespace detail

} // namespace openntc::image

#include "openntc/core/RestoreMacros.h"
