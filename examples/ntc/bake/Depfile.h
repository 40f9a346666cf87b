// SPDX-License-Identifier: MIT
// Rules for Make and ninja: what a file was made of.
#pragma once

#include <string>
#include <vector>

namespace openntc::tool {

struct DepfileRule {
    std::string target;               ///< relative to the folder of the plan
    std::vector<std::string> sources; ///< written as absolute paths
};

/// Throws CommandError(Failed).
void WriteDepfile(const std::string& path, const std::vector<DepfileRule>& rules);

} // namespace openntc::tool
