// SPDX-License-Identifier: MIT
// The part of a report's page on block compression.
#pragma once

#include "report/Report.h"

#include <functional>
#include <string>

namespace openntc::report {

inline constexpr double kTexels2K = 2048.0 * 2048.0;

/// One column of times: a device and a number of threads.
struct BlockWay {
    std::string device;
    int threads = 0; ///< 0: a GPU, or a driver that decides itself

    std::string GetName() const; ///< `AMD EPYC, one thread`
    friend bool operator==(const BlockWay&, const BlockWay&) = default;
};

/// In the order of first use; those that ran.
std::vector<BlockWay> ListBlockWays(const ReportRecord& report);

/// Empty without any. `getFigure`: a chart by its name.
std::string WriteBlocks(const ReportRecord& report,
                        const std::function<std::string(const std::string&)>& getFigure);

} // namespace openntc::report
