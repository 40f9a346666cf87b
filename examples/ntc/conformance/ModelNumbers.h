// SPDX-License-Identifier: MIT
// Number formats of the independent model, by scaling and rounding doubles. Doubles hold products of two binary32 numbers
// exactly, and since 53 >= 2 * 24 + 2 a sum, product or quotient of binary32 numbers rounded to double and then to
// binary32 is rounded correctly.
#pragma once

#include <cstddef>
#include <cstdint>

namespace openntc::conformance {

double RoundToBinary32(double x);
double RoundToHalf(double x);     ///< ties to even; infinite from 65520 on
double RoundToE4M3(double x);     ///< saturates at 448
double WidenHalf(unsigned code);  ///< bits of a finite half
double WidenE4M3(unsigned code);  ///< 0x7F and 0xFF count as 480
double CutToHalf(double x);       ///< towards zero
double CutToE4M3(double x);       ///< towards zero, saturates at 448
double RoundAwayToE4M3(double x); ///< ties away from zero, saturates at 448

int ToSignedByte(std::int64_t value);
std::int32_t ToWrappedInt(std::int64_t value);

constexpr std::size_t Index(int value) {
    return static_cast<std::size_t>(value);
}

} // namespace openntc::conformance
