// SPDX-License-Identifier: MIT
// Tiled textures with known contents, in the buffers that shaders read: images whose texels are a function of
// their place, and a texture set cut into slices.
#pragma once

#include "support/streaming/StreamingCases.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/streaming/HostPageTable.h"
#include "openntc/streaming/TextureSetTileLayout.h"

#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace openntc_tests {

struct SceneTexture {
    openntc::TiledTextureDesc desc;
    std::vector<openntc::TiledLevel> levels;
    openntc::NtcTiledTexture header{};
    std::uint32_t id = 0;

    int GetWidth(int mip) const { return std::max(desc.width >> mip, 1); }
    int GetHeight(int mip) const { return std::max(desc.height >> mip, 1); }
    int GetFirstTailMip() const { return levels.empty() ? 0 : levels.back().lastMip + 1; }
    int GetLevelOf(int mip) const {
        int level = 0;
        while (level < static_cast<int>(levels.size()) &&
               levels[static_cast<std::size_t>(level)].lastMip < mip)
            ++level;
        return level;
    }
    bool IsSet() const { return desc.format == openntc::TileFormat::TextureSet; }
};

inline std::uint32_t Mix(std::uint32_t a, std::uint32_t b) {
    std::uint32_t h = a * 2654435761u ^ (b + 0x7F4A7C15u + (a << 6) + (a >> 2));
    h ^= h >> 15;
    h *= 0x2C1B3C6Du;
    h ^= h >> 12;
    return h;
}

/// The bytes of a texel: any for 8-bit formats, numbers of moderate size for floats.
inline std::array<std::uint8_t, 16> GetTexelBytesAt(const SceneTexture& texture, int mip, int x, int y) {
    std::array<std::uint8_t, 16> bytes{};
    std::uint32_t seed = Mix(texture.id * 16 + static_cast<std::uint32_t>(mip),
                             static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16);
    for (std::size_t i = 0; i < 16; i += 4) {
        seed = Mix(seed, 77);
        std::uint32_t word = seed;
        using openntc::TileFormat;
        const TileFormat format = texture.desc.format;
        if (format == TileFormat::R32F || format == TileFormat::RG32F || format == TileFormat::RGBA32F)
            word = (word & 0x807FFFFFu) | (120u + (word >> 23) % 12u) << 23;
        if (format == TileFormat::R16F || format == TileFormat::RG16F || format == TileFormat::RGBA16F)
            word &= 0xBFFFBFFFu; // magnitudes below 2; subnormal ones occur
        std::memcpy(bytes.data() + i, &word, 4);
    }
    return bytes;
}

/// The same as numbers, by another way than the shaders': C's own conversions.
inline std::array<double, 4> GetTexelValue(const SceneTexture& texture, int mip, int x, int y) {
    const auto bytes = GetTexelBytesAt(texture, mip, x, y);
    std::array<double, 4> value = {0, 0, 0, 1};
    const auto half = [&](std::size_t i) {
        const int bits = bytes[2 * i] | bytes[2 * i + 1] << 8;
        const int exponent = (bits >> 10) & 31;
        const double magnitude =
            exponent == 0 ? std::ldexp(bits & 1023, -24) : std::ldexp((bits & 1023) + 1024, exponent - 25);
        return (bits & 0x8000) != 0 ? -magnitude : magnitude;
    };
    const auto real = [&](std::size_t i) {
        float number;
        std::memcpy(&number, bytes.data() + 4 * i, 4);
        return static_cast<double>(number);
    };
    using openntc::TileFormat;
    const auto fill = [&](std::size_t count, auto&& get) {
        for (std::size_t i = 0; i < count; ++i)
            value[i] = get(i);
    };
    const auto unorm = [&](std::size_t i) { return bytes[i] / 255.0; };
    switch (texture.desc.format) {
    case TileFormat::R8:
        fill(1, unorm);
        break;
    case TileFormat::RG8:
        fill(2, unorm);
        break;
    case TileFormat::RGBA8:
        fill(4, unorm);
        break;
    case TileFormat::RGBA8Srgb:
        fill(4, unorm);
        fill(3, [&](std::size_t i) {
            return value[i] <= 0.04045 ? value[i] / 12.92 : std::pow((value[i] + 0.055) / 1.055, 2.4);
        });
        break;
    case TileFormat::R16F:
        fill(1, half);
        break;
    case TileFormat::RG16F:
        fill(2, half);
        break;
    case TileFormat::RGBA16F:
        fill(4, half);
        break;
    case TileFormat::R32F:
        fill(1, real);
        break;
    case TileFormat::RG32F:
        fill(2, real);
        break;
    case TileFormat::RGBA32F:
        fill(4, real);
        break;
    case TileFormat::TextureSet:
        break;
    }
    return value;
}

/// Everything on one side of the bus: the host's page table, and what a device would have.
class StreamingScene {
public:
    static constexpr std::uint32_t kSlotBytes = 16384;
    static constexpr std::uint32_t kSlots = 1024;
    static constexpr std::uint32_t kGuard = 0xDEADBEEFu;

    explicit StreamingScene(std::uint32_t queueCapacity = 4096)
        : table_(MakeTable(queueCapacity)), slots(kSlots * kSlotBytes / 4, 0xCDCDCDCDu) {
        feedback.assign(table_.GetLimits().maxRegions, 0);
        residency.assign(table_.GetLimits().maxTiles / 4, 0xFFFFFFFFu);
        ClearState();
    }

    /// Tiles of tileWidth x tileHeight; mips that fit one tile are the tail.
    SceneTexture& AddImage(int width, int height, int tileWidth, int tileHeight, openntc::TileFormat format,
                           openntc::TileFilter filter, openntc::TileWrap wrapU, openntc::TileWrap wrapV,
                           int anisotropy = 1, int tailTiles = 1, std::uint32_t slotBytes = kSlotBytes) {
        SceneTexture& texture = textures.emplace_back();
        openntc::TiledTextureDesc& desc = texture.desc;
        desc.width = width;
        desc.height = height;
        desc.tileWidth = tileWidth;
        desc.tileHeight = tileHeight;
        desc.format = format;
        desc.filter = filter;
        desc.wrapU = wrapU;
        desc.wrapV = wrapV;
        desc.maxAnisotropy = anisotropy;
        desc.tailTiles = tailTiles;
        desc.slotBytes = slotBytes;
        desc.slotsOffset = 0;
        desc.mips = 1;
        while ((std::max(width, height) >> (desc.mips - 1)) > 1)
            ++desc.mips;
        for (int mip = 0; texture.GetWidth(mip) > tileWidth || texture.GetHeight(mip) > tileHeight; ++mip)
            texture.levels.push_back({mip, mip});
        desc.levels = texture.levels;
        Register(texture);
        return texture;
    }

    /// A synthesised set, `tile` texels of a level's last mip a tile. One set a scene.
    SceneTexture& AddSet(int width, int height, int tile, openntc::TileFilter filter, openntc::TileWrap wrap,
                         int networkVersion = NTC_NETWORK_SMALL) {
        openntc::SynthesisDesc synthesis;
        synthesis.seed = 5;
        synthesis.networkVersion = networkVersion;
        int mips = 1;
        while ((std::max(width, height) >> (mips - 1)) > 1)
            ++mips;
        synthesis.desc = {width, height, 8, mips};
        synthesis.shape = networkVersion <= NTC_NETWORK_XLARGE ? openntc::LatentShape{4, 4, 8, 2, 4}
                                                               : openntc::MakeLayeredShape(3, 8);
        REQUIRE(SynthesizeTextureSet(file, synthesis));
        REQUIRE(file.Seek(0));
        auto loaded = openntc::TextureSetMetadata::Load(file);
        REQUIRE(loaded);
        metadata.emplace(std::move(*loaded));
        const auto layout = openntc::MakeTextureSetTileLayout(*metadata, tile, tile);
        REQUIRE(layout);
        SceneTexture& texture = textures.emplace_back();
        for (const openntc::TileLevel& level : layout->GetLevels())
            texture.levels.push_back({level.firstMip, level.lastMip});
        openntc::TiledTextureDesc& desc = texture.desc;
        desc.width = width;
        desc.height = height;
        desc.mips = mips;
        desc.tileWidth = desc.tileHeight = tile;
        desc.levels = texture.levels;
        desc.tailTiles = layout->GetTailTileCount();
        desc.format = openntc::TileFormat::TextureSet;
        desc.filter = filter;
        desc.wrapU = desc.wrapV = wrap;
        desc.slotBytes = kSlotBytes;
        desc.firstChannel = 1;
        Register(texture);
        REQUIRE(layout->GetTileCount() == static_cast<int>(texture.header.tileCount));
        // Every texel, from the whole set; shaders that stream read no rows of latent images.
        const openntc::NtcTextureSetConstants whole =
            *openntc::MakeInferenceData(*metadata, 0, mips, openntc::InferenceWeightType::GenericInt8);
        constants = whole;
        for (int i = 0; i < NTC_MAX_NEURAL_MIPS; ++i)
            constants.highResNeuralMips[i] = constants.lowResNeuralMips[i] = openntc::NtcNeuralMipConstants{};
        std::vector<std::byte> latents(*openntc::GetLatentBufferBytes(*metadata, 0, mips));
        REQUIRE(openntc::ReadLatents(*metadata, file, 0, mips, latents));
        const openntc::DecodeSource source = {&whole, latents, metadata->GetWeights().int8.AsSpan(),
                                              metadata->GetNetworkVersion()};
        for (int mip = 0; mip < mips; ++mip) {
            std::vector<float>& texels = setTexels.emplace_back(
                static_cast<std::size_t>(texture.GetWidth(mip) * texture.GetHeight(mip)) * 16);
            const auto decoded = DecodeReference(
                source, mip, {0, 0, texture.GetWidth(mip), texture.GetHeight(mip)}, {}, texels);
            REQUIRE_MESSAGE(decoded.has_value(), std::string(decoded.error().GetText()));
        }
        return texture;
    }

    /// Fills a free slot with the tile and maps it.
    void MapTile(const SceneTexture& texture, std::uint32_t tile) {
        if (*table_.GetSlot(texture.id, tile) != NTC_TILE_MISSING)
            return;
        REQUIRE(nextSlot_ < kSlots);
        const std::uint32_t slot = nextSlot_++;
        if (texture.IsSet())
            MapSetTile(texture, tile, slot);
        else
            MapImageTile(texture, tile, slot);
    }

    void UnmapTile(const SceneTexture& texture, std::uint32_t tile) {
        REQUIRE(table_.Unmap(texture.id, tile));
    }

    void MapTail(const SceneTexture& texture) {
        for (std::uint32_t tile = texture.header.firstTailTile; tile < texture.header.tileCount; ++tile)
            MapTile(texture, tile);
    }

    void MapAll(const SceneTexture& texture) {
        for (std::uint32_t tile = 0; tile < texture.header.tileCount; ++tile)
            MapTile(texture, tile);
    }

    /// Zero, with guard words behind it.
    void ClearState() {
        const openntc::LaunchState& layout = table_.GetLaunchState();
        std::vector<std::byte> bytes(layout.GetBytes());
        REQUIRE(ClearLaunchState(layout, bytes));
        state.assign(layout.words + 64, kGuard);
        std::memcpy(state.data(), bytes.data(), bytes.size());
    }

    bool AreGuardsWhole() const {
        for (std::size_t i = table_.GetLaunchState().words; i < state.size(); ++i) {
            if (state[i] != kGuard)
                return false;
        }
        return true;
    }

    openntc::RequestList GetRequests() const {
        auto list = ReadRequests(table_.GetLaunchState(), std::as_bytes(std::span(state)));
        REQUIRE(list);
        return *list;
    }

    /// Runs the items one after the other in C++.
    std::vector<std::uint32_t> Run(std::span<const openntc::StreamingItem> items,
                                   const openntc::NtcStreamingConstants& launch) {
        std::vector<std::uint32_t> words(table_.GetBytes().size() / 4);
        std::memcpy(words.data(), table_.GetBytes().data(), words.size() * 4);
        openntc::shader::NtcStreamingMemory memory;
        memory.pageTable = {words.data(), words.size()};
        memory.launchState = {state.data(), state.size()};
        memory.feedback = {feedback.data(), feedback.size()};
        memory.residency = {residency.data(), residency.size()};
        const openntc::shader::NtcStreamingWords pool = {slots.data(), slots.size()};
        memory.pools = &pool;
        memory.poolCount = 1;
        openntc::shader::NtcDemandSets sets{metadata ? metadata->GetNetworkVersion() : NTC_NETWORK_SMALL,
                                            NTC_MATH_INT8,
                                            &constants,
                                            {slots.data(), slots.size() * 4},
                                            {GetWeights().data(), GetWeights().size()}};
        memory.textureSets = &sets;
        std::vector<std::uint32_t> results;
        for (const openntc::StreamingItem& item : items) {
            std::uint32_t r[CASE_WORDS];
            RunStreamingItem(openntc::shader::NtcMakeStreamingContext(launch, item.seed, memory), item, r);
            results.insert(results.end(), r, r + CASE_WORDS);
        }
        return results;
    }

    std::span<const std::byte> GetWeights() const {
        return metadata ? metadata->GetWeights().int8.AsSpan() : std::span<const std::byte>();
    }
    openntc::PageTable& GetTable() { return table_; }
    const openntc::PageTable& GetTable() const { return table_; }

    std::deque<SceneTexture> textures;
    std::vector<std::uint32_t> state, feedback, residency;

private:
    openntc::PageTable table_;
    std::uint32_t nextSlot_ = 0;

    static openntc::PageTable MakeTable(std::uint32_t queueCapacity) {
        auto table = openntc::PageTable::Create({32, 8192, kSlots, kSlots, 16, 16384, queueCapacity});
        REQUIRE(table);
        return std::move(*table);
    }

    void Register(SceneTexture& texture) {
        const auto id = table_.Add(texture.desc);
        REQUIRE_MESSAGE(id.has_value(), std::string(id.error().GetText()));
        texture.id = *id;
        texture.header = *table_.GetHeader(*id);
    }

    std::byte* GetSlot(const SceneTexture& texture, std::uint32_t slot) {
        return reinterpret_cast<std::byte*>(slots.data()) + std::size_t{slot} * texture.desc.slotBytes;
    }

    void MapImageTile(const SceneTexture& texture, std::uint32_t tile, std::uint32_t slot) {
        const std::size_t size = GetTexelBytes(texture.desc.format);
        std::byte* const bytes = GetSlot(texture, slot);
        if (tile < texture.header.firstTailTile) {
            int mip = 0;
            std::uint32_t first = 0;
            const auto across = [&](int m) {
                return (texture.GetWidth(m) + texture.desc.tileWidth - 1) / texture.desc.tileWidth;
            };
            const auto down = [&](int m) {
                return (texture.GetHeight(m) + texture.desc.tileHeight - 1) / texture.desc.tileHeight;
            };
            while (first + static_cast<std::uint32_t>(across(mip) * down(mip)) <= tile) {
                first += static_cast<std::uint32_t>(across(mip) * down(mip));
                ++mip;
            }
            const int left = static_cast<int>(tile - first) % across(mip) * texture.desc.tileWidth;
            const int top = static_cast<int>(tile - first) / across(mip) * texture.desc.tileHeight;
            for (int y = top; y < std::min(top + texture.desc.tileHeight, texture.GetHeight(mip)); ++y) {
                for (int x = left; x < std::min(left + texture.desc.tileWidth, texture.GetWidth(mip)); ++x) {
                    const auto place =
                        static_cast<std::size_t>((y - top) * texture.desc.tileWidth + x - left);
                    std::memcpy(bytes + place * size, GetTexelBytesAt(texture, mip, x, y).data(), size);
                }
            }
        } else {
            std::vector<std::uint8_t> tail;
            for (int mip = texture.GetFirstTailMip(); mip < texture.desc.mips; ++mip) {
                for (int y = 0; y < texture.GetHeight(mip); ++y) {
                    for (int x = 0; x < texture.GetWidth(mip); ++x) {
                        const auto texel = GetTexelBytesAt(texture, mip, x, y);
                        tail.insert(tail.end(), texel.begin(), texel.begin() + static_cast<int>(size));
                    }
                }
            }
            const std::size_t start =
                std::size_t{tile - texture.header.firstTailTile} * texture.desc.slotBytes;
            if (start < tail.size())
                std::memcpy(bytes, tail.data() + start,
                            std::min<std::size_t>(tail.size() - start, texture.desc.slotBytes));
        }
        REQUIRE(table_.Map(texture.id, tile, slot));
    }

    void MapSetTile(const SceneTexture& texture, std::uint32_t tile, std::uint32_t slot) {
        const auto layout =
            openntc::MakeTextureSetTileLayout(*metadata, texture.desc.tileWidth, texture.desc.tileHeight);
        const openntc::TileSlice slice = *layout->GetTileSlice(tile);
        const auto cut = MakePartialInferenceData(*metadata, file, MakeSliceDesc(slice),
                                                  openntc::InferenceWeightType::GenericInt8,
                                                  {GetSlot(texture, slot), kSlotBytes});
        REQUIRE_MESSAGE(cut.has_value(), std::string(cut.error().GetText()));
        const auto row = [&](int mip) {
            return GetSliceConstants(cut->constants,
                                     metadata->GetColorMips()[static_cast<std::size_t>(mip)].neuralMip);
        };
        if (tile < texture.header.firstTailTile) {
            REQUIRE(table_.MapSlice(texture.id, tile, slot, row(slice.firstMip)));
            return;
        }
        for (int mip = slice.firstMip; mip < slice.firstMip + slice.mips; ++mip)
            REQUIRE(table_.SetTailSlice(texture.id, mip, slot, row(mip)));
        REQUIRE(table_.Map(texture.id, tile, slot));
    }

public:
    std::vector<std::uint32_t> slots;
    openntc::MemoryStream file;
    std::optional<openntc::TextureSetMetadata> metadata;
    openntc::NtcTextureSetConstants constants{};
    std::vector<std::vector<float>> setTexels; ///< by mip, 16 outputs a texel
};

} // namespace openntc_tests
