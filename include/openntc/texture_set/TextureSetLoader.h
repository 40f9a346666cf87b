// SPDX-License-Identifier: MIT
// Stability: internal
// Turns a parsed document into a checked texture set.
#pragma once

#include "openntc/container/Reader.h"
#include "openntc/container/Views.h"
#include "openntc/core/FloatBits.h"
#include "openntc/format/Limits.h"
#include "openntc/texture_set/LatentMipLoading.h"
#include "openntc/texture_set/MlpValidation.h"
#include "openntc/texture_set/TextureSetContents.h"
#include "openntc/texture_set/WeightLoading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// Beyond this, texel · positionScale could leave the range of binary32 in a decoder: 2^20 · 2^100 < 2^128.
inline constexpr float kMaxPositionScale = 0x1p100f;

/// min(W / hw, H / hh) in binary32, rounded half away from zero. Source: format specification, "texture-set
/// description".
inline int DeriveGridSizeScale(const TextureSetDesc& desc,
                               const container::LatentImageRecord& finest) noexcept {
    const std::uint32_t width = std::max({finest.highResWidth, finest.width, 1u}); // of other generations 0
    const std::uint32_t height = std::max({finest.highResHeight, finest.height, 1u});
    const float x = static_cast<float>(desc.width) / static_cast<float>(width);
    const float y = static_cast<float>(desc.height) / static_cast<float>(height);
    return static_cast<int>(std::round(std::min(x, y)));
}

inline Expected<void> CheckDescription(TextureSetContents& set) noexcept {
    const container::Document& document = set.document;
    if (document.width < 1 || document.width > static_cast<std::uint32_t>(kMaxImageDimension))
        return Fail(Status::OutOfRange, "width: %u: must be 1 … %d", document.width, kMaxImageDimension);
    if (document.height < 1 || document.height > static_cast<std::uint32_t>(kMaxImageDimension))
        return Fail(Status::OutOfRange, "height: %u: must be 1 … %d", document.height, kMaxImageDimension);
    if (document.numChannels < 1 || document.numChannels > NTC_MAX_CHANNELS)
        return Fail(Status::OutOfRange, "numChannels: %u: must be 1 … %d", document.numChannels,
                    NTC_MAX_CHANNELS);
    if (document.numColorMips < 1 || document.numColorMips > NTC_MAX_MIPS)
        return Fail(Status::OutOfRange, "numColorMips: %u: must be 1 … %d", document.numColorMips,
                    NTC_MAX_MIPS);
    set.desc = {ToInt(document.width), ToInt(document.height), ToInt(document.numChannels),
                ToInt(document.numColorMips)};

    if (document.latents.empty())
        return Fail(Status::FileUnrecognized, "latents: absent: needs 1 … %d latent images",
                    NTC_MAX_NEURAL_MIPS);
    if (document.latents.size() > NTC_MAX_NEURAL_MIPS)
        return Fail(Status::OutOfRange, "latents: %zu: at most %d latent images", document.latents.size(),
                    NTC_MAX_NEURAL_MIPS);
    if (!document.latentShape)
        return Fail(Status::FileUnrecognized, "latentShape: absent: needed to read latents");
    const container::LatentShapeRecord& shape = *document.latentShape;
    if (document.schemaVersion == 1) {
        set.latentShape = {0, ToInt(shape.highResFeatures), ToInt(shape.lowResFeatures),
                           ToInt(shape.highResQuantBits), ToInt(shape.lowResQuantBits)};
        OPENNTC_CHECK(ValidateLatentEncoding(set.latentShape, NTC_NETWORK_UNKNOWN));
    } else {
        set.latentShape = MakeLayeredShape(0, ToInt(shape.numFeatures));
        if (!IsFeatureCount(set.latentShape.highResFeatures))
            return Fail(Status::OutOfRange, "latentShape.numFeatures: %u: must be 4, 8, 12 or 16",
                        shape.numFeatures);
    }
    set.latentShape.gridSizeScale = DeriveGridSizeScale(set.desc, document.latents[0]);
    return {};
}

/// Checks all networks first, then reads the last one of each kind: later ones replace earlier ones.
inline Expected<void> LoadNetworks(TextureSetContents& set, const container::BinaryChunk& chunk) noexcept {
    const container::Document& document = set.document;
    const bool isFirst = document.schemaVersion == 1;
    if (!document.mlp && document.mlpVersions.empty())
        return isFirst ? Fail(Status::FileUnrecognized, "mlp: absent: needs mlp or mlpVersions")
                       : Fail(Status::FileUnrecognized, "mlpVersions: absent: needs a network or more");

    struct Choice {
        const container::Mlp* mlp = nullptr;
        MlpInfo info;
        char path[40] = {};
    };
    Choice int8;
    Choice fp8;
    int& version = set.weights.networkVersion;
    const std::size_t first = document.mlp ? 0 : 1; // number 0 is `mlp`, number i + 1 is mlpVersions[i]
    for (std::size_t number = first; number <= document.mlpVersions.size(); ++number) {
        Choice current;
        current.mlp = number == 0 ? &*document.mlp : &document.mlpVersions[number - 1];
        if (number == 0)
            std::memcpy(current.path, "mlp", 4);
        else
            std::snprintf(current.path, sizeof current.path, "mlpVersions[%zu]", number - 1);
        OPENNTC_ASSIGN(current.info,
                       ValidateMlp(*current.mlp, document.schemaVersion, chunk.views, current.path));
        if (version == NTC_NETWORK_UNKNOWN)
            version = current.info.networkVersion;
        if (version != current.info.networkVersion)
            return Fail(Status::FileUnrecognized, "%s: %s network: the other networks of the set are %s",
                        current.path, GetNetworkName(current.info.networkVersion), GetNetworkName(version));
        (current.info.weightType == InferenceWeightType::GenericFP8 ? fp8 : int8) = current;
    }
    OPENNTC_CHECK(ValidateLatentEncoding(set.latentShape, version));
    if (int8.mlp != nullptr)
        OPENNTC_CHECK(LoadMlpWeights(chunk, *int8.mlp, int8.info, int8.path, set.weights));
    if (fp8.mlp != nullptr)
        OPENNTC_CHECK(LoadMlpWeights(chunk, *fp8.mlp, fp8.info, fp8.path, set.weights));
    return {};
}

/// Of one (mode, partition) each.
inline constexpr std::size_t kMaxBlockCompressionModes = kBlockModes * kBlockPartitions;

/// How many (mode, partition) records a texture has. A blob that is not made of whole records is ignored, as
/// in LibNTC. The view's index has been checked.
inline Expected<std::size_t> CountBlockCompressionModes(const container::BinaryChunk& chunk,
                                                        std::uint32_t view, std::size_t texture) noexcept {
    constexpr std::size_t kRecordBytes = sizeof(BlockCompressionMode);
    const std::uint64_t bytes = chunk.views[view].storedSize;
    if (bytes % kRecordBytes != 0)
        return 0;
    if (bytes > kRecordBytes * kMaxBlockCompressionModes)
        return Fail(Status::FileUnrecognized, "textures[%zu].bcAccelerationDataView: %llu bytes: at most %zu",
                    texture, static_cast<unsigned long long>(bytes),
                    kRecordBytes * kMaxBlockCompressionModes);
    return static_cast<std::size_t>(bytes / kRecordBytes);
}

/// Reads and checks the records of a texture.
inline Expected<void> LoadBlockCompressionModes(const container::BinaryChunk& chunk, std::uint32_t view,
                                                std::size_t texture,
                                                std::span<BlockCompressionMode> modes) noexcept {
    // The struct in memory is the record of the file on little-endian machines, see WeightLoading.h.
    static_assert(sizeof(BlockCompressionMode) == 4 && offsetof(BlockCompressionMode, partition) == 1 &&
                  offsetof(BlockCompressionMode, frequency) == 2);
    OPENNTC_CHECK(container::ReadView(chunk, view, std::as_writable_bytes(modes)));
    for (std::size_t i = 0; i < modes.size(); ++i) {
        if (modes[i].mode >= kBlockModes || modes[i].partition >= kBlockPartitions)
            return Fail(Status::FileUnrecognized,
                        "textures[%zu].bcAccelerationDataView: record %zu: mode %u, partition %u: must be "
                        "below %d and %d",
                        texture, i, modes[i].mode, modes[i].partition, kBlockModes, kBlockPartitions);
    }
    return {};
}

/// The statistics of all textures, one after the other in set.bcModes. Spans into it are taken when it has
/// its size.
inline Expected<void> LoadBlockCompressionModes(TextureSetContents& set,
                                                const container::BinaryChunk& chunk) noexcept {
    const container::Document& document = set.document;
    std::size_t total = 0;
    for (std::size_t i = 0; i < document.textures.size(); ++i) {
        const container::TextureRecord& record = document.textures[i];
        if (!record.bcAccelerationDataView)
            continue;
        OPENNTC_CHECK(container::CheckView(chunk.views, *record.bcAccelerationDataView, 0,
                                           {"", "textures", i}, "bcAccelerationDataView"));
        OPENNTC_ASSIGN(const std::size_t count,
                       CountBlockCompressionModes(chunk, *record.bcAccelerationDataView, i));
        total += count;
    }
    OPENNTC_CHECK(set.bcModes.Resize(total));
    std::span<BlockCompressionMode> rest = set.bcModes.AsSpan();
    for (std::size_t i = 0; i < document.textures.size(); ++i) {
        const container::TextureRecord& record = document.textures[i];
        if (!record.bcAccelerationDataView)
            continue;
        OPENNTC_ASSIGN(const std::size_t count,
                       CountBlockCompressionModes(chunk, *record.bcAccelerationDataView, i));
        OPENNTC_CHECK(LoadBlockCompressionModes(chunk, *record.bcAccelerationDataView, i, rest.first(count)));
        set.textures[i].bcModes = rest.first(count);
        rest = rest.subspan(count);
    }
    return {};
}

inline Expected<void> LoadTextures(TextureSetContents& set, const container::BinaryChunk& chunk) noexcept {
    const container::Document& document = set.document;
    OPENNTC_CHECK(set.textures.Reserve(document.textures.size()));
    for (const container::TextureRecord& record : document.textures) {
        Texture texture;
        texture.name = record.name.View();
        if (record.numChannels >= 1 &&
            IsRangeInside(record.firstChannel, record.numChannels, document.numChannels)) {
            texture.firstChannel = static_cast<int>(record.firstChannel);
            texture.numChannels = static_cast<int>(record.numChannels);
            set.weights.validChannelMask |= ((1u << record.numChannels) - 1u) << record.firstChannel;
        }
        texture.channelFormat = record.channelFormat.value_or(ChannelFormat::UNORM8);
        texture.rgbColorSpace = record.rgbColorSpace;
        texture.alphaColorSpace = record.alphaColorSpace;
        texture.bcFormat = record.bcFormat;
        texture.bcQuality = static_cast<int>(record.bcQuality & 0xFFu); // as LibNTC: one byte
        OPENNTC_CHECK(set.textures.PushBack(texture));
    }
    OPENNTC_CHECK(LoadBlockCompressionModes(set, chunk));
    OPENNTC_CHECK(LoadBlockModePlaces(set, chunk));

    if (!document.channels.empty() && document.channels.size() != document.numChannels)
        return Fail(Status::FileUnrecognized, "channels: %zu: numChannels is %u", document.channels.size(),
                    document.numChannels);
    for (std::size_t i = 0; i < document.channels.size(); ++i)
        set.weights.channelColorSpaces |= static_cast<std::uint32_t>(document.channels[i].colorSpace)
                                          << (2 * i);
    return {};
}

inline Expected<LatentGrid> CheckLatentGrid(const container::BinaryChunk& chunk,
                                            const container::ElementPath& path, const char* grid,
                                            std::uint32_t width, std::uint32_t height,
                                            std::uint32_t bitsPerPixel, int expectedBits,
                                            std::uint32_t view) noexcept {
    constexpr std::uint32_t kMax = static_cast<std::uint32_t>(kMaxLatentDimension);
    if (width < 1 || width > kMax || height < 1 || height > kMax)
        return Fail(Status::OutOfRange, "latents[%zu].%s: %u x %u: sides must be 1 … %u", path.index, grid,
                    width, height, kMax);
    if (bitsPerPixel != static_cast<std::uint32_t>(expectedBits))
        return Fail(Status::FileUnrecognized, "latents[%zu].%sBitsPerPixel: %u: latentShape gives %d",
                    path.index, grid, bitsPerPixel, expectedBits);
    const std::uint64_t bytes = (std::uint64_t{width} * height * bitsPerPixel + 7) / 8;
    OPENNTC_CHECK(container::CheckView(chunk.views, view, bytes, path, grid));
    const container::BufferView& record = chunk.views[view];
    return LatentGrid{static_cast<int>(width), static_cast<int>(height), chunk.offset + record.offset,
                      record.storedSize};
}

inline Expected<void> CheckLatents(TextureSetContents& set, const container::BinaryChunk& chunk) noexcept {
    const LatentShape& shape = set.latentShape;
    const int highBits = shape.highResFeatures * shape.highResQuantBits;
    const int lowBits = shape.lowResFeatures * shape.lowResQuantBits;
    for (std::size_t i = 0; i < set.document.latents.size(); ++i) {
        const container::LatentImageRecord& record = set.document.latents[i];
        const container::ElementPath path{"", "latents", i};
        LatentImage& image = set.latentImages[i];
        OPENNTC_ASSIGN(image.highRes,
                       CheckLatentGrid(chunk, path, "highRes", record.highResWidth, record.highResHeight,
                                       record.highResBitsPerPixel, highBits, record.highResView));
        OPENNTC_ASSIGN(image.lowRes,
                       CheckLatentGrid(chunk, path, "lowRes", record.lowResWidth, record.lowResHeight,
                                       record.lowResBitsPerPixel, lowBits, record.lowResView));
    }
    set.latentImageCount = static_cast<int>(set.document.latents.size());
    return {};
}

inline Expected<void> CheckColorMips(TextureSetContents& set) noexcept {
    const container::Document& document = set.document;
    if (document.colorMips.size() != document.numColorMips)
        return Fail(Status::FileUnrecognized, "colorMips: %zu entries: numColorMips is %u",
                    document.colorMips.size(), document.numColorMips);
    for (std::size_t i = 0; i < document.colorMips.size(); ++i) {
        const container::ColorMipRecord& record = document.colorMips[i];
        const int mip = static_cast<int>(i);
        ColorMip& result = set.colorMips[i];
        result.width = GetMipDimension(set.desc.width, mip);
        result.height = GetMipDimension(set.desc.height, mip);
        if (!record.latentMip)
            return Fail(Status::FileUnrecognized, "colorMips[%zu].latentMip: absent: needs 0 … %zu", i,
                        document.latents.size() - 1);
        const std::size_t latents = document.latents.size() - (document.schemaVersion == 1 ? 0 : 1);
        if (*record.latentMip >= latents)
            return Fail(
                Status::FileUnrecognized,
                document.schemaVersion == 1
                    ? "colorMips[%zu].latentMip: %u: the set has %zu latent images"
                    : "colorMips[%zu].latentMip: %u: this and the next one are needed: must be below %zu",
                i, *record.latentMip, latents);
        result.neuralMip = static_cast<int>(*record.latentMip);
        if (record.width && record.height &&
            (ToInt(*record.width) != result.width || ToInt(*record.height) != result.height))
            return Fail(Status::FileUnrecognized, "colorMips[%zu]: %u x %u: must be %d x %d", i,
                        *record.width, *record.height, result.width, result.height);
        if (record.positionLod && record.positionScale) {
            result.positionLod = *record.positionLod;
            result.positionScale = *record.positionScale;
        } else {
            result.positionLod = GetPositionLod(mip, result.neuralMip);
            result.positionScale = GetPositionScale(mip, result.neuralMip);
        }
        if (!IsFinite(result.positionLod))
            return Fail(Status::FileUnrecognized, "colorMips[%zu].positionLod: %g: must be finite", i,
                        static_cast<double>(result.positionLod));
        if (!IsMagnitudeAtMost(result.positionScale, kMaxPositionScale))
            return Fail(Status::FileUnrecognized, "colorMips[%zu].positionScale: %g: beyond ±2^100", i,
                        static_cast<double>(result.positionScale));
    }
    return {};
}

inline Expected<TextureSetContents> LoadTextureSet(Stream& stream, Allocator& allocator) noexcept {
    // Not OPENNTC_ASSIGN: g++ 12 would take members of a moved-from optional for uninitialised.
    Expected<container::Container> read = container::ReadContainer(stream, allocator);
    if (!read)
        return PassError(read);
    container::Container& file = *read;
    TextureSetContents set(allocator);
    set.document = std::move(file.document);
    const container::BinaryChunk chunk{&stream, file.binaryOffset,
                                       std::as_const(set.document.views).AsSpan()};
    OPENNTC_CHECK(CheckDescription(set));
    OPENNTC_CHECK(LoadTextures(set, chunk));
    OPENNTC_CHECK(set.document.schemaVersion == 1 ? CheckLatents(set, chunk) : CheckLatentMips(set, chunk));
    OPENNTC_CHECK(CheckColorMips(set));
    OPENNTC_CHECK(LoadNetworks(set, chunk));
    return set;
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
