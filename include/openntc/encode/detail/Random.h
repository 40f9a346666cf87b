// SPDX-License-Identifier: MIT
// Stability: internal
// Random numbers as functions of (seed, index), so that their order of use does not matter.
#pragma once

#include <cmath>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// A well-mixed 32-bit function of its argument (M. O'Neill's PCG output permutation over one LCG step).
inline std::uint32_t Hash(std::uint32_t value) {
    value = value * 747796405u + 2891336453u;
    value = ((value >> ((value >> 28) + 4u)) ^ value) * 277803737u;
    return (value >> 22) ^ value;
}

/// Uniform in [0, 1), 24 bits.
inline float ToUnit(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * (1.0f / 16777216.0f);
}

/// Standard normal numbers from a stream.
class RandomStream {
public:
    explicit RandomStream(std::uint32_t seed) : state_(Hash(seed)) {}
    std::uint32_t NextBits() { return Hash(state_++); }
    float NextUnit() { return ToUnit(NextBits()); }
    float NextNormal() {
        const float u = NextUnit() + 1e-8f, v = NextUnit();
        return std::sqrt(-2.0f * std::log(u)) * std::cos(6.28318531f * v);
    }

private:
    std::uint32_t state_;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
