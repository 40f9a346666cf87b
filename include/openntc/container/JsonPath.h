// SPDX-License-Identifier: MIT
// Stability: internal
// Names of places in the JSON document for error messages: "latents[3].highResView".
#pragma once

#include <cstddef>
#include <cstdio>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

/// A text of bounded length that never allocates; what does not fit is cut.
class JsonPath {
public:
    void AddKey(std::string_view key) noexcept {
        if (length_ > 0)
            Add('.');
        for (const char c : key)
            Add(c);
    }
    void AddIndex(std::size_t index) noexcept {
        char digits[24];
        std::snprintf(digits, sizeof(digits), "[%zu]", index);
        for (const char* c = digits; *c != '\0'; ++c)
            Add(*c);
    }
    const char* GetText() const noexcept { return text_; }

private:
    void Add(char c) noexcept {
        if (length_ + 1 < sizeof(text_))
            text_[length_++] = c;
    }

    char text_[96] = {};
    std::size_t length_ = 0;
};

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
