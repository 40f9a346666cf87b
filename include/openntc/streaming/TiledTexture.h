// SPDX-License-Identifier: MIT
// Stability: experimental
// What a tiled texture is to shaders: a description, checked, as the header of a page table.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/format/Limits.h"
#include "openntc/streaming/StreamingConstants.h"
#include "openntc/streaming/TileLayoutTypes.h"
#include "openntc/streaming/detail/TileMath.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A level of tiles: the mips that it serves. Its tiles are counted in texels of lastMip.
struct TiledLevel {
    int firstMip = 0;
    int lastMip = 0; ///< firstMip or coarser
};

/// What the tiles of a texture hold (NTC_TILES_*).
enum class TileFormat : std::uint32_t {
    TextureSet = NTC_TILES_TEXTURE_SET, ///< latents
    R8 = NTC_TILES_R8,
    RG8 = NTC_TILES_RG8,
    RGBA8 = NTC_TILES_RGBA8,
    RGBA8Srgb = NTC_TILES_RGBA8_SRGB,
    R16F = NTC_TILES_R16F,
    RG16F = NTC_TILES_RG16F,
    RGBA16F = NTC_TILES_RGBA16F,
    R32F = NTC_TILES_R32F,
    RG32F = NTC_TILES_RG32F,
    RGBA32F = NTC_TILES_RGBA32F,
};

enum class TileFilter : std::uint32_t {
    Point = NTC_FILTER_POINT,
    Bilinear = NTC_FILTER_BILINEAR,
    Trilinear = NTC_FILTER_TRILINEAR,
};

enum class TileWrap : std::uint32_t {
    Repeat = NTC_WRAP_REPEAT,
    Clamp = NTC_WRAP_CLAMP,
    Mirror = NTC_WRAP_MIRROR,
};

struct TiledTextureDesc {
    int width = 0; ///< texels of mip 0, 1 … NTC_MAX_TILED_SIZE
    int height = 0;
    int mips = 1;      ///< 1 … 16
    int tileWidth = 0; ///< texels of a level's last mip, 1 … 65535
    int tileHeight = 0;
    /// Levels of tiles from the finest, one behind the other, from mip 0 on. The mips that they leave are the
    /// tail. An image has one mip a level; a texture set the mips of one latent image. None: all is tail.
    std::span<const TiledLevel> levels;
    int tailTiles = 0; ///< 1 or more if there are mips in the tail, else 0
    TileFormat format = TileFormat::RGBA8;

    TileFilter filter = TileFilter::Trilinear;
    TileWrap wrapU = TileWrap::Repeat;
    TileWrap wrapV = TileWrap::Repeat;
    int maxAnisotropy = 1; ///< 1 … 16
    float mipBias = 0;     ///< -16 … 16

    std::uint32_t pool = 0;          ///< the engine's number of the buffer with the slots
    std::uint32_t firstSlot = 0;     ///< slot s of the pool has stamp and slice row firstSlot + s
    std::uint32_t slotsOffset = 0;   ///< bytes from the start of the buffer to slot 0; a multiple of 4
    std::uint32_t slotBytes = 0;     ///< a multiple of 16
    std::uint32_t textureSet = 0;    ///< texture sets: number of the constants, for NtcDemandGrad
    std::uint32_t weightsOffset = 0; ///< texture sets: bytes, for NtcDemandGrad
    int firstChannel = 0;            ///< texture sets: first of the four outputs of NtcDemandGrad, 0 … 12
    bool convertToLinear = false;    ///< texture sets: of NtcDemandGrad

    /// Texels of mip 0 that share a word of feedback. 0: a tile of the finest level, as GetRegionSize says.
    int regionWidth = 0;
    int regionHeight = 0;
    bool hasFeedback = true; ///< false: no words of feedback, nothing is recorded
};

/// Bytes of a texel of an image; 0 for a texture set.
constexpr std::uint32_t GetTexelBytes(TileFormat format) noexcept {
    switch (format) {
    case TileFormat::R8:
        return 1;
    case TileFormat::RG8:
    case TileFormat::R16F:
        return 2;
    case TileFormat::RGBA8:
    case TileFormat::RGBA8Srgb:
    case TileFormat::RG16F:
    case TileFormat::R32F:
        return 4;
    case TileFormat::RGBA16F:
    case TileFormat::RG32F:
        return 8;
    case TileFormat::RGBA32F:
        return 16;
    case TileFormat::TextureSet:
        break;
    }
    return 0;
}

namespace detail {

inline Expected<void> CheckTiledNumber(const char* name, std::int64_t value, std::int64_t least,
                                       std::int64_t most) noexcept {
    if (value < least || value > most)
        return Fail(Status::OutOfRange, "%s: %lld: %lld to %lld", name, static_cast<long long>(value),
                    static_cast<long long>(least), static_cast<long long>(most));
    return {};
}

inline Expected<void> CheckTiledNumbers(const TiledTextureDesc& desc) noexcept {
    OPENNTC_CHECK(CheckTiledNumber("width", desc.width, 1, NTC_MAX_TILED_SIZE));
    OPENNTC_CHECK(CheckTiledNumber("height", desc.height, 1, NTC_MAX_TILED_SIZE));
    OPENNTC_CHECK(CheckTiledNumber("mips", desc.mips, 1, kMaxMips));
    OPENNTC_CHECK(CheckTiledNumber("tileWidth", desc.tileWidth, 1, 65535));
    OPENNTC_CHECK(CheckTiledNumber("tileHeight", desc.tileHeight, 1, 65535));
    OPENNTC_CHECK(CheckTiledNumber("levels", static_cast<std::int64_t>(desc.levels.size()), 0, desc.mips));
    OPENNTC_CHECK(CheckTiledNumber("format", static_cast<std::int64_t>(desc.format), NTC_TILES_TEXTURE_SET,
                                   NTC_TILES_FORMAT_COUNT - 1));
    OPENNTC_CHECK(CheckTiledNumber("filter", static_cast<std::int64_t>(desc.filter), 0, 2));
    OPENNTC_CHECK(CheckTiledNumber("wrapU", static_cast<std::int64_t>(desc.wrapU), 0, 2));
    OPENNTC_CHECK(CheckTiledNumber("wrapV", static_cast<std::int64_t>(desc.wrapV), 0, 2));
    OPENNTC_CHECK(CheckTiledNumber("maxAnisotropy", desc.maxAnisotropy, 1, 16));
    if (!(std::fabs(desc.mipBias) <= 16)) // NaN too
        return Fail(Status::OutOfRange, "mipBias: %g: -16 to 16", static_cast<double>(desc.mipBias));
    OPENNTC_CHECK(CheckTiledNumber("firstChannel", desc.firstChannel, 0, kMaxChannels - 4));
    OPENNTC_CHECK(CheckTiledNumber("regionWidth", desc.regionWidth, 0, NTC_MAX_TILED_SIZE));
    OPENNTC_CHECK(CheckTiledNumber("regionHeight", desc.regionHeight, 0, NTC_MAX_TILED_SIZE));
    if (desc.slotsOffset % 4 != 0 || desc.slotBytes % 16 != 0 || desc.slotBytes == 0)
        return Fail(Status::InvalidArgument,
                    "slotsOffset, slotBytes: %u, %u: multiples of 4 and of 16, slots not empty",
                    desc.slotsOffset, desc.slotBytes);
    return {};
}

/// Fills levels and tiles; returns the number of regular tiles.
inline Expected<std::uint32_t> PackTiledLevels(const TiledTextureDesc& desc,
                                               NtcTiledTexture& header) noexcept {
    std::uint64_t tiles = 0;
    int nextMip = 0;
    for (std::size_t i = 0; i < desc.levels.size(); ++i) {
        const TiledLevel& level = desc.levels[i];
        if (level.firstMip != nextMip || level.lastMip < level.firstMip || level.lastMip >= desc.mips)
            return Fail(Status::InvalidArgument, "levels[%zu]: mips %d to %d: from %d on, below %d", i,
                        level.firstMip, level.lastMip, nextMip, desc.mips);
        if (desc.format != TileFormat::TextureSet && level.lastMip != level.firstMip)
            return Fail(Status::InvalidArgument, "levels[%zu]: mips %d to %d: an image has one mip a level",
                        i, level.firstMip, level.lastMip);
        const int width = GetTiledMipSize(desc.width, level.lastMip);
        const int height = GetTiledMipSize(desc.height, level.lastMip);
        const int across = (width + desc.tileWidth - 1) / desc.tileWidth;
        const int down = (height + desc.tileHeight - 1) / desc.tileHeight;
        if (across > 65535 || down > 65535)
            return Fail(Status::OutOfRange, "levels[%zu]: %d x %d tiles: at most 65535 an axis", i, across,
                        down);
        NtcTiledLevel& packed = header.levels[i];
        packed.widthFirstMip = static_cast<std::uint32_t>(width | (level.firstMip << 24));
        packed.heightLastMip = static_cast<std::uint32_t>(height | (level.lastMip << 24));
        packed.tilesXY = static_cast<std::uint32_t>(across) | (static_cast<std::uint32_t>(down) << 16);
        packed.firstTile = static_cast<std::uint32_t>(tiles);
        for (int mip = level.firstMip; mip <= level.lastMip; ++mip) {
            std::uint32_t& word = mip < 8 ? header.mipLevels0 : header.mipLevels1;
            word |= static_cast<std::uint32_t>(i) << (4 * (mip % 8));
        }
        tiles += static_cast<std::uint64_t>(across) * static_cast<std::uint64_t>(down);
        if (tiles > 0x7FFFFFFFu)
            return Fail(Status::OutOfRange, "levels: more than 2^31 tiles");
        nextMip = level.lastMip + 1;
    }
    header.levelsMips = static_cast<std::uint32_t>(desc.levels.size()) |
                        (static_cast<std::uint32_t>(desc.mips) << 8) |
                        (static_cast<std::uint32_t>(nextMip) << 16);
    return static_cast<std::uint32_t>(tiles);
}

/// Tiles and tail of an image must fit their slots. The mips of the tail lie one behind the other.
inline Expected<void> CheckImageBytes(const TiledTextureDesc& desc, int firstTailMip) noexcept {
    const std::uint64_t texelBytes = GetTexelBytes(desc.format);
    if (texelBytes == 0)
        return {};
    const std::uint64_t tileBytes =
        static_cast<std::uint64_t>(desc.tileWidth) * static_cast<std::uint64_t>(desc.tileHeight) * texelBytes;
    if (!desc.levels.empty() && tileBytes > desc.slotBytes)
        return Fail(Status::OutOfRange, "slotBytes: %u: a tile has %llu", desc.slotBytes,
                    static_cast<unsigned long long>(tileBytes));
    std::uint64_t tailBytes = 0;
    for (int mip = firstTailMip; mip < desc.mips; ++mip)
        tailBytes += static_cast<std::uint64_t>(GetTiledMipSize(desc.width, mip)) *
                     static_cast<std::uint64_t>(GetTiledMipSize(desc.height, mip)) * texelBytes;
    const std::uint64_t room = static_cast<std::uint64_t>(desc.tailTiles) * desc.slotBytes;
    if (tailBytes > room || tailBytes > 0xFFFFFFFFu)
        return Fail(Status::OutOfRange, "tailTiles: %d of %u bytes: the tail has %llu", desc.tailTiles,
                    desc.slotBytes, static_cast<unsigned long long>(tailBytes));
    return {};
}

} // namespace detail

/// The header of a texture, with places in shared buffers (firstEntry, firstTailRow, firstRegion) still 0.
/// Errors: OutOfRange and InvalidArgument, which name the field, its value and what may be there.
inline Expected<NtcTiledTexture> MakeTiledTexture(const TiledTextureDesc& desc) noexcept {
    OPENNTC_CHECK(detail::CheckTiledNumbers(desc));
    NtcTiledTexture header{};
    OPENNTC_ASSIGN(const std::uint32_t regularTiles, detail::PackTiledLevels(desc, header));
    const int firstTailMip = static_cast<int>(header.levelsMips >> 16);
    if (desc.tailTiles < 0 || desc.tailTiles > 0xFFFF || (desc.tailTiles > 0) != (firstTailMip < desc.mips))
        return Fail(Status::InvalidArgument, "tailTiles: %d for %d mips: none for none, at most 65535",
                    desc.tailTiles, desc.mips - firstTailMip);
    OPENNTC_CHECK(detail::CheckImageBytes(desc, firstTailMip));
    header.tileCount = regularTiles + static_cast<std::uint32_t>(desc.tailTiles);
    header.firstTailTile = regularTiles;
    header.width = static_cast<std::uint32_t>(desc.width);
    header.height = static_cast<std::uint32_t>(desc.height);
    header.tileSize =
        static_cast<std::uint32_t>(desc.tileWidth) | (static_cast<std::uint32_t>(desc.tileHeight) << 16);
    header.sampling = static_cast<std::uint32_t>(desc.filter) |
                      (static_cast<std::uint32_t>(desc.wrapU) << 4) |
                      (static_cast<std::uint32_t>(desc.wrapV) << 8) |
                      (static_cast<std::uint32_t>(desc.maxAnisotropy) << 16);
    header.mipBias = desc.mipBias;
    header.format = static_cast<std::uint32_t>(desc.format);
    header.pool = desc.pool;
    header.firstSlot = desc.firstSlot;
    header.slotsWord = desc.slotsOffset / 4;
    header.slotWords = desc.slotBytes / 4;
    header.textureSet = desc.textureSet;
    header.weightsOffset = desc.weightsOffset;
    header.channels =
        static_cast<std::uint32_t>(desc.firstChannel) | (desc.convertToLinear ? std::uint32_t{1} << 8 : 0u);
    if (desc.hasFeedback) {
        const int lastMip = desc.levels.empty() ? 0 : desc.levels[0].lastMip;
        const auto getRegion = [lastMip](int given, int textureSize, int tileSize) {
            return given > 0 ? given : GetRegionSize(textureSize, std::int64_t{tileSize} << lastMip);
        };
        const int regionWidth = getRegion(desc.regionWidth, desc.width, desc.tileWidth);
        const int regionHeight = getRegion(desc.regionHeight, desc.height, desc.tileHeight);
        const int across = (desc.width + regionWidth - 1) / regionWidth;
        const int down = (desc.height + regionHeight - 1) / regionHeight;
        if (across > 65535 || down > 65535)
            return Fail(Status::OutOfRange, "regions: %d x %d: at most 65535 an axis", across, down);
        header.regionWidth = static_cast<std::uint32_t>(regionWidth);
        header.regionHeight = static_cast<std::uint32_t>(regionHeight);
        header.regionsXY = static_cast<std::uint32_t>(across) | (static_cast<std::uint32_t>(down) << 16);
    }
    return header;
}

/// Words of feedback of a texture, one per region.
constexpr std::uint32_t GetRegionCount(const NtcTiledTexture& header) noexcept {
    return (header.regionsXY & 0xFFFFu) * (header.regionsXY >> 16);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
