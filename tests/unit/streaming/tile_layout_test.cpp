// SPDX-License-Identifier: MIT
// Geometry of tiles: sizes, numbers, regions, relations and texels, against rational arithmetic over all
// pairs, and against the sizes of a few textures written down by hand.
#include "support/TestSeed.h"

#include "openntc/core/Stream.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/streaming/TextureSetTileLayout.h"
#include "openntc/streaming/TileLayout.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <set>
#include <vector>

using namespace openntc;

namespace {

TileLayout MakeLayout(const TileLayoutDesc& desc) {
    auto layout = TileLayout::Create(desc);
    REQUIRE_MESSAGE(layout, (layout ? "" : layout.error().GetText()));
    return *layout;
}

/// Do [a, b) / c and [d, e) / f overlap?
bool OverlapsAsFractions(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d, std::int64_t e,
                         std::int64_t f) {
    return a * f < e * c && d * c < b * f;
}

/// Texels of a column of tiles in its level.
void GetTexels(const TileLayout& layout, int level, int column, std::int64_t& begin, std::int64_t& end) {
    const TileLevel& of = layout.GetLevels()[static_cast<std::size_t>(level)];
    begin = std::int64_t{column} * layout.GetTileWidth();
    end = std::min<std::int64_t>(begin + layout.GetTileWidth(), of.width);
}

Status GetLayoutRefusal(const TileLayoutDesc& desc) {
    const auto layout = TileLayout::Create(desc);
    REQUIRE_FALSE(layout);
    return layout.error().GetStatus();
}

} // namespace

TEST_CASE("tile layout: the textures of the specification") {
    TileLayoutDesc desc;
    desc.width = desc.height = 2048;
    desc.tileWidth = desc.tileHeight = 256;
    desc.mips = 12;
    desc.levelCount = 4;
    const TileLayout square = MakeLayout(desc);
    CHECK(square.GetTileCount() == 86);
    CHECK(square.GetRegionCount() == 64);
    CHECK(square.GetTailFirstMip() == 4);
    CHECK(square.GetLevels()[2].tilesX == 2);
    CHECK(square.GetLevels()[2].firstTile == 80);

    desc = {};
    desc.width = 257;
    desc.height = 130;
    desc.tileWidth = desc.tileHeight = 64;
    desc.mips = 9;
    desc.levelCount = 2;
    const TileLayout odd = MakeLayout(desc);
    CHECK(odd.GetLevels()[0].tilesX == 5);
    CHECK(odd.GetLevels()[0].tilesY == 3);
    CHECK(odd.GetLevels()[1].width == 128);
    CHECK(odd.GetLevels()[1].tilesX == 2);
    CHECK(odd.GetRelatedTiles({0, 4, 2}, 1) == TileRect{1, 1, 1, 1}); // no column 2 above column 4
    CHECK(odd.GetTilesOfRegion(4, 0, 1) == TileRect{1, 0, 1, 0});
    CHECK(odd.GetTilePosition(18) == TilePosition{1, 1, 1});
    CHECK(odd.GetTilePosition(19) == TilePosition{2, 0, 0});

    desc.levelCount = kLevelsAboveOneTile; // 257 × 130, 128 × 65; 64 × 32 fits
    CHECK(MakeLayout(desc).GetLevelCount() == 2);
}

TEST_CASE("tile layout: feedback regions") {
    const struct {
        int size, tile, region, count;
    } cases[] = {{64, 64, 32, 2}, {385, 64, 64, 7}, {100, 32, 32, 4}, {37, 32, 16, 3}, {128, 96, 64, 2},
                 {1, 64, 1, 1},   {2, 64, 1, 2},    {3, 64, 1, 3},    {127, 64, 32, 4}};
    for (const auto& c : cases) {
        TileLayoutDesc desc;
        desc.width = c.size;
        desc.height = 64;
        desc.tileWidth = desc.tileHeight = c.tile;
        desc.levelCount = 0;
        const TileLayout layout = MakeLayout(desc);
        CHECK_MESSAGE(layout.GetRegionWidth() == c.region, c.size);
        CHECK_MESSAGE(layout.GetRegionsX() == c.count, c.size);
    }
    TileLayoutDesc desc; // what Direct3D was told
    desc.width = desc.height = 1024;
    desc.tileWidth = desc.tileHeight = 256;
    desc.mips = 11;
    desc.regionWidth = 128;
    desc.regionHeight = 64;
    CHECK(MakeLayout(desc).GetRegionCount() == 8 * 16);
}

TEST_CASE("tile layout: numbers and places, both ways") {
    TileLayoutDesc desc;
    desc.width = 449;
    desc.height = 321;
    desc.tileWidth = 64;
    desc.tileHeight = 32;
    desc.mips = 9;
    desc.levelCount = 3;
    desc.tailTiles = 3;
    const TileLayout layout = MakeLayout(desc);
    CHECK(layout.GetTileCount() == 8 * 11 + 4 * 5 + 2 * 3 + 3);
    for (std::uint32_t tile = 0; tile < static_cast<std::uint32_t>(layout.GetTileCount()); ++tile) {
        const auto position = layout.GetTilePosition(tile);
        REQUIRE(position);
        CHECK(layout.GetTileNumber(*position) == tile);
    }
    CHECK_FALSE(layout.GetTilePosition(static_cast<std::uint32_t>(layout.GetTileCount())));
    for (const TilePosition& bad : {TilePosition{-1, 0, 0}, TilePosition{4, 0, 0}, TilePosition{0, 8, 0},
                                    TilePosition{0, 0, -1}, TilePosition{3, 3, 0}, TilePosition{3, 0, 1}})
        CHECK_FALSE(layout.GetTileNumber(bad));
}

TEST_CASE("tile layout: relations are those of fractions, for random sizes") {
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto pick = [&](int least, int most) {
        return static_cast<int>(random() % static_cast<unsigned>(most - least + 1)) + least;
    };
    for (int round = 0; round < 300; ++round) {
        TileLayoutDesc desc;
        desc.width = pick(1, 300);
        desc.height = 1;
        desc.tileWidth = pick(1, 40);
        desc.tileHeight = 1;
        desc.mips = 16;
        std::vector<TileLevelDesc> levels;
        int size = desc.width;
        for (int mip = 0; mip < pick(1, 6); ++mip) { // sizes that shrink by anything
            levels.push_back({size, 1, mip, mip});
            size = pick(std::max(size / 5, 1), size);
        }
        desc.levels = levels;
        const TileLayout layout = MakeLayout(desc);
        for (int level = 0; level < layout.GetLevelCount(); ++level) {
            const int tiles = layout.GetLevels()[static_cast<std::size_t>(level)].tilesX;
            const std::int64_t levelSize = levels[static_cast<std::size_t>(level)].width;
            std::int64_t begin = 0, end = 0, otherBegin = 0, otherEnd = 0;
            for (int region = 0; region < layout.GetRegionsX(); ++region) {
                const TileRect found = layout.GetTilesOfRegion(region, 0, level);
                for (int tile = 0; tile < tiles; ++tile) {
                    GetTexels(layout, level, tile, begin, end);
                    const std::int64_t left = std::int64_t{region} * layout.GetRegionWidth();
                    const bool overlaps = OverlapsAsFractions(
                        left, std::min<std::int64_t>(left + layout.GetRegionWidth(), desc.width), desc.width,
                        begin, end, levelSize);
                    CHECK(overlaps == (tile >= found.left && tile <= found.right));
                }
            }
            for (int other = 0; other < layout.GetLevelCount(); ++other) {
                const std::int64_t otherSize = levels[static_cast<std::size_t>(other)].width;
                for (int tile = 0; tile < tiles; ++tile) {
                    GetTexels(layout, level, tile, begin, end);
                    const TileRect found = layout.GetRelatedTiles({level, tile, 0}, other);
                    const int others = layout.GetLevels()[static_cast<std::size_t>(other)].tilesX;
                    for (int column = 0; column < others; ++column) {
                        GetTexels(layout, other, column, otherBegin, otherEnd);
                        CHECK(OverlapsAsFractions(begin, end, levelSize, otherBegin, otherEnd, otherSize) ==
                              (column >= found.left && column <= found.right));
                    }
                }
            }
        }
    }
}

TEST_CASE("tile layout: the shader's function finds the tile that 64-bit fractions give") {
    for (int mipSize = 1; mipSize <= 260; ++mipSize) {
        for (int shift = 0; shift <= 5; ++shift) {
            const int levelSize = std::max(mipSize >> shift, 1);
            for (const int tileSize : {1, 2, 3, 4, 7, 16, 300}) {
                for (int texel = 0; texel < mipSize; ++texel) {
                    const int expected =
                        detail::GetTileOfTexel(texel, mipSize, detail::TileAxis{levelSize, tileSize});
                    if (NtcTileOfTexel(texel, mipSize, shift, tileSize) != expected)
                        FAIL_CHECK(mipSize << " " << shift << " " << tileSize << " " << texel);
                }
            }
        }
    }
    std::mt19937 random(1);
    for (int i = 0; i < 1000000; ++i) { // up to the largest image
        const int mipSize = static_cast<int>(random() % (1u << (1 + random() % 20))) + 1;
        const int shift = static_cast<int>(random() % 8);
        const int levelSize = std::max(mipSize >> shift, 1);
        const int tileSize = static_cast<int>(random() % static_cast<unsigned>(levelSize)) + 1;
        const int near = static_cast<int>(std::int64_t{mipSize} * tileSize / levelSize *
                                          static_cast<std::int64_t>(random() % 8));
        const int texel = std::clamp(near + static_cast<int>(random() % 9) - 4, 0, mipSize - 1);
        if (NtcTileOfTexel(texel, mipSize, shift, tileSize) !=
            detail::GetTileOfTexel(texel, mipSize, detail::TileAxis{levelSize, tileSize}))
            FAIL_CHECK(mipSize << " " << shift << " " << tileSize << " " << texel);
    }
}

TEST_CASE("tile layout: slices hold their tile's texels at every mip, and each texel has one tile") {
    for (const int width : {1, 31, 257, 263, 500, 512}) {
        TileLayoutDesc desc;
        desc.width = width;
        desc.height = 100;
        desc.tileWidth = 8;
        desc.tileHeight = 5;
        desc.mips = 9;
        const TileLevelDesc levels[] = {{std::max(width >> 3, 1), 12, 0, 3},
                                        {std::max(width >> 5, 1), 3, 4, 5}};
        desc.levels = levels;
        const TileLayout layout = MakeLayout(desc);
        for (int mip = 0; mip < desc.mips; ++mip) {
            for (int y = 0; y < layout.GetMipHeight(mip); ++y) {
                for (int x = 0; x < layout.GetMipWidth(mip); ++x) {
                    const auto tile = layout.GetTileOfTexel(mip, x, y);
                    REQUIRE(tile);
                    const auto number = layout.GetTileNumber(*tile);
                    REQUIRE(number);
                    const auto slice = layout.GetTileSlice(*number);
                    REQUIRE(slice);
                    const int coarser = mip - slice->firstMip;
                    const bool isInside = coarser >= 0 && coarser < slice->mips &&
                                          x >= slice->left >> coarser && y >= slice->top >> coarser &&
                                          ((x << coarser) < slice->left + slice->width) &&
                                          ((y << coarser) < slice->top + slice->height);
                    CHECK_MESSAGE(isInside, width << ": mip " << mip << " texel " << x << ", " << y);
                    if (tile->level == layout.GetLevelCount())
                        continue;
                    const auto largest = layout.GetLargestTileSlice(tile->level);
                    REQUIRE(largest);
                    CHECK(slice->width <= largest->width);
                    CHECK(slice->height <= largest->height);
                }
            }
        }
    }
    TileLayoutDesc desc; // sizes that divide: the tile, scaled to the first mip, and nothing more
    desc.width = desc.height = 2048;
    desc.tileWidth = desc.tileHeight = 32;
    desc.mips = 12;
    const TileLevelDesc levels[] = {{256, 256, 0, 3}, {64, 64, 4, 5}};
    desc.levels = levels;
    const TileLayout layout = MakeLayout(desc);
    CHECK(layout.GetTileSlice(9) == TileSlice{0, 4, 256, 256, 256, 256});
    CHECK(layout.GetTileSlice(64 + 3) == TileSlice{4, 2, 64, 64, 64, 64});
    CHECK(layout.GetTileSlice(68) == TileSlice{6, 6, 0, 0, 32, 32});
    CHECK(layout.GetRegionWidth() == 256);
    CHECK(layout.GetRegionsX() == 8);
    CHECK(layout.GetLevelOfMip(3) == 0);
    CHECK(layout.GetLevelOfMip(4) == 1);
    CHECK(layout.GetLevelOfMip(11) == 2);
    CHECK(layout.GetFirstMipOfLevel(2) == 6);
}

TEST_CASE("tile layout: of a texture set: a level per latent image, the rest is tail") {
    for (const int width : {512, 263}) {
        SynthesisDesc desc;
        desc.seed = 7;
        desc.desc = {width, 256, 4, width == 512 ? 10 : 9};
        desc.networkVersion = NTC_NETWORK_SMALL;
        desc.shape.gridSizeScale = 4;
        desc.shape.highResFeatures = 4;
        desc.shape.highResQuantBits = 2;
        desc.shape.lowResFeatures = 4;
        desc.shape.lowResQuantBits = 4;
        desc.withInt8 = true;
        Texture texture;
        texture.name = "all";
        texture.numChannels = 4;
        desc.textures = {&texture, 1};
        MemoryStream stream;
        REQUIRE(SynthesizeTextureSet(stream, desc));
        REQUIRE(stream.Seek(0));
        const auto set = TextureSetMetadata::Load(stream);
        REQUIRE(set);
        const auto layout = MakeTextureSetTileLayout(*set, 16, 16, 2);
        REQUIRE(layout);
        int mip = 0;
        for (const TileLevel& level : layout->GetLevels()) {
            const auto fused = set->GetFusedMipLevels(mip);
            REQUIRE(fused);
            CHECK(level.firstMip == fused->first);
            CHECK(level.lastMip == fused->last);
            CHECK(level.width == set->GetColorMips()[static_cast<std::size_t>(fused->last)].width);
            CHECK((level.width > 16 || level.height > 16));
            mip = fused->last + 1;
        }
        REQUIRE(mip < set->GetDesc().mips);
        const auto tail = set->GetFusedMipLevels(mip);
        REQUIRE(tail);
        CHECK(layout->GetTailFirstMip() == mip);
        CHECK(set->GetColorMips()[static_cast<std::size_t>(tail->last)].width <= 16);
        CHECK(layout->GetTailTileCount() == 2);
        const auto whole = MakeTextureSetTileLayout(*set, 1024, 1024);
        REQUIRE(whole);
        CHECK(whole->GetLevelCount() == 0);
    }
}

TEST_CASE("tile layout: what is refused") {
    TileLayoutDesc good;
    good.width = good.height = 256;
    good.tileWidth = good.tileHeight = 64;
    good.mips = 9;
    CHECK(MakeLayout(good).GetLevelCount() == 2);
    const auto with = [&](auto change) {
        TileLayoutDesc desc = good;
        change(desc);
        return GetLayoutRefusal(desc);
    };
    using Desc = TileLayoutDesc;
    CHECK(with([](Desc& d) { d.width = 0; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.height = kMaxImageDimension + 1; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.tileWidth = 0; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.tileHeight = -64; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.mips = 0; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.mips = kMaxTiledMips + 1; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.levelCount = 10; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.levelCount = -2; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.tailTiles = -1; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.tailTiles = 0; }) == Status::InvalidArgument);  // mips 2 … 8 in no level
    CHECK(with([](Desc& d) { d.levelCount = 9; }) == Status::InvalidArgument); // tail without mips
    CHECK(with([](Desc& d) { d.regionWidth = -1; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { d.tailTiles = kMaxTileCount; }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { // 2^40 tiles
              d.width = d.height = kMaxImageDimension;
              d.tileWidth = d.tileHeight = 1;
          }) == Status::OutOfRange);
    CHECK(with([](Desc& d) { // 2^32 regions
              d.width = d.height = 65536;
              d.levelCount = 0;
              d.regionWidth = d.regionHeight = 1;
          }) == Status::OutOfRange);
    const auto withLevels = [&](std::vector<TileLevelDesc> levels) {
        return with([&](Desc& d) { d.levels = levels; });
    };
    CHECK(withLevels({{256, 256, 1, 1}}) == Status::InvalidArgument);                   // mip 0 is missing
    CHECK(withLevels({{256, 256, 0, 0}, {128, 128, 2, 2}}) == Status::InvalidArgument); // mip 1 is missing
    CHECK(withLevels({{256, 256, 0, 1}, {128, 128, 1, 2}}) == Status::InvalidArgument); // mip 1 twice
    CHECK(withLevels({{256, 256, 0, 9}}) == Status::InvalidArgument);                   // there is no mip 9
    CHECK(withLevels({{128, 128, 0, 0}, {256, 64, 1, 1}}) == Status::OutOfRange);       // grows
    CHECK(withLevels({{0, 256, 0, 0}}) == Status::OutOfRange);
    CHECK(withLevels(std::vector<TileLevelDesc>(kMaxTileLevels + 1, {1, 1, 0, 0})) == Status::OutOfRange);
}
