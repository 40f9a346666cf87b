// SPDX-License-Identifier: MIT
// The runtime alone, compiled with -ffast-math: numbers from files are still told from infinities and NaN.
#include <openntc/openntc.h>

#include <bit>
#include <cstdint>
#include <cstdio>

int main() {
    // Volatile: compilers that take NaN for impossible must not know these.
    volatile std::uint32_t bits[] = {0x7F800000u, 0xFF800000u, 0x7FC00000u,
                                     0xFFFFFFFFu, 0x7F7FFFFFu, 0x80000000u};
    const bool isFinite[] = {false, false, false, false, true, true};
    int wrong = 0;
    for (int i = 0; i < 6; ++i) {
        const float value = std::bit_cast<float>(std::uint32_t{bits[i]});
        wrong += openntc::IsFinite(value) == isFinite[i] ? 0 : 1;
        wrong += openntc::IsMagnitudeAtMost(value, 3.402823466e38f) == isFinite[i] ? 0 : 1;
    }
    // Thirds to the nearest binary32: 2/3, 5/3 and 7/3 by IEEE 754.
    volatile int mips[] = {2, 5, 7};
    const std::uint32_t thirds[] = {0x3F2AAAABu, 0x3FD55555u, 0x40155555u};
    for (int i = 0; i < 3; ++i)
        wrong += std::bit_cast<std::uint32_t>(openntc::GetPositionLod(mips[i], 0)) == thirds[i] ? 0 : 1;
    std::printf("%d wrong\n", wrong);
    return wrong == 0 ? 0 : 1;
}
