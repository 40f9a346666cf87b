// SPDX-License-Identifier: MIT
// Stability: experimental
// What the compute pass openntc/passes/ImageDifference needs, and its result.
//
// Errors are whole numbers: a component is rounded to the nearest multiple of 1 / steps, differences are
// squared, and sums have 64 bits. So they are the same on every device and in any order, and exact where
// components are multiples of 1 / steps: UNORM8 with 255 steps, UNORM16 with 65535, floats that are whole
// numbers of steps. Of other floats a difference is off by 1 / steps at most. A difference counts as
// 65535 / steps at most, a component as 2^22 / steps, and NaN as 0; texels where that happens are counted
// (unmeasured), so that a result says whether it is one.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/FloatBits.h"
#include "openntc/core/Rect.h"
#include "openntc/passes/ImageDifferenceConstants.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

inline constexpr float kUnorm8Steps = 255.0f;
inline constexpr float kUnorm16Steps = 65535.0f;
/// Bytes of a result in the buffer.
inline constexpr std::size_t kImageDifferenceBytes = std::size_t{8} * NTC_DIFFERENCE_SUMS;

struct ImageDifferenceRequest {
    Rect rect;          ///< of the first image, texels; inside both images, which the pass does not know
    int secondLeft = 0; ///< where the rectangle is in the second image
    int secondTop = 0;
    float steps = kUnorm8Steps; ///< > 0
    /// Where both alphas are below it, the other channels have no error.
    std::optional<float> alphaThreshold;
    /// Errors are of ln(1 + |value|), in all channels; not exact, as logarithms differ between devices.
    bool isLogarithmic = false;
    std::uint64_t outputOffset = 0; ///< of the result in its buffer: bytes, a multiple of 4
};

struct ImageDifferencePass {
    NtcImageDifferenceConstants constants{}; ///< push constants
    std::uint32_t groups[3] = {1, 1, 1};
};

struct ImageDifferenceResult {
    std::array<std::uint64_t, 4> squaredErrors{}; ///< red, green, blue, alpha: in 1 / steps^2
    std::uint64_t unmeasured = 0;                 ///< texels with something beyond what is measured

    friend constexpr bool operator==(const ImageDifferenceResult&,
                                     const ImageDifferenceResult&) noexcept = default;

    /// Mean squared error of channel 0 … 3 over `texels`, which must not be 0.
    double GetMeanSquaredError(std::size_t channel, std::uint64_t texels, float steps) const noexcept {
        const double unit = 1.0 / static_cast<double>(steps);
        return static_cast<double>(squaredErrors[channel]) * unit * unit / static_cast<double>(texels);
    }
};

/// Constants and dispatch of one comparison. The result is added to what the buffer holds: clear its
/// kImageDifferenceBytes before the first rectangle. Errors: OutOfRange for an empty rectangle, one of more
/// than 2^32 texels or that begins below 0, and for an offset that is no multiple of 4 or 2^34 or more;
/// InvalidArgument for steps that are not positive and finite, and a threshold that is NaN.
inline Expected<ImageDifferencePass> MakeImageDifferencePass(const ImageDifferenceRequest& request) noexcept {
    const Rect& rect = request.rect;
    if (rect.width < 1 || rect.height < 1)
        return Fail(Status::OutOfRange, "rect: %d x %d: must not be empty", rect.width, rect.height);
    if (static_cast<std::uint64_t>(rect.width) * static_cast<std::uint64_t>(rect.height) > std::uint64_t{1}
                                                                                               << 32)
        return Fail(Status::OutOfRange, "rect: %d x %d: at most 2^32 texels", rect.width, rect.height);
    const auto isInside = [](int start, int size) {
        return start >= 0 && start <= std::numeric_limits<int>::max() - size;
    };
    if (!isInside(rect.left, rect.width) || !isInside(rect.top, rect.height) ||
        !isInside(request.secondLeft, rect.width) || !isInside(request.secondTop, rect.height))
        return Fail(Status::OutOfRange, "rect: at %d,%d and %d,%d: must be 0 or more, ends below 2^31",
                    rect.left, rect.top, request.secondLeft, request.secondTop);
    if (!(request.steps > 0.0f) || !IsMagnitudeAtMost(request.steps, std::numeric_limits<float>::max()))
        return Fail(Status::InvalidArgument, "steps: %g: must be positive and finite",
                    static_cast<double>(request.steps));
    const float threshold = request.alphaThreshold.value_or(0.0f);
    if (!IsMagnitudeAtMost(threshold, std::numeric_limits<float>::infinity()))
        return Fail(Status::InvalidArgument, "alphaThreshold: NaN: must be a number");
    if (request.outputOffset % 4 != 0 || request.outputOffset / 4 > UINT32_MAX - 2 * NTC_DIFFERENCE_SUMS)
        return Fail(Status::OutOfRange, "outputOffset: %llu: must be a multiple of 4, below 2^34 - 40",
                    static_cast<unsigned long long>(request.outputOffset));
    ImageDifferencePass pass;
    NtcImageDifferenceConstants& c = pass.constants;
    c.firstLeft = rect.left;
    c.firstTop = rect.top;
    c.secondLeft = request.secondLeft;
    c.secondTop = request.secondTop;
    c.width = rect.width;
    c.height = rect.height;
    c.steps = request.steps;
    c.alphaThreshold = threshold;
    c.flags = (request.alphaThreshold ? NTC_DIFFERENCE_ALPHA : 0u) |
              (request.isLogarithmic ? NTC_DIFFERENCE_LOGARITHM : 0u);
    c.word = static_cast<std::uint32_t>(request.outputOffset / 4);
    constexpr std::uint32_t kSide = NTC_DIFFERENCE_GROUP * NTC_DIFFERENCE_TEXELS;
    pass.groups[0] = (static_cast<std::uint32_t>(rect.width) + kSide - 1) / kSide;
    pass.groups[1] = (static_cast<std::uint32_t>(rect.height) + kSide - 1) / kSide;
    return pass;
}

/// The result from the ten words that the pass has written.
inline ImageDifferenceResult
ReadImageDifference(std::span<const std::uint32_t, 2 * NTC_DIFFERENCE_SUMS> words) noexcept {
    ImageDifferenceResult result;
    const auto get = [&words](std::size_t i) { return words[2 * i] | std::uint64_t{words[2 * i + 1]} << 32; };
    for (std::size_t channel = 0; channel < 4; ++channel)
        result.squaredErrors[channel] = get(channel);
    result.unmeasured = get(4);
    return result;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
