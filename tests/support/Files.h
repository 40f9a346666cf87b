// SPDX-License-Identifier: MIT
// Files that tests read.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace openntc_tests {

/// The folder of conformance vectors: $OPENNTC_SHARED_DIR, else the folder known at build time. May not exist.
inline std::filesystem::path GetConformanceFolder() {
    const char* shared = std::getenv("OPENNTC_SHARED_DIR");
    return std::filesystem::path(shared != nullptr ? shared : OPENNTC_DEFAULT_SHARED_DIR) / "conformance";
}

/// The bytes of a file; none when it cannot be read.
inline std::vector<std::byte> ReadBytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    std::vector<std::byte> bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

} // namespace openntc_tests
