// SPDX-License-Identifier: MIT
// Stability: stable
// Reads a texture set to write it again: what older versions wrote takes the form of the last LibNTC of its
// generation, 0.7.2 for the first.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/texture_set/TextureSetMetadata.h"
#include "openntc/texture_set/WritableTextureSet.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

namespace detail {

/// The latents of a grid as whole words; a last word that the file cut short is filled with zeros.
inline Expected<void> ReadLatentGrid(Stream& source, const LatentGrid& grid, int features, int quantBits,
                                     Array<std::byte>& destination) noexcept {
    const std::uint64_t bytes = GetLatentGridBytes(grid.width, grid.height, features, quantBits);
    if (bytes > std::numeric_limits<std::size_t>::max() / 2)
        return Fail(Status::OutOfMemory, "latents: %llu bytes: address space",
                    static_cast<unsigned long long>(bytes));
    destination.clear();
    OPENNTC_CHECK(destination.Resize(static_cast<std::size_t>(bytes)));
    const std::size_t stored = static_cast<std::size_t>(std::min(bytes, grid.size));
    if (!source.Seek(grid.offset) || !source.Read(destination.data(), stored))
        return Fail(Status::IOError, "latents: %zu bytes at %llu: cannot be read", stored,
                    static_cast<unsigned long long>(grid.offset));
    return {};
}

/// Bytes as the file stores them, behind what `destination` holds.
inline Expected<void> AppendStored(Stream& source, const StoredData& data,
                                   Array<std::byte>& destination) noexcept {
    if (data.range.size > std::numeric_limits<std::size_t>::max() / 2 - destination.size())
        return Fail(Status::OutOfMemory, "views: %llu bytes: address space",
                    static_cast<unsigned long long>(data.range.size));
    const std::size_t offset = destination.size();
    const auto bytes = static_cast<std::size_t>(data.range.size);
    OPENNTC_CHECK(destination.Resize(offset + bytes));
    if (!source.ReadAt(data.range.offset, destination.data() + offset, bytes))
        return Fail(Status::IOError, "views: %zu bytes at %llu: cannot be read", bytes,
                    static_cast<unsigned long long>(data.range.offset));
    return {};
}

/// Latent mips of generation 2 as they are, of generation 3 with their views as they are stored.
inline Expected<void> CopyLatentMips(const TextureSetMetadata& metadata, Stream& source,
                                     WritableTextureSet& set, Array<std::byte>& buffer) noexcept {
    for (const LatentMip& mip : metadata.GetLatentMips()) {
        const auto layers = static_cast<std::size_t>(mip.layers);
        buffer.clear();
        for (std::size_t i = 0; i < layers; ++i)
            OPENNTC_CHECK(AppendStored(source, mip.layerData[i], buffer));
        const std::span<const std::byte> all = std::as_const(buffer).AsSpan();
        if (metadata.GetGeneration() == 2) {
            OPENNTC_CHECK(set.AddLatentMip(mip.width, mip.height, all));
            continue;
        }
        std::array<std::span<const std::byte>, kMaxLatentLayers> parts;
        std::size_t offset = 0;
        for (std::size_t i = 0; i < layers; ++i) {
            const auto bytes = static_cast<std::size_t>(mip.layerData[i].range.size);
            parts[i] = all.subspan(offset, bytes);
            offset += bytes;
        }
        OPENNTC_CHECK(set.AddStoredLatentMip(mip, std::span(parts).first(layers)));
    }
    return {};
}

inline Expected<void> CopyBlockModes(const TextureSetMetadata& metadata, Stream& source,
                                     WritableTextureSet& set, Array<std::byte>& buffer) noexcept {
    const std::span<const Texture> textures = metadata.GetTextures();
    for (std::size_t i = 0; i < textures.size(); ++i) {
        for (const BlockModeBuffer& modes : textures[i].blockModes) {
            buffer.clear();
            OPENNTC_CHECK(AppendStored(source, modes.data, buffer));
            OPENNTC_CHECK(set.AddStoredBlockModes(i, modes, std::as_const(buffer).AsSpan()));
        }
    }
    return {};
}

} // namespace detail

/// Takes a loaded set over for writing. `source` is the stream that the metadata was loaded from. Writing and
/// loading gives an equal set, except that odd channel counts become even; legacy biases stay the integers
/// that loading made. Compressed views stay compressed, byte for byte. `withBlockModes`: BC7 modes of
/// generation 3 too. Errors: IOError, OutOfMemory.
inline Expected<WritableTextureSet> MakeWritableCopy(const TextureSetMetadata& metadata, Stream& source,
                                                     Allocator& allocator = GetDefaultAllocator(),
                                                     bool withBlockModes = true) noexcept {
    WritableTextureSet set(allocator);
    const LatentShape& shape = metadata.GetLatentShape();
    const InferenceWeights& weights = metadata.GetWeights();
    OPENNTC_CHECK(
        set.SetDescription(metadata.GetDesc(), shape, weights.channelColorSpaces, metadata.GetGeneration()));
    OPENNTC_CHECK(set.AddNetwork(weights, InferenceWeightType::GenericInt8));
    OPENNTC_CHECK(set.AddNetwork(weights, InferenceWeightType::GenericFP8));
    for (const Texture& texture : metadata.GetTextures())
        OPENNTC_CHECK(set.AddTexture(texture));
    Array<std::byte> highRes(allocator);
    Array<std::byte> lowRes(allocator);
    for (const LatentImage& image : metadata.GetLatentImages()) {
        OPENNTC_CHECK(detail::ReadLatentGrid(source, image.highRes, shape.highResFeatures,
                                             shape.highResQuantBits, highRes));
        OPENNTC_CHECK(detail::ReadLatentGrid(source, image.lowRes, shape.lowResFeatures,
                                             shape.lowResQuantBits, lowRes));
        OPENNTC_CHECK(
            set.AddLatentImage(image, std::as_const(highRes).AsSpan(), std::as_const(lowRes).AsSpan()));
    }
    OPENNTC_CHECK(detail::CopyLatentMips(metadata, source, set, highRes));
    if (withBlockModes)
        OPENNTC_CHECK(detail::CopyBlockModes(metadata, source, set, highRes));
    for (const ColorMip& mip : metadata.GetColorMips())
        OPENNTC_CHECK(set.AddColorMip(mip));
    return set;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
