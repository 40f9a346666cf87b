// SPDX-License-Identifier: MIT
// What a core's dot products alone allow, as a measure for decoders.
#pragma once

#include <optional>

namespace openntc {
enum class SimdTarget; // of FastDecoder.h, which is slow to compile
}

namespace openntc::tool {

/// Multiply-adds of bytes that one core reaches in a second with the 8-bit dot products of an instruction set,
/// without loads: the best of a few short runs. None where it has no such instruction, or none that this build
/// knows.
std::optional<double> MeasureDotProducts(SimdTarget target);

} // namespace openntc::tool
