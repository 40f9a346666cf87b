// SPDX-License-Identifier: MIT
// Which images of a folder are one material: by what stands before the word that says what an image is.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// Images by material. T_Wall_D.png and T_Wall_N.png are `T_Wall`; images that are only such a word (BaseColor.png) and
/// those whose name ends in none are the folder's own material, the empty name. Words are those of GuessColor.
std::map<std::string, std::vector<std::string>> GroupImages(std::span<const std::filesystem::path> images);

} // namespace openntc::tool
