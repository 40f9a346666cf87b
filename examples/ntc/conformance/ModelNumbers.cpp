// SPDX-License-Identifier: MIT
#include "ModelNumbers.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace openntc::conformance {

namespace {

// x in units of the last place of a format with `precision` significant bits and no bits below 2^lowest, rounded by
// `round`.
template <typename Round>
double RoundTo(double x, int precision, int lowest, Round round) {
    if (x == 0 || !std::isfinite(x))
        return x;
    const auto getPower = [](int exponent) {
        return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
    };
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52 & 0x7FF) - 1022;
    const int quantum = std::max(exponent - precision, lowest);
    return round(x * getPower(-quantum)) * getPower(quantum); // both products are exact
}

double ToEven(double x) {
    return std::nearbyint(x);
}
double ToZero(double x) {
    return std::trunc(x);
}
double AwayAtTies(double x) {
    return std::round(x);
}

} // namespace

double RoundToBinary32(double x) {
    return static_cast<double>(static_cast<float>(x));
}

double RoundToHalf(double x) {
    const double rounded = RoundTo(x, 11, -24, ToEven);
    return std::fabs(rounded) < 65520 ? rounded : std::isnan(x) ? x : std::copysign(HUGE_VAL, x);
}

double CutToHalf(double x) {
    const double cut = RoundTo(x, 11, -24, ToZero);
    return std::isinf(x) ? x : std::clamp(cut, -65504.0, 65504.0);
}

double RoundToE4M3(double x) {
    return std::clamp(RoundTo(x, 4, -9, ToEven), -448.0, 448.0);
}
double CutToE4M3(double x) {
    return std::clamp(RoundTo(x, 4, -9, ToZero), -448.0, 448.0);
}
double RoundAwayToE4M3(double x) {
    return std::clamp(RoundTo(x, 4, -9, AwayAtTies), -448.0, 448.0);
}

double WidenHalf(unsigned code) {
    const int exponent = static_cast<int>(code >> 10 & 31);
    const int mantissa = static_cast<int>(code & 1023);
    const double magnitude =
        exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    return (code & 0x8000) != 0 ? -magnitude : magnitude;
}

double WidenE4M3(unsigned code) {
    const int exponent = static_cast<int>(code >> 3 & 15);
    const int mantissa = static_cast<int>(code & 7);
    const double magnitude =
        exponent == 0 ? std::ldexp(mantissa, -9) : std::ldexp(8 + mantissa, exponent - 10);
    return (code & 128) != 0 ? -magnitude : magnitude;
}

int ToSignedByte(std::int64_t value) {
    const int low = static_cast<int>(value & 255);
    return low < 128 ? low : low - 256;
}

std::int32_t ToWrappedInt(std::int64_t value) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value)));
}

} // namespace openntc::conformance
