// SPDX-License-Identifier: MIT
// The host's image of the page table: headers, mappings, changes, misuse, and random use against a model.
#include "support/CountingAllocator.h"

#include "openntc/streaming/HostPageTable.h"

#include <doctest/doctest.h>

#include <cstring>
#include <map>
#include <random>
#include <string>
#include <vector>

using namespace openntc;

namespace {

constexpr TiledLevel kImageLevels[] = {{0, 0}, {1, 1}, {2, 2}};
constexpr TiledLevel kSetLevels[] = {{0, 3}, {4, 5}};

/// 257 x 100 with tiles of 64 x 32: 5 x 4, 2 x 2 (128 x 50), 1 x 1 (64 x 25), tail 32 x 12 … 1 x 1.
TiledTextureDesc GetImageDesc() {
    TiledTextureDesc desc;
    desc.width = 257;
    desc.height = 100;
    desc.mips = 9;
    desc.tileWidth = 64;
    desc.tileHeight = 32;
    desc.levels = kImageLevels;
    desc.tailTiles = 1;
    desc.slotBytes = 64 * 32 * 4;
    return desc;
}

TiledTextureDesc GetSetDesc() {
    TiledTextureDesc desc;
    desc.width = 1024;
    desc.height = 512;
    desc.mips = 10;
    desc.tileWidth = 32;
    desc.tileHeight = 32;
    desc.levels = kSetLevels; // 128 x 64, 32 x 16
    desc.tailTiles = 1;
    desc.format = TileFormat::TextureSet;
    desc.slotBytes = 24576;
    return desc;
}

PageTable MakeTable(const PageTableLimits& limits, Allocator& allocator = GetDefaultAllocator()) {
    auto table = PageTable::Create(limits, allocator);
    REQUIRE_MESSAGE(table.has_value(), std::string(table.error().GetText()));
    return std::move(*table);
}

const PageTableLimits kLimits = {8, 200, 64, 64, 16, 300, 16};

/// What a device would have after the uploads.
void Upload(PageTable& table, std::vector<std::byte>& device) {
    std::size_t end = 0;
    for (PageTable::ByteRange range; table.TakeChange(range);) {
        CHECK(range.offset % 4 == 0);
        CHECK(range.size % 4 == 0);
        CHECK((end == 0 || range.offset > end)); // neighbours are one range
        end = range.offset + range.size;
        REQUIRE(end <= device.size());
        std::memcpy(device.data() + range.offset, table.GetBytes().data() + range.offset, range.size);
    }
}

template <typename T>
Status GetTableStatus(const Expected<T>& result) {
    return result ? Status::Ok : result.error().GetStatus();
}

} // namespace

TEST_CASE("page table: the header of an image") {
    PageTable table = MakeTable(kLimits);
    const auto id = table.Add(GetImageDesc());
    REQUIRE(id);
    const NtcTiledTexture header = *table.GetHeader(*id);
    CHECK(header.tileCount == 20 + 4 + 1 + 1);
    CHECK(header.firstTailTile == 25);
    CHECK(header.levelsMips == (3u | 9u << 8 | 3u << 16));
    CHECK(header.levels[0].widthFirstMip == 257);
    CHECK(header.levels[1].widthFirstMip == (128u | 1u << 24));
    CHECK(header.levels[1].heightLastMip == (50u | 1u << 24));
    CHECK(header.levels[1].tilesXY == (2u | 2u << 16));
    CHECK(header.levels[1].firstTile == 20);
    CHECK(header.levels[2].firstTile == 24);
    CHECK(header.mipLevels0 == 0x210);
    // 100 / 2 = 50 < 64 of height 32: 32; regions of 64 x 32.
    CHECK(header.regionWidth == 64);
    CHECK(header.regionHeight == 32);
    CHECK(header.regionsXY == (5u | 4u << 16));
}

TEST_CASE("page table: the header of a texture set, whose levels do not halve") {
    PageTable table = MakeTable(kLimits);
    const NtcTiledTexture header = *table.GetHeader(*table.Add(GetSetDesc()));
    CHECK(header.levels[0].widthFirstMip == 128);
    CHECK(header.levels[0].heightLastMip == (64u | 3u << 24));
    CHECK(header.levels[0].tilesXY == (4u | 2u << 16));
    CHECK(header.levels[1].widthFirstMip == (32u | 4u << 24));
    CHECK(header.levels[1].tilesXY == (1u | 1u << 16));
    CHECK(header.levels[1].firstTile == 8);
    CHECK(header.tileCount == 10);
    CHECK(header.mipLevels0 == 0x110000); // mips 0 … 3: level 0; 4, 5: level 1; then the tail
    CHECK(header.regionWidth == 256);     // 32 texels of mip 3
    CHECK(header.regionsXY == (4u | 2u << 16));
}

TEST_CASE("page table: regions are tiles, smaller powers of two where they exceed half the texture") {
    CHECK(GetRegionSize(1024, 256) == 256);
    CHECK(GetRegionSize(512, 256) == 256);
    CHECK(GetRegionSize(511, 256) == 128);
    CHECK(GetRegionSize(150, 100) == 64);
    CHECK(GetRegionSize(200, 100) == 100);
    CHECK(GetRegionSize(1, 64) == 1);
    CHECK(GetRegionSize(3, 64) == 1);
    CHECK(GetRegionSize(65536, std::int64_t{65535} << 15) == 32768);
}

TEST_CASE("page table: mapped tiles, slices and their offsets reach the device as changed ranges") {
    PageTable table = MakeTable(kLimits);
    std::vector<std::byte> device(table.GetBytes().size(), std::byte{0xCC});
    Upload(table, device);
    CHECK(std::equal(device.begin(), device.end(), table.GetBytes().begin()));
    PageTable::ByteRange none;
    CHECK_FALSE(table.TakeChange(none));

    const std::uint32_t image = *table.Add(GetImageDesc());
    TiledTextureDesc setDesc = GetSetDesc();
    setDesc.firstSlot = 32;
    setDesc.slotsOffset = 4096;
    const std::uint32_t set = *table.Add(setDesc);
    CHECK(*table.GetSlot(image, 7) == NTC_TILE_MISSING);
    REQUIRE(table.Map(image, 7, 3));
    CHECK(*table.GetSlot(image, 7) == 3);
    const NtcNeuralMipConstants high = {0, 0x00400080, 0x00010002, 0x00110012};
    const NtcNeuralMipConstants low = {1224, 0x00200040, 0x00000001, 0x0009000A};
    REQUIRE(table.MapSlice(set, 8, 5, {high, low}));
    REQUIRE(table.SetTailSlice(set, 9, 6, {high, low}));
    CHECK_FALSE(table.Map(set, 8, 5)); // a slice is needed
    Upload(table, device);
    CHECK(std::equal(device.begin(), device.end(), table.GetBytes().begin()));

    const NtcStreamingConstants constants = table.MakeConstants(7);
    CHECK(constants.round == 7);
    CHECK(constants.textureCount == 2);
    CHECK(constants.requestRate == 0xFFFFFFFFu);
    const auto word = [&](std::uint32_t at) {
        std::uint32_t value;
        std::memcpy(&value, device.data() + std::size_t{at} * 4, 4);
        return value;
    };
    const NtcTiledTexture header = *table.GetHeader(set);
    CHECK(word(constants.entriesWord + header.firstEntry + 8) == 5);
    CHECK(word(constants.slicesWord + 8 * (32 + 5)) == 4096 + 5 * 24576);
    CHECK(word(constants.slicesWord + 8 * (32 + 5) + 4) == 4096 + 5 * 24576 + 1224);
    CHECK(word(constants.slicesWord + 8 * (32 + 5) + 6) == low.sliceLeftTop);
    CHECK(header.firstTailRow >= kLimits.maxSlices);
    CHECK(word(constants.slicesWord + 8 * (header.firstTailRow + 9 - 6)) == 4096 + 6 * 24576);

    REQUIRE(table.Unmap(image, 7));
    REQUIRE(table.Remove(set));
    Upload(table, device);
    CHECK(std::equal(device.begin(), device.end(), table.GetBytes().begin()));
    CHECK(word(constants.entriesWord + header.firstEntry + 8) == NTC_TILE_MISSING);
    CHECK(table.GetUsedTiles() == 26);
}

TEST_CASE("page table: misuse answers with a status and changes nothing") {
    PageTable table = MakeTable(kLimits);
    const std::uint32_t image = *table.Add(GetImageDesc());
    const std::uint32_t set = *table.Add(GetSetDesc());
    for (PageTable::ByteRange range; table.TakeChange(range);) {
    }
    const std::vector<std::byte> before(table.GetBytes().begin(), table.GetBytes().end());
    const NtcNeuralMipConstants grid = {0, 0x00100010, 0, 0x00100010};
    CHECK(GetTableStatus(table.Map(9, 0, 0)) == Status::InvalidArgument);
    CHECK(GetTableStatus(table.Map(image, 26, 0)) == Status::OutOfRange);
    CHECK(GetTableStatus(table.Map(image, 0, 64)) == Status::OutOfRange);
    CHECK(GetTableStatus(table.Map(image, 0, 0xFFFFFFFFu)) == Status::OutOfRange);
    CHECK(GetTableStatus(table.Map(set, 0, 0)) == Status::InvalidArgument);
    CHECK(GetTableStatus(table.MapSlice(image, 0, 0, {grid, grid})) == Status::InvalidArgument);
    CHECK(GetTableStatus(table.MapSlice(set, 9, 0, {grid, grid})) == Status::InvalidArgument);
    CHECK(GetTableStatus(table.MapSlice(set, 10, 0, {grid, grid})) == Status::OutOfRange);
    CHECK(GetTableStatus(table.MapSlice(set, 8, 1, {{0xFFFFFFFCu, 0, 0, 0}, grid})) == Status::OutOfRange);
    CHECK(GetTableStatus(table.MapSlice(set, 8, 1, {{2, 0, 0, 0}, grid})) == Status::OutOfRange);
    CHECK(GetTableStatus(table.SetTailSlice(set, 5, 0, {grid, grid})) == Status::OutOfRange);
    CHECK(GetTableStatus(table.SetTailSlice(set, 10, 0, {grid, grid})) == Status::OutOfRange);
    CHECK(GetTableStatus(table.SetTailSlice(image, 8, 0, {grid, grid})) == Status::OutOfRange);
    CHECK(GetTableStatus(table.Unmap(image, 26)) == Status::OutOfRange);
    CHECK(GetTableStatus(table.Remove(2)) == Status::InvalidArgument);
    CHECK(std::equal(before.begin(), before.end(), table.GetBytes().begin()));
    CHECK(table.MapSlice(set, 8, 0, {{0xFFFFFFFCu, 0, 0, 0}, grid})); // the last word of 4 GiB
    REQUIRE(table.Remove(set));
    CHECK(GetTableStatus(table.Remove(set)) == Status::InvalidArgument);
    CHECK(GetTableStatus(table.GetSlot(set, 0)) == Status::InvalidArgument);

    const auto refuse = [&](auto&& change, Status status) {
        TiledTextureDesc desc = GetImageDesc();
        change(desc);
        const auto result = table.Add(desc);
        CHECK(GetTableStatus(result) == status);
        return result ? std::string() : std::string(result.error().GetText());
    };
    constexpr TiledLevel kGap[] = {{0, 0}, {2, 2}};
    constexpr TiledLevel kBeyond[] = {{0, 9}};
    using Desc = TiledTextureDesc;
    CHECK(refuse([](Desc& d) { d.width = 0; }, Status::OutOfRange) == "width: 0: 1 to 65536");
    refuse([](Desc& d) { d.height = 65537; }, Status::OutOfRange);
    refuse([](Desc& d) { d.mips = 17; }, Status::OutOfRange);
    refuse([](Desc& d) { d.tileWidth = 0; }, Status::OutOfRange);
    refuse([&](Desc& d) { d.levels = kGap; }, Status::InvalidArgument);
    refuse([&](Desc& d) { d.levels = kBeyond; }, Status::InvalidArgument);
    refuse([](Desc& d) { d.tailTiles = 0; }, Status::InvalidArgument);
    refuse([](Desc& d) { d.slotBytes = 64 * 32 * 4 - 16; }, Status::OutOfRange);
    refuse([](Desc& d) { d.slotBytes = 64 * 32 * 4 + 4; }, Status::InvalidArgument);
    refuse([](Desc& d) { d.format = TileFormat::RGBA16F; }, Status::OutOfRange);
    refuse([](Desc& d) { d.format = static_cast<TileFormat>(12); }, Status::OutOfRange);
    refuse([](Desc& d) { d.filter = static_cast<TileFilter>(3); }, Status::OutOfRange);
    refuse([](Desc& d) { d.maxAnisotropy = 17; }, Status::OutOfRange);
    refuse([](Desc& d) { d.mipBias = std::nanf(""); }, Status::OutOfRange);
    refuse([](Desc& d) { d.firstChannel = 13; }, Status::OutOfRange);
    refuse([](Desc& d) { d.firstSlot = 64; }, Status::OutOfRange);
    refuse([](Desc& d) { d.regionWidth = d.regionHeight = 1; }, Status::OutOfMemory); // 25 700 regions
    refuse([](Desc& d) { d.tileHeight = d.tileWidth = 8; }, Status::OutOfMemory);     // 33 x 13 tiles …
    CHECK(table.GetUsedTiles() == 26); // what was taken for a refused texture is back
    CHECK(table.GetUsedRegions() == 20);
}

TEST_CASE("page table: no allocation after Create, and each failing allocation is a status") {
    test::CountingAllocator allocator;
    {
        PageTable table = MakeTable(kLimits, allocator);
        const std::size_t allocations = allocator.GetAllocationCount();
        for (int i = 0; i < 50; ++i) {
            std::vector<std::uint32_t> ids;
            while (const auto id = table.Add(GetSetDesc()))
                ids.push_back(*id);
            REQUIRE(ids.size() == 4); // 16 tail rows
            for (const std::uint32_t id : ids) {
                REQUIRE(table.Map(id, 9, 0)); // the tail
                REQUIRE(table.Remove(id));
            }
        }
        CHECK(allocator.GetAllocationCount() == allocations);
        for (std::size_t at = 0; at < allocations; ++at) {
            test::CountingAllocator failing;
            failing.FailAt(at);
            CHECK(GetTableStatus(PageTable::Create(kLimits, failing)) == Status::OutOfMemory);
            CHECK(failing.GetUsedBytes() == 0);
        }
    }
    CHECK(allocator.GetUsedBytes() == 0);
    CHECK(GetTableStatus(PageTable::Create({0xFFFFFFFFu, 0xFFFFFFFFu, 0, 0, 0, 0, 0})) == Status::OutOfRange);
    CHECK(GetTableStatus(PageTable::Create({1, 1, 1, 2, 0, 0, 0})) == Status::InvalidArgument);
}

TEST_CASE("page table: random use against a model that keeps maps") {
    const unsigned seed = 20251127;
    MESSAGE("seed: " << seed);
    std::mt19937 generator(seed);
    const auto random = [&generator] { return static_cast<std::uint32_t>(generator()); };
    PageTable table = MakeTable(kLimits);
    std::vector<std::byte> device(table.GetBytes().size());
    std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> model; // texture: tile: slot
    std::size_t full = 0;
    for (int step = 0; step < 20000; ++step) {
        const std::uint32_t what = random() % 100;
        if (what < 10) {
            TiledTextureDesc desc = GetImageDesc();
            desc.width = static_cast<int>(1 + random() % 300);
            desc.height = static_cast<int>(1 + random() % 200);
            if (const auto id = table.Add(desc)) {
                REQUIRE_FALSE(model.contains(*id));
                model[*id] = {};
            } else {
                CHECK(id.error().GetStatus() == Status::OutOfMemory);
                ++full;
            }
        } else if (what < 18 && !model.empty()) {
            const auto at = std::next(model.begin(), random() % model.size());
            REQUIRE(table.Remove(at->first));
            model.erase(at);
        } else if (!model.empty()) {
            const auto at = std::next(model.begin(), random() % model.size());
            const std::uint32_t tile = random() % table.GetHeader(at->first)->tileCount;
            if (what < 70) {
                const std::uint32_t slot = random() % kLimits.maxSlots;
                REQUIRE(table.Map(at->first, tile, slot));
                at->second[tile] = slot;
            } else {
                REQUIRE(table.Unmap(at->first, tile));
                at->second.erase(tile);
            }
        }
        if (step % 16 != 0)
            continue;
        Upload(table, device);
        REQUIRE(std::equal(device.begin(), device.end(), table.GetBytes().begin()));
        // From the device's bytes alone: every mapping, and nothing else in a texture's entries.
        std::uint32_t tiles = 0;
        std::vector<bool> taken(kLimits.maxTiles);
        for (const auto& [id, mapped] : model) {
            NtcTiledTexture header;
            std::memcpy(&header, device.data() + id * sizeof(header), sizeof(header));
            tiles += header.tileCount;
            for (std::uint32_t tile = 0; tile < header.tileCount; ++tile) {
                REQUIRE_FALSE(taken.at(header.firstEntry + tile)); // no two textures share an entry
                taken[header.firstEntry + tile] = true;
                std::uint32_t slot;
                std::memcpy(&slot,
                            device.data() + (table.MakeConstants(1).entriesWord + header.firstEntry + tile) *
                                                std::size_t{4},
                            4);
                const auto found = mapped.find(tile);
                REQUIRE(slot == (found == mapped.end() ? NTC_TILE_MISSING : found->second));
            }
        }
        CHECK(table.GetUsedTiles() == tiles);
    }
    CHECK(full > 100);
}

TEST_CASE("page table: rates, launch state and the queue that comes back") {
    CHECK(PageTable::GetThreshold(1) == 0xFFFFFFFFu);
    CHECK(PageTable::GetThreshold(0.5) == 0x7FFFFFFFu);
    CHECK(PageTable::GetThreshold(1.0 / 64) == (1u << 26) - 1);
    CHECK(PageTable::GetThreshold(0) == 0);
    CHECK(PageTable::GetThreshold(std::nan("")) == 0);
    CHECK(PageTable::GetThreshold(1e-12) == 0);
    const PageTable table = MakeTable(kLimits);
    const LaunchState& state = table.GetLaunchState();
    CHECK(state.bitsWord == 4 + 2 * 16);
    CHECK(state.stampsWord == state.bitsWord + 7); // 200 bits
    CHECK(state.words == state.stampsWord + 64);
    std::vector<std::byte> bytes(state.GetBytes(), std::byte{0xAA});
    CHECK(GetTableStatus(ClearLaunchState(state, std::span(bytes).first(8))) == Status::InvalidArgument);
    REQUIRE(ClearLaunchState(state, bytes));
    const std::uint32_t words[] = {19, 3, 16, 0, 5, 6, 7, 8};
    std::memcpy(bytes.data(), words, sizeof(words));
    const auto list = ReadRequests(state, bytes);
    REQUIRE(list);
    CHECK(list->GetCount() == 16);
    CHECK(list->overflow == 3);
    CHECK((*list)[0].textureId == 5);
    CHECK((*list)[1].tile == 8);
    CHECK(GetTableStatus(ReadRequests(state, std::span(bytes).first(20))) == Status::InvalidArgument);
    bytes[8] = std::byte{17};
    CHECK(GetTableStatus(ReadRequests(state, bytes)) == Status::InvalidArgument);
}

TEST_CASE("page table: pages of a resource have values, and no slots") {
    PageTable table = MakeTable(kLimits);
    const auto texture = table.Add(GetImageDesc());
    const auto pages = table.AddPages(100);
    REQUIRE(texture.has_value());
    REQUIRE(pages.has_value());
    CHECK(table.SetPage(*pages, 99, 0xABCDEF01u).has_value());
    CHECK(table.GetSlot(*pages, 99).value() == 0xABCDEF01u);
    CHECK(table.GetSlot(*pages, 98).value() == NTC_TILE_MISSING);
    CHECK(table.GetHeader(*pages)->format == NTC_TILES_PAGES);
    CHECK(table.GetUsedTiles() == table.GetHeader(*texture)->tileCount + 100);
    CHECK(table.SetPage(*pages, 100, 1).error().GetStatus() == Status::OutOfRange);
    CHECK(table.SetPage(*texture, 0, 1).error().GetStatus() == Status::InvalidArgument);
    CHECK(table.SetPage(7, 0, 1).error().GetStatus() == Status::InvalidArgument);
    CHECK(table.MapSlice(*pages, 0, 0, {}).error().GetStatus() == Status::InvalidArgument);
    CHECK(table.AddPages(0).error().GetStatus() == Status::OutOfRange);
    CHECK(table.AddPages(1000).error().GetStatus() == Status::OutOfMemory);
    CHECK(table.Unmap(*pages, 99).has_value());
    CHECK(table.GetSlot(*pages, 99).value() == NTC_TILE_MISSING);
    REQUIRE(table.Remove(*pages).has_value());
    CHECK(table.GetUsedTiles() == table.GetHeader(*texture)->tileCount);
}

TEST_CASE("page table: a texture is replaced under its identifier") {
    PageTable table = MakeTable(kLimits);
    const auto id = table.Add(GetImageDesc());
    REQUIRE(id.has_value());
    REQUIRE(table.Map(*id, 3, 5).has_value());
    const NtcTiledTexture before = *table.GetHeader(*id);
    TiledTextureDesc tooLarge = GetImageDesc();
    tooLarge.tileWidth = 16; // 17 x 13 tiles of level 0: more than the table has
    tooLarge.tileHeight = 8;
    CHECK(table.Replace(*id, tooLarge).error().GetStatus() == Status::OutOfMemory);
    const NtcTiledTexture after = *table.GetHeader(*id);
    CHECK(std::memcmp(&before, &after, sizeof(before)) == 0);
    CHECK(table.GetSlot(*id, 3).value() == 5);
    REQUIRE(table.Replace(*id, GetSetDesc()).has_value());
    CHECK(table.GetHeader(*id)->format == NTC_TILES_TEXTURE_SET);
    for (std::uint32_t tile = 0; tile < table.GetHeader(*id)->tileCount; ++tile)
        CHECK(table.GetSlot(*id, tile).value() == NTC_TILE_MISSING);
    CHECK(table.GetUsedTiles() == table.GetHeader(*id)->tileCount);
    CHECK(table.GetTextureCount() == 1);
    CHECK(table.Replace(1, GetSetDesc()).error().GetStatus() == Status::InvalidArgument);
}
