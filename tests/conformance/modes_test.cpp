// SPDX-License-Identifier: MIT
// The maths modes on the recorded texels of the conformance sets: how far each is from the exact Int8 result and from the
// source, and FP8 from LibNTC's CUDA decoder with FP8 weights (half-precision tensor arithmetic of its own: a neighbour,
// not a contract).
#include "conformance/Expectations.h"
#include "models/FP8Interval.h"
#include "models/NumberFormats.h"
#include "support/Vectors.h"
#include "unit/decode/ModeSets.h"

#include "openntc/core/Half.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

using namespace openntc;

namespace {

constexpr std::size_t kHeader = 16;
constexpr std::size_t kRecord = 304;
constexpr int kHasCudaFP8 = 4;
constexpr int kHasSource = 8;
/// Records a set: every n-th, so that all kinds of mips occur.
constexpr std::size_t kRecords = 1000;

double LoadHalf(std::span<const std::byte> bytes, std::size_t at) {
    return static_cast<double>(HalfToFloat(models::LoadAt<std::uint16_t>(bytes, at)));
}

struct SquaredError {
    double sum = 0;
    double count = 0;
    void Add(double difference) {
        sum += difference * difference;
        count += 1;
    }
    double GetDecibels() const { return -10 * std::log10(sum / count); }
};

struct SetErrors {
    std::map<DecodeMath, SquaredError> toSource;
    std::map<DecodeMath, SquaredError> toInt8;
    std::vector<double> fp8ToCuda;
    int outsideInterval = 0;
};

constexpr std::pair<const char*, DecodeMath> kModes[] = {{"INT8", DecodeMath::Int8},
                                                         {"INT8_HALF", DecodeMath::Int8Half},
                                                         {"FP16", DecodeMath::FP16},
                                                         {"FP32", DecodeMath::FP32},
                                                         {"FP8", DecodeMath::FP8}};

SetErrors Compare(const decode_test::ModeSet& set, std::span<const std::byte> texels,
                  const models::FP8Interval& interval) {
    SetErrors errors;
    const std::uint32_t mask = set.GetMetadata().GetValidChannelMask();
    const std::size_t count = (texels.size() - kHeader) / kRecord;
    for (std::size_t i = 0; i < count; i += std::max<std::size_t>(count / kRecords, 1)) {
        const std::size_t at = kHeader + i * kRecord;
        const int mip = models::LoadAt<std::int32_t>(texels, at);
        const int x = models::LoadAt<std::int32_t>(texels, at + 4);
        const int y = models::LoadAt<std::int32_t>(texels, at + 8);
        const int flags = models::LoadAt<std::int32_t>(texels, at + 12);
        for (const auto& [name, math] : kModes) {
            if (!set.HasWeights(GetDecodeWeights(math)))
                continue;
            const DecodeSource source = set.GetSource(GetDecodeWeights(math));
            float outputs[16];
            REQUIRE(DecodeReference(source, mip, {x, y, 1, 1}, {.math = math, .convertToLinear = false},
                                    outputs));
            if (math == DecodeMath::FP8) {
                const auto bounds = interval.Decode(
                    {source.constants, source.latents, source.weights, source.networkVersion}, mip, x, y);
                for (std::size_t c = 0; c < 16; ++c)
                    errors.outsideInterval += static_cast<double>(outputs[c]) < bounds[c].low ||
                                              static_cast<double>(outputs[c]) > bounds[c].high;
            }
            for (std::size_t c = 0; c < 16; ++c) {
                if ((mask >> c & 1u) == 0)
                    continue;
                const double value = static_cast<double>(outputs[c]);
                errors.toInt8[math].Add(value -
                                        static_cast<double>(models::LoadAt<float>(texels, at + 16 + 4 * c)));
                if ((flags & kHasSource) != 0)
                    errors.toSource[math].Add(value - LoadHalf(texels, at + 272 + 2 * c));
                if (math == DecodeMath::FP8 && (flags & kHasCudaFP8) != 0)
                    errors.fp8ToCuda.push_back(std::fabs(value - LoadHalf(texels, at + 240 + 2 * c)));
            }
        }
    }
    std::sort(errors.fp8ToCuda.begin(), errors.fp8ToCuda.end());
    return errors;
}

} // namespace

TEST_CASE("maths modes on the recorded texels") {
    const std::vector<std::string> names = openntc_tests::ListGeneration1Sets();
    if (names.empty()) {
        MESSAGE("SKIP: no conformance vectors in the shared folder");
        openntc_tests::ReportVectors("modes", 0, 1);
        return;
    }
    const models::FP8Interval interval({.contraction = false, .branches = 16});
    for (const std::string& name : names) {
        CAPTURE(name);
        const std::filesystem::path folder = openntc_tests::GetConformanceFolder();
        const decode_test::ModeSet set(openntc_tests::ReadBytes(folder / (name + ".ntc")));
        SetErrors errors = Compare(set, openntc_tests::ReadBytes(folder / (name + ".texels")), interval);
        std::string text = name + ":";
        for (const auto& [mode, math] : kModes) {
            if (errors.toInt8.find(math) == errors.toInt8.end())
                continue;
            char part[96];
            std::snprintf(part, sizeof part, " %s %.2f dB to source, %.2f to INT8;", mode,
                          errors.toSource[math].GetDecibels(), errors.toInt8[math].GetDecibels());
            text += part;
        }
        if (!errors.fp8ToCuda.empty()) {
            const std::vector<double>& e = errors.fp8ToCuda;
            char part[160];
            std::snprintf(part, sizeof part, " FP8 to CUDA in 1/255: median %.3f, p99 %.2f, largest %.1f",
                          255 * e[e.size() / 2], 255 * e[e.size() * 99 / 100], 255 * e.back());
            text += part;
            CHECK(255 * e[e.size() / 2] < 1);
        }
        MESSAGE(text);
        CHECK(errors.toInt8[DecodeMath::Int8].sum == 0);
        CHECK(errors.outsideInterval == 0);
        // Quantisers of step 1/127.5 and 1/80 are worth some 44 dB; a mistake in a mode costs 20 and more.
        for (const DecodeMath math : {DecodeMath::Int8Half, DecodeMath::FP16, DecodeMath::FP32})
            CHECK(errors.toInt8[math].GetDecibels() > 42);
        CHECK(errors.toSource[DecodeMath::FP32].GetDecibels() >
              errors.toSource[DecodeMath::Int8].GetDecibels() - 0.1);
    }
    openntc_tests::ReportVectors("modes", static_cast<int>(names.size()), 0);
}
