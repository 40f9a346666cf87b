// SPDX-License-Identifier: MIT
// Every maths mode and network version on the device, from the GLSL and the HLSL build of the pass, against the C++
// build: the same bits, subnormal numbers taken as zero. (unit/decode/modes_test.cpp compares the C++ build with an
// independent model.) 100 000 texels of each mode and network in GLSL.
#include "shader/PassRunner.h"
#include "shader/TestDevice.h"
#include "shader/WideDecoder.h"
#include "support/DeviceBits.h"
#include "support/Files.h"
#include "support/Vectors.h"
#include "unit/decode/LatentMipSets.h"
#include "unit/decode/ModeSets.h"

#include "openntc/MathModes.h"
#include "openntc/core/FileStream.h"
#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "vulkan_harness/GpuDecoder.h"

#include "decode_shaders.h"
#include "hlsl_shaders.h"
#include "native_half_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

struct Mode {
    const char* name;
    DecodeMath math;
    int macro;
    bool isExact; ///< a mode of the exact contract, which the fast decoder has too
};

constexpr Mode kModes[] = {{"INT8", DecodeMath::Int8, NTC_MATH_INT8, true},
                           {"INT8_HALF", DecodeMath::Int8Half, NTC_MATH_INT8_HALF, true},
                           {"FP8", DecodeMath::FP8, NTC_MATH_FP8, false},
                           {"FP16", DecodeMath::FP16, NTC_MATH_FP16, false},
                           {"FP32", DecodeMath::FP32, NTC_MATH_FP32, false}};

constexpr std::size_t kTexels = 100'000;
/// Mip 0: with the other four mips, 101 207 texels.
constexpr int kWidth = 331;
constexpr int kHeight = 230;
/// The largest mip that is decoded in HLSL as well.
constexpr int kHlslTexels = 83 * 65;
/// The largest mip that the reference decoder decodes whole. Of larger ones faster decoders give most rows.
constexpr int kReferenceTexels = 41 * 32;
constexpr int kReferenceRows = 6;

std::string GetDefines(int networkVersion, int macro) {
    return "NETWORK_VERSION=" + std::to_string(networkVersion) + " NTC_MATH=" + std::to_string(macro);
}

/// Of the processor, all threads.
double GetSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::vector<float> DecodeOnCpu(const DecodeSource& source, int mip, Rect rect, DecodeMath math) {
    std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
    const auto result = DecodeReference(source, mip, rect, {.math = math, .convertToLinear = false}, outputs);
    REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    return outputs;
}

/// A large mip by a faster decoder, and some rows by the reference decoder to see that it is right.
std::vector<float> DecodeFast(const DecodeSource& source, int mip, Rect rect, const Mode& mode) {
    std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
    if (mode.isExact) {
        const auto decoder = FastDecoder::Create(source);
        REQUIRE_MESSAGE(decoder.has_value(), std::string(decoder.error().GetText()));
        const auto result =
            decoder->Decode(mip, rect, {.math = mode.math, .convertToLinear = false}, outputs);
        REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    } else {
        DecodeWide(source, mode.macro, mip, rect, outputs);
    }
    const Rect rows = {0, rect.height - kReferenceRows, rect.width, kReferenceRows};
    const std::vector<float> reference = DecodeOnCpu(source, mip, rows, mode.math);
    REQUIRE(std::equal(reference.rbegin(), reference.rend(), outputs.rbegin(),
                       [](float a, float b) { return GetDeviceBits(a) == GetDeviceBits(b); }));
    return outputs;
}

struct Totals {
    std::size_t texels = 0;
    double cpuSeconds = 0;
    double glslSeconds = 0;
    std::size_t glslTimedTexels = 0;
    std::size_t hlslTimedTexels = 0;
    std::size_t hlslTexels = 0;
    double hlslSeconds = 0;
    double slowestPipeline = 0;
};

/// Mips of a set with at most `maxTexels` texels from GLSL, and with at most kReferenceTexels from HLSL too.
void CompareSet(Context& context, const DecodeSource& source, const Mode& mode, int maxTexels,
                Totals& totals) {
    const std::string defines = GetDefines(source.networkVersion, mode.macro);
    const auto glsl = decode_shaders::FindShader("DecodeTexels.comp", defines);
    REQUIRE_MESSAGE(glsl.has_value(), std::string(glsl.error().GetText()));
    const auto hlsl = hlsl_shaders::FindShader("DecodeTexels.hlsl", defines);
    REQUIRE_MESSAGE(hlsl.has_value(), std::string(hlsl.error().GetText()));
    PassRunner glslRunner(context, source, *glsl);
    PassRunner hlslRunner(context, source, *hlsl);
    for (int mip = source.constants->imageMips - 1; mip >= 0; --mip) {
        const Rect rect = GetMipRect(source, mip);
        if (rect.width * rect.height > maxTexels)
            continue;
        CAPTURE(mip);
        const double start = GetSeconds();
        const std::vector<float> expected = rect.width * rect.height > kReferenceTexels
                                                ? DecodeFast(source, mip, rect, mode)
                                                : DecodeOnCpu(source, mip, rect, mode.math);
        totals.cpuSeconds += GetSeconds() - start;
        CHECK(CountDifferent(glslRunner.Decode(mip, rect), expected) == 0);
        totals.texels += expected.size() / 16;
        if (rect.width * rect.height > kHlslTexels)
            continue;
        CHECK(CountDifferent(hlslRunner.Decode(mip, rect), expected) == 0);
        totals.hlslTexels += expected.size() / 16;
    }
    totals.glslSeconds += glslRunner.GetSecondsOfDispatches();
    totals.hlslSeconds += hlslRunner.GetSecondsOfDispatches();
    totals.glslTimedTexels += glslRunner.GetTimedTexels();
    totals.hlslTimedTexels += hlslRunner.GetTimedTexels();
    totals.slowestPipeline =
        std::max({totals.slowestPipeline, glslRunner.GetCreationSeconds(), hlslRunner.GetCreationSeconds()});
}

std::vector<std::filesystem::path> ListConformanceSets() {
    const std::filesystem::path folder = GetConformanceFolder();
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".ntc")
            files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

} // namespace

TEST_CASE("every maths mode and network: GLSL and HLSL on the device give the bits of the C++ build") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const Mode& mode : kModes) {
        const std::string modeName = mode.name;
        CAPTURE(modeName);
        Totals totals;
        for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
            CAPTURE(version);
            const decode_test::ModeSet set = decode_test::MakeModeSet(version, kWidth, kHeight);
            const std::size_t before = totals.texels;
            CompareSet(*context, set.GetSource(GetDecodeWeights(mode.math)), mode, kWidth * kHeight, totals);
            CHECK(totals.texels - before >= kTexels);
        }
        const double texels = static_cast<double>(totals.texels);
        MESSAGE(std::string(mode.name)
                << ": " << totals.texels << " texels, microseconds per texel: C++ (processor) "
                << 1e6 * totals.cpuSeconds / texels << ", GLSL "
                << 1e6 * totals.glslSeconds / static_cast<double>(totals.glslTimedTexels) << ", HLSL "
                << 1e6 * totals.hlslSeconds / static_cast<double>(totals.hlslTimedTexels)
                << "; slowest pipeline " << totals.slowestPipeline << " s");
        CHECK(totals.hlslTexels >= 20'000);
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE(
    "every maths mode of generations 2 and 3: GLSL and HLSL on the device give the bits of the C++ build") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const decode_test::LatentMipShape& shape :
         {decode_test::LatentMipShape{31, NTC_NETWORK_GENERATION_2, 36, 28, 4, 4, 16},
          decode_test::LatentMipShape{32, NTC_NETWORK_GENERATION_3, 41, 31, 5, 3, 12}}) {
        CAPTURE(shape.networkVersion);
        const decode_test::LatentMipSet set(shape);
        for (const Mode& mode : kModes) {
            const std::string modeName = mode.name;
            CAPTURE(modeName);
            Totals totals;
            CompareSet(*context, set.GetSource(GetDecodeWeights(mode.math)), mode, kReferenceTexels, totals);
            CHECK(totals.hlslTexels >= static_cast<std::size_t>(shape.width * shape.height));
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("every maths mode: small mips of the conformance sets in both languages") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<std::filesystem::path> files = ListConformanceSets();
    if (files.empty()) {
        MESSAGE("SKIP: no conformance vectors in the shared folder");
        ReportVectors("conformance-modes", 0, 1);
        return;
    }
    Totals totals;
    for (const std::filesystem::path& path : files) {
        const std::string name = path.stem().string();
        CAPTURE(name);
        const decode_test::ModeSet set(ReadBytes(path));
        for (const Mode& mode : kModes) {
            const std::string modeName = mode.name;
            CAPTURE(modeName);
            if (set.HasWeights(GetDecodeWeights(mode.math)))
                CompareSet(*context, set.GetSource(GetDecodeWeights(mode.math)), mode, 32 * 32, totals);
        }
    }
    CHECK(totals.texels > 10'000);
    ReportVectors("conformance-modes", static_cast<int>(totals.texels), 0);
}

TEST_CASE("native binary16 arithmetic gives the bits of the emulated one") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().features.Has(Feature::Float16)) {
        MESSAGE("SKIP: the device lacks shaderFloat16");
        return;
    }
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        CAPTURE(version);
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, 64, 48);
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        const auto spirv = native_half_shaders::FindShader(
            "DecodeTexels.comp", GetDefines(version, NTC_MATH_FP16) + " NTC_NATIVE_FLOAT16=1");
        REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
        PassRunner runner(*context, source, *spirv);
        for (int mip = 0; mip < source.constants->imageMips; ++mip) {
            const Rect rect = GetMipRect(source, mip);
            CHECK(CountDifferent(runner.Decode(mip, rect),
                                 DecodeOnCpu(source, mip, rect, DecodeMath::FP16)) == 0);
        }
    }
}
