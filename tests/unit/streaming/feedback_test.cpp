// SPDX-License-Identifier: MIT
// Feedback as C++: the conditions C1 to C8 of the feedback specification against the model. On a device the
// same words come out (shader_streaming), where C4 and C8 are tested too.
#include "support/streaming/StreamingItems.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

using namespace openntc;
using namespace openntc_tests;

namespace {

void ClearFeedback(StreamingScene& scene) {
    std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
}

FeedbackMap RecordOne(StreamingScene& scene, const StreamingItem& item) {
    ClearFeedback(scene);
    scene.Run(std::span(&item, 1), scene.GetTable().MakeConstants(1));
    return ReadFeedback(scene, scene.feedback);
}

/// True if a region, with the finest mip that it asks for, wants a tile: the tile is of the level that serves
/// the mip, or of a coarser one, and meets the region.
bool IsTileWanted(const SceneTexture& texture, const FeedbackMap& map, int level, int column, int row) {
    const int across = static_cast<int>(texture.header.regionsXY & 0xFFFFu);
    const int last = texture.levels[static_cast<std::size_t>(level)].lastMip;
    const auto meets = [](std::int64_t region, std::int64_t regionSize, std::int64_t size, std::int64_t tile,
                          std::int64_t tileSize, std::int64_t levelSize) {
        const std::int64_t begin = region * regionSize * levelSize;
        const std::int64_t end = std::min((region + 1) * regionSize, size) * levelSize;
        return tile * tileSize * size < end && begin < std::min((tile + 1) * tileSize, levelSize) * size;
    };
    for (const auto& [key, bits] : map) {
        if (key.first != texture.id)
            continue;
        int finest = 0;
        while ((bits >> finest & 1u) == 0)
            ++finest;
        if (finest >= texture.GetFirstTailMip() || texture.GetLevelOf(finest) > level)
            continue;
        const int regionX = static_cast<int>(key.second) % across,
                  regionY = static_cast<int>(key.second) / across;
        if (meets(regionX, texture.header.regionWidth, texture.desc.width, column, texture.desc.tileWidth,
                  texture.GetWidth(last)) &&
            meets(regionY, texture.header.regionHeight, texture.desc.height, row, texture.desc.tileHeight,
                  texture.GetHeight(last)))
            return true;
    }
    return false;
}

/// Every bit is of a region that a texel of its mip within `reach` of the sample meets.
void CheckTight(const SceneTexture& texture, const ModelReads& reads, const FeedbackMap& map,
                const StreamingItem& item) {
    for (const auto& [key, bits] : map) {
        REQUIRE(key.first == texture.id);
        for (int mip = 0; mip < 32; ++mip) {
            if ((bits >> mip & 1u) == 0)
                continue;
            const bool isRead = std::any_of(reads.reads.begin(), reads.reads.end(),
                                            [&](const ModelRead& read) { return read.mip == mip; });
            CHECK(isRead);
            const auto meets = [&](double place, double reach, int size, int mipSize, int region,
                                   int regionSize, TileWrap wrap) {
                // Texels within the reach, a texel more for roundings.
                const long first = static_cast<long>(std::floor((place - reach) * mipSize - 1.5)) - 1;
                const long last = static_cast<long>(std::floor((place + reach) * mipSize + 1.5)) + 1;
                if (last - first >= mipSize)
                    return true;
                for (long x = first; x <= last; ++x) {
                    if (DoesRegionMeet(region, regionSize, size, WrapIndex(x, mipSize, wrap), mipSize))
                        return true;
                }
                return false;
            };
            const int across = static_cast<int>(texture.header.regionsXY & 0xFFFFu);
            const int region = static_cast<int>(key.second);
            CHECK(meets(static_cast<double>(item.u), reads.reachU, texture.desc.width, texture.GetWidth(mip),
                        region % across, static_cast<int>(texture.header.regionWidth), texture.desc.wrapU));
            CHECK(meets(static_cast<double>(item.v), reads.reachV, texture.desc.height,
                        texture.GetHeight(mip), region / across,
                        static_cast<int>(texture.header.regionHeight), texture.desc.wrapV));
        }
    }
}

} // namespace

TEST_CASE("feedback C1, C2, C6: every tile that is read is wanted, and nothing else is recorded") {
    std::mt19937 random(21);
    StreamingScene scene;
    AddAllTextures(scene);
    std::size_t sure = 0, exact = 0, tiles = 0, misses = 0;
    for (const StreamingItem& item : MakeSamples(scene, random, CASE_RECORD, 6000)) {
        const SceneTexture& texture = scene.textures[item.textureId];
        const ModelReads reads = GetModelReads(texture, item);
        FeedbackMap expected;
        if (!RecordByModel(texture, item, expected))
            continue;
        ++sure;
        CAPTURE(item.textureId);
        CAPTURE(item.u);
        CAPTURE(item.v);
        const FeedbackMap map = RecordOne(scene, item);
        bool isSure = true;
        bool isTail = false;
        for (const ModelRead& read : reads.reads) {
            isTail = isTail || read.mip >= texture.GetFirstTailMip();
            for (const ModelTexel& texel : GetModelTexels(texture, read, read.mip, reads.taps > 1, isSure)) {
                if (read.mip >= texture.GetFirstTailMip())
                    continue;
                const int level = texture.GetLevelOf(read.mip);
                const int last = texture.levels[static_cast<std::size_t>(level)].lastMip;
                const int across =
                    (texture.GetWidth(last) + texture.desc.tileWidth - 1) / texture.desc.tileWidth;
                std::uint32_t first = 0;
                for (int finer = 0; finer < level; ++finer)
                    first = texture.header.levels[finer + 1].firstTile;
                const int tile = static_cast<int>(GetModelTile(texture, read.mip, texel.x, texel.y) - first);
                ++tiles;
                misses += IsTileWanted(texture, map, level, tile % across, tile / across) ? 0u : 1u;
            }
        }
        CheckTight(texture, reads, map, item);
        if (reads.taps == 1 && !isTail) { // then the footprint is exactly the texels
            ++exact;
            CHECK(map == expected);
        }
    }
    MESSAGE("sure: " << sure << " of 6000, exactly the model's: " << exact << ", tiles read: " << tiles
                     << ", not wanted: " << misses);
    CHECK(misses == 0);
    CHECK(sure > 4800);
    CHECK(exact > 1000);
    CHECK(tiles > 10000);
}

TEST_CASE("feedback C3: any order gives the same words, and so does recording twice") {
    std::mt19937 random(22);
    StreamingScene scene;
    AddAllTextures(scene);
    auto items = MakeSamples(scene, random, CASE_RECORD, 2000);
    scene.Run(items, scene.GetTable().MakeConstants(1));
    const std::vector<std::uint32_t> once = scene.feedback;
    scene.Run(items, scene.GetTable().MakeConstants(1));
    CHECK(scene.feedback == once);
    for (int i = 0; i < 5; ++i) {
        std::shuffle(items.begin(), items.end(), random);
        ClearFeedback(scene);
        scene.Run(items, scene.GetTable().MakeConstants(1));
        CHECK(scene.feedback == once);
    }
}

TEST_CASE("feedback C5: at rate p, n quads are seen within k frames with probability 1 - (1 - p)^(nk)") {
    StreamingScene scene;
    const SceneTexture& texture = scene.AddImage(256, 256, 32, 32, TileFormat::RGBA8, TileFilter::Point,
                                                 TileWrap::Clamp, TileWrap::Clamp);
    constexpr int kRegions = 64, kQuads = 16, kTrials = 60;
    constexpr double kRate = 1.0 / 64;
    // Every region is accessed by 16 quads of 4 pixels a frame; how many frames until it is seen?
    for (const int frames : {1, 4, 16}) {
        int seen = 0;
        for (int trial = 0; trial < kTrials; ++trial) {
            ClearFeedback(scene);
            for (int frame = 0; frame < frames; ++frame) {
                std::vector<StreamingItem> items;
                for (int region = 0; region < kRegions; ++region) {
                    for (int pixel = 0; pixel < 4 * kQuads; ++pixel) {
                        StreamingItem item{};
                        item.kind = CASE_RECORD;
                        item.textureId = texture.id;
                        item.u = (static_cast<float>(region % 8) + 0.5f) / 8;
                        item.v = (static_cast<float>(region / 8) + 0.5f) / 8;
                        const int x = region * 16 + pixel % 16, y = pixel / 16; // quads of 2 x 2
                        item.seed = shader::NtcGetQuadSeed(shader::int2(x, y));
                        items.push_back(item);
                    }
                }
                scene.Run(items, scene.GetTable().MakeConstants(
                                     static_cast<std::uint32_t>(trial * 100 + frame + 1), 1, kRate));
            }
            for (int region = 0; region < kRegions; ++region)
                seen += scene.feedback[texture.header.firstRegion + static_cast<std::uint32_t>(region)] != 0;
        }
        const double expected = 1 - std::pow(1 - kRate, kQuads * frames);
        const double count = kTrials * kRegions;
        const double sigma = std::sqrt(expected * (1 - expected) / count);
        MESSAGE(frames << " frames: " << seen / count << ", expected " << expected);
        // Fixed seeds: five standard deviations are generous, and four times too many pixels would be 20.
        CHECK(std::fabs(seen / count - expected) < 5 * sigma);
    }
}

TEST_CASE("feedback C8: a still camera at a low rate asks for what it asks for at rate 1, after as many "
          "frames as C5 "
          "says") {
    StreamingScene scene;
    AddAllTextures(scene);
    // A picture of 64 x 64 pixels, 16 x 16 of each of 12 textures and 4 that do not exist; the lower half minified.
    std::vector<StreamingItem> pixels;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            StreamingItem item{};
            item.kind = CASE_RECORD;
            item.textureId = static_cast<std::uint32_t>(x / 16 + y / 16 * 4);
            item.u = (static_cast<float>(x % 16) + 0.5f) / 16;
            item.v = (static_cast<float>(y % 16) + 0.5f) / 16;
            item.dudx = item.dvdy = y % 16 < 8 ? 1.0f / 64 : 1.0f / 9;
            item.seed = shader::NtcGetQuadSeed(shader::int2(x, y));
            pixels.push_back(item);
        }
    }
    scene.Run(pixels, scene.GetTable().MakeConstants(1));
    const FeedbackMap full = ReadFeedback(scene, scene.feedback);
    // How many quads ask for each (region, mip); the rarest decides.
    std::map<std::pair<std::pair<std::uint32_t, std::uint32_t>, int>, std::set<std::uint32_t>> quads;
    for (const StreamingItem& item : pixels) {
        for (const auto& [key, bits] : RecordOne(scene, item)) {
            for (int mip = 0; mip < 16; ++mip) {
                if ((bits >> mip & 1u) != 0)
                    quads[{key, mip}].insert(item.seed);
            }
        }
    }
    std::size_t rarest = pixels.size();
    for (const auto& entry : quads)
        rarest = std::min(rarest, entry.second.size());
    REQUIRE(quads.size() > 100);
    for (const double rate : {1.0 / 4, 1.0 / 16}) {
        CAPTURE(rate);
        // Each is missed by all of so many frames with probability (1 - p)^(n frames): of all together, less than 1e-6
        // are expected. Seeds are fixed, so what holds once holds always.
        const double frames = std::log(1e-6 / static_cast<double>(quads.size())) /
                              (static_cast<double>(rarest) * std::log(1 - rate));
        ClearFeedback(scene);
        std::vector<std::uint32_t> first;
        for (int frame = 0; frame < static_cast<int>(std::ceil(frames)); ++frame) {
            scene.Run(pixels, scene.GetTable().MakeConstants(static_cast<std::uint32_t>(frame + 1), 1, rate));
            if (frame == 0)
                first = scene.feedback;
        }
        MESSAGE("rate " << rate << ": the rarest of " << quads.size() << " is asked for by " << rarest
                        << " quads, " << std::ceil(frames) << " frames");
        CHECK(ReadFeedback(scene, scene.feedback) == full);
        const FeedbackMap some =
            ReadFeedback(scene, first); // one frame is not enough, and never asks for more
        CHECK(some != full);
        for (const auto& [key, bits] : some)
            CHECK((full.at(key) & bits) == bits);
    }
}

TEST_CASE("feedback C6: numbers that are none, levels that do not exist, textures without feedback") {
    StreamingScene scene;
    const SceneTexture& texture = scene.AddImage(257, 33, 32, 16, TileFormat::RGBA8, TileFilter::Bilinear,
                                                 TileWrap::Repeat, TileWrap::Repeat);
    StreamingItem item{};
    item.kind = CASE_RECORD;
    item.textureId = texture.id;
    item.u = item.v = 0.25f;
    const auto getBits = [&] {
        std::uint32_t bits = 0;
        for (const auto& entry : RecordOne(scene, item))
            bits |= entry.second;
        return bits;
    };
    CHECK(getBits() == 1u); // gradients of 0: mip 0
    for (const float strange :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity(), 3e38f}) {
        item.dudx = strange;
        CHECK(getBits() == 1u << (texture.desc.mips - 1)); // the coarsest
    }
    item.kind = CASE_RECORD_LOD;
    for (const float lod : {1e30f, 100.0f, std::numeric_limits<float>::quiet_NaN()}) {
        item.dudx = lod;
        CHECK(getBits() == 1u << (texture.desc.mips - 1));
    }
    item.dudx = -1e30f;
    CHECK(getBits() == 1u);
    item.u = std::numeric_limits<float>::quiet_NaN(); // counts as 0
    item.v = 1e30f;
    CHECK(getBits() == 1u);
    item.kind = CASE_RECORD_TEXEL;
    for (const int mip : {-1, texture.desc.mips, 100}) {
        item.c = mip;
        CHECK(getBits() == 0);
    }
    item.c = 0;
    item.a = -5;
    item.b = 1000;
    CHECK(getBits() == 1u);
    item.textureId = 31;
    CHECK(getBits() == 0);
    TiledTextureDesc silent = texture.desc;
    silent.hasFeedback = false;
    item.textureId = *scene.GetTable().Add(silent);
    CHECK(scene.GetTable().GetUsedRegions() ==
          GetRegionCount(texture.header) + 3 - (GetRegionCount(texture.header) + 3) % 4);
    item.kind = CASE_RECORD;
    scene.Run(std::span(&item, 1), scene.GetTable().MakeConstants(1));
    CHECK(std::count(scene.feedback.begin(), scene.feedback.end(), 0u) ==
          static_cast<std::ptrdiff_t>(scene.feedback.size()));
}

TEST_CASE("feedback: words of the map belong to their textures") {
    StreamingScene scene;
    AddAllTextures(scene);
    PageTable& table = scene.GetTable();
    std::set<std::uint32_t> owned;
    for (const SceneTexture& texture : scene.textures) {
        CHECK(texture.header.firstRegion % 4 == 0);
        for (std::uint32_t region = 0; region < GetRegionCount(texture.header); ++region) {
            const auto owner = table.FindRegion(texture.header.firstRegion + region);
            REQUIRE(owner);
            CHECK(owner->texture == texture.id);
            CHECK(owner->region == region);
            CHECK(owned.insert(texture.header.firstRegion + region).second);
        }
    }
    for (std::uint32_t word = 0; word < table.GetLimits().maxRegions; ++word)
        CHECK(table.FindRegion(word).has_value() == owned.contains(word));
    CHECK_FALSE(table.FindRegion(0xFFFFFFFFu));
    REQUIRE(table.Remove(scene.textures[1].id));
    CHECK_FALSE(table.FindRegion(scene.textures[1].header.firstRegion));
    CHECK(table.FindRegion(scene.textures[2].header.firstRegion));
}
