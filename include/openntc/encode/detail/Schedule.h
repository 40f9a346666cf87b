// SPDX-License-Identifier: MIT
// Stability: internal
// Learning rates and phases over the course of training.
#pragma once

#include "openntc/encode/detail/Trainer.h"

#include <cmath>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Phases: latents with noise, then latents rounded for good, on which the network settles. Training latents
/// through their rounding was measured: it makes long training worse than short. Weights are quantised from
/// the first step, so that training always sees the decoder's integers.
struct Schedule {
    float networkRate = 0.02f;
    float latentRate = 0.1f;
    double warmup = 0.01; ///< fraction of the schedule in which rates rise
    double freeze = 0.9;  ///< fraction from which latents are rounded and stay

    /// The usual 0.999 remembers the large gradients of the beginning for too long: 0.3 dB less after 8000
    /// steps.
    static constexpr float kLatentBeta2 = 0.99f, kNetworkBeta2 = 0.99f;
    /// A mask's last texels need a strong push; pushing strongly from the start costs the other channels 0.4
    /// dB.
    static constexpr double kMaskPush = 0.5, kLastMaskPush = 64.0;
    static constexpr double kPushGrows = 0.7; ///< fraction from which the push grows, exponentially
    static constexpr double kShortRate = 0.02, kLongRate = 0.004; ///< of the network
    /// Of an FP8 network: how far its rate lets a weight go in all steps, about the distance between E4M3's
    /// numbers around 1. Larger rates end worse: weights still change places when the steps end.
    static constexpr double kHeadWay = 0.1;
    static constexpr double kMostHeadRate = 0.005;
    static constexpr double kShortSteps = 12000.0;
    /// Of that rate, for generation 3, whose small steps have noisier gradients.
    static constexpr float kBlendedRate = 0.7f;

    /// Rates for `steps` planned steps: short training must hurry, long training is hindered by large steps.
    /// `blended`: generation 3.
    static Schedule Make(double steps, bool blended = false) {
        Schedule schedule;
        schedule.networkRate = static_cast<float>(std::clamp(
            kShortRate * std::pow(kShortSteps / std::max(steps, 1.0), 0.4), kLongRate, kShortRate));
        if (blended)
            schedule.networkRate *= kBlendedRate;
        return schedule;
    }

    /// For an FP8 network that starts from a trained Int8 network, on frozen latents. Adam's steps are about
    /// as long as the rate, whose mean over the half cosine is half its first value.
    static Schedule MakeNetworkOnly(double steps) {
        Schedule schedule;
        schedule.networkRate =
            static_cast<float>(std::min(2.0 * kHeadWay / std::max(steps, 1.0), kMostHeadRate));
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

/// How much refinement of the latents (LatentRefiner) a training gets: passes over the image in rounds
/// between which the network settles, and a last round when training has ended.
struct RefinementPlan {
    std::uint64_t rounds = 0, passesPerRound = 0, lastPasses = 0;

    static constexpr double kLargestShare = 0.3;                      ///< of the training's texels
    static constexpr double kForwardCost = 0.4;                       ///< of a texel that is trained
    static constexpr std::uint64_t kMostSweeps = 12, kLastSweeps = 4; ///< more gain little
    static constexpr double kLastRound =
        0.97; ///< fraction of the schedule at which the last but one round is over

    /// `texels`: of all mips, `trained`: texels that training visits, `sweep`: passes that try everything
    ///once.
    static RefinementPlan Make(double trained, double texels, std::uint64_t sweep) {
        const double affordable = kLargestShare * trained / (kForwardCost * texels);
        const auto passes =
            static_cast<std::uint64_t>(std::min(affordable, static_cast<double>(kMostSweeps * sweep)));
        RefinementPlan plan;
        plan.lastPasses = std::min(passes / 2, kLastSweeps * sweep);
        plan.rounds = std::max<std::uint64_t>((passes - plan.lastPasses) / sweep, 1);
        plan.passesPerRound = (passes - plan.lastPasses) / plan.rounds;
        return plan;
    }
    std::uint64_t GetPasses() const { return rounds * passesPerRound + lastPasses; }
    /// Fraction of the schedule at which a round is due, when rounds begin at `first`.
    double GetDue(std::uint64_t round, double first) const {
        return first + (kLastRound - first) * static_cast<double>(round) / static_cast<double>(rounds);
    }
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
