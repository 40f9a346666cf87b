// SPDX-License-Identifier: MIT
// Flattened text is the same shader: its SPIR-V has the instructions of the source's, so its texels have the same bits
// wherever those do. In every emulated maths mode, both languages, and with what brings extensions along.
#include "shader_compiler/Compiler.h"
#include "shader_compiler/Permutations.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

using namespace openntc::shader_compiler;

namespace {

/// All instructions but for what names sources and their extensions: OpSource (3), OpSourceExtension (4), OpString (7).
std::vector<std::uint32_t> GetCode(const std::vector<std::uint32_t>& words) {
    std::vector<std::uint32_t> code;
    for (std::size_t at = 5; at < words.size();) {
        const std::size_t count = words[at] >> 16;
        REQUIRE((count != 0 && count <= words.size() - at));
        const std::uint32_t op = words[at] & 0xFFFFu;
        if (op != 3 && op != 4 && op != 7)
            code.insert(code.end(), words.begin() + static_cast<std::ptrdiff_t>(at),
                        words.begin() + static_cast<std::ptrdiff_t>(at + count));
        at += count;
    }
    return code;
}

struct Flat {
    std::string source; ///< below shaders/openntc/passes or tests/shader/matrix
    std::string stage;
    std::vector<std::string> defines;
};

std::vector<Flat> GetCover() {
    std::vector<Flat> cover;
    for (int math = 1; math <= 5; ++math) {
        // Networks differ in constants, but for those of generations 2 and 3.
        for (const char* network : {"1", "6"})
            cover.push_back(
                {"passes/DecodeTexels.comp",
                 "comp",
                 {"NTC_MATH=" + std::to_string(math), std::string("NETWORK_VERSION=") + network}});
    }
    for (const char* math : {"1", "3"})
        cover.push_back(
            {"passes/DecodeTexels.hlsl", "comp", {std::string("NTC_MATH=") + math, "NETWORK_VERSION=2"}});
    cover.push_back({"passes/DecodeTexels.comp",
                     "comp",
                     {"NTC_MATH=1", "NETWORK_VERSION=2", "NTC_DOT4_SPIRV=1", "NTC_OUTPUT_MASK=0x7"}});
    cover.push_back({"passes/DecodeTexels.comp",
                     "comp",
                     {"NTC_MATH=1", "NETWORK_VERSION=2", "NTC_NO_LOOP_ATTRIBUTES=1", "NTC_NO_PRECISE=1"}});
    cover.push_back({"passes/DecodeTexels.comp",
                     "comp",
                     {"NTC_MATH=2", "NETWORK_VERSION=2", "NTC_WEIGHT_FETCH=3",
                      "NTC_SUBGROUP_DECODES_ONE_SET=1", "NTC_WIDE_WEIGHT_LOADS=1"}});
    cover.push_back({"passes/DecompressToTextures.comp", "comp", {"NTC_MATH=1", "NETWORK_VERSION=6"}});
    return cover;
}

} // namespace

TEST_CASE("flattened text compiles to the same instructions") {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "openntc_flatten";
    std::filesystem::create_directories(folder);
    for (const Flat& flat : GetCover()) {
        Permutation permutation =
            ListPermutations({{NTC_SHADER_DIR "/openntc/" + flat.source, flat.stage, "", {}}}, {}).at(0);
        permutation.defines = flat.defines;
        CAPTURE(permutation.GetKey());
        CompileSettings settings;
        settings.includeDirectories = {NTC_SHADER_DIR};
        const CompileResult expected = Compile(permutation, settings);
        REQUIRE_MESSAGE(expected.IsGood(), expected.error);
        settings.flatten = true;
        const CompileResult text = Compile(permutation, settings);
        REQUIRE_MESSAGE(text.IsGood(), text.error);
        CHECK(text.words.empty());

        // Only #version and #extension, and nothing but those before the code.
        std::istringstream lines(text.text);
        std::string line;
        bool hasCode = false;
        for (int number = 1; std::getline(lines, line); ++number) {
            CHECK(line.starts_with("#version") == (number == 1 && !permutation.hlsl));
            if (line.starts_with("#")) {
                CHECK_FALSE(hasCode);
                CHECK((number == 1 || line.starts_with("#extension ")));
                CHECK(line.find("include") == std::string::npos);
            } else if (!line.starts_with("//")) {
                hasCode = true;
            }
        }
        const std::filesystem::path file = folder / permutation.GetFlatName();
        std::ofstream(file, std::ios::binary) << text.text;
        Permutation alone = ListPermutations({{file, flat.stage, "", {}}}, {}).at(0);
        CompileSettings bare; // without folders
        const CompileResult result = Compile(alone, bare);
        REQUIRE_MESSAGE(result.IsGood(), result.error);
        CHECK(GetCode(result.words) == GetCode(expected.words));
    }
    std::filesystem::remove_all(folder);
}
