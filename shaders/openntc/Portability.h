// SPDX-License-Identifier: MIT
// The prelude that lets one shader source compile as GLSL (glslang), HLSL (glslang -D, DXC, Slang) and C++20
// with GLM.
//
// Common tongue: HLSL spellings (uint, int2, asuint, asfloat), free functions, literals 1.0f and 1u, explicit
// casts.
//   NTC_FUNCTION          before every function
//   NTC_IN_ARRAY, NTC_OUT_ARRAY, NTC_INOUT_ARRAY(T, name, size)   array parameters
//   NTC_PRECISE           before every float that must be rounded once per operation and never be contracted
//   NtcMultiply(a, b)     a product that no compiler may fuse into a following addition
//   NtcBuffer             a read-only byte-addressed buffer; NtcBufferLoad(buffer, byteOffset) reads one
//   32-bit word
//
// Buffers. GLSL: NtcBuffer is a number, NTC_LATENTS or NTC_WEIGHTS, and the two storage buffers are declared
// below at NTC_DESCRIPTOR_SET, NTC_LATENTS_BINDING and NTC_WEIGHTS_BINDING (0, 1, 2 unless defined). HLSL:
// NtcBuffer is ByteAddressBuffer. C++: pointer and size; words outside read 0. An engine replaces this by
// defining both macros before the first include: `#define NtcBuffer uint` and `#define NtcBufferLoad(buffer,
// byteOffset) MyLoad(...)`.
//
// HLSL through glslangValidator -D needs -DNTC_HLSL=1 (it cannot be told from GLSL otherwise) and vulkan1.1.
#ifndef OPENNTC_PORTABILITY_H
#define OPENNTC_PORTABILITY_H

#if !defined(NTC_HLSL) && (defined(__HLSL_VERSION) || defined(__hlsl_dx_compiler) || defined(__SLANG__))
#define NTC_HLSL 1
#endif

#include "WeightFetch.h"

#if defined(__cplusplus)
// ----------------------------------------------------------------------------------------------------------
// C++
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0) ||                 \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(_M_FP_FAST)
#error                                                                                                       \
    "OpenNTC: decoding is bit-exact; -ffast-math (or -Ofast, -fassociative-math, /fp:fast) would break that"
#endif
#include <cfloat>
#if FLT_EVAL_METHOD != 0
#error                                                                                                       \
    "OpenNTC: decoding is bit-exact and needs float arithmetic in binary32; on 32-bit x86 use -msse2 -mfpmath=sse"
#endif

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <glm/vec2.hpp>

#define NTC_FUNCTION inline
#define NTC_IN_ARRAY(T, name, size) const T(&name)[size]
#define NTC_OUT_ARRAY(T, name, size) T(&name)[size]
#define NTC_INOUT_ARRAY(T, name, size) T(&name)[size]
#define NTC_PRECISE
#define NTC_LOOP
#define NTC_UNROLL
#define NTC_NAMESPACE_BEGIN namespace openntc::shader {
#define NTC_NAMESPACE_END }

namespace openntc::shader {

using uint = std::uint32_t;
using int2 = glm::ivec2;

inline int min(int a, int b) {
    return b < a ? b : a;
}
inline int max(int a, int b) {
    return a < b ? b : a;
}
inline float abs(float x) {
    return std::fabs(x);
}
inline float floor(float x) {
    return std::floor(x);
}
inline float sqrt(float x) {
    return std::sqrt(x);
}
inline float exp(float x) {
    return std::exp(x);
}
inline float log(float x) {
    return std::log(x);
}
inline float pow(float x, float y) {
    return std::pow(x, y);
}
inline uint asuint(float x) {
    return std::bit_cast<uint>(x);
}
inline float asfloat(uint x) {
    return std::bit_cast<float>(x);
}

/// The product, rounded once. The empty asm hides where the value comes from, so that not even
/// -march=native -ffp-contract=fast can fuse it into a following addition; it costs no instruction.
inline float NtcMultiply(float a, float b) {
    float product = a * b;
#if (defined(__GNUC__) || defined(__clang__)) && (defined(__x86_64__) || defined(__SSE2__))
    __asm__("" : "+x"(product));
    return product;
#elif (defined(__GNUC__) || defined(__clang__)) && defined(__aarch64__)
    __asm__("" : "+w"(product));
    return product;
#else
    volatile float stored = product;
    return stored;
#endif
}

#if !defined(NtcBufferLoad)
/// Read-only memory. Words that are not wholly inside read as 0, like robust buffer access on a GPU.
struct NtcBuffer {
    const void* data = nullptr;
    std::size_t size = 0; // bytes
};
inline uint NtcBufferLoad(const NtcBuffer& buffer, uint byteOffset) {
    uint word = 0;
    if (std::size_t(byteOffset) + 4 <= buffer.size)
        std::memcpy(&word, static_cast<const unsigned char*>(buffer.data) + byteOffset, 4);
    if constexpr (std::endian::native == std::endian::big)
        word = (word >> 24) | ((word >> 8) & 0xFF00u) | ((word << 8) & 0xFF0000u) | (word << 24);
    return word;
}
#endif

} // namespace openntc::shader

#else
// ------------------------------------------------------------------------------------------------ GLSL and
// HLSL
#define NTC_FUNCTION
#define NTC_IN_ARRAY(T, name, size) in T name[size]
#define NTC_OUT_ARRAY(T, name, size) out T name[size]
#define NTC_INOUT_ARRAY(T, name, size) inout T name[size]
#define NTC_PRECISE precise
#define NTC_NAMESPACE_BEGIN
#define NTC_NAMESPACE_END

#if defined(NTC_HLSL)
#define NTC_LOOP [loop]
#define NTC_UNROLL [unroll]
#if !defined(NtcBufferLoad)
#define NtcBuffer ByteAddressBuffer
#define NtcBufferLoad(buffer, byteOffset) (buffer).Load(byteOffset)
#define NtcLoadFourWeightWords(buffer, byteOffset) (buffer).Load4(byteOffset)
#endif
#else
#extension GL_EXT_control_flow_attributes : require
#define NTC_LOOP [[dont_unroll]]
#define NTC_UNROLL [[unroll]]
// The only names of ours without Ntc or NTC_. An engine's own macros of these names are used as they are, function-like
// ones too; they must mean the same.
#ifndef int2
#define int2 ivec2
#endif
#ifndef uint4
#define uint4 uvec4
#endif
#ifndef float4
#define float4 vec4
#endif
#ifndef asuint
#define asuint floatBitsToUint
#endif
#ifndef asfloat
#define asfloat uintBitsToFloat
#endif
#if defined(NtcBufferLoad)
#define NTC_OWN_BUFFER_LOAD
#else
#ifndef NTC_DESCRIPTOR_SET
#define NTC_DESCRIPTOR_SET 0
#endif
#ifndef NTC_LATENTS_BINDING
#define NTC_LATENTS_BINDING 1
#endif
#ifndef NTC_WEIGHTS_BINDING
#define NTC_WEIGHTS_BINDING 2
#endif
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_LATENTS_BINDING, std430) readonly buffer NtcLatentsBlock {
    uint words[];
}
ntcLatents;
#define NtcBuffer uint
#define NTC_LATENTS 0u
#define NTC_WEIGHTS 1u
#if NTC_WEIGHT_FETCH == NTC_FETCH_UNIFORM
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_WEIGHTS_BINDING, std140) uniform NtcWeightsBlock {
    uvec4 words[808 + 64 * NETWORK_VERSION]; // 13952 ... 17024 bytes
}
ntcWeights;
uint NtcBufferLoad(NtcBuffer buffer_, uint byteOffset) {
    return buffer_ == NTC_LATENTS ? ntcLatents.words[byteOffset >> 2]
                                  : ntcWeights.words[byteOffset >> 4][(byteOffset >> 2) & 3u];
}
uvec4 NtcLoadFourWeightWords(NtcBuffer buffer_, uint byteOffset) {
    return ntcWeights.words[byteOffset >> 4];
}
#else
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_WEIGHTS_BINDING, std430) readonly buffer NtcWeightsBlock {
    uint words[];
}
ntcWeights;
uint NtcBufferLoad(NtcBuffer buffer_, uint byteOffset) { // folds: the buffer is a literal at every call
    return buffer_ == NTC_LATENTS ? ntcLatents.words[byteOffset >> 2] : ntcWeights.words[byteOffset >> 2];
}
#if NTC_WIDE_WEIGHT_LOADS
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_WEIGHTS_BINDING, std430) readonly buffer NtcWideWeightsBlock {
    uvec4 words[];
}
ntcWideWeights;
uvec4 NtcLoadFourWeightWords(NtcBuffer buffer_, uint byteOffset) {
    return ntcWideWeights.words[byteOffset >> 4];
}
#endif
#endif
#endif
// Word by word where the buffer is not declared above, or weightsOffset need not be a multiple of 16.
#if (NTC_WIDE_WEIGHT_LOADS && defined(NTC_OWN_BUFFER_LOAD)) ||                                               \
    (!NTC_WIDE_WEIGHT_LOADS && NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP)
uvec4 NtcLoadFourWeightWords(NtcBuffer buffer_, uint byteOffset) {
    return uvec4(NtcBufferLoad(buffer_, byteOffset), NtcBufferLoad(buffer_, byteOffset + 4u),
                 NtcBufferLoad(buffer_, byteOffset + 8u), NtcBufferLoad(buffer_, byteOffset + 12u));
}
#endif
#endif

float NtcMultiply(float a, float b) {
    precise float product = a * b;
    return product;
}
#endif

NTC_NAMESPACE_BEGIN

/// Byte `index` (0 is the lowest) of a word, sign-extended.
NTC_FUNCTION int NtcSignedByte(uint word, uint index) {
    return int(word << (24u - 8u * index)) >> 24;
}

/// True for NaN, by bits: compilers may assume away float comparisons with themselves.
NTC_FUNCTION bool NtcIsNan(float x) {
    return (asuint(x) & 0x7FFFFFFFu) > 0x7F800000u;
}

/// Dot product of two words of four signed bytes, by bit operations. Every accelerated form equals it.
NTC_FUNCTION int NtcDot4Emulated(uint a, uint b) {
    return NtcSignedByte(a, 0u) * NtcSignedByte(b, 0u) + NtcSignedByte(a, 1u) * NtcSignedByte(b, 1u) +
           NtcSignedByte(a, 2u) * NtcSignedByte(b, 2u) + NtcSignedByte(a, 3u) * NtcSignedByte(b, 3u);
}

NTC_NAMESPACE_END

// The hardware dot product. GLSL: define NTC_DOT4_SPIRV (SPV_KHR_integer_dot_product, core in Vulkan 1.3);
// the device must have shaderIntegerDotProduct. HLSL: define NTC_DOT4_SM64 (shader model 6.4; not known to
// glslang -D).
#if defined(NTC_DOT4_SPIRV) && !defined(NTC_HLSL) && !defined(__cplusplus)
#extension GL_EXT_spirv_intrinsics : require
spirv_instruction(extensions = ["SPV_KHR_integer_dot_product"], capabilities = [ 6018, 6019 ],
                  id = 4450) int NtcOpSDot(uint a, uint b, spirv_literal int packedFormat);
#define NtcDot4(a, b) NtcOpSDot(a, b, 0)
#elif defined(NTC_DOT4_SM64) && defined(NTC_HLSL)
#define NtcDot4(a, b) dot4add_i8packed(a, b, 0)
#else
#define NtcDot4(a, b) NtcDot4Emulated(a, b)
#endif

#endif
