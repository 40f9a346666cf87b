// SPDX-License-Identifier: MIT
// Stability: internal
// What the processor can do, asked once per process; the fast decoder and the encoder choose their code by
// it.
//
// The environment variable OPENNTC_SIMD_CAP takes instruction sets away from the whole process, so that one
// machine tests what others run: `none`, `avx2`, `avxvnni`, `avx512` or `amx`, each with those before it. (On
// Arm `none` takes BF16 away, which the others leave.) Unset or empty: no cap. Any other value is an error of
// FastDecoder::Create and Encoder::Encode, never a guess. It is read once, at the first question.
#pragma once

#include "openntc/core/Expected.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>

#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define OPENNTC_DETECT_X86 1
#include <cpuid.h>
#else
#define OPENNTC_DETECT_X86 0
#endif

// x86 kernels use function-level targets. g++ for Windows is left out: it cannot align the stack to more than
// 16 bytes there (GCC bug 54412), so that spilled vectors would fault; clang for Windows is fine.
#if defined(__x86_64__) && (defined(__clang__) || (defined(__GNUC__) && !defined(_WIN32)))
#define OPENNTC_FAST_X86 1
#else
#define OPENNTC_FAST_X86 0
#endif

// 64-bit Arm always has NEON with fused multiply-add. Its BF16 instructions need a compiler that takes them
// function by function, or a target that has them.
#if defined(__aarch64__) && defined(__GNUC__)
#define OPENNTC_FAST_NEON 1
#else
#define OPENNTC_FAST_NEON 0
#endif
#if OPENNTC_FAST_NEON && (!defined(__clang__) || defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC))
#define OPENNTC_FAST_NEON_BF16 1
#else
#define OPENNTC_FAST_NEON_BF16 0
#endif
#if OPENNTC_FAST_NEON && defined(__linux__)
#include <sys/auxv.h>
#elif OPENNTC_FAST_NEON && defined(__APPLE__)
#include <sys/sysctl.h>
#endif

// Matrix tiles need the permission of the operating system; how to ask for it is known for Linux.
#if defined(__x86_64__) && defined(__GNUC__) && defined(__linux__)
#define OPENNTC_DETECT_AMX 1
#include <sys/syscall.h>
#include <unistd.h>
#else
#define OPENNTC_DETECT_AMX 0
#endif

#include "openntc/core/HideMacros.h"

namespace openntc {

/// The most that a process may use: see OPENNTC_SIMD_CAP above. Each contains those before it.
enum class SimdCap {
    None,            ///< what every processor of the architecture has
    Baseline = None, ///< for sources that include X11's headers, where None is a macro
    Avx2,            ///< with FMA and F16C
    AvxVnni,
    Avx512, ///< with VNNI and BF16
    Amx,
};

/// The cap of a name as in OPENNTC_SIMD_CAP; null and "" are Amx, no cap. Errors: InvalidArgument.
inline Expected<SimdCap> ParseSimdCap(const char* name) noexcept {
    constexpr struct {
        const char* name;
        SimdCap cap;
    } kCaps[] = {{"", SimdCap::Amx},          {"none", SimdCap::None},
                 {"avx2", SimdCap::Avx2},     {"avxvnni", SimdCap::AvxVnni},
                 {"avx512", SimdCap::Avx512}, {"amx", SimdCap::Amx}};
    for (const auto& known : kCaps) {
        if (std::strcmp(name != nullptr ? name : "", known.name) == 0)
            return known.cap;
    }
    return Fail(Status::InvalidArgument,
                "OPENNTC_SIMD_CAP: %.32s: must be none, avx2, avxvnni, avx512 or amx", name);
}

/// What OPENNTC_SIMD_CAP says. Errors: InvalidArgument for a value that is none of the names.
inline const Expected<SimdCap>& GetSimdCap() noexcept {
#if defined(_MSC_VER)
#pragma warning(push)
#pragma warning(disable : 4996) // getenv: the value is looked at before anybody could change it
#endif
    static const Expected<SimdCap> cap = ParseSimdCap(std::getenv("OPENNTC_SIMD_CAP"));
#if defined(_MSC_VER)
#pragma warning(pop)
#endif
    return cap;
}

/// Instruction sets that this process may use: the processor has them, the operating system saves their state
/// and OPENNTC_SIMD_CAP allows them. All false on processors other than x86 and 64-bit Arm, and with
/// compilers other than GCC and Clang.
struct ProcessorFeatures {
    bool avx2 = false; ///< with F16C and FMA
    bool fma = false;  ///< the same
    bool avxVnni = false;
    bool avx512 = false;     ///< F, BW, DQ and VL, with avx2
    bool avx512Vnni = false; ///< with F, BW, DQ and VL
    bool avx512Bf16 = false; ///< with F, BW, DQ and VL
    bool amxInt8 = false;    ///< with avx512Vnni; RequestMatrixTiles() comes before the first use
    bool amxBf16 = false;    ///< with avx512Bf16 and fma; RequestMatrixTiles() comes before the first use
    bool neonBf16 = false;   ///< 64-bit Arm: dot products and conversions
};

/// Takes away what is above a cap.
constexpr ProcessorFeatures LimitFeatures(ProcessorFeatures features, SimdCap cap) noexcept {
    features.avx2 = features.avx2 && cap >= SimdCap::Avx2;
    features.fma = features.fma && cap >= SimdCap::Avx2;
    features.avxVnni = features.avxVnni && cap >= SimdCap::AvxVnni;
    features.avx512 = features.avx512 && cap >= SimdCap::Avx512;
    features.avx512Vnni = features.avx512Vnni && cap >= SimdCap::Avx512;
    features.avx512Bf16 = features.avx512Bf16 && cap >= SimdCap::Avx512;
    features.amxInt8 = features.amxInt8 && cap >= SimdCap::Amx;
    features.amxBf16 = features.amxBf16 && cap >= SimdCap::Amx;
    features.neonBf16 = features.neonBf16 && cap > SimdCap::None;
    return features;
}

namespace detail {

/// Processor and operating system alone.
inline ProcessorFeatures ReadProcessor() noexcept {
    ProcessorFeatures features;
#if OPENNTC_DETECT_X86
    struct Registers {
        unsigned a = 0, b = 0, c = 0, d = 0;
    };
    const auto has = [](unsigned bits, int bit) { return (bits >> bit & 1u) != 0; };
    Registers basic, extended, more;
    if (__get_cpuid(1, &basic.a, &basic.b, &basic.c, &basic.d) == 0 || !has(basic.c, 27)) // OSXSAVE
        return features;
    if (__get_cpuid_count(7, 0, &extended.a, &extended.b, &extended.c, &extended.d) == 0)
        return features;
    if (__get_cpuid_count(7, 1, &more.a, &more.b, &more.c, &more.d) == 0)
        more = {};
    std::uint32_t stateLow = 0;
    std::uint32_t stateHigh = 0;
    __asm__ volatile("xgetbv" : "=a"(stateLow), "=d"(stateHigh) : "c"(0));
    const auto saves = [&](std::uint32_t state) { return (stateLow & state) == state; };

    features.avx2 = saves(0x06) && has(basic.c, 29) && has(basic.c, 12) && has(extended.b, 5);
    features.fma = features.avx2;
    features.avxVnni = features.avx2 && has(more.a, 4);
    features.avx512 = features.avx2 && saves(0xE6) && has(extended.b, 16) && has(extended.b, 17) &&
                      has(extended.b, 30) && has(extended.b, 31);
    features.avx512Vnni = features.avx512 && has(extended.c, 11);
    features.avx512Bf16 = features.avx512 && has(more.a, 5);
#if OPENNTC_DETECT_AMX
    const bool tiles = saves(0x60000) && has(extended.d, 24);
    features.amxInt8 = tiles && features.avx512Vnni && has(extended.d, 25);
    features.amxBf16 = tiles && features.avx512Bf16 && features.fma && has(extended.d, 22);
#endif
#elif OPENNTC_FAST_NEON && defined(__linux__)
    constexpr unsigned long kBf16 = 1ul << 14; // HWCAP2_BF16, which old headers lack
    features.neonBf16 = (::getauxval(AT_HWCAP2) & kBf16) != 0;
#elif OPENNTC_FAST_NEON && defined(__APPLE__)
    int has = 0;
    std::size_t size = sizeof(has);
    features.neonBf16 = ::sysctlbyname("hw.optional.arm.FEAT_BF16", &has, &size, nullptr, 0) == 0 && has != 0;
#endif
    return features;
}

} // namespace detail

/// What this process may use. With a bad OPENNTC_SIMD_CAP: nothing.
inline const ProcessorFeatures& GetProcessorFeatures() noexcept {
    static const ProcessorFeatures features =
        LimitFeatures(detail::ReadProcessor(), GetSimdCap() ? *GetSimdCap() : SimdCap::None);
    return features;
}

/// Asks the operating system, once, to let this process use matrix tiles; true if it may. Signal frames grow
/// by 8 KiB from then on.
inline bool RequestMatrixTiles() noexcept {
#if OPENNTC_DETECT_AMX
    static const bool granted = [] {
        constexpr long kRequestPermission = 0x1023; // ARCH_REQ_XCOMP_PERM
        constexpr long kTileData = 18;              // XFEATURE_XTILEDATA
        return ::syscall(SYS_arch_prctl, kRequestPermission, kTileData) == 0;
    }();
    return granted;
#else
    return false;
#endif
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
