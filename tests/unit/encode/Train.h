// SPDX-License-Identifier: MIT
// The encoder behind a function: its kernels are compiled once for all tests, which is most of their build time.
#pragma once

#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"

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

/// encode::Encoder::Encode.
Expected<encode::EncodeResult> Train(const encode::Material& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress = {});
Expected<encode::EncodeResult> Train(encode::Material&& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress = {});

} // namespace openntc::test
