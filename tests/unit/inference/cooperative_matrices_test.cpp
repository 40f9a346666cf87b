// SPDX-License-Identifier: MIT
// Weights for cooperative matrices: operands times inputs in the order of the shader's bytes are the sums of the
// generic weights, for the networks of every generation, with and without a layout of the accumulator.
#include "shader/coopmat/Probes.h"

#include "openntc/inference/CooperativeMatrices.h"

#include <doctest/doctest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// Small numbers everywhere, so that every network fits the lanes' form.
std::vector<std::byte> MakeGenericInt8(const NetworkDescription& network, std::mt19937& random) {
    std::vector<std::byte> generic(static_cast<std::size_t>(network.int8Bytes));
    for (std::size_t i = 0; i < generic.size(); ++i)
        generic[i] = static_cast<std::byte>(random());
    for (int row = 0; row < network.outputsOfAllLayers; ++row) {
        const float scale = static_cast<float>(random() % 1000) / 256.0f;
        const auto bias = static_cast<std::int32_t>(random() % 100'000) - 50'000;
        std::memcpy(generic.data() + network.int8ScaleOffsets[0] + 4 * row, &scale, 4);
        std::memcpy(generic.data() + network.int8BiasOffsets[0] + 4 * row, &bias, 4);
    }
    return generic;
}

/// What the shader reads of the buffer, by its numbers of vectors.
class CoopMatBuffer {
public:
    CoopMatBuffer(const NetworkDescription& network, std::span<const std::byte> bytes)
        : rows_(static_cast<std::size_t>(network.outputsOfAllLayers)),
          stride_(network.inputs[0] > 64 ? 7 : 5), bytes_(bytes) {
        REQUIRE(bytes.size() == 16 * (GetTail() + rows_ / 2 + 36));
    }

    int GetWeight(std::size_t row, std::size_t byte) const {
        const std::size_t at = row < 64 ? row * stride_ : 64 * stride_ + 5 * (row - 64);
        return static_cast<std::int8_t>(bytes_[16 * at + byte]);
    }
    template <typename T>
    T GetScale(std::size_t place) const {
        return Get<T>(16 * GetTail() + 4 * place);
    }
    template <typename T>
    T GetBias(std::size_t place) const {
        return Get<T>(16 * GetTail() + 4 * rows_ + 4 * place);
    }

private:
    std::size_t GetTail() const { return 64 * stride_ + 5 * (rows_ - 64); }
    template <typename T>
    T Get(std::size_t at) const {
        T value{};
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }

    std::size_t rows_, stride_;
    std::span<const std::byte> bytes_;
};

/// A texel's bytes as NetworkCoopMat.h stages them: what the lanes put there, or units in order. `garbage` is where no unit is.
std::vector<int> StageUnits(const std::vector<int>& units, const CoopMatLayout* layout, int garbage) {
    const std::size_t tiles = units.size() / 16;
    std::vector<int> bytes(tiles == 2 ? 32 : 64, garbage);
    if (layout == nullptr) {
        std::copy(units.begin(), units.end(), bytes.begin());
        return bytes;
    }
    constexpr std::size_t kElements[4] = {0, 2, 1, 3}; // of NtcPackUnits
    for (std::size_t group = 0; group < 4; ++group) {
        for (std::size_t tile = 0; tile < tiles; ++tile) {
            for (std::size_t i = 0; i < 4; ++i) {
                const std::size_t word = tiles == 2 ? 2 * group + tile : 4 * group + tile;
                bytes[4 * word + i] = units[16 * tile + layout->columns[group][kElements[i]]];
            }
        }
    }
    return bytes;
}

std::vector<int> MakeUnits(int count, std::mt19937& random) {
    std::vector<int> units(static_cast<std::size_t>(count));
    for (int& unit : units)
        unit = static_cast<int>(random() % 256) - 128;
    return units;
}

/// The row of all layers' whose weights output `row` of a layer has: outputs of the network are ordered by the layout.
std::size_t GetPlace(std::size_t firstRow, std::size_t row, bool isLast, const CoopMatLayout* layout) {
    return firstRow + (isLast && layout != nullptr ? layout->columns[row / 4][row % 4] : row);
}

void CheckNetwork(int version, const CoopMatLayout* layout, std::mt19937& random) {
    const NetworkDescription network = GetNetworkDescription(version);
    const std::vector<std::byte> generic = MakeGenericInt8(network, random);
    const auto made = MakeCoopMatWeights(version, generic, layout);
    REQUIRE_MESSAGE(made.has_value(), std::string(made.error().GetText()));
    const CoopMatBuffer buffer(network, made->AsSpan());
    std::size_t firstRow = 0;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        CAPTURE(layer);
        const auto inputs = static_cast<std::size_t>(network.inputs[layer]);
        const std::vector<int> units = MakeUnits(network.inputs[layer], random);
        std::vector<int> staged = units; // of the first layer: in order, zeros behind
        staged.resize((inputs + 31) / 32 * 32);
        if (layer > 0)
            staged = StageUnits(units, layout, 77);
        std::size_t different = 0;
        for (std::size_t row = 0; row < static_cast<std::size_t>(network.outputs[layer]); ++row) {
            const std::size_t place = GetPlace(firstRow, row, layer == 3, layout);
            int expected = 0, sum = 0;
            for (std::size_t i = 0; i < inputs; ++i) {
                const auto at = static_cast<std::size_t>(network.weightOffsets[layer]) + row * inputs + i;
                expected += static_cast<std::int8_t>(generic[at]) * units[i];
            }
            for (std::size_t byte = 0; byte < staged.size(); ++byte)
                sum += buffer.GetWeight(place, byte) * staged[byte];
            different += sum != expected ? 1 : 0;
            float scale = 0;
            std::int32_t bias = 0;
            std::memcpy(&scale, generic.data() + network.int8ScaleOffsets[layer] + 4 * row, 4);
            std::memcpy(&bias, generic.data() + network.int8BiasOffsets[layer] + 4 * row, 4);
            if (layout == nullptr) {
                different += buffer.GetScale<float>(place) != scale ? 1 : 0;
                different += buffer.GetBias<std::int32_t>(place) != bias ? 1 : 0;
                continue;
            }
            for (std::size_t group = 0; group < 4; ++group) { // the lane's element of this column
                for (std::size_t i = 0; i < 4; ++i) {
                    if (layout->columns[group][i] != place % 16)
                        continue;
                    const std::size_t element = place - place % 16 + 4 * group + i;
                    different += buffer.GetScale<float>(element) != scale ? 1 : 0;
                    different +=
                        buffer.GetBias<float>(element) != static_cast<float>(bias) - 12582912.0f ? 1 : 0;
                }
            }
        }
        CHECK(different == 0);
        firstRow += static_cast<std::size_t>(network.outputs[layer]);
    }
}

} // namespace

TEST_CASE("cooperative matrices: operands give the sums of the generic weights") {
    constexpr unsigned kSeed = 53;
    MESSAGE("seed " << kSeed);
    std::mt19937 random(kSeed);
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_GENERATION_3; ++version) {
        CAPTURE(version);
        CheckNetwork(version, nullptr, random);
        for (const auto& probe : {MakeKnownProbe(), MakeRandomProbe(random)}) {
            const auto layout = ReadCoopMatLayout(probe);
            REQUIRE(layout);
            CheckNetwork(version, &*layout, random);
        }
    }
}

TEST_CASE("cooperative matrices: networks, sizes and subgroups of every generation") {
    std::mt19937 random(1);
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_GENERATION_3; ++version) {
        CAPTURE(version);
        const NetworkDescription network = GetNetworkDescription(version);
        std::vector<std::byte> generic = MakeGenericInt8(network, random);
        CHECK(FitsCoopMatLanes(version, generic));
        const bool isLarge = version == NTC_NETWORK_LARGE || version == NTC_NETWORK_XLARGE;
        CHECK(GetCoopMatSubgroups(version, true) == (isLarge                               ? 12
                                                     : version == NTC_NETWORK_GENERATION_3 ? 24
                                                                                           : 20));
        CHECK(GetCoopMatSubgroups(version, false) == (isLarge ? 6 : 8));
        // The last row of layer 2: its sums could pass 2^22.
        const std::int32_t bias = 1 << 22;
        std::memcpy(generic.data() + network.int8BiasOffsets[2] + 4 * (network.outputs[2] - 1), &bias, 4);
        CHECK_FALSE(FitsCoopMatLanes(version, generic));
        CHECK(MakeCoopMatWeights(version, generic, nullptr).has_value());
        generic.pop_back();
        CHECK_FALSE(FitsCoopMatLanes(version, generic));
        CHECK_FALSE(MakeCoopMatWeights(version, generic, nullptr));
    }
    for (const int version : {0, 7}) {
        const auto refused = MakeCoopMatWeights(version, std::vector<std::byte>(9472), nullptr);
        REQUIRE_FALSE(refused);
        CHECK(std::string(refused.error().GetText()) ==
              "network version: " + std::to_string(version) + ": must be 1 to 6");
        CHECK_FALSE(FitsCoopMatLanes(version, std::vector<std::byte>(9472)));
    }
}
