// SPDX-License-Identifier: MIT
// What the fast decoder needs to know about compiler and processor: which instruction sets can be compiled,
// which the machine has, and how to keep a product from being fused with a following addition.
#pragma once

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error                                                                                                       \
    "openntc/decode: the decoder is exact; compile it without -ffast-math, -Ofast and -funsafe-math-optimizations"
#endif

#include <cfloat>
#include <cstdint>

#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error                                                                                                       \
    "openntc/decode: the decoder needs binary32 arithmetic without excess precision (on 32-bit x86: -mfpmath=sse)"
#endif

// x86 kernels use function-level targets. g++ for Windows is left out: it cannot align the stack to more than
// 16 bytes there (GCC bug 54412), so that spilled vectors would fault; clang for Windows is fine.
#if defined(__x86_64__) && (defined(__clang__) || (defined(__GNUC__) && !defined(_WIN32)))
#define OPENNTC_FAST_X86 1
#include <cpuid.h>
#else
#define OPENNTC_FAST_X86 0
#endif

// Matrix tiles need the permission of the operating system; how to ask for it is known for Linux.
#if OPENNTC_FAST_X86 && defined(__linux__)
#define OPENNTC_FAST_AMX 1
#include <sys/syscall.h>
#include <unistd.h>
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

#if defined(__clang__)
#define OPENNTC_FAST_UNROLL _Pragma("clang loop unroll(full)")
#define OPENNTC_FAST_INLINE inline __attribute__((always_inline))
#elif defined(__GNUC__)
#define OPENNTC_FAST_UNROLL _Pragma("GCC unroll 16")
#define OPENNTC_FAST_INLINE inline __attribute__((always_inline))
#else
#define OPENNTC_FAST_UNROLL
#define OPENNTC_FAST_INLINE inline
#endif

namespace openntc::fast {

/// a · b rounded to binary32 once, whatever follows.
OPENNTC_FAST_INLINE float MultiplyRounded(float a, float b) noexcept {
    float product = a * b;
    OPENNTC_KEEP_ROUNDED(product);
    return product;
}

/// Instruction sets of the machine that the fast decoder can use, as far as the operating system saves their
/// state.
struct ProcessorFeatures {
    bool avx2 = false; // with F16C
    bool avxVnni = false;
    bool avx512Vnni = false; // with F, BW, DQ and VL
    bool amxInt8 = false;    // with avx512Vnni; RequestTiles() comes before the first use
};

inline ProcessorFeatures DetectProcessor() noexcept {
    ProcessorFeatures features;
#if OPENNTC_FAST_X86
    unsigned a = 0;
    unsigned b = 0;
    unsigned c = 0;
    unsigned d = 0;
    if (__get_cpuid(1, &a, &b, &c, &d) == 0)
        return features;
    const bool osSavesState = (c >> 27 & 1u) != 0;
    const bool f16c = (c >> 29 & 1u) != 0;
    if (!osSavesState)
        return features;
    std::uint32_t stateLow = 0;
    std::uint32_t stateHigh = 0;
    __asm__ volatile("xgetbv" : "=a"(stateLow), "=d"(stateHigh) : "c"(0));
    const bool ymm = (stateLow & 0x06u) == 0x06u;
    const bool zmm = (stateLow & 0xE6u) == 0xE6u;
    if (__get_cpuid_count(7, 0, &a, &b, &c, &d) == 0)
        return features;
    features.avx2 = ymm && f16c && (b >> 5 & 1u) != 0;
    const bool avx512 =
        (b >> 16 & 1u) != 0 && (b >> 17 & 1u) != 0 && (b >> 30 & 1u) != 0 && (b >> 31 & 1u) != 0;
    features.avx512Vnni = zmm && features.avx2 && avx512 && (c >> 11 & 1u) != 0;
#if OPENNTC_FAST_AMX
    const bool tiles = (stateLow & 0x60000u) == 0x60000u;
    features.amxInt8 = tiles && features.avx512Vnni && (d >> 24 & 1u) != 0 && (d >> 25 & 1u) != 0;
#endif
    if (__get_cpuid_count(7, 1, &a, &b, &c, &d) != 0)
        features.avxVnni = features.avx2 && (a >> 4 & 1u) != 0;
#endif
    return features;
}

/// Asks the operating system to let this process use matrix tiles; true if it may. Signal frames grow by 8
/// KiB from then on.
inline bool RequestTiles() noexcept {
#if OPENNTC_FAST_AMX
    constexpr long kRequestPermission = 0x1023; // ARCH_REQ_XCOMP_PERM
    constexpr long kTileData = 18;              // XFEATURE_XTILEDATA
    return ::syscall(SYS_arch_prctl, kRequestPermission, kTileData) == 0;
#else
    return false;
#endif
}

} // namespace openntc::fast
