// SPDX-License-Identifier: MIT
// Stability: experimental
// Stored values to linear light and back, on the host.
#pragma once

#include "openntc/format/Enums.h"

#include <cmath>

#include "openntc/core/HideMacros.h"

namespace openntc::image {

/// Linear light of a stored value (IEC 61966-2-1 for sRGB; ITU-R BT.2100 HLG with linear 1 at 0.5, 12 at 1).
inline float DecodeColor(ColorSpace space, float stored) noexcept {
    if (space == ColorSpace::sRGB)
        return stored <= 0.04045f ? stored / 12.92f : std::pow((stored + 0.055f) / 1.055f, 2.4f);
    if (space == ColorSpace::HLG) {
        const float h = std::fabs(stored);
        const float linear =
            h < 0.5f ? 4.0f * h * h : std::exp((h - 0.55991073f) / 0.17883277f) + 0.28466892f;
        return std::copysign(linear, stored);
    }
    return stored;
}

/// Stored value of linear light; the inverse of DecodeColor.
inline float EncodeColor(ColorSpace space, float linear) noexcept {
    if (space == ColorSpace::sRGB)
        return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
    if (space == ColorSpace::HLG) {
        const float e = std::fabs(linear);
        const float stored =
            e < 1.0f ? 0.5f * std::sqrt(e) : 0.17883277f * std::log(e - 0.28466892f) + 0.55991073f;
        return std::copysign(stored, linear);
    }
    return linear;
}

} // namespace openntc::image

#include "openntc/core/RestoreMacros.h"
