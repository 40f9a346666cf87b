// SPDX-License-Identifier: MIT
// How tests tell tests/run.sh which conformance vectors they ran. The run fails unless V1 and V2 of the
// format specification ran, and ends with the totals.
#pragma once

#include <cstdio>

namespace openntc_tests {

/// Prints one line `VECTORS ran=N skipped=M name=NAME`. `name` is one word: `V1`, `V2` for the
/// specification's sets, or what else was run; `ran` and `skipped` count compared records (texels, mips or
/// files, the test's choice).
inline void ReportVectors(const char* name, int ran, int skipped) {
    std::printf("VECTORS ran=%d skipped=%d name=%s\n", ran, skipped, name);
    std::fflush(stdout);
}

} // namespace openntc_tests
