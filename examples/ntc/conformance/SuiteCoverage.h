// SPDX-License-Identifier: MIT
// Which case covers which end of which field of the format, and which pair: measured in the sets and values themselves.
#pragma once

#include "Suite.h"

#include <string>
#include <vector>

namespace openntc::conformance {

struct CoverageItem {
    std::string what;               ///< "layer 2 bias: -2147483648"
    std::vector<std::string> cases; ///< that have it; empty: nothing does
};

/// Texts of everything that the suite promises, in a fixed order.
std::vector<std::string> ListPromises();
/// As these texts name numbers: "-0", "65504", "inf".
std::string NameFloat(float value);

/// Every promise with the cases that keep it.
std::vector<CoverageItem> MeasureCoverage(const Suite& suite);

/// A line an item: what, and up to three of its cases.
std::string WriteCoverage(const std::vector<CoverageItem>& items);

} // namespace openntc::conformance
