// SPDX-License-Identifier: MIT
// Stability: internal
// Textures and resources of a demand loader: how they come, change and go, and what the page table says.
#pragma once

#include "openntc/streaming/detail/DemandCore.h"

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline Expected<Shared<TileSet>> DemandCore::MakeSet(Shared<TileSource> source, bool hasRows) {
    const TileLayout& layout = source->GetLayout();
    OPENNTC_ASSIGN(Shared<TileSet> set, MakeShared<TileSet>(allocator, allocator));
    set->tileCount = static_cast<std::uint32_t>(layout.GetTileCount());
    const bool hasTail = layout.GetTailTileCount() > 0;
    const TileLevel* coarsest = hasTail ? nullptr : &layout.GetLevels().back();
    set->baseFirst = hasTail ? static_cast<std::uint32_t>(layout.GetRegularTileCount()) : coarsest->firstTile;
    set->baseCount = set->tileCount - set->baseFirst;
    set->baseMissing = set->baseCount;
    set->hasRows = hasRows;
    const std::size_t largest = source->GetLargestTileBytes();
    if (largest > options.slotBytes)
        return Fail(Status::OutOfRange, "source: tiles of %zu bytes: slots have %u", largest,
                    options.slotBytes);
    for (std::uint32_t i = 0; i < set->baseCount; ++i)
        set->baseBytes += source->GetTileBytes(set->baseFirst + i);
    if (set->baseCount > GetSlotLimit() - std::min<std::uint64_t>(baseTiles, GetSlotLimit()))
        return Fail(Status::OutOfRange,
                    "budget: %u tiles: %llu are tails that stay, and this texture has %u more",
                    GetSlotLimit(), static_cast<unsigned long long>(baseTiles), set->baseCount);
    if (set->baseBytes > options.budgetBytes - std::min(baseBytes, options.budgetBytes))
        return Fail(Status::OutOfRange,
                    "budget: %llu bytes: %llu are tails that stay, and this texture has %llu more",
                    static_cast<unsigned long long>(options.budgetBytes),
                    static_cast<unsigned long long>(baseBytes),
                    static_cast<unsigned long long>(set->baseBytes));
    OPENNTC_CHECK(set->tiles.SetSize(set->tileCount));
    for (std::uint32_t i = 0; i < set->baseCount; ++i)
        OPENNTC_CHECK(set->tiles.Touch(set->baseFirst + i));
    set->source = std::move(source);
    OPENNTC_CHECK(pendingBases.PushBack(set));
    set->isPending = true;
    baseTiles += set->baseCount;
    baseBytes += set->baseBytes;
    return set;
}

/// The texture's shape is the source's, and where its tiles lie is the loader's.
inline void DemandCore::FillGeometry(const TileLayout& layout, TiledTextureDesc& desc,
                                     std::array<TiledLevel, NTC_MAX_LEVELS>& levels) const noexcept {
    desc.width = layout.GetWidth();
    desc.height = layout.GetHeight();
    desc.mips = layout.GetMips();
    desc.tileWidth = layout.GetTileWidth();
    desc.tileHeight = layout.GetTileHeight();
    desc.tailTiles = layout.GetTailTileCount();
    std::size_t count = 0;
    for (const TileLevel& level : layout.GetLevels()) {
        if (count < levels.size())
            levels[count++] = {level.firstMip, level.lastMip};
    }
    desc.levels = {levels.data(), count};
    desc.pool = options.pool;
    desc.firstSlot = options.firstSlot;
    desc.slotsOffset = options.slotsOffset;
    desc.slotBytes = options.slotBytes;
}

/// Textures of the same source share a set, if they may.
inline Expected<Shared<TileSet>> DemandCore::FindOrMakeSet(Shared<TileSource> source, bool hasRows) {
    if (!source)
        return Fail(Status::InvalidArgument, "source: is empty");
    if (source->GetLayout().GetLevelCount() > NTC_MAX_LEVELS)
        return Fail(Status::OutOfRange, "source: %d levels: at most %d", source->GetLayout().GetLevelCount(),
                    NTC_MAX_LEVELS);
    for (DemandTexture& texture : textures) {
        for (Shared<TileSet>* set : {&texture.set, &texture.next}) {
            if (options.coalesce && *set && !(*set)->isRemoved && (*set)->source &&
                IsSameSource(*(*set)->source, *source))
                return *set;
        }
    }
    return MakeSet(std::move(source), hasRows);
}

inline Expected<void> DemandCore::Register(std::uint32_t index, DemandTexture::Kind kind,
                                           Shared<TileSet> set) {
    if (index >= textures.size())
        OPENNTC_CHECK(textures.Resize(std::size_t{index} + 1));
    DemandTexture& texture = textures[index];
    OPENNTC_CHECK(set->textures.PushBack(index));
    texture.kind = kind;
    ++texture.generation;
    texture.firstRound = round + 1;
    ++set->holders;
    texture.set = std::move(set);
    return {};
}

inline Expected<DemandId> DemandCore::AddTexture(Shared<TileSource> source, const TiledTextureDesc& given) {
    OPENNTC_ASSIGN(Shared<TileSet> set,
                   FindOrMakeSet(std::move(source), given.format == TileFormat::TextureSet));
    TiledTextureDesc desc = given;
    std::array<TiledLevel, NTC_MAX_LEVELS> levels{};
    FillGeometry(set->source->GetLayout(), desc, levels);
    Expected<std::uint32_t> index = table.Add(desc);
    if (index) {
        if (Expected<void> registered = Register(*index, DemandTexture::Kind::Texture, set); !registered) {
            static_cast<void>(table.Remove(*index));
            index = PassError(registered);
        }
    }
    if (!index) {
        if (set->holders == 0)
            Drop(set);
        return PassError(index);
    }
    Show(*set, *index);
    QueueBases();
    return DemandId{*index, textures[*index].generation};
}

inline Expected<DemandId> DemandCore::AddResource(std::uint32_t pages, PageCallback callback) {
    if (callback.call == nullptr)
        return Fail(Status::InvalidArgument, "callback: is null");
    OPENNTC_ASSIGN(Shared<TileSet> set, MakeShared<TileSet>(allocator, allocator));
    set->callback = callback;
    set->tileCount = pages;
    OPENNTC_CHECK(set->tiles.SetSize(pages));
    OPENNTC_ASSIGN(const std::uint32_t index, table.AddPages(pages));
    if (Expected<void> registered = Register(index, DemandTexture::Kind::Resource, set); !registered) {
        static_cast<void>(table.Remove(index));
        return PassError(registered);
    }
    ClearAllBitsOf(index);
    return DemandId{index, textures[index].generation};
}

/// The new source's tail is read first; then LaunchPrepare puts it in the place of the old one.
inline Expected<void> DemandCore::ReplaceTexture(DemandId id, Shared<TileSource> source,
                                                 const TiledTextureDesc& desc) {
    OPENNTC_ASSIGN(DemandTexture * found, Find(id, DemandTexture::Kind::Texture));
    OPENNTC_ASSIGN(Shared<TileSet> set,
                   FindOrMakeSet(std::move(source), desc.format == TileFormat::TextureSet));
    ++set->holders;
    DemandTexture& texture = *found;
    TiledTextureDesc next = desc;
    std::array<TiledLevel, NTC_MAX_LEVELS> levels{};
    FillGeometry(set->source->GetLayout(), next, levels);
    Expected<void> valid;
    if (const auto header = MakeTiledTexture(next); !header)
        valid = PassError(header);
    else if (!texture.next)
        valid = replacing.PushBack(id.index);
    if (!valid) {
        Drop(set);
        return valid;
    }
    if (texture.next)
        Drop(texture.next);
    texture.next = std::move(set);
    texture.nextDesc = desc;
    QueueBases();
    return {};
}

inline Expected<DemandTexture*> DemandCore::Find(DemandId id, DemandTexture::Kind kind) {
    if (id.index >= textures.size() || textures[id.index].kind == DemandTexture::Kind::Unused ||
        textures[id.index].generation != id.generation)
        return Fail(Status::InvalidArgument, "id: %u, generation %u: does not exist (any more)", id.index,
                    id.generation);
    if (textures[id.index].kind != kind)
        return Fail(Status::InvalidArgument, "id: %u: is not a %s", id.index,
                    kind == DemandTexture::Kind::Texture ? "texture" : "resource");
    return &textures[id.index];
}

inline Expected<void> DemandCore::Remove(DemandId id, DemandTexture::Kind kind) {
    OPENNTC_ASSIGN(DemandTexture * texture, Find(id, kind));
    Hide(*texture->set, id.index);
    ClearAllBitsOf(id.index);
    OPENNTC_CHECK(table.Remove(id.index));
    texture->kind = DemandTexture::Kind::Unused;
    if (texture->next) {
        Drop(texture->next);
        std::swap(*std::find(replacing.begin(), replacing.end(), id.index), replacing.back());
        replacing.pop_back();
    }
    Drop(texture->set);
    return {};
}

inline Expected<void> DemandCore::InvalidatePage(DemandId id, std::uint32_t page) {
    OPENNTC_ASSIGN(DemandTexture * texture, Find(id, DemandTexture::Kind::Resource));
    TileSet& set = *texture->set;
    if (page >= set.tileCount)
        return Fail(Status::OutOfRange, "page: %u: must be 0 … %u", page, set.tileCount - 1);
    TileRecord* record = set.tiles.Find(page);
    if (record == nullptr)
        return {};
    if (record->state == TileState::Resident) {
        record->state = TileState::Free;
        UnmapAll(set, page);
        --set.residents;
    } else if (record->state == TileState::Reading || record->state == TileState::Filled) {
        record->isStale = true;
    }
    return {};
}

inline Expected<void> DemandCore::SetBudget(std::uint32_t tiles, std::uint64_t bytes) {
    if (tiles < baseTiles || bytes < baseBytes)
        return Fail(Status::OutOfRange, "budget: %u tiles, %llu bytes: tails that stay have %llu, %llu",
                    tiles, static_cast<unsigned long long>(bytes), static_cast<unsigned long long>(baseTiles),
                    static_cast<unsigned long long>(baseBytes));
    options.budgetTiles = tiles;
    options.budgetBytes = bytes;
    return {};
}

/// Entries that get another meaning: whatever launches asked for there is forgotten.
inline void DemandCore::ClearAllBitsOf(std::uint32_t texture) noexcept {
    const Expected<NtcTiledTexture> header = table.GetHeader(texture);
    if (!header)
        return;
    const std::uint32_t first = header->firstEntry / 32;
    const std::uint32_t last = (header->firstEntry + header->tileCount - 1) / 32;
    if (!clearRanges.PushBack({table.GetLaunchState().bitsWord + first, last - first + 1}))
        clearAll = true;
}

/// The table learns what is resident of a set already.
inline void DemandCore::Show(TileSet& set, std::uint32_t texture) {
    ClearAllBitsOf(texture);
    if (set.residents == 0)
        return;
    for (const TileRef& ref : residents) {
        const TileRecord& record = *ref.set->tiles.Find(ref.tile);
        if (ref.set.Get() == &set && record.state == TileState::Resident)
            static_cast<void>(Map(set, ref.tile, record.slot, texture));
    }
}

inline void DemandCore::Hide(TileSet& set, std::uint32_t texture) noexcept {
    std::uint32_t* found = std::find(set.textures.begin(), set.textures.end(), texture);
    if (found == set.textures.end())
        return;
    std::swap(*found, set.textures.back());
    set.textures.pop_back();
}

/// One holder fewer. Without any the set goes: its reads are cancelled, and its slots given back when no
/// launch can read them any more.
inline void DemandCore::Drop(Shared<TileSet>& held) noexcept {
    const Shared<TileSet> set = std::move(held);
    held = Shared<TileSet>();
    if (set->holders > 0 && --set->holders > 0)
        return;
    set->isRemoved = true;
    set->isCancelled = true;
    baseTiles -= set->baseCount;
    baseBytes -= set->baseBytes;
    CancelQueued(*set);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < filled.size(); ++i) {
        if (filled[i].ref.set.Get() != set.Get()) {
            if (kept != i)
                filled[kept] = std::move(filled[i]);
            ++kept;
            continue;
        }
        Settle(filled[i].ref, TileState::Free);
        ReturnBuffer(filled[i].buffer);
        ++statistics.discarded;
    }
    static_cast<void>(filled.Resize(kept)); // smaller: cannot fail
    kept = 0;
    for (std::size_t i = 0; i < failed.size(); ++i) {
        if (failed[i].ref.set.Get() == set.Get())
            continue;
        if (kept != i)
            failed[kept] = std::move(failed[i]);
        ++kept;
    }
    static_cast<void>(failed.Resize(kept)); // smaller: cannot fail
    for (std::uint32_t place = 0; place < residents.size(); ++place) {
        if (residents[place].set.Get() == set.Get() &&
            set->tiles.Find(residents[place].tile)->state == TileState::Resident)
            Stage(place);
    }
}

inline Expected<void> DemandCore::Map(const TileSet& set, std::uint32_t tile, std::uint32_t slot,
                                      std::uint32_t texture) {
    if (!set.hasRows)
        return table.Map(texture, tile, slot);
    std::array<NtcSliceConstants, NTC_MAX_MIPS> rows{};
    const std::uint32_t count = std::min(set.source->GetSliceRows(tile, rows), std::uint32_t{NTC_MAX_MIPS});
    const TileLayout& layout = set.source->GetLayout();
    if (tile < static_cast<std::uint32_t>(layout.GetRegularTileCount()))
        return table.MapSlice(texture, tile, slot, rows[0]);
    for (std::uint32_t i = 0; i < count; ++i)
        OPENNTC_CHECK(
            table.SetTailSlice(texture, layout.GetTailFirstMip() + static_cast<int>(i), slot, rows[i]));
    return table.Map(texture, tile, slot);
}

inline Expected<void> DemandCore::MapAll(const TileSet& set, std::uint32_t tile, std::uint32_t slot) {
    for (const std::uint32_t texture : set.textures) {
        if (set.IsResource())
            OPENNTC_CHECK(table.SetPage(texture, tile, slot));
        else
            OPENNTC_CHECK(Map(set, tile, slot, texture));
    }
    return {};
}

inline void DemandCore::UnmapAll(const TileSet& set, std::uint32_t tile) noexcept {
    for (const std::uint32_t texture : set.textures)
        static_cast<void>(table.Unmap(texture, tile));
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
