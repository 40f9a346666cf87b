// SPDX-License-Identifier: MIT
// Stability: internal
// States of training handed to the caller now and then, so that a run that is killed can go on.
#pragma once

#include "openntc/encode/EncodeOptions.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class StateSaver {
public:
    /// `options` outlives the saver.
    explicit StateSaver(const EncodeOptions& options) : options_(options) {}

    /// Between steps: gives options.save the state when it is time to. `elapsed`: seconds since the start.
    template <typename AnyTrainer>
    void SaveWhenDue(AnyTrainer& trainer, double elapsed, double fraction) {
        if (!options_.save || elapsed < due_)
            return;
        if (due_ > 0.0 || options_.saveSeconds <= 0.0) {
            const auto begin = std::chrono::steady_clock::now();
            trainer.Save(bytes_);
            if (bytes_.empty()) // of a device that is lost
                return;
            options_.save(bytes_, fraction);
            ++saved_;
            const double spent =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
            due_ = elapsed + spent + std::max(options_.saveSeconds, kShare * spent);
        } else {
            due_ = options_.saveSeconds;
        }
    }

    std::uint64_t GetCount() const { return saved_; }

private:
    /// A large state on a slow disk takes no more of the time than 1/20.
    static constexpr double kShare = 20.0;

    const EncodeOptions& options_;
    double due_ = 0.0; ///< seconds since the start; 0: not known yet
    std::vector<std::byte> bytes_;
    std::uint64_t saved_ = 0;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
