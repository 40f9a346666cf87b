// SPDX-License-Identifier: MIT
// Whole mips through the compute pass: against the CRCs of the format specification (network 12), against
// LibNTC's exact texels, and texel by texel against the C++ build of the shader source.
//
// Comparisons are of bits, with subnormal numbers taken as zero: devices may flush them.
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"
#include "support/Files.h"
#include "support/Vectors.h"
#include "unit/decode/SpecificationSets.h"

#include "ntc/conformance/VectorFiles.h"
#include "openntc/core/Crc32.h"
#include "openntc/core/FileStream.h"
#include "openntc/core/Half.h"
#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/TextureSetMetadata.h"
#include "vulkan_harness/GpuDecoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

using namespace openntc;
using namespace openntc::harness;

namespace {

/// Texels per set for the maths modes and dot products other than the first, which has no limit: large mips
/// take seconds on lavapipe, and small ones hold every kind of geometry.
constexpr int kTexelBudget = 8 * 1024;

std::vector<DotProduct> GetDotProducts(const Context& context) {
    if (context.GetDevice().features.Has(Feature::IntegerDotProduct))
        return {DotProduct::Hardware, DotProduct::Emulated};
    MESSAGE("SKIP: OpSDot: the device lacks shaderIntegerDotProduct");
    return {DotProduct::Emulated};
}

std::vector<float> DecodeOnGpu(GpuDecoder& decoder, int mip, Rect rect, const DecodeOptions& options,
                               std::uint32_t* dispatches = nullptr) {
    std::vector<float> outputs(static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height) *
                               16);
    const Expected<GpuDecodeTiming> timing = decoder.Decode(mip, rect, options, outputs);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    if (dispatches != nullptr)
        *dispatches = timing->dispatches;
    return outputs;
}

struct MipChecksum {
    int mip, width, height;
    std::uint32_t half, binary32;
};

constexpr MipChecksum kV1[] = {{0, 24, 20, 0xbf80e76f, 0x007d97d0},
                               {1, 12, 10, 0x2b2db22a, 0x753fadfb},
                               {2, 6, 5, 0x01aa6b12, 0xa0be28f5},
                               {3, 3, 2, 0x16f196a5, 0x15b5c1e1}};
constexpr MipChecksum kV2[] = {{0, 40, 64, 0x4484fd84, 0x9f75f00c}, {1, 20, 32, 0x3ba32a83, 0xd3342cd7},
                               {2, 10, 16, 0xd30af414, 0xf06d2b91}, {3, 5, 8, 0x0426cc42, 0x7cc52f91},
                               {4, 2, 4, 0x0b35c34c, 0x3f6c89f8},   {5, 1, 2, 0x45d68f0c, 0x265b6c2f}};

void CheckSpecificationSet(Context& context, const char* name, const decode_test::SpecificationShape& shape,
                           std::span<const MipChecksum> checks) {
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
    const DecodeSource source = {&set.constants, set.latents, set.weights, set.networkVersion};
    int texels = 0;
    for (const DotProduct dot : GetDotProducts(context)) {
        Expected<GpuDecoder> decoder = GpuDecoder::Create(context, source, {.dotProduct = dot});
        REQUIRE_MESSAGE(decoder.has_value(), std::string(decoder.error().GetText()));
        for (const MipChecksum& check : checks) {
            CAPTURE(check.mip);
            const Rect rect = {0, 0, check.width, check.height};
            const std::vector<float> exact =
                DecodeOnGpu(*decoder, check.mip, rect, {.math = DecodeMath::Int8});
            CHECK(Crc32(std::as_bytes(std::span(exact))) == check.binary32);
            std::vector<std::uint16_t> halves;
            for (const float value : DecodeOnGpu(*decoder, check.mip, rect, {.math = DecodeMath::Int8Half})) {
                halves.push_back(FloatToHalf(value));
                REQUIRE(HalfToFloat(halves.back()) == value);
            }
            CHECK(Crc32(std::as_bytes(std::span(halves))) == check.half);
            texels += 2 * check.width * check.height;
        }
    }
    openntc_tests::ReportVectors(name, texels, 0);
}

/// A set with all its latents.
struct LoadedSet {
    std::string name;
    std::vector<std::byte> latents;
    TextureSetMetadata metadata;
    NtcTextureSetConstants constants;
    DecodeSource source;
};

LoadedSet LoadSet(const std::filesystem::path& path) {
    const std::vector<std::byte> file = openntc_tests::ReadBytes(path);
    ReadOnlyMemoryStream stream(file);
    Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(metadata.has_value(), std::string(metadata.error().GetText()));
    const int mips = metadata->GetDesc().mips;
    const auto bytes = GetLatentBufferBytes(*metadata, 0, mips);
    REQUIRE(bytes);
    LoadedSet set{path.stem().string(), std::vector<std::byte>(*bytes), std::move(*metadata), {}, {}};
    REQUIRE(ReadLatents(set.metadata, stream, 0, mips, set.latents));
    const auto constants = MakeInferenceData(set.metadata, 0, mips, InferenceWeightType::GenericInt8);
    REQUIRE_MESSAGE(constants.has_value(), std::string(constants.error().GetText()));
    set.constants = *constants;
    const auto weights = set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    REQUIRE(weights);
    set.source = {nullptr, set.latents, *weights, set.metadata.GetNetworkVersion()};
    return set;
}

struct Comparison {
    int texels = 0;  ///< compared with the C++ build
    int records = 0; ///< compared with LibNTC's exact values
    int different = 0;
};

/// One mip, whole, against the C++ build and against the records that lie in it.
void CompareMip(const std::vector<float>& outputs, const std::vector<float>& reference, int mip, int width,
                DecodeMath math, std::span<const conformance::TexelRecord> records, Comparison& total) {
    for (std::size_t i = 0; i < outputs.size(); ++i)
        total.different +=
            openntc_tests::GetDeviceBits(outputs[i]) != openntc_tests::GetDeviceBits(reference[i]);
    total.texels += static_cast<int>(outputs.size() / 16);
    for (const conformance::TexelRecord& record : records) {
        if (record.mip != mip || (record.flags & conformance::kHasExact) == 0)
            continue;
        const auto& truth = math == DecodeMath::Int8 ? record.exact : record.exactHalf;
        const std::size_t first = (static_cast<std::size_t>(record.y) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(record.x)) *
                                  16;
        REQUIRE(first + 16 <= outputs.size());
        for (std::size_t c = 0; c < 16; ++c)
            total.different +=
                openntc_tests::GetDeviceBits(outputs[first + c]) != openntc_tests::GetDeviceBits(truth[c]);
        ++total.records;
    }
}

Comparison CompareSet(Context& context, const LoadedSet& set,
                      std::span<const conformance::TexelRecord> records) {
    DecodeSource source = set.source;
    source.constants = &set.constants;
    std::vector<GpuDecoder> decoders;
    for (const DotProduct dot : GetDotProducts(context)) {
        Expected<GpuDecoder> decoder = GpuDecoder::Create(context, source, {.dotProduct = dot});
        REQUIRE_MESSAGE(decoder.has_value(), std::string(decoder.error().GetText()));
        decoders.push_back(std::move(*decoder));
    }
    const auto fast = FastDecoder::Create(source);
    REQUIRE_MESSAGE(fast.has_value(), std::string(fast.error().GetText()));
    Comparison total;
    const std::span<const ColorMip> mips = set.metadata.GetColorMips();
    for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
        for (std::size_t mip = 0; mip < mips.size(); ++mip) {
            const Rect rect = {0, 0, mips[mip].width, mips[mip].height};
            const bool small = rect.width * rect.height <= kTexelBudget;
            if (math != DecodeMath::Int8 && !small)
                continue;
            const DecodeOptions options = {.math = math};
            // Large mips by the fast decoder, which is tested against the reference on these sets.
            std::vector<float> reference(static_cast<std::size_t>(rect.width * rect.height) * 16);
            if (small)
                REQUIRE(DecodeReference(source, static_cast<int>(mip), rect, options, reference));
            else
                REQUIRE(fast->Decode(static_cast<int>(mip), rect, options, reference));
            for (std::size_t i = 0; i < (small ? decoders.size() : 1); ++i) {
                CompareMip(DecodeOnGpu(decoders[i], static_cast<int>(mip), rect, options), reference,
                           static_cast<int>(mip), rect.width, math, records, total);
            }
        }
    }
    return total;
}

} // namespace

TEST_CASE("V1 on the device: both maths modes, both dot products, every mip") {
    OPENNTC_REQUIRE_DEVICE(context);
    CheckSpecificationSet(*context, "V1", decode_test::GetV1Shape(), kV1);
}

TEST_CASE("V2 on the device: both maths modes, both dot products, every mip") {
    OPENNTC_REQUIRE_DEVICE(context);
    CheckSpecificationSet(*context, "V2", decode_test::GetV2Shape(), kV2);
}

TEST_CASE("conformance sets on the device, whole mips") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::error_code error;
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(openntc_tests::GetConformanceFolder(), error)) {
        if (entry.path().extension() == ".ntc")
            files.push_back(entry.path());
    }
    if (files.empty()) {
        MESSAGE("SKIP: no conformance vectors in the shared folder");
        openntc_tests::ReportVectors("conformance-vulkan", 0, 1);
        return;
    }
    std::sort(files.begin(), files.end());
    Comparison total;
    for (const std::filesystem::path& path : files) {
        const LoadedSet set = LoadSet(path);
        CAPTURE(set.name);
        std::filesystem::path texels = path;
        const auto records =
            conformance::ReadTexels(openntc_tests::ReadBytes(texels.replace_extension(".texels")));
        REQUIRE_MESSAGE(records.has_value(), std::string(records.error().GetText()));
        const Comparison comparison = CompareSet(*context, set, *records);
        CHECK(comparison.texels > 0);
        // Of later generations LibNTC's values depend on a texture unit's filter.
        CHECK((comparison.records > 0) == (set.metadata.GetGeneration() == 1));
        CHECK(comparison.different == 0);
        total.texels += comparison.texels;
        total.records += comparison.records;
    }
    MESSAGE("texels compared with the C++ build: " << total.texels
                                                   << ", records compared with LibNTC: " << total.records);
    openntc_tests::ReportVectors("conformance-vulkan", total.records, 0);
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("rectangles, dispatches that are split, and texels outside the image") {
    OPENNTC_REQUIRE_DEVICE(context);
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV2Shape());
    const DecodeSource source = {&set.constants, set.latents, set.weights, set.networkVersion};
    const DecodeOptions options;
    for (const std::uint32_t limit : {7u, 100u, 1u << 18}) {
        Expected<GpuDecoder> decoder = GpuDecoder::Create(*context, source, {.maxTexelsPerDispatch = limit});
        REQUIRE_MESSAGE(decoder.has_value(), std::string(decoder.error().GetText()));
        for (const Rect rect :
             {Rect{3, 5, 17, 9}, Rect{0, 63, 40, 1}, Rect{39, 0, 1, 64}, Rect{-9, -4, 60, 12}}) {
            std::vector<float> reference(static_cast<std::size_t>(rect.width * rect.height) * 16);
            REQUIRE(DecodeReference(source, 0, rect, options, reference));
            std::uint32_t dispatches = 0;
            const std::vector<float> outputs = DecodeOnGpu(*decoder, 0, rect, options, &dispatches);
            int different = 0;
            for (std::size_t i = 0; i < outputs.size(); ++i)
                different +=
                    openntc_tests::GetDeviceBits(outputs[i]) != openntc_tests::GetDeviceBits(reference[i]);
            CHECK(different == 0);
            CHECK((dispatches > 1) == (static_cast<std::uint32_t>(rect.width * rect.height) > limit));
        }
    }
}

TEST_CASE("the GPU decoder refuses what the reference decoder refuses") {
    OPENNTC_REQUIRE_DEVICE(context);
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV1Shape());
    DecodeSource source = {&set.constants, set.latents, set.weights, set.networkVersion};
    Expected<GpuDecoder> decoder = GpuDecoder::Create(*context, source);
    REQUIRE(decoder);
    std::vector<float> outputs(16);
    CHECK_FALSE(decoder->Decode(4, {0, 0, 1, 1}, {}, outputs));
    CHECK_FALSE(decoder->Decode(-1, {0, 0, 1, 1}, {}, outputs));
    CHECK_FALSE(decoder->Decode(0, {0, 0, 2, 1}, {}, outputs));
    source.latents = source.latents.first(source.latents.size() - 4);
    CHECK_FALSE(GpuDecoder::Create(*context, source));
    source.constants = nullptr;
    CHECK_FALSE(GpuDecoder::Create(*context, source));
}
