// SPDX-License-Identifier: MIT
// The encoder behind a function, whose kernels the command line has too: they are compiled once.
#pragma once

#include "encode/Training.h"

#include <cstdint>

namespace openntc::test {

/// Steps of a training: `few` under sanitizers, which slow it down tenfold and more and run the same code.
constexpr std::uint64_t Steps([[maybe_unused]] std::uint64_t steps, [[maybe_unused]] std::uint64_t few) {
#ifdef OPENNTC_TEST_SANITIZED
    return few;
#else
    return steps;
#endif
}

using tool::Train; ///< encode::Encoder::Encode

} // namespace openntc::test
