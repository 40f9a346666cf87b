// SPDX-License-Identifier: MIT
// GpuDecoder on matrices, which are arrays here: what the host chooses, uploads and dispatches, against the reference decoder's
// bits.
#include "shader/TestDevice.h"
#include "shader/coopmat/Probes.h"
#include "support/DeviceBits.h"
#include "unit/decode/ModeSets.h"
#include "vulkan_harness/GpuDecoder.h"

#include "coopmat_shaders.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

/// A definition's value, or `absent`.
std::string FindDefine(std::string_view defines, const std::string& name, const char* absent) {
    const std::size_t at = (" " + std::string(defines)).find(" " + name + "=");
    if (at == std::string::npos)
        return absent;
    const std::string_view rest = defines.substr(at + name.size() + 1);
    return std::string(rest.substr(0, rest.find(' ')));
}

/// The emulated shader for what GpuDecoder asks the kept SPIR-V for.
Expected<std::span<const std::uint32_t>> FindEmulated(std::string_view defines) {
    const std::string version = FindDefine(defines, "NETWORK_VERSION", "?");
    return coopmat_shaders::FindShader(
        "DecodeBlocks.comp",
        "NETWORK_VERSION=" + version + " NTC_MATH=" + FindDefine(defines, "NTC_MATH", "?") +
            " NTC_COOPMAT_LANES=" + FindDefine(defines, "NTC_COOPMAT_LANES", "0") +
            " NTC_COOPMAT_ROLLED=" + (version == "2" || version == "4" ? "1" : "0") +
            " NTC_COOPMAT_EMULATED=1 NTC_RESULT_BITS=" + FindDefine(defines, "NTC_RESULT_BITS", "16"));
}

/// Numbers of a rectangle that are others than the reference decoder's.
std::size_t CountDifferent(GpuDecoder& decoder, const DecodeSource& source, int mip, const Rect& rect,
                           const DecodeOptions& options, std::uint32_t dispatches) {
    const std::size_t count = static_cast<std::size_t>(rect.width * rect.height) * 16;
    std::vector<float> expected(count), outputs(count, -1.0f);
    REQUIRE(DecodeReference(source, mip, rect, options, expected));
    const auto timing = decoder.Decode(mip, rect, options, outputs);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    CHECK(timing->dispatches == dispatches);
    std::size_t different = 0;
    for (std::size_t i = 0; i < count; ++i)
        different += GetDeviceBits(outputs[i]) != GetDeviceBits(expected[i]) ? 1 : 0;
    return different;
}

} // namespace

TEST_CASE("GpuDecoder on matrices as arrays: forms, maths modes, rectangles in parts, sets in turn") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr unsigned kSeed = 47;
    MESSAGE("seed " << kSeed);
    std::mt19937 random(kSeed);
    const auto layout = ReadCoopMatLayout(MakeRandomProbe(random));
    REQUIRE(layout);
    const decode_test::ModeSet small = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 37, 22);
    const decode_test::ModeSet other = decode_test::MakeModeSet(NTC_NETWORK_GENERATION_3, 20, 33);
    const DecodeSource first = small.GetSource(DecodeWeights::Int8);
    const DecodeSource second = other.GetSource(DecodeWeights::Int8);
    for (const bool hasLanes : {true, false}) {
        CAPTURE(hasLanes);
        GpuDecoderOptions options;
        options.matrices = MatrixUse::Required;
        options.substitute = {hasLanes ? std::optional(*layout) : std::nullopt, FindEmulated};
        options.maxTexelsPerDispatch = 37 * 8; // rows in parts of eight
        auto decoder = GpuDecoder::Create(*context, first, options);
        REQUIRE_MESSAGE(decoder.has_value(), std::string(decoder.error().GetText()));
        CHECK(decoder->HasMatrixLanes() == hasLanes);
        CHECK(CountDifferent(*decoder, first, 0, {0, 0, 37, 22},
                             {.math = DecodeMath::Int8, .convertToLinear = false}, 3) == 0);
        CHECK(CountDifferent(*decoder, first, 1, {2, 3, 15, 7},
                             {.math = DecodeMath::Int8Half, .convertToLinear = true}, 1) == 0);
        // Another network: pipelines and weights of its own. Then the first again.
        REQUIRE(decoder->SetSource(second));
        CHECK(CountDifferent(*decoder, second, 0, {1, 2, 19, 31},
                             {.math = DecodeMath::Int8, .convertToLinear = true}, 3) == 0);
        REQUIRE(decoder->SetSource(first));
        CHECK(CountDifferent(*decoder, first, 0, {36, 0, 1, 22},
                             {.math = DecodeMath::Int8Half, .convertToLinear = false}, 1) == 0);
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("GpuDecoder on matrices as arrays: weights that lanes cannot take, and what matrices cannot do") {
    OPENNTC_REQUIRE_DEVICE(context);
    const auto layout = ReadCoopMatLayout(MakeKnownProbe());
    REQUIRE(layout);
    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 24, 12);
    DecodeSource source = set.GetSource(DecodeWeights::Int8);
    GpuDecoderOptions options;
    options.matrices = MatrixUse::Required;
    options.substitute = {*layout, FindEmulated};
    auto decoder = GpuDecoder::Create(*context, source, options);
    REQUIRE(decoder);
    CHECK(decoder->HasMatrixLanes());
    // A bias whose sums pass 2^22: the form for any device, with the same bits.
    std::vector<std::byte> large(source.weights.begin(), source.weights.end());
    const std::int32_t bias = 4'194'303;
    std::memcpy(large.data() + GetNetworkDescription(NTC_NETWORK_SMALL).int8BiasOffsets[1], &bias, 4);
    source.weights = large;
    REQUIRE(decoder->SetSource(source));
    CHECK_FALSE(decoder->HasMatrixLanes());
    CHECK(CountDifferent(*decoder, source, 0, {0, 0, 24, 12},
                         {.math = DecodeMath::Int8, .convertToLinear = false}, 1) == 0);

    std::vector<float> outputs(16);
    const auto other = decoder->Decode(0, {0, 0, 1, 1}, {.math = DecodeMath::FP16}, outputs);
    REQUIRE_FALSE(other);
    CHECK(other.error().GetStatus() == Status::Unsupported);
    const auto fp8 = decoder->SetSource(set.GetSource(DecodeWeights::FP8));
    REQUIRE_FALSE(fp8);
    CHECK(fp8.error().GetStatus() == Status::Unsupported);
    if (!context->GetDevice().hasByteMatrices) { // without arrays in their place
        const auto none = GpuDecoder::Create(*context, set.GetSource(DecodeWeights::Int8),
                                             {.matrices = MatrixUse::Required});
        REQUIRE_FALSE(none);
        CHECK(std::string(none.error().GetText()).find("device or feature absent: cooperative matrices") ==
              0);
    }
    CHECK(context->GetValidationLog().errors.empty());
}
