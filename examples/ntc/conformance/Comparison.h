// SPDX-License-Identifier: MIT
// When a decoded value is right: equality that knows NaN and flushed subnormals, and the error bound of
// conversion to linear colour.
#pragma once

#include "openntc/decode/DecodeTypes.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace openntc::conformance {

/// Which arithmetic the decoder under test used.
enum class Arithmetic {
    Host,  ///< C++ with the platform's binary32 math library
    Vulkan ///< the precision that the Vulkan specification promises to shaders
};

/// Equal bits; or both NaN; or, if `flushBelow` > 0, both smaller than it in magnitude: devices may flush
/// subnormals, so there every subnormal counts as zero.
inline bool IsSame(float a, float b, float flushBelow) {
    if (std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b))
        return true;
    if (std::isnan(a) || std::isnan(b))
        return std::isnan(a) && std::isnan(b);
    return std::fabs(a) < flushBelow && std::fabs(b) < flushBelow;
}

/// Below it, values count as zero: subnormals, which devices may flush and hosts keep.
inline float GetFlushLimit(Arithmetic arithmetic, DecodeMath math) {
    if (arithmetic == Arithmetic::Host)
        return 0;
    return math == DecodeMath::Int8Half || math == DecodeMath::FP16 ? 0x1p-14f
                                                                    : std::numeric_limits<float>::min();
}

/// |a - b|, infinite if exactly one is NaN or the two are different infinities; never NaN.
inline double GetDistance(float a, float b) {
    if (IsSame(a, b, 0))
        return 0;
    const double distance = std::fabs(static_cast<double>(a) - static_cast<double>(b));
    return std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
}

/// Largest difference allowed between a recorded conversion to linear (binary32 libm) and that of the decoder
/// under test, for the stored value `stored`, which is the same on both sides.
double GetLinearBound(ColorSpace colorSpace, float stored, Arithmetic arithmetic);

} // namespace openntc::conformance
