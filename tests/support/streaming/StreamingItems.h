// SPDX-License-Identifier: MIT
// A scene with every kind of texture, and samples of it: random ones, and those at edges and corners of
// tiles, at both ends of wrapped axes, of gradients that are no numbers.
#pragma once

#include "support/streaming/StreamingModel.h"

#include <limits>
#include <random>

namespace openntc_tests {

inline void AddAllTextures(StreamingScene& scene) {
    using openntc::TileFilter;
    using openntc::TileFormat;
    using openntc::TileWrap;
    scene.AddImage(256, 256, 32, 32, TileFormat::RGBA8, TileFilter::Bilinear, TileWrap::Clamp,
                   TileWrap::Clamp);
    scene.AddImage(257, 33, 32, 16, TileFormat::RGBA16F, TileFilter::Trilinear, TileWrap::Repeat,
                   TileWrap::Mirror);
    scene.AddImage(100, 37, 17, 9, TileFormat::R8, TileFilter::Point, TileWrap::Repeat, TileWrap::Clamp);
    scene.AddImage(1, 1, 32, 32, TileFormat::RGBA8Srgb, TileFilter::Trilinear, TileWrap::Repeat,
                   TileWrap::Repeat);
    scene.AddImage(1, 600, 64, 64, TileFormat::RG8, TileFilter::Bilinear, TileWrap::Mirror, TileWrap::Mirror);
    // The tail, 63 x 31 texels of 16 bytes and what is coarser, in three slots.
    scene.AddImage(63, 31, 64, 32, TileFormat::RGBA32F, TileFilter::Trilinear, TileWrap::Clamp,
                   TileWrap::Repeat, 1, 3);
    scene.AddImage(512, 128, 32, 32, TileFormat::RGBA8Srgb, TileFilter::Trilinear, TileWrap::Repeat,
                   TileWrap::Repeat, 8);
    scene.AddImage(129, 255, 16, 64, TileFormat::R16F, TileFilter::Bilinear, TileWrap::Mirror,
                   TileWrap::Repeat, 16);
    scene.AddImage(130, 70, 33, 21, TileFormat::RG32F, TileFilter::Trilinear, TileWrap::Mirror,
                   TileWrap::Clamp);
    scene.AddImage(77, 300, 40, 40, TileFormat::RG16F, TileFilter::Point, TileWrap::Mirror, TileWrap::Repeat);
    scene.AddImage(64, 200, 16, 16, TileFormat::R32F, TileFilter::Bilinear, TileWrap::Repeat,
                   TileWrap::Repeat);
    scene.AddSet(187, 130, 8, TileFilter::Trilinear, TileWrap::Repeat);
}

/// Random finest mips, 0 to 4, for three entries of every word of the residency map; nothing for the fourth.
inline void FillResidency(StreamingScene& scene, std::mt19937& random) {
    for (std::uint32_t& word : scene.residency)
        word = static_cast<std::uint32_t>(random() % 5 | (random() % 5) << 8 | (random() % 5) << 16 |
                                          255u << 24);
}

/// Maps a share of the tiles, and the tails of most textures.
inline void MapSome(StreamingScene& scene, std::mt19937& random, double share) {
    for (const SceneTexture& texture : scene.textures) {
        if (random() % 8 != 0)
            scene.MapTail(texture);
        for (std::uint32_t tile = 0; tile < texture.header.firstTailTile; ++tile) {
            if (static_cast<double>(random() % 1000) < share * 1000)
                scene.MapTile(texture, tile);
        }
    }
}

inline std::vector<openntc::StreamingItem> MakeSamples(const StreamingScene& scene, std::mt19937& random,
                                                       std::uint32_t kind, std::size_t count) {
    std::vector<openntc::StreamingItem> items;
    const auto unit = [&] { return static_cast<float>(random() % 16777216u) / 16777216.0f; };
    const float strange[] = {std::numeric_limits<float>::quiet_NaN(),
                             std::numeric_limits<float>::infinity(),
                             -std::numeric_limits<float>::infinity(),
                             0.0f,
                             1e30f,
                             -3e38f,
                             1e-30f,
                             -0.0f};
    for (std::size_t i = 0; i < count; ++i) {
        openntc::StreamingItem item{};
        item.kind = kind;
        item.textureId = static_cast<std::uint32_t>(random() % scene.textures.size());
        const SceneTexture& texture = scene.textures[item.textureId];
        const auto coordinate = [&](int size) {
            switch (random() % 4) {
            case 0: // an edge or centre of a texel, exact where the size is a power of two
                return static_cast<float>(random() % static_cast<unsigned>(4 * size + 1)) /
                           static_cast<float>(2 * size) -
                       0.5f;
            case 1: // the ends of the axis
                return static_cast<float>(static_cast<int>(random() % 5) - 2) * 0.5f;
            default:
                return unit() * 4 - 1.5f;
            }
        };
        item.u = coordinate(texture.desc.width);
        item.v = coordinate(texture.desc.height);
        const float level = std::exp2(unit() * 11 - 1.5f);
        const float angle = unit() * 6.2831853f, skew = unit();
        item.dudx = level * std::cos(angle) / static_cast<float>(texture.desc.width);
        item.dvdx = level * std::sin(angle) / static_cast<float>(texture.desc.height);
        item.dudy = -level * skew * std::sin(angle) / static_cast<float>(texture.desc.width);
        item.dvdy = level * skew * std::cos(angle) / static_cast<float>(texture.desc.height);
        if (random() % 5 == 0) { // exactly a level
            item.dudx = std::exp2(static_cast<float>(random() % 6)) / static_cast<float>(texture.desc.width);
            item.dvdx = item.dudy = item.dvdy = 0;
        }
        if (random() % 16 == 0)
            item.dudx = strange[random() % std::size(strange)];
        if (random() % 16 == 0)
            item.dvdy = strange[random() % std::size(strange)];
        item.seed = static_cast<std::uint32_t>(i);
        items.push_back(item);
    }
    return items;
}

} // namespace openntc_tests
