// SPDX-License-Identifier: MIT
// EffectTexels.comp as its tests use it.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// Its push constants.
struct EffectPush {
    std::int32_t left, top, width, height, mipLevel;
    std::uint32_t convertToLinear, latentsOffset, weightsOffset;
};

/// The SPIR-V of one permutation in a table that openntc_add_shaders() made.
template <typename Find>
std::span<const std::uint32_t> FindEffectShader(Find find, std::string_view defines) {
    const auto words = find("EffectTexels.comp", defines);
    REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
    return *words;
}
