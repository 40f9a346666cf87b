// SPDX-License-Identifier: MIT
// Stability: stable
// The reference decoder: the shader source, compiled as C++. One thread, no allocation, bit-exact.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/format/NetworkDescription.h"

#include <cstddef>
#include <span>

#include "openntc/core/HideMacros.h"

#include "openntc/Inference.h" // and GLM: their min, max, abs and round are names too

namespace openntc {

// The shaders' own spelling of the network's geometry.
static_assert(4 * NTC_HIDDEN_WORDS == kHiddenChannels && 4 * NTC_MAX_INPUT_WORDS == kMaxNetworkInputs &&
              NTC_LAYER_OUTPUTS == kNetworkOutputs);

namespace detail {

template <int networkVersion, int math>
void DecodeReferenceRect(const DecodeSource& source, int mip, const Rect& rect, bool convertToLinear,
                         std::span<float> outputs) {
    const shader::NtcBuffer latents{source.latents.data(), source.latents.size()};
    const shader::NtcBuffer weights{source.weights.data(), source.weights.size()};
    std::size_t at = 0;
    float texel[NTC_MAX_CHANNELS];
    for (int y = 0; y < rect.height; ++y) {
        for (int x = 0; x < rect.width; ++x) {
            shader::NtcSampleTextureSet(networkVersion, math, *source.constants, latents, 0, weights, 0,
                                        shader::int2(rect.left + x, rect.top + y), mip, convertToLinear,
                                        texel);
            for (const float value : texel)
                outputs[at++] = value;
        }
    }
}

template <int networkVersion>
void DecodeReferenceVersion(const DecodeSource& source, int mip, const Rect& rect,
                            const DecodeOptions& options, std::span<float> outputs) {
    const bool toLinear = options.convertToLinear;
    switch (options.math) {
    case DecodeMath::Int8:
        return DecodeReferenceRect<networkVersion, NTC_MATH_INT8>(source, mip, rect, toLinear, outputs);
    case DecodeMath::Int8Half:
        return DecodeReferenceRect<networkVersion, NTC_MATH_INT8_HALF>(source, mip, rect, toLinear, outputs);
    case DecodeMath::FP8:
        return DecodeReferenceRect<networkVersion, NTC_MATH_FP8>(source, mip, rect, toLinear, outputs);
    case DecodeMath::FP16:
        return DecodeReferenceRect<networkVersion, NTC_MATH_FP16>(source, mip, rect, toLinear, outputs);
    case DecodeMath::FP32:
        return DecodeReferenceRect<networkVersion, NTC_MATH_FP32>(source, mip, rect, toLinear, outputs);
    }
}

} // namespace detail

/// Decodes a rectangle of texels of one mip: 16 binary32 per texel, texels row by row, all network outputs
/// (also those that no texture covers), in storage colour space unless options say otherwise. The rectangle
/// may lie outside the image: latents are clamped there (of generations 2 and 3 they wrap), positional inputs
/// are not. Errors: those of
/// ValidateDecodeSource; InvalidArgument for a maths mode that needs other weights; OutOfRange for mip,
/// rectangle or too few outputs; Unsupported if the latents of the mip are absent.
inline Expected<void> DecodeReference(const DecodeSource& source, int mip, Rect rect,
                                      const DecodeOptions& options, std::span<float> outputs) {
    OPENNTC_CHECK(ValidateDecodeSource(source));
    OPENNTC_CHECK(detail::ValidateDecodeMath(options.math, source.weightFormat));
    OPENNTC_CHECK(detail::ValidateDecodeRequest(*source.constants, mip, rect, outputs.size()));
    switch (source.networkVersion) {
    case NTC_NETWORK_SMALL:
        detail::DecodeReferenceVersion<NTC_NETWORK_SMALL>(source, mip, rect, options, outputs);
        break;
    case NTC_NETWORK_MEDIUM:
        detail::DecodeReferenceVersion<NTC_NETWORK_MEDIUM>(source, mip, rect, options, outputs);
        break;
    case NTC_NETWORK_LARGE:
        detail::DecodeReferenceVersion<NTC_NETWORK_LARGE>(source, mip, rect, options, outputs);
        break;
    case NTC_NETWORK_XLARGE:
        detail::DecodeReferenceVersion<NTC_NETWORK_XLARGE>(source, mip, rect, options, outputs);
        break;
    case NTC_NETWORK_GENERATION_2:
        detail::DecodeReferenceVersion<NTC_NETWORK_GENERATION_2>(source, mip, rect, options, outputs);
        break;
    default:
        detail::DecodeReferenceVersion<NTC_NETWORK_GENERATION_3>(source, mip, rect, options, outputs);
        break;
    }
    return {};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
