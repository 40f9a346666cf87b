// SPDX-License-Identifier: MIT
// Shaders of the renderer and passes of the library, compiled when the program runs: only the permutations that a scene
// calls for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace openntc::renderer {

class ShaderCache {
public:
    /// `sources`: folder of OpenNTC's source.
    explicit ShaderCache(std::filesystem::path sources) : sources_(std::move(sources)) {}

    /// SPIR-V of a file of examples/renderer/shaders, or of shaders/openntc/passes. Throws CommandError(BadInput) if it
    /// is not there or does not compile. Stays while the cache is there.
    std::span<const std::uint32_t> Get(const std::string& file, const std::vector<std::string>& defines);

    struct Entry {
        std::string file;
        std::string defines;
        std::vector<std::uint32_t> words;
        double milliseconds = 0.0; ///< of compilation
    };
    /// By file and definitions.
    const std::map<std::string, Entry>& GetEntries() const { return entries_; }

private:
    std::filesystem::path FindSource(const std::string& file) const;

    std::filesystem::path sources_;
    std::map<std::string, Entry> entries_;
};

} // namespace openntc::renderer
