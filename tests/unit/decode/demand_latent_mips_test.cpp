// SPDX-License-Identifier: MIT
// Tiles of generations 2 and 3 beside case 47: how often compressed latents are decompressed and what memory that takes,
// reads of stored ones, several threads and sources with one cache, and files that are corrupt or cut short.
#include "support/CountingAllocator.h"
#include "support/RandomSlices.h"
#include "support/SpecificationVectors.h"

#include "openntc/streaming/TextureSetTileSource.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

using namespace openntc;
using namespace openntc_tests;
using Bytes = std::vector<std::byte>;

namespace {

constexpr int kTileSize = 32;

/// 256 x 256 latent texels of `layers` layers in mip 0: two tiles of 64 KiB in each.
Bytes MakeLayeredFile(bool isCompressed, int layers = 2) {
    SynthesisDesc synthesis;
    synthesis.seed = 11;
    synthesis.desc = {256, 256, 4, 9};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(1, 4 * layers);
    synthesis.compression = {isCompressed, false, 1, 2.0f};
    return MakeFile(synthesis);
}

Shared<TextureSetTileSource> Open(Stream& stream, Shared<DecompressedTileCache> cache = {},
                                  Allocator& allocator = GetDefaultAllocator()) {
    auto source = TextureSetTileSource::OpenStream(stream, kTileSize, kTileSize, allocator, std::move(cache));
    REQUIRE_MESSAGE(source, std::string(source ? "" : source.error().GetText()));
    return *source;
}

std::uint32_t GetTileCount(const TileSource& source) {
    return static_cast<std::uint32_t>(source.GetLayout().GetTileCount());
}

Bytes ReadOne(TileSource& source, std::uint32_t tile) {
    Bytes bytes(source.GetTileBytes(tile));
    const auto read = source.ReadTile(tile, bytes, {});
    REQUIRE_MESSAGE(read, std::string(read ? "" : read.error().GetText()));
    REQUIRE(read->bytes == bytes.size());
    return bytes;
}

std::vector<Bytes> ReadEach(TileSource& source) {
    std::vector<Bytes> tiles;
    for (std::uint32_t tile = 0; tile < GetTileCount(source); ++tile)
        tiles.push_back(ReadOne(source, tile));
    return tiles;
}

/// Notes what is read, and fails behind `limit`.
class NotingStream final : public Stream {
public:
    struct Part {
        std::uint64_t offset;
        std::size_t bytes;
    };

    explicit NotingStream(std::span<const std::byte> bytes) : inner_(bytes) {}
    bool Read(void* destination, std::size_t bytes) noexcept override {
        parts.push_back({inner_.Tell(), bytes});
        return inner_.Tell() + bytes <= limit && inner_.Read(destination, bytes);
    }
    bool Write(const void*, std::size_t) noexcept override { return false; }
    bool Seek(std::uint64_t offset) noexcept override { return inner_.Seek(offset); }
    std::uint64_t Tell() noexcept override { return inner_.Tell(); }
    std::uint64_t Size() noexcept override { return inner_.Size(); }

    std::vector<Part> parts;
    std::uint64_t limit = ~std::uint64_t{0};

private:
    ReadOnlyMemoryStream inner_;
};

/// Tiles of 64 KiB of all layers that are compressed: the smallest are not.
std::uint64_t CountCompressedTiles(const TextureSetMetadata& set) {
    std::uint64_t tiles = 0;
    for (const LatentMip& mip : set.GetLatentMips()) {
        for (int layer = 0; layer < mip.layers; ++layer) {
            if (mip.layerData[static_cast<std::size_t>(layer)].isCompressed)
                tiles += (mip.GetLayerBytes() + 65535) / 65536;
        }
    }
    return tiles;
}

} // namespace

TEST_CASE("demand: compressed latents: each tile of 64 KiB is decompressed once where the cache holds them") {
    const Bytes file = MakeLayeredFile(true);
    ReadOnlyMemoryStream stream(file);
    auto cache = DecompressedTileCache::Create(64);
    REQUIRE(cache);
    const auto source = Open(stream, *cache);
    const std::vector<Bytes> tiles = ReadEach(*source);
    const DecompressedTileStatistics statistics = (*cache)->GetStatistics();
    CHECK(statistics.decompressed == CountCompressedTiles(source->GetMetadata()));
    CHECK(statistics.bytes == statistics.decompressed * 65536);
    CHECK(statistics.found > 0);
    CHECK(std::max_element(tiles.begin(), tiles.end(), [](const Bytes& a, const Bytes& b) {
              return a.size() < b.size();
          })->size() <= source->GetLargestTileBytes());

    auto narrow = DecompressedTileCache::Create(1);
    REQUIRE(narrow);
    CHECK(ReadEach(*Open(stream, *narrow)) == tiles);
    CHECK((*narrow)->GetStatistics().decompressed > statistics.decompressed);
    CHECK((*narrow)->GetStatistics().bytes == 65536);

    const Bytes stored = MakeLayeredFile(false);
    ReadOnlyMemoryStream storedStream(stored);
    CHECK(ReadEach(*Open(storedStream)) == tiles);
    CHECK(DecompressedTileCache::Create(0).error().GetStatus() == Status::OutOfRange);
    CHECK(DecompressedTileCache::Create(4097).error().GetStatus() == Status::OutOfRange);
}

TEST_CASE("demand: compressed latents: memory is that of the cache and of one reader") {
    const Bytes file = MakeLayeredFile(true, 4);
    NotingStream stream(file); // from streams the compressed bytes are copied first
    openntc::test::CountingAllocator counting;
    auto source = Open(stream, {}, counting);
    const std::size_t before = counting.GetUsedBytes();
    CHECK(CountCompressedTiles(source->GetMetadata()) > TextureSetTileSource::kCachedTiles);
    ReadEach(*source);
    const std::size_t cached = TextureSetTileSource::kCachedTiles * 65536;
    CHECK(counting.GetUsedBytes() == before + cached);
    CHECK(counting.GetPeakBytes() <= before + cached + 2 * 65536 + 8 + 4 * 2); // a compressed tile, a table
    counting.SetLimit(counting.GetUsedBytes());
    Bytes bytes(source->GetTileBytes(0));
    CHECK(source->ReadTile(0, bytes, {}).error().GetStatus() == Status::OutOfMemory);
    source = {};
    CHECK(counting.GetUsedBytes() == 0);
}

TEST_CASE("demand: compressed latents: threads and sources with one small cache read the same") {
    const Bytes file = MakeLayeredFile(true);
    auto cache = DecompressedTileCache::Create(3);
    REQUIRE(cache);
    std::vector<Shared<TextureSetTileSource>> sources;
    for (int i = 0; i < 2; ++i) {
        auto source =
            TextureSetTileSource::OpenMemory(file, kTileSize, kTileSize, GetDefaultAllocator(), *cache);
        REQUIRE(source);
        sources.push_back(*source);
    }
    const std::vector<Bytes> expected = ReadEach(*sources[0]);
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::uint32_t t = 0; t < 4; ++t) {
        threads.emplace_back([&, t] {
            TileSource& source = *sources[t % 2];
            for (std::uint32_t i = 0; i < 2 * expected.size(); ++i) {
                const auto tile = (i * 7 + t) % static_cast<std::uint32_t>(expected.size());
                Bytes bytes(source.GetTileBytes(tile));
                if (!source.ReadTile(tile, bytes, {}) || bytes != expected[tile])
                    ++wrong;
            }
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    CHECK(wrong == 0);
    CHECK((*cache)->GetStatistics().bytes <= 3 * 65536);
}

TEST_CASE("demand: stored latents: rows come together, and nothing outside the layers is read") {
    const Bytes file = MakeLayeredFile(false);
    NotingStream stream(file);
    const auto source = Open(stream);
    const TextureSetMetadata& set = source->GetMetadata();
    for (std::uint32_t tile = 0; tile < GetTileCount(*source); ++tile) {
        stream.parts.clear();
        const Bytes bytes = ReadOne(*source, tile);
        std::size_t calls = 0;
        for (const NotingStream::Part& part : stream.parts) {
            bool isInside = false;
            for (const LatentMip& mip : set.GetLatentMips()) {
                for (int layer = 0; layer < mip.layers; ++layer) {
                    const StreamRange& range = mip.layerData[static_cast<std::size_t>(layer)].range;
                    isInside = isInside || (part.offset >= range.offset &&
                                            part.offset + part.bytes <= range.offset + range.size);
                }
            }
            CHECK(isInside);
            ++calls;
        }
        // Of two layers in two mips, of rows of at most 512 bytes: 16 KiB hold all of a tile's, once below and once
        // above the edge where they wrap, and the first row a second time where it wraps to the left.
        const bool isTail = tile >= static_cast<std::uint32_t>(source->GetLayout().GetRegularTileCount());
        CHECK(calls <= (isTail ? 2 * set.GetLatentMips().size() : 4 * 6));
    }
    Bytes whole(source->GetTileBytes(0));
    stream.limit = set.GetLatentMips()[0].layerData[1].range.offset;
    const auto cut = source->ReadTile(0, whole, {});
    CHECK(cut.error().GetStatus() == Status::IOError);
    CHECK(source->ReadTile(0, std::span(whole).first(whole.size() - 1), {}).error().GetStatus() ==
          Status::OutOfRange);
}

TEST_CASE("demand: compressed latents: what is corrupt is an error of the tiles that need it") {
    Bytes file = MakeLayeredFile(true, 1);
    ReadOnlyMemoryStream stream(file);
    const auto source = Open(stream);
    const std::vector<Bytes> expected = ReadEach(*source);
    // The second tile of 64 KiB of mip 0: rows 128 and below. A block of a type that does not exist.
    const StreamRange range = source->GetMetadata().GetLatentMips()[0].layerData[0].range;
    std::uint32_t offset = 0;
    std::memcpy(&offset, file.data() + range.offset + 12, 4);
    const std::size_t corrupt = static_cast<std::size_t>(range.offset) + 16 + offset;
    const std::byte sound = file[corrupt];
    file[corrupt] |= std::byte{7};
    const auto again = Open(stream);
    std::size_t failed = 0;
    for (std::uint32_t tile = 0; tile < GetTileCount(*again); ++tile) {
        Bytes bytes(again->GetTileBytes(tile));
        const auto read = again->ReadTile(tile, bytes, {});
        const TileSlice slice = *again->GetLayout().GetTileSlice(tile);
        const bool needs = slice.firstMip == 0 && (slice.top == 0 || slice.top + slice.height >= 127);
        CHECK(read.has_value() == !needs);
        if (read) {
            CHECK(bytes == expected[tile]);
        } else {
            ++failed;
            CHECK(read.error().GetStatus() == Status::FileUnrecognized);
        }
    }
    CHECK(failed > 0);
    file[corrupt] = sound; // what could not be read is asked for again
    CHECK(ReadOne(*again, 0) == expected[0]);
}
