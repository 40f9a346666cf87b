// SPDX-License-Identifier: MIT
// Stability: internal
// Row loops of the optimiser and of the latents with AVX-512.
#pragma once

#include "openntc/encode/detail/AmxSupport.h"

#if defined(OPENNTC_ENCODE_AMX)

#if !defined(__clang__)
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

struct Avx512Rows : PlainWeightRows {
    /// Working weights of inputs `input`, which is even, and `input` + 1 to the outputs of a column: integers
    /// q[2][16], real[o] of them in real units.
    static void PackRows(PackedNetwork& packed, const NetworkShape& shape, int layer, int column, int input,
                         const float (&q)[2][16], const float* real) {
        const int tiles = layer == 3 ? 1 : 2, inputs = shape.LayerInputs(layer);
        std::uint16_t* forward = packed.forward.data() + PackedNetwork::ForwardOffset(shape, layer) +
                                 column * 16 * inputs + (input / 32) * 512 + input % 32;
        std::uint16_t* backward = packed.backward.data() + PackedNetwork::BackwardOffset(shape, layer) +
                                  ((input / 16) * tiles + column / 2) * 512 + (input % 16) * 32 +
                                  (column % 2) * 16;
        for (int k = 0; k < 2; ++k) {
            for (int o = 0; o < 16; ++o) {
                forward[o * 32 + k] = ToBfloat16(q[k][o]);
                backward[k * 32 + o] = ToBfloat16(q[k][o] * real[o]);
            }
        }
    }

    __attribute__((flatten)) OPENNTC_AMX_TARGET static void TexelLosses(const KernelContext& context,
                                                                        const TileTask& tile,
                                                                        const float* outputs, int stride,
                                                                        float* to, std::size_t pitch) {
        WriteTexelLosses(context, tile, outputs, stride, to, pitch);
    }
    /// Adam on `count` parameters; those whose gradient is exactly 0 keep value and moments. Values that are
    /// not finite become 0.
    OPENNTC_AMX_TARGET static void AdamRow(float* values, float* first, float* second, const float* gradients,
                                           int count, const AdamStep& step, float lowest, float highest) {
        const __m512 b1 = _mm512_set1_ps(1.0f - step.beta1), b2 = _mm512_set1_ps(1.0f - step.beta2),
                     rate = _mm512_set1_ps(step.rate), correction = _mm512_set1_ps(step.secondCorrection),
                     epsilon = _mm512_set1_ps(AdamStep::kEpsilon), low = _mm512_set1_ps(lowest),
                     high = _mm512_set1_ps(highest);
        for (int i = 0; i < count; i += 16) {
            const auto lanes =
                count - i >= 16 ? __mmask16(0xffff) : static_cast<__mmask16>((1u << (count - i)) - 1u);
            const __m512 g = _mm512_maskz_loadu_ps(lanes, gradients + i);
            const __mmask16 touched = _mm512_cmp_ps_mask(g, _mm512_setzero_ps(), _CMP_NEQ_OQ);
            if (touched == 0)
                continue;
            const __m512 w = _mm512_maskz_loadu_ps(lanes, values + i);
            __m512 m = _mm512_maskz_loadu_ps(lanes, first + i), v = _mm512_maskz_loadu_ps(lanes, second + i);
            m = _mm512_fmadd_ps(b1, _mm512_sub_ps(g, m), m);
            v = _mm512_fmadd_ps(b2, _mm512_sub_ps(_mm512_mul_ps(g, g), v), v);
            const __m512 change = _mm512_div_ps(
                _mm512_mul_ps(rate, m), _mm512_add_ps(_mm512_sqrt_ps(_mm512_mul_ps(v, correction)), epsilon));
            __m512 updated = _mm512_min_ps(_mm512_max_ps(_mm512_sub_ps(w, change), low), high);
            updated = _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(change, change, _CMP_ORD_Q), updated);
            _mm512_mask_storeu_ps(values + i, touched, updated);
            _mm512_mask_storeu_ps(first + i, touched, m);
            _mm512_mask_storeu_ps(second + i, touched, v);
        }
    }
    /// Latents rounded to their levels (format specification: "Encode"), as integer network inputs.
    OPENNTC_AMX_TARGET static void RoundRow(const float* from, float* to, int count,
                                            const LatentQuantiser& quantiser) {
        const __m512 scale = _mm512_set1_ps(quantiser.scale), input = _mm512_set1_ps(quantiser.levelInput),
                     half = _mm512_set1_ps(0.5f),
                     low = _mm512_set1_ps(static_cast<float>(quantiser.lowestLevel)),
                     high = _mm512_set1_ps(static_cast<float>(quantiser.highestLevel));
        for (int i = 0; i < count; i += 16) {
            const auto lanes =
                count - i >= 16 ? __mmask16(0xffff) : static_cast<__mmask16>((1u << (count - i)) - 1u);
            const __m512 level = Floor(_mm512_fmadd_ps(_mm512_maskz_loadu_ps(lanes, from + i), scale, half));
            _mm512_mask_storeu_ps(to + i, lanes,
                                  _mm512_mul_ps(_mm512_min_ps(_mm512_max_ps(level, low), high), input));
        }
    }
    /// Latents with uniform noise of one level's width, as real-valued network inputs.
    OPENNTC_AMX_TARGET static void NoiseRow(const float* from, float* to, int count,
                                            const LatentQuantiser& quantiser, std::uint32_t seed) {
        const __m512 scale = _mm512_set1_ps(quantiser.scale), input = _mm512_set1_ps(quantiser.levelInput);
        for (int i = 0; i < count; i += 16) {
            const auto lanes =
                count - i >= 16 ? __mmask16(0xffff) : static_cast<__mmask16>((1u << (count - i)) - 1u);
            alignas(64) float noise[16];
            for (std::uint32_t k = 0; k < 16; ++k)
                noise[k] = ToUnit(Hash(seed + static_cast<std::uint32_t>(i) + k)) - 0.5f;
            const __m512 level =
                _mm512_fmadd_ps(_mm512_maskz_loadu_ps(lanes, from + i), scale, _mm512_load_ps(noise));
            _mm512_mask_storeu_ps(to + i, lanes, _mm512_mul_ps(level, input));
        }
    }
};

} // namespace openntc::encode::detail

#if !defined(__clang__)
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
