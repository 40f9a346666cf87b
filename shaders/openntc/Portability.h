// SPDX-License-Identifier: MIT
// The prelude that lets one shader source compile as GLSL, HLSL and C++20 with GLM. It declares no resource:
// where latents and weights are read from is Buffers.h.
//
// Common tongue: HLSL spellings (uint, int2, asuint, asfloat), free functions, literals 1.0f and 1u, explicit
// casts.
//   NTC_FUNCTION          before every function
//   NTC_IN_ARRAY, NTC_OUT_ARRAY, NTC_INOUT_ARRAY(T, name, size)   array parameters
//   NTC_OUT, NTC_INOUT(T, name)   parameters that are written
//   NTC_PRECISE           before every float that must be rounded once per operation and never be contracted
//   NtcKeep(x)            a float that no compiler may merge with the operation that uses it
//   NtcMultiply(a, b)     a product that no compiler may fuse into a following addition
//   NTC_LOOP, NTC_UNROLL  before every loop; nothing where the language has no such attributes
//
// Exactness. Compilers that know `precise` and obey it (glslang; DXC and FXC to DXIL and DXBC) need nothing.
// For all others define, before the first include,
//   NTC_NO_PRECISE        the language has no such qualifier (GLSL ES before 3.20, WGSL, Metal)
//   NTC_OPAQUE_ZERO       a uint expression that is 0 at run time and that no compiler can know: a member of
//                         a uniform buffer. Without it they merge the constants of roundings, and texels are
//                         wrong.
// Slang drops `precise` on the way to SPIR-V without a word, so it is refused without NTC_OPAQUE_ZERO or
//   NTC_TRUST_PRECISE     the qualifier is kept: output as GLSL or HLSL for another compiler, or a slangc
//                         that knows -fp-mode precise
// NTC_NO_LOOP_ATTRIBUTES leaves loop attributes out where a compiler claims GL_EXT_control_flow_attributes in
// vain. The engine sets `precision highp float; precision highp int;` where GLSL ES wants it.
//
// HLSL through glslangValidator -D needs -DNTC_HLSL=1 (it cannot be told from GLSL otherwise) and vulkan1.1.
#ifndef OPENNTC_PORTABILITY_H
#define OPENNTC_PORTABILITY_H

#if !defined(NTC_HLSL) && (defined(__HLSL_VERSION) || defined(__hlsl_dx_compiler) || defined(__SLANG__))
#define NTC_HLSL 1
#endif

#if defined(__SLANG__) && !defined(NTC_OPAQUE_ZERO) && !defined(NTC_TRUST_PRECISE)
#error Slang may drop the qualifier precise, and texels are wrong then: define NTC_OPAQUE_ZERO, or NTC_TRUST_PRECISE if it is kept (Portability.h)
#endif

#if defined(NTC_OPAQUE_ZERO)
#define NtcKeep(x) asfloat(asuint(x) | (NTC_OPAQUE_ZERO)) // not ^, of which two undo each other
#else
#define NtcKeep(x) (x)
#endif

#if defined(__cplusplus)
// With a space: bundlers of web engines paste every #include that they see, whatever #if it is under.
// clang-format off
# include "PortabilityCpp.h"
// clang-format on
#else
// -------------------------------------------------------------------------------------------- GLSL and HLSL
#define NTC_FUNCTION
#define NTC_IN_ARRAY(T, name, size) in T name[size]
#define NTC_OUT_ARRAY(T, name, size) out T name[size]
#define NTC_INOUT_ARRAY(T, name, size) inout T name[size]
#define NTC_OUT(T, name) out T name
#define NTC_INOUT(T, name) inout T name
#if defined(NTC_NO_PRECISE)
#define NTC_PRECISE
#else
#define NTC_PRECISE precise
#endif
#define NTC_NAMESPACE_BEGIN
#define NTC_NAMESPACE_END

#if defined(NTC_HLSL)
#define NTC_LOOP [loop]
#define NTC_UNROLL [unroll]
#else
#if defined(GL_EXT_control_flow_attributes) && !defined(NTC_NO_LOOP_ATTRIBUTES)
#extension GL_EXT_control_flow_attributes : require
#define NTC_LOOP [[dont_unroll]]
#define NTC_UNROLL [[unroll]]
#else
#define NTC_LOOP
#define NTC_UNROLL
#endif
// The only names of ours without Ntc or NTC_. An engine's own macros of these names are used as they are,
// function-like ones too; they must mean the same.
#ifndef int2
#define int2 ivec2
#endif
#ifndef float2
#define float2 vec2
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
#endif

float NtcMultiply(float a, float b) {
    NTC_PRECISE float product = a * b;
    return NtcKeep(product);
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
