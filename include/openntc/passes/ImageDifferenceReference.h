// SPDX-License-Identifier: MIT
// Stability: experimental
// The pass ImageDifference on the CPU: the same shader source as C++ (needs GLM), the same numbers.
#pragma once

#include "openntc/passes/ImageDifference.h"
#include "openntc/passes/ImageDifferenceTexel.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Texels of an image as the pass sees them: four components each, rows one after the other.
struct DifferenceImage {
    std::span<const float> components; ///< 4 * width * height
    int width = 0;
    int height = 0;
};

/// What the pass adds for a request; outputOffset is not looked at. Errors: those of
/// MakeImageDifferencePass; OutOfRange if the rectangle leaves an image, or an image has fewer components
/// than its size says.
inline Expected<ImageDifferenceResult>
MeasureImageDifference(const DifferenceImage& first, const DifferenceImage& second,
                       const ImageDifferenceRequest& request) noexcept {
    OPENNTC_ASSIGN(const ImageDifferencePass pass, MakeImageDifferencePass(request));
    const NtcImageDifferenceConstants& c = pass.constants;
    const auto holds = [&c](const DifferenceImage& image, int left, int top) {
        return image.width > 0 && image.height > 0 && left <= image.width - c.width &&
               top <= image.height - c.height &&
               image.components.size() / 4 / static_cast<std::size_t>(image.width) >=
                   static_cast<std::size_t>(image.height);
    };
    if (!holds(first, c.firstLeft, c.firstTop) || !holds(second, c.secondLeft, c.secondTop))
        return Fail(Status::OutOfRange, "rect: %d x %d at %d,%d and %d,%d: must be inside both images",
                    c.width, c.height, c.firstLeft, c.firstTop, c.secondLeft, c.secondTop);
    const auto load = [](const DifferenceImage& image, int x, int y) {
        const std::size_t texel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
        const float* at = image.components.data() + 4 * texel;
        return shader::float4(at[0], at[1], at[2], at[3]);
    };
    ImageDifferenceResult result;
    for (int y = 0; y < c.height; ++y) {
        for (int x = 0; x < c.width; ++x) {
            shader::uint errors[NTC_DIFFERENCE_SUMS];
            shader::NtcMeasureTexel(load(first, c.firstLeft + x, c.firstTop + y),
                                    load(second, c.secondLeft + x, c.secondTop + y), c.steps,
                                    c.alphaThreshold, c.flags, errors);
            for (std::size_t channel = 0; channel < 4; ++channel)
                result.squaredErrors[channel] += errors[channel];
            result.unmeasured += errors[4];
        }
    }
    return result;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
