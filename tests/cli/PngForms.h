// SPDX-License-Identifier: MIT
// One small PNG of every form that the format has, with the samples that a reader of stored values must give.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

namespace openntc_tests {

struct PngForm {
    const char* name;
    int colorType; ///< PNG's number: 0 gray, 2 RGB, 3 palette, 4 gray and alpha, 6 RGBA
    int bits;      ///< of a sample or index
    bool hasKey;   ///< tRNS: one transparent gray or colour, or alpha of the palette
    int channelsRead;
};

inline constexpr std::array<PngForm, 18> kPngForms = {{{"rgb8", 2, 8, false, 3},
                                                       {"gray1", 0, 1, false, 1},
                                                       {"gray2", 0, 2, false, 1},
                                                       {"gray4", 0, 4, false, 1},
                                                       {"gray8", 0, 8, false, 1},
                                                       {"gray16", 0, 16, false, 1},
                                                       {"gray8 key", 0, 8, true, 2},
                                                       {"gray16 key", 0, 16, true, 2},
                                                       {"rgb16", 2, 16, false, 3},
                                                       {"rgb8 key", 2, 8, true, 4},
                                                       {"rgb16 key", 2, 16, true, 4},
                                                       {"palette1", 3, 1, false, 3},
                                                       {"palette4", 3, 4, false, 3},
                                                       {"palette8", 3, 8, false, 3},
                                                       {"palette8 alpha", 3, 8, true, 4},
                                                       {"gray alpha 8", 4, 8, false, 2},
                                                       {"gray alpha 16", 4, 16, false, 2},
                                                       {"rgba8", 6, 8, false, 4}}};

inline constexpr int kPngFormWidth = 11, kPngFormHeight = 9; ///< Adam7's last passes are partial

/// Writes the form with a gamma of 1 and a text chunk.
void WritePngForm(const std::filesystem::path& path, const PngForm& form, bool interlaced);

/// What the file holds, as values 0 ... 1.
std::vector<float> GetPngFormSamples(const PngForm& form);

} // namespace openntc_tests
