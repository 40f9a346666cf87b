// SPDX-License-Identifier: MIT
// What the tests of the fast decoder share: the targets of this machine and the comparison with the reference
// decoder.
#pragma once

#include "SpecificationSets.h"

#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

namespace decode_test {

struct FastTarget {
    const char* name;
    openntc::FastDecoderOptions options;
};

/// Every kernel that this machine can run; the others are named in the output.
inline std::vector<FastTarget> GetFastTargets(int threads) {
    using openntc::SimdTarget;
    std::vector<FastTarget> targets;
    for (const SimdTarget target : {SimdTarget::Portable, SimdTarget::Avx2, SimdTarget::AvxVnni,
                                    SimdTarget::Avx512Vnni, SimdTarget::Amx}) {
        const char* name = openntc::SimdTargetToString(target);
        if (openntc::IsSimdTargetAvailable(target))
            targets.push_back({name, {.target = target, .threads = threads}});
        else
            MESSAGE("SKIP: " << std::string(name) << ": not on this machine or in this build");
    }
    return targets;
}

inline std::vector<float> DecodeFast(const openntc::DecodeSource& source, const FastTarget& target, int mip,
                                     const openntc::Rect& rect, const openntc::DecodeOptions& options) {
    const std::size_t count =
        static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height) * NTC_MAX_CHANNELS;
    std::vector<float> outputs(count + NTC_MAX_CHANNELS, -77.0f); // one guard texel
    const auto decoder = openntc::FastDecoder::Create(source, target.options);
    if (!decoder)
        FAIL(std::string(decoder.error().GetText()));
    const auto result = decoder->Decode(mip, rect, options, outputs);
    if (!result)
        FAIL(std::string(result.error().GetText()));
    for (std::size_t i = count; i < outputs.size(); ++i)
        REQUIRE(outputs[i] == -77.0f);
    outputs.resize(count);
    return outputs;
}

/// All kernels, both maths modes, stored and linear outputs: the bits of the reference decoder.
inline void CompareWithReference(const openntc::DecodeSource& source, int mip, const openntc::Rect& rect,
                                 const std::vector<FastTarget>& targets) {
    std::vector<float> expected(static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height) *
                                NTC_MAX_CHANNELS);
    for (const openntc::DecodeMath math : {openntc::DecodeMath::Int8, openntc::DecodeMath::Int8Half}) {
        for (const bool linear : {false, true}) {
            const openntc::DecodeOptions options{.math = math, .convertToLinear = linear};
            const auto reference = openntc::DecodeReference(source, mip, rect, options, expected);
            if (!reference)
                FAIL(std::string(reference.error().GetText()));
            for (const FastTarget& target : targets) {
                const std::vector<float> outputs = DecodeFast(source, target, mip, rect, options);
                std::size_t different = 0;
                for (std::size_t i = 0; i < expected.size(); ++i)
                    different += std::memcmp(&expected[i], &outputs[i], sizeof(float)) != 0 ? 1u : 0u;
                INFO("mip " << mip << " rect " << rect.left << "," << rect.top << "," << rect.width << ","
                            << rect.height << " network " << source.networkVersion << " half "
                            << (math == openntc::DecodeMath::Int8Half) << " linear " << linear << " target "
                            << std::string(target.name));
                CHECK(different == 0);
            }
        }
    }
}

inline void CompareWithReference(const SpecificationSet& set, int mip, const openntc::Rect& rect,
                                 const std::vector<FastTarget>& targets) {
    CompareWithReference(GetSource(set), mip, rect, targets);
}

} // namespace decode_test
