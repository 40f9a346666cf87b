// SPDX-License-Identifier: MIT
#include "bake/ImageGroups.h"

#include "encode/ColorGuess.h"

#include <algorithm>

namespace openntc::tool {

std::map<std::string, std::vector<std::string>> GroupImages(std::span<const std::filesystem::path> images) {
    std::map<std::string, std::vector<std::string>> groups;
    for (const std::filesystem::path& image : images)
        groups[GuessColor(image.stem().string()).base].push_back(image.string());
    for (auto& [name, paths] : groups)
        std::sort(paths.begin(), paths.end());
    return groups;
}

} // namespace openntc::tool
