// SPDX-License-Identifier: MIT
// Stability: experimental
// How many training steps a set of a size needs before its file is of use.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// Steps below which a result is not worth having, for a set with so many texels in all its mips. A step
/// visits 4096 texels and moves their latents by at most 0.1 of their range, by half of that on average over
/// the half cosine of the rates: a latent needs 20 visits to cross its range. And the last tenth, in which
/// the network settles on rounded latents, has to be as long as the 100 steps that the optimiser's second
/// moment (decay 0.99) remembers.
inline std::uint64_t GetUsefulSteps(double texels) {
    constexpr double kTexelsPerStep = 4096.0, kVisits = 20.0;
    constexpr std::uint64_t kLeastSteps = 1000;
    return std::max(kLeastSteps, static_cast<std::uint64_t>(std::ceil(kVisits * texels / kTexelsPerStep)));
}

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
