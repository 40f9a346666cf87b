// SPDX-License-Identifier: MIT
#include "Peak.h"

#include "openntc/core/Processor.h"

#include <algorithm>
#include <ctime>

namespace openntc::bench {

namespace {

#if OPENNTC_FAST_X86
// Twelve sums: more than the product of latency and instructions per cycle on processors so far.
#define OPENNTC_TWELVE(instruction, r)                                                                       \
    instruction " %%" r "12,%%" r "12,%%" r "0\n" instruction " %%" r "12,%%" r "12,%%" r "1\n" instruction  \
                " %%" r "12,%%" r "12,%%" r "2\n" instruction " %%" r "12,%%" r "12,%%" r "3\n" instruction  \
                " %%" r "12,%%" r "12,%%" r "4\n" instruction " %%" r "12,%%" r "12,%%" r "5\n" instruction  \
                " %%" r "12,%%" r "12,%%" r "6\n" instruction " %%" r "12,%%" r "12,%%" r "7\n" instruction  \
                " %%" r "12,%%" r "12,%%" r "8\n" instruction " %%" r "12,%%" r "12,%%" r "9\n" instruction  \
                " %%" r "12,%%" r "12,%%" r "10\n" instruction " %%" r "12,%%" r "12,%%" r "11\n"
#define OPENNTC_LOOP(instruction, r)                                                                         \
    __asm__ volatile("vzeroall\n1:\n" OPENNTC_TWELVE(instruction, r) "dec %0\njnz 1b\nvzeroupper\n"          \
                     : "+r"(count)                                                                           \
                     :                                                                                       \
                     : "cc", "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", \
                       "xmm10", "xmm11", "xmm12", "xmm13", "xmm14", "xmm15")

/// Multiply-adds of one instruction.
int RunLoop(encode::KernelChoice kernel, long count) {
    switch (kernel) {
    case encode::KernelChoice::Avx512Bf16:
        OPENNTC_LOOP("vdpbf16ps", "zmm");
        return 32;
    case encode::KernelChoice::Avx512:
        OPENNTC_LOOP("vfmadd231ps", "zmm");
        return 16;
    case encode::KernelChoice::Avx2:
        OPENNTC_LOOP("vfmadd231ps", "ymm");
        return 8;
    default:
        return 0;
    }
}

#undef OPENNTC_LOOP
#undef OPENNTC_TWELVE
#else
int RunLoop(encode::KernelChoice, long) {
    return 0;
}
#endif

} // namespace

double MeasurePeak(encode::KernelChoice kernel) {
    constexpr long kCount = 4000000;
    double best = 0.0;
    for (int repeat = 0; repeat < 5; ++repeat) {
        const std::clock_t begin = std::clock();
        const int work = RunLoop(kernel, kCount);
        const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        if (work == 0)
            return 0.0;
        best = std::max(best, 12.0 * static_cast<double>(kCount) * work / std::max(seconds, 1e-6));
    }
    return best;
}

} // namespace openntc::bench
