// SPDX-License-Identifier: MIT
// Stability: internal
// Exact conversion of JSON numbers, which come as text: nothing is rounded on the way to an integer, and a
// real is rounded to binary64 and from there to binary32, as the format's own reader does.
#pragma once

#include "openntc/container/DecimalReal.h"

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <system_error>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

/// True if `text` (a JSON number) is an integer 0 … maximum without fraction and exponent.
inline bool ParseInteger(std::string_view text, std::uint64_t maximum, std::uint64_t& value) noexcept {
    if (text == "-0")
        text = "0";
    std::uint64_t sum = 0;
    for (const char c : text) {
        if (c < '0' || c > '9')
            return false;
        const auto digit = static_cast<std::uint64_t>(c - '0');
        if (sum > (maximum - digit) / 10)
            return false;
        sum = sum * 10 + digit;
    }
    value = sum;
    return !text.empty();
}

#if defined(__cpp_lib_to_chars)
/// True if a JSON number that does not fit a binary64 is too small for it rather than too large: the power of
/// ten of its first digit that is not zero is negative.
inline bool IsUnderflow(std::string_view text) noexcept {
    const std::size_t exponentAt = text.find_first_of("eE");
    const std::string_view mantissa = text.substr(0, exponentAt);
    std::int64_t exponent = 0;
    if (exponentAt != std::string_view::npos) {
        const bool negative = text[exponentAt + 1] == '-';
        for (const char c : text.substr(exponentAt + 1)) {
            if (c >= '0' && c <= '9' && exponent < (std::int64_t{1} << 40))
                exponent = exponent * 10 + (c - '0');
        }
        exponent = negative ? -exponent : exponent;
    }
    const std::size_t digit = mantissa.find_first_of("123456789");
    if (digit == std::string_view::npos)
        return true;
    std::size_t point = mantissa.find('.');
    if (point == std::string_view::npos)
        point = mantissa.size();
    exponent += static_cast<std::int64_t>(point) - static_cast<std::int64_t>(digit);
    return exponent < 0;
}

/// The nearest binary64, infinite or 0 beyond its range. False if `text` is no number.
inline bool ParseBinary64(std::string_view text, double& value) noexcept {
    const std::from_chars_result result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (result.ec == std::errc::result_out_of_range) {
        const double magnitude = IsUnderflow(text) ? 0.0 : std::numeric_limits<double>::infinity();
        value = text.front() == '-' ? -magnitude : magnitude;
        return true;
    }
    return result.ec == std::errc() && result.ptr == text.data() + text.size();
}
#else
/// The same without the standard library's help: libc++ before 20, mingw's of some configurations.
inline bool ParseBinary64(std::string_view text, double& value) noexcept {
    return ParseDecimalReal(text, value);
}
#endif

/// True if `text` (a JSON number) rounds to a finite binary32.
inline bool ParseReal(std::string_view text, float& value) noexcept {
    double wide = 0.0;
    if (!ParseBinary64(text, wide))
        return false;
    // Half a step above the largest binary32: from here on the value would round to infinity.
    constexpr double kOverflow = 3.4028235677973366e38;
    if (!(wide > -kOverflow && wide < kOverflow))
        return false;
    value = static_cast<float>(wide);
    return true;
}

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
