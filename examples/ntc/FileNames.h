// SPDX-License-Identifier: MIT
// File names made from the names of textures, which come from a file and are hostile.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace openntc::tool {

/// Gives each texture of a set a file name (without extension) that is safe in any folder. Characters outside
/// [A-Za-z0-9._-] (path separators among them) and leading dots become '_', an empty name becomes "texture",
/// names are cut to 100 characters, and a name that was given before (ignoring case, for file systems that
/// do) gets "_2", "_3", ….
class FileNames {
public:
    std::string Add(std::string_view textureName);

private:
    std::set<std::string> taken_; // lower case
};

} // namespace openntc::tool
