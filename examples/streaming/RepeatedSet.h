// SPDX-License-Identifier: MIT
// A large texture set that is nowhere stored: its latent images repeat those of a small set. It has metadata
// and constants of its own, like a set that was encoded at that size, and positions are those of the large
// set.
#pragma once

#include "openntc/inference/PartialInference.h"
#include "openntc/streaming/TextureSetTileLayout.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace openntc::landscape {

/// Moves the repeated images, by whole pixels of the small set's coarsest grid, so that sets made
/// from the same small one differ.
struct Phase {
    int x = 0;
    int y = 0;

    friend bool operator==(const Phase&, const Phase&) = default;
};

class RepeatedSet {
public:
    /// The set in `path`, of any generation, repeated to `size` x `size` texels, in tiles of `tileSize`
    /// texels of a level's last mip. Throws CommandError: BadInput for a set that is not square, not a power
    /// of two, larger than `size`, or whose latent pixels are not whole bytes.
    RepeatedSet(const std::string& path, int size, int tileSize);

    const std::string& GetName() const noexcept { return name_; }
    const TextureSetMetadata& GetMetadata() const noexcept { return metadata_; }
    const TileLayout& GetLayout() const noexcept { return layout_; }
    /// With the latents of the whole set, from byte 0 on.
    const NtcTextureSetConstants& GetConstants() const noexcept { return constants_; }
    std::span<const std::byte> GetWeights() const noexcept { return metadata_.GetWeights().int8.AsSpan(); }
    /// Bytes of all latents.
    std::uint64_t GetLatentBytes() const noexcept { return latentBytes_; }
    /// Bytes of all textures of the set in their block-compressed formats (BC7, BC5, BC4, …), with all mips.
    std::uint64_t GetBlockBytes() const noexcept { return blockBytes_; }
    /// Different values of each of Phase's numbers, from 0 on.
    int GetPhases() const noexcept { return phases_; }
    int GetColorChannel() const noexcept { return colorChannel_; }
    /// -1: the set has no normals.
    int GetNormalChannel() const noexcept { return normalChannel_; }

    std::uint32_t GetTileBytes(std::uint32_t tile) const noexcept { return tileBytes_[tile]; }
    std::uint32_t GetLargestTileBytes() const noexcept { return largestTileBytes_; }

    /// Writes the slice that a tile is, as a source would from the file that does not exist. Errors:
    /// OutOfRange.
    Expected<void> WriteTile(std::uint32_t tile, Phase phase,
                             std::span<std::byte> destination) const noexcept;
    /// All latents, as GetConstants wants them.
    std::vector<std::byte> MakeLatents(Phase phase) const;

private:
    /// A grid of the small set (of later generations a layer of a latent mip), or the mean of one.
    struct Pattern {
        int width = 0;
        int height = 0;
        std::size_t pixelBytes = 0;
        std::vector<std::byte> pixels;
    };
    /// Part of a grid of the large set, packed row by row; of later generations it wraps.
    struct Part {
        std::size_t pattern = 0;
        int left = 0;
        int top = 0;
        int width = 0;
        int height = 0;
        int gridWidth = 0;
        int gridHeight = 0;
    };

    static Pattern Shrink(const Pattern& pattern, int factor, int bits);
    void ReadPatterns(const std::string& path);
    std::vector<Pattern> ReadGrids(const std::string& path) const;
    /// Patterns of an image, or of a latent mip.
    std::size_t GetPatternsEach() const noexcept;
    void WritePart(const Part& part, Phase phase, std::byte* to) const noexcept;
    void WriteGrids(const SliceLayout& slice, Phase phase, std::byte* to) const noexcept;
    void WriteLatentMips(const LatentMipSliceLayout& slice, Phase phase, std::byte* to) const noexcept;
    void PickChannels();

    std::string name_;
    std::vector<Pattern> patterns_; // high-res, low-res of each image; layers of each latent mip
    TextureSetMetadata metadata_;
    TileLayout layout_;
    NtcTextureSetConstants constants_{};
    std::uint64_t latentBytes_ = 0;
    std::uint64_t blockBytes_ = 0;
    int phases_ = 1;
    int colorChannel_ = 0;
    int normalChannel_ = -1;
    std::vector<std::uint32_t> tileBytes_;
    std::uint32_t largestTileBytes_ = 0;
};

} // namespace openntc::landscape
