// SPDX-License-Identifier: MIT
// Stability: stable
// Enumerations of the file format: what stored values mean and how decoded textures should be kept.
#pragma once

#include "openntc/InferenceConstants.h"

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Encoding of stored colour values. Values equal NTC_COLOR_SPACE_*.
enum class ColorSpace : std::uint8_t {
    Linear = NTC_COLOR_SPACE_LINEAR,
    sRGB = NTC_COLOR_SPACE_SRGB,
    HLG = NTC_COLOR_SPACE_HLG,
};

/// Format that a decoded texture should be stored in.
enum class ChannelFormat : std::uint8_t { UNKNOWN = 0, UNORM8, UNORM16, FLOAT16, FLOAT32, UINT32 };

/// Block-compressed format that a decoded texture should be transcoded to. Uncompressed is None, for sources
/// that include X11's headers, where None is a macro.
enum class BlockCompressedFormat : std::uint8_t {
    None = 0,
    BC1,
    BC2,
    BC3,
    BC4,
    BC5,
    BC6,
    BC7,
    Uncompressed = None,
};

/// Storage forms of network weights; the first five values equal LibNTC's.
enum class InferenceWeightType : std::uint8_t {
    Unknown = 0,
    GenericInt8 = 1, ///< Int8 weights, binary32 scales, int32 biases
    GenericFP8 = 2,  ///< E4M3 weights and binary16 biases, output layer as Int8
    CoopVecInt8 = 3, ///< driver-defined matrix layout: see CooperativeVectors.h
    CoopVecFP8 = 4,
    CoopMatInt8 = 5, ///< of cooperative matrices, for a device and a form: see CooperativeMatrices.h
};

/// The enumerator's name; "Unknown" for values that are not enumerators.
constexpr const char* InferenceWeightTypeToString(InferenceWeightType type) noexcept {
    switch (type) {
    case InferenceWeightType::GenericInt8:
        return "GenericInt8";
    case InferenceWeightType::GenericFP8:
        return "GenericFP8";
    case InferenceWeightType::CoopVecInt8:
        return "CoopVecInt8";
    case InferenceWeightType::CoopVecFP8:
        return "CoopVecFP8";
    case InferenceWeightType::CoopMatInt8:
        return "CoopMatInt8";
    case InferenceWeightType::Unknown:
        break;
    }
    return "Unknown";
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
