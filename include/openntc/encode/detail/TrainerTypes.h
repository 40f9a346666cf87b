// SPDX-License-Identifier: MIT
// Stability: internal
// What steps of a trainer are given and what they tell.
#pragma once

#include "openntc/encode/detail/LatentStore.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// What one step does.
struct StepSettings {
    float networkRate = 0.0f; ///< 0: the network is not trained
    float latentRate = 0.0f;  ///< 0: latents are not trained
    LatentMode latentMode = LatentMode::Noise;
    bool quantiseWeights = true;
    float maskPush = 0.0f;                             ///< of MaskLoss
    float networkBeta2 = 0.999f, latentBeta2 = 0.999f; ///< Adam's second decay
};

/// Constants of the optimiser in one step.
struct OptimiserSteps {
    AdamStep network, latents;
};

/// Squared errors in stored units.
struct LossSums {
    std::array<double, kMaxChannels> perOutput{};
    double texels = 0.0;
    double discarded = 0.0;           ///< texels of those that count for the mask only
    int mask = -1;                    ///< the channel that all texels count for
    std::uint64_t maskViolations = 0; ///< exact 0 or 1 of the mask that decodes to another UNORM8 value

    void Add(const LossSums& other) {
        for (std::size_t o = 0; o < kMaxChannels; ++o)
            perOutput[o] += other.perOutput[o];
        texels += other.texels;
        discarded += other.discarded;
        mask = std::max(mask, other.mask);
        maskViolations += other.maskViolations;
    }
    /// Peak signal-to-noise ratio in dB over `channels` channels of peak 1.
    double Psnr(int channels) const {
        double total = 0.0;
        for (double error : perOutput)
            total += error;
        return -10.0 * std::log10(total / (texels * channels - discarded * (channels - (mask >= 0 ? 1 : 0))));
    }
    /// The same of one channel.
    double ChannelPsnr(int channel) const {
        return -10.0 * std::log10(perOutput[static_cast<std::size_t>(channel)] /
                                  (texels - (channel == mask ? 0.0 : discarded)));
    }
};

/// Refinement of the latents that was done.
struct RefinementCounts {
    std::uint64_t passes = 0, rounds = 0;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
