// SPDX-License-Identifier: MIT
// What the processor could do at most.
#pragma once

#include "openntc/encode/EncodeOptions.h"

namespace openntc::bench {

/// Multiply-adds per second of one core that does nothing but a kernel's instruction on registers; 0 where that is not
/// known.
double MeasurePeak(encode::KernelChoice kernel);

} // namespace openntc::bench
