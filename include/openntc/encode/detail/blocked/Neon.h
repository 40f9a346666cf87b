// SPDX-License-Identifier: MIT
// Stability: internal
// Blocked kernels for 64-bit Arm, sixteen lanes in four vectors: products in binary32, and with BF16's dot
// products of pairs where the compiler knows them.
#pragma once

#include "openntc/encode/detail/blocked/Support.h"

#if OPENNTC_FAST_NEON
#include <arm_neon.h>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail::neon {

using NativeFloat = float32x4_t;
using NativeBits = uint32x4_t;
using NativeMask = uint32x4_t;
inline constexpr int kLanes = 4;
inline constexpr int kBlockRows = 6, kBlockColumns = 1;

OPENNTC_FAST_INLINE float32x4_t LoadNative(const float* from) {
    return vld1q_f32(from);
}
OPENNTC_FAST_INLINE void StoreNative(float* to, float32x4_t v) {
    vst1q_f32(to, v);
}
OPENNTC_FAST_INLINE float32x4_t LoadNativePartial(const float* from, int count) {
    if (count >= kLanes)
        return vld1q_f32(from);
    float lanes[kLanes] = {};
    for (int i = 0; i < count; ++i)
        lanes[i] = from[i];
    return vld1q_f32(lanes);
}
OPENNTC_FAST_INLINE void StoreNativePartial(float* to, float32x4_t v, int count) {
    if (count >= kLanes)
        return vst1q_f32(to, v);
    float lanes[kLanes];
    vst1q_f32(lanes, v);
    for (int i = 0; i < count; ++i)
        to[i] = lanes[i];
}
OPENNTC_FAST_INLINE float32x4_t LoadNativeShorts(const std::uint16_t* from) {
    return vcvtq_f32_u32(vmovl_u16(vld1_u16(from)));
}
OPENNTC_FAST_INLINE float32x4_t SetNative(float v) {
    return vdupq_n_f32(v);
}
OPENNTC_FAST_INLINE float32x4_t Add(float32x4_t a, float32x4_t b) {
    return vaddq_f32(a, b);
}
OPENNTC_FAST_INLINE float32x4_t Subtract(float32x4_t a, float32x4_t b) {
    return vsubq_f32(a, b);
}
OPENNTC_FAST_INLINE float32x4_t Multiply(float32x4_t a, float32x4_t b) {
    float32x4_t product = vmulq_f32(a, b);
    __asm__("" : "+w"(product)); // keeps compilers from fusing it with an addition
    return product;
}
OPENNTC_FAST_INLINE float32x4_t Divide(float32x4_t a, float32x4_t b) {
    return vdivq_f32(a, b);
}
OPENNTC_FAST_INLINE float32x4_t MultiplyAdd(float32x4_t a, float32x4_t b, float32x4_t c) {
    return vfmaq_f32(c, a, b);
}
OPENNTC_FAST_INLINE float32x4_t SquareRoot(float32x4_t v) {
    return vsqrtq_f32(v);
}
OPENNTC_FAST_INLINE float32x4_t Min(float32x4_t a, float32x4_t b) {
    return vminq_f32(a, b);
}
OPENNTC_FAST_INLINE float32x4_t Max(float32x4_t a, float32x4_t b) {
    return vmaxq_f32(a, b);
}
OPENNTC_FAST_INLINE float32x4_t Floor(float32x4_t v) {
    return vrndmq_f32(v);
}
OPENNTC_FAST_INLINE float32x4_t Truncate(float32x4_t v) {
    return vrndq_f32(v);
}
OPENNTC_FAST_INLINE uint32x4_t Less(float32x4_t a, float32x4_t b) {
    return vcltq_f32(a, b);
}
OPENNTC_FAST_INLINE uint32x4_t Equal(float32x4_t a, float32x4_t b) {
    return vceqq_f32(a, b);
}
OPENNTC_FAST_INLINE float32x4_t Select(uint32x4_t mask, float32x4_t a, float32x4_t b) {
    return vbslq_f32(mask, a, b);
}
OPENNTC_FAST_INLINE uint32x4_t LoadNativeBits(const std::int32_t* from) {
    return vreinterpretq_u32_s32(vld1q_s32(from));
}
OPENNTC_FAST_INLINE uint32x4_t SetNativeBits(std::uint32_t v) {
    return vdupq_n_u32(v);
}
OPENNTC_FAST_INLINE uint32x4_t Add(uint32x4_t a, uint32x4_t b) {
    return vaddq_u32(a, b);
}
OPENNTC_FAST_INLINE uint32x4_t Multiply(uint32x4_t a, uint32x4_t b) {
    return vmulq_u32(a, b);
}
OPENNTC_FAST_INLINE uint32x4_t Xor(uint32x4_t a, uint32x4_t b) {
    return veorq_u32(a, b);
}
/// Bits that both have, as a number.
OPENNTC_FAST_INLINE float32x4_t And(float32x4_t a, uint32x4_t b) {
    return vreinterpretq_f32_u32(vandq_u32(vreinterpretq_u32_f32(a), b));
}
/// Adds to a number's bits.
OPENNTC_FAST_INLINE float32x4_t AddToBits(float32x4_t a, uint32x4_t b) {
    return vreinterpretq_f32_u32(vaddq_u32(vreinterpretq_u32_f32(a), b));
}
template <int kBits>
OPENNTC_FAST_INLINE uint32x4_t ShiftRight(uint32x4_t v) {
    return vshrq_n_u32(v, kBits);
}
OPENNTC_FAST_INLINE uint32x4_t ShiftRight(uint32x4_t v, uint32x4_t count) {
    return vshlq_u32(v, vnegq_s32(vreinterpretq_s32_u32(count)));
}
OPENNTC_FAST_INLINE float32x4_t ToFloat(uint32x4_t v) {
    return vcvtq_f32_u32(v);
}
OPENNTC_FAST_INLINE float32x4_t PickNative(const float* row, int, uint32x4_t index) {
    float32x4_t v = vld1q_dup_f32(row + vgetq_lane_u32(index, 0));
    v = vld1q_lane_f32(row + vgetq_lane_u32(index, 1), v, 1);
    v = vld1q_lane_f32(row + vgetq_lane_u32(index, 2), v, 2);
    return vld1q_lane_f32(row + vgetq_lane_u32(index, 3), v, 3);
}
/// 4 x 4.
OPENNTC_FAST_INLINE void TransposeNative(const float* from, int fromPitch, float* to, int toPitch) {
    const float32x4x2_t a = vzipq_f32(vld1q_f32(from), vld1q_f32(from + 2 * fromPitch)),
                        b = vzipq_f32(vld1q_f32(from + fromPitch), vld1q_f32(from + 3 * fromPitch));
    const float32x4x2_t low = vzipq_f32(a.val[0], b.val[0]), high = vzipq_f32(a.val[1], b.val[1]);
    vst1q_f32(to, low.val[0]);
    vst1q_f32(to + toPitch, low.val[1]);
    vst1q_f32(to + 2 * toPitch, high.val[0]);
    vst1q_f32(to + 3 * toPitch, high.val[1]);
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
} // namespace openntc::encode::detail::neon

#if OPENNTC_FAST_NEON_BF16

#if !defined(__clang__)
#pragma GCC push_options
#pragma GCC target("arch=armv8.2-a+bf16")
#endif

namespace openntc::encode::detail::neon::bf16 {

inline constexpr int kTerms = 2;

using Sum = Float;

OPENNTC_FAST_INLINE void AddDot(Sum& sum, float32x4_t a, const Float& b) {
    OPENNTC_FAST_UNROLL
    for (int k = 0; k < kParts; ++k)
        sum.part[k] = vbfdotq_f32(sum.part[k], vreinterpretq_bf16_f32(a), vreinterpretq_bf16_f32(b.part[k]));
}
/// Sixteen numbers to bfloat16, eight in a vector.
OPENNTC_FAST_INLINE void Convert(const Float& v, uint16x8_t (&to)[2]) {
    OPENNTC_FAST_UNROLL
    for (int k = 0; k < 2; ++k)
        to[k] =
            vreinterpretq_u16_bf16(vcvtq_high_bf16_f32(vcvtq_low_bf16_f32(v.part[2 * k]), v.part[2 * k + 1]));
}
OPENNTC_FAST_INLINE void StoreUnits(float* to, uint16x8_t v) {
    vst1q_f32(to, vreinterpretq_f32_u16(v));
}
/// Pairs of an even and an odd vector's numbers.
OPENNTC_FAST_INLINE void StoreInterleaved(float* to, const uint16x8_t (&even)[2],
                                          const uint16x8_t (&odd)[2]) {
    OPENNTC_FAST_UNROLL
    for (int k = 0; k < 2; ++k) {
        const uint16x8x2_t pairs = vzipq_u16(even[k], odd[k]);
        StoreUnits(to + 8 * k, pairs.val[0]);
        StoreUnits(to + 8 * k + 4, pairs.val[1]);
    }
}

struct Operand : PairedOperand {
    OPENNTC_FAST_INLINE void Put(int texel, int channel, const Float& even, const Float& odd) {
        uint16x8_t e[2], o[2];
        Convert(even, e);
        Convert(odd, o);
        float* to = rows.data() + texel * kRowPitch + channel / 2;
        StoreUnits(to, e[0]);
        StoreUnits(to + 4, e[1]);
        StoreUnits(to + kRowPitch, o[0]);
        StoreUnits(to + kRowPitch + 4, o[1]);
        StoreInterleaved(columns.data() + (texel / 2) * kColumnPitch + channel, e, o);
    }
};

OPENNTC_FAST_INLINE void PackWeights(float* forward, int, const Float& even, const Float& odd) {
    uint16x8_t e[2], o[2];
    Convert(even, e);
    Convert(odd, o);
    StoreInterleaved(forward, e, o);
}
OPENNTC_FAST_INLINE void PackTransposed(float* backward, int pitch, const Float& even, const Float& odd) {
    float pairs[2][8]; // of outputs
    uint16x8_t e[2], o[2];
    Convert(even, e);
    Convert(odd, o);
    for (int k = 0; k < 2; ++k) {
        StoreUnits(pairs[0] + 4 * k, e[k]);
        StoreUnits(pairs[1] + 4 * k, o[k]);
    }
    for (int k = 0; k < 8; ++k) {
        std::memcpy(backward + k * pitch, &pairs[0][k], sizeof(float));
        std::memcpy(backward + k * pitch + 1, &pairs[1][k], sizeof(float));
    }
}

#include "openntc/encode/detail/blocked/Matrix.inl"

#include "openntc/encode/detail/blocked/Latents.inl"

#include "openntc/encode/detail/blocked/Kernel.inl"

} // namespace openntc::encode::detail::neon::bf16

#if !defined(__clang__)
#pragma GCC pop_options
#endif
#endif

#include "openntc/core/RestoreMacros.h"
#endif
