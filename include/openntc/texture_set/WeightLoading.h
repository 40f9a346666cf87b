// SPDX-License-Identifier: MIT
// Stability: internal
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

/// Names a view of a network in messages.
struct LayerView {
    const char* network; // "mlp", "mlpVersions[0]"
    std::size_t layer;
    const char* member;
};

/// The first of the unsigned integers T that `values` consists of whose bits of `exponent`, which follow each
/// other below the highest one, are all set; or their number. Eight bytes at once say first whether there is
/// one: only then does adding the lowest bit of the exponent reach the highest one.
template <typename T>
std::size_t FindNonFinite(std::span<const std::byte> values, T exponent) noexcept {
    constexpr std::uint64_t kOnes = ~std::uint64_t{0} / static_cast<T>(~T{0}); // a 1 in each T of a word
    const std::uint64_t exponents = kOnes * exponent;
    const std::uint64_t lowest = kOnes * static_cast<T>(exponent & (~exponent + 1));
    constexpr std::uint64_t kHighest = kOnes << (8 * sizeof(T) - 1);
    const std::size_t count = values.size() / sizeof(T);
    std::uint64_t reached = 0;
    std::size_t i = 0;
    for (; i + 8 <= values.size(); i += 8)
        reached |= (LoadScalar<std::uint64_t>(values.data() + i) & exponents) + lowest;
    const auto isNonFinite = [&](std::size_t number) noexcept {
        return (LoadScalar<T>(values.data() + number * sizeof(T)) & exponent) == exponent;
    };
    std::size_t first = (reached & kHighest) != 0 ? 0 : i / sizeof(T);
    while (first < count && !isNonFinite(first))
        ++first;
    return first;
}

/// All numbers of a view that was read. T: the unsigned integer of their size; `exponent`: its bits that are
/// all set only in infinities and NaN (E4M3, without infinities: 0x7F). Errors: FileUnrecognized.
template <typename T>
Expected<void> CheckFinite(std::span<const std::byte> values, T exponent, const LayerView& path) noexcept {
    const std::size_t first = FindNonFinite<T>(values, exponent);
    if (first == values.size() / sizeof(T))
        return {};
    return Fail(Status::FileUnrecognized, "%s.layers[%zu].%s: number %zu is 0x%0*X: must be finite",
                path.network, path.layer, path.member, first, static_cast<int>(2 * sizeof(T)),
                static_cast<unsigned>(LoadScalar<T>(values.data() + first * sizeof(T))));
}

/// A matrix of the file that lies at the start of its place in the buffer, where rows are `inputs` long,
/// spread out; the rest of the place is zero.
inline void SpreadRows(std::span<std::byte> matrix, std::size_t inputs, std::size_t storedInputs,
                       std::size_t storedOutputs) noexcept {
    if (storedInputs < inputs) {
        for (std::size_t row = storedOutputs; row-- > 0;) {
            std::memmove(matrix.data() + row * inputs, matrix.data() + row * storedInputs, storedInputs);
            std::memset(matrix.data() + row * inputs + storedInputs, 0, inputs - storedInputs);
        }
    }
    std::memset(matrix.data() + storedOutputs * inputs, 0, matrix.size() - storedOutputs * inputs);
}

/// Reads scales and biases of a layer with Int8 weights, which are in place already. The file has those of
/// `stored` outputs; further scales are 1 and biases 0.
inline Expected<void> LoadInt8ScalesAndBiases(const container::BinaryChunk& chunk,
                                              const container::MlpLayer& layer, bool hasFloatBias,
                                              std::span<std::byte> weights, std::span<std::byte> scales,
                                              std::span<std::byte> biases, const char* path,
                                              std::size_t index) noexcept {
    const std::size_t outputs = scales.size() / 4;
    const std::size_t stored = layer.outputChannels;
    if (layer.scaleView) {
        OPENNTC_CHECK(container::ReadView(chunk, *layer.scaleView, scales.first(4 * stored)));
        OPENNTC_CHECK(CheckFinite(scales.first(4 * stored), 0x7F800000u, {path, index, "scaleView"}));
    }
    for (std::size_t row = layer.scaleView ? stored : 0; row < outputs; ++row)
        StoreScalar(scales.data() + 4 * row, 1.0f);
    OPENNTC_CHECK(container::ReadView(chunk, layer.biasView, biases.first(4 * stored)));
    if (!hasFloatBias)
        return {};
    OPENNTC_CHECK(CheckFinite(biases, 0x7F800000u, {path, index, "biasView"}));
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
    buffer.clear();
    OPENNTC_CHECK(buffer.Resize(static_cast<std::size_t>(isFP8 ? network.fp8Bytes : network.int8Bytes)));
    const auto part = [&buffer](int offset, int bytes) noexcept {
        return buffer.AsSpan().subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes));
    };
    for (std::size_t i = 0; i < kNetworkLayers; ++i) {
        const container::MlpLayer& layer = mlp.layers[i];
        const int outputs = network.outputs[i];
        const std::size_t storedInputs = layer.inputChannels;
        const std::size_t storedOutputs = layer.outputChannels;
        const std::span<std::byte> weights = part(network.weightOffsets[i], network.inputs[i] * outputs);
        OPENNTC_CHECK(
            container::ReadView(chunk, layer.weightView, weights.first(storedInputs * storedOutputs)));
        SpreadRows(weights, static_cast<std::size_t>(network.inputs[i]), storedInputs, storedOutputs);
        if (isFP8 && i < 3) {
            const std::span<std::byte> biases =
                part(network.fp8BiasOffsets[i], 2 * static_cast<int>(storedOutputs));
            OPENNTC_CHECK(CheckFinite(weights, std::uint8_t{0x7F}, {path, i, "weightView"}));
            OPENNTC_CHECK(container::ReadView(chunk, layer.biasView, biases));
            OPENNTC_CHECK(CheckFinite(biases, std::uint16_t{0x7C00}, {path, i, "biasView"}));
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
