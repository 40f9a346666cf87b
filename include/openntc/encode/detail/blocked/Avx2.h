// SPDX-License-Identifier: MIT
// Stability: internal
// Blocked kernel for AVX2 with fused multiply-add: sixteen lanes are two vectors.
#pragma once

#include "openntc/encode/detail/blocked/Support.h"

#if OPENNTC_FAST_X86
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail::avx2 {

using NativeFloat = __m256;
using NativeBits = __m256i;
using NativeMask = __m256;
inline constexpr int kLanes = 8;
inline constexpr int kBlockRows = 6, kBlockColumns = 1;

OPENNTC_FAST_INLINE __m256i FirstLanes(int count) {
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(count), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}
OPENNTC_FAST_INLINE __m256 LoadNative(const float* from) {
    return _mm256_loadu_ps(from);
}
OPENNTC_FAST_INLINE void StoreNative(float* to, __m256 v) {
    _mm256_storeu_ps(to, v);
}
OPENNTC_FAST_INLINE __m256 LoadNativePartial(const float* from, int count) {
    return _mm256_maskload_ps(from, FirstLanes(count));
}
/// In halves: AMD's processors take long over masked stores.
OPENNTC_FAST_INLINE void StoreNativePartial(float* to, __m256 v, int count) {
    if (count >= 8)
        return _mm256_storeu_ps(to, v);
    if (count <= 0)
        return;
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
OPENNTC_FAST_INLINE __m256 LoadNativeShorts(const std::uint16_t* from) {
    return _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))));
}
OPENNTC_FAST_INLINE __m256 SetNative(float v) {
    return _mm256_set1_ps(v);
}
OPENNTC_FAST_INLINE __m256 Add(__m256 a, __m256 b) {
    return _mm256_add_ps(a, b);
}
OPENNTC_FAST_INLINE __m256 Subtract(__m256 a, __m256 b) {
    return _mm256_sub_ps(a, b);
}
OPENNTC_FAST_INLINE __m256 Multiply(__m256 a, __m256 b) {
    __m256 product = _mm256_mul_ps(a, b);
    __asm__("" : "+x"(product)); // keeps compilers from fusing it with an addition
    return product;
}
OPENNTC_FAST_INLINE __m256 Divide(__m256 a, __m256 b) {
    return _mm256_div_ps(a, b);
}
OPENNTC_FAST_INLINE __m256 MultiplyAdd(__m256 a, __m256 b, __m256 c) {
    return _mm256_fmadd_ps(a, b, c);
}
OPENNTC_FAST_INLINE __m256 SquareRoot(__m256 v) {
    return _mm256_sqrt_ps(v);
}
OPENNTC_FAST_INLINE __m256 Min(__m256 a, __m256 b) {
    return _mm256_min_ps(a, b);
}
OPENNTC_FAST_INLINE __m256 Max(__m256 a, __m256 b) {
    return _mm256_max_ps(a, b);
}
OPENNTC_FAST_INLINE __m256 Floor(__m256 v) {
    return _mm256_floor_ps(v);
}
OPENNTC_FAST_INLINE __m256 Truncate(__m256 v) {
    return _mm256_round_ps(v, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
}
OPENNTC_FAST_INLINE __m256 Less(__m256 a, __m256 b) {
    return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
}
OPENNTC_FAST_INLINE __m256 Equal(__m256 a, __m256 b) {
    return _mm256_cmp_ps(a, b, _CMP_EQ_OQ);
}
OPENNTC_FAST_INLINE __m256 Select(__m256 mask, __m256 a, __m256 b) {
    return _mm256_blendv_ps(b, a, mask);
}
OPENNTC_FAST_INLINE __m256i LoadNativeBits(const std::int32_t* from) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}
OPENNTC_FAST_INLINE __m256i SetNativeBits(std::uint32_t v) {
    return _mm256_set1_epi32(static_cast<int>(v));
}
OPENNTC_FAST_INLINE __m256i Add(__m256i a, __m256i b) {
    return _mm256_add_epi32(a, b);
}
OPENNTC_FAST_INLINE __m256i Multiply(__m256i a, __m256i b) {
    return _mm256_mullo_epi32(a, b);
}
OPENNTC_FAST_INLINE __m256i Xor(__m256i a, __m256i b) {
    return _mm256_xor_si256(a, b);
}
/// Bits that both have, as a number.
OPENNTC_FAST_INLINE __m256 And(__m256 a, __m256i b) {
    return _mm256_and_ps(a, _mm256_castsi256_ps(b));
}
/// Adds to a number's bits.
OPENNTC_FAST_INLINE __m256 AddToBits(__m256 a, __m256i b) {
    return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(a), b));
}
template <int kBits>
OPENNTC_FAST_INLINE __m256i ShiftRight(__m256i v) {
    return _mm256_srli_epi32(v, kBits);
}
OPENNTC_FAST_INLINE __m256i ShiftRight(__m256i v, __m256i count) {
    return _mm256_srlv_epi32(v, count);
}
OPENNTC_FAST_INLINE __m256 ToFloat(__m256i v) {
    return _mm256_cvtepi32_ps(v);
}
OPENNTC_FAST_INLINE __m256 PickNative(const float* row, int pitch, __m256i index) {
    if (pitch > 16)
        return _mm256_i32gather_ps(row, index, 4);
    const __m256 low = _mm256_permutevar8x32_ps(_mm256_loadu_ps(row), index),
                 high = _mm256_permutevar8x32_ps(_mm256_loadu_ps(row + 8), index);
    return _mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32(index, 28)));
}
/// 8 x 8. Vectors whose halves come from rows r and r + 4: a third of the shuffles become loads.
OPENNTC_FAST_INLINE void TransposeNative(const float* from, int fromPitch, float* to, int toPitch) {
    OPENNTC_FAST_UNROLL
    for (int half = 0; half < 2; ++half) {
        __m256 v[4];
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < 4; ++r) {
            const float* source = from + r * fromPitch + half * 4;
            v[r] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(source)),
                                        _mm_loadu_ps(source + 4 * fromPitch), 1);
        }
        const __m256 a = _mm256_unpacklo_ps(v[0], v[1]), b = _mm256_unpackhi_ps(v[0], v[1]),
                     c = _mm256_unpacklo_ps(v[2], v[3]), d = _mm256_unpackhi_ps(v[2], v[3]);
        float* target = to + half * 4 * toPitch;
        _mm256_storeu_ps(target, _mm256_shuffle_ps(a, c, 0x44));
        _mm256_storeu_ps(target + toPitch, _mm256_shuffle_ps(a, c, 0xee));
        _mm256_storeu_ps(target + 2 * toPitch, _mm256_shuffle_ps(b, d, 0x44));
        _mm256_storeu_ps(target + 3 * toPitch, _mm256_shuffle_ps(b, d, 0xee));
    }
}

#include "openntc/encode/detail/blocked/Lanes.inl"

#include "openntc/encode/detail/blocked/Rows.inl"

#include "openntc/encode/detail/blocked/EightBits.inl"

#include "openntc/encode/detail/blocked/Loss.inl"

#include "openntc/encode/detail/blocked/FloatUnits.inl"

#include "openntc/encode/detail/blocked/Matrix.inl"

#include "openntc/encode/detail/blocked/Latents.inl"

#include "openntc/encode/detail/blocked/Kernel.inl"

} // namespace openntc::encode::detail::avx2

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#include "openntc/core/RestoreMacros.h"
#endif
