// SPDX-License-Identifier: MIT
// A new seed for every run, which OPENNTC_TEST_SEED repeats. Whoever uses it prints it.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>

namespace openntc::test {

inline std::uint64_t GetTestSeed() {
    static const std::uint64_t seed = [] {
        const char* text = std::getenv("OPENNTC_TEST_SEED");
        return text != nullptr ? std::strtoull(text, nullptr, 10)
                               : static_cast<unsigned long long>(std::random_device{}());
    }();
    return seed;
}

} // namespace openntc::test
