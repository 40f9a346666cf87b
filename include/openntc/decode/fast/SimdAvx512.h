// SPDX-License-Identifier: MIT
// Stability: internal
// Kernel for AVX-512 with VNNI: 16 texels in a vector, four 8-bit products per lane and instruction.
#pragma once

#include "openntc/decode/fast/TileKernel.h"

#if OPENNTC_FAST_X86
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(                                                                                \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2,f16c"))), apply_to = function)
#else
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wsign-conversion" // intrinsics are macros without optimisation
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2,f16c")
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::fast::avx512 {

using Float = __m512;
using Int = __m512i;
using Quantized = __m512i; // low byte: value + 128
inline constexpr int kLanes = 16;
inline constexpr int kGroups = 4;
inline constexpr OperandLayout kLayout = OperandLayout::UnsignedBytes;
inline constexpr bool kFuses = true;
inline constexpr float kQuantizedZero = 128.0f;

OPENNTC_FAST_INLINE Float LoadFloat(const float* p) noexcept {
    return _mm512_loadu_ps(p);
}
OPENNTC_FAST_INLINE void StoreFloat(float* p, Float v) noexcept {
    _mm512_storeu_ps(p, v);
}
OPENNTC_FAST_INLINE Int LoadInt(const void* p) noexcept {
    return _mm512_loadu_si512(p);
}
OPENNTC_FAST_INLINE void StoreInt(void* p, Int v) noexcept {
    _mm512_storeu_si512(p, v);
}
OPENNTC_FAST_INLINE Float SetFloat(float v) noexcept {
    return _mm512_set1_ps(v);
}
OPENNTC_FAST_INLINE Int SetInt(std::int32_t v) noexcept {
    return _mm512_set1_epi32(v);
}
OPENNTC_FAST_INLINE Float Add(Float a, Float b) noexcept {
    return _mm512_add_ps(a, b);
}
OPENNTC_FAST_INLINE Float Subtract(Float a, Float b) noexcept {
    return _mm512_sub_ps(a, b);
}
OPENNTC_FAST_INLINE Float Multiply(Float a, Float b) noexcept {
    Float product = _mm512_mul_ps(a, b);
    __asm__("" : "+v"(product)); // keeps compilers from fusing it with an addition
    return product;
}
OPENNTC_FAST_INLINE Float MultiplyAdd(Float a, Float b, Float c) noexcept {
    return _mm512_fmadd_ps(a, b, c);
}
OPENNTC_FAST_INLINE Float Min(Float a, Float b) noexcept {
    return _mm512_min_ps(a, b);
}
OPENNTC_FAST_INLINE Float Max(Float a, Float b) noexcept {
    return _mm512_max_ps(a, b);
}
OPENNTC_FAST_INLINE Int AsInt(Float v) noexcept {
    return _mm512_castps_si512(v);
}
OPENNTC_FAST_INLINE Float AsFloat(Int v) noexcept {
    return _mm512_castsi512_ps(v);
}
// `negative` where v has its sign set.
OPENNTC_FAST_INLINE Float SelectNegative(Float v, Float negative, Float positive) noexcept {
    return _mm512_mask_mov_ps(positive, _mm512_movepi32_mask(_mm512_castps_si512(v)), negative);
}
OPENNTC_FAST_INLINE Float ToFloat(Int v) noexcept {
    return _mm512_cvtepi32_ps(v);
}
OPENNTC_FAST_INLINE Int Truncate(Float v) noexcept {
    return _mm512_cvttps_epi32(v);
}
OPENNTC_FAST_INLINE Int AddInt(Int a, Int b) noexcept {
    return _mm512_add_epi32(a, b);
}
OPENNTC_FAST_INLINE Int SubtractInt(Int a, Int b) noexcept {
    return _mm512_sub_epi32(a, b);
}
OPENNTC_FAST_INLINE Int And(Int a, Int b) noexcept {
    return _mm512_and_si512(a, b);
}
OPENNTC_FAST_INLINE Int Or(Int a, Int b) noexcept {
    return _mm512_or_si512(a, b);
}
OPENNTC_FAST_INLINE Int Xor(Int a, Int b) noexcept {
    return _mm512_xor_si512(a, b);
}
OPENNTC_FAST_INLINE Int MultiplyHigh16(Int a, Int b) noexcept {
    return _mm512_mulhi_epi16(a, b);
}
OPENNTC_FAST_INLINE Int MultiplyAdd16(Int a, Int b) noexcept {
    return _mm512_madd_epi16(a, b);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftLeft32(Int v) noexcept {
    return _mm512_slli_epi32(v, kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftRight32(Int v) noexcept {
    return _mm512_srai_epi32(v, kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftLeft16(Int v) noexcept {
    return _mm512_slli_epi16(v, kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftRight16(Int v) noexcept {
    return _mm512_srai_epi16(v, kBits);
}
OPENNTC_FAST_INLINE Int Lookup(const std::uint32_t* entries, Int index) noexcept {
    return _mm512_permutexvar_epi32(index, LoadInt(entries));
}
OPENNTC_FAST_INLINE Float RoundToHalf(Float v) noexcept {
    return _mm512_cvtph_ps(_mm512_cvtps_ph(v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
OPENNTC_FAST_INLINE void AddDot(Int& sum, Int x, Int w) noexcept {
    // As assembly because g++ 12 surrounds the intrinsic with two register copies.
    __asm__("vpdpbusd %2, %1, %0" : "+v"(sum) : "v"(x), "v"(w));
}

OPENNTC_FAST_INLINE Quantized AsQuantized(Float v) noexcept {
    return _mm512_castps_si512(v);
}
// 128 more makes the integer unsigned.
OPENNTC_FAST_INLINE Quantized RoundToInteger(Float v) noexcept {
    return AsQuantized(Add(v, SetFloat(kRoundingBase + kQuantizedZero)));
}

OPENNTC_FAST_INLINE void StoreQuantized(std::int32_t* outputs, int, const Quantized (&q)[4]) noexcept {
    // Byte 0 of q[1], q[2], q[3] goes to bytes 1, 2, 3 of q[0].
    const Int spread = _mm512_set4_epi32(0x0C0C0C0C, 0x08080808, 0x04040404, 0x00000000);
    Int word = _mm512_mask_shuffle_epi8(q[0], 0x2222222222222222u, q[1], spread);
    word = _mm512_mask_shuffle_epi8(word, 0x4444444444444444u, q[2], spread);
    word = _mm512_mask_shuffle_epi8(word, 0x8888888888888888u, q[3], spread);
    StoreInt(outputs, word);
}

// The low halves of `even` in the low halves of lanes, those of `odd` in the high halves.
OPENNTC_FAST_INLINE Int JoinPairs(Quantized even, Quantized odd) noexcept {
    const Int spread = _mm512_set4_epi32(0x0D0C0D0C, 0x09080908, 0x05040504, 0x01000100);
    return _mm512_mask_shuffle_epi8(even, 0xCCCCCCCCCCCCCCCCu, odd, spread);
}
OPENNTC_FAST_INLINE Int SetInt16(int v) noexcept {
    return _mm512_set1_epi16(static_cast<short>(v));
}
OPENNTC_FAST_INLINE Int Min16(Int a, Int b) noexcept {
    return _mm512_min_epi16(a, b);
}
OPENNTC_FAST_INLINE void StorePairs(std::int32_t* outputs, int, Int even, Int odd) noexcept {
    StoreInt(outputs, Or(even, ShiftLeft16<8>(odd)));
}

#include "openntc/decode/fast/Inputs.inl"

#include "openntc/decode/fast/Fused.inl"

#include "openntc/decode/fast/VectorLayer.inl"

#include "openntc/decode/fast/Tile.inl"

} // namespace openntc::fast::avx512

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
