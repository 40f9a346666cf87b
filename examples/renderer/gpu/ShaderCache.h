// SPDX-License-Identifier: MIT
// Shaders of the renderer and passes of the library, compiled when the program runs: only the permutations that a scene
// calls for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::renderer {

class ShaderCache {
public:
    /// `sources`: folder of OpenNTC's source. `glslang`: a program for cooperative vectors, where the glslang that we are
    /// linked with does not know them; empty: one that is found (FindCooperativeVectorGlslang).
    explicit ShaderCache(std::filesystem::path sources, std::string glslang = {})
        : sources_(std::move(sources)), glslang_(std::move(glslang)) {}

    /// SPIR-V of a file of examples/renderer/shaders, or of shaders/openntc/passes. Throws CommandError(BadInput) if it
    /// is not there or does not compile. Stays while the cache is there.
    std::span<const std::uint32_t> Get(const std::string& file, const std::vector<std::string>& defines);

    /// Why nobody here compiles cooperative vectors; empty: they are compiled. Throws CommandError(BadInput) for a glslang that
    /// was named and does not know them.
    std::string WhyNoCooperativeVectors();

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
    /// The program that compiles cooperative vectors; empty: there is none.
    const std::string& FindGlslang();

    std::filesystem::path sources_;
    std::string glslang_;
    std::optional<std::string> vectorGlslang_; // looked for when it is first wanted
    std::map<std::string, Entry> entries_;
};

} // namespace openntc::renderer
