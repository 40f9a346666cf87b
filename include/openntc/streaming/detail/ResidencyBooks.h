// SPDX-License-Identifier: MIT
// Stability: internal
// Residency maps, kept up to date under the tiles that become visible or vanish.
#pragma once

#include "openntc/streaming/detail/TileBooks.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct ResidencyBooks : TileBooks {
    using TileBooks::TileBooks;

    /// A tile has become visible (its word says so already).
    void ShowTile(std::uint32_t index, std::uint32_t tile) noexcept {
        ManagedTexture& texture = textures[index];
        const TileLayout& layout = texture.shape->layout;
        if ((texture.tiles[tile].word & tile_word::kPinned) != 0)
            --texture.state->pinnedMissing;
        if (layout.GetTailTileCount() > 0 && texture.state->pinnedMissing > 0)
            return; // without the whole tail nothing can be read
        if (tile >= static_cast<std::uint32_t>(layout.GetRegularTileCount())) {
            Recompute(index, {0, 0, layout.GetResidencyWidth() - 1, layout.GetResidencyHeight() - 1});
            return;
        }
        const Place place = GetPlace(texture, tile);
        if (!texture.shape->isNested) {
            Recompute(index, place.entries);
            return;
        }
        // All entries below a tile with a complete chain above it say the level above; if not, they still do.
        if (GetFirst(texture, place) > texture.shape->values[static_cast<std::size_t>(place.level) + 1])
            return;
        Fill(texture, place);
        MarkDirty(index, place.entries);
    }

    /// A tile is not visible any more. Pinned ones never vanish.
    void HideTile(std::uint32_t index, std::uint32_t tile) noexcept {
        ManagedTexture& texture = textures[index];
        if (texture.shape->layout.GetTailTileCount() > 0 && texture.state->pinnedMissing > 0)
            return;
        const Place place = GetPlace(texture, tile);
        if (!texture.shape->isNested) {
            Recompute(index, place.entries);
            return;
        }
        const auto level = static_cast<std::size_t>(place.level);
        if (GetFirst(texture, place) > texture.shape->values[level])
            return;
        Set(texture, place.entries, texture.shape->values[level + 1]);
        MarkDirty(index, place.entries);
    }

    /// An entry from scratch, by the tables.
    static std::uint8_t Compute(const ManagedTexture& texture, int x, int y) noexcept {
        const TileShape& shape = *texture.shape;
        if (shape.layout.GetTailTileCount() > 0 && texture.state->pinnedMissing > 0)
            return kNoTilesFeedback;
        int level = shape.levels;
        while (level > 0 && IsComplete(texture, shape.x.GetOfFinest(level - 1, x),
                                       shape.y.GetOfFinest(level - 1, y), level - 1))
            --level;
        return shape.values[static_cast<std::size_t>(level)];
    }

    void MarkDirty(std::uint32_t index, const TileRect& entries) noexcept {
        ManagedTexture& texture = textures[index];
        if (texture.state->dirtyIndex == kNoIndex) {
            texture.state->dirtyIndex = static_cast<std::uint32_t>(dirtyTextures.size());
            (void)dirtyTextures.PushBack(index); // room was reserved when the texture was added
            texture.state->dirty = entries;
            return;
        }
        TileRect& dirty = texture.state->dirty;
        dirty = {std::min(dirty.left, entries.left), std::min(dirty.top, entries.top),
                 std::max(dirty.right, entries.right), std::max(dirty.bottom, entries.bottom)};
    }

    void ForgetDirty(std::uint32_t index) noexcept {
        const std::uint32_t place = std::exchange(textures[index].state->dirtyIndex, kNoIndex);
        if (place == kNoIndex)
            return;
        dirtyTextures[place] = dirtyTextures.back();
        textures[dirtyTextures[place]].state->dirtyIndex = dirtyTextures[place] == index ? kNoIndex : place;
        (void)dirtyTextures.Resize(dirtyTextures.size() - 1); // shrinks: cannot fail
    }

private:
    struct Place {
        int level = 0;
        int x = 0;
        int y = 0;
        TileRect entries; ///< of the residency map, that the tile covers
    };

    static Place GetPlace(const ManagedTexture& texture, std::uint32_t tile) noexcept {
        const TileShape& shape = *texture.shape;
        Place place;
        place.level = shape.GetLevelOfTile(tile);
        const TileLevel& level = shape.layout.GetLevels()[static_cast<std::size_t>(place.level)];
        const int number = static_cast<int>(tile - level.firstTile);
        place.y = number / level.tilesX;
        place.x = number - place.y * level.tilesX;
        SetEntries(shape, place);
        return place;
    }

    static void SetEntries(const TileShape& shape, Place& place) noexcept {
        const TileSpan x = shape.x.GetFinest(place.level, place.x);
        const TileSpan y = shape.y.GetFinest(place.level, place.y);
        place.entries = {x.first, y.first, x.last, y.last};
    }

    static std::uint8_t GetFirst(const ManagedTexture& texture, const Place& place) noexcept {
        return texture
            .residency[place.entries.top * texture.shape->layout.GetResidencyWidth() + place.entries.left];
    }

    static void Set(ManagedTexture& texture, const TileRect& entries, std::uint8_t value) noexcept {
        const int width = texture.shape->layout.GetResidencyWidth();
        for (int y = entries.top; y <= entries.bottom; ++y)
            std::memset(texture.residency + std::ptrdiff_t{y} * width + entries.left, value,
                        static_cast<std::size_t>(entries.right - entries.left + 1));
    }

    /// The entries below a visible tile whose chain is complete: its level, and under visible children
    /// theirs.
    static void Fill(ManagedTexture& texture, const Place& place) noexcept {
        const TileShape& shape = *texture.shape;
        Set(texture, place.entries, shape.values[static_cast<std::size_t>(place.level)]);
        if (place.level == 0)
            return;
        const TileLevel& finer = shape.layout.GetLevels()[static_cast<std::size_t>(place.level) - 1];
        const int left = shape.x.GetOfFinest(place.level - 1, place.entries.left).first;
        const int right = shape.x.GetOfFinest(place.level - 1, place.entries.right).first;
        const int top = shape.y.GetOfFinest(place.level - 1, place.entries.top).first;
        const int bottom = shape.y.GetOfFinest(place.level - 1, place.entries.bottom).first;
        for (int y = top; y <= bottom; ++y) {
            for (int x = left; x <= right; ++x) {
                const std::uint32_t tile = finer.firstTile + static_cast<std::uint32_t>(y * finer.tilesX + x);
                if (!IsVisible(texture.tiles[tile].word))
                    continue;
                Place child{place.level - 1, x, y, {}};
                SetEntries(shape, child);
                Fill(texture, child);
            }
        }
    }

    static bool IsComplete(const ManagedTexture& texture, const TileSpan& columns, const TileSpan& rows,
                           int level) noexcept {
        const TileLevel& of = texture.shape->layout.GetLevels()[static_cast<std::size_t>(level)];
        for (int y = rows.first; y <= rows.last; ++y) {
            for (int x = columns.first; x <= columns.last; ++x) {
                if (!IsVisible(
                        texture.tiles[of.firstTile + static_cast<std::uint32_t>(y * of.tilesX + x)].word))
                    return false;
            }
        }
        return true;
    }

    void Recompute(std::uint32_t index, const TileRect& entries) noexcept {
        ManagedTexture& texture = textures[index];
        const int width = texture.shape->layout.GetResidencyWidth();
        if (texture.shape->levels == 0) {
            texture.residency[0] = texture.shape->values[0];
        } else {
            for (int y = entries.top; y <= entries.bottom; ++y) {
                for (int x = entries.left; x <= entries.right; ++x)
                    texture.residency[std::ptrdiff_t{y} * width + x] = Compute(texture, x, y);
            }
        }
        MarkDirty(index, entries);
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
