// SPDX-License-Identifier: MIT
// Stability: internal
// From a trained network and latents to a texture-set file.
#pragma once

#include "openntc/core/E4M3.h"
#include "openntc/core/Half.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/detail/Trainer.h"
#include "openntc/format/NetworkDescription.h"
#include "openntc/texture_set/WritableTextureSet.h"

#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

template <typename T>
void StoreAt(std::span<std::byte> buffer, int offset, T value) {
    std::memcpy(buffer.data() + offset, &value, sizeof(T));
}

/// One output row as the file stores it.
struct QuantisedRow {
    std::array<std::int8_t, kHidden> weights{};
    float scale = 0.0f;
    std::int32_t bias = 0;
};
inline void StoreWeights(std::span<std::byte> buffer, int offset, const QuantisedRow& row, int count) {
    std::memcpy(buffer.data() + offset, row.weights.data(), static_cast<std::size_t>(count));
}

/// The row of an output that is not trained: 0, or a constant. A scale of |value| and a bias of 1 reproduce
/// any binary32 value exactly.
inline QuantisedRow MakeConstantRow(float value) {
    QuantisedRow row;
    row.scale = value == 0.0f ? 1.0f / 65536.0f : std::fabs(value);
    row.bias = value == 0.0f ? 0 : value < 0.0f ? -1 : 1;
    return row;
}

/// Row `output` of the last layer, with the channel's range folded in (format specification: "Int8 row
/// quantisation").
inline QuantisedRow MakeOutputRow(const NetworkState& network, const TrainingSet& set, int output) {
    const ChannelPlan& plan = set.GetChannel(output);
    const auto trained = set.GetTrainedChannels();
    if (std::find(trained.begin(), trained.end(), output) == trained.end())
        return MakeConstantRow(plan.declared ? plan.minimum : 0.0f);
    QuantisedRow row;
    const int inputs = network.GetShape().LayerInputs(3);
    const float* integers =
        network.packed.integers.data() + network.GetShape().WeightOffset(3) + output * inputs;
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(inputs); ++i) {
        row.weights[i] = static_cast<std::int8_t>(integers[i]);
        sum += row.weights[i];
    }
    const int at = NetworkShape::BiasOffset(3) + output;
    row.scale = network.packed.scale[at] * plan.range;
    const double bias = static_cast<double>(network.packed.bias[at]) +
                        static_cast<double>(plan.minimum) / static_cast<double>(row.scale);
    row.bias = static_cast<std::int32_t>(std::llround(bias) + 113 * sum);
    return row;
}

/// The "generic Int8" weight buffer of the working weights packed last (which must be quantised).
inline void FillInt8Weights(const NetworkState& network, const TrainingSet& set,
                            const NetworkDescription& file, std::span<std::byte> buffer) {
    const NetworkShape& shape = network.GetShape();
    for (int layer = 0; layer < 3; ++layer) {
        const auto l = static_cast<std::size_t>(layer);
        const int inputs = shape.LayerInputs(layer);
        const float* integers = network.packed.integers.data() + shape.WeightOffset(layer);
        const float unit = shape.blended ? 1.0f : kHiddenUnit;
        for (int o = 0; o < shape.LayerOutputs(layer); ++o) {
            std::int64_t sum = 0;
            for (int i = 0; i < inputs; ++i) {
                const int column = layer == 0 ? shape.FileSlot(i) : i;
                if (column < 0)
                    continue;
                const auto q = static_cast<std::int8_t>(integers[o * inputs + i]);
                StoreAt(buffer, file.weightOffsets[l] + o * file.inputs[l] + column, q);
                sum += q;
            }
            const int at = NetworkShape::BiasOffset(layer) + o;
            StoreAt(buffer, file.int8ScaleOffsets[l] + 4 * o, network.packed.scale[at] * unit);
            const auto bias =
                static_cast<std::int64_t>(network.packed.bias[at]) + (layer == 0 ? 0 : 113 * sum);
            StoreAt(buffer, file.int8BiasOffsets[l] + 4 * o, static_cast<std::int32_t>(bias));
        }
    }
    for (int o = 0; o < kOutputs; ++o) {
        const QuantisedRow row = MakeOutputRow(network, set, o);
        StoreWeights(buffer, file.weightOffsets[3] + o * file.inputs[3], row, file.inputs[3]);
        StoreAt(buffer, file.int8ScaleOffsets[3] + 4 * o, row.scale);
        StoreAt(buffer, file.int8BiasOffsets[3] + 4 * o, row.bias);
    }
}

/// Codes of a grid as the file packs them (format specification: "Bit packing and addressing").
inline std::vector<std::byte> PackLatents(const LatentPlanes& grid) {
    const LatentQuantiser& q = grid.quantiser;
    const std::size_t bits = grid.values.size() * static_cast<std::size_t>(q.bits);
    std::vector<std::byte> bytes((bits + 31) / 32 * 4);
    std::size_t element = 0;
    for (std::size_t pixel = 0; pixel < grid.PlaneSize(); ++pixel) {
        for (std::size_t f = 0; f < static_cast<std::size_t>(grid.features); ++f, ++element) {
            const float value = grid.values[f * grid.PlaneSize() + pixel];
            const int level = std::clamp(static_cast<int>(std::floor(value * q.scale + 0.5f)), q.lowestLevel,
                                         q.highestLevel);
            const auto code = static_cast<unsigned>(level - q.lowestLevel);
            const std::size_t bit = element * static_cast<std::size_t>(q.bits);
            bytes[bit / 8] |= static_cast<std::byte>(code << (bit % 8));
        }
    }
    return bytes;
}

/// Codes of a latent mip of generation 3: [layer][y][x] of 16 bits, four features of 4 bits from the lowest
/// on.
inline std::vector<std::byte> PackLayers(const LatentPlanes& grid) {
    constexpr std::size_t kFeatures = kLayerFeatures;
    const auto features = static_cast<std::size_t>(grid.features);
    std::vector<std::byte> bytes(features / kFeatures * 2 * grid.PlaneSize());
    for (std::size_t f = 0; f < features; ++f) {
        const float* values = grid.values.data() + f * grid.PlaneSize();
        std::byte* layer = bytes.data() + f / kFeatures * 2 * grid.PlaneSize();
        const std::size_t nibble = f % kFeatures;
        for (std::size_t pixel = 0; pixel < grid.PlaneSize(); ++pixel) {
            const int level = static_cast<int>(std::floor(values[pixel] * grid.quantiser.scale + 0.5f));
            const int code = std::clamp(level, 0, grid.quantiser.highestLevel);
            layer[2 * pixel + nibble / 2] |= static_cast<std::byte>(code << (nibble % 2 * 4));
        }
    }
    return bytes;
}

/// The "generic FP8" weight buffer of the working weights packed last.
inline void FillFp8Weights(const NetworkState& network, const TrainingSet& set,
                           const NetworkDescription& file, std::span<std::byte> buffer) {
    const NetworkShape& shape = network.GetShape();
    for (int layer = 0; layer < 3; ++layer) {
        const auto l = static_cast<std::size_t>(layer);
        const int inputs = shape.LayerInputs(layer);
        const float* weights = network.packed.integers.data() + shape.WeightOffset(layer);
        for (int o = 0; o < shape.LayerOutputs(layer); ++o) {
            for (int i = 0; i < inputs; ++i) {
                const int column = layer == 0 ? shape.FileSlot(i) : i;
                if (column >= 0)
                    StoreAt(buffer, file.weightOffsets[l] + o * file.inputs[l] + column,
                            FloatToE4M3(weights[o * inputs + i]));
            }
            StoreAt(buffer, file.fp8BiasOffsets[l] + 2 * o,
                    FloatToHalf(network.packed.bias[NetworkShape::BiasOffset(layer) + o]));
        }
    }
    for (int o = 0; o < kOutputs; ++o) {
        const QuantisedRow row = MakeOutputRow(network, set, o);
        StoreWeights(buffer, file.weightOffsets[3] + o * file.inputs[3], row, file.inputs[3]);
        StoreAt(buffer, file.fp8ScaleOffset + 4 * o, row.scale);
        StoreAt(buffer, file.fp8BiasOffsets[3] + 4 * o, row.bias);
    }
}

/// What training leaves for the file.
struct TrainedParts {
    struct Latents {
        GridSize highSize, lowSize;
        std::vector<std::byte> high, low;
    };
    /// Of generation 3.
    struct LatentMip {
        GridSize size;
        std::vector<std::byte> layers;
    };
    InferenceWeights weights;
    std::vector<Latents> latents;      ///< of generation 1
    std::vector<LatentMip> latentMips; ///< of generation 3
    std::vector<ColorMip> mips;
};

/// Int8 network and latents of a trainer whose latents are frozen.
template <typename Kernel>
Expected<TrainedParts> CollectParts(Trainer<Kernel>& trainer, const TrainingSet& set, int networkVersion) {
    trainer.PackNetwork();
    TrainedParts parts;
    parts.weights.networkVersion = networkVersion;
    const NetworkDescription description = GetNetworkDescription(networkVersion);
    OPENNTC_CHECK(parts.weights.int8.Resize(static_cast<std::size_t>(description.int8Bytes)));
    FillInt8Weights(trainer.GetNetwork(), set, description, parts.weights.int8.AsSpan());
    const bool layered = trainer.GetNetwork().GetShape().blended;
    for (std::size_t n = 0; n < trainer.GetHighGrids().size(); ++n) {
        const LatentPlanes& high = trainer.GetHighGrids()[n];
        const LatentPlanes& low = trainer.GetLowGrids()[n];
        if (layered) {
            parts.latentMips.push_back({high.size, PackLayers(high)});
            parts.latentMips.push_back({low.size, PackLayers(low)});
            continue;
        }
        parts.latents.push_back({high.size, low.size, PackLatents(high), PackLatents(low)});
    }
    for (const MipGeometry& mip : trainer.GetMips()) {
        ColorMip record;
        record.width = mip.width;
        record.height = mip.height;
        record.neuralMip = layered ? 2 * mip.neuralMip : mip.neuralMip;
        record.positionLod = mip.positionLod;
        record.positionScale = mip.positionScale;
        parts.mips.push_back(record);
    }
    return parts;
}

/// Adds the FP8 network of a trainer.
template <typename Kernel>
Expected<void> AddFp8Network(Trainer<Kernel>& trainer, const TrainingSet& set, TrainedParts& parts) {
    trainer.PackNetwork();
    const NetworkDescription description = GetNetworkDescription(parts.weights.networkVersion);
    OPENNTC_CHECK(parts.weights.fp8.Resize(static_cast<std::size_t>(description.fp8Bytes)));
    FillFp8Weights(trainer.GetNetwork(), set, description, parts.weights.fp8.AsSpan());
    return {};
}

/// The complete file. `compress`: latents, of generation 3.
inline Expected<void> WriteTextureSet(const TrainedParts& parts, const TrainingSet& set,
                                      const Material& material, const LatentShape& shape, bool compress,
                                      Stream& destination) {
    WritableTextureSet file;
    TextureSetDesc desc{};
    desc.width = set.GetWidth();
    desc.height = set.GetHeight();
    desc.mips = set.GetMipCount();
    desc.channels = material.GetChannelCount();
    OPENNTC_CHECK(file.SetDescription(desc, shape, material.GetChannelColorSpaces(),
                                      GetGeneration(parts.weights.networkVersion)));
    if (compress)
        OPENNTC_CHECK(file.SetCompression({.latents = true}));
    OPENNTC_CHECK(file.AddNetwork(parts.weights, InferenceWeightType::GenericInt8));
    if (!parts.weights.fp8.empty())
        OPENNTC_CHECK(file.AddNetwork(parts.weights, InferenceWeightType::GenericFP8));
    for (const MaterialTexture& source : material.GetTextures()) {
        Texture texture;
        texture.name = source.name;
        texture.firstChannel = source.firstChannel;
        texture.numChannels = source.channels;
        texture.channelFormat = source.format;
        texture.rgbColorSpace = source.rgbColorSpace;
        texture.alphaColorSpace = source.alphaColorSpace;
        texture.bcFormat = source.bcFormat;
        OPENNTC_CHECK(file.AddTexture(texture));
    }
    for (const TrainedParts::Latents& latents : parts.latents) {
        LatentImage image;
        image.highRes.width = latents.highSize.width;
        image.highRes.height = latents.highSize.height;
        image.lowRes.width = latents.lowSize.width;
        image.lowRes.height = latents.lowSize.height;
        OPENNTC_CHECK(file.AddLatentImage(image, latents.high, latents.low));
    }
    for (const TrainedParts::LatentMip& mip : parts.latentMips) {
        OPENNTC_CHECK(file.AddLatentMip(mip.size.width, mip.size.height, mip.layers));
    }
    for (const ColorMip& mip : parts.mips)
        OPENNTC_CHECK(file.AddColorMip(mip));
    return file.Write(destination);
}

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
