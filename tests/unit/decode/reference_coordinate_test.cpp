// SPDX-License-Identifier: MIT
// Texel centres: (x + 1/2) / W must be the correctly rounded binary32 quotient even where division is not.
#include "openntc/Latents.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

namespace shader = openntc::shader;

namespace {

// IEEE division of the CPU: both operands are exact for |x| < 2^22.
std::uint32_t DivideBits(int x, int size) {
    return std::bit_cast<std::uint32_t>((static_cast<float>(x) + 0.5f) / static_cast<float>(size));
}

std::uint32_t CenterBits(int x, int size) {
    return std::bit_cast<std::uint32_t>(shader::NtcTexelCenter(x, size));
}

class Random {
public:
    std::uint32_t Next() {
        state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
        return static_cast<std::uint32_t>(state_ >> 32);
    }

private:
    std::uint64_t state_ = 7;
};

} // namespace

TEST_CASE("texel centres equal IEEE division: every texel of sizes 1 to 2048 and a border around them") {
    std::uint64_t wrong = 0;
    for (int size = 1; size <= 2048; ++size) {
        for (int x = -size / 2 - 16; x < size + size / 2 + 16; ++x)
            wrong += CenterBits(x, size) != DivideBits(x, size) ? 1u : 0u;
    }
    CHECK(wrong == 0);
}

TEST_CASE("texel centres equal IEEE division: large sizes, texels to +-2^22") {
    Random random;
    std::uint64_t wrong = 0;
    for (int i = 0; i < 2'000'000; ++i) {
        const int size = 1 + static_cast<int>(random.Next() >> (12 + random.Next() % 10));
        const int x = static_cast<int>(random.Next() >> 9) - (1 << 22);
        wrong += CenterBits(x, size) != DivideBits(x, size) ? 1u : 0u;
        const int inside = static_cast<int>(random.Next() % static_cast<std::uint32_t>(size));
        wrong += CenterBits(inside, size) != DivideBits(inside, size) ? 1u : 0u;
    }
    for (int size : {1, 2, 3, 16383, 16384, 65535, 1048573, 1048575, 1048576}) {
        for (int x : {-(1 << 22), -(1 << 22) + 1, -1, 0, 1, size - 1, (1 << 22) - 1})
            wrong += CenterBits(x, size) != DivideBits(x, size) ? 1u : 0u;
    }
    CHECK(wrong == 0);
    CHECK(CenterBits(INT32_MAX, 5) == DivideBits((1 << 22) - 1, 5));
    CHECK(CenterBits(INT32_MIN, 5) == DivideBits(-(1 << 22), 5));
}

TEST_CASE("the quotient survives a division that is wrong by up to 4 units") {
    // Vulkan allows 2.5 ulp; ulp is 2^-23 for quotients in [1, 2) and half of that below.
    Random random;
    std::uint64_t wrong = 0;
    for (int i = 0; i < 300'000; ++i) {
        const std::uint32_t d = 0x800000u | (random.Next() >> 9);
        std::uint32_t n = 0x800000u | (random.Next() >> 9);
        n = n < d ? 2 * n : n;
        const std::uint64_t scaled = std::uint64_t{n} << 23;
        std::uint64_t expected = scaled / d;
        const std::uint64_t twice = 2 * (scaled % d);
        expected += twice > d || (twice == d && expected % 2 == 1) ? 1u : 0u;
        for (int units = -4; units <= 4; ++units) {
            const double estimate = static_cast<double>(n) / d + units / 8388608.0;
            wrong += shader::NtcRoundQuotient(n, d, static_cast<float>(estimate)) != expected ? 1u : 0u;
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("taps are clamped to the slice, fractions are not") {
    // 5 latent pixels over 10 texels: texel 0 lies at latent position 0.05 * 5 - 0.5 = -0.25.
    const shader::NtcAxisTaps first = shader::NtcGetAxisTaps(shader::NtcTexelCenter(0, 10), 5, 0, 5);
    CHECK(first.first == 0);
    CHECK(first.second == 0);
    CHECK(first.fraction == 0.75f);
    const shader::NtcAxisTaps last = shader::NtcGetAxisTaps(shader::NtcTexelCenter(9, 10), 5, 0, 5);
    CHECK(last.first == 4);
    CHECK(last.second == 4);
    CHECK(last.fraction == 0.25f);
    const shader::NtcAxisTaps slice = shader::NtcGetAxisTaps(shader::NtcTexelCenter(5, 10), 5, 1, 2);
    CHECK(slice.first == 1); // position 2.25 of the image, 1.25 of the slice that starts at 1
    CHECK(slice.second == 1);
    CHECK(slice.fraction == 0.25f);
    // Far outside the image, beyond the range of int.
    const shader::NtcAxisTaps far =
        shader::NtcGetAxisTaps(shader::NtcTexelCenter(1 << 22, 1), 65535, 0, 65535);
    CHECK(far.first == 65534);
    CHECK(far.second == 65534);
    const shader::NtcAxisTaps before =
        shader::NtcGetAxisTaps(shader::NtcTexelCenter(-(1 << 22), 1), 65535, 0, 65535);
    CHECK(before.first == 0);
    CHECK(before.second == 0);
}
