// SPDX-License-Identifier: MIT
// What TextureSetMetadata::Load refuses, with status and field, and what it tolerates.
#include "EditedFile.h"

#include <limits>

using namespace openntc;
using namespace openntc_tests;

TEST_CASE("V1 loads with the specification's sizes, latents and mips") {
    const auto set = EditV1().Load();
    REQUIRE(set);
    CHECK(set->GetDesc() == TextureSetDesc{24, 20, 4, 4});
    CHECK(set->GetLatentShape() == LatentShape{4, 4, 8, 2, 4});
    CHECK(set->GetNetworkVersion() == NTC_NETWORK_SMALL);
    REQUIRE(set->GetLatentImages().size() == 1);
    CHECK(set->GetLatentImages()[0].highRes.width == 6);
    CHECK(set->GetLatentImages()[0].lowRes.height == 2);
    CHECK(set->GetStreamRangeForLatents(0, 4) == StreamRange{1932 + 13952, 56});
    REQUIRE(set->GetTextures().size() == 1);
    CHECK(set->GetTextures()[0].name == "t");
    CHECK(set->GetTextures()[0].channelFormat == ChannelFormat::UNORM8);
    CHECK(set->GetMipLevelsForLatentImage(0) == MipRange{0, 3});
    CHECK(set->GetMipLevelsForLatentImage(1).error().GetStatus() == Status::OutOfRange);
    CHECK(set->GetFusedMipLevels(4).error().GetStatus() == Status::OutOfRange);
    CHECK(set->GetStreamRangeForLatents(1, 4).error().GetStatus() == Status::OutOfRange);
    CHECK(set->GetStreamRangeForLatents(4, 1).error().GetStatus() == Status::OutOfRange);
    CHECK(set->GetStreamRangeForLatents(0, 0).error().GetStatus() == Status::OutOfRange);
}

TEST_CASE("sizes and counts outside their limits are refused") {
    EditV1().Replace("\"width\":24", "\"width\":0").CheckRefused(Status::OutOfRange, "width");
    EditV1().Replace("\"width\":24", "\"width\":1048577").CheckRefused(Status::OutOfRange, "1048576");
    EditV1().Replace("\"height\":20", "\"height\":4294967295").CheckRefused(Status::OutOfRange, "height");
    EditV1()
        .Replace("\"numChannels\":4", "\"numChannels\":17")
        .CheckRefused(Status::OutOfRange, "numChannels");
    EditV1()
        .Replace("\"numColorMips\":4", "\"numColorMips\":17")
        .CheckRefused(Status::OutOfRange, "numColorMips");
    EditV1()
        .Replace("\"numColorMips\":4", "\"numColorMips\":3")
        .CheckRefused(Status::FileUnrecognized, "colorMips");
    EditV1().Replace("\"colorMips\"", "\"unknown\"").CheckRefused(Status::FileUnrecognized, "colorMips");
    EditV1().Replace("\"latents\"", "\"unknown\"").CheckRefused(Status::FileUnrecognized, "latents");
    EditV1().Replace("\"latentShape\"", "\"unknown\"").CheckRefused(Status::FileUnrecognized, "latentShape");
    EditV1().Replace("\"mlp\"", "\"unknown\"").CheckRefused(Status::FileUnrecognized, "mlp");
    EditV1().Replace("{},{},{},{}", "{},{},{}").CheckRefused(Status::FileUnrecognized, "channels");
}

TEST_CASE("latents that contradict shape, views or the limits are refused") {
    EditV1()
        .Replace("\"highResFeatures\":4", "\"highResFeatures\":5")
        .CheckRefused(Status::OutOfRange, "highResFeatures");
    EditV1()
        .Replace("\"lowResQuantBits\":4", "\"lowResQuantBits\":3")
        .CheckRefused(Status::OutOfRange, "lowResQuantBits");
    EditV1()
        .Replace("\"highResBitsPerPixel\":8", "\"highResBitsPerPixel\":9")
        .CheckRefused(Status::FileUnrecognized, "BitsPerPixel");
    EditV1()
        .Replace("\"highResWidth\":6", "\"highResWidth\":0")
        .CheckRefused(Status::OutOfRange, "latents[0].highRes");
    EditV1()
        .Replace("\"highResWidth\":6", "\"highResWidth\":65536")
        .CheckRefused(Status::OutOfRange, "65535");
    // 32768 * 32768 * 8 bits needs 2^30 bytes; 32-bit arithmetic on bits would see 0
    EditV1()
        .Replace("\"highResWidth\":6,\"highResHeight\":5", "\"highResWidth\":32768,\"highResHeight\":32768")
        .CheckRefused(Status::FileUnrecognized, "1073741824");
    EditV1()
        .Replace("\"highResHeight\":5", "\"highResHeight\":6")
        .CheckRefused(Status::FileUnrecognized, "storedSize");
    EditV1()
        .Replace("\"highResView\":12", "\"highResView\":14")
        .CheckRefused(Status::FileUnrecognized, "highResView");
    EditV1()
        .Replace("\"latentMip\":0", "\"latentMip\":1")
        .CheckRefused(Status::FileUnrecognized, "latentMip");
    EditV1().Replace("\"latentMip\":0,", "").CheckRefused(Status::FileUnrecognized, "latentMip");
    EditV1()
        .Replace("\"width\":12,\"height\":10", "\"width\":12,\"height\":11")
        .CheckRefused(Status::FileUnrecognized, "colorMips[1]");
    EditV1()
        .Replace("\"positionScale\":2.0", "\"positionScale\":1e37")
        .CheckRefused(Status::FileUnrecognized, "positionScale");
}

TEST_CASE("networks that do not fit are refused") {
    EditV1()
        .Replace("\"inputChannels\":48", "\"inputChannels\":50")
        .CheckRefused(Status::FileUnrecognized, "inputChannels");
    EditV1()
        .Replace("\"inputChannels\":48", "\"inputChannels\":64")
        .CheckRefused(Status::FileUnrecognized, "weightView");
    EditV1()
        .Replace("\"outputChannels\":16", "\"outputChannels\":15")
        .CheckRefused(Status::FileUnrecognized, "layers[3]");
    EditV1().Replace("RowMajor", "ColumnMajor").CheckRefused(Status::FileUnrecognized, "weightLayout");
    EditV1()
        .Replace(",\"weightLayout\":\"RowMajor\"", "")
        .CheckRefused(Status::FileUnrecognized, "weightLayout");
    EditV1()
        .Replace("\"biasType\":\"Int32\"", "\"biasType\":\"Float32\"")
        .CheckRefused(Status::FileUnrecognized, "layers[0]");
    EditV1()
        .Replace("\"weightType\":\"Int8\"", "\"weightType\":\"FloatE5M2\"")
        .CheckRefused(Status::FileUnrecognized, "FloatE5M2");
    EditV1()
        .Replace("\"offset\":3328,\"storedSize\":256", "\"offset\":3328,\"storedSize\":252")
        .CheckRefused(Status::FileUnrecognized, "biasView"); // short Int32 biases
    SynthesisDesc large = GetV2().synthesis;
    EditedFile(MakeFile(large))
        .Replace("\"highResFeatures\":12", "\"highResFeatures\":16")
        .Replace("\"highResQuantBits\":4", "\"highResQuantBits\":2")
        .ReplaceAll("\"highResBitsPerPixel\":48", "\"highResBitsPerPixel\":32")
        .CheckRefused(Status::OutOfRange, "highResFeatures");
}

TEST_CASE("numbers that are not finite are refused") {
    const float infinity = std::numeric_limits<float>::infinity();
    EditV1().Store(3072 + 8, infinity).CheckRefused(Status::FileUnrecognized, "layers[0].scaleView");
    EditV1()
        .Store(13824, std::numeric_limits<float>::quiet_NaN())
        .CheckRefused(Status::FileUnrecognized, "layers[3]");
    SynthesisDesc fp8 = GetV1().synthesis;
    fp8.withInt8 = false;
    fp8.withFP8 = true;
    EditedFile(MakeFile(fp8))
        .Store<std::uint8_t>(100, 0xFF)
        .CheckRefused(Status::FileUnrecognized,
                      "mlpVersions[0].layers[0].weightView: number 100 is 0xFF: must be finite");
    EditedFile(MakeFile(fp8))
        .Store<std::uint16_t>(3072, 0x7C00)
        .CheckRefused(Status::FileUnrecognized, "biasView");
}

TEST_CASE("sets with an FP8 network only load") {
    SynthesisDesc fp8 = GetV1().synthesis;
    fp8.withInt8 = false;
    fp8.withFP8 = true;
    const auto set = EditedFile(MakeFile(fp8)).Load();
    REQUIRE(set);
    CHECK_FALSE(set->IsInferenceWeightTypeSupported(InferenceWeightType::GenericInt8));
    CHECK(set->GetInferenceWeights(InferenceWeightType::GenericInt8).error().GetStatus() ==
          Status::Unsupported);
    REQUIRE(set->GetInferenceWeights(InferenceWeightType::GenericFP8));
    CHECK(set->GetInferenceWeights(InferenceWeightType::GenericFP8)->size() == 12800);
}

TEST_CASE("odd channel counts, missing channels and positions, and bad texture ranges are tolerated") {
    auto odd = EditV1()
                   .Replace("\"numChannels\":4,", "\"numChannels\":3,")
                   .Replace("{},{},{},{}", "{},{},{\"colorSpace\":\"HLG\"}")
                   .Load();
    REQUIRE(odd);
    CHECK(odd->GetDesc().channels == 3);
    CHECK(odd->GetChannelStorageColorSpace(2) == ColorSpace::HLG);
    CHECK(odd->GetTextures()[0].numChannels == 0); // 4 channels do not fit into 3
    CHECK(odd->GetValidChannelMask() == 0);
    CHECK(EditV1().Replace("\"channels\":[{},{},{},{}],", "").Load());
    const auto legacy = EditV1().Replace(",\"positionLod\":0.3333333432674408", "").Load();
    REQUIRE(legacy);
    CHECK(legacy->GetColorMips()[1].positionLod == 1.0f / 3.0f);
    CHECK(legacy->GetColorMips()[1].positionScale == 2.0f);
}

TEST_CASE("a 1 x N image loads: the derived gridSizeScale is informational") {
    SynthesisDesc sliver = GetV1().synthesis;
    sliver.desc = {1, 40, 4, 3};
    const auto set = EditedFile(MakeFile(sliver)).Load();
    REQUIRE(set);
    CHECK(set->GetLatentShape().gridSizeScale == 1);
}

TEST_CASE("BC7 statistics: modes beyond 7 and partitions beyond 63 are refused") {
    const BlockCompressionMode modes[] = {{6, 0, 60000}, {1, 63, 5535}};
    Texture texture;
    texture.name = "t";
    texture.numChannels = 4;
    texture.bcModes = modes;
    SynthesisDesc synthesis = GetV1().synthesis;
    synthesis.textures = {&texture, 1};
    EditedFile file(MakeFile(synthesis));
    const auto set = file.Load();
    REQUIRE(set);
    REQUIRE(set->GetTextures()[0].bcModes.size() == 2);
    CHECK(set->GetTextures()[0].bcModes[1].partition == 63);
    CHECK(set->GetTextures()[0].bcModes[1].frequency == 5535);
    EditedFile badMode = file; // the records follow the network
    badMode.Store<std::uint8_t>(13952, 8).CheckRefused(Status::FileUnrecognized, "bcAccelerationDataView");
    EditedFile badPartition = file;
    badPartition.Store<std::uint8_t>(13957, 64).CheckRefused(Status::FileUnrecognized, "partition 64");
}
