// SPDX-License-Identifier: MIT
// Stability: stable
// Latents of a texture set of any generation, read into the buffer that decoders and shaders index.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/texture_set/StoredDataReader.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Bytes of the buffer for the latents of mips firstMip … firstMip + numMips - 1, a multiple of 4. Errors:
/// OutOfRange for mips that the set does not have; OutOfMemory for more than an address can count.
inline Expected<std::size_t> GetLatentBufferBytes(const TextureSetMetadata& metadata, int firstMip,
                                                  int numMips) noexcept {
    OPENNTC_ASSIGN(const StreamRange range, metadata.GetStreamRangeForLatents(firstMip, numMips));
    std::uint64_t bytes = (range.size / 4 + (range.size % 4 != 0 ? 1 : 0)) * 4;
    if (metadata.GetGeneration() > 1) {
        bytes = 0;
        const MipRange images = metadata.GetLatentsOfMips(firstMip, numMips);
        for (int i = images.first; i <= images.last; ++i) {
            const LatentMip& mip = metadata.GetLatentMips()[static_cast<std::size_t>(i)];
            bytes += GetLatentMipBytes(mip.width, mip.height, mip.layers);
        }
    }
    if (bytes > std::numeric_limits<std::size_t>::max() / 2)
        return Fail(Status::OutOfMemory, "latents: %llu bytes: address space",
                    static_cast<unsigned long long>(bytes));
    return static_cast<std::size_t>(bytes);
}

/// Reads the latents of mips firstMip … firstMip + numMips - 1 and everything between them. Generation 1: the
/// bytes of the file. Generations 2 and 3: latent mips one after the other, each from a multiple of 4 on, its
/// layers [layer][y][x] in texels of 16 bits. `destination` has GetLatentBufferBytes. MakeInferenceData of
/// the same mips makes the constants. `stream` is the one that the metadata was loaded from; compressed
/// latents take memory of `allocator` meanwhile. Errors: OutOfRange for mips that the set does not have;
/// InvalidArgument for another size; IOError; FileUnrecognized for compressed latents that are corrupt;
/// OutOfMemory.
inline Expected<void> ReadLatents(const TextureSetMetadata& metadata, Stream& stream, int firstMip,
                                  int numMips, std::span<std::byte> destination,
                                  Allocator& allocator = GetDefaultAllocator()) noexcept {
    OPENNTC_ASSIGN(const std::size_t bytes, GetLatentBufferBytes(metadata, firstMip, numMips));
    if (destination.size() != bytes)
        return Fail(Status::InvalidArgument, "destination: %zu bytes: must be %zu", destination.size(),
                    bytes);
    if (metadata.GetGeneration() == 1) {
        OPENNTC_ASSIGN(const StreamRange range, metadata.GetStreamRangeForLatents(firstMip, numMips));
        const auto stored = static_cast<std::size_t>(range.size);
        if (!stream.ReadAt(range.offset, destination.data(), stored))
            return Fail(Status::IOError, "latents: %zu bytes at %llu: cannot be read", stored,
                        static_cast<unsigned long long>(range.offset));
        std::memset(destination.data() + stored, 0, bytes - stored);
        return {};
    }
    StoredDataReader reader(stream, allocator);
    const MipRange images = metadata.GetLatentsOfMips(firstMip, numMips);
    for (int i = images.first; i <= images.last; ++i) {
        const LatentMip& mip = metadata.GetLatentMips()[static_cast<std::size_t>(i)];
        const auto layerBytes = static_cast<std::size_t>(mip.GetLayerBytes());
        const auto layers = static_cast<std::size_t>(mip.layers);
        for (std::size_t layer = 0; layer < layers; ++layer)
            OPENNTC_CHECK(reader.Read(mip.layerData[layer],
                                      destination.subspan(layer * layerBytes, layerBytes), "latents"));
        const auto mipBytes = static_cast<std::size_t>(GetLatentMipBytes(mip.width, mip.height, mip.layers));
        std::memset(destination.data() + layers * layerBytes, 0, mipBytes - layers * layerBytes);
        destination = destination.subspan(mipBytes);
    }
    return {};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
