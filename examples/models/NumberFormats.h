// SPDX-License-Identifier: MIT
// binary32, binary16 and E4M3 by scaling and nearbyint in double, sharing no code with the library.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace openntc::models {

/// Nearest number with `precision` significant bits and no bits below 2^lowest, ties to even.
inline double RoundTo(double x, int precision, int lowest) {
    if (x == 0 || !std::isfinite(x))
        return x;
    int exponent = 0;
    std::frexp(x, &exponent);
    const int quantum = exponent - precision > lowest ? exponent - precision : lowest;
    return std::ldexp(std::nearbyint(std::ldexp(x, -quantum)), quantum);
}
inline double ToBinary32(double x) {
    return static_cast<double>(static_cast<float>(x));
}
inline double ToHalf(double x) {
    return RoundTo(x, 11, -24);
}
inline double ToE4M3(double x) {
    const double rounded = RoundTo(x, 4, -9);
    return rounded > 448 ? 448 : rounded < -448 ? -448 : rounded;
}
inline double E4M3Value(std::byte code) {
    const int bits = std::to_integer<int>(code);
    const int exponent = bits >> 3 & 15;
    const double magnitude =
        exponent == 0 ? std::ldexp(bits & 7, -9) : std::ldexp(8 + (bits & 7), exponent - 10);
    return (bits & 128) != 0 ? -magnitude : magnitude;
}
inline double HalfValue(std::uint16_t bits) {
    const int exponent = bits >> 10 & 31;
    const double magnitude =
        exponent == 0 ? std::ldexp(bits & 1023, -24) : std::ldexp(1024 + (bits & 1023), exponent - 25);
    return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

template <typename T>
T LoadAt(std::span<const std::byte> bytes, std::size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

} // namespace openntc::models
