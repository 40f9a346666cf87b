// SPDX-License-Identifier: MIT
#include "HardwareIntervals.h"

#include "models/FP8Interval.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace openntc::conformance {

namespace {

// binary32 sums in any order with any activation; an NVIDIA H100; and tensor cores that multiply E4M3 numbers themselves.
constexpr models::FP8Assumptions kHardware[] = {
    {},
    {.halfInputs = true, .block = 16, .contraction = false},
    {.block = 32, .cut = 13, .contraction = false},
};

// Away from the interval if it is not a binary32 number.
float RoundOutward(double value, double direction) {
    const float nearest = static_cast<float>(value);
    if ((static_cast<double>(nearest) - value) * direction >= 0)
        return nearest;
    return std::nextafterf(nearest, static_cast<float>(direction) * std::numeric_limits<float>::infinity());
}

} // namespace

void FillHardwareIntervals(const DecodeSource& source, std::span<ValueRecord> records) {
    const models::ModelSource model{source.constants, source.latents, source.weights, source.networkVersion};
    for (ValueRecord& record : records)
        record.low = record.high = record.outputs;
    for (const models::FP8Assumptions& assumptions : kHardware) {
        const models::FP8Interval interval(assumptions);
        for (ValueRecord& record : records) {
            const auto bounds = interval.Decode(model, record.texel.mip, record.texel.x, record.texel.y);
            for (std::size_t c = 0; c < bounds.size(); ++c) {
                record.low[c] = std::min(record.low[c], RoundOutward(bounds[c].low, -1));
                record.high[c] = std::max(record.high[c], RoundOutward(bounds[c].high, 1));
            }
        }
    }
}

} // namespace openntc::conformance
