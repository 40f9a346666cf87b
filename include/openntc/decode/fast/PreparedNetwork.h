// SPDX-License-Identifier: MIT
// Stability: internal
// The weights of a network, reordered once for the kernels.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/decode/fast/FusedActivation.h"
#include "openntc/decode/fast/Platform.h"
#include "openntc/format/NetworkDescription.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>

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
    const FusedRow* fused = nullptr; ///< of the rows behind the first exactRows
    int exactRows = 0;               ///< hidden layers: a multiple of 4
    int units = 0;
    int rows = 0;
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
    int networkVersion = NTC_NETWORK_UNKNOWN;
    int highResFeatures = 0;
    int lowResFeatures = 0;
};

/// The words of the format's input vector that a texture set uses: features of four corners, low-resolution
/// features (of generations 2 and 3 those of two latent mips), three positional words, the lod word. Returns
/// how many there are.
inline int ListUsedInputWords(const NetworkSource& source, const NetworkDescription& network,
                              int (&words)[kMaxInputWords]) noexcept {
    const bool isPerCorner = network.generation == 1;
    const int slots = isPerCorner ? network.highResSlots : kMaxFeatures;
    const int samples = isPerCorner ? 4 : 1;
    int count = 0;
    for (int sample = 0; sample < samples; ++sample) {
        for (int k = 0; k < source.highResFeatures; k += 4)
            words[count++] = (sample * slots + k) / 4;
    }
    const int lowRes = samples * slots / 4;
    for (int k = 0; k < source.lowResFeatures; k += 4)
        words[count++] = lowRes + k / 4;
    for (int i = 0; i < kPositionWords; ++i)
        words[count++] = lowRes + kLowResWords + i;
    return count;
}

namespace detail {

/// Weights of one row of a layer in the order of its packed inputs.
class RowReader {
public:
    /// `columns`: which stored column each input is.
    RowReader(const std::byte* stored, const std::uint16_t* columns, int inputs) noexcept
        : stored_(stored), columns_(columns), inputs_(inputs) {}

    int GetInputs() const noexcept { return inputs_; }
    int operator[](int input) const noexcept {
        const int code = std::to_integer<int>(stored_[columns_[input]]);
        return code < 128 ? code : code - 256;
    }

private:
    const std::byte* stored_;
    const std::uint16_t* columns_;
    int inputs_;
};

/// The constants of a row's fused activation, if it has any; inputs are -128 … 127.
inline bool FuseRow(ActivationFuser& fuser, const RowReader& row, std::int32_t bias, float scale,
                    FusedRow& constants) noexcept {
    std::int64_t low = bias;
    std::int64_t high = bias;
    for (int i = 0; i < row.GetInputs(); ++i) {
        const int weight = row[i];
        low += weight > 0 ? -128 * weight : 127 * weight;
        high += weight > 0 ? 127 * weight : -128 * weight;
    }
    return fuser.Fuse(scale, low, high, constants);
}

/// Packs the weights of a row; returns the bias that goes with them.
inline std::int32_t PackRow(const RowReader& row, OperandLayout layout, bool outputLayer, int place,
                            int units, std::int32_t bias, std::int32_t* packed) noexcept {
    const int unitsPerWord = UnitsPerWord(layout);
    std::int32_t sum = 0;
    for (int word = 0; word < row.GetInputs() / 4; ++word) {
        std::int32_t q[4];
        std::uint32_t bytes = 0;
        for (int i = 0; i < 4; ++i) {
            q[i] = row[4 * word + i];
            bytes |= (static_cast<std::uint32_t>(q[i]) & 0xFFu) << (8 * i);
            sum += q[i];
        }
        for (int part = 0; part < unitsPerWord; ++part) {
            const std::uint32_t pair = (static_cast<std::uint32_t>(q[part]) & 0xFFFFu) |
                                       static_cast<std::uint32_t>(q[part + 2]) << 16;
            packed[GetPackedIndex(layout, outputLayer, place, word * unitsPerWord + part, units)] =
                static_cast<std::int32_t>(layout == OperandLayout::SignedPairs ? pair : bytes);
        }
    }
    if (layout == OperandLayout::SignedPairs)
        return bias;
    // Takes the 128 added to every input away again.
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(bias) -
                                     static_cast<std::uint32_t>(sum) * 128u);
}

} // namespace detail

/// Reorders the weights into `storage`. `fuses`: the kernel has the activation with fused multiply-adds; rows
/// that cannot have it go to the front of their layer.
inline Expected<PreparedNetwork> PrepareNetwork(const NetworkSource& source, OperandLayout layout, bool fuses,
                                                Array<std::int32_t>& storage) noexcept {
    PreparedNetwork network;
    const NetworkDescription description = GetNetworkDescription(source.networkVersion);
    int usedWords[kMaxInputWords] = {};
    network.inputWords = ListUsedInputWords(source, description, usedWords);
    const int unitsPerWord = UnitsPerWord(layout);
    const int totalWords =
        (PadWords(layout, network.inputWords) + 2 * kHiddenWords) * kHiddenRows + kHiddenWords * kOutputRows;
    constexpr int kTotalOutputs = 3 * kHiddenRows + kOutputRows;
    constexpr int kWordsPerOutput = 2 + static_cast<int>(sizeof(FusedRow) / sizeof(std::int32_t));
    constexpr std::size_t kAlignment = 64;
    OPENNTC_CHECK(
        storage.Resize(static_cast<std::size_t>(totalWords * unitsPerWord + kWordsPerOutput * kTotalOutputs) +
                       kAlignment / sizeof(std::int32_t)));
    std::memset(storage.data(), 0, storage.size() * sizeof(std::int32_t));
    const std::size_t misalignment = reinterpret_cast<std::uintptr_t>(storage.data()) % kAlignment;
    std::int32_t* next = storage.data() + (kAlignment - misalignment) % kAlignment / sizeof(std::int32_t);
    const std::byte* scales = source.weights + source.scaleOffset;
    const std::byte* biases = scales + description.outputsOfAllLayers * 4;

    std::uint16_t
        columns[kMaxNetworkInputs]; // where a layer's inputs are stored: the row order of the one before
    for (int i = 0; i < network.inputWords * 4; ++i)
        columns[i] = static_cast<std::uint16_t>(usedWords[i / 4] * 4 + i % 4);
    ActivationFuser fuser(description.generation == 3 ? kGeneration3Form : ActivationForm{});
    for (std::size_t l = 0; l < kNetworkLayers; ++l) {
        PreparedLayer& layer = network.layers[l];
        const bool outputLayer = l == 3;
        const int words = l == 0 ? network.inputWords : description.inputs[l] / 4;
        const int rows = description.outputs[l];
        layer.rows = rows;
        const std::byte* const stored = source.weights + source.weightOffsets[l];
        const auto read = [&](int row) {
            return detail::RowReader(stored + row * description.inputs[l], columns, words * 4);
        };
        float rowScales[kHiddenRows];
        std::memcpy(rowScales, scales, static_cast<std::size_t>(rows) * sizeof(float));

        layer.units = (outputLayer ? words : PadWords(layout, words)) * unitsPerWord;
        layer.weights = next;
        std::int32_t* const packed = next;
        std::int32_t* const packedBiases = packed + rows * layer.units;
        layer.biases = packedBiases;
        auto* const packedScales = reinterpret_cast<float*>(packedBiases + rows);
        layer.scales = packedScales;
        auto* const fused = reinterpret_cast<FusedRow*>(packedScales + rows);
        layer.fused = fused;
        next = packedBiases + kWordsPerOutput * rows;

        std::uint16_t order[kHiddenRows] = {}; // the stored row of every place
        int exactRows = 0;
        int fusedRows = 0;
        for (int row = 0; row < rows; ++row) {
            FusedRow constants;
            if (fuses && !outputLayer &&
                detail::FuseRow(fuser, read(row), LoadInt32(biases + row * 4), rowScales[row], constants)) {
                ++fusedRows;
                order[rows - fusedRows] = static_cast<std::uint16_t>(row);
                ::new (fused + rows - fusedRows) FusedRow(constants);
            } else {
                order[exactRows++] = static_cast<std::uint16_t>(row);
            }
        }
        layer.exactRows = (exactRows + 3) / 4 * 4;
        for (int place = 0; place < rows; ++place) {
            const int row = order[place];
            packedBiases[place] = detail::PackRow(read(row), layout, outputLayer, place, layer.units,
                                                  LoadInt32(biases + row * 4), packed);
            ::new (packedScales + place) float(rowScales[row]);
        }
        std::memcpy(columns, order, sizeof order);
        scales += rows * 4;
        biases += rows * 4;
    }
    return network;
}

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
