// SPDX-License-Identifier: MIT
// VK_NV_memory_decompression: what the device makes of compressed latents are the bytes of the CPU.
#include "conformance/ConformanceFolder.h"
#include "shader/TestDevice.h"
#include "support/CompressedSets.h"
#include "support/Files.h"
#include "vulkan_harness/LatentDecompression.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

using Bytes = std::vector<std::byte>;

bool Decompresses(const Context& context) {
    const std::string& absence = context.GetDevice().features.GetAbsence(Feature::MemoryDecompression);
    if (!absence.empty())
        MESSAGE("SKIP: decompression on " << context.GetDevice().name << ": " << absence);
    return absence.empty();
}

Buffer MakeBuffer(Context& context, std::uint64_t bytes) {
    auto buffer = context.CreateBuffer(bytes, BufferKind::Storage, BufferMemory::DeviceLocal);
    REQUIRE_MESSAGE(buffer, std::string(buffer.error().GetText()));
    return std::move(*buffer);
}

/// Latents of all mips.
Bytes DecompressOnDevice(Context& context, LatentDecompressor& decompressor, const Bytes& file) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const auto plan = PlanLatentDecompression(*set, stream, 0, set->GetDesc().mips);
    REQUIRE_MESSAGE(plan, std::string(plan.error().GetText()));
    Bytes upload(static_cast<std::size_t>(plan->uploadBytes));
    REQUIRE(ReadLatentUploads(*plan, stream, upload));
    const Buffer work = MakeBuffer(context, plan->workBytes);
    const Buffer latents = MakeBuffer(context, plan->latentBytes);
    REQUIRE(context.Write(work, 0, upload));
    decompressor.Clear();
    REQUIRE(decompressor.Add(*plan, work, latents));
    const auto seconds = decompressor.Run();
    REQUIRE_MESSAGE(seconds, std::string(seconds.error().GetText()));
    Bytes result(static_cast<std::size_t>(plan->latentBytes));
    REQUIRE(context.Read(latents, 0, result));
    return result;
}

Bytes ReadOnCpu(const Bytes& file) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    const int mips = set->GetDesc().mips;
    Bytes latents(*GetLatentBufferBytes(*set, 0, mips));
    REQUIRE(ReadLatents(*set, stream, 0, mips, latents));
    return latents;
}

} // namespace

TEST_CASE("decompression on the device, by itself and by a shader: the bytes of ReadLatents, of every kind "
          "of tile") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const TileDecoder decoder : {TileDecoder::Device, TileDecoder::Shader}) {
        if (decoder == TileDecoder::Device && !Decompresses(*context))
            continue;
        CAPTURE(static_cast<int>(decoder));
        auto decompressor = LatentDecompressor::Create(*context, decoder);
        REQUIRE_MESSAGE(decompressor, std::string(decompressor.error().GetText()));
        for (const CompressedSetDesc& desc : ListCompressedSets()) {
            CAPTURE(desc.width);
            CAPTURE(desc.height);
            CAPTURE(static_cast<int>(desc.latents));
            CAPTURE(desc.extraBytes);
            CAPTURE(desc.gap);
            const Bytes file = MakeCompressedSet(desc);
            CHECK(DecompressOnDevice(*context, *decompressor, file) == ReadOnCpu(file));
        }
        const std::vector<std::string> names = ListGeneration3Sets();
        for (const std::string& name : names) {
            CAPTURE(name);
            const Bytes file = ReadBytes(GetConformanceFolder() / (name + ".ntc"));
            CHECK(DecompressOnDevice(*context, *decompressor, file) == ReadOnCpu(file));
        }
        if (names.empty())
            MESSAGE("SKIP: no files of LibNTC 0.9.2");
    }
}

TEST_CASE("decompression by a shader: tiles that are corrupt are counted") {
    OPENNTC_REQUIRE_DEVICE(context);
    auto decompressor = LatentDecompressor::Create(*context, TileDecoder::Shader);
    REQUIRE(decompressor);
    LatentDecompression plan;
    plan.uploadBytes = plan.workBytes = 256;
    plan.latentBytes = 64;
    REQUIRE(plan.tiles.PushBack({0, 0, 128, 32, false}));
    REQUIRE(plan.tiles.PushBack({128, 32, 128, 32, false}));
    const Buffer work = MakeBuffer(*context, 256); // zeros: blocks of nothing, without an end
    const Buffer latents = MakeBuffer(*context, 64);
    REQUIRE(decompressor->Add(plan, work, latents));
    const auto seconds = decompressor->Run();
    REQUIRE_FALSE(seconds);
    CHECK(seconds.error().GetStatus() == Status::FileUnrecognized);
    CHECK(std::string(seconds.error().GetText()) == "GDeflate: 2 tiles: corrupt");
}

TEST_CASE("decompression on the device: refused without the feature, and where a tile does not fit") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Buffer buffer = MakeBuffer(*context, 1024);
    const DecompressedTile fits{&buffer, 0, 128, &buffer, 512, 64};
    const auto tryTile = [&](const DecompressedTile& tile) {
        const auto timing = context->Decompress(std::span(&tile, 1), {});
        REQUIRE_FALSE(timing);
        return timing.error().GetStatus();
    };
    if (!context->GetDevice().features.Has(Feature::MemoryDecompression)) {
        CHECK(tryTile(fits) == Status::Unsupported);
        return;
    }
    DecompressedTile tile = fits;
    tile.sourceOffset = 2;
    CHECK(tryTile(tile) == Status::OutOfRange);
    tile = fits;
    tile.destinationOffset = 514;
    CHECK(tryTile(tile) == Status::OutOfRange);
    tile = fits;
    tile.bytes = 516;
    CHECK(tryTile(tile) == Status::OutOfRange);
    tile = fits;
    tile.sourceBytes = 1028;
    CHECK(tryTile(tile) == Status::OutOfRange);
    tile = fits;
    tile.bytes = 0;
    CHECK(tryTile(tile) == Status::OutOfRange);
    const BufferCopy copy{&buffer, 1000, &buffer, 0, 28};
    const auto timing = context->Decompress({}, std::span(&copy, 1));
    REQUIRE_FALSE(timing);
    CHECK(timing.error().GetStatus() == Status::OutOfRange);
}
