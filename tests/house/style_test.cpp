// SPDX-License-Identifier: MIT
// How files are written: licence, widths, lengths, numbers of parameters, names that macros of other people hide.
#include "SourceTree.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <string>

using namespace openntc_tests;

namespace {

const std::vector<std::string> kAllFolders = {"include", "shaders", "examples", "tests", "cmake", "docs"};
const std::vector<std::string> kProduct = {"include", "shaders"};

/// Product files of more lines than kMostLines, with the reason.
struct LongFile {
    const char* path;
    std::size_t mostLines;
    const char* reason;
};
constexpr std::size_t kMostLines = 400;
constexpr LongFile kLongFiles[] = {
    {"include/openntc/encode/detail/AmxKernel.h", 520,
     "one kernel: forward and backward pass share the arrangement of their tiles"},
    {"include/openntc/encode/detail/Trainer.h", 480,
     "one class: the state of training, saved and loaded as a whole"},
};
constexpr std::size_t kWidth = 110;
constexpr int kMostParameters = 12;

bool IsWord(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// A parameter list of a function's definition: its name and how many there are.
struct Parameters {
    std::string name;
    int count = 0;
};

/// Definitions in C++, GLSL and HLSL: NAME(…) and then {, perhaps behind const, noexcept and the like.
std::vector<Parameters> FindDefinitions(const std::string& code) {
    std::vector<Parameters> found;
    for (std::size_t open = code.find('('); open != std::string::npos; open = code.find('(', open + 1)) {
        std::size_t nameEnd = open;
        std::size_t nameBegin = nameEnd;
        while (nameBegin > 0 && IsWord(code[nameBegin - 1]))
            --nameBegin;
        const std::string name = code.substr(nameBegin, nameEnd - nameBegin);
        if (name.empty() || name == "if" || name == "for" || name == "while" || name == "switch")
            continue;
        int depth = 0, count = 0;
        bool hasText = false;
        std::size_t at = open;
        for (; at < code.size(); ++at) {
            const char c = code[at];
            if (c == '(' || c == '{' || c == '[' || c == '<')
                ++depth;
            else if (c == ')' || c == '}' || c == ']' || (c == '>' && depth > 1))
                --depth;
            else if (c == ',' && depth == 1)
                ++count;
            else if (std::isspace(static_cast<unsigned char>(c)) == 0)
                hasText = true;
            if (depth == 0)
                break;
        }
        std::size_t behind = std::min(at + 1, code.size());
        for (;;) { // const noexcept override …
            while (behind < code.size() && std::isspace(static_cast<unsigned char>(code[behind])) != 0)
                ++behind;
            std::size_t end = behind;
            while (end < code.size() && IsWord(code[end]))
                ++end;
            const std::string word = code.substr(behind, end - behind);
            if (word != "const" && word != "noexcept" && word != "override" && word != "final")
                break;
            behind = end;
        }
        if (behind < code.size() && code[behind] == '{')
            found.push_back({name, hasText ? count + 1 : 0});
    }
    return found;
}

} // namespace

TEST_CASE("house: every file says its licence") {
    const std::string line = std::string("SPDX-License") + "-Identifier: MIT";
    std::size_t files = 0;
    for (const SourceFile& file :
         ReadSources(kAllFolders, {".h", ".inl", ".cpp", ".c", ".comp", ".hlsl", ".frag", ".glsl", ".cmake",
                                   ".sh", ".md", ".in", "CMakeLists.txt"})) {
        ++files;
        bool says = false;
        for (std::size_t i = 0; i < std::min<std::size_t>(file.lines.size(), 3); ++i)
            says = says || file.lines[i].find(line) != std::string::npos;
        CHECK_MESSAGE(says, file.path);
    }
    CHECK(files > 300);
}

TEST_CASE("house: no file names a path of the machine that it was written on") {
    // Put together here, so that this file does not name them.
    const std::string folders[] = {std::string("/wo") + "rk/", std::string("/ro") + "ot/",
                                   std::string("/ho") + "me/"};
    for (const SourceFile& file :
         ReadSources(kAllFolders, {".h", ".inl", ".cpp", ".c", ".comp", ".hlsl", ".frag", ".glsl", ".cmake",
                                   ".sh", ".md", ".in", ".json", "CMakeLists.txt"})) {
        for (const std::string& folder : folders)
            CHECK_MESSAGE(file.text.find(folder) == std::string::npos, file.path << ": " << folder);
    }
}

TEST_CASE("house: comments of the product are at most 110 columns wide") {
    std::size_t widest = 0;
    for (const SourceFile& file : ReadSources(kProduct, {".h", ".inl", ".comp", ".hlsl"})) {
        for (std::size_t i = 0; i < file.lines.size(); ++i) {
            const std::string& line = file.lines[i];
            if (line.find("//") == std::string::npos || line.find("://") != std::string::npos)
                continue;
            const std::size_t columns = CountCharacters(line);
            widest = std::max(widest, columns);
            CHECK_MESSAGE(columns <= kWidth, file.path << ":" << i + 1 << ": " << columns << " columns");
        }
    }
    CHECK(widest > 100);
    MESSAGE("measure: widest line with a comment: " << widest << " columns");
}

TEST_CASE("house: no product file is longer than 400 lines without a reason") {
    std::size_t longest = 0;
    for (const SourceFile& file : ReadSources(kProduct, {".h", ".inl", ".comp", ".hlsl"})) {
        const auto entry = std::find_if(std::begin(kLongFiles), std::end(kLongFiles),
                                        [&](const LongFile& f) { return file.path == f.path; });
        const bool isListed = entry != std::end(kLongFiles);
        const std::size_t most = isListed ? entry->mostLines : kMostLines;
        CHECK_MESSAGE(file.lines.size() <= most, file.path << ": " << file.lines.size() << " lines");
        if (isListed) {
            CHECK_MESSAGE(file.lines.size() > kMostLines, file.path << ": needs no reason any more");
            MESSAGE("measure: " << file.path << ": " << file.lines.size()
                                << " lines: " << std::string(entry->reason));
        } else {
            longest = std::max(longest, file.lines.size());
        }
    }
    MESSAGE("measure: longest other product file: " << longest << " lines");
}

TEST_CASE("house: no function of the product has more than 12 parameters") {
    // The counting itself.
    const auto own = FindDefinitions("int F(int a, std::array<int, 3> b, int c = G(1, 2)) const noexcept {}\n"
                                     "if (x(1, 2)) {}\nvoid E() {}\nfor (;;) {}\n");
    REQUIRE(own.size() == 2);
    CHECK(own[0].count == 3);
    CHECK(own[1].count == 0);
    Parameters largest;
    std::size_t functions = 0;
    for (const SourceFile& file : ReadSources(kProduct, {".h", ".inl", ".comp", ".hlsl"})) {
        for (const Parameters& p : FindDefinitions(GetCode(file.text))) {
            ++functions;
            CHECK_MESSAGE(p.count <= kMostParameters, file.path << ": " << p.name << ": " << p.count);
            if (p.count > largest.count)
                largest = p;
        }
    }
    CHECK(functions > 500);
    MESSAGE("measure: largest parameter list: " << largest.count << " (" << largest.name << ") of "
                                                << functions << " definitions");
}

TEST_CASE("house: every C++ header puts hosts' macros aside, and hidden enumerators have another name") {
    const std::string names[] = {"Status", "None", "Bool", "True", "False", "Success", "Always"};
    for (const SourceFile& file : ReadSources({"include"}, {".h"})) {
        if (file.path.ends_with("Macros.h"))
            continue;
        const std::string code = GetCode(file.text);
        if (code.find("namespace ") != std::string::npos) {
            const std::size_t hide = file.text.find("#include \"openntc/core/HideMacros.h\"");
            const std::size_t restore = file.text.find("#include \"openntc/core/RestoreMacros.h\"");
            const bool hasPair = hide != std::string::npos && restore != std::string::npos &&
                                 hide < restore && hide < code.find("\nnamespace ") &&
                                 code.find_first_not_of(" \n", restore) == std::string::npos;
            CHECK_MESSAGE(hasPair, file.path << ": core/HideMacros.h behind its includes, "
                                             << "core/RestoreMacros.h at its end");
        }
        for (std::size_t at = code.find("enum class "); at != std::string::npos;
             at = code.find("enum class ", at + 1)) {
            const std::size_t open = code.find('{', at);
            const std::string body = code.substr(open, code.find('}', open) - open);
            for (const std::string& name : names) {
                const std::size_t found = body.find(name);
                if (found == std::string::npos || IsWord(body[found - 1]) ||
                    IsWord(body[found + name.size()]))
                    continue;
                CHECK_MESSAGE(body.find("= " + name, found) != std::string::npos,
                              file.path << ": " << name << " is a macro of X11: needs a second name");
            }
        }
    }
}

TEST_CASE(
    "house: every C++ header says how stable it is, and docs/versioning.md lists the experimental ones") {
    std::string page;
    for (const SourceFile& file : ReadSources({"docs"}, {"versioning.md"}))
        page = file.text;
    REQUIRE_FALSE(page.empty());
    std::size_t stable = 0, experimental = 0, internal = 0;
    for (const SourceFile& file : ReadSources({"include"}, {".h"})) {
        REQUIRE_MESSAGE(file.lines.size() > 2, file.path);
        const std::string& line = file.lines[1];
        const bool isPrivate =
            file.path.find("/detail/") != std::string::npos || file.path.find("/fast/") != std::string::npos;
        const std::string name = file.path.substr(std::string("include/openntc/").size());
        const bool isListed = page.find("`" + name + "`") != std::string::npos;
        if (line == "// Stability: experimental") {
            ++experimental;
            CHECK_MESSAGE(isListed, file.path << ": not in docs/versioning.md");
        } else if (line == "// Stability: internal") {
            ++internal;
            CHECK_MESSAGE(!isListed, file.path << ": in docs/versioning.md");
        } else {
            ++stable;
            CHECK_MESSAGE(line == "// Stability: stable", file.path << ": its second line: " << line);
            CHECK_MESSAGE(!isListed, file.path << ": in docs/versioning.md");
        }
        CHECK_MESSAGE((!isPrivate || line == "// Stability: internal"), file.path);
    }
    CHECK(experimental > 0);
    MESSAGE("measure: headers: " << stable << " stable, " << experimental << " experimental, " << internal
                                 << " internal");
}

TEST_CASE("house: no table of the README says two things of one name") {
    std::ifstream readme(OPENNTC_SOURCE_DIR "/README.md");
    std::set<std::string> names; // of the rows of the table that is being read
    std::size_t rows = 0;
    for (std::string line; std::getline(readme, line);) {
        if (!line.starts_with("| ")) {
            names.clear();
            continue;
        }
        ++rows;
        const std::string name = line.substr(2, line.find(" |", 2) - 2);
        CHECK_MESSAGE(names.insert(name).second, "README.md: two rows: " << name);
    }
    CHECK(rows > 50);
}
