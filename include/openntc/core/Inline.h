// SPDX-License-Identifier: MIT
// Stability: internal
// How kernels of the decoder and the encoder ask compilers for inlining and unrolling, without which
// vectors that are arrays do not stay in registers.
#pragma once

#if defined(__clang__)
#define OPENNTC_FAST_UNROLL _Pragma("clang loop unroll(full)")
#define OPENNTC_FAST_INLINE inline __attribute__((always_inline))
#define OPENNTC_FAST_NOINLINE inline __attribute__((noinline))
#elif defined(__GNUC__)
#define OPENNTC_FAST_UNROLL _Pragma("GCC unroll 16")
#define OPENNTC_FAST_INLINE inline __attribute__((always_inline))
#define OPENNTC_FAST_NOINLINE inline __attribute__((noinline))
#else
#define OPENNTC_FAST_UNROLL
#define OPENNTC_FAST_INLINE inline
#define OPENNTC_FAST_NOINLINE inline
#endif
