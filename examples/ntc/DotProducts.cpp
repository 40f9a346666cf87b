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
#define OPENNTC_DOT_TWELVE(prefix, register)                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                \
    prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "0\n" prefix                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                          \
                                                                      "vpdpbusd %%" register "15, "                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                         \
                                                                                             "%%" register "14, %%" register "1\n" prefix                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                   \
                                                                                                                             "vpdpbusd %%" register "15, %%" register "14, %%" register "2\n" prefix                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                        \
                                                                                                                                                                                        "vpdpbusd %%" register "15, %%" register "14, %%" register "3\n" prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "4\n" prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "5\n" prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "6\n" prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "7\n" prefix                                                                                                                                                                                                             \
                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                   "vpdpbusd %%" register "15, %%" register "14, %%" register "8\n" prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "9\n" prefix "vpdpbusd %%" register "15, %%" register "14, %%" register "10\n" prefix \
                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                                              "vpdpbusd %%" register "15, %%" register "14, %%" register "11\n"
#define OPENNTC_DOT_CLOBBERS                                                                                 \
    "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10", "xmm11"

// Code behind it may be slow while the upper halves are in use.
void FinishVectors() {
    __asm__ volatile("vzeroupper");
}

void AddProducts512() {
    for (int i = 0; i < kTurns; ++i)
        __asm__ volatile(OPENNTC_DOT_TWELVE("", "zmm") : : : OPENNTC_DOT_CLOBBERS);
}

void AddProducts256() {
    for (int i = 0; i < kTurns; ++i)
        __asm__ volatile(OPENNTC_DOT_TWELVE("%{vex%} ", "ymm") : : : OPENNTC_DOT_CLOBBERS);
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

#undef OPENNTC_DOT_TWELVE
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
