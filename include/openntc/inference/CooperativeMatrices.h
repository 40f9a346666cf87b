// SPDX-License-Identifier: MIT
// Stability: experimental
// Weights for cooperative matrices (VK_KHR_cooperative_matrix): what shaders/openntc/NetworkCoopMat.h reads.
//
//   1. Where the device has signed bytes in 16 x 16 x 32 matrices at subgroup scope, run
//      passes/ProbeCoopMat.comp and give its numbers to ReadCoopMatLayout: lanes of a layout that the lanes'
//      form knows, or an error, and then the portable form is used.
//   2. MakeCoopMatWeights with that layout, or without for the portable form. The lanes' form also refuses
//      weights whose sums could pass 2^22; again the portable form takes them.
//   3. Upload, and decode with the constants of GenericInt8.
//
// The library calls no graphics API.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/core/FloatBits.h"
#include "openntc/format/NetworkDescription.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

inline constexpr std::size_t kCoopMatLanes = 32;
/// Numbers that ProbeCoopMat writes for a lane: its eight elements, and how many it has.
inline constexpr std::size_t kCoopMatProbeNumbers = 9;

/// Which elements of a 16 x 16 accumulator a lane holds: 0 … 3 in one row, 4 … 7 in another, in the same
/// four columns. Lanes with the same columns are a group.
struct CoopMatLayout {
    std::array<std::array<std::uint8_t, 2>, kCoopMatLanes> rows{};
    std::array<std::uint8_t, kCoopMatLanes> groups{};     ///< 0 … 3
    std::array<std::array<std::uint8_t, 4>, 4> columns{}; ///< of a group
};

/// The layout that ProbeCoopMat found. Errors: InvalidArgument for another number of results; Unsupported if
/// it is not of that kind.
inline Expected<CoopMatLayout> ReadCoopMatLayout(std::span<const std::int32_t> probe) noexcept {
    if (probe.size() != kCoopMatLanes * kCoopMatProbeNumbers)
        return Fail(Status::InvalidArgument, "probe: %zu numbers: must be %zu", probe.size(),
                    kCoopMatLanes * kCoopMatProbeNumbers);
    CoopMatLayout layout;
    std::size_t groups = 0;
    std::array<bool, 256> isHeld{};
    for (std::size_t lane = 0; lane < kCoopMatLanes; ++lane) {
        const std::span<const std::int32_t> own =
            probe.subspan(lane * kCoopMatProbeNumbers, kCoopMatProbeNumbers);
        bool isKnown = own[8] == 8;
        for (std::size_t i = 0; i < 8 && isKnown; ++i) {
            isKnown = own[i] >= 0 && own[i] < 256 && !isHeld[static_cast<std::size_t>(own[i])] &&
                      own[i] / 16 == own[i & 4u] / 16 && own[i] % 16 == own[i & 3u] % 16;
            if (isKnown)
                isHeld[static_cast<std::size_t>(own[i])] = true;
        }
        if (!isKnown)
            return Fail(Status::Unsupported, "probe: lane %zu: its elements are not four columns of two rows",
                        lane);
        std::array<std::uint8_t, 4> columns{};
        for (std::size_t i = 0; i < 4; ++i)
            columns[i] = static_cast<std::uint8_t>(own[i] % 16);
        std::size_t group = 0;
        while (group < groups && layout.columns[group] != columns)
            ++group;
        if (group == groups) {
            if (groups == layout.columns.size())
                return Fail(Status::Unsupported, "probe: lane %zu: a fifth set of columns", lane);
            layout.columns[groups++] = columns;
        }
        layout.rows[lane] = {static_cast<std::uint8_t>(own[0] / 16), static_cast<std::uint8_t>(own[4] / 16)};
        layout.groups[lane] = static_cast<std::uint8_t>(group);
    }
    return layout; // 256 elements, each held once
}

namespace detail {

/// Operands of 32 inputs that a layer of so many has.
constexpr std::size_t GetCoopMatChunks(int inputs) noexcept {
    return (static_cast<std::size_t>(inputs) + 31) / 32;
}

/// Vectors of 16 bytes in a row of the first layer's weights in the shader's shared memory: whole operands of
/// 32 inputs and one more. Rows of the other layers have five.
constexpr std::size_t GetCoopMatStride(int networkVersion) noexcept {
    return 2 * GetCoopMatChunks(GetNetworkDescription(networkVersion).inputs[0]) + 1;
}

/// Where a row of all layers' begins in the buffer, in bytes.
constexpr std::size_t GetCoopMatRow(int networkVersion, std::size_t row) noexcept {
    const std::size_t stride = GetCoopMatStride(networkVersion);
    return 16 * (row < 64 ? row * stride : 64 * stride + (row - 64) * 5);
}

/// The unit that is byte `byte` of a texel's bytes between layers, `chunks` times 32 (1 or 2) of them. May be
/// one that the layer does not have: 48 units take 64 bytes.
inline std::size_t GetCoopMatUnit(const CoopMatLayout& layout, std::size_t byte,
                                  std::size_t chunks) noexcept {
    constexpr std::array<std::size_t, 4> kOrder = {0, 2, 1, 3}; // in which the shader packs
    const std::size_t blocks = 2 * chunks;                      // of a group of lanes
    const std::size_t group = byte / (4 * blocks), block = byte / 4 % blocks;
    return 16 * block + layout.columns[group][kOrder[byte % 4]];
}

/// Puts a row's weights where the shader's operands have their inputs; what they have besides stays as it is.
inline void PlaceCoopMatRow(std::span<const std::byte> weights, const CoopMatLayout* layout,
                            std::byte* row) noexcept {
    const std::size_t chunks = GetCoopMatChunks(static_cast<int>(weights.size()));
    for (std::size_t byte = 0; byte < 32 * chunks; ++byte) {
        const std::size_t unit = layout == nullptr ? byte : GetCoopMatUnit(*layout, byte, chunks);
        if (unit < weights.size())
            row[byte] = weights[unit];
    }
}

/// Checks what the lanes' form needs of a row: sums that floats hold whatever the inputs, and a scale that
/// takes none of them to infinity.
inline Expected<void> CheckCoopMatRow(std::span<const std::byte> weights, std::int32_t bias, float scale,
                                      std::size_t row) noexcept {
    std::int64_t most = bias < 0 ? -std::int64_t{bias} : std::int64_t{bias};
    for (const std::byte weight : weights) {
        const int value = static_cast<std::int8_t>(weight);
        most += 128 * (value < 0 ? -value : value);
    }
    if (most >= std::int64_t{1} << 22)
        return Fail(Status::Unsupported, "row %zu: sums up to %lld: must be below 4194304", row,
                    static_cast<long long>(most));
    if (!IsMagnitudeAtMost(scale, 0x1p100f))
        return Fail(Status::Unsupported, "row %zu: scale %g: must be finite and at most 2^100", row,
                    static_cast<double>(scale));
    return {};
}

} // namespace detail

/// True if the lanes' form can take these generic Int8 weights; MakeCoopMatWeights says which row is why not.
/// False too for an unknown network version and a buffer of another size than the network's.
inline bool FitsCoopMatLanes(int networkVersion, std::span<const std::byte> generic) noexcept {
    if (!IsKnownNetwork(networkVersion))
        return false;
    const NetworkDescription network = GetNetworkDescription(networkVersion);
    if (generic.size() != static_cast<std::size_t>(network.int8Bytes))
        return false;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        const std::size_t inputs = static_cast<std::size_t>(network.inputs[layer]);
        for (std::size_t r = 0; r < static_cast<std::size_t>(network.outputs[layer]); ++r) {
            const auto row =
                generic.subspan(static_cast<std::size_t>(network.weightOffsets[layer]) + r * inputs, inputs);
            float scale = 0;
            std::int32_t bias = 0;
            std::memcpy(&scale, generic.data() + network.int8ScaleOffsets[layer] + 4 * r, 4);
            std::memcpy(&bias, generic.data() + network.int8BiasOffsets[layer] + 4 * r, 4);
            if (!detail::CheckCoopMatRow(row, bias, scale, r))
                return false;
        }
    }
    return true;
}

/// Subgroups of a workgroup of a pass that was compiled without NTC_COOPMAT_SUBGROUPS.
constexpr int GetCoopMatSubgroups(int networkVersion, bool isByLanes) noexcept {
    if (isByLanes && networkVersion == NTC_NETWORK_GENERATION_3)
        return 24;
    if (detail::GetCoopMatStride(networkVersion) == 5)
        return isByLanes ? 20 : 8;
    return isByLanes ? 12 : 6;
}

/// Workgroups to dispatch, along x, for a rectangle of texels: not more than there are blocks of 8 x 4 for,
/// and at most 5280 subgroups, 40 for each multiprocessor of the GPU that was measured. Any number is right.
constexpr std::uint32_t GetCoopMatGroups(int width, int height, int subgroups) noexcept {
    const std::int64_t blocks = ((std::int64_t{width} + 7) / 8) * ((std::int64_t{height} + 3) / 4);
    const std::int64_t most = blocks < 5280 ? blocks : 5280;
    return static_cast<std::uint32_t>((most + subgroups - 1) / subgroups);
}

/// The buffer of a network, from its generic Int8 weights. `layout`: null for the portable form. Errors:
/// InvalidArgument for an unknown network version or a buffer of another size than the network's; Unsupported
/// for weights that the lanes' form cannot take; OutOfMemory.
inline Expected<Array<std::byte>> MakeCoopMatWeights(int networkVersion, std::span<const std::byte> generic,
                                                     const CoopMatLayout* layout,
                                                     Allocator& allocator = GetDefaultAllocator()) noexcept {
    if (!IsKnownNetwork(networkVersion))
        return Fail(Status::InvalidArgument, "network version: %d: must be 1 to %d", networkVersion,
                    NTC_NETWORK_GENERATION_3);
    const NetworkDescription network = GetNetworkDescription(networkVersion);
    if (generic.size() != static_cast<std::size_t>(network.int8Bytes))
        return Fail(Status::InvalidArgument, "weights: %zu bytes: the generic buffer has %d", generic.size(),
                    network.int8Bytes);
    constexpr std::size_t kVector = 16;
    const std::size_t rows = static_cast<std::size_t>(network.outputsOfAllLayers);
    const std::size_t tail = detail::GetCoopMatRow(networkVersion, rows);
    const std::size_t biases = tail + 4 * rows;
    const std::size_t lanes = biases + 4 * rows;
    Array<std::byte> buffer(allocator);
    OPENNTC_CHECK(buffer.Resize(lanes + (kCoopMatLanes + 4) * kVector));
    std::memset(buffer.data(), 0, buffer.size());

    std::size_t row = 0;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        const std::size_t inputs = static_cast<std::size_t>(network.inputs[layer]);
        for (std::size_t r = 0; r < static_cast<std::size_t>(network.outputs[layer]); ++r, ++row) {
            const auto from =
                generic.subspan(static_cast<std::size_t>(network.weightOffsets[layer]) + r * inputs, inputs);
            // Outputs 4 g ... 4 g + 3 go where group g has its columns: a lane writes them as they are.
            const bool isOutput = layout != nullptr && layer + 1 == kNetworkLayers;
            const std::size_t at = isOutput ? row - r + layout->columns[r / 4][r % 4] : row;
            detail::PlaceCoopMatRow(from, layer == 0 ? nullptr : layout,
                                    buffer.data() + detail::GetCoopMatRow(networkVersion, at));
            float scale = 0;
            std::int32_t bias = 0;
            std::memcpy(&scale, generic.data() + network.int8ScaleOffsets[layer] + 4 * r, 4);
            std::memcpy(&bias, generic.data() + network.int8BiasOffsets[layer] + 4 * r, 4);
            if (layout == nullptr) {
                std::memcpy(buffer.data() + tail + 4 * row, &scale, 4);
                std::memcpy(buffer.data() + biases + 4 * row, &bias, 4);
                continue;
            }
            OPENNTC_CHECK(detail::CheckCoopMatRow(from, bias, scale, row));
            // In the order of the lanes' elements; 1.5 * 2^23 goes out with the bias.
            const float shifted = static_cast<float>(bias - 12582912);
            for (std::size_t group = 0; group < 4; ++group) {
                for (std::size_t k = 0; k < 4; ++k) {
                    if (layout->columns[group][k] != at % 16)
                        continue;
                    const std::size_t place = 4 * (at - at % 16 + 4 * group + k);
                    std::memcpy(buffer.data() + tail + place, &scale, 4);
                    std::memcpy(buffer.data() + biases + place, &shifted, 4);
                }
            }
        }
    }
    if (layout != nullptr) {
        for (std::size_t lane = 0; lane < kCoopMatLanes; ++lane) {
            const std::uint32_t words[4] = {layout->rows[lane][0], layout->rows[lane][1],
                                            layout->groups[lane], 0x00FF00FFu};
            std::memcpy(buffer.data() + lanes + lane * kVector, words, sizeof words);
        }
        for (std::size_t group = 0; group < 4; ++group) {
            const std::array<std::uint8_t, 4>& columns = layout->columns[group];
            const std::uint32_t words[4] = {columns[0], columns[1], columns[2], columns[3]};
            std::memcpy(buffer.data() + lanes + (kCoopMatLanes + group) * kVector, words, sizeof words);
        }
    }
    return buffer;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
