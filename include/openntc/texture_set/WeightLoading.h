// SPDX-License-Identifier: MIT
// Reads the weights of validated networks into the generic buffers and turns legacy biases into integers.
#pragma once

#include "openntc/container/Views.h"
#include "openntc/texture_set/InferenceWeights.h"
#include "openntc/texture_set/MlpValidation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

static_assert(std::endian::native == std::endian::little,
              "weight buffers are copied as the little-endian file has them");

template <typename T>
T LoadScalar(const std::byte* bytes) noexcept {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

template <typename T>
void StoreScalar(std::byte* bytes, T value) noexcept {
    std::memcpy(bytes, &value, sizeof value);
}

/// The integer nearest to a binary32 number, halves away from zero, saturated to int32. NaN must not occur.
inline std::int32_t RoundToInt32(float value) noexcept {
    const float rounded = std::round(value);
    if (rounded >= 2147483648.0f)
        return std::numeric_limits<std::int32_t>::max();
    if (rounded <= -2147483648.0f)
        return std::numeric_limits<std::int32_t>::min();
    return static_cast<std::int32_t>(rounded);
}

constexpr float kConstantRowScale = 1.0f / 65536.0f; ///< scale of rows without weights, 2^-16

/// One output of an Int8 layer in a weight buffer.
struct OutputRow {
    std::byte* weights; // int8[inputs]
    std::byte* scale;   // binary32
    std::byte* bias;    // int32
};

/// Legacy rule (LibNTC 0.5.x): a binary32 bias is added after scaling; it becomes round(bias / scale). A row
/// of scale zero is constant: scale 2^-16, no weights. The bias must be finite, the scale too.
inline void ConvertFloatBias(const OutputRow& row, std::size_t inputs) noexcept {
    const float scale = LoadScalar<float>(row.scale);
    const float bias = LoadScalar<float>(row.bias);
    if (scale == 0.0f) {
        StoreScalar(row.scale, kConstantRowScale);
        StoreScalar(row.bias, RoundToInt32(bias * 65536.0f));
        std::memset(row.weights, 0, inputs);
    } else {
        StoreScalar(row.bias, RoundToInt32(bias / scale));
    }
}

/// True if any of the unsigned integers T that `values` consists of has all bits of `exponent` set. A maximum
/// without early exit, which compilers turn into vector instructions.
template <typename T>
bool HasNonFinite(std::span<const std::byte> values, T exponent) noexcept {
    T largest = 0;
    for (std::size_t i = 0; i < values.size(); i += sizeof(T))
        largest = std::max(largest, static_cast<T>(LoadScalar<T>(values.data() + i) & exponent));
    return largest == exponent;
}

inline Expected<void> CheckFiniteFloats(std::span<const std::byte> values, const char* path,
                                        std::size_t layer, const char* member) noexcept {
    if (HasNonFinite<std::uint32_t>(values, 0x7F800000u))
        return Fail(Status::FileUnrecognized, "%s.layers[%zu].%s: has binary32 numbers that are not finite",
                    path, layer, member);
    return {};
}

inline Expected<void> CheckFiniteHalves(std::span<const std::byte> values, const char* path,
                                        std::size_t layer) noexcept {
    if (HasNonFinite<std::uint16_t>(values, 0x7C00u))
        return Fail(Status::FileUnrecognized,
                    "%s.layers[%zu].biasView: has binary16 numbers that are not finite", path, layer);
    return {};
}

/// E4M3 has no infinities; NaN are 0x7F and 0xFF.
inline Expected<void> CheckE4M3(std::span<const std::byte> values, const char* path,
                                std::size_t layer) noexcept {
    if (HasNonFinite<std::uint8_t>(values, 0x7Fu))
        return Fail(Status::FileUnrecognized, "%s.layers[%zu].weightView: has E4M3 weights that are NaN",
                    path, layer);
    return {};
}

/// Reads scales and biases of a layer with Int8 weights, which are in place already.
inline Expected<void> LoadInt8ScalesAndBiases(const container::BinaryChunk& chunk,
                                              const container::MlpLayer& layer, bool hasFloatBias,
                                              std::span<std::byte> weights, std::span<std::byte> scales,
                                              std::span<std::byte> biases, const char* path,
                                              std::size_t index) noexcept {
    const std::size_t outputs = scales.size() / 4;
    if (layer.scaleView) {
        OPENNTC_CHECK(container::ReadView(chunk, *layer.scaleView, scales));
        OPENNTC_CHECK(CheckFiniteFloats(scales, path, index, "scaleView"));
    } else {
        for (std::size_t row = 0; row < outputs; ++row)
            StoreScalar(scales.data() + 4 * row, 1.0f);
    }
    OPENNTC_CHECK(container::ReadView(chunk, layer.biasView, biases));
    if (!hasFloatBias)
        return {};
    OPENNTC_CHECK(CheckFiniteFloats(biases, path, index, "biasView"));
    const std::size_t inputs = weights.size() / outputs;
    for (std::size_t row = 0; row < outputs; ++row)
        ConvertFloatBias({weights.data() + row * inputs, scales.data() + 4 * row, biases.data() + 4 * row},
                         inputs);
    return {};
}

/// Reads a network that passed ValidateMlp into the buffer of its kind. Errors: IOError, OutOfMemory,
/// FileUnrecognized for numbers that are not finite.
inline Expected<void> LoadMlpWeights(const container::BinaryChunk& chunk, const container::Mlp& mlp,
                                     const MlpInfo& info, const char* path,
                                     InferenceWeights& destination) noexcept {
    const NetworkDescription network = GetNetworkDescription(info.networkVersion);
    const bool isFP8 = info.weightType == InferenceWeightType::GenericFP8;
    Array<std::byte>& buffer = isFP8 ? destination.fp8 : destination.int8;
    OPENNTC_CHECK(buffer.Resize(static_cast<std::size_t>(isFP8 ? network.fp8Bytes : network.int8Bytes)));
    const auto part = [&buffer](int offset, int bytes) noexcept {
        return buffer.AsSpan().subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes));
    };
    for (std::size_t i = 0; i < kNetworkLayers; ++i) {
        const container::MlpLayer& layer = mlp.layers[i];
        const int outputs = network.outputs[i];
        const std::span<std::byte> weights = part(network.weightOffsets[i], network.inputs[i] * outputs);
        OPENNTC_CHECK(container::ReadView(chunk, layer.weightView, weights));
        if (isFP8 && i < 3) {
            const std::span<std::byte> biases = part(network.fp8BiasOffsets[i], 2 * outputs);
            OPENNTC_CHECK(CheckE4M3(weights, path, i));
            OPENNTC_CHECK(container::ReadView(chunk, layer.biasView, biases));
            OPENNTC_CHECK(CheckFiniteHalves(biases, path, i));
            continue;
        }
        const int scaleOffset = isFP8 ? network.fp8ScaleOffset : network.int8ScaleOffsets[i];
        const int biasOffset = isFP8 ? network.fp8BiasOffsets[i] : network.int8BiasOffsets[i];
        OPENNTC_CHECK(LoadInt8ScalesAndBiases(chunk, layer, info.hasFloatBiases, weights,
                                              part(scaleOffset, 4 * outputs), part(biasOffset, 4 * outputs),
                                              path, i));
    }
    return {};
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
