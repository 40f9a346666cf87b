// SPDX-License-Identifier: MIT
// Limits of numbers that users give, whatever they write them in: the command line, or Python.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace openntc::tool {

/// Inclusive limits; whole numbers up to 2^53 are exact.
struct NumberLimits {
    double lowest = 0.0, highest = 0.0;
};

/// Whether `value` lies inside, and is whole where it must be; NaN never does.
inline bool IsInside(double value, const NumberLimits& limits, bool isWhole) {
    return value >= limits.lowest && value <= limits.highest && (!isWhole || value == std::floor(value));
}

/// "must be a whole number 1 to 64", for an error.
inline std::string DescribeLimits(const NumberLimits& limits, bool isWhole) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "must be a %s %.10g to %.10g",
                  isWhole ? "whole number" : "number", limits.lowest, limits.highest);
    return text.data();
}

} // namespace openntc::tool
