// SPDX-License-Identifier: MIT
// What streaming functions must do, by another way: binary64 and 64-bit integers, sets of tiles and regions,
// nothing shared with the shaders. A sample that lies within the rounding of a decision (which texel, which
// mip, how many taps) is not sure, and is not compared.
#pragma once

#include "support/streaming/StreamingScene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace openntc_tests {

/// One filter tap of one mip: a place, and the share of the result.
struct ModelRead {
    int mip;
    double u, v, weight;
};

struct ModelReads {
    bool isSure = true;
    int taps = 1;
    double reachU = 0, reachV = 0; ///< half of the larger gradient, where sampling is anisotropic
    std::vector<ModelRead> reads;
};

struct ModelTexel {
    int x, y;
    double weight;
};

inline bool IsNearInteger(double x, double within) {
    const double distance = std::fabs(x - std::round(x));
    return distance > 0 && distance < within;
}

/// Which mips are read where, from gradients.
inline ModelReads GetModelReads(const SceneTexture& texture, const openntc::StreamingItem& item) {
    ModelReads result;
    const double width = texture.desc.width, height = texture.desc.height;
    const double lastMip = texture.desc.mips - 1;
    const double gradients[] = {item.dudx, item.dvdx, item.dudy, item.dvdy};
    double lod = lastMip;
    double axisU = 0, axisV = 0;
    bool isFinite = true;
    for (const double g : gradients)
        isFinite = isFinite && std::isfinite(g);
    if (isFinite) {
        const double x = std::hypot(gradients[0] * width, gradients[1] * height);
        const double y = std::hypot(gradients[2] * width, gradients[3] * height);
        const double major = std::max(x, y), minor = std::min(x, y);
        lod = major > 0 ? std::log2(major) + static_cast<double>(texture.desc.mipBias) : -100;
        if (texture.desc.maxAnisotropy > 1 && major > 0) {
            const double ratio = minor > 0 ? major / minor : 1e9;
            result.taps = static_cast<int>(std::min<double>(std::ceil(ratio), texture.desc.maxAnisotropy));
            if (ratio < texture.desc.maxAnisotropy + 1 && ratio > 1 && IsNearInteger(ratio, 1e-4))
                result.isSure = false;
            if (ratio > 1 && ratio == std::round(ratio) && ratio <= texture.desc.maxAnisotropy)
                result.isSure = false;
            lod -= std::log2(result.taps);
            axisU = x >= y ? gradients[0] : gradients[2];
            axisV = x >= y ? gradients[1] : gradients[3];
            if (std::fabs(x - y) < 1e-4 * major && x != y)
                result.isSure = false;
            result.reachU = std::max(std::fabs(gradients[0]), std::fabs(gradients[2])) / 2;
            result.reachV = std::max(std::fabs(gradients[1]), std::fabs(gradients[3])) / 2;
        }
    }
    lod = std::min(std::max(lod, 0.0), lastMip);
    std::vector<std::pair<int, double>> mips;
    if (texture.desc.filter == openntc::TileFilter::Trilinear) {
        if (IsNearInteger(lod, 1e-4))
            result.isSure = false;
        const int fine = static_cast<int>(std::floor(lod));
        const double between = lod - fine;
        mips.emplace_back(fine, 1 - between);
        if (between > 0)
            mips.emplace_back(fine + 1, between);
    } else {
        if (IsNearInteger(lod + 0.5, 1e-4))
            result.isSure = false;
        mips.emplace_back(std::min(static_cast<int>(std::floor(lod + 0.5)), texture.desc.mips - 1), 1.0);
    }
    for (const auto& [mip, weight] : mips) {
        for (int i = 0; i < result.taps; ++i) {
            const double place = (2.0 * i + 1 - result.taps) / (2.0 * result.taps);
            result.reads.push_back({mip, static_cast<double>(item.u) + axisU * place,
                                    static_cast<double>(item.v) + axisV * place, weight / result.taps});
        }
    }
    return result;
}

inline int WrapIndex(std::int64_t index, int size, openntc::TileWrap wrap) {
    switch (wrap) {
    case openntc::TileWrap::Clamp:
        return static_cast<int>(std::min<std::int64_t>(std::max<std::int64_t>(index, 0), size - 1));
    case openntc::TileWrap::Repeat:
        return static_cast<int>((index % size + size) % size);
    case openntc::TileWrap::Mirror:
        break;
    }
    const std::int64_t period = std::int64_t{2} * size;
    const std::int64_t place = (index % period + period) % period;
    return static_cast<int>(place < size ? place : period - 1 - place);
}

/// Texels of an axis that a tap reads with their weights; texels that fold onto one are added.
inline std::map<int, double> GetAxisTexels(double u, int size, openntc::TileWrap wrap, bool isPoint,
                                           double slack, bool& isSure) {
    const double scaled = u * size;
    // The coordinate is cut off to 2^-16 (1 + size / 256) of a texel.
    const double error = (1 + size / 256.0) / 65536 + slack * size;
    std::map<int, double> texels;
    const double at = isPoint ? scaled : scaled - 0.5;
    if (IsNearInteger(at, 2 * error) || (slack > 0 && std::fabs(at - std::round(at)) < 2 * error))
        isSure = false;
    const double whole = std::floor(at);
    // Beyond 2^52 there are only integers: not sure, whatever the index is.
    const auto index = static_cast<std::int64_t>(std::min(std::max(whole, -0x1p52), 0x1p52));
    if (isPoint) {
        texels[WrapIndex(index, size, wrap)] += 1;
        return texels;
    }
    const double fraction = at - whole;
    texels[WrapIndex(index, size, wrap)] += 1 - fraction;
    if (fraction > 0)
        texels[WrapIndex(index + 1, size, wrap)] += fraction;
    return texels;
}

inline std::vector<ModelTexel> GetModelTexels(const SceneTexture& texture, const ModelRead& read, int mip,
                                              bool hasTaps, bool& isSure) {
    const bool isPoint = texture.desc.filter == openntc::TileFilter::Point;
    const double slack = hasTaps ? 1e-6 : 0; // places of anisotropic taps are rounded
    std::vector<ModelTexel> texels;
    for (const auto& [y, weightY] :
         GetAxisTexels(read.v, texture.GetHeight(mip), texture.desc.wrapV, isPoint, slack, isSure)) {
        for (const auto& [x, weightX] :
             GetAxisTexels(read.u, texture.GetWidth(mip), texture.desc.wrapU, isPoint, slack, isSure))
            texels.push_back({x, y, weightX * weightY});
    }
    return texels;
}

/// Number of the tile that holds a texel's centre; the first of the tail for its mips.
inline std::uint32_t GetModelTile(const SceneTexture& texture, int mip, int x, int y) {
    std::uint32_t first = 0;
    for (std::size_t level = 0; level < texture.levels.size(); ++level) {
        const int last = texture.levels[level].lastMip;
        const std::int64_t width = texture.GetWidth(last), height = texture.GetHeight(last);
        const std::int64_t across = (width + texture.desc.tileWidth - 1) / texture.desc.tileWidth;
        const std::int64_t down = (height + texture.desc.tileHeight - 1) / texture.desc.tileHeight;
        if (mip >= texture.levels[level].firstMip && mip <= last) {
            const std::int64_t column = (2 * std::int64_t{x} + 1) * width /
                                        (2 * std::int64_t{texture.GetWidth(mip)} * texture.desc.tileWidth);
            const std::int64_t row = (2 * std::int64_t{y} + 1) * height /
                                     (2 * std::int64_t{texture.GetHeight(mip)} * texture.desc.tileHeight);
            return first + static_cast<std::uint32_t>(row * across + column);
        }
        first += static_cast<std::uint32_t>(across * down);
    }
    return first;
}

/// Tiles that must be there for a texel.
inline std::vector<std::uint32_t> GetTilesOfTexel(const SceneTexture& texture, int mip, int x, int y) {
    if (mip < texture.GetFirstTailMip())
        return {GetModelTile(texture, mip, x, y)};
    std::vector<std::uint32_t> tiles;
    for (int i = 0; i < texture.desc.tailTiles; ++i)
        tiles.push_back(GetModelTile(texture, mip, x, y) + static_cast<std::uint32_t>(i));
    return tiles;
}

inline int GetNextModelMip(const SceneTexture& texture, int mip) {
    const auto level = static_cast<std::size_t>(texture.GetLevelOf(mip));
    return level < texture.levels.size() ? texture.levels[level].lastMip + 1 : texture.desc.mips;
}

using TileSet = std::set<std::pair<std::uint32_t, std::uint32_t>>; ///< texture, tile

struct ModelResult {
    bool isSure = true;
    bool resident = false;
    int sampledMip = -1;
    std::array<double, 4> color{};
    double tolerance = 0;
    TileSet missing;               ///< what is requested
    std::set<std::uint32_t> slots; ///< what is stamped
};

inline std::array<double, 4> GetModelColor(const StreamingScene& scene, const SceneTexture& texture, int mip,
                                           int x, int y) {
    if (!texture.IsSet())
        return GetTexelValue(texture, mip, x, y);
    std::array<double, 4> color{};
    for (int c = 0; c < 4; ++c)
        color[static_cast<std::size_t>(c)] =
            static_cast<double>(scene.setTexels[static_cast<std::size_t>(mip)][static_cast<std::size_t>(
                (y * texture.GetWidth(mip) + x) * 16 + texture.desc.firstChannel + c)]);
    return color;
}

/// True if all tiles are mapped; `missing` gets the others, `slots` those that are.
inline bool UseTiles(const StreamingScene& scene, const SceneTexture& texture,
                     const std::vector<std::uint32_t>& tiles, bool requests, ModelResult& result) {
    bool complete = !tiles.empty();
    for (const std::uint32_t tile : tiles) {
        const std::uint32_t slot = *scene.GetTable().GetSlot(texture.id, tile);
        if (slot != NTC_TILE_MISSING) {
            result.slots.insert(slot);
            continue;
        }
        complete = false;
        if (requests)
            result.missing.insert({texture.id, tile});
    }
    return complete;
}

inline ModelResult DemandByModel(const StreamingScene& scene, const openntc::StreamingItem& item) {
    ModelResult result;
    if (item.textureId >= scene.textures.size())
        return result;
    const SceneTexture& texture = scene.textures[item.textureId];
    const ModelReads reads = GetModelReads(texture, item);
    result.isSure = reads.isSure;
    result.resident = true;
    int lowest = 0;
    bool isEmpty = false;
    double largest = 1;
    for (const ModelRead& read : reads.reads) {
        int used = -1;
        for (int mip = read.mip; mip < texture.desc.mips && used < 0; mip = GetNextModelMip(texture, mip)) {
            const auto texels = GetModelTexels(texture, read, mip, reads.taps > 1, result.isSure);
            bool complete = true;
            for (const ModelTexel& texel : texels)
                complete = UseTiles(scene, texture, GetTilesOfTexel(texture, mip, texel.x, texel.y),
                                    mip == read.mip, result) &&
                           complete;
            if (!complete)
                continue;
            used = mip;
            for (const ModelTexel& texel : texels) {
                const auto color = GetModelColor(scene, texture, mip, texel.x, texel.y);
                for (std::size_t c = 0; c < 4; ++c) {
                    result.color[c] += color[c] * texel.weight * read.weight;
                    largest = std::max(largest, std::fabs(color[c]));
                }
            }
        }
        result.resident = result.resident && used == read.mip;
        isEmpty = isEmpty || used < 0;
        lowest = std::max(lowest, used);
    }
    result.sampledMip = isEmpty ? -1 : lowest;
    // Fractions along both axes are cut off, by 2^-16 (1 + size / 256) each, which moves a blend by twice
    // that of the largest number an axis; the level of detail is off by 2^-17 at most; the rest are roundings
    // of at most 16 taps of 8 products. Anisotropic taps may lie 2^-24 of the texture away, twice as much
    // where coordinates are larger than 1.
    const double size = std::max(texture.desc.width, texture.desc.height);
    result.tolerance = largest * (4 * (1 + size / 256) / 65536 + 2.0 / 131072 + 1e-5 +
                                  (reads.taps > 1 ? 4 * size / 8388608 : 0));
    return result;
}

/// NtcSampleTextureSetTiled.
inline ModelResult SampleSetByModel(const StreamingScene& scene, const SceneTexture& texture, int x, int y,
                                    int mip) {
    ModelResult result;
    if (mip < 0 || mip >= texture.desc.mips)
        return result;
    x = std::min(std::max(x, 0), texture.GetWidth(mip) - 1);
    y = std::min(std::max(y, 0), texture.GetHeight(mip) - 1);
    for (int to = mip; to < texture.desc.mips; to = GetNextModelMip(texture, to)) {
        const auto move = [](std::int64_t from, std::int64_t fromSize, std::int64_t toSize) {
            return static_cast<int>((2 * from + 1) * toSize / (2 * fromSize));
        };
        const int toX = move(x, texture.GetWidth(mip), texture.GetWidth(to));
        const int toY = move(y, texture.GetHeight(mip), texture.GetHeight(to));
        if (!UseTiles(scene, texture, GetTilesOfTexel(texture, to, toX, toY), to == mip, result))
            continue;
        result.resident = to == mip;
        result.sampledMip = to;
        result.color = {static_cast<double>(toX), static_cast<double>(toY), 0, 0}; // the place
        break;
    }
    return result;
}

/// True if texel x of an axis of `mipSize` overlaps region r of an axis of `size`, in exact arithmetic.
inline bool DoesRegionMeet(int region, int regionSize, int size, int texel, int mipSize) {
    const std::int64_t begin = std::int64_t{region} * regionSize * mipSize;
    const std::int64_t end = std::min<std::int64_t>(std::int64_t{region + 1} * regionSize, size) * mipSize;
    return std::int64_t{texel} * size < end && begin < (std::int64_t{texel} + 1) * size;
}

using FeedbackMap =
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>; ///< texture, region: bits

/// Regions that meet a texel get its mip's bit.
inline void RecordByModel(const SceneTexture& texture, int mip, int x, int y, FeedbackMap& map) {
    const int regionWidth = static_cast<int>(texture.header.regionWidth);
    const int regionHeight = static_cast<int>(texture.header.regionHeight);
    const int across = static_cast<int>(texture.header.regionsXY & 0xFFFFu);
    const int down = static_cast<int>(texture.header.regionsXY >> 16);
    for (int row = 0; row < down; ++row) {
        if (!DoesRegionMeet(row, regionHeight, texture.desc.height, y, texture.GetHeight(mip)))
            continue;
        for (int column = 0; column < across; ++column) {
            if (DoesRegionMeet(column, regionWidth, texture.desc.width, x, texture.GetWidth(mip)))
                map[{texture.id, static_cast<std::uint32_t>(row * across + column)}] |= 1u << mip;
        }
    }
}

/// Everything that the filter reads. False: not sure.
inline bool RecordByModel(const SceneTexture& texture, const openntc::StreamingItem& item, FeedbackMap& map) {
    const ModelReads reads = GetModelReads(texture, item);
    bool isSure = reads.isSure;
    FeedbackMap found;
    for (const ModelRead& read : reads.reads) {
        for (const ModelTexel& texel : GetModelTexels(texture, read, read.mip, reads.taps > 1, isSure))
            RecordByModel(texture, read.mip, texel.x, texel.y, found);
    }
    if (isSure) {
        for (const auto& [key, bits] : found)
            map[key] |= bits;
    }
    return isSure;
}

/// The recorded words, as the model has them.
inline FeedbackMap ReadFeedback(const StreamingScene& scene, const std::vector<std::uint32_t>& words) {
    FeedbackMap map;
    for (const SceneTexture& texture : scene.textures) {
        for (std::uint32_t region = 0; region < GetRegionCount(texture.header); ++region) {
            if (const std::uint32_t bits = words[texture.header.firstRegion + region]; bits != 0)
                map[{texture.id, region}] = bits;
        }
    }
    return map;
}

} // namespace openntc_tests
