// SPDX-License-Identifier: MIT
// Stability: experimental
// Texture sets with pseudo-random weights and latents: complete files that exercise every reader and decoder
// without anybody's material. Source of the generator: format specification, "test vectors".
#pragma once

#include "openntc/core/Half.h"
#include "openntc/core/Stream.h"
#include "openntc/texture_set/InferenceWeights.h"
#include "openntc/texture_set/WeightLoading.h"
#include "openntc/texture_set/WritableTextureSet.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What to synthesise. The same description gives the same bytes on every machine.
struct SynthesisDesc {
    std::uint32_t seed = 1;
    TextureSetDesc desc;                      ///< odd channel counts become even
    int networkVersion = NTC_NETWORK_UNKNOWN; ///< NTC_NETWORK_UNKNOWN: the smallest that holds the shape
    LatentShape shape;
    /// Channel ranges must lie inside the set. None: one texture "t" of all channels, without a channel
    /// format.
    std::span<const Texture> textures;
    std::uint32_t channelColorSpaces = 0; ///< storage colour space of channel c in bits 2c and 2c + 1
    bool withInt8 = true;                 ///< write an Int8 network
    bool withFP8 = false; ///< write an FP8 network too; Int8 weights and latents do not depend on it
    CompressionOptions compression; ///< generation 3
};

namespace detail {

/// Numerical Recipes' linear congruential generator, high halves.
class SynthesisGenerator {
public:
    explicit SynthesisGenerator(std::uint32_t seed) noexcept : state_(seed) {}

    int Next() noexcept {
        state_ = state_ * 1664525u + 1013904223u;
        return static_cast<int>(state_ >> 16);
    }

private:
    std::uint32_t state_;
};

/// Weights, scales and biases of one Int8 layer. The biases of layers behind an activation undo its offset of
/// -113.
inline void SynthesizeInt8Layer(SynthesisGenerator& generator, std::span<std::byte> buffer, int inputs,
                                int outputs, int weightOffset, int scaleOffset, int biasOffset,
                                bool isFirst) noexcept {
    std::array<int, kHiddenChannels> rowSums{};
    std::byte* weights = buffer.data() + weightOffset;
    std::byte* scales = buffer.data() + scaleOffset;
    std::byte* biases = buffer.data() + biasOffset;
    for (int row = 0; row < outputs; ++row) {
        for (int i = 0; i < inputs; ++i) {
            const int weight = generator.Next() % 255 - 127;
            rowSums[static_cast<std::size_t>(row)] += weight;
            *weights++ = static_cast<std::byte>(weight & 0xFF);
        }
    }
    for (int row = 0; row < outputs; ++row)
        StoreScalar(scales + 4 * row, static_cast<float>(1 + generator.Next() % 64) * 0x1p-20f);
    for (int row = 0; row < outputs; ++row) {
        const int bias = generator.Next() % 8192 - 4096;
        StoreScalar(
            biases + 4 * row,
            static_cast<std::int32_t>(isFirst ? bias : bias + 113 * rowSums[static_cast<std::size_t>(row)]));
    }
}

/// E4M3 weights up to 0.25 and biases up to 1 for layers 0 – 2: sums stay in the interesting part of the
/// activation.
inline void SynthesizeE4M3Layer(SynthesisGenerator& generator, std::span<std::byte> buffer, int inputs,
                                int outputs, int weightOffset, int biasOffset) noexcept {
    constexpr int kCodes = 0x29; // magnitudes 0 … 0x28 = 2^-2
    for (int i = 0; i < inputs * outputs; ++i) {
        const int n = generator.Next();
        buffer[static_cast<std::size_t>(weightOffset) + static_cast<std::size_t>(i)] =
            static_cast<std::byte>((n >> 8 & 0x80) | n % kCodes);
    }
    for (int row = 0; row < outputs; ++row) {
        const float bias = static_cast<float>(generator.Next() % 2048 - 1024) * 0x1p-10f; // exact in binary16
        StoreScalar(buffer.data() + biasOffset + 2 * row, FloatToHalf(bias));
    }
}

/// Packed codes of one grid, element order; those that encoders use.
inline Expected<void> SynthesizeGrid(SynthesisGenerator& generator, const LatentGrid& grid, int features,
                                     int quantBits, Array<std::byte>& destination) noexcept {
    const std::uint64_t bytes = GetLatentGridBytes(grid.width, grid.height, features, quantBits);
    if (bytes > std::numeric_limits<std::size_t>::max() / 2)
        return Fail(Status::OutOfMemory, "latents: %llu bytes: address space",
                    static_cast<unsigned long long>(bytes));
    destination.clear();
    OPENNTC_CHECK(destination.Resize(static_cast<std::size_t>(bytes)));
    const std::uint64_t elements = static_cast<std::uint64_t>(grid.width) *
                                   static_cast<std::uint64_t>(grid.height) *
                                   static_cast<std::uint64_t>(features);
    const int codes = GetLatentQuantization(quantBits).codes;
    for (std::uint64_t e = 0; e < elements; ++e) {
        const std::uint64_t bit = e * static_cast<std::uint64_t>(quantBits);
        const int code = generator.Next() % codes;
        destination[static_cast<std::size_t>(bit / 8)] |= static_cast<std::byte>(code << (bit % 8));
    }
    return {};
}

inline LatentImage MakeLatentImage(const TextureSetDesc& desc, int gridSizeScale, int neuralMip) noexcept {
    LatentImage image;
    image.highRes.width = GetLatentGridDimension(desc.width, gridSizeScale, neuralMip);
    image.highRes.height = GetLatentGridDimension(desc.height, gridSizeScale, neuralMip);
    image.lowRes.width = GetLatentGridDimension(desc.width, 2 * gridSizeScale, neuralMip);
    image.lowRes.height = GetLatentGridDimension(desc.height, 2 * gridSizeScale, neuralMip);
    return image;
}

inline Expected<void> SynthesizeInt8Network(SynthesisGenerator& generator, const NetworkDescription& network,
                                            InferenceWeights& weights) noexcept {
    OPENNTC_CHECK(weights.int8.Resize(static_cast<std::size_t>(network.int8Bytes)));
    for (std::size_t i = 0; i < kNetworkLayers; ++i)
        SynthesizeInt8Layer(generator, weights.int8.AsSpan(), network.inputs[i], network.outputs[i],
                            network.weightOffsets[i], network.int8ScaleOffsets[i], network.int8BiasOffsets[i],
                            i == 0);
    return {};
}

inline Expected<void> SynthesizeFP8Network(SynthesisGenerator& generator, const NetworkDescription& network,
                                           InferenceWeights& weights) noexcept {
    OPENNTC_CHECK(weights.fp8.Resize(static_cast<std::size_t>(network.fp8Bytes)));
    for (std::size_t i = 0; i < 3; ++i)
        SynthesizeE4M3Layer(generator, weights.fp8.AsSpan(), network.inputs[i], network.outputs[i],
                            network.weightOffsets[i], network.fp8BiasOffsets[i]);
    SynthesizeInt8Layer(generator, weights.fp8.AsSpan(), network.inputs[3], network.outputs[3],
                        network.weightOffsets[3], network.fp8ScaleOffset, network.fp8BiasOffsets[3], false);
    return {};
}

inline Expected<void> ValidateSynthesisDesc(const SynthesisDesc& synthesis, int networkVersion) noexcept {
    const TextureSetDesc& desc = synthesis.desc;
    OPENNTC_CHECK(ValidateTextureSetDesc(desc));
    if (synthesis.shape.IsEmpty())
        return Fail(Status::InvalidArgument, "latentShape: 0 features: needs a shape");
    OPENNTC_CHECK(ValidateLatentShape(synthesis.shape, networkVersion));
    if (!synthesis.withInt8 && !synthesis.withFP8)
        return Fail(Status::InvalidArgument, "networks: none: needs Int8, FP8 or both");
    const LatentImage finest = MakeLatentImage(desc, synthesis.shape.gridSizeScale, 0);
    if (finest.highRes.width > kMaxLatentDimension || finest.highRes.height > kMaxLatentDimension)
        return Fail(Status::OutOfRange, "latents: %d x %d: at most %d per side", finest.highRes.width,
                    finest.highRes.height, kMaxLatentDimension);
    for (const Texture& texture : synthesis.textures) {
        if (texture.firstChannel < 0 || texture.numChannels < 1 || texture.firstChannel >= desc.channels ||
            texture.numChannels > desc.channels - texture.firstChannel)
            return Fail(Status::OutOfRange, "texture channels: first %d, count %d: the set has %d",
                        texture.firstChannel, texture.numChannels, desc.channels);
    }
    return {};
}

/// Latents of an image of generation 1, or in `highRes` those of a latent mip.
struct SynthesizedLatents {
    LatentImage image;
    Array<std::byte> highRes;
    Array<std::byte> lowRes;
};

inline Expected<SynthesizedLatents> SynthesizeLatents(SynthesisGenerator& generator,
                                                      const SynthesisDesc& synthesis, int generation,
                                                      int number, Allocator& allocator) noexcept {
    const TextureSetDesc& desc = synthesis.desc;
    const LatentShape& shape = synthesis.shape;
    SynthesizedLatents latents{MakeLatentImage(desc, shape.gridSizeScale, number),
                               Array<std::byte>(allocator), Array<std::byte>(allocator)};
    LatentGrid& highRes = latents.image.highRes;
    if (generation > 1) {
        highRes.width = GetLatentMipDimension(desc.width, shape.gridSizeScale, number);
        highRes.height = GetLatentMipDimension(desc.height, shape.gridSizeScale, number);
    }
    OPENNTC_CHECK(
        SynthesizeGrid(generator, highRes, shape.highResFeatures, shape.highResQuantBits, latents.highRes));
    if (generation == 1)
        OPENNTC_CHECK(SynthesizeGrid(generator, latents.image.lowRes, shape.lowResFeatures,
                                     shape.lowResQuantBits, latents.lowRes));
    return latents;
}

inline Expected<void> AddSynthesizedLatents(WritableTextureSet& set, const LatentShape& shape, int generation,
                                            const SynthesizedLatents& latents) noexcept {
    const LatentGrid& highRes = latents.image.highRes;
    if (generation == 1)
        return set.AddLatentImage(latents.image, latents.highRes.AsSpan(), latents.lowRes.AsSpan());
    const std::size_t bytes = std::size_t{2} * static_cast<std::size_t>(highRes.width) *
                              static_cast<std::size_t>(highRes.height) *
                              static_cast<std::size_t>(GetLatentLayers(shape));
    return set.AddLatentMip(highRes.width, highRes.height, latents.highRes.AsSpan().first(bytes));
}

/// Colour mips as an encoder makes them.
inline Expected<void> AddSynthesizedMips(WritableTextureSet& set, const SynthesisDesc& synthesis,
                                         int generation, int images) noexcept {
    const TextureSetDesc& desc = synthesis.desc;
    const int scale = synthesis.shape.gridSizeScale;
    for (int mip = 0; mip < desc.mips; ++mip) {
        ColorMip record{GetMipDimension(desc.width, mip), GetMipDimension(desc.height, mip)};
        if (generation == 1) {
            record.neuralMip = GetNeuralMipForColorMip(mip, scale, images);
            record.positionLod = GetPositionLod(mip, record.neuralMip);
            record.positionScale = GetPositionScale(mip, record.neuralMip);
        } else {
            record.neuralMip = GetLatentMipForColorMip(mip, scale, images);
            record.positionScale = GetLatentPositionScale(
                record.width, record.height, GetLatentMipDimension(desc.width, scale, record.neuralMip),
                GetLatentMipDimension(desc.height, scale, record.neuralMip));
            record.positionLod = GetLatentPositionLod(record.positionScale);
        }
        OPENNTC_CHECK(set.AddColorMip(record));
    }
    return {};
}

} // namespace detail

/// Writes a synthesised texture set, of the generation that its network belongs to, from position 0 of the
/// stream. Errors: OutOfRange and InvalidArgument for what no file can hold, OutOfMemory, IOError.
inline Expected<void> SynthesizeTextureSet(Stream& destination, const SynthesisDesc& synthesis,
                                           Allocator& allocator = GetDefaultAllocator()) noexcept {
    const LatentShape& shape = synthesis.shape;
    const int version = synthesis.networkVersion == NTC_NETWORK_UNKNOWN
                            ? GetNetworkVersionForFeatures(shape.highResFeatures)
                            : synthesis.networkVersion;
    OPENNTC_CHECK(detail::ValidateSynthesisDesc(synthesis, version));
    const NetworkDescription network = GetNetworkDescription(version);
    const int generation = network.generation;
    const int images = generation == 1 ? GetNeuralMipCount(synthesis.desc, shape.gridSizeScale)
                                       : GetLatentMipCount(synthesis.desc, shape.gridSizeScale);

    detail::SynthesisGenerator generator(synthesis.seed);
    InferenceWeights weights(allocator);
    weights.networkVersion = version;
    OPENNTC_CHECK(detail::SynthesizeInt8Network(generator, network, weights));
    std::array<detail::SynthesizedLatents, NTC_MAX_NEURAL_MIPS> latents;
    for (int n = 0; n < images; ++n) {
        OPENNTC_ASSIGN(latents[static_cast<std::size_t>(n)],
                       detail::SynthesizeLatents(generator, synthesis, generation, n, allocator));
    }
    if (synthesis.withFP8)
        OPENNTC_CHECK(detail::SynthesizeFP8Network(generator, network, weights));

    WritableTextureSet set(allocator);
    OPENNTC_CHECK(set.SetDescription(synthesis.desc, shape, synthesis.channelColorSpaces, generation));
    OPENNTC_CHECK(set.SetCompression(synthesis.compression));
    if (synthesis.withInt8)
        OPENNTC_CHECK(set.AddNetwork(weights, InferenceWeightType::GenericInt8));
    OPENNTC_CHECK(set.AddNetwork(weights, InferenceWeightType::GenericFP8));
    for (const Texture& texture : synthesis.textures)
        OPENNTC_CHECK(set.AddTexture(texture));
    if (synthesis.textures.empty()) {
        Texture texture;
        texture.name = "t";
        texture.numChannels = synthesis.desc.channels;
        OPENNTC_CHECK(set.AddTexture(texture));
        set.GetDocument().textures.back().channelFormat.reset();
    }
    for (int n = 0; n < images; ++n)
        OPENNTC_CHECK(
            detail::AddSynthesizedLatents(set, shape, generation, latents[static_cast<std::size_t>(n)]));
    OPENNTC_CHECK(detail::AddSynthesizedMips(set, synthesis, generation, images));
    return set.Write(destination);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
