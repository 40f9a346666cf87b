// SPDX-License-Identifier: MIT
// Stability: stable
// Geometry of the four decoder networks and the layout of their weight buffers: texture_set loads weights
// into these layouts, inference exports the offsets, decoders and the trainer compute with them.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/format/Limits.h"

#include <array>
#include <cstddef>

#include "openntc/core/HideMacros.h"

namespace openntc {

inline constexpr int kNetworkLayers = 4;
inline constexpr int kHiddenChannels = 64;
inline constexpr int kLowResSlots = kMaxFeatures;
inline constexpr int kWaveSlots = 12; ///< three frequencies, two phases, two axes
inline constexpr int kPositionSlots =
    kWaveSlots + 4; ///< then the level of detail twice, and two that stay unused
/// Outputs of all layers together: 64 + 64 + 64 + 16.
inline constexpr int kNetworkOutputs = 3 * kHiddenChannels + NTC_MAX_CHANNELS;

/// Geometry and buffer layout of one network version. Offsets and sizes are in bytes from the start of the
/// buffer. Source: format specification, "geometry" and "weight buffers".
struct NetworkDescription {
    int version;      ///< NTC_NETWORK_SMALL … NTC_NETWORK_XLARGE
    int highResSlots; ///< largest number of high-res features: 4, 8, 12, 16
    std::array<int, kNetworkLayers> inputs;
    std::array<int, kNetworkLayers> outputs;

    /// Matrices, row-major, row = output; one byte per weight in both buffers.
    std::array<int, kNetworkLayers> weightOffsets;
    int weightBytes; ///< all matrices; scales (Int8) or biases (FP8) start here

    /// "Generic Int8" buffer: binary32 scale and int32 bias of each output of each layer.
    std::array<int, kNetworkLayers> int8ScaleOffsets;
    std::array<int, kNetworkLayers> int8BiasOffsets;
    int int8Bytes;

    /// "Generic FP8" buffer: binary16 biases of layers 0 – 2 and int32 biases of layer 3, whose binary32
    /// scales are at fp8ScaleOffset. The matrix of layer 3 is Int8.
    std::array<int, kNetworkLayers> fp8BiasOffsets;
    int fp8ScaleOffset;
    int fp8Bytes;
};

constexpr bool IsNetworkVersion(int version) noexcept {
    return version >= NTC_NETWORK_SMALL && version <= NTC_NETWORK_XLARGE;
}

/// High-res features that a network version has room for, at each of four corners.
constexpr int GetHighResSlots(int version) noexcept {
    return kFeatureStep * version;
}
inline constexpr int kMaxNetworkInputs =
    4 * GetHighResSlots(NTC_NETWORK_XLARGE) + kLowResSlots + kPositionSlots;

/// Description of a network version, which must satisfy IsNetworkVersion.
constexpr NetworkDescription GetNetworkDescription(int version) noexcept {
    NetworkDescription d{};
    d.version = version;
    d.highResSlots = GetHighResSlots(version);
    d.inputs = {4 * d.highResSlots + kLowResSlots + kPositionSlots, kHiddenChannels, kHiddenChannels,
                kHiddenChannels};
    d.outputs = {kHiddenChannels, kHiddenChannels, kHiddenChannels, NTC_MAX_CHANNELS};
    int offset = 0;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        d.weightOffsets[layer] = offset;
        offset += d.inputs[layer] * d.outputs[layer];
    }
    d.weightBytes = offset;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        d.int8ScaleOffsets[layer] = offset;
        d.int8BiasOffsets[layer] = offset + 4 * kNetworkOutputs;
        offset += 4 * d.outputs[layer];
    }
    d.int8Bytes = d.weightBytes + 8 * kNetworkOutputs;
    offset = d.weightBytes;
    for (std::size_t layer = 0; layer < 3; ++layer) {
        d.fp8BiasOffsets[layer] = offset;
        offset += 2 * d.outputs[layer];
    }
    d.fp8ScaleOffset = offset;
    d.fp8BiasOffsets[3] = offset + 4 * d.outputs[3];
    d.fp8Bytes = offset + 8 * d.outputs[3];
    return d;
}

/// The network version whose first layer has that many inputs (48, 64, 80, 96), or NTC_NETWORK_UNKNOWN.
constexpr int GetNetworkVersionForInputs(std::size_t inputs) noexcept {
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        if (inputs == static_cast<std::size_t>(GetNetworkDescription(version).inputs[0]))
            return version;
    }
    return NTC_NETWORK_UNKNOWN;
}

/// "small", "medium", "large", "xlarge", or "unknown".
constexpr const char* GetNetworkName(int version) noexcept {
    switch (version) {
    case NTC_NETWORK_SMALL:
        return "small";
    case NTC_NETWORK_MEDIUM:
        return "medium";
    case NTC_NETWORK_LARGE:
        return "large";
    case NTC_NETWORK_XLARGE:
        return "xlarge";
    default:
        return "unknown";
    }
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
