// SPDX-License-Identifier: MIT
// Stability: internal
// What the fast decoder needs to know about the compiler: whether it can compile matrix tiles, and how to
// keep a product from being fused with a following addition.
#pragma once

#include "openntc/core/Inline.h"
#include "openntc/core/Processor.h"

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error                                                                                                       \
    "openntc/decode: the decoder is exact; compile it without -ffast-math, -Ofast and -funsafe-math-optimizations"
#endif

#include <cfloat>

#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error                                                                                                       \
    "openntc/decode: the decoder needs binary32 arithmetic without excess precision (on 32-bit x86: -mfpmath=sse)"
#endif

// Matrix tiles: where their permission can be asked for.
#if OPENNTC_FAST_X86 && OPENNTC_DETECT_AMX
#define OPENNTC_FAST_AMX 1
#else
#define OPENNTC_FAST_AMX 0
#endif

// The value passes through an empty assembly statement, so that no compiler flag can fuse it into a
// multiply-add.
#if defined(__GNUC__) && defined(__SSE2__)
#define OPENNTC_KEEP_ROUNDED(value) __asm__("" : "+x"(value))
#elif defined(__GNUC__) && defined(__aarch64__)
#define OPENNTC_KEEP_ROUNDED(value) __asm__("" : "+w"(value))
#elif defined(__GNUC__)
#define OPENNTC_KEEP_ROUNDED(value) __asm__("" : "+m"(value))
#else
#define OPENNTC_KEEP_ROUNDED(value) static_cast<void>(value)
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::fast {

/// a · b rounded to binary32 once, whatever follows.
OPENNTC_FAST_INLINE float MultiplyRounded(float a, float b) noexcept {
    float product = a * b;
    OPENNTC_KEEP_ROUNDED(product);
    return product;
}

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
