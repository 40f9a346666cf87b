// SPDX-License-Identifier: MIT
#include "SourceTree.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

namespace openntc_tests {

namespace fs = std::filesystem;

namespace {

const fs::path kRoot = OPENNTC_SOURCE_DIR;

std::string ReadText(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string Trim(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" `");
    if (begin == std::string_view::npos)
        return {};
    return std::string(text.substr(begin, text.find_last_not_of(" `") - begin + 1));
}

std::vector<std::string> Split(std::string_view text, char separator) {
    std::vector<std::string> parts;
    std::size_t at = 0;
    for (std::size_t end = text.find(separator); end != std::string_view::npos;
         end = text.find(separator, at)) {
        parts.emplace_back(text.substr(at, end - at));
        at = end + 1;
    }
    parts.emplace_back(text.substr(at));
    return parts;
}

} // namespace

std::vector<SourceFile> ReadSources(const std::vector<std::string>& folders,
                                    const std::vector<std::string>& endings) {
    std::vector<SourceFile> files;
    for (const std::string& folder : folders) {
        for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
            const std::string path = entry.path().lexically_relative(kRoot).generic_string();
            const auto hasEnding = [&](const std::string& ending) { return path.ends_with(ending); };
            if (!entry.is_regular_file() || path.find("/build/") != std::string::npos ||
                std::none_of(endings.begin(), endings.end(), hasEnding))
                continue;
            std::string text = ReadText(entry.path());
            std::vector<std::string> lines = Split(text, '\n');
            if (!lines.empty() && lines.back().empty()) // behind the last line break
                lines.pop_back();
            files.push_back({path, std::move(text), std::move(lines)});
        }
    }
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return files;
}

std::string GetCode(const std::string& text) {
    std::string code = text;
    enum class Part { Code, Line, Block, String, Character, Directive } part = Part::Code;
    bool lineHasCode = false;
    for (std::size_t i = 0; i < code.size(); ++i) {
        const char c = code[i], next = i + 1 < code.size() ? code[i + 1] : '\0';
        if (c == '\n') {
            const bool continues = part == Part::Directive && i > 0 && text[i - 1] == '\\';
            if (part != Part::Block && !continues)
                part = Part::Code;
            lineHasCode = false;
            continue;
        }
        switch (part) {
        case Part::Code:
            if (c == '/' && next == '/')
                part = Part::Line;
            else if (c == '/' && next == '*')
                part = Part::Block;
            else if (c == '#' && !lineHasCode)
                part = Part::Directive;
            else if (c == '"')
                part = Part::String;
            else if (c == '\'' && (i == 0 || !std::isalnum(static_cast<unsigned char>(code[i - 1]))))
                part = Part::Character;
            lineHasCode = lineHasCode || c != ' ';
            if (part == Part::Code)
                continue;
            break;
        case Part::Block:
            if (c == '*' && next == '/') {
                code[i + 1] = ' ';
                ++i;
                part = Part::Code;
            }
            break;
        case Part::String:
        case Part::Character:
            if (c == '\\' && next != '\0' && next != '\n')
                code[i++] = ' ';
            else if (c == (part == Part::String ? '"' : '\''))
                part = Part::Code;
            break;
        case Part::Line:
        case Part::Directive:
            break;
        }
        code[i] = ' ';
    }
    return code;
}

std::vector<std::string> GetIncludes(const SourceFile& file) {
    std::vector<std::string> includes;
    for (const std::string& line : file.lines) {
        if (!line.starts_with("#include "))
            continue;
        const std::size_t begin = line.find_first_of("\"<");
        const std::size_t end = begin == std::string::npos ? begin : line.find_first_of("\">", begin + 1);
        if (end != std::string::npos)
            includes.push_back(line.substr(begin + 1, end - begin - 1));
    }
    return includes;
}

std::string ResolveInclude(const SourceFile& file, const std::string& include) {
    const fs::path beside = fs::path(file.path).parent_path();
    for (const fs::path& folder : {beside, fs::path("include"), fs::path("shaders"), fs::path("examples"),
                                   fs::path("tests"), fs::path(".")}) {
        const fs::path candidate = (folder / include).lexically_normal();
        if (fs::is_regular_file(kRoot / candidate))
            return candidate.generic_string();
    }
    return {};
}

std::string GetRoom(const std::string& path) {
    if (path.starts_with("shaders/"))
        return "shaders";
    const std::string prefix = "include/openntc/";
    const std::size_t end = path.find('/', prefix.size());
    return path.starts_with(prefix) && end != std::string::npos
               ? path.substr(prefix.size(), end - prefix.size())
               : std::string();
}

std::map<std::string, std::vector<std::string>> ReadArchitectureTable() {
    std::map<std::string, std::vector<std::string>> direct;
    for (const std::string& line : Split(ReadText(kRoot / "docs/architecture.md"), '\n')) {
        const std::vector<std::string> cells = Split(line, '|');
        if (cells.size() != 5 || Trim(cells[1]).find("openntc") == std::string::npos ||
            cells[1].find('`') == std::string::npos)
            continue;
        const std::string folder = Trim(cells[1]);
        const std::string room = folder == "shaders/openntc" ? "shaders" : GetRoom(folder + "/");
        for (const std::string& part : Split(cells[3], ',')) {
            if (const std::string name = Trim(part); name != "–" && !name.empty())
                direct[room].push_back(name);
        }
        direct[room].push_back(room);
    }
    std::map<std::string, std::vector<std::string>> all;
    for (const auto& entry : direct) {
        std::set<std::string> reached = {entry.first};
        std::vector<std::string> open = {entry.first};
        while (!open.empty()) {
            const std::string room = open.back();
            open.pop_back();
            for (const std::string& next : direct[room]) {
                if (reached.insert(next).second && direct.contains(next))
                    open.push_back(next);
            }
        }
        all[entry.first].assign(reached.begin(), reached.end());
    }
    return all;
}

std::size_t CountCharacters(std::string_view line) {
    return static_cast<std::size_t>(
        std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

} // namespace openntc_tests
