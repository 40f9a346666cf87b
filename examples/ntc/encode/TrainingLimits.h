// SPDX-License-Identifier: MIT
// What may be asked of training: the same for the command line and for the Python package.
#pragma once

#include "NumberLimits.h"

#include "openntc/core/Expected.h"
#include "openntc/core/ThreadTeam.h"
#include "openntc/encode/EncodeOptions.h"

#include <cstddef>
#include <cstdint>

namespace openntc::tool {

// Of all networks; which of them a network has is said by name.
inline constexpr NumberLimits kBitsPerPixelLimits{0.01, 1000.0};
inline constexpr NumberLimits kStepLimits{1, 1e9};
inline constexpr NumberLimits kSecondLimits{1e-3, 1e9};
inline constexpr NumberLimits kSeedLimits{0, 4294967295.0};
inline constexpr NumberLimits kThreadLimits{0, kMaxThreads};
inline constexpr NumberLimits kMipLimits{1, 16};
inline constexpr NumberLimits kWeightLimits{0.0, 1e6}; ///< of a texture's error; 0: ignored

/// `declared`: bit c for channel c of a texture. Errors: OutOfRange where training would have nothing to learn.
inline Expected<void> CheckWeights(const encode::EncodeOptions& options, std::uint32_t declared) {
    for (std::size_t c = 0; c < options.lossScales.size(); ++c) {
        if ((declared >> c & 1u) != 0 && options.lossScales[c] > 0.0f)
            return {};
    }
    return Fail(Status::OutOfRange, "weight: 0 for every texture: one must be above 0");
}

} // namespace openntc::tool
