// SPDX-License-Identifier: MIT
// Learning rates and phases over the course of training.
#pragma once

#include "openntc/encode/detail/Trainer.h"

#include <cmath>

namespace openntc::encode::detail {

/// Phases: latents with noise, then latents rounded for good, on which the network settles. Training latents through
/// their rounding was measured: it makes long training worse than short. Weights are quantised from the first step, so
/// that training always sees the decoder's integers.
struct Schedule {
    float networkRate = 0.02f;
    float latentRate = 0.1f;
    double warmup = 0.01; ///< fraction of the schedule in which rates rise
    double freeze = 0.9;  ///< fraction from which latents are rounded and stay

    /// The usual 0.999 remembers the large gradients of the beginning for too long: 0.3 dB less after 8000 steps.
    static constexpr float kLatentBeta2 = 0.99f, kNetworkBeta2 = 0.99f;
    /// A mask's last texels need a strong push; pushing strongly from the start costs the other channels 0.4 dB.
    static constexpr double kMaskPush = 0.5, kLastMaskPush = 64.0;
    static constexpr double kPushGrows = 0.7; ///< fraction from which the push grows, exponentially
    static constexpr double kShortRate = 0.02, kLongRate = 0.004; ///< of the network
    static constexpr float kHeadRate = 0.25f; ///< of the rate of a whole training as short
    static constexpr double kShortSteps = 12000.0;

    /// Rates for `steps` planned steps: short training must hurry, long training is hindered by large steps.
    static Schedule Make(double steps) {
        Schedule schedule;
        schedule.networkRate = static_cast<float>(std::clamp(
            kShortRate * std::pow(kShortSteps / std::max(steps, 1.0), 0.4), kLongRate, kShortRate));
        return schedule;
    }

    /// For an FP8 network that starts from a trained Int8 network, on frozen latents.
    static Schedule MakeNetworkOnly(double steps) {
        Schedule schedule = Make(steps);
        schedule.networkRate *= kHeadRate;
        schedule.latentRate = 0.0f;
        schedule.freeze = 0.0;
        schedule.warmup = 0.05;
        return schedule;
    }

    StepSettings At(double fraction) const {
        constexpr double kPi = 3.14159265358979;
        double rate = 0.5 * (1.0 + std::cos(kPi * std::min(fraction, 1.0)));
        if (fraction < warmup)
            rate *= (fraction + 1e-6) / warmup;
        StepSettings settings;
        settings.networkRate = networkRate * static_cast<float>(rate);
        settings.latentRate = fraction < freeze ? latentRate * static_cast<float>(rate) : 0.0f;
        settings.latentMode = fraction < freeze ? LatentMode::Noise : LatentMode::Round;
        const double grown = std::clamp((fraction - kPushGrows) / (1.0 - kPushGrows), 0.0, 1.0);
        settings.maskPush = static_cast<float>(kMaskPush * std::pow(kLastMaskPush / kMaskPush, grown));
        settings.latentBeta2 = kLatentBeta2;
        settings.networkBeta2 = kNetworkBeta2;
        return settings;
    }
};

} // namespace openntc::encode::detail
