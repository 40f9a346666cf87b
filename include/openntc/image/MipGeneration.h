// SPDX-License-Identifier: MIT
// Stability: experimental
// Mip chains by area filtering in linear light.
#pragma once

#include "openntc/image/ColorEncoding.h"

#include <algorithm>
#include <cstddef>
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
/// `source` holds width x height values in rows.
inline std::vector<float> MakeNextMip(std::span<const float> source, int width, int height,
                                      ColorSpace space) {
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
            float sum = 0.0f;
            for (int j = 0; j < rows.count; ++j) {
                const float* row = linear.data() +
                                   static_cast<std::size_t>(rows.first + j) * static_cast<std::size_t>(width);
                for (int i = 0; i < columns.count; ++i)
                    sum += rows.weights[j] * columns.weights[i] * row[columns.first + i];
            }
            result[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
                EncodeColor(space, sum);
        }
    }
    return result;
}

} // namespace openntc::image

#include "openntc/core/RestoreMacros.h"
