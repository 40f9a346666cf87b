// SPDX-License-Identifier: MIT
// The same bytes whatever runs, and random sets against the independent model.
#include "Decoders.h"
#include "HardCases.h"

#include "openntc/core/Crc32.h"
#include "openntc/decode/FastDecoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <string>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace numerics {

namespace {

using namespace openntc;

/// CRC-32 of mip 0 of the set below, 16 binary32 a texel. The number is recorded here so that every compiler,
/// optimisation level, instruction set and machine that runs this test must produce it.
constexpr std::uint32_t kRecordedCrc = 0x6bcd93b3u;

TestSet MakeSet() {
    SynthesisDesc synthesis;
    synthesis.seed = 2026;
    synthesis.desc = {61, 47, 16, 1};
    synthesis.shape = {3, 12, 16, 4, 8};
    return TestSet(conformance::SynthesizeBytes(synthesis));
}

Measurement MeasureDeterminism() {
    const TestSet set = MakeSet();
    const tool::DecodeData data = set.GetData(DecodeMath::Int8);
    std::vector<float> outputs(std::size_t{61} * 47 * 16);
    double different = 0;
    int runs = 0;
    const auto check = [&](tool::Decoder& decoder) {
        std::fill(outputs.begin(), outputs.end(), 0.0f);
        REQUIRE(decoder.Decode(0, {0, 0, 61, 47}, {DecodeMath::Int8, false}, outputs));
        const std::uint32_t crc = Crc32(std::as_bytes(std::span(outputs)));
        different += crc != kRecordedCrc ? 1 : 0;
        ++runs;
        if (crc != kRecordedCrc)
            MESSAGE("CRC-32 " << crc << " in place of " << kRecordedCrc);
    };
    for (const auto& [simd, name] : tool::ListSimdTargets()) {
        for (const int threads : {1, 3}) {
            const auto decoder = tool::MakeDecoder(data, {tool::Backend::Cpu, {}, simd, threads});
            if (!decoder) {
                MESSAGE("SKIP: " << std::string(name) << ": " << std::string(decoder.error().GetText()));
                break;
            }
            check(**decoder);
            check(**decoder);
        }
    }
    const auto reference = tool::MakeDecoder(data, {tool::Backend::Reference, {}, {}, 1});
    REQUIRE(reference);
    check(**reference);
    return {different, std::to_string(runs) + " decodes of 2867 texels"};
}

// Random shapes, sizes, networks and code widths against the model.
Measurement MeasureRandomSets() {
    std::mt19937 random(20261122);
    const auto pick = [&random](std::initializer_list<int> list) {
        return list.begin()[random() % list.size()];
    };
    double worst = 0;
    for (int i = 0; i < 24; ++i) {
        SynthesisDesc synthesis;
        synthesis.seed = static_cast<std::uint32_t>(random());
        synthesis.desc = {1 + static_cast<int>(random() % 60), 1 + static_cast<int>(random() % 60), 16, 3};
        synthesis.desc.mips = std::max(synthesis.desc.width, synthesis.desc.height) >= 4 ? 3 : 1;
        synthesis.networkVersion = pick({1, 2, 3, 4});
        const int features =
            4 * (1 + static_cast<int>(random() % static_cast<unsigned>(synthesis.networkVersion)));
        const int scale = pick({2, 3, 4, 5, 6, 7, 8});
        const int lowResFeatures = pick({4, 8, 12, 16});
        const int highResBits = pick({1, 2, 4, 8});
        synthesis.shape = {scale, features, lowResFeatures, highResBits, pick({1, 2, 4, 8})};
        const TestSet set(conformance::SynthesizeBytes(synthesis));
        const DecodeMath math = i % 2 == 0 ? DecodeMath::Int8 : DecodeMath::Int8Half;
        worst = std::max(worst, Compare(set, math, set.ListTexels(23)));
    }
    return {worst, "24 sets"};
}

#if defined(__SSE2__)
/// Subnormal operands and results become zero, as in engines that set these bits for their whole process.
class FlushedSubnormals {
public:
    explicit FlushedSubnormals(bool flush) : before_(_mm_getcsr()) {
        _mm_setcsr(before_ | (flush ? 0x8040u : 0u));
    }
    ~FlushedSubnormals() { _mm_setcsr(before_); }
    FlushedSubnormals(const FlushedSubnormals&) = delete;
    FlushedSubnormals& operator=(const FlushedSubnormals&) = delete;

private:
    unsigned before_;
};
#endif

// Every decoder on the processor with subnormal numbers flushed, against its own results without. Devices: the shader tests
// dispatch DenormFlushToZero and DenormPreserve where they are offered.
Measurement MeasureFlushing() {
#if defined(__SSE2__)
    SynthesisDesc synthesis;
    synthesis.seed = 2027;
    synthesis.desc = {40, 31, 16, 1};
    synthesis.shape = {2, 4, 8, 8, 8};
    synthesis.withFP8 = true;
    const TestSet set(conformance::SynthesizeBytes(synthesis));
    double different = 0;
    int compared = 0;
    for (const DecodeMath math :
         {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP8, DecodeMath::FP16, DecodeMath::FP32}) {
        const tool::DecodeData data = set.GetData(math);
        for (const tool::Backend backend : {tool::Backend::Reference, tool::Backend::Cpu}) {
            if (backend == tool::Backend::Cpu && math != DecodeMath::Int8 && math != DecodeMath::Int8Half)
                continue;
            std::vector<float> outputs[2];
            for (const bool flushed : {false, true}) {
                outputs[flushed].resize(std::size_t{40} * 31 * 16);
                const FlushedSubnormals scope(flushed);
                const auto decoder = tool::MakeDecoder(data, {backend, {}, {}, 1});
                REQUIRE(decoder);
                REQUIRE((*decoder)->Decode(0, {0, 0, 40, 31}, {math, false}, outputs[flushed]));
            }
            for (std::size_t i = 0; i < outputs[0].size(); ++i)
                different += outputs[0][i] != outputs[1][i] ? 1 : 0;
            compared += static_cast<int>(outputs[0].size());
        }
    }
    return {different, std::to_string(compared) + " outputs"};
#else
    return {0, "not measured: no MXCSR on this machine"};
#endif
}

constexpr HardCase kDeterminismCases[] = {
    {"determinism",
     "The same bytes from every instruction set, number of threads, run, compiler and optimisation level.",
     "Reassociation, contraction, races.",
     "Integers between the layers; what is not integer is rounded once per operation. The checksum is "
     "recorded in the test; further ones, of all modes and networks, in tests/unit/decode/modes_test.cpp, "
     "which g++, "
     "clang++, -O0 to -O3, the sanitizers, Windows and aarch64 run.",
     0, MeasureDeterminism},
    {"denormal-flushing", "Subnormal binary32 numbers become zero, in operands and results.",
     "GPUs by default; processors whose MXCSR an engine has set (FTZ and DAZ).",
     "No step makes one from a finite file but a subnormal scale (see subnormal-scales): weights, latents, "
     "waves and sums "
     "are integers or multiples of 2^-24, and halves below 2^-14 are made by adding and subtracting a larger "
     "number.",
     0, MeasureFlushing},
    {"random-sets", "Random sizes, shapes, networks and code widths against the independent model.",
     "Whatever nobody thought of.", "Two implementations that share no arithmetic.", 0, MeasureRandomSets},
};

} // namespace

std::span<const HardCase> ListDeterminismCases() {
    return kDeterminismCases;
}

} // namespace numerics
