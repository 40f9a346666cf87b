// SPDX-License-Identifier: MIT
// How far decoded texels are from the source and from the FP32 decode.
#pragma once

#include "report/Encodings.h"

#include <memory>

namespace openntc::report {

/// The C++ decoder of a maths mode (for cooperative vectors: of the same numbers) on mip 0, 16 values a texel, with all
/// cores.
std::vector<float> DecodeOnCpu(const Encoding& encoding, int math, bool linear);

/// Keeps what was decoded for comparison.
class ReferenceDecodes {
public:
    const std::vector<float>& Get(const Encoding& encoding, int math, bool linear);

private:
    std::map<std::string, std::vector<float>> kept_;
};

/// `outputs`: mip 0 as a device decoded it, with the outputs of `mask`. SSIM is the mean over channels (ComparedSet.h); in
/// linear light all values, the source's too, are linear.
Accuracy MeasureAccuracy(const Encoding& encoding, std::uint32_t mask, int math, bool linear,
                         std::span<const float> outputs, ReferenceDecodes& references);

} // namespace openntc::report
