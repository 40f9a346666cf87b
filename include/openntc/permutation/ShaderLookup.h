// SPDX-License-Identifier: MIT
// Stability: stable
// Comparing the names of shader permutations, and saying which one is missing.
#pragma once

#include "openntc/core/Expected.h"

#include <cstddef>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// One compiled permutation: the source's file name (with ":ENTRY" behind it where the entry point is not
/// main) and its defines, "NAME=VALUE NAME=VALUE" in any order.
struct ShaderKey {
    std::string_view source;
    std::string_view defines;
};

/// Takes the next word off a list separated by spaces; empty at its end.
constexpr std::string_view TakeShaderWord(std::string_view& list) noexcept {
    while (!list.empty() && list.front() == ' ')
        list.remove_prefix(1);
    const std::size_t end = list.find(' ');
    const std::string_view word = list.substr(0, end);
    list.remove_prefix(word.size());
    return word;
}

/// How many words of `words` are not in `list`.
constexpr std::size_t CountMissingWords(std::string_view list, std::string_view words) noexcept {
    std::size_t missing = 0;
    for (std::string_view word = TakeShaderWord(words); !word.empty(); word = TakeShaderWord(words)) {
        bool found = false;
        std::string_view rest = list;
        for (std::string_view other = TakeShaderWord(rest); !other.empty() && !found;
             other = TakeShaderWord(rest))
            found = other == word;
        missing += found ? 0 : 1;
    }
    return missing;
}

/// Do two lists hold the same words, in any order?
constexpr bool HaveSameDefines(std::string_view a, std::string_view b) noexcept {
    return CountMissingWords(a, b) == 0 && CountMissingWords(b, a) == 0;
}

namespace detail {

inline int GetPrintLength(std::string_view text) noexcept {
    constexpr std::size_t kLongest = 200; // more than a message holds
    return static_cast<int>(text.size() < kLongest ? text.size() : kLongest);
}

/// Does a list of defines that had no compiler hold one of `defines`?
constexpr bool IsLeftOut(std::string_view leftOut, std::string_view defines) noexcept {
    for (std::string_view word = TakeShaderWord(leftOut); !word.empty(); word = TakeShaderWord(leftOut)) {
        if (CountMissingWords(defines, word) == 0)
            return true;
    }
    return false;
}

} // namespace detail

/// The error of a lookup: ShaderUnavailable, naming the permutation, why it was left out (`leftOut` lists the
/// defines that had no compiler) and the two nearest of the `count` permutations, whose keys `getKey(i)`
/// gives; it is called once for every i, in order.
template <typename GetKey>
Unexpected FailMissingShader(const ShaderKey& wanted, std::string_view leftOut, std::size_t count,
                             const GetKey& getKey) noexcept {
    const auto print = [](std::string_view text) { return detail::GetPrintLength(text); };
    if (detail::IsLeftOut(leftOut, wanted.defines))
        return Fail(Status::ShaderUnavailable,
                    "shader: %.*s %.*s: left out: cooperative vectors and matrices need GLSL and a glslang "
                    "that knows GL_NV_cooperative_vector",
                    print(wanted.source), wanted.source.data(), print(wanted.defines), wanted.defines.data());
    ShaderKey first{"", ""};
    ShaderKey nearest[2];
    std::size_t distances[2] = {~std::size_t{0}, ~std::size_t{0}};
    for (std::size_t i = 0; i < count; ++i) {
        const ShaderKey key = getKey(i);
        if (i == 0)
            first = key;
        if (key.source != wanted.source)
            continue;
        const std::size_t missing = CountMissingWords(key.defines, wanted.defines);
        const std::size_t surplus = CountMissingWords(wanted.defines, key.defines);
        const std::size_t distance = missing > surplus ? missing : surplus; // another value counts once
        if (distance < distances[0]) {
            nearest[1] = nearest[0];
            distances[1] = distances[0];
            nearest[0] = key;
            distances[0] = distance;
        } else if (distance < distances[1]) {
            nearest[1] = key;
            distances[1] = distance;
        }
    }
    if (nearest[0].source.empty()) {
        return Fail(Status::ShaderUnavailable,
                    "shader: %.*s: no such source among the %zu permutations compiled; there is %.*s",
                    print(wanted.source), wanted.source.data(), count, print(first.source),
                    first.source.data());
    }
    const bool two = !nearest[1].source.empty();
    return Fail(Status::ShaderUnavailable,
                "shader: %.*s %.*s: not among the %zu permutations compiled; nearest: %.*s%s%.*s",
                print(wanted.source), wanted.source.data(), print(wanted.defines), wanted.defines.data(),
                count, print(nearest[0].defines), nearest[0].defines.data(), two ? ", or " : "",
                print(nearest[1].defines), two ? nearest[1].defines.data() : "");
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
