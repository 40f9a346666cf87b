// SPDX-License-Identifier: MIT
// Plans for devices that decompress GDeflate tiles: run on the CPU they give what ReadLatents gives, and whatever a file
// says, no tile and no copy leaves its buffers.
#include "conformance/ConformanceFolder.h"
#include "support/CompressedSets.h"
#include "support/CountingAllocator.h"
#include "support/Files.h"

#include "openntc/inference/LatentDecompression.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

using Bytes = std::vector<std::byte>;

bool IsInside(std::uint64_t offset, std::uint64_t bytes, std::uint64_t size) {
    return offset <= size && bytes <= size - offset;
}

/// What devices ask for: alignment, sizes, ranges inside their buffers, nothing written twice.
std::string FindViolation(const LatentDecompression& plan, std::uint64_t fileBytes) {
    if (plan.uploadBytes % 4 != 0 || plan.workBytes % 4 != 0 || plan.uploadBytes > plan.workBytes)
        return "sizes";
    constexpr std::uint64_t kLayers = 12; // of the sets here, at most
    if (plan.workBytes > 3 * plan.latentBytes + kLayers * (192 << 10))
        return "the size of the work buffer";
    std::uint64_t end = 0;
    for (const LatentUpload& upload : plan.uploads) {
        if (upload.destination < end || !IsInside(upload.destination, upload.range.size, plan.uploadBytes) ||
            !IsInside(upload.range.offset, upload.range.size, fileBytes))
            return "an upload";
        end = upload.destination + upload.range.size;
    }
    std::vector<std::pair<std::uint64_t, std::uint64_t>> written[2]; // in the latents, in the work buffer
    for (const LatentTile& tile : plan.tiles) {
        if (tile.source % 4 != 0 || tile.destination % 4 != 0 || tile.sourceBytes % 4 != 0)
            return "a tile's alignment";
        if (tile.sourceBytes < 128 || tile.sourceBytes > container::kMaxGDeflateTileBytes || tile.bytes < 1 ||
            tile.bytes > container::kGDeflateTileBytes)
            return "a tile's size";
        if (!IsInside(tile.source, tile.sourceBytes, plan.uploadBytes) ||
            !IsInside(tile.destination, tile.bytes, tile.isInWork ? plan.workBytes : plan.latentBytes) ||
            (tile.isInWork && tile.destination < plan.uploadBytes))
            return "a tile's range";
        written[tile.isInWork].emplace_back(tile.destination, tile.destination + tile.bytes);
    }
    for (const LatentCopy& copy : plan.copies) {
        if (!IsInside(copy.source, copy.bytes, plan.workBytes) ||
            !IsInside(copy.destination, copy.bytes, plan.latentBytes))
            return "a copy's range";
        written[0].emplace_back(copy.destination, copy.destination + copy.bytes);
    }
    for (auto& ranges : written) {
        std::sort(ranges.begin(), ranges.end());
        for (std::size_t i = 1; i < ranges.size(); ++i)
            if (ranges[i - 1].second > ranges[i].first)
                return "bytes written twice";
    }
    return {};
}

/// The latents, or what is wrong.
std::string RunOnCpu(const Bytes& file, int firstMip, int numMips, Bytes& latents) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    if (!set)
        return set.error().GetText();
    const auto plan = PlanLatentDecompression(*set, stream, firstMip, numMips);
    if (!plan)
        return plan.error().GetText();
    if (const std::string violation = FindViolation(*plan, file.size()); !violation.empty())
        return "VIOLATION: " + violation;
    Bytes work(static_cast<std::size_t>(plan->workBytes), std::byte{0xCD});
    if (const auto read = ReadLatentUploads(
            *plan, stream, std::span(work).first(static_cast<std::size_t>(plan->uploadBytes)));
        !read)
        return read.error().GetText();
    latents.assign(static_cast<std::size_t>(plan->latentBytes), std::byte{0});
    // A device may take tiles in any order.
    for (std::size_t i = plan->tiles.size(); i-- > 0;)
        if (const auto done =
                DecompressLatentTile(plan->tiles[i], work, latents, static_cast<std::uint32_t>(i));
            !done)
            return done.error().GetText();
    CopyLatents(*plan, work, latents);
    return {};
}

Bytes ReadExpected(const Bytes& file, int firstMip, int numMips) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    Bytes latents(*GetLatentBufferBytes(*set, firstMip, numMips));
    const auto read = ReadLatents(*set, stream, firstMip, numMips, latents);
    REQUIRE_MESSAGE(read, std::string(read.error().GetText()));
    return latents;
}

LatentDecompression MakePlan(const Bytes& file) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    auto plan = PlanLatentDecompression(*set, stream, 0, set->GetDesc().mips);
    REQUIRE_MESSAGE(plan, std::string(plan.error().GetText()));
    return std::move(*plan);
}

} // namespace

TEST_CASE("latent decompression: plans give the bytes of ReadLatents, tile by tile") {
    for (const CompressedSetDesc& desc : ListCompressedSets()) {
        CAPTURE(desc.width);
        CAPTURE(desc.height);
        CAPTURE(desc.extraBytes);
        CAPTURE(desc.gap);
        const Bytes file = MakeCompressedSet(desc);
        for (const int first : {0, 2}) {
            Bytes latents;
            CHECK(RunOnCpu(file, first, 3 - first, latents) == "");
            CHECK(latents == ReadExpected(file, first, 3 - first));
        }
    }
}

TEST_CASE("latent decompression: what suits a device goes straight to its place") {
    // 128 x 256 texels in three layers and 64 x 128 ones: every tile is whole words.
    const LatentDecompression whole = MakePlan(MakeCompressedSet({1024, 512, LatentBytes::Few}));
    CHECK(whole.copies.empty());
    CHECK(whole.workBytes == whole.uploadBytes);
    CHECK(whole.uploads.size() <= whole.tiles.size());
    for (const LatentTile& tile : whole.tiles)
        CHECK_FALSE(tile.isInWork);
    // Layers of 73794 bytes: the second one begins between words, the first and the third do not.
    const LatentDecompression odd = MakePlan(MakeCompressedSet({1004, 588, LatentBytes::Few}));
    REQUIRE(odd.tiles.size() >= 6);
    for (std::size_t i = 0; i < 6; ++i)
        CHECK(odd.tiles[i].isInWork == (i / 2 == 1));
    CHECK(odd.tiles[1].bytes == 73794 - 65536);
    // One upload a layer, since its tiles follow one another; one a tile where they are off the grid of words.
    const Bytes tiles = MakeCompressedSet({1024, 1536, LatentBytes::Few});
    const Bytes moved = MakeCompressedSet({1024, 1536, LatentBytes::Few, 0, 1});
    CHECK(MakePlan(tiles).uploads.size() < MakePlan(tiles).tiles.size());
    CHECK(MakePlan(moved).uploads.size() == MakePlan(moved).tiles.size());
}

TEST_CASE("latent decompression: sets without compression are copies") {
    SynthesisDesc synthesis;
    synthesis.desc = {100, 60, 6, 4};
    for (const int version : {NTC_NETWORK_SMALL, NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        CAPTURE(version);
        synthesis.networkVersion = version;
        synthesis.shape = GetGeneration(version) == 1 ? GetV1().synthesis.shape : MakeLayeredShape(4, 12);
        const Bytes file = MakeFile(synthesis);
        CHECK(MakePlan(file).tiles.empty());
        Bytes latents;
        CHECK(RunOnCpu(file, 1, 3, latents) == "");
        CHECK(latents == ReadExpected(file, 1, 3));
    }
}

TEST_CASE("latent decompression: files of LibNTC 0.9.2") {
    const std::vector<std::string> names = ListGeneration3Sets();
    for (const std::string& name : names) {
        CAPTURE(name);
        const Bytes file = ReadBytes(GetConformanceFolder() / (name + ".ntc"));
        ReadOnlyMemoryStream stream(file);
        const int mips = TextureSetMetadata::Load(stream)->GetDesc().mips;
        Bytes latents;
        CHECK(RunOnCpu(file, 0, mips, latents) == "");
        CHECK(latents == ReadExpected(file, 0, mips));
    }
    if (names.empty())
        MESSAGE("SKIP: no files of LibNTC 0.9.2");
}

TEST_CASE("latent decompression: hostile headers and tables are refused, or harmless") {
    for (const CompressedSetDesc& desc :
         {CompressedSetDesc{1004, 588, LatentBytes::Few}, CompressedSetDesc{64, 64, LatentBytes::Repeated},
          CompressedSetDesc{1024, 512, LatentBytes::Noise, 70000}}) {
        const Bytes base = MakeCompressedSet(desc);
        ReadOnlyMemoryStream stream(base);
        const auto set = TextureSetMetadata::Load(stream);
        REQUIRE(set);
        const StoredData& data = set->GetLatentMips()[0].layerData[0];
        const auto header = *container::DecodeGDeflateHeader(
            std::span(base).subspan(static_cast<std::size_t>(data.range.offset)));
        Bytes file = base;
        int refused = 0;
        for (std::size_t i = 0; i < header.GetTableBytes() + 16; ++i) {
            std::byte& byte = file[static_cast<std::size_t>(data.range.offset) + i];
            const std::byte right = byte;
            for (const int value : {0, 1, 128, 255}) {
                byte = static_cast<std::byte>(value);
                Bytes latents;
                const std::string error = RunOnCpu(file, 0, 3, latents);
                CHECK_MESSAGE(error.find("VIOLATION") == std::string::npos, error);
                refused += error.empty() ? 0 : 1;
            }
            byte = right;
        }
        CHECK(refused > 0);
    }
}

TEST_CASE("latent decompression: every allocation may fail, and the size of an upload is checked") {
    const Bytes file = MakeCompressedSet({1004, 588, LatentBytes::Few});
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    openntc::test::CountingAllocator counting;
    { // the plan's memory is the allocator's
        const auto plan = PlanLatentDecompression(*set, stream, 0, 3, counting);
        REQUIRE(plan);
        Bytes upload(static_cast<std::size_t>(plan->uploadBytes) - 4);
        const auto read = ReadLatentUploads(*plan, stream, upload);
        REQUIRE_FALSE(read);
        CHECK(read.error().GetStatus() == Status::InvalidArgument);
    }
    CHECK(counting.GetUsedBytes() == 0);
    REQUIRE(counting.GetAllocationCount() > 0);
    for (std::size_t n = 0; n < counting.GetAllocationCount(); ++n) {
        openntc::test::CountingAllocator failing;
        failing.FailAt(n);
        const auto plan = PlanLatentDecompression(*set, stream, 0, 3, failing);
        REQUIRE_FALSE(plan);
        CHECK(plan.error().GetStatus() == Status::OutOfMemory);
        CHECK(failing.GetUsedBytes() == 0);
    }
}
