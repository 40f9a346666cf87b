// SPDX-License-Identifier: MIT
// Numbers without the standard library's help (libc++ before 20) against std::from_chars and std::to_chars.
#include "openntc/container/DecimalReal.h"

#include "openntc/container/JsonNumber.h"

#include <doctest/doctest.h>

#include <charconv>
#include <clocale>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::container::detail;

namespace {

std::uint64_t Read(const std::string& text) {
    double value = 7.0;
    INFO(text);
    REQUIRE(ParseDecimalReal(text, value));
    return BitCast<std::uint64_t>(value);
}

/// The exact decimal expansion of mantissa * 2^exponent, mantissa below 2^63: digits and the power of ten behind
/// them. Schoolbook arithmetic on decimal digits, nothing of the reader's.
std::string WriteExactly(std::uint64_t mantissa, int exponent) {
    std::vector<int> digits; // lowest first
    for (; mantissa != 0; mantissa /= 10)
        digits.push_back(static_cast<int>(mantissa % 10));
    const int factor = exponent >= 0 ? 2 : 5; // 2^-n = 5^n 10^-n
    for (int i = 0; i < std::abs(exponent); ++i) {
        int carry = 0;
        for (int& digit : digits) {
            carry += digit * factor;
            digit = carry % 10;
            carry /= 10;
        }
        if (carry != 0)
            digits.push_back(carry);
    }
    std::string text;
    for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit)
        text.push_back(static_cast<char>('0' + *digit));
    return text + "e" + std::to_string(exponent >= 0 ? 0 : exponent);
}

/// The number half way between the binary64 of `bits` (finite, positive) and the next, in all its digits.
std::string HalfWayAbove(std::uint64_t bits) {
    const auto field = static_cast<int>(bits >> 52);
    const std::uint64_t fraction = bits & 0xFFFFFFFFFFFFFu;
    const std::uint64_t mantissa = field == 0 ? fraction : fraction | (std::uint64_t{1} << 52);
    return WriteExactly(2 * mantissa + 1, (field == 0 ? 1 : field) - 1075 - 1);
}

/// More and less than a number of HalfWayAbove's form, by as little as its digits and one more can say.
std::string Slightly(const std::string& exact, char digit) {
    const std::size_t e = exact.find('e');
    const int exponent = std::stoi(exact.substr(e + 1));
    std::string digits = exact.substr(0, e);
    if (digit == '9') { // one less in the last digit, and a 9 behind
        std::size_t last = digits.size() - 1;
        for (; digits[last] == '0'; --last)
            digits[last] = '9';
        --digits[last];
    }
    return digits + digit + "e" + std::to_string(exponent - 1);
}

} // namespace

TEST_CASE("decimal: half way between two numbers goes to the even one, a trace more or less does not") {
    std::vector<std::uint64_t> numbers = {
        0, // half of the smallest number of all
        1,
        2,
        0xFFFFFFFFFFFFE, // subnormal
        0xFFFFFFFFFFFFF, // the largest of them
        0x10000000000000,
        0x10000000000001,
        0x3FEFFFFFFFFFFFFF,
        0x3FF0000000000000,
        0x3FF0000000000001,
        0x433FFFFFFFFFFFFF,
        0x4340000000000000,
        0x7FEFFFFFFFFFFFFE,
        0x7FEFFFFFFFFFFFFF, // the largest: half a step above is infinite
    };
    std::mt19937_64 random(11);
    for (int i = 0; i < 300; ++i)
        numbers.push_back(random() % 0x7FEFFFFFFFFFFFFF);
    for (int i = 0; i < 100; ++i)
        numbers.push_back(random() >> 12); // subnormal
    for (const std::uint64_t bits : numbers) {
        const std::string exact = HalfWayAbove(bits);
        CHECK(Read(exact) == bits + (bits & 1));
        CHECK(Read(Slightly(exact, '1')) == bits + 1);
        CHECK(Read(Slightly(exact, '9')) == bits);
        // A trace so far behind that no buffer of digits holds it.
        const std::size_t e = exact.find('e');
        const int exponent = std::stoi(exact.substr(e + 1));
        const std::string far = exact.substr(0, e) + std::string(1200, '0');
        CHECK(Read(far + "1e" + std::to_string(exponent - 1201)) == bits + 1);
        CHECK(Read(far + "0e" + std::to_string(exponent - 1201)) == bits + (bits & 1));
        CHECK(Read("-" + exact) == ((bits + (bits & 1)) | 0x8000000000000000u));
    }
}

TEST_CASE("decimal: hard and extreme numbers") {
    CHECK(Read("0") == 0);
    CHECK(Read("-0.000e5") == 0x8000000000000000u);
    CHECK(Read("0." + std::string(5000, '0') + "1e5001") == BitCast<std::uint64_t>(1.0));
    CHECK(Read("1" + std::string(5000, '0') + "e-5000") == BitCast<std::uint64_t>(1.0));
    CHECK(Read("1e99999999999999999999999") == 0x7FF0000000000000u);
    CHECK(Read("-1e99999999999999999999999") == 0xFFF0000000000000u);
    CHECK(Read("1e-99999999999999999999999") == 0);
    CHECK(Read("0e99999999999999999999999") == 0);
    CHECK(Read("2.4703282292062327e-324") == 0);
    CHECK(Read("2.4703282292062328e-324") == 1);
    CHECK(Read("9007199254740993") == BitCast<std::uint64_t>(9007199254740992.0));
    CHECK(Read("2.2250738585072012e-308") == 0x0010000000000000u); // hung PHP and Java
    CHECK(Read("2.2250738585072011e-308") == 0x000FFFFFFFFFFFFFu);
    double value = 0.0;
    for (const char* text :
         {"", "-", ".", "e5", "1e", "1e+", "1x", "1.2.3", "--1", " 1", "1 ", "inf", "nan", "0x1"}) {
        INFO(text);
        CHECK_FALSE(ParseDecimalReal(text, value));
    }
}

#if defined(__cpp_lib_to_chars)
TEST_CASE("decimal: the same as std::from_chars for random numbers of every length") {
    std::mt19937_64 random(12);
    for (int i = 0; i < 20000; ++i) {
        char text[64];
        const double number = BitCast<double>(random());
        if (!std::isfinite(number))
            continue;
        std::to_chars_result end = std::to_chars(
            text, text + sizeof text, number, std::chars_format::scientific, static_cast<int>(random() % 25));
        const std::string_view view(text, static_cast<std::size_t>(end.ptr - text));
        double expected = 0.0, value = 1.0;
        REQUIRE(ParseBinary64(view, expected));
        REQUIRE(ParseDecimalReal(view, value));
        INFO(std::string(view));
        REQUIRE(BitCast<std::uint64_t>(value) == BitCast<std::uint64_t>(expected));
        // Plain notation too.
        const double plain = static_cast<double>(static_cast<std::int64_t>(random())) / 65536.0;
        end = std::to_chars(text, text + sizeof text, plain, std::chars_format::fixed);
        REQUIRE(ParseDecimalReal({text, static_cast<std::size_t>(end.ptr - text)}, value));
        REQUIRE(value == plain);
    }
}
#endif

TEST_CASE("decimal: shortest text, read again, in any locale") {
    const char* const before = std::setlocale(LC_NUMERIC, nullptr);
    const std::string saved = before != nullptr ? before : "C";
    bool hasComma = false;
    for (const char* name : {"C", "de_DE.UTF-8", "de_DE.utf8", "de_DE"}) {
        if (std::setlocale(LC_NUMERIC, name) == nullptr)
            continue;
        hasComma = hasComma || std::localeconv()->decimal_point[0] == ',';
        std::mt19937 random(13);
        for (int i = 0; i < 3000; ++i) {
            const float number = BitCast<float>(static_cast<std::uint32_t>(random()));
            if (!IsFinite(number))
                continue;
            char text[40];
            const char* const end = FormatShortest(text, static_cast<double>(number));
            std::string written(text, static_cast<std::size_t>(end - text));
            for (char& c : written)
                c = c == ',' ? '.' : c;
            double value = 0.0;
            REQUIRE(ParseDecimalReal(written, value));
            REQUIRE(value == static_cast<double>(number));
#if defined(__cpp_lib_to_chars)
            char shortest[40];
            const std::to_chars_result last =
                std::to_chars(shortest, shortest + sizeof shortest, static_cast<double>(number),
                              std::chars_format::scientific);
            CHECK(written == std::string(shortest, last.ptr));
#endif
        }
        float real = 0.0f;
        CHECK(ParseReal("1.5", real));
        CHECK(real == 1.5f);
        CHECK_FALSE(ParseReal("1,5", real));
    }
    std::setlocale(LC_NUMERIC, saved.c_str());
    if (!hasComma)
        MESSAGE("SKIP: no locale with a decimal comma (de_DE.UTF-8) on this machine");
}
