// SPDX-License-Identifier: MIT
// What FP8 hardware may return, for the cases whose expected values are ranges.
#pragma once

#include "Suite.h"

#include "openntc/decode/DecodeTypes.h"

#include <span>

namespace openntc::conformance {

/// Fills `low` and `high` of every record: the hull of what FP8 hardware of the kinds listed in docs/conformance.md may
/// return, and of the outputs that the record holds. `source` has FP8 weights; the texels are inside the image.
void FillHardwareIntervals(const DecodeSource& source, std::span<ValueRecord> records);

} // namespace openntc::conformance
