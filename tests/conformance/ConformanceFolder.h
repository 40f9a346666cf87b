// SPDX-License-Identifier: MIT
// Finds the shared conformance vectors.
#pragma once

#include "support/Files.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace openntc_tests {

/// Names (without .ntc) of the sets of generation 3, sorted. Empty without the folder.
inline std::vector<std::string> ListGeneration3Sets() {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(GetConformanceFolder(), error)) {
        const std::string name = entry.path().stem().string();
        if (entry.path().extension() == ".ntc" && name.starts_with("v092"))
            names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
}

/// Names (without .ntc) of the sets of generation 1: those with expectations, sorted. Empty without the
/// folder.
inline std::vector<std::string> ListGeneration1Sets() {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(GetConformanceFolder(), error)) {
        const std::string name = entry.path().filename().string();
        constexpr std::string_view kSuffix = ".expect.json";
        if (name.size() > kSuffix.size() && name.ends_with(kSuffix))
            names.push_back(name.substr(0, name.size() - kSuffix.size()));
    }
    std::sort(names.begin(), names.end());
    return names;
}

} // namespace openntc_tests
