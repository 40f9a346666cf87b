// SPDX-License-Identifier: MIT
// The maths modes FP8, FP16 and FP32 against an independent model: FP8 and FP16 bit for bit, FP32 within the bound that
// ModeModel.h derives.
#include "FastDecoderCases.h"
#include "LatentMipSets.h"
#include "ModeSets.h"
#include "models/ModeModel.h"
#include "models/NumberFormats.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/E4M3.h"
#include "openntc/core/Half.h"
#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <string>

namespace models = openntc::models;
namespace shader = openntc::shader;
using openntc::DecodeMath;
using openntc::DecodeWeights;

namespace {

models::ModelSource GetModelSource(const openntc::DecodeSource& source) {
    return {source.constants, source.latents, source.weights, source.networkVersion};
}

/// Calls check(mip, x, y, outputs) for every texel of every mip, and for a frame of four texels round mip 0.
template <typename Check>
int ForEachTexel(const openntc::DecodeSource& source, DecodeMath math, Check check) {
    int texels = 0;
    for (int mip = 0; mip < source.constants->imageMips; ++mip) {
        const int frame = mip == 0 ? 4 : 0;
        const int width = std::max(source.constants->imageWidth >> mip, 1) + 2 * frame;
        const int height = std::max(source.constants->imageHeight >> mip, 1) + 2 * frame;
        std::vector<float> outputs(static_cast<std::size_t>(width * height) * 16);
        const auto result = openntc::DecodeReference(source, mip, {-frame, -frame, width, height},
                                                     {.math = math, .convertToLinear = false}, outputs);
        REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
        for (int i = 0; i < width * height; ++i) {
            check(mip, i % width - frame, i / width - frame,
                  std::span(outputs).subspan(static_cast<std::size_t>(i) * 16, 16));
            ++texels;
        }
    }
    return texels;
}

template <typename Model>
void CheckBits(DecodeMath math, Model model, int lastVersion) {
    for (int version = NTC_NETWORK_SMALL; version <= lastVersion; ++version) {
        CAPTURE(version);
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, 27, 22);
        const openntc::DecodeSource source = set.GetSource(openntc::GetDecodeWeights(math));
        int different = 0;
        double spread = 0;
        const int texels =
            ForEachTexel(source, math, [&](int mip, int x, int y, std::span<const float> outputs) {
                const std::array<double, 16> expected = model(GetModelSource(source), mip, x, y);
                for (std::size_t c = 0; c < 16; ++c) {
                    different += static_cast<double>(outputs[c]) != expected[c];
                    spread = std::max(spread, std::fabs(expected[c]));
                }
            });
        CHECK(texels > 1000);
        CHECK(different == 0);
        CHECK(spread > 0.25); // a network that does something
        CHECK(spread < 1000);
    }
}

} // namespace

TEST_CASE("FP8 equals the independent model bit for bit, every network") {
    CheckBits(DecodeMath::FP8, models::DecodeFP8Model, NTC_NETWORK_GENERATION_3);
}

TEST_CASE("FP16 equals the independent model bit for bit, networks of generation 1") {
    CheckBits(DecodeMath::FP16, models::DecodeFP16Model, NTC_NETWORK_XLARGE);
}

TEST_CASE("FP32 lies within the derived bound of the network in double, every network") {
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        CAPTURE(version);
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, 27, 22);
        const openntc::DecodeSource source = set.GetSource(DecodeWeights::Int8);
        double worst = 0; // error in units of its bound
        double largest = 0;
        double deviations = 0; // error in units of its expected deviation
        ForEachTexel(source, DecodeMath::FP32, [&](int mip, int x, int y, std::span<const float> outputs) {
            const models::BoundedOutputs expected =
                models::DecodeFP32Model(GetModelSource(source), mip, x, y);
            for (std::size_t c = 0; c < 16; ++c) {
                const double error = std::fabs(static_cast<double>(outputs[c]) - expected.values[c]);
                largest = std::max(largest, error);
                worst = std::max(worst, error / expected.bounds[c]);
                deviations = std::max(deviations, error / expected.deviations[c]);
                CHECK(expected.deviations[c] < 5e-5);
            }
        });
        MESSAGE("network " << version << ": largest error " << largest << ", " << worst << " of the bound, "
                           << deviations << " expected deviations");
        CHECK(worst <= 1);
        CHECK(deviations <= 2); // roundings are at most u, not of deviation u: 0.3 is usual
    }
}

TEST_CASE("rounding to E4M3 and widening equal the codec of the core library") {
    int wrong = 0;
    const auto check = [&](float x) {
        const float expected = openntc::E4M3ToFloat(openntc::FloatToE4M3(x));
        wrong +=
            std::bit_cast<std::uint32_t>(shader::NtcRoundToE4M3(x)) != std::bit_cast<std::uint32_t>(expected);
    };
    // Every half: all E4M3 numbers, their midpoints, and much in between; with their neighbouring floats.
    for (std::uint32_t half = 0; half < 0x7C00; ++half) {
        const std::uint32_t bits =
            std::bit_cast<std::uint32_t>(openntc::HalfToFloat(static_cast<std::uint16_t>(half)));
        for (const std::uint32_t neighbour : {bits, bits + 1, bits == 0 ? 0 : bits - 1}) {
            check(std::bit_cast<float>(neighbour));
            check(std::bit_cast<float>(neighbour | 0x80000000u));
        }
    }
    check(std::numeric_limits<float>::infinity());
    check(-std::numeric_limits<float>::infinity());
    CHECK(wrong == 0);
    CHECK(shader::NtcIsNan(shader::NtcRoundToE4M3(std::numeric_limits<float>::quiet_NaN())));
    for (std::uint32_t code = 0; code < 256; ++code) {
        if ((code & 0x7F) != 0x7F)
            wrong += shader::NtcWidenE4M3(code << 16 | 0x55000055u, 2) !=
                     openntc::E4M3ToFloat(static_cast<std::uint8_t>(code));
    }
    for (std::uint32_t code = 0; code < 0x10000; ++code) {
        if ((code & 0x7C00) != 0x7C00)
            wrong += std::bit_cast<std::uint32_t>(shader::NtcWidenHalf(code | 0xABCD0000u)) !=
                     std::bit_cast<std::uint32_t>(openntc::HalfToFloat(static_cast<std::uint16_t>(code)));
    }
    CHECK(wrong == 0);
}

TEST_CASE("a maths mode needs its weights; the fast decoder says what it lacks") {
    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 16, 16);
    const openntc::DecodeSource int8 = set.GetSource(DecodeWeights::Int8);
    const openntc::DecodeSource fp8 = set.GetSource(DecodeWeights::FP8);
    std::vector<float> outputs(16);
    const auto decode = [&](const openntc::DecodeSource& source, DecodeMath math) {
        const auto result = openntc::DecodeReference(source, 0, {0, 0, 1, 1},
                                                     {.math = math, .convertToLinear = false}, outputs);
        return result ? openntc::Status::Ok : result.error().GetStatus();
    };
    for (const DecodeMath math :
         {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP16, DecodeMath::FP32}) {
        CHECK(decode(int8, math) == openntc::Status::Ok);
        CHECK(decode(fp8, math) == openntc::Status::InvalidArgument);
    }
    CHECK(decode(fp8, DecodeMath::FP8) == openntc::Status::Ok);
    CHECK(decode(int8, DecodeMath::FP8) == openntc::Status::InvalidArgument);
    CHECK(decode(int8, static_cast<DecodeMath>(6)) == openntc::Status::InvalidArgument);
    CHECK(decode(int8, static_cast<DecodeMath>(0)) == openntc::Status::InvalidArgument);

    // Constants of one format given as the other.
    openntc::DecodeSource mislabelled = int8;
    mislabelled.weightFormat = DecodeWeights::FP8;
    CHECK_FALSE(openntc::ValidateDecodeSource(mislabelled));
    mislabelled = fp8;
    mislabelled.weightFormat = DecodeWeights::Int8;
    CHECK_FALSE(openntc::ValidateDecodeSource(mislabelled));
    mislabelled = fp8;
    mislabelled.weights = fp8.weights.first(fp8.weights.size() - 1);
    CHECK_FALSE(openntc::ValidateDecodeSource(mislabelled));

    CHECK(openntc::FastDecoder::Create(fp8).error().GetStatus() == openntc::Status::Unsupported);
    const auto fast = openntc::FastDecoder::Create(int8);
    REQUIRE(fast);
    for (const DecodeMath math : {DecodeMath::FP8, DecodeMath::FP16, DecodeMath::FP32}) {
        const auto result = fast->Decode(0, {0, 0, 1, 1}, {.math = math, .convertToLinear = false}, outputs);
        REQUIRE_FALSE(result);
        CHECK(result.error().GetStatus() == openntc::Status::Unsupported);
    }
}

TEST_CASE("sums of the FP16 mode round to the nearest half, subnormal ones too") {
    // Every half, the ties between neighbours, and the floats beside both: sums below 2^-14 are multiples of 2^-24.
    int wrong = 0;
    const auto check = [&](double x) {
        const double expected = models::ToHalf(x);
        wrong += static_cast<double>(shader::NtcRoundSum(static_cast<float>(x))) != expected;
        wrong += static_cast<double>(shader::NtcRoundSum(static_cast<float>(-x))) != -expected;
    };
    for (std::uint32_t half = 0; half < 0x7BFF; ++half) {
        const double low = models::HalfValue(static_cast<std::uint16_t>(half));
        const double high = models::HalfValue(static_cast<std::uint16_t>(half + 1));
        const auto tie = static_cast<float>((low + high) / 2);
        check(low);
        check(static_cast<double>(tie));
        check(static_cast<double>(std::nextafter(tie, 0.0f)));
        check(static_cast<double>(std::nextafter(tie, 65504.0f)));
    }
    CHECK(wrong == 0);
    // Of two terms: 2^-24 + 2^-24 and 2^-14 - 2^-24 are halves; half a quantum goes to the even neighbour.
    CHECK(shader::NtcAddHalf(0x1p-24f, 0x1p-24f) == 0x1p-23f);
    CHECK(shader::NtcAddHalf(0x1p-14f, -0x1p-24f) == 0x1p-14f - 0x1p-24f);
    CHECK(shader::NtcMultiplyHalf(3.0f, 0x1p-25f) == 0x1p-23f);
    CHECK(shader::NtcMultiplyHalf(1.0f, 0x1p-25f) == 0.0f);
}

TEST_CASE("levels of detail that are not finite have a defined result in every mode") {
    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 16, 16);
    const float infinity = std::numeric_limits<float>::infinity();
    for (const DecodeMath math : {DecodeMath::FP8, DecodeMath::FP16, DecodeMath::FP32}) {
        openntc::DecodeSource source = set.GetSource(openntc::GetDecodeWeights(math));
        openntc::NtcTextureSetConstants constants = *source.constants;
        source.constants = &constants;
        for (const float lod : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN(), 3e38f}) {
            constants.colorMips[0].positionLod = lod;
            constants.colorMips[0].positionScale = lod;
            std::vector<float> outputs(16 * 16, -77.0f);
            REQUIRE(openntc::DecodeReference(source, 0, {0, 0, 4, 4},
                                             {.math = math, .convertToLinear = false}, outputs));
            for (const float value : outputs)
                CHECK(std::isfinite(value));
        }
    }
}

TEST_CASE("checksums of the decoders are the same in every build") {
    std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    decode_test::CheckChecksums("reference", [](const openntc::DecodeSource& source, int mip,
                                                const openntc::Rect& rect, openntc::DecodeOptions options) {
        std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
        REQUIRE(openntc::DecodeReference(source, mip, rect, options, outputs));
        return outputs;
    });
    decode_test::CheckLatentMipChecksums("reference", [](const openntc::DecodeSource& source, int mip,
                                                         const openntc::Rect& rect,
                                                         openntc::DecodeOptions options) {
        std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
        REQUIRE(openntc::DecodeReference(source, mip, rect, options, outputs));
        return outputs;
    });
    for (decode_test::FastTarget& target : targets) {
        for (const int threads : {1, 2, 3, 8}) {
            target.options.threads = threads;
            decode_test::CheckChecksums(
                target.name,
                [&](const openntc::DecodeSource& source, int mip, const openntc::Rect& rect,
                    const openntc::DecodeOptions& options) {
                    return decode_test::DecodeFast(source, target, mip, rect, options);
                },
                2);
            decode_test::CheckLatentMipChecksums(
                target.name,
                [&](const openntc::DecodeSource& source, int mip, const openntc::Rect& rect,
                    const openntc::DecodeOptions& options) {
                    return decode_test::DecodeFast(source, target, mip, rect, options);
                },
                2);
        }
    }
}
