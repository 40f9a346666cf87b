// SPDX-License-Identifier: MIT
// Is an image colour (sRGB) or data (linear)? What its name says, by the conventions of engines and tools.
#pragma once

#include <string>
#include <string_view>

namespace openntc::tool {

enum class ColorMeaning {
    Unknown,
    Color, ///< sRGB when its bits are integers
    Data,  ///< linear
};

struct ColorGuess {
    ColorMeaning meaning = ColorMeaning::Unknown;
    std::string reason; ///< "by name: _BaseColor", or "no known name"
    /// The name without the word that was known at its end: "T_Wall" of "T_Wall_D", "T_Wall_01" of "T_Wall_D_01". Empty
    /// where nothing stands before that word, or none was known.
    std::string base = {};
};

/// By the last word of the name that is known ("T_Wall_D", "wallBaseColor", "wall-normal_01": words end at
/// separators, digits and capitals), then by a long word anywhere in it. docs/manifest.md has the table and
/// where it is from.
ColorGuess GuessColor(std::string_view name);

} // namespace openntc::tool
