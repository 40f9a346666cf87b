// SPDX-License-Identifier: MIT
// What permutations cost before the first texel: code size and time to create a pipeline.
#pragma once

#include "Benchmark.h"

namespace openntc::bench {

/// Prints a markdown table with the bytes of SPIR-V, the median of three vkCreateComputePipelines and the first dispatch
/// of 64 texels, in which drivers that compile to the CPU generate machine code; without the driver's cache of shaders on
/// disk. Returns the exit code: 1 if a pipeline cannot be made.
int PrintPipelines(harness::Context& device, const Options& options);

} // namespace openntc::bench
