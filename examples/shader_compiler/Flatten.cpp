// SPDX-License-Identifier: MIT
#include "shader_compiler/Flatten.h"

#include <algorithm>
#include <vector>

namespace openntc::shader_compiler {

namespace {

std::string_view TrimSpace(std::string_view line) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos)
        return {};
    return line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
}

} // namespace

std::string FlattenText(std::string_view preprocessed, std::string_view comment) {
    std::string_view version;
    std::vector<std::string_view> extensions;
    std::string code;
    while (!preprocessed.empty()) {
        const std::size_t end = std::min(preprocessed.find('\n'), preprocessed.size());
        const std::string_view line = TrimSpace(preprocessed.substr(0, end));
        preprocessed.remove_prefix(std::min(end + 1, preprocessed.size()));
        if (line.empty() || line.starts_with("#line"))
            continue;
        if (line.starts_with("#version")) {
            version = line;
        } else if (!line.starts_with("#extension")) {
            code.append(line).append("\n");
        } else if (line.find("GL_GOOGLE_include_directive") == std::string_view::npos &&
                   std::find(extensions.begin(), extensions.end(), line) == extensions.end()) {
            extensions.push_back(line);
        }
    }
    std::string text;
    if (!version.empty())
        text.append(version).append("\n");
    for (const std::string_view extension : extensions)
        text.append(extension).append("\n");
    return text.append("// ").append(comment).append("\n").append(code);
}

} // namespace openntc::shader_compiler
