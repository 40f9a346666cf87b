// SPDX-License-Identifier: MIT
// Sets of generations 2 and 3: what is loaded, what is refused, and what is written again. No file of generation 2 was at
// hand: its sets are made by the project's own writer from the format specification.
#include "EditedFile.h"
#include "RewrittenFile.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/ReadLatents.h"
#include "support/CountingAllocator.h"
#include "support/Files.h"

#include <cstring>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// 96 x 80, 12 features in grids of 24 x 20, 12 x 10, 6 x 5 and 3 x 2.
SynthesisDesc GetLayered(int version) {
    SynthesisDesc synthesis;
    synthesis.seed = 7;
    synthesis.desc = {96, 80, 6, 7};
    synthesis.networkVersion = version;
    synthesis.shape = MakeLayeredShape(4, 12);
    synthesis.withFP8 = true;
    return synthesis;
}

SynthesisDesc GetCompressed() {
    SynthesisDesc synthesis = GetLayered(NTC_NETWORK_GENERATION_3);
    synthesis.desc = {640, 640, 6, 3}; // layers of 51200 bytes, and of 12800
    synthesis.compression.latents = true;
    synthesis.compression.largestRatio = 2.0f; // noise does not shrink
    synthesis.compression.level = 1;
    return synthesis;
}

EditedFile Edit(int version) {
    return EditedFile(MakeFile(GetLayered(version)));
}

std::vector<std::byte> ReadAllLatents(const std::vector<std::byte>& file,
                                      Allocator& allocator = GetDefaultAllocator()) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const int mips = set->GetDesc().mips;
    std::vector<std::byte> latents(*GetLatentBufferBytes(*set, 0, mips));
    const auto read = ReadLatents(*set, stream, 0, mips, latents, allocator);
    REQUIRE_MESSAGE(read, std::string(read.error().GetText()));
    return latents;
}

std::string FailToReadLatents(const std::vector<std::byte>& file) {
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    std::vector<std::byte> latents(*GetLatentBufferBytes(*set, 0, 1));
    const auto read = ReadLatents(*set, stream, 0, 1, latents);
    return read ? "" : read.error().GetText();
}

} // namespace

TEST_CASE("generations 2 and 3: shape, latent mips, positions and weights of a loaded set") {
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        CAPTURE(version);
        const auto set = Edit(version).Load();
        REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
        CHECK(set->GetGeneration() == GetGeneration(version));
        CHECK(set->GetNetworkVersion() == version);
        CHECK(set->GetLatentShape() == MakeLayeredShape(4, 12));
        CHECK(set->GetLatentImages().empty());
        REQUIRE(set->GetLatentMips().size() == 4);
        CHECK(set->GetLatentMips()[2].width == 6);
        CHECK(set->GetLatentMips()[2].height == 5);
        CHECK(set->GetLatentMips()[2].layers == 3);
        CHECK(set->GetLatentMips()[3].height == 2);
        const int latentMips[] = {0, 0, 0, 2, 2, 2, 2};
        for (std::size_t mip = 0; mip < 7; ++mip)
            CHECK(set->GetColorMips()[mip].neuralMip == latentMips[mip]);
        CHECK(set->GetColorMips()[0].positionScale == 0.125f);
        CHECK(set->GetColorMips()[0].positionLod == -0.75f);
        const NetworkDescription network = GetNetworkDescription(version);
        CHECK(set->GetWeights().int8.size() == static_cast<std::size_t>(network.int8Bytes));
        CHECK(set->GetWeights().fp8.size() == static_cast<std::size_t>(network.fp8Bytes));
        CHECK(set->GetFusedMipLevels(4) == MipRange{3, 6});
        CHECK(set->GetMipLevelsForLatentImage(2) == MipRange{3, 6});
        CHECK_FALSE(set->GetMipLevelsForLatentImage(1));
        CHECK(set->GetLatentsOfMips(0, 7) == MipRange{0, 3});
        CHECK(set->GetLatentsOfMips(1, 2) == MipRange{0, 1});
        CHECK(set->GetLatentsOfMips(4, 1) == MipRange{2, 3});
        const LatentMip& last = set->GetLatentMips()[3];
        const StreamRange range = *set->GetStreamRangeForLatents(3, 4);
        CHECK(range.offset == set->GetLatentMips()[2].layerData[0].range.offset);
        CHECK(range.offset + range.size == last.layerData[2].range.offset + 12);
    }
}

TEST_CASE("generations 2 and 3: constants of the latents that are read") {
    const auto set = Edit(NTC_NETWORK_GENERATION_3).Load();
    REQUIRE(set);
    const auto constants = MakeInferenceData(*set, 3, 2, InferenceWeightType::GenericInt8);
    REQUIRE(constants);
    CHECK(constants->highResEncoding.numFeatures == 12);
    CHECK(constants->highResEncoding.quantBits == 4);
    CHECK(constants->highResEncoding.logElementsPerUint == 3);
    CHECK(constants->highResEncoding.addressMask == 7);
    CHECK(constants->highResEncoding.dataMask == 15);
    CHECK(constants->highResEncoding.quantizedScale == 0);
    CHECK(std::memcmp(&constants->highResEncoding, &constants->lowResEncoding,
                      sizeof(NtcLatentEncodingConstants)) == 0);
    CHECK(constants->highResNeuralMips[0].sliceWidthHeight == 0);
    CHECK(constants->highResNeuralMips[2].dataOffset == 0);
    CHECK(constants->highResNeuralMips[2].imageWidthHeight == (6u | 5u << 16));
    CHECK(constants->lowResNeuralMips[2].dataOffset == 180); // 6 x 5 x 3 texels
    CHECK(constants->lowResNeuralMips[2].imageWidthHeight == (3u | 2u << 16));
    CHECK(constants->highResNeuralMips[3].dataOffset == 180);
    CHECK(constants->lowResNeuralMips[3].sliceWidthHeight == 0);
    CHECK(constants->colorMips[3].neuralMip == 2);
    CHECK(constants->networkScaleBiasOffset == 8192);
    CHECK(*GetLatentBufferBytes(*set, 3, 2) == 180 + 36);
    CHECK_FALSE(MakeInferenceData(*set, 3, 5, InferenceWeightType::GenericInt8));
    const auto wrong = MakeInferenceData(*set, StreamRange{}, InferenceWeightType::GenericInt8);
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().GetStatus() == Status::Unsupported);

    const auto textures = MakeTextureConstants(*set, InferenceWeightType::GenericFP8);
    REQUIRE(textures);
    CHECK(textures->networkWeightOffset3 == 7680);
    CHECK(textures->networkBiasOffset3 == 8544);
    CHECK(textures->networkScaleOffset3 == 8480);
    CHECK(textures->networkScaleOffset0 == 0);
    CHECK(textures->imageWidth == 96);
    CHECK(textures->validChannelMask == 0x3F);
    CHECK_FALSE(MakeTextureConstants(*EditV1().Load(), InferenceWeightType::GenericInt8));
}

TEST_CASE("generations 2 and 3: latents are the layers of the file, one after the other") {
    const std::vector<std::byte> second = ReadAllLatents(MakeFile(GetLayered(NTC_NETWORK_GENERATION_2)));
    const std::vector<std::byte> third = ReadAllLatents(MakeFile(GetLayered(NTC_NETWORK_GENERATION_3)));
    REQUIRE(second.size() == 2 * 3 * (480 + 120 + 30 + 6));
    CHECK(second.size() == third.size());
    EditedFile file = Edit(NTC_NETWORK_GENERATION_2);
    const auto set = file.Load();
    const std::vector<std::byte> whole = file.Build();
    const StreamRange first = set->GetLatentMips()[0].layerData[0].range;
    CHECK(std::memcmp(second.data(), whole.data() + first.offset, 2 * 3 * 480) == 0);
}

TEST_CASE("generation 3: compressed latents are those that are not; memory does not follow the file") {
    SynthesisDesc plain = GetCompressed();
    plain.compression.latents = false;
    const std::vector<std::byte> file = MakeFile(GetCompressed());
    CHECK(EditedFile(file).json.find("\"compression\":\"GDeflate\",\"uncompressedSize\":153600") ==
          std::string::npos);
    CHECK(EditedFile(file).json.find("\"compression\":\"GDeflate\",\"uncompressedSize\":51200,\"crc32\":") !=
          std::string::npos);
    openntc::test::CountingAllocator counting;
    CHECK(ReadAllLatents(file, counting) == ReadAllLatents(MakeFile(plain)));
    CHECK(counting.GetUsedBytes() == 0);
    CHECK(counting.GetPeakBytes() <= 192u << 10);
    // Not worth it with LibNTC's limit.
    SynthesisDesc usual = GetCompressed();
    usual.compression.largestRatio = 0.95f;
    CHECK(MakeFile(usual) == MakeFile(plain));
}

TEST_CASE("generation 3: compressed latents that are corrupt are refused when they are read") {
    const EditedFile file(MakeFile(GetCompressed()));
    CHECK(FailToReadLatents(file.Build()).empty());
    EditedFile crc = file;
    const std::size_t at = crc.json.find("\"crc32\":") + 8;
    crc.json.replace(at, crc.json.find('}', at) - at, "1");
    CHECK(FailToReadLatents(crc.Build()).find("latents: crc32: ") == 0);
    EditedFile unchecked = file;
    unchecked.json.replace(at, unchecked.json.find('}', at) - at, "0");
    CHECK(FailToReadLatents(unchecked.Build()).empty());
    // The format defines the number for compressed views alone.
    EditedFile stored = Edit(NTC_NETWORK_GENERATION_3);
    const std::size_t size = stored.json.rfind("\"storedSize\":");
    REQUIRE(size != std::string::npos);
    stored.json.insert(stored.json.find('}', size), ",\"crc32\":5");
    CHECK(FailToReadLatents(stored.Build()).empty());
    EditedFile larger = file;
    CHECK(FailToReadLatents(
              larger.Replace("\"uncompressedSize\":51200", "\"uncompressedSize\":51201").Build()) ==
          "latents: uncompressedSize: 51201: the GDeflate stream has 51200");
    const auto set = file.Load();
    const std::uint64_t chunk = file.Build().size() - file.binary.size();
    EditedFile broken = file;
    broken.Store(static_cast<std::size_t>(set->GetLatentMips()[0].layerData[0].range.offset - chunk),
                 std::uint8_t{7});
    CHECK(FailToReadLatents(broken.Build()) == "GDeflate: id 7, 251: must be 4, 251");
    // A view as large as its table does not have to be read.
    EditedFile small = file;
    small.Replace("\"uncompressedSize\":51200", "\"uncompressedSize\":51199");
    small.CheckRefused(Status::FileUnrecognized, "uncompressedSize: 51199: needs at least 51200 bytes");
    EditedFile absent = file;
    absent.Replace("\"uncompressedSize\":51200,", "");
    absent.CheckRefused(Status::FileUnrecognized, "uncompressedSize: 0: needs at least 51200 bytes");
}

TEST_CASE("generations 2 and 3: contradictions are refused by name") {
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        CAPTURE(version);
        const EditedFile file = Edit(version);
        const auto refuse = [&](std::string_view from, std::string_view to, Status status,
                                std::string_view text) {
            EditedFile edited = file;
            edited.Replace(from, to).CheckRefused(status, text);
        };
        refuse("\"numFeatures\":12", "\"numFeatures\":20", Status::OutOfRange, "latentShape.numFeatures: 20");
        refuse("\"numFeatures\":12", "\"numFeatures\":6", Status::OutOfRange, "latentShape.numFeatures: 6");
        refuse("\"numFeatures\":12", "\"numFeatures\":8", Status::FileUnrecognized, "latentShape gives 2");
        refuse("\"width\":12,\"height\":10", "\"width\":12,\"height\":11", Status::FileUnrecognized,
               "latents[1]: 12 x 11: must be 12 x 10");
        refuse("\"width\":24,\"height\":20", "\"width\":25,\"height\":20", Status::FileUnrecognized,
               "needs at least");
        refuse("\"width\":24,\"height\":20", "\"width\":0,\"height\":20", Status::OutOfRange,
               "latents[0]: 0 x 20");
        refuse("\"latentMip\":2", "\"latentMip\":3", Status::FileUnrecognized, "colorMips[3].latentMip: 3");
        refuse("\"positionScale\":0.125", "\"positionScale\":3e38", Status::FileUnrecognized,
               "colorMips[0].positionScale");
        refuse("\"mlpVersions\"", "\"unknown\"", Status::FileUnrecognized, "mlpVersions: absent");
        refuse("\"inputChannels\":48", "\"inputChannels\":64", Status::FileUnrecognized,
               "mlpVersions[0].layers[0]: 64 x 64");
        refuse("\"outputChannels\":16", "\"outputChannels\":15", Status::FileUnrecognized,
               "mlpVersions[0].layers[3]");
        refuse("\"biasType\":\"Int32\"", "\"biasType\":\"Float32\"", Status::FileUnrecognized,
               "mlpVersions[0].layers[0]: types");
        refuse("\"weightLayout\":\"RowMajor\"", "\"x\":0", Status::FileUnrecognized, "weightLayout: absent");
    }
    EditedFile second = Edit(NTC_NETWORK_GENERATION_2);
    second.Replace("\"arraySize\":3", "\"arraySize\":4")
        .CheckRefused(Status::FileUnrecognized, "latents[0].arraySize: 4");
    EditedFile third = Edit(NTC_NETWORK_GENERATION_3);
    third
        .Replace("{\"offset\":0,\"storedSize\":3072}",
                 "{\"offset\":0,\"storedSize\":3072,\"compression\":\"GDeflate\"}")
        .CheckRefused(Status::FileUnrecognized, "views[0].compression: GDeflate: only latents and BC7 modes");
}

TEST_CASE("generations 2 and 3: one latent mip is not enough") {
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        EditedFile file = Edit(version);
        const std::size_t begin = file.json.find("\"latents\":[") + 11;
        const std::size_t end = file.json.find("},", begin);
        file.json.replace(begin, file.json.find("}]", begin) - begin, file.json.substr(begin, end - begin));
        file.CheckRefused(Status::FileUnrecognized, "latents: 1: a colour mip is decoded from two");
    }
}

// What a file leaves out of the channels between layers counts as weights of 0, scales of 1 and biases of 0.
TEST_CASE("generation 3: networks with fewer hidden channels fill the buffers with zeros") {
    EditedFile file = Edit(NTC_NETWORK_GENERATION_3);
    const auto whole = file.Load();
    REQUIRE(whole);
    file.Replace("\"inputChannels\":64,\"outputChannels\":48", "\"inputChannels\":60,\"outputChannels\":40");
    const auto set = file.Load();
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const std::byte* const weights = set->GetWeights().int8.data();
    const std::byte* const stored = whole->GetWeights().int8.data() + 3072;
    for (std::size_t row = 0; row < 48; ++row) {
        for (std::size_t column = 0; column < 64; ++column) {
            const std::byte expected = row < 40 && column < 60 ? stored[row * 60 + column]
                                                               : std::byte{0}; // rows of the file are shorter
            REQUIRE(weights[3072 + row * 64 + column] == expected);
        }
        const float scale = detail::LoadScalar<float>(weights + 8448 + 4 * row);
        const auto bias = detail::LoadScalar<std::int32_t>(weights + 9088 + 4 * row);
        CHECK((row < 40) == (scale != 1.0f));
        if (row >= 40)
            CHECK(bias == 0);
    }
    // The FP8 network is whole still, and what precedes and follows the layer too.
    CHECK(std::memcmp(set->GetWeights().fp8.data(), whole->GetWeights().fp8.data(), 8608) == 0);
    CHECK(std::memcmp(weights, whole->GetWeights().int8.data(), 3072) == 0);
    CHECK(std::memcmp(weights + 6144, whole->GetWeights().int8.data() + 6144, 2304) == 0);
    EditedFile second = Edit(NTC_NETWORK_GENERATION_2);
    second.Replace("\"inputChannels\":64,\"outputChannels\":64", "\"inputChannels\":60,\"outputChannels\":64")
        .CheckRefused(Status::FileUnrecognized,
                      "mlpVersions[0].layers[1]: 60 x 64: must be 64 x 64 in a gen2 network");
}

TEST_CASE("generations 2 and 3: a set written again is the same file, compressed or not") {
    for (const SynthesisDesc& desc :
         {GetLayered(NTC_NETWORK_GENERATION_2), GetLayered(NTC_NETWORK_GENERATION_3), GetCompressed()}) {
        const std::vector<std::byte> file = MakeFile(desc);
        CHECK(Rewrite(file) == Rewrite(Rewrite(file)));
        CHECK(file.size() % 4 == 0);
        CHECK(ReadAllLatents(file) == ReadAllLatents(Rewrite(file)));
    }
    int files = 0;
    for (const char* name : {"v092-bricks-f8.ntc", "v092-hdr-hlg.ntc", "v092-helmet-leather-4bpp.ntc"}) {
        const std::vector<std::byte> file = ReadBytes(GetConformanceFolder() / name);
        if (file.empty())
            continue;
        CAPTURE(name);
        CHECK(Rewrite(file) == file); // LibNTC 0.9.2's, byte for byte
        ++files;
    }
    if (files == 0)
        MESSAGE("SKIP: no files of LibNTC 0.9.2");
}

TEST_CASE("generation 3: every allocation of reading compressed latents may fail") {
    const std::vector<std::byte> file = MakeFile(GetCompressed());
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    std::vector<std::byte> latents(*GetLatentBufferBytes(*set, 0, 1));
    openntc::test::CountingAllocator counting;
    REQUIRE(ReadLatents(*set, stream, 0, 1, latents, counting));
    REQUIRE(counting.GetAllocationCount() > 0);
    for (std::size_t n = 0; n < counting.GetAllocationCount(); ++n) {
        openntc::test::CountingAllocator failing;
        failing.FailAt(n);
        const auto read = ReadLatents(*set, stream, 0, 1, latents, failing);
        REQUIRE_FALSE(read);
        CHECK(read.error().GetStatus() == Status::OutOfMemory);
        CHECK(failing.GetUsedBytes() == 0);
    }
}
