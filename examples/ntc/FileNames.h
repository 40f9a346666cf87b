// SPDX-License-Identifier: MIT
// File names made from the names of textures and materials, which come from a file and are hostile.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace openntc::tool {

/// Gives each texture of a set a file name (without extension) that is safe in any folder of any system. Kept
/// are [A-Za-z0-9._-] and, as UTF-8, letters, digits and marks of other scripts. All else (path separators,
/// controls, direction overrides, invisible characters, bytes that are no UTF-8), leading dots and a trailing
/// dot become '_'. A device of Windows (CON, NUL, COM1, also before a dot) gets a '_', an empty name becomes
/// "texture", names are cut to 100 bytes. A name that differs from one given before at most in case or
/// accents, for file systems that do not tell them apart, gets "_2", "_3", ….
class FileNames {
public:
    std::string Add(std::string_view textureName);

private:
    std::set<std::string> taken_; // as MakeKey gives them
};

} // namespace openntc::tool
