// SPDX-License-Identifier: MIT
// Stability: stable
// Geometry of the decoder networks of all generations and the layout of their weight buffers: texture_set
// loads weights into these layouts, inference exports the offsets, decoders and the trainer compute with
// them.
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
/// Outputs of all layers together, 64 + 64 + 64 + 16: of generation 3 fewer (NetworkDescription).
inline constexpr int kNetworkOutputs = 3 * kHiddenChannels + NTC_MAX_CHANNELS;
/// Latents of a texel per layer of generations 2 and 3, and how many latent mips a colour mip reads there.
inline constexpr int kLayerFeatures = 4;
inline constexpr int kSampledLatentMips = 2;

/// Geometry and buffer layout of one network version. Offsets and sizes are in bytes from the start of the
/// buffer. Source: format specification, "geometry" and "weight buffers"; generations, "buffers".
struct NetworkDescription {
    int version;      ///< NTC_NETWORK_SMALL … NTC_NETWORK_GENERATION_3
    int generation;   ///< 1, 2 or 3
    int highResSlots; ///< largest number of high-res features: 4, 8, 12, 16; 0 in generations 2 and 3
    std::array<int, kNetworkLayers> inputs;
    std::array<int, kNetworkLayers> outputs;
    int outputsOfAllLayers; ///< 208, or 160 in generation 3

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

/// True for the networks of generation 1.
constexpr bool IsNetworkVersion(int version) noexcept {
    return version >= NTC_NETWORK_SMALL && version <= NTC_NETWORK_XLARGE;
}

/// The generation of files that a network version belongs to, 1 to 3; 0 if it is none.
constexpr int GetGeneration(int networkVersion) noexcept {
    if (IsNetworkVersion(networkVersion))
        return 1;
    if (networkVersion == NTC_NETWORK_GENERATION_2)
        return 2;
    return networkVersion == NTC_NETWORK_GENERATION_3 ? 3 : 0;
}

/// True for the networks of every generation.
constexpr bool IsKnownNetwork(int version) noexcept {
    return GetGeneration(version) != 0;
}

/// High-res features that a network version of generation 1 has room for, at each of four corners.
constexpr int GetHighResSlots(int version) noexcept {
    return kFeatureStep * version;
}
inline constexpr int kMaxNetworkInputs =
    4 * GetHighResSlots(NTC_NETWORK_XLARGE) + kLowResSlots + kPositionSlots;

/// Description of a network version, which must satisfy IsKnownNetwork.
constexpr NetworkDescription GetNetworkDescription(int version) noexcept {
    NetworkDescription d{};
    d.version = version;
    d.generation = GetGeneration(version);
    d.outputs = {kHiddenChannels, kHiddenChannels, kHiddenChannels, NTC_MAX_CHANNELS};
    if (d.generation == 3)
        d.outputs = {64, 48, 32, NTC_MAX_CHANNELS};
    d.highResSlots = d.generation == 1 ? GetHighResSlots(version) : 0;
    const int latentInputs =
        d.generation == 1 ? 4 * d.highResSlots + kLowResSlots : kSampledLatentMips * kMaxFeatures;
    d.inputs = {latentInputs + kPositionSlots, d.outputs[0], d.outputs[1], d.outputs[2]};
    int offset = 0;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        d.weightOffsets[layer] = offset;
        offset += d.inputs[layer] * d.outputs[layer];
        d.outputsOfAllLayers += d.outputs[layer];
    }
    d.weightBytes = offset;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        d.int8ScaleOffsets[layer] = offset;
        d.int8BiasOffsets[layer] = offset + 4 * d.outputsOfAllLayers;
        offset += 4 * d.outputs[layer];
    }
    d.int8Bytes = d.weightBytes + 8 * d.outputsOfAllLayers;
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

/// The network version of generation 1 whose first layer has that many inputs (48, 64, 80, 96), or
/// NTC_NETWORK_UNKNOWN.
constexpr int GetNetworkVersionForInputs(std::size_t inputs) noexcept {
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        if (inputs == static_cast<std::size_t>(GetNetworkDescription(version).inputs[0]))
            return version;
    }
    return NTC_NETWORK_UNKNOWN;
}

/// "small", "medium", "large", "xlarge", "gen2", "gen3", or "unknown".
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
    case NTC_NETWORK_GENERATION_2:
        return "gen2";
    case NTC_NETWORK_GENERATION_3:
        return "gen3";
    default:
        return "unknown";
    }
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
