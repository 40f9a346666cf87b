// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace openntc::report {

/// Times over the repeats, in nanoseconds per texel unless a member says otherwise.
struct Spread {
    double median = 0, lowerQuartile = 0, upperQuartile = 0, minimum = 0, maximum = 0;
    int repeats = 0; ///< 0: not measured
};

template <typename A>
void Describe(A& a, Spread& r) {
    a("median", r.median);
    a("lowerQuartile", r.lowerQuartile);
    a("upperQuartile", r.upperQuartile);
    a("minimum", r.minimum);
    a("maximum", r.maximum);
    a("repeats", r.repeats);
}

/// Median, quartiles (linear between ranks) and range.
Spread Summarise(std::vector<double> values);

/// Removes records that were judged and not timed yet.
template <typename Record>
void DropUntimed(std::vector<Record>& records) {
    std::erase_if(records, [](const Record& record) {
        if constexpr (requires { record.skipped; }) {
            if (!record.skipped.empty())
                return false;
        }
        return record.time.repeats == 0;
    });
}

} // namespace openntc::report
