// SPDX-License-Identifier: MIT
// Stability: stable
// A rectangle of texels, as decoders, slices and tiles take it.
#pragma once

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A rectangle of texels of one mip level.
struct Rect {
    int left = 0;
    int top = 0;
    int width = 0;
    int height = 0;

    friend constexpr bool operator==(const Rect&, const Rect&) noexcept = default;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
