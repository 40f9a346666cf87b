// SPDX-License-Identifier: MIT
// Stability: internal
// Decimal text to binary64 and back for standard libraries that have no from_chars (libc++ before 20) and no
// to_chars (before 14) of floating-point numbers: independent of the locale, without allocation or
// exceptions. Reading is correctly rounded for any number of digits.
//
// A number is digits * 10^exponent, an integer quotient A / B. A is shifted until the quotient has 53 bits
// (less for subnormal numbers), which long division gives one by one; the remainder rounds.
#pragma once

#include "openntc/core/FloatBits.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

/// A natural number of up to 4224 bits. 770 digits have 2558 bits, 10^1095 has 3638, and a quotient of 53
/// bits needs its dividend no longer than its divisor: everything below fits.
class BigNatural {
public:
    explicit BigNatural(std::uint32_t value) noexcept {
        if (value != 0)
            words_[size_++] = value;
    }

    void MultiplyAdd(std::uint32_t factor, std::uint32_t addend) noexcept {
        std::uint64_t carry = addend;
        for (std::size_t i = 0; i < size_; ++i) {
            carry += std::uint64_t{words_[i]} * factor;
            words_[i] = static_cast<std::uint32_t>(carry);
            carry >>= 32;
        }
        if (carry != 0)
            words_[size_++] = static_cast<std::uint32_t>(carry);
    }

    void MultiplyByPowerOfTen(std::int64_t exponent) noexcept {
        for (; exponent >= 9; exponent -= 9)
            MultiplyAdd(1000000000u, 0);
        for (; exponent > 0; --exponent)
            MultiplyAdd(10, 0);
    }

    void ShiftLeft(std::size_t bits) noexcept {
        if (size_ == 0)
            return;
        MultiplyAdd(1u << (bits % 32), 0);
        const std::size_t words = bits / 32;
        for (std::size_t i = size_; words != 0 && i > 0; --i)
            words_[i - 1 + words] = words_[i - 1];
        for (std::size_t i = 0; i < words; ++i)
            words_[i] = 0;
        size_ += words;
    }

    int Compare(const BigNatural& other) const noexcept {
        if (size_ != other.size_)
            return size_ < other.size_ ? -1 : 1;
        for (std::size_t i = size_; i > 0; --i) {
            if (words_[i - 1] != other.words_[i - 1])
                return words_[i - 1] < other.words_[i - 1] ? -1 : 1;
        }
        return 0;
    }

    /// Subtracts a number that is not larger.
    void Subtract(const BigNatural& other) noexcept {
        std::uint64_t borrow = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            const std::uint64_t subtrahend = borrow + (i < other.size_ ? other.words_[i] : 0);
            borrow = words_[i] < subtrahend ? 1 : 0;
            words_[i] = static_cast<std::uint32_t>(words_[i] - subtrahend);
        }
        while (size_ > 0 && words_[size_ - 1] == 0)
            --size_;
    }

    int GetBits() const noexcept {
        if (size_ == 0)
            return 0;
        int bits = static_cast<int>(32 * (size_ - 1));
        for (std::uint32_t top = words_[size_ - 1]; top != 0; top >>= 1)
            ++bits;
        return bits;
    }

private:
    std::array<std::uint32_t, 132> words_{}; // lowest first
    std::size_t size_ = 0;
};

/// digits * 10^exponent, `digits` not 0, rounded to nearest, ties to even: the bits of a positive binary64.
inline std::uint64_t RoundQuotient(const BigNatural& digits, std::int64_t exponent) noexcept {
    BigNatural dividend = digits;
    BigNatural divisor(1);
    if (exponent >= 0)
        dividend.MultiplyByPowerOfTen(exponent);
    else
        divisor.MultiplyByPowerOfTen(-exponent);

    // 2^power <= dividend / divisor < 2^(power + 1) once both are aligned.
    int power = dividend.GetBits() - divisor.GetBits();
    if (power >= 0)
        divisor.ShiftLeft(static_cast<std::size_t>(power));
    else
        dividend.ShiftLeft(static_cast<std::size_t>(-power));
    if (dividend.Compare(divisor) < 0) {
        --power;
        dividend.ShiftLeft(1);
    }
    if (power > 1023)
        return 0x7FF0000000000000u;
    // The last bit of a normal number is 52 below its first; of a subnormal number it is 2^-1074.
    const int bits = power >= -1022 ? 53 : 53 - (-1022 - power);
    std::uint64_t quotient = 0;
    if (bits < 0)
        return 0;
    for (int i = 0; i < bits; ++i) {
        quotient <<= 1;
        if (dividend.Compare(divisor) >= 0) {
            dividend.Subtract(divisor);
            quotient |= 1;
        }
        dividend.ShiftLeft(1);
    }
    // The next bit is dividend >= divisor, and what is behind it decides ties.
    const int half = dividend.Compare(divisor);
    if (half > 0 || (half == 0 && (quotient & 1) != 0))
        ++quotient; // may carry into the exponent below, where it belongs
    if (power < -1022)
        return quotient;
    return quotient + (static_cast<std::uint64_t>(power + 1022) << 52);
}

/// What a JSON number is, rounded to nearest, ties to even: too large is infinite, too small is 0 with its
/// sign. False if `text` is no such number.
inline bool ParseDecimalReal(std::string_view text, double& value) noexcept {
    // Halves of two neighbouring binary64 have up to 767 digits: of more, it only matters that something
    // follows.
    constexpr int kMaximumDigits = 769;
    // Far outside every binary64, far inside an int64, also when added to the number of digits of any text.
    constexpr std::int64_t kMaximumExponent = std::int64_t{1} << 40;

    std::size_t at = 0;
    const auto isDigit = [&] { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
    const bool isNegative = at < text.size() && text[at] == '-';
    if (isNegative)
        ++at;

    BigNatural digits(0);
    int count = 0;             // of digits in `digits`
    std::int64_t exponent = 0; // of the last of them
    bool isMore = false;       // something behind them is not 0
    bool isAny = false;
    bool isFraction = false;
    for (; isDigit() || (at < text.size() && text[at] == '.' && !isFraction); ++at) {
        if (text[at] == '.') {
            isFraction = true;
            continue;
        }
        isAny = true;
        const auto digit = static_cast<std::uint32_t>(text[at] - '0');
        if (count < kMaximumDigits) {
            if (count > 0 || digit != 0) {
                digits.MultiplyAdd(10, digit);
                ++count;
            }
            exponent -= isFraction ? 1 : 0;
        } else {
            isMore = isMore || digit != 0;
            exponent += isFraction ? 0 : 1;
        }
    }
    if (!isAny)
        return false;
    if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
        ++at;
        const bool isExponentNegative = at < text.size() && text[at] == '-';
        if (at < text.size() && (text[at] == '-' || text[at] == '+'))
            ++at;
        if (!isDigit())
            return false;
        std::int64_t written = 0;
        for (; isDigit(); ++at) {
            if (written < kMaximumExponent)
                written = written * 10 + (text[at] - '0');
        }
        exponent += isExponentNegative ? -written : written;
    }
    if (at != text.size())
        return false;
    if (isMore) {
        digits.MultiplyAdd(10, 1);
        ++count;
        --exponent;
    }

    // 10^(first - 1) <= number < 10^first
    const std::int64_t first = exponent + count;
    std::uint64_t bits = 0;
    if (count > 0 && first > 309)
        bits = 0x7FF0000000000000u;
    else if (count > 0 && first > -324)
        bits = RoundQuotient(digits, exponent);
    value = BitCast<double>(bits | (isNegative ? 0x8000000000000000u : 0u));
    return true;
}

/// Writes [-]d[.ddd]e±xx with the fewest digits that are read as `value` (finite), and returns the end. The
/// point is that of the locale.
inline const char* FormatShortest(char (&text)[40], double value) noexcept {
    int written = 0;
    for (int decimals = 0; decimals <= 16; ++decimals) {
        written = std::snprintf(text, sizeof(text), "%.*e", decimals, value);
        if (std::strtod(text, nullptr) == value)
            break;
    }
    return text + written;
}

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
