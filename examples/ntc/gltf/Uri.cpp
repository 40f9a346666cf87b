// SPDX-License-Identifier: MIT
#include "gltf/Uri.h"

#include "Output.h"
#include "Text.h"

#include <algorithm>
#include <cstdint>

namespace openntc::tool {

namespace {

int GetHexDigit(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

int GetBase64Digit(char c) {
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

bool DecodeBase64(std::string_view text, std::vector<std::byte>& bytes, std::string& error) {
    const std::string_view digits = text.substr(0, std::min(text.size(), text.find_last_not_of('=') + 1));
    if (text.size() - digits.size() > 2 || digits.size() % 4 == 1) {
        error =
            Format("base64: %zu characters, %zu of them padding", text.size(), text.size() - digits.size());
        return false;
    }
    bytes.reserve(digits.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        const int digit = GetBase64Digit(digits[i]);
        if (digit < 0) {
            error = Format("base64: character %zu: byte 0x%02x is no digit", i,
                           static_cast<unsigned>(static_cast<unsigned char>(digits[i])));
            return false;
        }
        bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xffffffu;
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes.push_back(static_cast<std::byte>(bits >> count & 0xffu));
        }
    }
    return true;
}

} // namespace

std::string UnescapeUri(std::string_view uri) {
    std::string text;
    text.reserve(uri.size());
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const int high = uri[i] == '%' && i + 2 < uri.size() ? GetHexDigit(uri[i + 1]) : -1;
        const int low = high >= 0 ? GetHexDigit(uri[i + 2]) : -1;
        if (low >= 0) {
            text += static_cast<char>(high * 16 + low);
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

bool IsDataUri(std::string_view uri) {
    return ToLower(uri.substr(0, 5)) == "data:";
}

std::optional<DataUri> ParseDataUri(std::string_view uri, std::string& error) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) {
        error = "data URI: no comma";
        return std::nullopt;
    }
    const std::string head = ToLower(uri.substr(5, comma - 5));
    constexpr std::string_view kBase64 = ";base64";
    if (head.size() < kBase64.size() ||
        head.compare(head.size() - kBase64.size(), kBase64.size(), kBase64) != 0) {
        error = "data URI: not base64";
        return std::nullopt;
    }
    DataUri data;
    data.mediaType = head.substr(0, head.find(';'));
    const std::string_view text = uri.substr(comma + 1);
    // Base64 is what makes a URI long: a copy is made only of those that need one.
    const bool decoded = text.find('%') == std::string_view::npos
                             ? DecodeBase64(text, data.bytes, error)
                             : DecodeBase64(UnescapeUri(text), data.bytes, error);
    if (!decoded)
        return std::nullopt;
    return data;
}

} // namespace openntc::tool
