// SPDX-License-Identifier: MIT
// Derivation of the bound. Both sides evaluate the same formula from the same stored value, so each is
// compared with the real function and the two errors add up. u = 2^-24 bounds the relative error of one
// correctly rounded binary32 operation, and of a decimal constant rounded to binary32. One ULP is at most 2u
// relative.
//
//   host    + - * / sqrt: u.   expf, powf: 1 ULP = 2u (what C libraries document).
//   Vulkan  + - *: u.   /: 2.5 ULP = 5u.   exp: (3 + 2|x|) ULP.   pow(x, y): inherited from exp2(y *
//   log2(x));
//           log2: 3 ULP, or 2^-21 absolute for x in [0.5, 2]; exp2: (3 + 2|x|) ULP.
//           (Vulkan specification, "Precision and Operation of SPIR-V Instructions".)
//
// sRGB, c <= 0.04045: c / 12.92: the constant and the division.
// sRGB above: r = (c + 0.055) / 1.055. c + 0.055: the constant counts by 0.055 / (c + 0.055), then the
// rounding; the
//   division adds its constant and its error. r^2.4 multiplies the relative error of r by 2.4; the rounded
//   exponent adds 2.4 u |ln r|; pow adds its own error.
// HLG, |h| < 0.5: 4 m m: multiplying by 4 is exact, so one rounding.
// HLG above: x = (m - c) / a has the absolute error (c u + |m - c| u) / a + |x| (u + division), which is the
// relative
//   error of exp(x) besides exp's own; adding b costs b u for the constant and u for the sum.
#include "Comparison.h"

#include <algorithm>

namespace openntc::conformance {

namespace {

constexpr double kUnit = 0x1p-24;

// Terms of second order (products of two of these errors) stay below a thousandth of the sum.
constexpr double kSecondOrder = 1.001;

double GetDivisionError(Arithmetic arithmetic) {
    return arithmetic == Arithmetic::Host ? kUnit : 5 * kUnit;
}

// Relative error of pow(x, 2.4f) itself, with the exponent's rounding.
double GetPowError(double x, Arithmetic arithmetic) {
    const double exponentError = 2.4 * kUnit * std::fabs(std::log(x));
    if (arithmetic == Arithmetic::Host)
        return 2 * kUnit + exponentError;
    const double logarithm = std::fabs(std::log2(x));
    const double logarithmError = x >= 0.5 && x <= 2 ? 0x1p-21 : 3 * 2 * kUnit * logarithm;
    const double argument = 2.4 * logarithm;
    const double argumentError = 2.4 * logarithmError + kUnit * argument; // and the rounding of y * log2(x)
    const double exp2Error = (3 + 2 * argument) * 2 * kUnit;
    return std::log(2.0) * argumentError + exp2Error + exponentError;
}

// Relative error of exp(x) itself.
double GetExpError(double x, Arithmetic arithmetic) {
    return arithmetic == Arithmetic::Host ? 2 * kUnit : (3 + 2 * std::fabs(x)) * 2 * kUnit;
}

// |evaluation - real function|.
double GetEvaluationError(ColorSpace colorSpace, double stored, Arithmetic arithmetic) {
    const double division = GetDivisionError(arithmetic);
    const double magnitude = std::fabs(stored);
    if (colorSpace == ColorSpace::sRGB) {
        if (stored <= 0.04045)
            return magnitude / 12.92 * (kUnit + division);
        const double sum = stored + 0.055;
        const double baseError = (0.055 / sum + 1) * kUnit + kUnit + division;
        const double base = sum / 1.055;
        return std::pow(base, 2.4) * (2.4 * baseError + GetPowError(base, arithmetic));
    }
    if (colorSpace == ColorSpace::HLG) {
        if (magnitude < 0.5)
            return 4 * magnitude * magnitude * kUnit;
        constexpr double a = 0.17883277;
        constexpr double b = 0.28466892;
        constexpr double c = 0.55991073;
        const double x = (magnitude - c) / a;
        const double argumentError =
            (c + std::fabs(magnitude - c)) * kUnit / a + std::fabs(x) * (kUnit + division);
        const double power = std::exp(x);
        return power * (argumentError + GetExpError(x, arithmetic)) + b * kUnit + (power + b) * kUnit;
    }
    return 0;
}

} // namespace

double GetLinearBound(ColorSpace colorSpace, float stored, Arithmetic arithmetic) {
    if (colorSpace == ColorSpace::Linear || !std::isfinite(stored))
        return 0;
    const double bound = GetEvaluationError(colorSpace, static_cast<double>(stored), Arithmetic::Host) +
                         GetEvaluationError(colorSpace, static_cast<double>(stored), arithmetic);
    // Results below the smallest normal number may be flushed or rounded to a multiple of the smallest
    // subnormal.
    return bound * kSecondOrder + static_cast<double>(std::numeric_limits<float>::min());
}

} // namespace openntc::conformance
