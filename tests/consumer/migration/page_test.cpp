// SPDX-License-Identifier: MIT
// The page shows what is compiled here, and names every public entry point of LibNTC 0.7.
#include "openntc/core/FileStream.h"

#include <doctest/doctest.h>

#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

using namespace openntc;

namespace {

std::string ReadText(const std::filesystem::path& path) {
    auto file = FileReader::Open(path);
    REQUIRE_MESSAGE(file.has_value(), path.string());
    std::string text(static_cast<std::size_t>(file->Size()), ' ');
    REQUIRE(file->Read(text.data(), text.size()));
    return text;
}

/// Without white space, so that the formatting of either side does not matter.
std::string Squeeze(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (std::isspace(static_cast<unsigned char>(c)) == 0)
            result += c;
    }
    return result;
}

const std::filesystem::path kRoot = std::filesystem::path(OPENNTC_TEST_DATA_DIR).parent_path().parent_path();

/// Free functions, then those of the interfaces, then those of shaders.
constexpr std::string_view kEntryPoints[] = {"GetInterfaceVersion",
                                             "GetLibraryVersion",
                                             "CreateContext",
                                             "DestroyContext",
                                             "GetLastErrorMessage",
                                             "StatusToString",
                                             "ChannelFormatToString",
                                             "BlockCompressedFormatToString",
                                             "ColorSpaceToString",
                                             "NetworkVersionToString",
                                             "InferenceWeightTypeToString",
                                             "GetBytesPerPixelComponent",
                                             "LossToPSNR",
                                             "EstimateCompressedTextureSetSize",
                                             "GetKnownLatentShapeCount",
                                             "EnumerateKnownLatentShapes",
                                             "PickLatentShape",
                                             "GetLatentShapeBitsPerPixel",
                                             "DecodeImageDifferenceResult",
                                             "OpenFile",
                                             "CloseFile",
                                             "OpenMemory",
                                             "OpenReadOnlyMemory",
                                             "CloseMemory",
                                             "CreateTextureSet",
                                             "DestroyTextureSet",
                                             "CreateTextureSetMetadataFromStream",
                                             "DestroyTextureSetMetadata",
                                             "CreateCompressedTextureSetFromStream",
                                             "CreateCompressedTextureSetFromMemory",
                                             "CreateCompressedTextureSetFromFile",
                                             "RegisterSharedTexture",
                                             "ReleaseSharedTexture",
                                             "CreateAdaptiveCompressionSession",
                                             "DestroyAdaptiveCompressionSession",
                                             "MakeDecompressionComputePass",
                                             "MakeBlockCompressionComputePass",
                                             "MakeImageDifferenceComputePass",
                                             "MakeInferenceData",
                                             "MakePartialInferenceData",
                                             "GetConservativeLatentBufferSize",
                                             "IsCooperativeVectorInt8Supported",
                                             "IsCooperativeVectorFP8Supported",
                                             "GetDesc",
                                             "GetLatentShape",
                                             "AddTexture",
                                             "RemoveTexture",
                                             "ClearTextureMetadata",
                                             "GetTextureCount",
                                             "GetTexture",
                                             "GetChannelStorageColorSpace",
                                             "GetNetworkVersion",
                                             "GetStreamRangeForLatents",
                                             "GetFusedMipLevels",
                                             "GetNumLatentImages",
                                             "GetMipLevelsForLatentImage",
                                             "GetBestSupportedWeightType",
                                             "GetInferenceWeights",
                                             "ConvertInferenceWeights",
                                             "IsInferenceWeightTypeSupported",
                                             "ShuffleInferenceOutputs",
                                             "GetValidChannelMask",
                                             "SetName",
                                             "GetName",
                                             "SetChannels",
                                             "GetChannels",
                                             "GetFirstChannel",
                                             "GetNumChannels",
                                             "SetChannelFormat",
                                             "GetChannelFormat",
                                             "SetBlockCompressedFormat",
                                             "GetBlockCompressedFormat",
                                             "SetRgbColorSpace",
                                             "GetRgbColorSpace",
                                             "SetAlphaColorSpace",
                                             "GetAlphaColorSpace",
                                             "SetBlockCompressionAccelerationData",
                                             "HasBlockCompressionAccelerationData",
                                             "SetBlockCompressionQuality",
                                             "GetBlockCompressionQuality",
                                             "SetLatentShape",
                                             "GetOutputStreamSize",
                                             "SaveToStream",
                                             "SaveToMemory",
                                             "SaveToFile",
                                             "LoadFromStream",
                                             "LoadFromMemory",
                                             "LoadFromFile",
                                             "WriteChannels",
                                             "ReadChannels",
                                             "WriteChannelsFromTexture",
                                             "ReadChannelsIntoTexture",
                                             "GenerateMips",
                                             "BeginCompression",
                                             "RunCompressionSteps",
                                             "FinalizeCompression",
                                             "AbortCompression",
                                             "Decompress",
                                             "SetMaskChannelIndex",
                                             "SetExperimentalKnob",
                                             "IAdaptiveCompressionSession",
                                             "Reset",
                                             "Finished",
                                             "GetCurrentPreset",
                                             "Next",
                                             "GetIndexOfFinalRun",
                                             "ISharedTexture",
                                             "IStream",
                                             "IAllocator",
                                             "NtcSampleTextureSet",
                                             "NtcSampleTextureSet_CoopVec_Int8",
                                             "NtcSampleTextureSet_CoopVec_FP8",
                                             "NtcPrepareNetworkInputs",
                                             "NtcGetTextureDimensions",
                                             "NtcGetTextureMipLevels",
                                             "NtcGetChannelMask",
                                             "NtcGetValidChannelMask",
                                             "NtcTextureSetHasChannels",
                                             "NtcConvertChannelToLinearColorSpace",
                                             "NtcConvertColorSpace"};

bool IsNamePart(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// True if the left column of a table holds the name as a whole word.
bool IsListed(std::string_view page, std::string_view name) {
    for (std::size_t at = page.find(name); at != std::string_view::npos; at = page.find(name, at + 1)) {
        const std::size_t end = at + name.size();
        const bool isWord =
            (at == 0 || !IsNamePart(page[at - 1])) && (end == page.size() || !IsNamePart(page[end]));
        const std::size_t newline = page.rfind('\n', at);
        const std::size_t line = newline == std::string_view::npos ? 0 : newline + 1;
        const std::string_view before = page.substr(line, at - line);
        if (isWord && before.starts_with("| ") && before.find('|', 1) == std::string_view::npos)
            return true;
    }
    return false;
}

} // namespace

TEST_CASE("blocks of code are those that are compiled") {
    const std::string page = ReadText(kRoot / "docs" / "migrating-from-libntc.md");
    std::string compiled;
    for (const char* name : {"calls_test.cpp", "encode_calls_test.cpp", "SampleMaterial.comp"})
        compiled += Squeeze(ReadText(kRoot / "tests" / "consumer" / "migration" / name));
    int blocks = 0;
    for (std::size_t at = page.find("```"); at != std::string::npos; at = page.find("```", at)) {
        const std::size_t begin = page.find('\n', at);
        const std::size_t end = page.find("```", begin);
        REQUIRE(end != std::string::npos);
        // A blank line separates pieces that need not follow each other in the source.
        const std::string block = page.substr(begin, end - begin);
        for (std::size_t from = 0; from < block.size();) {
            const std::size_t gap = block.find("\n\n", from);
            const std::string piece = Squeeze(block.substr(from, gap - from));
            CAPTURE(piece);
            CHECK(compiled.find(piece) != std::string::npos);
            from = gap == std::string::npos ? block.size() : gap + 2;
        }
        ++blocks;
        at = end + 3;
    }
    CHECK(blocks == 8);
}

TEST_CASE("every entry point of LibNTC has a line") {
    const std::string page = ReadText(kRoot / "docs" / "migrating-from-libntc.md");
    for (const std::string_view name : kEntryPoints) {
        CAPTURE(std::string(name));
        CHECK(IsListed(page, name));
    }
}
