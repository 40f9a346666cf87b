// SPDX-License-Identifier: MIT
// Stability: internal
// Blocked kernels for AVX-512: products in binary32, and with BF16's dot products of pairs.
#pragma once

#include "openntc/encode/detail/blocked/Support.h"

#if OPENNTC_FAST_X86
#define OPENNTC_ENCODE_AVX512 1
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma"))),         \
                             apply_to = function)
#else
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wsign-conversion" // intrinsics are macros without optimisation
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail::avx512 {

using NativeFloat = __m512;
using NativeBits = __m512i;
using NativeMask = __mmask16;
inline constexpr int kLanes = 16;
inline constexpr int kBlockRows = 8, kBlockColumns = 2;

OPENNTC_FAST_INLINE __mmask16 FirstLanes(int count) {
    return count >= 16 ? __mmask16(0xffff) : static_cast<__mmask16>((1u << (count > 0 ? count : 0)) - 1u);
}
/// The first count mod 8 lanes.
OPENNTC_FAST_INLINE void StoreFewer(float* to, __m256 v, int count) {
    __m128 rest = _mm256_castps256_ps128(v);
    if ((count & 4) != 0) {
        _mm_storeu_ps(to, rest);
        rest = _mm256_extractf128_ps(v, 1);
        to += 4;
    }
    if ((count & 2) != 0) {
        _mm_storel_pi(reinterpret_cast<__m64*>(to), rest);
        rest = _mm_movehl_ps(rest, rest);
        to += 2;
    }
    if ((count & 1) != 0)
        _mm_store_ss(to, rest);
}
OPENNTC_FAST_INLINE __m512 LoadNative(const float* from) {
    return _mm512_loadu_ps(from);
}
OPENNTC_FAST_INLINE void StoreNative(float* to, __m512 v) {
    _mm512_storeu_ps(to, v);
}
OPENNTC_FAST_INLINE __m512 LoadNativePartial(const float* from, int count) {
    return _mm512_maskz_loadu_ps(FirstLanes(count), from);
}
/// In halves: AMD's processors take long over masked stores.
OPENNTC_FAST_INLINE void StoreNativePartial(float* to, __m512 v, int count) {
    if (count >= 16)
        return _mm512_storeu_ps(to, v);
    __m256 rest = _mm512_castps512_ps256(v);
    if ((count & 8) != 0) {
        _mm256_storeu_ps(to, rest);
        rest = _mm512_extractf32x8_ps(v, 1);
        to += 8;
    }
    StoreFewer(to, rest, count);
}
OPENNTC_FAST_INLINE __m512 LoadNativeShorts(const std::uint16_t* from) {
    return _mm512_cvtepi32_ps(
        _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))));
}
OPENNTC_FAST_INLINE __m512 SetNative(float v) {
    return _mm512_set1_ps(v);
}
OPENNTC_FAST_INLINE __m512 Add(__m512 a, __m512 b) {
    return _mm512_add_ps(a, b);
}
OPENNTC_FAST_INLINE __m512 Subtract(__m512 a, __m512 b) {
    return _mm512_sub_ps(a, b);
}
OPENNTC_FAST_INLINE __m512 Multiply(__m512 a, __m512 b) {
    __m512 product = _mm512_mul_ps(a, b);
    __asm__("" : "+v"(product)); // keeps compilers from fusing it with an addition
    return product;
}
OPENNTC_FAST_INLINE __m512 Divide(__m512 a, __m512 b) {
    return _mm512_div_ps(a, b);
}
OPENNTC_FAST_INLINE __m512 MultiplyAdd(__m512 a, __m512 b, __m512 c) {
    return _mm512_fmadd_ps(a, b, c);
}
OPENNTC_FAST_INLINE __m512 SquareRoot(__m512 v) {
    return _mm512_sqrt_ps(v);
}
OPENNTC_FAST_INLINE __m512 Min(__m512 a, __m512 b) {
    return _mm512_min_ps(a, b);
}
OPENNTC_FAST_INLINE __m512 Max(__m512 a, __m512 b) {
    return _mm512_max_ps(a, b);
}
OPENNTC_FAST_INLINE __m512 Floor(__m512 v) {
    return _mm512_roundscale_ps(v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}
OPENNTC_FAST_INLINE __m512 Truncate(__m512 v) {
    return _mm512_roundscale_ps(v, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
}
OPENNTC_FAST_INLINE __mmask16 Less(__m512 a, __m512 b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
OPENNTC_FAST_INLINE __mmask16 Equal(__m512 a, __m512 b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}
OPENNTC_FAST_INLINE __m512 Select(__mmask16 mask, __m512 a, __m512 b) {
    return _mm512_mask_mov_ps(b, mask, a);
}
OPENNTC_FAST_INLINE __m512i LoadNativeBits(const std::int32_t* from) {
    return _mm512_loadu_si512(from);
}
OPENNTC_FAST_INLINE __m512i SetNativeBits(std::uint32_t v) {
    return _mm512_set1_epi32(static_cast<int>(v));
}
OPENNTC_FAST_INLINE __m512i Add(__m512i a, __m512i b) {
    return _mm512_add_epi32(a, b);
}
OPENNTC_FAST_INLINE __m512i Multiply(__m512i a, __m512i b) {
    return _mm512_mullo_epi32(a, b);
}
OPENNTC_FAST_INLINE __m512i Xor(__m512i a, __m512i b) {
    return _mm512_xor_si512(a, b);
}
/// Bits that both have, as a number.
OPENNTC_FAST_INLINE __m512 And(__m512 a, __m512i b) {
    return _mm512_castsi512_ps(_mm512_and_si512(_mm512_castps_si512(a), b));
}
/// Adds to a number's bits.
OPENNTC_FAST_INLINE __m512 AddToBits(__m512 a, __m512i b) {
    return _mm512_castsi512_ps(_mm512_add_epi32(_mm512_castps_si512(a), b));
}
template <int kBits>
OPENNTC_FAST_INLINE __m512i ShiftRight(__m512i v) {
    return _mm512_srli_epi32(v, kBits);
}
OPENNTC_FAST_INLINE __m512i ShiftRight(__m512i v, __m512i count) {
    return _mm512_srlv_epi32(v, count);
}
OPENNTC_FAST_INLINE __m512 ToFloat(__m512i v) {
    return _mm512_cvtepi32_ps(v);
}
OPENNTC_FAST_INLINE __m512 PickNative(const float* row, int pitch, __m512i index) {
    if (pitch == 16)
        return _mm512_permutexvar_ps(index, _mm512_loadu_ps(row));
    if (pitch == 32)
        return _mm512_permutex2var_ps(_mm512_loadu_ps(row), index, _mm512_loadu_ps(row + 16));
    return _mm512_i32gather_ps(index, row, 4);
}
/// 16 x 16. Four vectors whose 128-bit lanes come from rows r, r + 4, r + 8 and r + 12: half of the shuffles
/// become loads.
OPENNTC_FAST_INLINE void TransposeNative(const float* from, int fromPitch, float* to, int toPitch) {
    for (int quarter = 0; quarter < 4; ++quarter) {
        __m512 v[4];
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < 4; ++r) {
            const float* source = from + r * fromPitch + quarter * 4;
            v[r] = _mm512_castps128_ps512(_mm_loadu_ps(source));
            v[r] = _mm512_mask_broadcast_f32x4(v[r], 0x00f0, _mm_loadu_ps(source + 4 * fromPitch));
            v[r] = _mm512_mask_broadcast_f32x4(v[r], 0x0f00, _mm_loadu_ps(source + 8 * fromPitch));
            v[r] = _mm512_mask_broadcast_f32x4(v[r], 0xf000, _mm_loadu_ps(source + 12 * fromPitch));
        }
        const __m512d a = _mm512_castps_pd(_mm512_unpacklo_ps(v[0], v[1])),
                      b = _mm512_castps_pd(_mm512_unpackhi_ps(v[0], v[1])),
                      c = _mm512_castps_pd(_mm512_unpacklo_ps(v[2], v[3])),
                      d = _mm512_castps_pd(_mm512_unpackhi_ps(v[2], v[3]));
        float* target = to + quarter * 4 * toPitch;
        _mm512_storeu_pd(target, _mm512_unpacklo_pd(a, c));
        _mm512_storeu_pd(target + toPitch, _mm512_unpackhi_pd(a, c));
        _mm512_storeu_pd(target + 2 * toPitch, _mm512_unpacklo_pd(b, d));
        _mm512_storeu_pd(target + 3 * toPitch, _mm512_unpackhi_pd(b, d));
    }
}

#include "openntc/encode/detail/blocked/Lanes.inl"

#include "openntc/encode/detail/blocked/Rows.inl"

#include "openntc/encode/detail/blocked/EightBits.inl"

#include "openntc/encode/detail/blocked/Loss.inl"

namespace fma {

#include "openntc/encode/detail/blocked/FloatUnits.inl"

#include "openntc/encode/detail/blocked/Matrix.inl"

#include "openntc/encode/detail/blocked/Latents.inl"

#include "openntc/encode/detail/blocked/Kernel.inl"

} // namespace fma
} // namespace openntc::encode::detail::avx512

#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(                                                                                \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512bf16,avx2,fma"))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx512bf16,avx2,fma")
#endif

namespace openntc::encode::detail::avx512::bf16 {

inline constexpr int kTerms = 2;

using Sum = Float;

OPENNTC_FAST_INLINE void AddDot(Sum& sum, __m512 a, const Float& b) {
    sum.part[0] =
        _mm512_dpbf16_ps(sum.part[0], reinterpret_cast<__m512bh>(a), reinterpret_cast<__m512bh>(b.part[0]));
}

/// Two vectors to bfloat16, `low` in the lower half.
OPENNTC_FAST_INLINE __m512i Convert(const Float& low, const Float& high) {
    return reinterpret_cast<__m512i>(_mm512_cvtne2ps_pbh(high.part[0], low.part[0]));
}
/// Pairs of numbers of the lower and the upper half.
OPENNTC_FAST_INLINE __m512i Interleave(__m512i v) {
    alignas(64) static constexpr std::uint16_t kOrder[32] = {0,  16, 1,  17, 2,  18, 3,  19, 4,  20, 5,
                                                             21, 6,  22, 7,  23, 8,  24, 9,  25, 10, 26,
                                                             11, 27, 12, 28, 13, 29, 14, 30, 15, 31};
    return _mm512_permutexvar_epi16(_mm512_load_si512(kOrder), v);
}

struct Operand : PairedOperand {
    OPENNTC_FAST_INLINE void Put(int texel, int channel, const Float& even, const Float& odd) {
        const __m512i v = Convert(even, odd);
        float* to = rows.data() + texel * kRowPitch + channel / 2;
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_castsi512_si256(v));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + kRowPitch), _mm512_extracti64x4_epi64(v, 1));
        _mm512_storeu_si512(columns.data() + (texel / 2) * kColumnPitch + channel, Interleave(v));
    }
};

OPENNTC_FAST_INLINE void PackWeights(float* forward, int, const Float& even, const Float& odd) {
    _mm512_storeu_si512(forward, Interleave(Convert(even, odd)));
}
OPENNTC_FAST_INLINE void PackTransposed(float* backward, int pitch, const Float& even, const Float& odd) {
    alignas(64) float pairs[16]; // of outputs: eight of input `even`, eight of `odd`
    _mm512_store_si512(pairs, Convert(even, odd));
    for (int o = 0; o < 8; ++o) {
        std::memcpy(backward + o * pitch, pairs + o, sizeof(float));
        std::memcpy(backward + o * pitch + 1, pairs + o + 8, sizeof(float));
    }
}

#include "openntc/encode/detail/blocked/Matrix.inl"

#include "openntc/encode/detail/blocked/Latents.inl"

#include "openntc/encode/detail/blocked/Kernel.inl"

} // namespace openntc::encode::detail::avx512::bf16

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
