// SPDX-License-Identifier: MIT
// The project's own files as text, for tests of how they are written and of what includes what.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace openntc_tests {

struct SourceFile {
    std::string path; ///< from the project's root, with slashes
    std::string text;
    std::vector<std::string> lines;
};

/// Files below the given folders, sorted by path; build folders and data are left out.
std::vector<SourceFile> ReadSources(const std::vector<std::string>& folders,
                                    const std::vector<std::string>& endings);

/// The text with comments, strings and preprocessor lines blanked; line breaks stay.
std::string GetCode(const std::string& text);

/// What stands between the quotes or angle brackets of the #include lines.
std::vector<std::string> GetIncludes(const SourceFile& file);

/// The file that an #include line of `file` means, by the include paths of the product; empty if it is none of the tree.
std::string ResolveInclude(const SourceFile& file, const std::string& include);

/// include/openntc/core/X.h: "core"; shaders/…: "shaders"; include/openntc/openntc.h: "".
std::string GetRoom(const std::string& path);

/// Rooms of the table in docs/architecture.md with all that they may include, themselves and what those may include.
std::map<std::string, std::vector<std::string>> ReadArchitectureTable();

/// Characters, not bytes.
std::size_t CountCharacters(std::string_view line);

} // namespace openntc_tests
