// SPDX-License-Identifier: MIT
// Stability: internal
// Kernels for AVX2: 8 texels in a vector. Plain AVX2 multiplies 16-bit pairs; AVX-VNNI four 8-bit values per
// lane.
#pragma once

#include "openntc/decode/fast/TileKernel.h"

#if OPENNTC_FAST_X86
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma,f16c"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma,f16c")
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::fast::avx2 {

using Float = __m256;
using Int = __m256i;
using Quantized = __m256i; // the integer
inline constexpr int kLanes = 8;
inline constexpr bool kFuses = true;
inline constexpr float kQuantizedZero = 0.0f;

OPENNTC_FAST_INLINE Float LoadFloat(const float* p) noexcept {
    return _mm256_loadu_ps(p);
}
OPENNTC_FAST_INLINE void StoreFloat(float* p, Float v) noexcept {
    _mm256_storeu_ps(p, v);
}
OPENNTC_FAST_INLINE Int LoadInt(const void* p) noexcept {
    return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
OPENNTC_FAST_INLINE void StoreInt(void* p, Int v) noexcept {
    _mm256_storeu_si256(static_cast<__m256i*>(p), v);
}
OPENNTC_FAST_INLINE Float SetFloat(float v) noexcept {
    return _mm256_set1_ps(v);
}
OPENNTC_FAST_INLINE Int SetInt(std::int32_t v) noexcept {
    return _mm256_set1_epi32(v);
}
OPENNTC_FAST_INLINE Float Add(Float a, Float b) noexcept {
    return _mm256_add_ps(a, b);
}
OPENNTC_FAST_INLINE Float Subtract(Float a, Float b) noexcept {
    return _mm256_sub_ps(a, b);
}
OPENNTC_FAST_INLINE Float Multiply(Float a, Float b) noexcept {
    Float product = _mm256_mul_ps(a, b);
    __asm__("" : "+x"(product)); // keeps compilers from fusing it with an addition
    return product;
}
OPENNTC_FAST_INLINE Float MultiplyAdd(Float a, Float b, Float c) noexcept {
    return _mm256_fmadd_ps(a, b, c);
}
OPENNTC_FAST_INLINE Float Min(Float a, Float b) noexcept {
    return _mm256_min_ps(a, b);
}
OPENNTC_FAST_INLINE Float Max(Float a, Float b) noexcept {
    return _mm256_max_ps(a, b);
}
OPENNTC_FAST_INLINE Int AsInt(Float v) noexcept {
    return _mm256_castps_si256(v);
}
OPENNTC_FAST_INLINE Float AsFloat(Int v) noexcept {
    return _mm256_castsi256_ps(v);
}
// `negative` where v has its sign set.
OPENNTC_FAST_INLINE Float SelectNegative(Float v, Float negative, Float positive) noexcept {
    return _mm256_blendv_ps(positive, negative, v);
}
OPENNTC_FAST_INLINE Float ToFloat(Int v) noexcept {
    return _mm256_cvtepi32_ps(v);
}
OPENNTC_FAST_INLINE Int Truncate(Float v) noexcept {
    return _mm256_cvttps_epi32(v);
}
OPENNTC_FAST_INLINE Int AddInt(Int a, Int b) noexcept {
    return _mm256_add_epi32(a, b);
}
OPENNTC_FAST_INLINE Int SubtractInt(Int a, Int b) noexcept {
    return _mm256_sub_epi32(a, b);
}
OPENNTC_FAST_INLINE Int And(Int a, Int b) noexcept {
    return _mm256_and_si256(a, b);
}
OPENNTC_FAST_INLINE Int Or(Int a, Int b) noexcept {
    return _mm256_or_si256(a, b);
}
OPENNTC_FAST_INLINE Int Xor(Int a, Int b) noexcept {
    return _mm256_xor_si256(a, b);
}
OPENNTC_FAST_INLINE Int MultiplyHigh16(Int a, Int b) noexcept {
    return _mm256_mulhi_epi16(a, b);
}
OPENNTC_FAST_INLINE Int MultiplyAdd16(Int a, Int b) noexcept {
    return _mm256_madd_epi16(a, b);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftLeft32(Int v) noexcept {
    return _mm256_slli_epi32(v, kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftRight32(Int v) noexcept {
    return _mm256_srai_epi32(v, kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftLeft16(Int v) noexcept {
    return _mm256_slli_epi16(v, kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftRight16(Int v) noexcept {
    return _mm256_srai_epi16(v, kBits);
}
OPENNTC_FAST_INLINE Int Lookup(const std::uint32_t* entries, Int index) noexcept {
    return _mm256_permutevar8x32_epi32(LoadInt(entries), index);
}
OPENNTC_FAST_INLINE Float RoundToHalf(Float v) noexcept {
    return _mm256_cvtph_ps(_mm256_cvtps_ph(v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
// An integer is what the low 16 bits are: what follows looks at those.
OPENNTC_FAST_INLINE Quantized AsQuantized(Float v) noexcept {
    return _mm256_castps_si256(v);
}
OPENNTC_FAST_INLINE Quantized RoundToInteger(Float v) noexcept {
    return AsQuantized(Add(v, SetFloat(kRoundingBase)));
}
OPENNTC_FAST_INLINE Int JoinPairs(Quantized even, Quantized odd) noexcept {
    return _mm256_blend_epi16(even, _mm256_slli_epi32(odd, 16), 0xAA);
}
OPENNTC_FAST_INLINE Int SetInt16(int v) noexcept {
    return _mm256_set1_epi16(static_cast<short>(v));
}
OPENNTC_FAST_INLINE Int Min16(Int a, Int b) noexcept {
    return _mm256_min_epi16(a, b);
}

namespace pairs {

inline constexpr int kGroups = 2;
inline constexpr OperandLayout kLayout = OperandLayout::SignedPairs;

OPENNTC_FAST_INLINE void AddDot(Int& sum, Int x, Int w) noexcept {
#if defined(__clang__)
    sum = _mm256_add_epi32(sum, _mm256_madd_epi16(x, w));
#else
    // As assembly because g++ 12 keeps one of the accumulators in memory, whose latency then sets the pace.
    Int product;
    __asm__("vpmaddwd %3, %2, %1\n\tvpaddd %1, %0, %0" : "+x"(sum), "=&x"(product) : "x"(x), "x"(w));
#endif
}

OPENNTC_FAST_INLINE void StorePairs(std::int32_t* outputs, int unitStride, Int even, Int odd) noexcept {
    StoreInt(outputs, even);
    StoreInt(outputs + unitStride, odd);
}

OPENNTC_FAST_INLINE void StoreQuantized(std::int32_t* outputs, int unitStride,
                                        const Quantized (&q)[4]) noexcept {
    StorePairs(outputs, unitStride, JoinPairs(q[0], q[2]), JoinPairs(q[1], q[3]));
}

#include "openntc/decode/fast/Inputs.inl"

#include "openntc/decode/fast/Fused.inl"

#include "openntc/decode/fast/VectorLayer.inl"

#include "openntc/decode/fast/Tile.inl"

} // namespace pairs
} // namespace openntc::fast::avx2

#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx2,fma,f16c,avxvnni"))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx2,fma,f16c,avxvnni")
#endif

namespace openntc::fast::avx2::vnni {

inline constexpr int kGroups = 2;
inline constexpr OperandLayout kLayout = OperandLayout::UnsignedBytes;

OPENNTC_FAST_INLINE void AddDot(Int& sum, Int x, Int w) noexcept {
    // As assembly because g++ 12 surrounds the intrinsic with two register copies.
    __asm__("%{vex%} vpdpbusd %2, %1, %0" : "+x"(sum) : "x"(x), "x"(w));
}

OPENNTC_FAST_INLINE void StorePairs(std::int32_t* outputs, int, Int even, Int odd) noexcept {
    const Int word = Or(And(even, SetInt(0x00FF00FF)), ShiftLeft16<8>(odd));
    StoreInt(outputs, Xor(word, SetInt(static_cast<std::int32_t>(0x80808080u))));
}

OPENNTC_FAST_INLINE void StoreQuantized(std::int32_t* outputs, int unitStride,
                                        const Quantized (&q)[4]) noexcept {
    StorePairs(outputs, unitStride, JoinPairs(q[0], q[2]), JoinPairs(q[1], q[3]));
}

#include "openntc/decode/fast/Inputs.inl"

#include "openntc/decode/fast/Fused.inl"

#include "openntc/decode/fast/VectorLayer.inl"

#include "openntc/decode/fast/Tile.inl"

} // namespace openntc::fast::avx2::vnni

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#include "openntc/core/RestoreMacros.h"
#endif
