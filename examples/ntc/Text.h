// SPDX-License-Identifier: MIT
// Text of the user's, whatever the locale.
#pragma once

#include <string>
#include <string_view>

namespace openntc::tool {

/// ASCII letters in lower case; other bytes stay.
constexpr char ToLower(char c) noexcept {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
inline std::string ToLower(std::string_view text) {
    std::string lower(text);
    for (char& c : lower)
        c = ToLower(c);
    return lower;
}

} // namespace openntc::tool
