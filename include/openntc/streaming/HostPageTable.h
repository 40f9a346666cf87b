// SPDX-License-Identifier: MIT
// Stability: experimental
// The host's image of the page table that shaders read (StreamingConstants.h): textures come and go, tiles
// are mapped to slots, and what has changed is a list of byte ranges for the engine to upload. No memory is
// taken after Create. (PageTable.h is the shaders' side.)
//
//   auto table = PageTable::Create({.maxTextures = 1000, .maxTiles = 100000, .maxSlots = 4096});
//   auto id = table->Add(desc);                          // the header; every tile is missing
//   table->Map(*id, tile, slot);                         // an image's tile, or one of a tail
//   table->MapSlice(*id, tile, slot, slice);             // a texture set's tile
//   for (PageTable::ByteRange range; table->TakeChange(range);)
//       upload(table->GetBytes().subspan(range.offset, range.size), range.offset);
//   NtcStreamingConstants constants = table->MakeConstants(round);
//
// The launch state (request queue, request bits, stamps) is the device's: LaunchState says how large it is
// and where its parts are.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/streaming/LaunchState.h"
#include "openntc/streaming/TiledTexture.h"
#include "openntc/streaming/detail/ChangedBlocks.h"
#include "openntc/streaming/detail/RangePool.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Sizes of the shared buffers, fixed at creation.
struct PageTableLimits {
    std::uint32_t maxTextures = 0;
    std::uint32_t maxTiles = 0;    ///< of all textures together: 4 bytes each, and a bit of launch state
    std::uint32_t maxSlots = 0;    ///< of all pools together: 4 bytes of launch state each
    std::uint32_t maxSlices = 0;   ///< slice rows of slots, 32 bytes each: maxSlots if there are texture sets
    std::uint32_t maxTailRows = 0; ///< 32 bytes for every mip in the tail of a texture set
    std::uint32_t maxRegions = 0;  ///< words of feedback in a frame's map
    std::uint32_t queueCapacity = 0; ///< requests that one launch can make; 0: none
};

/// A region of a texture.
struct RegionOwner {
    std::uint32_t texture = 0;
    std::uint32_t region = 0; ///< row by row
};

class PageTable {
public:
    using ByteRange = detail::ChangedBlocks::ByteRange; ///< { offset, size }, multiples of 4

    /// Errors: OutOfRange if a buffer would have 2^32 words or more; OutOfMemory.
    static Expected<PageTable> Create(const PageTableLimits& limits,
                                      Allocator& allocator = GetDefaultAllocator()) noexcept {
        PageTable table(allocator);
        const std::uint64_t headers = std::uint64_t{limits.maxTextures} * kHeaderWords;
        const std::uint64_t rows = (std::uint64_t{limits.maxSlices} + limits.maxTailRows) * kRowWords;
        const std::uint64_t slicesWord = (headers + limits.maxTiles + 7) & ~std::uint64_t{7};
        const std::uint64_t words = slicesWord + rows;
        const std::uint64_t bits = (std::uint64_t{limits.maxTiles} + 31) / 32;
        const std::uint64_t state = 4 + 2 * std::uint64_t{limits.queueCapacity} + bits + limits.maxSlots;
        if (words > kMaxWords || state > kMaxWords)
            return Fail(Status::OutOfRange, "limits: %llu words of table, %llu of state: at most %llu",
                        static_cast<unsigned long long>(words), static_cast<unsigned long long>(state),
                        static_cast<unsigned long long>(kMaxWords));
        if (limits.maxSlices > limits.maxSlots)
            return Fail(Status::InvalidArgument, "maxSlices: %u: at most maxSlots, %u", limits.maxSlices,
                        limits.maxSlots);
        table.limits_ = limits;
        table.entriesWord_ = static_cast<std::uint32_t>(headers);
        table.slicesWord_ = static_cast<std::uint32_t>(slicesWord);
        table.state_.bitsWord = 4 + 2 * limits.queueCapacity;
        table.state_.stampsWord = table.state_.bitsWord + static_cast<std::uint32_t>(bits);
        table.state_.words = static_cast<std::uint32_t>(state);
        table.state_.queueCapacity = limits.queueCapacity;
        OPENNTC_CHECK(table.words_.Resize(static_cast<std::size_t>(words)));
        OPENNTC_CHECK(table.freeTextures_.Reserve(limits.maxTextures));
        OPENNTC_CHECK(table.changes_.Reset(static_cast<std::size_t>(words) * 4));
        OPENNTC_CHECK(table.tiles_.Reset(limits.maxTiles, limits.maxTextures));
        OPENNTC_CHECK(table.tailRows_.Reset(limits.maxTailRows, limits.maxTextures));
        OPENNTC_CHECK(table.regions_.Reset(limits.maxRegions, limits.maxTextures));
        OPENNTC_CHECK(table.regionOwners_.Resize(limits.maxRegions));
        for (std::uint32_t& owner : table.regionOwners_)
            owner = kNoOwner;
        for (std::uint32_t i = 0; i < limits.maxTiles; ++i)
            table.words_[table.entriesWord_ + i] = NTC_TILE_MISSING;
        table.changes_.MarkAll();
        return table;
    }

    /// A texture, all tiles missing. Returns its identifier, which one that has been removed may have had.
    /// Errors: those of MakeTiledTexture; OutOfMemory where a limit of the table is reached, which is then as
    /// before; OutOfRange for a firstSlot beyond maxSlots.
    Expected<std::uint32_t> Add(const TiledTextureDesc& desc) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, MakeTiledTexture(desc));
        return AddHeader(header);
    }

    /// `pages` entries that are no texture's: each has a value of the engine's own (SetPage), and is
    /// requested like a tile (NtcDemandPage). Errors: OutOfRange for none, OutOfMemory as above.
    Expected<std::uint32_t> AddPages(std::uint32_t pages) noexcept {
        if (pages == 0)
            return Fail(Status::OutOfRange, "pages: 0: must be 1 or more");
        NtcTiledTexture header{};
        header.format = NTC_TILES_PAGES;
        header.tileCount = pages;
        return AddHeader(header);
    }

    /// Another texture under the same identifier, all tiles missing: launches see the old one whole, or the
    /// new one with what has been mapped by the time its bytes are taken. Errors: as Add, then nothing
    /// changes, and InvalidArgument for no such texture. Both need entries for a moment.
    Expected<void> Replace(std::uint32_t texture, const TiledTextureDesc& desc) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture old, GetHeader(texture));
        OPENNTC_ASSIGN(NtcTiledTexture header, MakeTiledTexture(desc));
        OPENNTC_CHECK(TakeRanges(header));
        ReturnRanges(old);
        SetOwner(header, texture);
        Write(texture * kHeaderWords, &header, sizeof(header));
        return {};
    }

    /// Unmaps all tiles and forgets the texture; its identifier may be given away by the next Add. Launches
    /// that still read the old bytes see the old texture. Errors: InvalidArgument for no such texture.
    Expected<void> Remove(std::uint32_t texture) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, GetHeader(texture));
        ReturnRanges(header);
        const NtcTiledTexture none{};
        Write(texture * kHeaderWords, &none, sizeof(none));
        return freeTextures_.PushBack(texture); // has room since Create
    }

    /// Tile to slot: images, and tails of all. Errors: InvalidArgument for no such texture, or a tile of a
    /// texture set that is not in its tail; OutOfRange for no such tile or slot.
    Expected<void> Map(std::uint32_t texture, std::uint32_t tile, std::uint32_t slot) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, CheckTile(texture, tile, slot));
        if (header.format == NTC_TILES_TEXTURE_SET && tile < header.firstTailTile)
            return Fail(Status::InvalidArgument, "tile: %u: of a texture set; it needs its slice (MapSlice)",
                        tile);
        SetWord(entriesWord_ + header.firstEntry + tile, slot);
        return {};
    }

    /// A texture set's tile, in front of the tail: its slot and its slice, with offsets from the start of the
    /// slot, as MakePartialInferenceData gives them. Errors: as Map; OutOfRange for latents at 4 GiB or
    /// behind.
    Expected<void> MapSlice(std::uint32_t texture, std::uint32_t tile, std::uint32_t slot,
                            const NtcSliceConstants& slice) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, CheckTile(texture, tile, slot));
        if (header.format != NTC_TILES_TEXTURE_SET || tile >= header.firstTailTile)
            return Fail(Status::InvalidArgument, "tile: %u: not a texture set's in front of the tail", tile);
        if (header.firstSlot + slot >= limits_.maxSlices)
            return Fail(Status::OutOfRange, "slot: %u: below maxSlices, %u, from firstSlot, %u, on", slot,
                        limits_.maxSlices, header.firstSlot);
        OPENNTC_CHECK(WriteSlice(header, header.firstSlot + slot, slot, slice));
        SetWord(entriesWord_ + header.firstEntry + tile, slot);
        return {};
    }

    /// The slice of a mip in the tail of a texture set, to be set before the last tile of the tail is mapped.
    /// Offsets count from the start of `slot`. Errors: InvalidArgument for no such texture, OutOfRange for no
    /// such mip or slot.
    Expected<void> SetTailSlice(std::uint32_t texture, int mip, std::uint32_t slot,
                                const NtcSliceConstants& slice) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, GetHeader(texture));
        const int firstTailMip = static_cast<int>(header.levelsMips >> 16);
        const int mips = static_cast<int>((header.levelsMips >> 8) & 255u);
        if (header.format != NTC_TILES_TEXTURE_SET || mip < firstTailMip || mip >= mips)
            return Fail(Status::OutOfRange, "mip: %d: %d to %d of a texture set are its tail", mip,
                        firstTailMip, mips - 1);
        OPENNTC_CHECK(CheckSlot(header, slot));
        return WriteSlice(header, header.firstTailRow + static_cast<std::uint32_t>(mip - firstTailMip), slot,
                          slice);
    }

    /// The value of a page. Errors: InvalidArgument for an identifier that AddPages did not give, OutOfRange
    /// for no such page.
    Expected<void> SetPage(std::uint32_t pages, std::uint32_t page, std::uint32_t value) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, CheckTile(pages, page, 0));
        if (header.format != NTC_TILES_PAGES)
            return Fail(Status::InvalidArgument, "pages: %u: is a texture", pages);
        SetWord(entriesWord_ + header.firstEntry + page, value);
        return {};
    }

    /// Errors: InvalidArgument, OutOfRange as above. Unmapping what is not mapped is fine.
    Expected<void> Unmap(std::uint32_t texture, std::uint32_t tile) noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, CheckTile(texture, tile, 0));
        SetWord(entriesWord_ + header.firstEntry + tile, NTC_TILE_MISSING);
        return {};
    }

    /// NTC_TILE_MISSING, or the slot.
    Expected<std::uint32_t> GetSlot(std::uint32_t texture, std::uint32_t tile) const noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, CheckTile(texture, tile, 0));
        return words_[entriesWord_ + header.firstEntry + tile];
    }

    Expected<NtcTiledTexture> GetHeader(std::uint32_t texture) const noexcept {
        NtcTiledTexture header{};
        if (texture < textureCount_)
            std::memcpy(&header, words_.data() + texture * kHeaderWords, sizeof(header));
        if (header.format == NTC_TILES_NONE)
            return Fail(Status::InvalidArgument, "texture: %u: does not exist", texture);
        return header;
    }

    /// Whose a word of feedback is, as the resolve pass lists it: texture, and region in the texture. Errors:
    /// OutOfRange for a word of no texture's, such as one that has been removed since.
    Expected<RegionOwner> FindRegion(std::uint32_t region) const noexcept {
        if (region < regionOwners_.size() && regionOwners_[region] != kNoOwner) {
            OPENNTC_ASSIGN(const NtcTiledTexture header, GetHeader(regionOwners_[region]));
            if (region - header.firstRegion < GetRegionCount(header))
                return RegionOwner{regionOwners_[region], region - header.firstRegion};
        }
        return Fail(Status::OutOfRange, "region: %u: of no texture", region);
    }

    /// The whole table, as it is uploaded at first.
    std::span<const std::byte> GetBytes() const noexcept { return std::as_bytes(words_.AsSpan()); }

    /// The next range that has changed since it was last taken, rising offsets within one series of calls;
    /// false: none. Ranges are multiples of 64 bytes but for the last, and neighbours are one.
    bool TakeChange(ByteRange& range) noexcept { return changes_.Take(range); }

    /// What a launch is given. Rates: 0 … 1, the share of threads that request, or record; 1: all.
    NtcStreamingConstants MakeConstants(std::uint32_t round, double requestRate = 1, double feedbackRate = 1,
                                        std::uint32_t feedbackWord = 0) const noexcept {
        NtcStreamingConstants constants{};
        constants.entriesWord = entriesWord_;
        constants.slicesWord = slicesWord_;
        constants.textureCount = textureCount_;
        constants.queueWord = state_.queueWord;
        constants.bitsWord = state_.bitsWord;
        constants.stampsWord = state_.stampsWord;
        constants.round = round;
        constants.requestRate = GetThreshold(requestRate);
        constants.feedbackRate = GetThreshold(feedbackRate);
        constants.feedbackWord = feedbackWord;
        constants.frame = round;
        return constants;
    }

    /// A random word is at most this with probability `rate`; a rate of 0 is 2^-32.
    static std::uint32_t GetThreshold(double rate) noexcept {
        if (!(rate > 0))
            return 0;
        return rate >= 1 ? 0xFFFFFFFFu : static_cast<std::uint32_t>(rate * 4294967296.0 - 0.5);
    }

    const LaunchState& GetLaunchState() const noexcept { return state_; }
    const PageTableLimits& GetLimits() const noexcept { return limits_; }
    std::uint32_t GetTextureCount() const noexcept { return textureCount_; } ///< identifiers ever given
    std::uint32_t GetUsedTiles() const noexcept { return tiles_.GetUsed(); }
    std::uint32_t GetUsedRegions() const noexcept { return regions_.GetUsed(); }

private:
    static constexpr std::uint32_t kNoOwner = 0xFFFFFFFFu;
    static constexpr std::uint32_t kHeaderWords = sizeof(NtcTiledTexture) / 4;
    static constexpr std::uint32_t kRowWords = sizeof(NtcSliceConstants) / 4;
    static constexpr std::uint64_t kMaxWords = std::uint64_t{1} << 30; // bytes count to 2^32 in shaders

    explicit PageTable(Allocator& allocator) noexcept
        : words_(allocator), freeTextures_(allocator), changes_(allocator), tiles_(allocator),
          tailRows_(allocator), regions_(allocator), regionOwners_(allocator) {}

    Expected<std::uint32_t> AddHeader(NtcTiledTexture header) noexcept {
        if (freeTextures_.empty() && textureCount_ == limits_.maxTextures)
            return Fail(Status::OutOfMemory, "textures: %u: the table is full", limits_.maxTextures);
        OPENNTC_CHECK(TakeRanges(header));
        std::uint32_t id = textureCount_;
        if (!freeTextures_.empty()) {
            id = freeTextures_.back();
            OPENNTC_CHECK(freeTextures_.Resize(freeTextures_.size() - 1));
        } else {
            ++textureCount_;
        }
        SetOwner(header, id);
        Write(id * kHeaderWords, &header, sizeof(header));
        return id;
    }

    /// Entries, tail rows and regions; all of them or, with an error, none.
    Expected<void> TakeRanges(NtcTiledTexture& header) noexcept {
        if (header.firstSlot >= limits_.maxSlots && header.format != NTC_TILES_PAGES)
            return Fail(Status::OutOfRange, "firstSlot: %u: below maxSlots, %u", header.firstSlot,
                        limits_.maxSlots);
        const std::uint32_t tailRows = GetTailRows(header);
        OPENNTC_ASSIGN(header.firstEntry, tiles_.Take(header.tileCount, "maxTiles"));
        if (auto row = tailRows_.Take(tailRows, "maxTailRows")) {
            header.firstTailRow = limits_.maxSlices + *row;
        } else {
            tiles_.Return(header.firstEntry, header.tileCount);
            return PassError(row);
        }
        if (auto region = regions_.Take(GetRegionWords(header), "maxRegions")) {
            header.firstRegion = *region;
        } else {
            tiles_.Return(header.firstEntry, header.tileCount);
            tailRows_.Return(header.firstTailRow - limits_.maxSlices, tailRows);
            return PassError(region);
        }
        return {};
    }

    void SetOwner(const NtcTiledTexture& header, std::uint32_t owner) noexcept {
        for (std::uint32_t region = 0; region < GetRegionCount(header); ++region)
            regionOwners_[header.firstRegion + region] = owner;
    }

    void ReturnRanges(const NtcTiledTexture& header) noexcept {
        SetOwner(header, kNoOwner);
        for (std::uint32_t tile = 0; tile < header.tileCount; ++tile)
            SetWord(entriesWord_ + header.firstEntry + tile, NTC_TILE_MISSING);
        tiles_.Return(header.firstEntry, header.tileCount);
        tailRows_.Return(header.firstTailRow - limits_.maxSlices, GetTailRows(header));
        regions_.Return(header.firstRegion, GetRegionWords(header));
    }

    /// Regions of a texture begin and end at multiples of 4: the resolve pass keeps a byte of each.
    static std::uint32_t GetRegionWords(const NtcTiledTexture& header) noexcept {
        return (GetRegionCount(header) + 3u) & ~3u;
    }

    static std::uint32_t GetTailRows(const NtcTiledTexture& header) noexcept {
        return header.format == NTC_TILES_TEXTURE_SET
                   ? ((header.levelsMips >> 8) & 255u) - (header.levelsMips >> 16)
                   : 0;
    }

    Expected<void> CheckSlot(const NtcTiledTexture& header, std::uint32_t slot) const noexcept {
        if (header.format != NTC_TILES_PAGES && slot >= limits_.maxSlots - header.firstSlot)
            return Fail(Status::OutOfRange, "slot: %u: below maxSlots, %u, from firstSlot, %u, on", slot,
                        limits_.maxSlots, header.firstSlot);
        return {};
    }

    Expected<NtcTiledTexture> CheckTile(std::uint32_t texture, std::uint32_t tile,
                                        std::uint32_t slot) const noexcept {
        OPENNTC_ASSIGN(const NtcTiledTexture header, GetHeader(texture));
        if (tile >= header.tileCount)
            return Fail(Status::OutOfRange, "tile: %u: the texture has %u", tile, header.tileCount);
        OPENNTC_CHECK(CheckSlot(header, slot));
        return header;
    }

    Expected<void> WriteSlice(const NtcTiledTexture& header, std::uint32_t row, std::uint32_t slot,
                              NtcSliceConstants slice) noexcept {
        const std::uint64_t start =
            (std::uint64_t{header.slotsWord} + std::uint64_t{slot} * header.slotWords) * 4;
        for (NtcNeuralMipConstants* grid : {&slice.highRes, &slice.lowRes}) {
            const std::uint64_t offset = start + grid->dataOffset;
            if (offset > 0xFFFFFFFFu || grid->dataOffset % 4 != 0)
                return Fail(Status::OutOfRange,
                            "dataOffset: %u in slot %u: a multiple of 4, below 4 GiB in the buffer",
                            grid->dataOffset, slot);
            grid->dataOffset = static_cast<std::uint32_t>(offset);
        }
        Write(slicesWord_ + row * kRowWords, &slice, sizeof(slice));
        return {};
    }

    void SetWord(std::uint32_t word, std::uint32_t value) noexcept {
        if (words_[word] == value)
            return;
        words_[word] = value;
        changes_.Mark(std::size_t{word} * 4, 4);
    }

    void Write(std::uint32_t word, const void* bytes, std::size_t size) noexcept {
        std::memcpy(words_.data() + word, bytes, size);
        changes_.Mark(std::size_t{word} * 4, size);
    }

    PageTableLimits limits_;
    LaunchState state_;
    std::uint32_t entriesWord_ = 0;
    std::uint32_t slicesWord_ = 0;
    std::uint32_t textureCount_ = 0;
    Array<std::uint32_t> words_;
    Array<std::uint32_t> freeTextures_;
    detail::ChangedBlocks changes_;
    detail::RangePool tiles_;
    detail::RangePool tailRows_;
    detail::RangePool regions_;
    Array<std::uint32_t> regionOwners_; // texture of each word of feedback
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
