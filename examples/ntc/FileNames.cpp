// SPDX-License-Identifier: MIT
#include "FileNames.h"

#include "Text.h"

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace openntc::tool {

namespace {

constexpr std::size_t kMaxLength =
    100; // leaves room for suffixes within the 255 bytes of common file systems

constexpr std::uint32_t kInvalid = ~0u;

/// Takes one character of UTF-8 off `text`; kInvalid and one byte for what is not well-formed.
std::uint32_t TakeCharacter(std::string_view& text) {
    const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    const std::uint32_t first = at(0);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xC2 ? 0
                               : first < 0xE0 ? 2
                               : first < 0xF0 ? 3
                               : first < 0xF5 ? 4
                                              : 0;
    std::uint32_t character = length <= 1 ? first : first & (0xFFu >> (length + 1));
    bool valid = length > 0 && length <= text.size();
    for (std::size_t i = 1; valid && i < length; ++i) {
        valid = (at(i) & 0xC0u) == 0x80u;
        character = character << 6 | (at(i) & 0x3Fu);
    }
    constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
    valid = valid && character >= kSmallest[length] && character <= 0x10FFFF &&
            (character < 0xD800 || character > 0xDFFF);
    text.remove_prefix(valid ? length : 1);
    return valid ? character : kInvalid;
}

bool IsAsciiAllowed(std::uint32_t c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
}

// Unicode's blocks of controls, spaces, punctuation, symbols, formatting and private characters. What is left
// are letters, digits and marks.
constexpr struct {
    std::uint32_t first, last;
} kRefused[] = {{0x80, 0xA9},       {0xAB, 0xB4},       {0xB6, 0xB9},       {0xBB, 0xBF},
                {0xD7, 0xD7},       {0xF7, 0xF7},       {0x34F, 0x34F},     {0x61C, 0x61C},
                {0x115F, 0x1160},   {0x1680, 0x1680},   {0x17B4, 0x17B5},   {0x180B, 0x180F},
                {0x2000, 0x2BFF},   {0x2E00, 0x2E7F},   {0x3000, 0x3004},   {0x3008, 0x3020},
                {0x3164, 0x3164},   {0xD800, 0xF8FF},   {0xFE00, 0xFE1F},   {0xFE30, 0xFE6F},
                {0xFEFF, 0xFEFF},   {0xFF00, 0xFF0F},   {0xFF1A, 0xFF20},   {0xFF3B, 0xFF40},
                {0xFF5B, 0xFF65},   {0xFFA0, 0xFFA0},   {0xFFE0, 0xFFFF},   {0x1BCA0, 0x1BCA3},
                {0x1D000, 0x1D24F}, {0x1F000, 0x1FAFF}, {0xE0000, 0x10FFFF}};

bool IsAllowed(std::uint32_t c) {
    if (c < 0x80)
        return IsAsciiAllowed(c);
    if (c == kInvalid || (c & 0xFFFEu) == 0xFFFEu)
        return false;
    return std::none_of(std::begin(kRefused), std::end(kRefused),
                        [&](const auto& range) { return c >= range.first && c <= range.last; });
}

/// Windows opens a device for these, whatever follows the first dot.
bool IsDevice(const std::string& name) {
    const std::string stem = ToLower(name.substr(0, name.find('.')));
    static constexpr std::string_view kDevices[] = {"con", "prn", "aux", "nul"};
    if (std::find(std::begin(kDevices), std::end(kDevices), stem) != std::end(kDevices))
        return true;
    return stem.size() == 4 && (stem.compare(0, 3, "com") == 0 || stem.compare(0, 3, "lpt") == 0) &&
           stem[3] >= '0' && stem[3] <= '9';
}

std::string Sanitise(std::string_view name) {
    std::string result;
    bool inRun = false; // one '_' for a run of bytes that are no UTF-8
    while (!name.empty()) {
        const char* begin = name.data();
        const std::uint32_t character = TakeCharacter(name);
        const auto length = static_cast<std::size_t>(name.data() - begin);
        const bool allowed = IsAllowed(character);
        if (result.size() + (allowed ? length : 1) > kMaxLength)
            break;
        if (allowed)
            result.append(begin, length);
        else if (character != kInvalid || !inRun)
            result += '_';
        inRun = character == kInvalid;
    }
    for (std::size_t i = 0; i < result.size() && result[i] == '.'; ++i)
        result[i] = '_';
    if (!result.empty() && result.back() == '.')
        result.back() = '_';
    if (IsDevice(result))
        result.insert(std::min(result.find('.'), result.size()), 1, '_');
    return result.empty() ? "texture" : result;
}

/// Letters of Latin-1 (from U+C0) and Latin Extended-A (from U+100) without their accents, in small.
constexpr std::string_view kLatin1 = "aaaaaaaceeeeiiiidnooooo*ouuuuytsaaaaaaaceeeeiiiidnooooo/ouuuuyty";
constexpr std::string_view kLatinExtended =
    "aaaaaaccccccccddddeeeeeeeeeegggggggghhhhiiiiiiiiiiiijjkkklllllll"
    "lllnnnnnnnnnoooooooorrrrrrssssssssttttttuuuuuuuuuuuuwwyyyzzzzzzs";
static_assert(kLatin1.size() == 64 && kLatinExtended.size() == 128);

/// Equal for names that some file system takes for one: case and accents are dropped, composed or not.
std::string MakeKey(std::string_view name) {
    std::string key;
    while (!name.empty()) {
        const char* begin = name.data();
        const std::uint32_t c = TakeCharacter(name);
        if (c < 0x80)
            key += ToLower(static_cast<char>(c));
        else if (c >= 0xC0 && c <= 0xFF)
            key += kLatin1[c - 0xC0];
        else if (c >= 0x100 && c <= 0x17F)
            key += kLatinExtended[c - 0x100];
        else if ((c >= 0x391 && c <= 0x3A9) || (c >= 0x410 && c <= 0x42F)) // capitals: Greek, Cyrillic
            key += std::to_string(c + 0x20); // so far stand they before their small letters
        else if (c >= 0x400 && c <= 0x40F)
            key += std::to_string(c + 0x50);
        else if ((c >= 0x391 && c <= 0x3C9) || (c >= 0x400 && c <= 0x45F))
            key += std::to_string(c);
        else if (c < 0x300 || c > 0x36F) // combining accents
            key.append(begin, static_cast<std::size_t>(name.data() - begin));
    }
    return key;
}

} // namespace

std::string FileNames::Add(std::string_view textureName) {
    const std::string base = Sanitise(textureName);
    std::string name = base;
    for (int copy = 2; !taken_.insert(MakeKey(name)).second; ++copy)
        name = base + "_" + std::to_string(copy);
    return name;
}

} // namespace openntc::tool
