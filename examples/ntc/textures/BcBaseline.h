// SPDX-License-Identifier: MIT
// Results of `ntc bc-test`, as rows, and how they differ from those of an earlier run.
#pragma once

#include "textures/BlockMeasurement.h"

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace openntc::tool {

/// One image, or all of them together, in one format with one effort.
struct BcRow {
    std::string image; ///< as on the command line; empty: all
    bc::BlockFormat format = bc::BlockFormat::Bc7;
    BlockEffort effort = BlockEffort::Normal;
    BlockMeasurement measurement;
    bool hinted = false; ///< BC7 with hints of a search at best

    /// `normal`, or `normal, hinted`.
    std::string GetLevel() const { return std::string(GetName(effort)) + (hinted ? ", hinted" : ""); }
};

struct BcLimits {
    double decibels = 0.01; ///< that PSNR may fall
    double percent = 10.0;  ///< that speed may fall
};

/// The JSON of an earlier run.
class BcBaseline {
public:
    /// Throws CommandError(BadInput) if `path` is no such file, and CommandError(Usage) if its threads are others.
    BcBaseline(const std::string& path, int threads);

    /// One line for everything that is worse than before by more than the limits: PSNR, texels of BC1 on the other side of
    /// alpha, speed, rows that are missing.
    std::vector<std::string> Compare(const std::vector<BcRow>& rows, const BcLimits& limits) const;

private:
    struct OldRow {
        double psnr = 0.0, speed = 0.0;
        std::uint64_t moved = 0;
    };
    using RowKey = std::tuple<std::string, std::string, std::string>; // image, format, effort and hints

    std::map<RowKey, OldRow> rows_;
};

} // namespace openntc::tool
