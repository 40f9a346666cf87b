// SPDX-License-Identifier: MIT
#pragma once

#include "Benchmark.h"

namespace openntc::bench {

/// Variants that generation 1's medium network and those of generations 2 and 3 have, in turns: a table of their times and
/// ratios. Returns the exit code.
int PrintGenerations(harness::Context& device, const Options& options);

} // namespace openntc::bench
