// SPDX-License-Identifier: MIT
// Stability: internal
// Checks the description of a decoder network and its views. Source: format specification, "MLP validation".
#pragma once

#include "openntc/container/Schema.h"
#include "openntc/container/Views.h"
#include "openntc/core/Expected.h"
#include "openntc/format/Enums.h"
#include "openntc/format/NetworkDescription.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What a valid network description resolves to.
struct MlpInfo {
    int networkVersion = NTC_NETWORK_UNKNOWN;
    InferenceWeightType weightType = InferenceWeightType::Unknown; ///< GenericInt8 or GenericFP8
    /// Biases of the Int8 layers are binary32 (written by LibNTC 0.5.x) and have to become integers.
    bool hasFloatBiases = false;
};

namespace detail {

using container::MlpDataType;

/// NUL-terminated, as the names are literals.
constexpr const char* MlpDataTypeToString(std::optional<MlpDataType> type) noexcept {
    return type ? container::EnumToString(*type).data() : "none";
}

constexpr std::uint64_t GetMlpDataTypeBytes(MlpDataType type) noexcept {
    switch (type) {
    case MlpDataType::Int8:
    case MlpDataType::FloatE4M3:
    case MlpDataType::FloatE5M2:
        return 1;
    case MlpDataType::Float16:
        return 2;
    case MlpDataType::Int32:
    case MlpDataType::Float32:
        return 4;
    }
    return 0;
}

struct LayerTypes {
    std::optional<MlpDataType> weight;
    std::optional<MlpDataType> scale;
    std::optional<MlpDataType> bias;
};

/// Types of a layer with the defaults of its network applied, newer keys first.
inline LayerTypes ResolveLayerTypes(const container::Mlp& mlp, const container::MlpLayer& layer) noexcept {
    const std::optional<MlpDataType> scaleBias =
        layer.scaleBiasType ? layer.scaleBiasType : mlp.scaleBiasType;
    LayerTypes types;
    types.weight = layer.weightType ? layer.weightType : mlp.weightType;
    types.scale = layer.scaleType;
    if (!types.scale && layer.scaleView)
        types.scale = scaleBias;
    types.bias = layer.biasType ? layer.biasType : scaleBias;
    return types;
}

/// Finds the row of the table of type combinations that the four layers match. Binary32 biases of Int8 layers
/// are generation 1's only.
inline Expected<void> ClassifyMlp(const std::array<LayerTypes, kNetworkLayers>& types,
                                  std::uint32_t generation, const char* path, MlpInfo& info) noexcept {
    const bool isFP8 = types[0].weight == MlpDataType::FloatE4M3;
    info.weightType = isFP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
    info.hasFloatBiases = generation == 1 && types[3].bias == MlpDataType::Float32;
    const MlpDataType integerBias = info.hasFloatBiases ? MlpDataType::Float32 : MlpDataType::Int32;
    for (std::size_t i = 0; i < kNetworkLayers; ++i) {
        const bool isE4M3 = isFP8 && i < 3;
        LayerTypes expected;
        expected.weight = isE4M3 ? MlpDataType::FloatE4M3 : MlpDataType::Int8;
        if (!isE4M3)
            expected.scale = MlpDataType::Float32;
        expected.bias = isE4M3 ? MlpDataType::Float16 : integerBias;
        if (types[i].weight != expected.weight || types[i].scale != expected.scale ||
            types[i].bias != expected.bias)
            return Fail(Status::FileUnrecognized,
                        "%s.layers[%zu]: types %s, %s, %s (weights, scales, biases): expected %s, %s, %s",
                        path, i, MlpDataTypeToString(types[i].weight), MlpDataTypeToString(types[i].scale),
                        MlpDataTypeToString(types[i].bias), MlpDataTypeToString(expected.weight),
                        MlpDataTypeToString(expected.scale), MlpDataTypeToString(expected.bias));
    }
    return {};
}

/// The network whose first layer is this, of a file of a generation: of later ones there is one.
inline Expected<int> FindNetworkVersion(const container::MlpLayer& first, std::uint32_t generation,
                                        const char* path) noexcept {
    const int version = generation == 1   ? GetNetworkVersionForInputs(first.inputChannels)
                        : generation == 2 ? NTC_NETWORK_GENERATION_2
                                          : NTC_NETWORK_GENERATION_3;
    if (version == NTC_NETWORK_UNKNOWN)
        return Fail(Status::FileUnrecognized, "%s.layers[0].inputChannels: %u: must be 48, 64, 80 or 96",
                    path, first.inputChannels);
    return version;
}

/// The dimensions of a layer: those of the network, but in generation 3 the channels between layers may be
/// fewer; what is missing counts as zeros.
inline Expected<void> CheckLayerSize(const container::MlpLayer& layer, const NetworkDescription& network,
                                     const char* path, std::size_t index) noexcept {
    const auto inputs = static_cast<std::uint32_t>(network.inputs[index]);
    const auto outputs = static_cast<std::uint32_t>(network.outputs[index]);
    const bool maySaveInputs = network.generation == 3 && index > 0;
    const bool maySaveOutputs = network.generation == 3 && index + 1 < kNetworkLayers;
    const auto fits = [](std::uint32_t channels, std::uint32_t full, bool maySave) {
        return channels == full || (maySave && channels >= 1 && channels < full);
    };
    if (fits(layer.inputChannels, inputs, maySaveInputs) &&
        fits(layer.outputChannels, outputs, maySaveOutputs))
        return {};
    return Fail(Status::FileUnrecognized, "%s.layers[%zu]: %u x %u: must be %s%u x %s%u in a %s network",
                path, index, layer.inputChannels, layer.outputChannels, maySaveInputs ? "at most " : "",
                inputs, maySaveOutputs ? "at most " : "", outputs, GetNetworkName(network.version));
}

} // namespace detail

/// Checks one network of a file of a generation: four layers of the dimensions of a network version,
/// row-major, a known combination of types, and views large enough. `path` names the network in messages
/// ("mlp", "mlpVersions[0]"). Errors: FileUnrecognized.
inline Expected<MlpInfo> ValidateMlp(const container::Mlp& mlp, std::uint32_t generation,
                                     std::span<const container::BufferView> views,
                                     const char* path) noexcept {
    if (mlp.layers.size() != kNetworkLayers)
        return Fail(Status::FileUnrecognized, "%s.layers: %zu: must be %d", path, mlp.layers.size(),
                    kNetworkLayers);
    MlpInfo info;
    OPENNTC_ASSIGN(info.networkVersion, detail::FindNetworkVersion(mlp.layers[0], generation, path));
    if (mlp.weightLayout != container::MatrixLayout::RowMajor)
        return Fail(Status::FileUnrecognized, "%s.weightLayout: %s: must be RowMajor", path,
                    mlp.weightLayout ? "ColumnMajor" : "absent");

    std::array<detail::LayerTypes, kNetworkLayers> types;
    for (std::size_t i = 0; i < kNetworkLayers; ++i)
        types[i] = detail::ResolveLayerTypes(mlp, mlp.layers[i]);
    OPENNTC_CHECK(detail::ClassifyMlp(types, generation, path, info));

    const NetworkDescription network = GetNetworkDescription(info.networkVersion);
    for (std::size_t i = 0; i < kNetworkLayers; ++i) {
        const container::MlpLayer& layer = mlp.layers[i];
        OPENNTC_CHECK(detail::CheckLayerSize(layer, network, path, i));
        const std::uint64_t inputs = layer.inputChannels;
        const std::uint64_t outputs = layer.outputChannels;
        const container::ElementPath layerPath{path, ".layers", i};
        OPENNTC_CHECK(
            container::CheckView(views, layer.weightView, inputs * outputs, layerPath, "weightView"));
        if (types[i].scale && layer.scaleView)
            OPENNTC_CHECK(container::CheckView(views, *layer.scaleView, outputs * 4, layerPath, "scaleView"));
        OPENNTC_CHECK(container::CheckView(views, layer.biasView,
                                           outputs * detail::GetMlpDataTypeBytes(*types[i].bias), layerPath,
                                           "biasView"));
    }
    return info;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
