// SPDX-License-Identifier: MIT
#include "bake/Depfile.h"

#include "bake/BakeFiles.h"
#include "bake/MaterialTree.h"
#include "encode/StateFile.h"

namespace openntc::tool {

namespace {

std::string Escape(const std::string& path) {
    std::string text;
    for (const char c : path) {
        if (c == ' ' || c == '#' || c == '\\')
            text += '\\';
        text += c == '$' ? std::string("$$") : std::string(1, c);
    }
    return text;
}

} // namespace

void WriteDepfile(const std::string& path, const std::vector<DepfileRule>& rules) {
    std::string text;
    for (const DepfileRule& rule : rules) {
        text += Escape(rule.target) + ":";
        for (const std::string& source : rule.sources)
            text += " \\\n  " + Escape(GetAbsolutePath(source));
        text += "\n";
    }
    MakeFolderOf(path);
    WriteWholeFile(path, {std::as_bytes(std::span(text))});
}

} // namespace openntc::tool
