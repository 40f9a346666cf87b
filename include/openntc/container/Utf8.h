// SPDX-License-Identifier: MIT
// Stability: internal
// Validation of UTF-8 (RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF).
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

/// True if `text` is well-formed UTF-8. Eight ASCII bytes are passed over at a time.
inline bool IsValidUtf8(std::string_view text) noexcept {
    const char* at = text.data();
    const char* const end = at + text.size();
    while (at != end) {
        std::uint64_t block = 0;
        while (end - at >= 8) {
            std::memcpy(&block, at, 8);
            if ((block & 0x8080808080808080u) != 0)
                break;
            at += 8;
        }
        while (at != end && static_cast<unsigned char>(*at) < 0x80)
            ++at;
        if (at == end)
            return true;
        const auto lead = static_cast<unsigned char>(*at);
        const int length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
        if (lead < 0xC2 || lead > 0xF4 || end - at < length)
            return false;
        const auto second = static_cast<unsigned char>(at[1]);
        const unsigned char low = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
        const unsigned char high = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
        if (second < low || second > high)
            return false;
        for (int i = 2; i < length; ++i) {
            if ((static_cast<unsigned char>(at[i]) & 0xC0u) != 0x80u)
                return false;
        }
        at += length;
    }
    return true;
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
