// SPDX-License-Identifier: MIT
// Stability: internal
// The weights of a network, reordered once for the kernels.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/decode/fast/Platform.h"
#include "openntc/format/NetworkDescription.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::fast {

inline constexpr int kHiddenRows = kHiddenChannels;
inline constexpr int kOutputRows = kMaxChannels;
inline constexpr int kMaxInputWords = kMaxNetworkInputs / 4;
inline constexpr int kHiddenWords = kHiddenRows / 4;
inline constexpr int kLowResWords = kLowResSlots / 4, kPositionWords = kPositionSlots / 4;

/// How four consecutive layer inputs are laid out in 32-bit lanes. One "unit" is what one dot-product
/// instruction consumes in each lane.
enum class OperandLayout {
    UnsignedBytes, ///< one unit: four bytes, value + 128 (instructions that multiply unsigned by signed
                   ///< bytes)
    SignedPairs,   ///< two units: 16-bit values 0 and 2, then values 1 and 3
    Tiles,         ///< bytes as in UnsignedBytes, hidden layers in matrix tiles of 16 outputs by 16 words
};

inline constexpr int kTileWords = 16;

constexpr int UnitsPerWord(OperandLayout layout) noexcept {
    return layout == OperandLayout::SignedPairs ? 2 : 1;
}

/// Words of a layer's input, with those added that only fill a tile (their weights are zero).
constexpr int PadWords(OperandLayout layout, int words) noexcept {
    return layout == OperandLayout::Tiles ? (words + kTileWords - 1) / kTileWords * kTileWords : words;
}

/// Where a unit of a row lies in PreparedLayer::weights.
constexpr int GetPackedIndex(OperandLayout layout, bool outputLayer, int row, int unit, int units) noexcept {
    if (outputLayer)
        return unit * kOutputRows + row;
    if (layout == OperandLayout::Tiles)
        return (row / kTileWords * units + unit / kTileWords * kTileWords + row % kTileWords) * kTileWords +
               unit % kTileWords;
    return (row / 4 * units + unit) * 4 + row % 4;
}

struct PreparedLayer {
    /// Hidden layers: [row / 4][unit][row % 4], in tiles [row / 16][unit / 16][row % 16][unit % 16]; the last
    /// layer: [unit][row].
    const std::int32_t* weights = nullptr;
    const std::int32_t* biases = nullptr;
    const float* scales = nullptr;
    int units = 0;
};

struct PreparedNetwork {
    int inputWords = 0; ///< of layer 0 after dropping the unused feature slots, which are always zero
    PreparedLayer layers[4];
};

inline std::int32_t LoadInt32(const std::byte* bytes) noexcept {
    std::int32_t value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// Generic Int8 weights (little-endian) and how the texture set uses them; offsets and feature counts are
/// checked.
struct NetworkSource {
    const std::byte* weights = nullptr;
    std::int32_t weightOffsets[4] = {};
    std::int32_t scaleOffset = 0;
    int highResSlots = 0; ///< features per corner that the network has room for
    int highResFeatures = 0;
    int lowResFeatures = 0;
};

/// The words of the format's input vector that a texture set uses: features of four corners, low-resolution
/// features, three positional words, the lod word. Returns how many there are.
inline int ListUsedInputWords(const NetworkSource& source, int (&words)[kMaxInputWords]) noexcept {
    int count = 0;
    for (int corner = 0; corner < 4; ++corner) {
        for (int k = 0; k < source.highResFeatures; k += 4)
            words[count++] = (corner * source.highResSlots + k) / 4;
    }
    for (int k = 0; k < source.lowResFeatures; k += 4)
        words[count++] = source.highResSlots + k / 4;
    for (int i = 0; i < kPositionWords; ++i)
        words[count++] = source.highResSlots + kLowResWords + i;
    return count;
}

/// Reorders the weights into `storage`.
inline Expected<PreparedNetwork> PrepareNetwork(const NetworkSource& source, OperandLayout layout,
                                                Array<std::int32_t>& storage) noexcept {
    PreparedNetwork network;
    int usedWords[kMaxInputWords] = {};
    network.inputWords = ListUsedInputWords(source, usedWords);
    const int storedInputWords = source.highResSlots + kLowResWords + kPositionWords;
    const int unitsPerWord = UnitsPerWord(layout);
    const int totalWords =
        (PadWords(layout, network.inputWords) + 2 * kHiddenWords) * kHiddenRows + kHiddenWords * kOutputRows;
    const int outputsBefore[5] = {0, kHiddenRows, 2 * kHiddenRows, 3 * kHiddenRows,
                                  3 * kHiddenRows + kOutputRows};
    const int totalOutputs = outputsBefore[4];
    constexpr std::size_t kAlignment = 64;
    OPENNTC_CHECK(storage.Resize(static_cast<std::size_t>(totalWords * unitsPerWord + 2 * totalOutputs) +
                                 kAlignment / sizeof(std::int32_t)));
    std::memset(storage.data(), 0, storage.size() * sizeof(std::int32_t));
    const std::size_t misalignment = reinterpret_cast<std::uintptr_t>(storage.data()) % kAlignment;
    std::int32_t* next = storage.data() + (kAlignment - misalignment) % kAlignment / sizeof(std::int32_t);
    const std::byte* scales = source.weights + source.scaleOffset;
    const std::byte* biases = scales + totalOutputs * 4;

    for (int l = 0; l < 4; ++l) {
        PreparedLayer& layer = network.layers[l];
        const int words = l == 0 ? network.inputWords : kHiddenWords;
        const int rows = outputsBefore[l + 1] - outputsBefore[l];
        layer.units = (l == 3 ? words : PadWords(layout, words)) * unitsPerWord;
        layer.weights = next;
        std::int32_t* packed = next;
        next += rows * layer.units;
        std::int32_t* packedBiases = next;
        layer.biases = next;
        next += rows;
        for (int row = 0; row < rows; ++row) {
            const std::byte* stored = source.weights + source.weightOffsets[l] +
                                      row * (l == 0 ? storedInputWords : kHiddenWords) * 4;
            std::int32_t sum = 0;
            for (int word = 0; word < words; ++word) {
                const std::byte* const four = stored + (l == 0 ? usedWords[word] : word) * 4;
                std::int32_t q[4];
                std::uint32_t bytes = 0;
                for (int i = 0; i < 4; ++i) {
                    const int code = std::to_integer<int>(four[i]);
                    q[i] = code < 128 ? code : code - 256;
                    bytes |= (static_cast<std::uint32_t>(q[i]) & 0xFFu) << (8 * i);
                    sum += q[i];
                }
                for (int part = 0; part < unitsPerWord; ++part) {
                    const int unit = word * unitsPerWord + part;
                    const std::uint32_t pair = (static_cast<std::uint32_t>(q[part]) & 0xFFFFu) |
                                               static_cast<std::uint32_t>(q[part + 2]) << 16;
                    packed[GetPackedIndex(layout, l == 3, row, unit, layer.units)] =
                        static_cast<std::int32_t>(layout == OperandLayout::SignedPairs ? pair : bytes);
                }
            }
            std::uint32_t bias = static_cast<std::uint32_t>(LoadInt32(biases + (outputsBefore[l] + row) * 4));
            if (layout != OperandLayout::SignedPairs) // takes the 128 added to every input away again
                bias -= static_cast<std::uint32_t>(sum) * 128u;
            packedBiases[row] = static_cast<std::int32_t>(bias);
        }
    }
    // Scales last, as binary32 in the same block.
    for (int l = 0; l < 4; ++l) {
        const int rows = outputsBefore[l + 1] - outputsBefore[l];
        std::memcpy(next, scales + outputsBefore[l] * 4, static_cast<std::size_t>(rows) * sizeof(float));
        network.layers[l].scales = reinterpret_cast<const float*>(next);
        next += rows;
    }
    return network;
}

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
