// SPDX-License-Identifier: MIT
// Files of LibNTC 0.9.2 against LibNTC's own decode of them (CUDA) and the texels that it was given.
//
// CUDA's arithmetic is binary16, and it floors every input where the shader truncates waves and level of detail, so its
// texels are not those of the shader, which is the contract. A model of CUDA (CudaModel.h) has nine in ten of its numbers
// bit for bit; what the contract's arithmetic may change is derived from that, and has to hold for every record.
#include "conformance/ConformanceFolder.h"
#include "conformance/CudaModel.h"
#include "support/Vectors.h"
#include "unit/decode/ModeSets.h"

#include "openntc/core/Half.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

constexpr std::size_t kTexelsHeader = 16;
constexpr std::size_t kTexelRecord = 304;
constexpr std::size_t kCudaInt8 = 208, kCudaFP8 = 240, kOriginal = 272;

/// Records of a set's .texels.
class Records {
public:
    explicit Records(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
    std::size_t GetCount() const { return (bytes_.size() - kTexelsHeader) / kTexelRecord; }
    int GetPlace(std::size_t record, std::size_t field) const {
        return LoadAt<std::int32_t>(bytes_, kTexelsHeader + record * kTexelRecord + 4 * field);
    }
    double Get(std::size_t record, std::size_t block, std::size_t channel) const {
        return static_cast<double>(HalfToFloat(
            LoadAt<std::uint16_t>(bytes_, kTexelsHeader + record * kTexelRecord + block + 2 * channel)));
    }

private:
    std::vector<std::byte> bytes_;
};

struct MeanSquare {
    double sum = 0, count = 0;
    void Add(double difference) {
        sum += difference * difference;
        count += 1;
    }
    double GetDecibels() const { return -10 * std::log10(sum / count); }
};

std::array<float, 16> DecodeRecord(const DecodeSource& source, const Records& records, std::size_t i,
                                   DecodeMath math) {
    std::array<float, 16> outputs{};
    const auto result = DecodeReference(source, records.GetPlace(i, 0),
                                        {records.GetPlace(i, 1), records.GetPlace(i, 2), 1, 1},
                                        {.math = math, .convertToLinear = false}, outputs);
    REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    return outputs;
}

/// PSNR against the source's texels in decibels: ours, and LibNTC's.
std::array<double, 2> ComparePsnr(const DecodeSource& source, const Records& records, DecodeMath math,
                                  std::uint32_t channels) {
    MeanSquare ours, theirs;
    const std::size_t block = math == DecodeMath::FP8 ? kCudaFP8 : kCudaInt8;
    for (std::size_t i = 0; i < records.GetCount(); ++i) {
        const std::array<float, 16> outputs = DecodeRecord(source, records, i, math);
        for (std::size_t c = 0; c < 16; ++c) {
            if ((channels >> c & 1u) == 0)
                continue;
            const double original = records.Get(i, kOriginal, c);
            ours.Add(static_cast<double>(outputs[c]) - original);
            theirs.Add(records.Get(i, block, c) - original);
        }
    }
    return {ours.GetDecibels(), theirs.GetDecibels()};
}

/// Whether every input of a texel is as near the model's as the contract's arithmetic makes it.
bool IsNear(const CudaModel& model, const std::array<double, 48>& own, const std::array<double, 48>& inputs) {
    for (std::size_t k = 0; k < 48; ++k) {
        if (!(std::fabs(own[k] - inputs[k]) <= model.GetInputTolerance(own[k], inputs[k])))
            return false;
    }
    return true;
}

struct CudaDifferences {
    int numbers = 0, sameAsModel = 0, beyondBound = 0;
    int records = 0, farInputs = 0;
    std::array<int, 4>
        mistakes{}; ///< found by inputs: clamped latents, layers swapped, one latent mip, a texel aside
    double largest = 0, largestShare = 0; ///< of the bound
    MeanSquare model, theirs;
};

/// The decoder's own inputs of a texel, as the network takes them.
std::array<double, 48> GetOwnInputs(const DecodeSource& source, DecodeMath math, int mip, int x, int y) {
    const shader::NtcBuffer latents = {source.latents.data(), source.latents.size()};
    std::array<double, 48> inputs{};
    if (math == DecodeMath::FP8) {
        float values[NTC_MAX_INPUTS];
        REQUIRE(shader::NtcPrepareRealInputsFrom(source.networkVersion, NTC_MATH_FP8,
                                                 shader::NtcGetMip(*source.constants, mip), latents, 0,
                                                 {x, y}, values));
        for (std::size_t k = 0; k < 48; ++k)
            inputs[k] = models::ToE4M3(static_cast<double>(values[k]));
        return inputs;
    }
    shader::uint words[NTC_MAX_INPUT_WORDS];
    REQUIRE(shader::NtcPrepareNetworkInputs(source.networkVersion, *source.constants, latents, 0, {x, y}, mip,
                                            words));
    for (std::size_t k = 0; k < 48; ++k)
        inputs[k] = shader::NtcSignedByte(words[k / 4], static_cast<shader::uint>(k % 4)) / 127.5;
    return inputs;
}

CudaDifferences CompareWithCuda(const DecodeSource& source, const Records& records, DecodeMath math,
                                std::uint32_t channels) {
    const std::size_t block = math == DecodeMath::FP8 ? kCudaFP8 : kCudaInt8;
    const CudaModel model(source), clamped(source, false);
    CudaDifferences result;
    for (std::size_t i = 0; i < records.GetCount(); ++i) {
        const int mip = records.GetPlace(i, 0), x = records.GetPlace(i, 1), y = records.GetPlace(i, 2);
        const CudaTexel texel = model.Decode(mip, x, y);
        const std::array<double, 48> own = GetOwnInputs(source, math, mip, x, y);
        std::array<double, 48> swapped = texel.inputs, oneMip = texel.inputs;
        std::swap_ranges(swapped.begin(), swapped.begin() + 4, swapped.begin() + 4);
        std::copy(oneMip.begin(), oneMip.begin() + 16, oneMip.begin() + 16);
        result.records += 1;
        result.farInputs += !IsNear(model, own, texel.inputs);
        result.mistakes[0] += !IsNear(model, own, clamped.Decode(mip, x, y).inputs);
        result.mistakes[1] += !IsNear(model, own, swapped);
        result.mistakes[2] += !IsNear(model, own, oneMip);
        result.mistakes[3] += !IsNear(model, own, model.Decode(mip, x + 1, y).inputs);
        // A latent may be one step off in CUDA besides: its sum in binary16 lies next to where steps change.
        std::array<double, 48> inputs{};
        for (std::size_t k = 0; k < 48; ++k)
            inputs[k] =
                std::fabs(own[k] - texel.inputs[k]) + (k < 32 ? model.GetInputStep(texel.inputs[k]) : 0.0);
        const std::array<double, 16> bounds = model.GetBounds(texel, inputs);
        const std::array<float, 16> outputs = DecodeRecord(source, records, i, math);
        for (std::size_t c = 0; c < 16; ++c) {
            if ((channels >> c & 1u) == 0)
                continue;
            const double cuda = records.Get(i, block, c);
            const double difference = std::fabs(static_cast<double>(outputs[c]) - cuda);
            result.numbers += 1;
            result.sameAsModel += texel.outputs[c] == cuda;
            result.beyondBound += !(difference <= bounds[c]);
            result.largest = std::max(result.largest, difference);
            result.largestShare = std::max(result.largestShare, difference / bounds[c]);
            result.model.Add(texel.outputs[c] - records.Get(i, kOriginal, c));
            result.theirs.Add(cuda - records.Get(i, kOriginal, c));
        }
    }
    return result;
}

} // namespace

TEST_CASE("generation 3: decoded files of LibNTC 0.9.2 are as near their sources as LibNTC's own decode") {
    const std::vector<std::string> names = ListGeneration3Sets();
    if (names.empty()) {
        MESSAGE("SKIP: no conformance vectors of generation 3 in the shared folder");
        ReportVectors("generation3", 0, 1);
        return;
    }
    for (const std::string& name : names) {
        CAPTURE(name);
        const decode_test::ModeSet set(ReadBytes(GetConformanceFolder() / (name + ".ntc")));
        const Records records(ReadBytes(GetConformanceFolder() / (name + ".texels")));
        const std::uint32_t channels = set.GetMetadata().GetValidChannelMask();
        REQUIRE(set.GetMetadata().GetNetworkVersion() == NTC_NETWORK_GENERATION_3);
        std::string text = name + ": dB to the source, ours and CUDA's:";
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::FP8}) {
            const auto [ours, theirs] =
                ComparePsnr(set.GetSource(GetDecodeWeights(math)), records, math, channels);
            char part[64];
            std::snprintf(part, sizeof part, " %s %.3f %.3f;", math == DecodeMath::FP8 ? "FP8" : "INT8", ours,
                          theirs);
            text += part;
            CHECK(ours > theirs - 0.02);
        }
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        for (const DecodeMath math : {DecodeMath::Int8Half, DecodeMath::FP16, DecodeMath::FP32})
            CHECK(ComparePsnr(source, records, math, channels)[0] >
                  ComparePsnr(source, records, DecodeMath::Int8, channels)[0] - 0.1);
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::FP8}) {
            const CudaDifferences cuda =
                CompareWithCuda(set.GetSource(GetDecodeWeights(math)), records, math, channels);
            const double same = static_cast<double>(cuda.sameAsModel) / cuda.numbers;
            char part[160];
            std::snprintf(
                part, sizeof part,
                " CUDA's model %s: %.3f dB, %.1f %% of the numbers the same; ours to CUDA: at most %.3f, "
                "%.0f %% of the bound;",
                math == DecodeMath::FP8 ? "FP8" : "INT8", cuda.model.GetDecibels(), 100 * same, cuda.largest,
                100 * cuda.largestShare);
            text += part;
            // The rest are sums whose rounding in the tensor cores took another way to the next step.
            CHECK(same > 0.85);
            CHECK(std::fabs(cuda.model.GetDecibels() - cuda.theirs.GetDecibels()) < 0.02);
            CHECK(cuda.farInputs == 0);
            CHECK(cuda.beyondBound == 0);
            // The inputs' limit is narrow enough to find what would be wrong with them.
            CHECK(cuda.mistakes[0] > 0); // records on the rim alone
            for (std::size_t mistake = 1; mistake < 4; ++mistake)
                CHECK(cuda.mistakes[mistake] > 0.5 * cuda.records);
        }
        MESSAGE(text);
    }
    ReportVectors("generation3", static_cast<int>(names.size()), 0);
}
