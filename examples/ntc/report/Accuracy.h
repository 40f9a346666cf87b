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

/// How many of the outputs of `mask` have other bits than the reference's, which may go on longer.
std::uint64_t CountDifferent(std::span<const float> outputs, std::span<const float> reference,
                             std::uint32_t mask);

/// `outputs`: mip 0 as a device decoded it, with the outputs of `mask`. SSIM is the mean over channels (ComparedSet.h); in
/// linear light all values, the source's too, are linear.
Accuracy MeasureAccuracy(const Encoding& encoding, std::uint32_t mask, bool linear,
                         std::span<const float> outputs, ReferenceDecodes& references);

} // namespace openntc::report
