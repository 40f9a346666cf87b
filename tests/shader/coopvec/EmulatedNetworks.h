// SPDX-License-Identifier: MIT
// InferenceCoopVec.h compiled as C++, once for each network and maths mode of the list: EmulatedVariant.h makes them.
#pragma once

#include "openntc/Inference.h"

#include <cstddef>
#include <span>

namespace openntc_tests {

/// What a texel's network reads: packed bytes for Int8, E4M3 numbers for FP8.
struct EmulatedInputs {
    openntc::shader::uint words[NTC_MAX_INPUT_WORDS] = {};
    float numbers[NTC_MAX_INPUTS] = {};
};

using EmulatedNetwork = void (*)(std::span<const std::byte> weights,
                                 const openntc::shader::NtcLayerOffsets& layers, const EmulatedInputs& inputs,
                                 float (&outputs)[NTC_MAX_CHANNELS]);

#define NTC_EMULATED_NETWORK(name)                                                                           \
    void name(std::span<const std::byte> weights, const openntc::shader::NtcLayerOffsets& layers,            \
              const EmulatedInputs& inputs, float(&outputs)[NTC_MAX_CHANNELS])
NTC_EMULATED_NETWORK(EvaluateMediumInt8);
NTC_EMULATED_NETWORK(EvaluateMediumFP8);
NTC_EMULATED_NETWORK(EvaluateSecondInt8);
NTC_EMULATED_NETWORK(EvaluateSecondFP8);
NTC_EMULATED_NETWORK(EvaluateThirdInt8);
NTC_EMULATED_NETWORK(EvaluateThirdFP8);
NTC_EMULATED_NETWORK(EvaluateThirdExplicit);

} // namespace openntc_tests
