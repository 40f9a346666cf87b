// SPDX-License-Identifier: MIT
// libFuzzer entry for longer runs than the tests make: the input is a whole file.
//   cmake -DCMAKE_CXX_COMPILER=clang++ -DOPENNTC_BUILD_FUZZERS=ON …; bin/load_fuzzer CORPUS_FOLDER
//   SEED_FOLDER
#include "fuzz/FuzzTarget.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const openntc::fuzz::Outcome outcome =
        openntc::fuzz::LoadEverything(std::as_bytes(std::span(data, size)), {});
    if (outcome.broken != nullptr) {
        std::fprintf(stderr, "broken promise: %s\n", outcome.broken);
        std::abort();
    }
    return 0;
}
