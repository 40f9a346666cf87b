// SPDX-License-Identifier: MIT
// Stability: internal
// Kernel for any processor: 4 texels in a 16-byte vector of the compiler's own kind (SSE2, NEON, …), with
// intrinsics only where compilers do not find the instruction themselves. Compilers without vector types get
// one texel at a time.
#pragma once

#include "openntc/core/FloatBits.h"
#include "openntc/decode/fast/TileKernel.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::fast::portable {

#if defined(__GNUC__)
typedef float Float __attribute__((vector_size(16)));
typedef std::int32_t Int __attribute__((vector_size(16)));
typedef std::uint32_t Unsigned __attribute__((vector_size(16)));
inline constexpr int kLanes = 4;
#else
using Float = float;
using Int = std::int32_t;
using Unsigned = std::uint32_t;
inline constexpr int kLanes = 1;
#endif
using Quantized = Int;
inline constexpr int kGroups = 2;
inline constexpr OperandLayout kLayout = OperandLayout::SignedPairs;
inline constexpr bool kFuses = false;

OPENNTC_FAST_INLINE Int AsInt(Float v) noexcept {
    return BitCast<Int>(v);
}
OPENNTC_FAST_INLINE Float AsFloat(Int v) noexcept {
    return BitCast<Float>(v);
}
OPENNTC_FAST_INLINE Int AsInt(Unsigned v) noexcept {
    return BitCast<Int>(v);
}
OPENNTC_FAST_INLINE Unsigned AsUnsigned(Int v) noexcept {
    return BitCast<Unsigned>(v);
}

template <typename Vector>
OPENNTC_FAST_INLINE Vector LoadVector(const void* p) noexcept {
    Vector v;
    std::memcpy(&v, p, sizeof v);
    return v;
}
OPENNTC_FAST_INLINE Float LoadFloat(const float* p) noexcept {
    return LoadVector<Float>(p);
}
OPENNTC_FAST_INLINE void StoreFloat(float* p, Float v) noexcept {
    std::memcpy(p, &v, sizeof v);
}
OPENNTC_FAST_INLINE Int LoadInt(const void* p) noexcept {
    return LoadVector<Int>(p);
}
OPENNTC_FAST_INLINE void StoreInt(void* p, Int v) noexcept {
    std::memcpy(p, &v, sizeof v);
}
OPENNTC_FAST_INLINE Float Add(Float a, Float b) noexcept {
    return a + b;
}
OPENNTC_FAST_INLINE Float Subtract(Float a, Float b) noexcept {
    return a - b;
}
OPENNTC_FAST_INLINE Float Multiply(Float a, Float b) noexcept {
    Float product = a * b;
    OPENNTC_KEEP_ROUNDED(product);
    return product;
}
OPENNTC_FAST_INLINE Int AddInt(Int a, Int b) noexcept {
    return AsInt(AsUnsigned(a) + AsUnsigned(b));
}
OPENNTC_FAST_INLINE Int SubtractInt(Int a, Int b) noexcept {
    return AsInt(AsUnsigned(a) - AsUnsigned(b));
}
OPENNTC_FAST_INLINE Int And(Int a, Int b) noexcept {
    return a & b;
}
OPENNTC_FAST_INLINE Int Or(Int a, Int b) noexcept {
    return a | b;
}
OPENNTC_FAST_INLINE Int Xor(Int a, Int b) noexcept {
    return a ^ b;
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftLeft32(Int v) noexcept {
    return AsInt(AsUnsigned(v) << kBits);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftRight32(Int v) noexcept {
    return v >> kBits;
}

#if defined(__GNUC__)
OPENNTC_FAST_INLINE Float SetFloat(float v) noexcept {
    return Float{v, v, v, v};
}
OPENNTC_FAST_INLINE Int SetInt(std::int32_t v) noexcept {
    return Int{v, v, v, v};
}
OPENNTC_FAST_INLINE Float ToFloat(Int v) noexcept {
    return __builtin_convertvector(v, Float);
}
OPENNTC_FAST_INLINE Int Truncate(Float v) noexcept {
    return __builtin_convertvector(v, Int);
}
OPENNTC_FAST_INLINE Int Lookup(const std::uint32_t* entries, Int index) noexcept {
    return AsInt(Unsigned{entries[index[0]], entries[index[1]], entries[index[2]], entries[index[3]]});
}
OPENNTC_FAST_INLINE Int LessThan(Int a, Int b) noexcept {
    return a < b;
} // all bits set where true
#else
OPENNTC_FAST_INLINE Float SetFloat(float v) noexcept {
    return v;
}
OPENNTC_FAST_INLINE Int SetInt(std::int32_t v) noexcept {
    return v;
}
OPENNTC_FAST_INLINE Float ToFloat(Int v) noexcept {
    return static_cast<float>(v);
}
OPENNTC_FAST_INLINE Int Truncate(Float v) noexcept {
    return static_cast<std::int32_t>(v);
}
OPENNTC_FAST_INLINE Int Lookup(const std::uint32_t* entries, Int index) noexcept {
    return AsInt(entries[index]);
}
OPENNTC_FAST_INLINE Int LessThan(Int a, Int b) noexcept {
    return a < b ? -1 : 0;
}
#endif

OPENNTC_FAST_INLINE Int Select(Int mask, Int whereSet, Int elsewhere) noexcept {
    return (mask & whereSet) | (~mask & elsewhere);
}

// 16-bit halves of a lane, sign-extended.
OPENNTC_FAST_INLINE Int LowHalf(Int v) noexcept {
    return ShiftRight32<16>(ShiftLeft32<16>(v));
}
OPENNTC_FAST_INLINE Int HighHalf(Int v) noexcept {
    return ShiftRight32<16>(v);
}
OPENNTC_FAST_INLINE Int JoinHalves(Int low, Int high) noexcept {
    return (low & SetInt(0xFFFF)) | ShiftLeft32<16>(high);
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftLeft16(Int v) noexcept {
    return JoinHalves(ShiftLeft32<kBits>(v), ShiftLeft32<kBits>(HighHalf(v)));
}
template <int kBits>
OPENNTC_FAST_INLINE Int ShiftRight16(Int v) noexcept {
    return JoinHalves(ShiftRight32<kBits>(LowHalf(v)), ShiftRight32<kBits>(HighHalf(v)));
}

#if defined(__SSE2__)
OPENNTC_FAST_INLINE Float Min(Float a, Float b) noexcept {
    return reinterpret_cast<Float>(_mm_min_ps(reinterpret_cast<__m128>(a), reinterpret_cast<__m128>(b)));
}
OPENNTC_FAST_INLINE Float Max(Float a, Float b) noexcept {
    return reinterpret_cast<Float>(_mm_max_ps(reinterpret_cast<__m128>(a), reinterpret_cast<__m128>(b)));
}
OPENNTC_FAST_INLINE Int MultiplyHigh16(Int a, Int b) noexcept {
    return reinterpret_cast<Int>(_mm_mulhi_epi16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
OPENNTC_FAST_INLINE Int MultiplyAdd16(Int a, Int b) noexcept {
    return reinterpret_cast<Int>(_mm_madd_epi16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
#else
OPENNTC_FAST_INLINE Int MultiplyHigh16(Int a, Int b) noexcept {
    const Int low = ShiftRight32<16>(LowHalf(a) * LowHalf(b));
    const Int high = ShiftRight32<16>(HighHalf(a) * HighHalf(b));
    return JoinHalves(low, high);
}
#if defined(__aarch64__)
OPENNTC_FAST_INLINE Float Min(Float a, Float b) noexcept {
    return (Float)vminq_f32((float32x4_t)a, (float32x4_t)b);
}
OPENNTC_FAST_INLINE Float Max(Float a, Float b) noexcept {
    return (Float)vmaxq_f32((float32x4_t)a, (float32x4_t)b);
}
OPENNTC_FAST_INLINE Int MultiplyAdd16(Int a, Int b) noexcept {
    const int16x8_t x = (int16x8_t)a;
    const int16x8_t w = (int16x8_t)b;
    return (Int)vpaddq_s32(vmull_s16(vget_low_s16(x), vget_low_s16(w)), vmull_high_s16(x, w));
}
#else
OPENNTC_FAST_INLINE Float Min(Float a, Float b) noexcept {
    return a < b ? a : b;
}
OPENNTC_FAST_INLINE Float Max(Float a, Float b) noexcept {
    return a > b ? a : b;
}
OPENNTC_FAST_INLINE Int MultiplyAdd16(Int a, Int b) noexcept {
    return AddInt(LowHalf(a) * LowHalf(b), HighHalf(a) * HighHalf(b));
}
#endif
#endif

OPENNTC_FAST_INLINE void AddDot(Int& sum, Int x, Int w) noexcept {
    sum = AddInt(sum, MultiplyAdd16(x, w));
}

// Rounds to the nearest binary16, ties to even, as a binary32. Not a number does not occur.
OPENNTC_FAST_INLINE Float RoundToHalf(Float v) noexcept {
    const Int bits = AsInt(v);
    const Int magnitude = bits & SetInt(0x7FFFFFFF);
    const Int sign = bits ^ magnitude;
    // Normal halves: drop 13 bits of the significand. 65520 and above become infinity.
    const Int odd = ShiftRight32<13>(magnitude) & SetInt(1);
    const Int rounded = AddInt(AddInt(magnitude, SetInt(0xFFF)), odd) & SetInt(~0x1FFF);
    const Int normal = Select(LessThan(magnitude, SetInt(0x477FF000)), rounded, SetInt(0x7F800000));
    // Subnormal halves are multiples of 2^-24, the spacing of binary32 between 0.5 and 1.
    const Int subnormal = AsInt(Subtract(Add(AsFloat(magnitude), SetFloat(0.5f)), SetFloat(0.5f)));
    return AsFloat(Select(LessThan(magnitude, SetInt(0x38800000)), subnormal, normal) | sign);
}

// Adding 1.5 · 2^23 rounds to an integer, ties to even, and leaves it in the low 16 bits (what follows looks
// at those).
OPENNTC_FAST_INLINE Quantized RoundToInteger(Float v) noexcept {
    return AsInt(Add(v, SetFloat(12582912.0f)));
}

OPENNTC_FAST_INLINE void StoreQuantized(std::int32_t* outputs, int unitStride,
                                        const Quantized (&q)[4]) noexcept {
    StoreInt(outputs, JoinHalves(q[0], q[2]));
    StoreInt(outputs + unitStride, JoinHalves(q[1], q[3]));
}

#include "openntc/decode/fast/Inputs.inl"

#include "openntc/decode/fast/VectorLayer.inl"

#include "openntc/decode/fast/Tile.inl"

} // namespace openntc::fast::portable

#include "openntc/core/RestoreMacros.h"
