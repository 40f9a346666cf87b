// SPDX-License-Identifier: MIT
// Finds included files where glslangValidator does: beside the including file, beside those that include that one, then
// in the include directories, the last one first.
#pragma once

#include <glslang/Public/ShaderLang.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace openntc::shader_compiler {

class Includer final : public glslang::TShader::Includer {
public:
    Includer(const std::filesystem::path& source, const std::vector<std::filesystem::path>& directories)
        : source_(source), directories_(directories) {}

    IncludeResult* includeLocal(const char* name, const char* includer, std::size_t) override {
        std::string file = includer;
        for (std::size_t level = 0; level <= parents_.size() && !file.empty();
             ++level) { // guarded files may include in a ring
            if (IncludeResult* result = Open(std::filesystem::path(file).parent_path() / name, includer))
                return result;
            const auto parent = parents_.find(file);
            file = parent != parents_.end() ? parent->second : "";
        }
        if (IncludeResult* result = Open(source_.parent_path() / name, includer))
            return result;
        return includeSystem(name, includer, 0);
    }

    IncludeResult* includeSystem(const char* name, const char* includer, std::size_t) override {
        for (auto directory = directories_.rbegin(); directory != directories_.rend(); ++directory) {
            if (IncludeResult* result = Open(*directory / name, includer))
                return result;
        }
        return nullptr;
    }

    void releaseInclude(IncludeResult* result) override {
        if (result == nullptr)
            return;
        delete static_cast<std::string*>(result->userData);
        delete result;
    }

private:
    IncludeResult* Open(const std::filesystem::path& path, const char* includer) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored))
            return nullptr;
        std::ifstream stream(path, std::ios::binary);
        if (!stream)
            return nullptr;
        auto* text =
            new std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
        const std::string name = path.lexically_normal().string();
        parents_.emplace(name, includer);
        return new IncludeResult(name, text->data(), text->size(), text);
    }

    std::filesystem::path source_;
    const std::vector<std::filesystem::path>& directories_;
    std::map<std::string, std::string> parents_; // included file → the first that included it
};

} // namespace openntc::shader_compiler
