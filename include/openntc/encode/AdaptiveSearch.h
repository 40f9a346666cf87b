// SPDX-License-Identifier: MIT
// Stability: experimental
// The fewest bits per pixel that reach a target quality: which known latent shape to try next.
#pragma once

#include "openntc/texture_set/LatentShape.h"

#include <cmath>
#include <functional>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// Interval search over the table of known shapes, steered by psnr = a * ln(bits per pixel) + b through the
/// interval's ends. The first guess assumes the slope that encoders of this format show, so that most
/// searches end after three runs.
class AdaptiveSearch {
public:
    struct Trial {
        KnownLatentShape shape{};
        double psnr = 0.0;
    };

    /// `maximumBits` > 0 limits the search; `accepts`, where given, leaves out shapes of no use. Errors:
    /// OutOfRange.
    static Expected<AdaptiveSearch> Create(int networkVersion, double targetPsnr, double maximumBits = 0.0,
                                           const std::function<bool(const LatentShape&)>& accepts = {}) {
        AdaptiveSearch search;
        search.target_ = targetPsnr;
        const int count = GetKnownLatentShapeCount(networkVersion);
        for (int i = 0; i < count; ++i) {
            OPENNTC_ASSIGN(const KnownLatentShape shape, EnumerateKnownLatentShapes(i, networkVersion));
            if (maximumBits > 0.0 && static_cast<double>(shape.bitsPerPixel) > maximumBits)
                break;
            if (!accepts || accepts(shape.shape))
                search.shapes_.push_back(shape);
        }
        if (search.shapes_.empty())
            return Fail(Status::OutOfRange, "bitsPerPixel: %g: no known shape is that small", maximumBits);
        search.low_ = -1;
        search.high_ = static_cast<int>(search.shapes_.size());
        search.next_ = std::min(search.high_ / 2, 12);
        search.next_ = std::min(search.next_, search.high_ - 1);
        return search;
    }

    bool IsFinished() const { return next_ < 0; }
    const KnownLatentShape& GetNext() const { return shapes_[static_cast<std::size_t>(next_)]; }
    const std::vector<Trial>& GetTrials() const { return trials_; }
    /// True when some trial reached the target.
    bool IsReached() const { return high_ < static_cast<int>(shapes_.size()); }
    /// Index into GetTrials of the answer: the smallest shape that reached the target, else the best seen.
    std::size_t GetBest() const {
        std::size_t best = 0;
        for (std::size_t i = 1; i < trials_.size(); ++i) {
            const bool reached = trials_[i].psnr >= target_, bestReached = trials_[best].psnr >= target_;
            if (reached != bestReached ? reached
                : reached              ? trials_[i].shape.bitsPerPixel < trials_[best].shape.bitsPerPixel
                                       : trials_[i].psnr > trials_[best].psnr)
                best = i;
        }
        return best;
    }

    /// Result of encoding with GetNext().
    void Report(double psnr) {
        trials_.push_back({GetNext(), psnr});
        if (psnr >= target_) {
            high_ = next_;
            highPsnr_ = psnr;
        } else {
            low_ = next_;
            lowPsnr_ = psnr;
        }
        next_ = high_ - low_ <= 1 ? -1 : Predict();
    }

private:
    static constexpr double kSlope = 5.0; ///< dB per factor e in bits, until two results are known

    int Predict() const {
        const bool hasLow = low_ >= 0, hasHigh = high_ < static_cast<int>(shapes_.size());
        const auto log = [&](int i) {
            return std::log(static_cast<double>(shapes_[static_cast<std::size_t>(i)].bitsPerPixel));
        };
        double slope = kSlope;
        if (hasLow && hasHigh && highPsnr_ > lowPsnr_)
            slope = (highPsnr_ - lowPsnr_) / (log(high_) - log(low_));
        const double wanted =
            hasHigh ? log(high_) + (target_ - highPsnr_) / slope : log(low_) + (target_ - lowPsnr_) / slope;
        int best = low_ + 1;
        // The smallest shape that the model expects to reach the target.
        while (best + 1 < high_ && log(best) < wanted)
            ++best;
        return best;
    }

    std::vector<KnownLatentShape> shapes_;
    std::vector<Trial> trials_;
    double target_ = 0.0, lowPsnr_ = 0.0, highPsnr_ = 0.0;
    int low_ = -1; ///< largest shape known to miss
    int high_ = 0; ///< smallest shape known to reach
    int next_ = -1;
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
