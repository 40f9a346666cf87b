// SPDX-License-Identifier: MIT
// Are the device's FP8 results among those that FP8 hardware may return?
#pragma once

#include "Benchmark.h"

#include <span>
#include <string>

namespace openntc::bench {

/// Compares the first texels of mip 0, 16 values each, row by row of `size` texels, with the intervals of
/// examples/models/FP8Interval.h for several ways to add up: in any order with binary32 (2^-24), 14-bit (2^-13) or
/// binary16 accumulators (2^-11), and as an NVIDIA H100 does. Prints a line for each: the fraction inside, and the worst excess,
/// absolute and in steps of 1/255. Returns the same as JSON members, beginning with a comma.
std::string CheckFP8Intervals(const Set& set, int network, int size, std::span<const float> values);

} // namespace openntc::bench
