// SPDX-License-Identifier: MIT
// Files of a bake beside its texture sets: folders, states, what killed runs left, and what is no longer wanted.
#pragma once

#include <filesystem>
#include <string>

namespace openntc::tool {

/// Makes the folder that `file` is to lie in. Throws CommandError(Failed).
void MakeFolderOf(const std::filesystem::path& file);

/// Path of a material's state, which holds for one content key only.
std::string GetBakeStatePath(const std::string& folder, const std::string& name, const std::string& key);

/// Removes what killed runs left half written of a material, and states of other keys.
void RemoveLeftovers(const std::string& folder, const std::string& name, const std::string& key);

/// Removes a material's file, record and states, and folders that are empty then.
void RemoveMaterial(const std::string& folder, const std::string& name);

/// Writes a file unless it is there with this text. Throws CommandError(Failed).
void WriteIfDifferent(const std::string& path, const std::string& text);

} // namespace openntc::tool
