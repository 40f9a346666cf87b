// SPDX-License-Identifier: MIT
// Stability: internal
// The block encoders of every instruction set that this compiler can be told of, and the choice among them.
#pragma once

#include "openntc/bc/detail/BlockBatch.h"
#include "openntc/core/Processor.h"

// g++ 12 at -O3 takes loops whose body asks `which part is this?` for ones that run out of an array, and
// drops their end: other blocks than at -O2. No sanitizer finds anything.
#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpass-failed" // of loops whose length it comes to know too late
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("no-aggressive-loop-optimizations")
#endif

#include "openntc/core/HideMacros.h"

#include "openntc/Portability.h"

#include "openntc/bc/detail/Kernels.inl" // plain ints: NTC_LANES is 1 where nothing is said

#if defined(__GNUC__)
#undef NTC_LANES
#undef NTC_LANES_TARGET
#define NTC_LANES 4
#define NTC_LANES_TARGET lanes4
#include "openntc/bc/detail/Kernels.inl"
#endif

#if OPENNTC_FAST_X86
#undef NTC_LANES
#undef NTC_LANES_TARGET
#define NTC_LANES 8
#define NTC_LANES_TARGET lanes8
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
#include "openntc/bc/detail/Kernels.inl"
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#undef NTC_LANES
#undef NTC_LANES_TARGET
#define NTC_LANES 16
#define NTC_LANES_TARGET lanes16
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2"))),             \
                             apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx2,prefer-vector-width=512")
#endif
#include "openntc/bc/detail/Kernels.inl"
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

#undef NTC_LANES
#undef NTC_LANES_TARGET
#define NTC_LANES 1
#define NTC_LANES_TARGET lanes1

#if defined(__clang__)
#pragma clang diagnostic pop
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif

#include "openntc/core/RestoreMacros.h"
