// SPDX-License-Identifier: MIT
// `bench_gpu SHADER_FOLDER --matrices 1`: passes/DecodeBlocks on cooperative matrices.
#pragma once

#include "Benchmark.h"

namespace openntc::bench {

/// Every network, form and number of workgroups, timed and compared with the reference decoder's bits. Returns 1 if a result
/// differs or a driver refuses; a device without such matrices is said to be skipped.
int PrintCoopMat(harness::Context& device, const Options& options);

} // namespace openntc::bench
