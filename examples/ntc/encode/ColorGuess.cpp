// SPDX-License-Identifier: MIT
#include "encode/ColorGuess.h"

#include "Text.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace openntc::tool {

namespace {

struct KnownWord {
    std::string_view word; ///< lower case, no separators
    ColorMeaning meaning;
};

constexpr ColorMeaning kColor = ColorMeaning::Color, kData = ColorMeaning::Data;

// Whole suffixes. One and two letters are the suffixes of Unreal projects (T_Rock_D); words are those of
// Substance's presets for Unreal and Unity, of O3DE and of common practice.
constexpr KnownWord kSuffixes[] = {
    {"d", kColor},
    {"diff", kColor},
    {"diffuse", kColor},
    {"bc", kColor},
    {"basecolor", kColor},
    {"basecolour", kColor},
    {"basemap", kColor},
    {"c", kColor},
    {"col", kColor},
    {"color", kColor},
    {"colour", kColor},
    {"alb", kColor},
    {"albedo", kColor},
    {"albedom", kColor},
    {"albedotransparency", kColor},
    {"maintex", kColor},
    {"e", kColor},
    {"emi", kColor},
    {"emissive", kColor},
    {"emission", kColor},
    {"s", kColor},
    {"spec", kColor},
    {"specular", kColor},
    {"specularcolor", kColor},
    {"specularsmoothness", kColor},
    {"specularglossiness", kColor},
    {"n", kData},
    {"nm", kData},
    {"nrm", kData},
    {"norm", kData},
    {"normal", kData},
    {"normalgl", kData},
    {"normaldx", kData},
    {"normalopengl", kData},
    {"normaldirectx", kData},
    {"b", kData},
    {"bump", kData},
    {"h", kData},
    {"hm", kData},
    {"height", kData},
    {"dp", kData},
    {"disp", kData},
    {"displ", kData},
    {"displacement", kData},
    {"r", kData},
    {"rough", kData},
    {"roughness", kData},
    {"smoothness", kData},
    {"gloss", kData},
    {"glossiness", kData},
    {"m", kData},
    {"mt", kData},
    {"mtl", kData},
    {"metal", kData},
    {"metallic", kData},
    {"metalness", kData},
    {"metalsmooth", kData},
    {"metallicsmoothness", kData},
    {"metallicroughness", kData},
    {"metallicgloss", kData},
    {"o", kData},
    {"ao", kData},
    {"occ", kData},
    {"occlusion", kData},
    {"ambientocclusion", kData},
    {"ambient", kData},
    {"orm", kData},
    {"arm", kData},
    {"mra", kData},
    {"rma", kData},
    {"mrao", kData},
    {"rmao", kData},
    {"occlusionroughnessmetallic", kData},
    {"mask", kData},
    {"masks", kData},
    {"maskmap", kData},
    {"a", kData},
    {"alpha", kData},
    {"opacity", kData},
    {"transparency", kData},
    {"transmission", kData},
    {"t", kData},
    {"thickness", kData},
    {"f", kData},
    {"flow", kData},
    {"flowmap", kData},
};

// Anywhere in a name.
constexpr KnownWord kInside[] = {
    {"basecolor", kColor}, {"albedo", kColor}, {"diffuse", kColor}, {"emissi", kColor}};

bool IsDigit(char c) {
    return c >= '0' && c <= '9';
}
bool IsSeparator(char c) {
    return c == '_' || c == '-' || c == '.' || c == ' ';
}
bool IsCapital(char c) {
    return c >= 'A' && c <= 'Z';
}

struct Word {
    std::string text; ///< lower case
    std::size_t begin = 0;
};

/// Words of a name: between separators and digits, and at capitals that follow a small letter.
std::vector<Word> SplitWords(std::string_view name) {
    std::vector<Word> words;
    bool inside = false;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const char c = name[i];
        if (IsSeparator(c) || IsDigit(c)) {
            inside = false;
            continue;
        }
        const bool capital = i > 0 && IsCapital(c) && !IsCapital(name[i - 1]);
        if (!inside || capital)
            words.push_back({{}, i});
        words.back().text += ToLower(c);
        inside = true;
    }
    return words;
}

/// How a name is cut after its meaning: variants (T_Bob_D_01, wall_albedo_2k).
bool IsVariant(const std::string& word) {
    static constexpr std::string_view kVariants[] = {"k", "v", "px", "gl", "dx", "lod", "udim", "x"};
    return std::find(std::begin(kVariants), std::end(kVariants), word) != std::end(kVariants);
}

const KnownWord* FindSuffix(std::string_view text) {
    const auto* found = std::find_if(std::begin(kSuffixes), std::end(kSuffixes),
                                     [&](const KnownWord& known) { return known.word == text; });
    return found == std::end(kSuffixes) ? nullptr : found;
}

} // namespace

ColorGuess GuessColor(std::string_view name) {
    std::vector<Word> words = SplitWords(name);
    while (words.size() > 1 && IsVariant(words.back().text))
        words.pop_back();
    // The longest suffix of up to three words: "Base_Color" before "Color", "MetallicSmoothness" before
    // "Smoothness". A letter or two mean something only behind other words, not as a whole name.
    for (std::size_t count = std::min<std::size_t>(words.size(), 3); count > 0; --count) {
        std::string text;
        for (std::size_t i = words.size() - count; i < words.size(); ++i)
            text += words[i].text;
        const Word& first = words[words.size() - count];
        if (text.size() <= 2 && (first.begin == 0 || !IsSeparator(name[first.begin - 1])))
            continue;
        if (const KnownWord* known = FindSuffix(text)) {
            std::size_t begin = first.begin;
            if (begin > 0 && IsSeparator(name[begin - 1]))
                --begin;
            const std::size_t end = words.back().begin + words.back().text.size();
            ColorGuess guess{known->meaning, "by name: " + std::string(name.substr(begin, end - begin))};
            if (begin > 0)
                guess.base = std::string(name.substr(0, begin)) + std::string(name.substr(end));
            return guess;
        }
    }
    std::string all;
    for (const Word& word : words)
        all += word.text;
    for (const KnownWord& known : kInside) {
        if (all.find(known.word) != std::string::npos)
            return {known.meaning, "by name: " + std::string(known.word)};
    }
    return {ColorMeaning::Unknown, "no known name"};
}

} // namespace openntc::tool
