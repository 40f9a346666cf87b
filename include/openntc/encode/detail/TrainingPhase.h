// SPDX-License-Identifier: MIT
// Stability: internal
// Parts of an encoder's run, and what follows from its input.
#pragma once

#include "openntc/core/ThreadTeam.h"
#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"

#include <algorithm>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// A part of the training of one set, with its own trainer and schedule.
struct TrainingPhase {
    double begin = 0.0, end = 1.0; ///< fractions of the whole
    std::uint64_t steps = 0;       ///< planned, unless a time limit ends training
    bool latents = true;           ///< false: latents are given, only the network is trained

    /// Fraction of the whole, of a fraction of this phase's schedule.
    double GetWhole(double fraction) const { return begin + (end - begin) * std::min(fraction, 1.0); }
};

inline int GetThreads(const EncodeOptions& options) {
    return options.threads > 0 ? options.threads : CountHardwareThreads();
}

/// Of all mips.
inline double CountTexels(const Material& material) {
    double texels = 0.0;
    for (int mip = 0; mip < material.GetMipCount(); ++mip)
        texels += static_cast<double>(material.GetWidth(mip)) * material.GetHeight(mip);
    return texels;
}

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
