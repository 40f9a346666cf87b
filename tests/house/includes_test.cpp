// SPDX-License-Identifier: MIT
// What may include what: the table of docs/architecture.md, read from it.
#include "SourceTree.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <set>

using namespace openntc_tests;

namespace {

const std::vector<std::string> kCode = {".h", ".inl", ".cpp", ".comp", ".hlsl", ".frag", ".glsl", ".c"};

} // namespace

TEST_CASE("house: nothing in include, shaders and examples includes from tests") {
    std::size_t includes = 0, fromTests = 0;
    for (const SourceFile& file : ReadSources({"include", "shaders", "examples"}, kCode)) {
        for (const std::string& include : GetIncludes(file)) {
            ++includes;
            const bool isFine = !ResolveInclude(file, include).starts_with("tests/");
            CHECK_MESSAGE(isFine, file.path << ": " << include);
            fromTests += isFine ? 0 : 1;
        }
    }
    CHECK(includes > 1000);
    for (const SourceFile& file : ReadSources({"examples", "cmake"}, {"CMakeLists.txt", ".cmake"})) {
        for (const std::string& line : file.lines) {
            CHECK_MESSAGE(line.find("}/tests\"") == std::string::npos, file.path << ": " << line);
        }
    }
    MESSAGE("measure: includes from tests in include, shaders, examples: " << fromTests << " of "
                                                                           << includes);
}

TEST_CASE("house: no arrow runs back: a room includes what docs/architecture.md allows") {
    const auto table = ReadArchitectureTable();
    for (const std::string room : {"core", "format", "container", "texture_set", "inference", "permutation",
                                   "streaming", "decode", "image", "encode", "shaders"})
        REQUIRE_MESSAGE(table.contains(room), room);
    for (const auto& entry : table) { // the table itself has no way back
        const std::string& room = entry.first;
        for (const std::string& other : entry.second) {
            if (other == room || !table.contains(other))
                continue;
            const auto& others = table.at(other);
            CHECK_MESSAGE(std::find(others.begin(), others.end(), room) == others.end(),
                          room << " and " << other);
        }
    }
    std::size_t arrows = 0, back = 0;
    for (const SourceFile& file : ReadSources({"include", "shaders"}, kCode)) {
        const std::string room = GetRoom(file.path);
        if (room.empty()) // the umbrella
            continue;
        CHECK_MESSAGE(table.contains(room), file.path << ": its room is not in docs/architecture.md");
        for (const std::string& include : GetIncludes(file)) {
            const std::string target = ResolveInclude(file, include);
            if (target.empty() || !table.contains(room))
                continue;
            const std::vector<std::string>& allowed = table.at(room);
            const auto mayInclude = [&](const std::string& name) {
                return std::find(allowed.begin(), allowed.end(), name) != allowed.end();
            };
            // The pair of macro headers belongs to all of the C++, and InferenceConstants.h is shared.
            const bool isFine =
                mayInclude(GetRoom(target)) || mayInclude(std::filesystem::path(target).filename().string());
            CHECK_MESSAGE(isFine, file.path << " includes " << include << ": " << room << " may not");
            arrows += GetRoom(target) != room ? 1 : 0;
            back += isFine ? 0 : 1;
        }
    }
    MESSAGE("measure: arrows back: " << back << " of " << arrows << " includes between rooms");
}

TEST_CASE("house: no include cycles") {
    std::map<std::string, std::vector<std::string>> graph;
    for (const SourceFile& file : ReadSources({"include", "shaders", "examples"}, kCode)) {
        for (const std::string& include : GetIncludes(file)) {
            if (const std::string target = ResolveInclude(file, include); !target.empty())
                graph[file.path].push_back(target);
        }
    }
    std::set<std::string> done;
    std::vector<std::string> stack;
    std::size_t cycles = 0;
    const std::function<void(const std::string&)> visit = [&](const std::string& path) {
        if (const auto at = std::find(stack.begin(), stack.end(), path); at != stack.end()) {
            ++cycles;
            std::string text;
            for (auto step = at; step != stack.end(); ++step)
                text += *step + " > ";
            CHECK_MESSAGE(false, text << path);
            return;
        }
        if (!done.insert(path).second)
            return;
        stack.push_back(path);
        for (const std::string& next : graph[path])
            visit(next);
        stack.pop_back();
    };
    const auto copy = graph;
    for (const auto& entry : copy)
        visit(entry.first);
    CHECK(cycles == 0);
    MESSAGE("measure: include cycles: " << cycles << " in " << copy.size() << " files");
}

TEST_CASE("house: `detail` and `fast` folders are private to their room") {
    std::size_t uses = 0;
    for (const SourceFile& file : ReadSources({"include", "shaders", "examples"}, kCode)) {
        for (const std::string& include : GetIncludes(file)) {
            const std::string target = ResolveInclude(file, include);
            if (target.find("/detail/") == std::string::npos && target.find("/fast/") == std::string::npos)
                continue;
            ++uses;
            CHECK_MESSAGE(GetRoom(target) == GetRoom(file.path), file.path << " includes " << include);
        }
    }
    CHECK(uses > 30);
}
