// SPDX-License-Identifier: MIT
// Stability: experimental
// Latents of generations 2 and 3 as the array texture that shaders sample with NTC_LATENT_FETCH =
// NTC_LATENTS_TEXTURE (openntc/LatentFetch.h has format and sampler): its size, and what to copy where.
//
//   auto size = GetLatentTextureSize(metadata);                     // the image: levels and layers
//   ReadLatents(metadata, stream, firstMip, numMips, staging);      // the bytes, in a buffer
//   for (const LatentTextureCopy& c : *GetLatentTextureCopies(metadata, firstMip, numMips))
//       regions.push_back({c.offset, 0, 0, {COLOR, c.level, 0, c.layers}, {}, {c.width, c.height, 1}});
//   vkCmdCopyBufferToImage(...)
//
// The constants are those of a buffer: MakeInferenceData of the same mips. Levels that were not copied are
// not sampled.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Of the array texture of 16-bit texels.
struct LatentTextureSize {
    std::uint32_t width = 0; ///< of level 0, in latent texels; level n has max(width >> n, 1)
    std::uint32_t height = 0;
    std::uint32_t levels = 0; ///< latent mips of the set, 2 … 8
    std::uint32_t layers = 0; ///< four features each, 1 … 4
};

/// All layers of a level: width · height · layers texels of 2 bytes, [layer][y][x] without gaps.
struct LatentTextureCopy {
    std::size_t offset = 0; ///< bytes in what ReadLatents reads, a multiple of 4
    std::uint32_t level = 0;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t layers = 0;
};

/// One for each latent mip that was read, finest first.
class LatentTextureCopies {
public:
    void Add(const LatentTextureCopy& copy) noexcept { copies_[count_++] = copy; }
    const LatentTextureCopy* begin() const noexcept { return copies_.data(); }
    const LatentTextureCopy* end() const noexcept { return copies_.data() + count_; }

private:
    std::array<LatentTextureCopy, NTC_MAX_NEURAL_MIPS> copies_{};
    std::size_t count_ = 0;
};

/// Errors: Unsupported for generation 1, whose latents are no texture.
inline Expected<LatentTextureSize> GetLatentTextureSize(const TextureSetMetadata& metadata) noexcept {
    const std::span<const LatentMip> mips = metadata.GetLatentMips();
    if (mips.empty())
        return Fail(Status::Unsupported,
                    "latents: of a set of generation %d: only those of 2 and 3 are a texture",
                    metadata.GetGeneration());
    return LatentTextureSize{
        static_cast<std::uint32_t>(mips[0].width), static_cast<std::uint32_t>(mips[0].height),
        static_cast<std::uint32_t>(mips.size()), static_cast<std::uint32_t>(mips[0].layers)};
}

/// What ReadLatents of the same mips reads, and where it goes. Errors: Unsupported for generation 1;
/// OutOfRange for mips that the set does not have.
inline Expected<LatentTextureCopies> GetLatentTextureCopies(const TextureSetMetadata& metadata, int firstMip,
                                                            int numMips) noexcept {
    OPENNTC_CHECK(GetLatentTextureSize(metadata));
    OPENNTC_CHECK(metadata.CheckMips(firstMip, numMips));
    const MipRange range = metadata.GetLatentsOfMips(firstMip, numMips);
    LatentTextureCopies copies;
    std::size_t offset = 0;
    for (int i = range.first; i <= range.last; ++i) {
        const LatentMip& mip = metadata.GetLatentMips()[static_cast<std::size_t>(i)];
        copies.Add({offset, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(mip.width),
                    static_cast<std::uint32_t>(mip.height), static_cast<std::uint32_t>(mip.layers)});
        offset += static_cast<std::size_t>(GetLatentMipBytes(mip.width, mip.height, mip.layers));
    }
    return copies;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
