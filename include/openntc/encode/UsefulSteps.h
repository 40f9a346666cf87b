// SPDX-License-Identifier: MIT
// Stability: experimental
// How many training steps a set of a size needs: before its file is of use, and for each class of quality.
#pragma once

#include "openntc/encode/EncodeOptions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

inline constexpr double kTexelsPerStep = 4096.0; ///< that a training step visits

/// Steps below which a result is not worth having, for a set with so many texels in all its mips. A step
/// visits 4096 texels and moves their latents by at most 0.1 of their range, by half of that on average over
/// the half cosine of the rates: a latent needs 20 visits to cross its range. And the last tenth, in which
/// the network settles on rounded latents, has to be as long as the 100 steps that the optimiser's second
/// moment (decay 0.99) remembers.
inline std::uint64_t GetUsefulSteps(double texels) {
    constexpr double kVisits = 20.0;
    constexpr std::uint64_t kLeastSteps = 1000;
    return std::max(kLeastSteps, static_cast<std::uint64_t>(std::ceil(kVisits * texels / kTexelsPerStep)));
}

/// Steps of a class of quality for a set with so many texels in all its mips and so many channels in use. The
/// network needs its number of steps whatever the size; latents need their number of visits of each texel,
/// and the more of them the more channels their texels have to serve (docs/encoder.md has the curves).
inline std::uint64_t GetEffortSteps(Effort effort, double texels, int channels) {
    struct Class {
        double network; ///< steps
        double visits;  ///< of a texel with kChannels channels
    };
    constexpr double kChannels = 10.0, kLeastShare = 0.5;
    const Class needs = effort == Effort::Fast     ? Class{2000.0, 188.0}
                        : effort == Effort::Normal ? Class{10000.0, 3500.0}
                                                   : Class{30000.0, 10000.0};
    const double share = kLeastShare + (1.0 - kLeastShare) * std::min(channels / kChannels, 1.0);
    const double steps = std::ceil(needs.network + needs.visits * share * texels / kTexelsPerStep);
    return std::max(static_cast<std::uint64_t>(steps), GetUsefulSteps(texels));
}

/// Texels of a training step on a device, where larger steps cost less a texel, for a set with so many texels
/// in all its mips: a sixteenth of them, so that a pass over the set is many steps.
inline int GetDeviceBatchTexels(double texels) {
    constexpr int kLeast = 4096, kMost = 65536;
    int batch = kMost;
    while (batch > kLeast && batch > texels / 16.0)
        batch /= 2;
    return batch;
}

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
