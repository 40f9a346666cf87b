// SPDX-License-Identifier: MIT
#include "FileNames.h"

namespace openntc::tool {

namespace {

constexpr std::size_t kMaxLength =
    100; // leaves room for suffixes within the 255 bytes of common file systems

bool IsAllowed(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
}

std::string Sanitise(std::string_view name) {
    std::string result;
    bool insideCharacter = false; // one '_' for all bytes of a UTF-8 character
    for (const char c : name) {
        const bool continuation = (static_cast<unsigned char>(c) & 0xC0u) == 0x80u;
        if (continuation && insideCharacter)
            continue;
        insideCharacter = static_cast<unsigned char>(c) >= 0x80u;
        result += IsAllowed(c) ? c : '_';
        if (result.size() == kMaxLength)
            break;
    }
    for (std::size_t i = 0; i < result.size() && result[i] == '.'; ++i)
        result[i] = '_';
    return result.empty() ? "texture" : result;
}

std::string ToLower(std::string text) {
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z')
            c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

} // namespace

std::string FileNames::Add(std::string_view textureName) {
    const std::string base = Sanitise(textureName);
    std::string name = base;
    for (int copy = 2; !taken_.insert(ToLower(name)).second; ++copy)
        name = base + "_" + std::to_string(copy);
    return name;
}

} // namespace openntc::tool
