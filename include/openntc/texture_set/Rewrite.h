// SPDX-License-Identifier: MIT
// Stability: stable
// Reads a texture set to write it again: what older versions wrote takes the form of LibNTC 0.7.2.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/texture_set/TextureSetMetadata.h"
#include "openntc/texture_set/WritableTextureSet.h"

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

} // namespace detail

/// Takes a loaded set over for writing. `source` is the stream that the metadata was loaded from. Writing and
/// loading gives an equal set, except that odd channel counts become even; legacy biases stay the integers
/// that loading made. Errors: IOError, OutOfMemory.
inline Expected<WritableTextureSet> MakeWritableCopy(const TextureSetMetadata& metadata, Stream& source,
                                                     Allocator& allocator = GetDefaultAllocator()) noexcept {
    WritableTextureSet set(allocator);
    const LatentShape& shape = metadata.GetLatentShape();
    const InferenceWeights& weights = metadata.GetWeights();
    OPENNTC_CHECK(set.SetDescription(metadata.GetDesc(), shape, weights.channelColorSpaces));
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
    for (const ColorMip& mip : metadata.GetColorMips())
        OPENNTC_CHECK(set.AddColorMip(mip));
    return set;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
