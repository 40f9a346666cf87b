// SPDX-License-Identifier: MIT
// The C++ side of Portability.h, which includes it. Names in parentheses are those that hosts have as
// function-like macros.
#ifndef OPENNTC_PORTABILITY_CPP_H
#define OPENNTC_PORTABILITY_CPP_H

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
#include <glm/vec4.hpp>

#define NTC_FUNCTION inline
#define NTC_IN_ARRAY(T, name, size) const T(&name)[size]
#define NTC_OUT_ARRAY(T, name, size) T(&name)[size]
#define NTC_INOUT_ARRAY(T, name, size) T(&name)[size]
#define NTC_OUT(T, name) T& name
#define NTC_INOUT(T, name) T& name
#define NTC_PRECISE
#define NTC_LOOP
#define NTC_UNROLL
#define NTC_NAMESPACE_BEGIN namespace openntc::shader {
#define NTC_NAMESPACE_END }

namespace openntc::shader {

using uint = std::uint32_t;
using int2 = glm::ivec2;
using float2 = glm::vec2;
using float4 = glm::vec4;
using uint4 = glm::uvec4;

inline int(min)(int a, int b) {
    return b < a ? b : a;
}
inline uint(min)(uint a, uint b) {
    return a < b ? a : b;
}
inline int(max)(int a, int b) {
    return a < b ? b : a;
}
inline float(abs)(float x) {
    return (std::fabs)(x);
}
inline float(floor)(float x) {
    return (std::floor)(x);
}
inline float(sqrt)(float x) {
    return (std::sqrt)(x);
}
inline float(exp)(float x) {
    return (std::exp)(x);
}
inline float(log)(float x) {
    return (std::log)(x);
}
inline float(pow)(float x, float y) {
    return (std::pow)(x, y);
}
inline uint asuint(float x) {
    return __builtin_bit_cast(uint, x);
}
inline float asfloat(uint x) {
    return __builtin_bit_cast(float, x);
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

} // namespace openntc::shader

#endif
