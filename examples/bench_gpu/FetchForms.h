// SPDX-License-Identifier: MIT
// `bench_gpu SHADER_FOLDER --forms 1`: the ways to fetch weights against each other.
#pragma once

#include "Benchmark.h"

namespace openntc::bench {

/// For every network: all forms of the Int8 network decode the same image in turns, so that whatever else the machine does
/// meets them alike. Prints a table; the first form, scalar direct loads with one texel per invocation, is what the others
/// are compared with, in time and in the bits of the results. Returns 1 if any result differs.
int PrintFetchForms(harness::Context& device, const Options& options);

} // namespace openntc::bench
