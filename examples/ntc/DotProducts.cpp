// SPDX-License-Identifier: MIT
#include "DotProducts.h"

#include "openntc/core/Processor.h"
#include "openntc/decode/FastDecoder.h"

#include <algorithm>
#include <chrono>

namespace openntc::tool {

#if OPENNTC_FAST_X86

namespace {

constexpr int kTurns = 200000;
constexpr int kRuns = 5;
// Enough sums that none waits for its last product, and registers for them.
constexpr int kSums = 12;

// The registers are named in the text, so that nothing but the instructions is timed.
#define OPENNTC_DOT(prefix, v, sum) prefix "vpdpbusd %%" v "15, %%" v "14, %%" v sum "\n"
#define OPENNTC_DOTS(prefix, v)                                                                              \
    OPENNTC_DOT(prefix, v, "0")                                                                              \
    OPENNTC_DOT(prefix, v, "1")                                                                              \
    OPENNTC_DOT(prefix, v, "2")                                                                              \
    OPENNTC_DOT(prefix, v, "3")                                                                              \
    OPENNTC_DOT(prefix, v, "4")                                                                              \
    OPENNTC_DOT(prefix, v, "5")                                                                              \
    OPENNTC_DOT(prefix, v, "6")                                                                              \
    OPENNTC_DOT(prefix, v, "7")                                                                              \
    OPENNTC_DOT(prefix, v, "8")                                                                              \
    OPENNTC_DOT(prefix, v, "9")                                                                              \
    OPENNTC_DOT(prefix, v, "10")                                                                             \
    OPENNTC_DOT(prefix, v, "11")
#define OPENNTC_DOT_CLOBBERS                                                                                 \
    "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10", "xmm11"

// Code behind it may be slow while the upper halves are in use.
void FinishVectors() {
    __asm__ volatile("vzeroupper");
}

void AddProducts512() {
    for (int i = 0; i < kTurns; ++i)
        __asm__ volatile(OPENNTC_DOTS("", "zmm") : : : OPENNTC_DOT_CLOBBERS);
}

void AddProducts256() {
    for (int i = 0; i < kTurns; ++i)
        __asm__ volatile(OPENNTC_DOTS("%{vex%} ", "ymm") : : : OPENNTC_DOT_CLOBBERS);
}

double TimeProducts(void (*add)(), int productsPerInstruction) {
    double best = 0.0;
    for (int run = 0; run < kRuns; ++run) {
        const auto start = std::chrono::steady_clock::now();
        add();
        FinishVectors();
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
        best = std::max(best, static_cast<double>(kTurns) * kSums * productsPerInstruction / time.count());
    }
    return best;
}

} // namespace

#undef OPENNTC_DOT
#undef OPENNTC_DOTS
#undef OPENNTC_DOT_CLOBBERS

std::optional<double> MeasureDotProducts(SimdTarget target) {
    const ProcessorFeatures& features = GetProcessorFeatures();
    if (target == SimdTarget::Avx512Vnni && features.avx512Vnni)
        return TimeProducts(&AddProducts512, 64);
    if (target == SimdTarget::AvxVnni && features.avxVnni)
        return TimeProducts(&AddProducts256, 32);
    return std::nullopt;
}

#else

std::optional<double> MeasureDotProducts(SimdTarget) {
    return std::nullopt;
}

#endif

} // namespace openntc::tool
