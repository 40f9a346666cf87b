// SPDX-License-Identifier: MIT
// Stability: internal
// A layout with the tables that make its relations cheap, shared by all textures that have it.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/streaming/TileLayout.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// Relations along one axis. 16 bits hold a column: kMaxTilesPerSide.
struct AxisTables {
    explicit AxisTables(Allocator& allocator) noexcept
        : ofRegion(allocator), ofFinest(allocator), finest(allocator) {}

    /// Nested axes: column of level l that holds region r: [l · regions + r].
    Array<std::uint16_t> ofRegion;
    /// First and last column of level l that overlap column c of level 0: [(l · columns of level 0 + c) · 2].
    Array<std::uint16_t> ofFinest;
    /// First and last column of level 0 that overlap column c of level l: [(start of l + c) · 2].
    Array<std::uint16_t> finest;
    std::array<std::uint32_t, kMaxTileLevels> starts = {};
    std::uint32_t regions = 0;
    std::uint32_t finestColumns = 0;
    /// Each region lies in one column of each level, and each column in one of each coarser level.
    bool isNested = true;

    TileSpan GetOfFinest(int level, int column) const noexcept {
        const std::size_t i =
            (static_cast<std::size_t>(level) * finestColumns + static_cast<std::size_t>(column)) * 2;
        return {ofFinest[i], ofFinest[i + 1]};
    }
    TileSpan GetFinest(int level, int column) const noexcept {
        const std::size_t i =
            (std::size_t{starts[static_cast<std::size_t>(level)]} + static_cast<std::size_t>(column)) * 2;
        return {finest[i], finest[i + 1]};
    }
};

struct TileShape {
    TileShape(const TileLayout& from, Allocator& allocator) noexcept
        : layout(from), x(allocator), y(allocator) {}

    TileLayout layout;
    std::uint64_t hash = 0;
    std::uint32_t users = 0;
    bool isNested = true;
    int levels = 0;
    /// What the residency map says where level l … levels is the finest complete one.
    std::array<std::uint8_t, kMaxTileLevels + 1> values = {};
    std::array<std::uint8_t, 256> levelOfMip = {}; ///< `levels` for the tail and everything coarser
    AxisTables x;
    AxisTables y;

    int GetPinnedTileCount() const noexcept {
        if (layout.GetTailTileCount() > 0)
            return layout.GetTailTileCount();
        return layout.GetTileCount() - GetFirstPinnedTile();
    }
    /// Tiles from here on are always wanted: the tail, or without one the coarsest level.
    int GetFirstPinnedTile() const noexcept {
        return layout.GetTailTileCount() > 0
                   ? layout.GetRegularTileCount()
                   : static_cast<int>(layout.GetLevels()[static_cast<std::size_t>(levels) - 1].firstTile);
    }
    /// Nested shapes: the tile of a regular level that holds a region.
    std::uint32_t GetTileOfRegion(std::uint32_t region, int level) const noexcept {
        const std::uint32_t row = region / x.regions;
        const auto l = static_cast<std::size_t>(level);
        const TileLevel& of = layout.GetLevels()[l];
        return of.firstTile +
               std::uint32_t{y.ofRegion[l * y.regions + row]} * static_cast<std::uint32_t>(of.tilesX) +
               x.ofRegion[l * x.regions + (region - row * x.regions)];
    }
    /// The regular level of a tile; `levels` for the tail.
    int GetLevelOfTile(std::uint32_t tile) const noexcept {
        if (tile >= static_cast<std::uint32_t>(layout.GetRegularTileCount()))
            return levels;
        int level = levels - 1;
        while (layout.GetLevels()[static_cast<std::size_t>(level)].firstTile > tile)
            --level;
        return level;
    }
};

inline Expected<void> FillAxis(AxisTables& tables, const TileLayout& layout, bool isX) noexcept {
    const std::span<const TileLevel> levels = layout.GetLevels();
    const int regions = isX ? layout.GetRegionsX() : layout.GetRegionsY();
    const auto getTiles = [&](std::size_t level) {
        return isX ? levels[level].tilesX : levels[level].tilesY;
    };
    const auto getSpan = [isX](const TileRect& rect) {
        return isX ? TileSpan{rect.left, rect.right} : TileSpan{rect.top, rect.bottom};
    };
    const auto getRelated = [&](std::size_t level, int column, std::size_t other) {
        return getSpan(layout.GetRelatedTiles({static_cast<int>(level), isX ? column : 0, isX ? 0 : column},
                                              static_cast<int>(other)));
    };
    if (levels.empty())
        return {};
    tables.regions = static_cast<std::uint32_t>(regions);
    tables.finestColumns = static_cast<std::uint32_t>(getTiles(0));
    std::uint32_t columns = 0;
    for (std::size_t level = 0; level < levels.size(); ++level) {
        tables.starts[level] = columns;
        columns += static_cast<std::uint32_t>(getTiles(level));
    }
    OPENNTC_CHECK(tables.ofRegion.Resize(levels.size() * tables.regions));
    OPENNTC_CHECK(tables.ofFinest.Resize(levels.size() * tables.finestColumns * 2));
    OPENNTC_CHECK(tables.finest.Resize(std::size_t{columns} * 2));
    const auto store = [](Array<std::uint16_t>& table, std::size_t at, const TileSpan& span) {
        table[at] = static_cast<std::uint16_t>(span.first);
        table[at + 1] = static_cast<std::uint16_t>(span.last);
    };
    for (std::size_t level = 0; level < levels.size(); ++level) {
        for (int region = 0; region < regions; ++region) {
            const TileSpan span =
                getSpan(layout.GetTilesOfRegion(isX ? region : 0, isX ? 0 : region, static_cast<int>(level)));
            tables.ofRegion[level * tables.regions + static_cast<std::size_t>(region)] =
                static_cast<std::uint16_t>(span.first);
            tables.isNested = tables.isNested && span.first == span.last;
        }
        for (int column = 0; column < getTiles(0); ++column)
            store(tables.ofFinest, (level * tables.finestColumns + static_cast<std::size_t>(column)) * 2,
                  getRelated(0, column, level));
        for (int column = 0; column < getTiles(level); ++column) {
            store(tables.finest, (tables.starts[level] + static_cast<std::size_t>(column)) * 2,
                  getRelated(level, column, 0));
            if (level + 1 < levels.size()) {
                const TileSpan coarser = getRelated(level, column, level + 1);
                tables.isNested = tables.isNested && coarser.first == coarser.last;
            }
        }
    }
    return {};
}

/// The shapes in use, found by hash.
class TileShapes {
public:
    explicit TileShapes(Allocator& allocator) noexcept : table_(allocator) {}
    TileShapes(TileShapes&& other) noexcept
        : table_(std::move(other.table_)), count_(std::exchange(other.count_, 0)) {}
    TileShapes& operator=(TileShapes&& other) noexcept {
        std::swap(table_, other.table_);
        std::swap(count_, other.count_);
        return *this;
    }
    ~TileShapes() {
        for (TileShape* shape : table_)
            Destroy(shape);
    }

    /// The shape of a layout, with one user more. Errors: OutOfMemory.
    Expected<TileShape*> Acquire(const TileLayout& layout) noexcept {
        const std::uint64_t hash = Hash(layout);
        if (!table_.empty()) {
            for (std::size_t i = hash;; ++i) {
                TileShape* shape = At(i);
                if (shape == nullptr)
                    break;
                if (shape->hash == hash && shape->layout == layout) {
                    ++shape->users;
                    return shape;
                }
            }
        }
        if (table_.size() < 2 * (count_ + 1))
            OPENNTC_CHECK(GrowTable());
        void* block = table_.GetAllocator().Allocate(sizeof(TileShape));
        if (block == nullptr)
            return Fail(Status::OutOfMemory, "tile layout: %zu bytes: refused by the allocator",
                        sizeof(TileShape));
        auto* shape = ::new (block) TileShape(layout, table_.GetAllocator());
        if (Expected<void> filled = Fill(*shape); !filled) {
            Destroy(shape);
            return PassError(filled);
        }
        shape->hash = hash;
        shape->users = 1;
        Insert(shape);
        ++count_;
        return shape;
    }

    void Release(TileShape* shape) noexcept {
        if (--shape->users > 0)
            return;
        std::size_t hole = shape->hash;
        while (At(hole) != shape)
            ++hole;
        Destroy(shape);
        At(hole) = nullptr;
        --count_;
        for (std::size_t i = hole + 1; At(i) != nullptr; ++i) // those behind may belong into the hole
            Insert(std::exchange(At(i), nullptr));
    }

private:
    static std::uint64_t Hash(const TileLayout& layout) noexcept {
        std::uint64_t hash = 14695981039346656037u; // FNV-1a, by numbers instead of bytes
        const auto add = [&](int value) {
            hash = (hash ^ static_cast<std::uint64_t>(static_cast<std::uint32_t>(value))) * 1099511628211u;
        };
        for (const int value : {layout.GetWidth(), layout.GetHeight(), layout.GetTileWidth(),
                                layout.GetTileHeight(), layout.GetMips(), layout.GetTailTileCount(),
                                layout.GetLevelCount(), layout.GetRegionWidth(), layout.GetRegionHeight()})
            add(value);
        for (const TileLevel& level : layout.GetLevels()) {
            add(level.width);
            add(level.height);
            add(level.lastMip);
        }
        return hash ^ (hash >> 32);
    }

    static Expected<void> Fill(TileShape& shape) noexcept {
        const TileLayout& layout = shape.layout;
        shape.levels = layout.GetLevelCount();
        for (int level = 0; level < shape.levels; ++level)
            shape.values[static_cast<std::size_t>(level)] =
                static_cast<std::uint8_t>(layout.GetFirstMipOfLevel(level));
        shape.values[static_cast<std::size_t>(shape.levels)] = static_cast<std::uint8_t>(
            layout.GetTailTileCount() > 0 ? layout.GetTailFirstMip() : kNoTilesFeedback);
        for (std::size_t mip = 0; mip < shape.levelOfMip.size(); ++mip)
            shape.levelOfMip[mip] = static_cast<std::uint8_t>(layout.GetLevelOfMip(static_cast<int>(mip)));
        OPENNTC_CHECK(FillAxis(shape.x, layout, true));
        OPENNTC_CHECK(FillAxis(shape.y, layout, false));
        shape.isNested = shape.x.isNested && shape.y.isNested;
        return {};
    }

    Expected<void> GrowTable() noexcept {
        Array<TileShape*> larger(table_.GetAllocator());
        OPENNTC_CHECK(larger.Resize(std::max<std::size_t>(16, 2 * table_.size())));
        std::swap(table_, larger);
        for (TileShape* shape : larger) {
            if (shape != nullptr)
                Insert(shape);
        }
        return {};
    }

    void Insert(TileShape* shape) noexcept {
        std::size_t i = shape->hash;
        while (At(i) != nullptr)
            ++i;
        At(i) = shape;
    }

    void Destroy(TileShape* shape) noexcept {
        if (shape == nullptr)
            return;
        shape->~TileShape();
        table_.GetAllocator().Deallocate(shape, sizeof(TileShape));
    }

    TileShape*& At(std::size_t number) noexcept { return table_[number & (table_.size() - 1)]; }

    Array<TileShape*> table_; // open addressing, a power of two, at most half full
    std::size_t count_ = 0;
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
