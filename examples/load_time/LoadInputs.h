// SPDX-License-Identifier: MIT
// Which texture sets are loaded.
#pragma once

#include <string>
#include <vector>

namespace openntc::load_time {

/// Texture sets of the arguments: files, folders (their .ntc files, by name), and lists that `ntc convert-gltf` writes
/// (materials.json: all sets of the model). Without arguments the sample materials. Throws tool::CommandError(BadInput).
std::vector<std::string> ListSets(const std::vector<std::string>& arguments);

} // namespace openntc::load_time
