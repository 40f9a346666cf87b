// SPDX-License-Identifier: MIT
// Texture sets of every generation through the demand loader, from file, stream and memory: any texel of any mip, decoded from the
// slot and the slice row that the page table names for its tile, has the bits of the whole set.
#include "support/RandomSlices.h"
#include "support/SpecificationVectors.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/streaming/DemandLoader.h"
#include "openntc/streaming/TextureSetTileSource.h"

#include <doctest/doctest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// A pool in memory.
class DemandedPool final : public TileUploader {
public:
    explicit DemandedPool(std::size_t bytes) : bytes_(bytes) {}
    Expected<void> Upload(const TileUpload& upload) override {
        REQUIRE(upload.offset + upload.bytes.size() <= bytes_.size());
        std::memcpy(bytes_.data() + upload.offset, upload.bytes.data(), upload.bytes.size());
        return {};
    }
    std::span<const std::byte> Get() const { return bytes_; }

private:
    std::vector<std::byte> bytes_;
};

NtcSliceConstants GetDemandedRow(const PageTable& table, std::uint32_t row) {
    NtcSliceConstants constants{};
    const std::size_t word = table.MakeConstants(1).slicesWord + std::size_t{row} * 8;
    std::memcpy(&constants, table.GetBytes().data() + word * 4, sizeof(constants));
    return constants;
}

/// Loads all tiles of a set, and compares `texels` random ones of any mip.
void CheckDemandedSet(SliceRandom& random, const SynthesisDesc& synthesis,
                      const Shared<TextureSetTileSource>& source, std::span<const std::byte> file,
                      int threads, int texels) {
    const TileLayout& layout = source->GetLayout();
    const std::uint32_t tiles = static_cast<std::uint32_t>(layout.GetTileCount());
    DemandLoaderOptions options;
    options.slots = tiles;
    options.slotBytes = static_cast<std::uint32_t>((source->GetLargestTileBytes() + 15) / 16 * 16);
    options.firstSlot = 2;
    options.slotsOffset = 64;
    options.table = {2, tiles, tiles + 2, tiles + 2, 16, 0, tiles};
    options.threads = threads;
    options.framesInFlight = 1;
    options.maxOutstanding = tiles;
    auto loader = DemandLoader::Create(options);
    REQUIRE_MESSAGE(loader.has_value(), std::string(loader.error().GetText()));
    TiledTextureDesc desc;
    desc.format = TileFormat::TextureSet;
    desc.hasFeedback = false;
    const auto id = loader->CreateTexture(source, desc);
    REQUIRE_MESSAGE(id.has_value(), std::string(id.error().GetText()));
    DemandedPool pool(options.slotsOffset + std::size_t{tiles} * options.slotBytes);
    std::vector<NtcTileRequest> requests;
    for (std::uint32_t tile = 0; tile < tiles; ++tile)
        requests.push_back({id->index, tile});
    const auto first = loader->LaunchPrepare(pool);
    REQUIRE(first.has_value());
    const auto ticket =
        loader->ProcessRequests(first->context, {{std::as_bytes(std::span(requests)), 0}, {}});
    REQUIRE(ticket.has_value());
    ticket->Wait();
    loader->WaitIdle();
    REQUIRE(loader->LaunchPrepare(pool).has_value());
    CHECK(loader->GetStatistics().residentTiles == tiles);

    const TextureSetMetadata& set = source->GetMetadata();
    ReadOnlyMemoryStream stream(file);
    std::vector<std::byte> latents(*GetLatentBufferBytes(set, 0, set.GetDesc().mips));
    REQUIRE(ReadLatents(set, stream, 0, set.GetDesc().mips, latents));
    const auto whole = MakeInferenceData(set, 0, set.GetDesc().mips, InferenceWeightType::GenericInt8);
    const auto weights = set.GetInferenceWeights(InferenceWeightType::GenericInt8);
    REQUIRE(whole);
    REQUIRE(weights);
    const PageTable& table = loader->GetPageTable();
    for (int i = 0; i < texels; ++i) {
        const int mip = random.Pick(0, set.GetDesc().mips - 1);
        const ColorMip& size = set.GetColorMips()[static_cast<std::size_t>(mip)];
        const int x = random.Pick(0, size.width - 1), y = random.Pick(0, size.height - 1);
        const TilePosition position = *layout.GetTileOfTexel(mip, x, y);
        const std::uint32_t tile = *layout.GetTileNumber(position);
        const std::uint32_t slot = *table.GetSlot(id->index, tile);
        REQUIRE(slot < tiles);
        const bool isTail = mip >= layout.GetTailFirstMip();
        const std::uint32_t row = isTail ? table.GetHeader(id->index)->firstTailRow +
                                               static_cast<std::uint32_t>(mip - layout.GetTailFirstMip())
                                         : options.firstSlot + slot;
        NtcTextureSetConstants constants = *whole;
        for (int image = 0; image < NTC_MAX_NEURAL_MIPS; ++image)
            REQUIRE(PatchConstants(constants, image, {}));
        REQUIRE(PatchConstants(constants, size.neuralMip, GetDemandedRow(table, row)));
        float expected[16], sampled[16];
        REQUIRE(DecodeReference({&*whole, latents, *weights, set.GetNetworkVersion()}, mip, {x, y, 1, 1}, {},
                                expected));
        const Expected<void> decoded = DecodeReference(
            {&constants, pool.Get(), *weights, set.GetNetworkVersion()}, mip, {x, y, 1, 1}, {}, sampled);
        REQUIRE_MESSAGE(decoded.has_value(), ToText(synthesis)
                                                 << ": " << std::string(decoded.error().GetText()));
        REQUIRE_MESSAGE(std::memcmp(expected, sampled, sizeof(expected)) == 0,
                        ToText(synthesis) << ": texel " << x << "," << y << " of mip " << mip << ", tiles of "
                                          << layout.GetTileWidth() << "x" << layout.GetTileHeight());
    }
}

} // namespace

TEST_CASE("demand case 47: any texel from any slice tile equals the decode of the whole set") {
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("seed: " << seed);
    SliceRandom random(seed);
    const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                       ("openntc_demand_slices_" + std::to_string(seed % 1000000) + ".ntc");
    for (int i = 0; i < 80; ++i) {
        const SynthesisDesc synthesis = i < 40 ? PickSet(random, 120) : PickLayeredSet(random, 120);
        const std::vector<std::byte> file = MakeFile(synthesis);
        const int tileWidth = random.Pick(1, 24), tileHeight = random.Pick(1, 24);
        ReadOnlyMemoryStream stream(file);
        if (i % 3 == 2) {
            std::ofstream(path, std::ios::binary)
                .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
        }
        auto source = i % 3 == 0   ? TextureSetTileSource::OpenMemory(file, tileWidth, tileHeight)
                      : i % 3 == 1 ? TextureSetTileSource::OpenStream(stream, tileWidth, tileHeight)
                                   : TextureSetTileSource::OpenFile(path, tileWidth, tileHeight);
        REQUIRE_MESSAGE(source.has_value(), ToText(synthesis)
                                                << ": " << std::string(source.error().GetText()));
        CheckDemandedSet(random, synthesis, *source, file, i % 2 == 0 ? 0 : 3, 100);
    }
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
}

TEST_CASE("demand: a file opened twice is one source, by any path, until it is written again") {
    SliceRandom random(6);
    const std::vector<std::byte> file = MakeFile(PickSet(random, 60));
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() /
        ("openntc_identity_" + std::to_string(openntc::test::GetTestSeed() % 1000000));
    std::filesystem::create_directories(folder);
    const auto write = [&](const char* name, std::size_t more) {
        std::ofstream out(folder / name, std::ios::binary);
        out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
        out << std::string(more, ' ');
    };
    const auto open = [&](const std::filesystem::path& path, int tileWidth = 16) {
        auto source = TextureSetTileSource::OpenFile(path, tileWidth, 16);
        REQUIRE_MESSAGE(source.has_value(), std::string(source ? "" : source.error().GetText()));
        return *source;
    };
    write("a.ntc", 0);
    write("b.ntc", 0);
    const auto first = open(folder / "a.ntc");
    CHECK(IsSameSource(*first, *open(folder / "a.ntc")));
    CHECK(IsSameSource(*first, *open(folder / "." / "a.ntc")));
    CHECK_FALSE(IsSameSource(*first, *open(folder / "a.ntc", 8)));
    CHECK_FALSE(IsSameSource(*first, *open(folder / "b.ntc")));
    const auto inMemory = TextureSetTileSource::OpenMemory(file, 16, 16);
    REQUIRE(inMemory.has_value());
    CHECK_FALSE(IsSameSource(*first, **inMemory));
    write("a.ntc", 3); // nothing that the set needs
    CHECK_FALSE(IsSameSource(*first, *open(folder / "a.ntc")));
    const auto missing = MakeFileIdentity(folder / "none");
    REQUIRE(missing.has_value());
    CHECK(missing->empty());
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
}

TEST_CASE("demand: a texture set cut short after its description: an error of each tile, not of the others") {
    SliceRandom random(5);
    SynthesisDesc synthesis = PickSet(random, 60);
    synthesis.desc = {64, 64, 4, 7};
    std::vector<std::byte> file = MakeFile(synthesis);
    class CutStream final : public Stream {
    public:
        explicit CutStream(std::span<const std::byte> bytes) : inner_(bytes) {}
        bool Read(void* destination, std::size_t bytes) noexcept override {
            return inner_.Tell() + bytes <= limit && inner_.Read(destination, bytes);
        }
        bool Write(const void*, std::size_t) noexcept override { return false; }
        bool Seek(std::uint64_t offset) noexcept override { return inner_.Seek(offset); }
        std::uint64_t Tell() noexcept override { return inner_.Tell(); }
        std::uint64_t Size() noexcept override { return inner_.Size(); }
        std::uint64_t limit = ~std::uint64_t{0};

    private:
        ReadOnlyMemoryStream inner_;
    } stream(file);
    auto source = TextureSetTileSource::OpenStream(stream, 4, 4);
    REQUIRE(source.has_value());
    const LatentGrid& finest = (*source)->GetMetadata().GetLatentImages()[0].highRes;
    stream.limit = finest.offset + finest.size / 2;
    std::vector<std::byte> tile((*source)->GetLargestTileBytes());
    CHECK((*source)->ReadTile(0, tile, {}).error().GetStatus() == Status::IOError);
    stream.limit = ~std::uint64_t{0};
    CHECK((*source)->ReadTile(0, tile, {}).has_value());
    CHECK((*source)->ReadTile(0, std::span(tile).first(1), {}).error().GetStatus() == Status::OutOfRange);
    CHECK((*source)
              ->ReadTile(static_cast<std::uint32_t>((*source)->GetLayout().GetTileCount()), tile, {})
              .error()
              .GetStatus() == Status::OutOfRange);
    CHECK(TextureSetTileSource::OpenFile("no such file", 8, 8).error().GetStatus() ==
          Status::FileUnavailable);
    CHECK(TextureSetTileSource::OpenMemory({}, 8, 8).error().GetStatus() == Status::IOError);
    CHECK(TextureSetTileSource::OpenMemory(file, 0, 8).error().GetStatus() == Status::OutOfRange);
}
