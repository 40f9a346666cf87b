// SPDX-License-Identifier: MIT
// The shader of cooperative vectors as C++, on vectors that are arrays: its arithmetic is that of the emulated modes, for
// networks of every generation. What a device's multiplications give is tested on devices.
#include "EmulatedNetworks.h"
#include "unit/decode/ModeSets.h"

#include <doctest/doctest.h>

#include <bit>

using namespace openntc;
using namespace openntc_tests;

namespace {

struct Variant {
    const char* name;
    EmulatedNetwork evaluate;
    int network;
    int math; ///< of the reference
};

constexpr Variant kVariants[] = {
    {"medium INT8", EvaluateMediumInt8, NTC_NETWORK_MEDIUM, NTC_MATH_INT8},
    {"medium FP8", EvaluateMediumFP8, NTC_NETWORK_MEDIUM, NTC_MATH_FP8},
    {"gen2 INT8", EvaluateSecondInt8, NTC_NETWORK_GENERATION_2, NTC_MATH_INT8},
    {"gen2 FP8", EvaluateSecondFP8, NTC_NETWORK_GENERATION_2, NTC_MATH_FP8},
    {"gen3 INT8", EvaluateThirdInt8, NTC_NETWORK_GENERATION_3, NTC_MATH_INT8},
    {"gen3 FP8", EvaluateThirdFP8, NTC_NETWORK_GENERATION_3, NTC_MATH_FP8},
    {"gen3 INT8, packed in the shader", EvaluateThirdExplicit, NTC_NETWORK_GENERATION_3, NTC_MATH_INT8},
};

/// Inputs of a texel and the outputs of the emulated mode.
EmulatedInputs EvaluateReference(const Variant& variant, const DecodeSource& source, shader::int2 texel,
                                 float (&outputs)[NTC_MAX_CHANNELS]) {
    const NtcTextureSetConstants& desc = *source.constants;
    const shader::NtcBuffer latents = {source.latents.data(), source.latents.size()};
    const shader::NtcBuffer weights = {source.weights.data(), source.weights.size()};
    const shader::NtcMip mip = shader::NtcGetMip(desc, 0);
    const shader::NtcLayerOffsets layers = shader::NtcGetLayerOffsets(desc);
    EmulatedInputs inputs;
    if (variant.math == NTC_MATH_FP8) {
        REQUIRE(shader::NtcPrepareRealInputsFrom(variant.network, variant.math, mip, latents, 0, texel,
                                                 inputs.numbers));
        shader::NtcEvaluateE4M3Network(variant.network, weights, 0, layers, inputs.numbers, outputs);
    } else {
        REQUIRE(shader::NtcPrepareNetworkInputsFrom(variant.network, mip, latents, 0, texel, inputs.words));
        shader::NtcEvaluateNetwork(variant.network, variant.math, weights, 0, layers, inputs.words, outputs);
    }
    return inputs;
}

} // namespace

TEST_CASE("cooperative vectors as arrays: the bits of INT8 and FP8, for networks of every generation") {
    constexpr int kWidth = 37, kHeight = 29;
    for (const Variant& variant : kVariants) {
        CAPTURE(variant.name);
        const decode_test::ModeSet set = decode_test::MakeModeSet(variant.network, kWidth, kHeight);
        const DecodeSource source =
            set.GetSource(variant.math == NTC_MATH_FP8 ? DecodeWeights::FP8 : DecodeWeights::Int8);
        std::size_t different = 0, distinct = 0;
        float first[NTC_MAX_CHANNELS] = {};
        for (int i = 0; i < kWidth * kHeight; ++i) {
            float expected[NTC_MAX_CHANNELS] = {}, outputs[NTC_MAX_CHANNELS] = {};
            const EmulatedInputs inputs =
                EvaluateReference(variant, source, {i % kWidth, i / kWidth}, expected);
            variant.evaluate(source.weights, shader::NtcGetLayerOffsets(*source.constants), inputs, outputs);
            if (i == 0)
                std::copy(std::begin(expected), std::end(expected), std::begin(first));
            for (std::size_t c = 0; c < NTC_MAX_CHANNELS; ++c) {
                different +=
                    std::bit_cast<std::uint32_t>(outputs[c]) != std::bit_cast<std::uint32_t>(expected[c]) ? 1
                                                                                                          : 0;
                distinct += expected[c] != first[c] ? 1 : 0;
            }
        }
        CHECK(different == 0);
        CHECK(distinct > 0); // something was decoded
    }
}
