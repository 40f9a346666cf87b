// SPDX-License-Identifier: MIT
#include "report/Spread.h"

#include <algorithm>
#include <cmath>

namespace openntc::report {

Spread Summarise(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double fraction) {
        const double rank = fraction * static_cast<double>(values.size() - 1);
        const auto low = static_cast<std::size_t>(rank);
        const std::size_t high = std::min(low + 1, values.size() - 1);
        return std::lerp(values[low], values[high], rank - static_cast<double>(low));
    };
    if (values.empty())
        return {};
    return {at(0.5), at(0.25), at(0.75), values.front(), values.back(), static_cast<int>(values.size())};
}

} // namespace openntc::report
