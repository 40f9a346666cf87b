// SPDX-License-Identifier: MIT
// What the SPIR-V of ordinary builds says: floating-point operations of the exact path must not be contracted, and headers
// that only calculate declare no resource.
#include "shader_compiler/Compiler.h"
#include "shader_compiler/Permutations.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace openntc::shader_compiler;

namespace {

CompileSettings GetExactSettings() {
    CompileSettings settings;
    settings.includeDirectories = {NTC_SHADER_DIR};
    return settings;
}

/// Calls `use` with every instruction.
template <typename Use>
void ForEachInstruction(std::span<const std::uint32_t> words, Use&& use) {
    for (std::size_t at = 5; at < words.size();) {
        const std::size_t count = words[at] >> 16;
        REQUIRE((count != 0 && count <= words.size() - at));
        use(words[at] & 0xFFFFu, words.subspan(at, count));
        at += count;
    }
}

constexpr std::uint32_t kEntryPoint = 15, kConstant = 43, kFunction = 54, kFunctionCall = 57, kVariable = 59,
                        kDecorate = 71, kFAdd = 129, kFSub = 131, kFMul = 133, kFDiv = 136,
                        kNoContraction = 42;

struct Counts {
    int marked = 0, exact = 0, other = 0;
};

/// Operations in functions that the entry point reaches. A product with a power of two is exact whatever becomes of it.
Counts CountOperations(std::span<const std::uint32_t> words) {
    std::set<std::uint32_t> marked, exactFactors, reached;
    std::map<std::uint32_t, std::set<std::uint32_t>> calls;
    std::map<std::uint32_t, Counts> counts;
    std::uint32_t entry = 0, function = 0;
    ForEachInstruction(words, [&](std::uint32_t op, std::span<const std::uint32_t> w) {
        if (op == kEntryPoint)
            entry = w[2];
        else if (op == kDecorate && w[2] == kNoContraction)
            marked.insert(w[1]);
        else if (op == kConstant && (w[3] & 0x7FFFFFu) == 0)
            exactFactors.insert(w[2]);
        else if (op == kFunction)
            function = w[2];
        else if (op == kFunctionCall)
            calls[function].insert(w[3]);
        else if (op == kFAdd || op == kFSub || op == kFMul || op == kFDiv) {
            if (marked.count(w[2]) != 0)
                ++counts[function].marked;
            else if (op == kFMul && (exactFactors.count(w[3]) != 0 || exactFactors.count(w[4]) != 0))
                ++counts[function].exact;
            else
                ++counts[function].other;
        }
    });
    Counts sum;
    std::vector<std::uint32_t> open = {entry};
    while (!open.empty()) {
        const std::uint32_t at = open.back();
        open.pop_back();
        if (!reached.insert(at).second)
            continue;
        sum.marked += counts[at].marked;
        sum.exact += counts[at].exact;
        sum.other += counts[at].other;
        open.insert(open.end(), calls[at].begin(), calls[at].end());
    }
    return sum;
}

} // namespace

TEST_CASE("SPIR-V: every floating-point operation of the exact path is kept from contraction") {
    for (const char* source : {"DecodeTexels.comp", "DecodeTexels.hlsl"}) {
        for (int math = 1; math <= 5; ++math) {
            auto permutation =
                ListPermutations(
                    {{std::string(NTC_SHADER_DIR) + "/openntc/passes/" + source, "comp", "", {}}}, {})
                    .at(0);
            // Colour spaces are no part of the exact path.
            permutation.defines = {"NETWORK_VERSION=3", "NTC_MATH=" + std::to_string(math),
                                   "NTC_LINEARISE=0"};
            const CompileResult result = Compile(permutation, GetExactSettings());
            REQUIRE_MESSAGE(result.IsGood(), result.error);
            const Counts counts = CountOperations(result.words);
            CAPTURE(source);
            CAPTURE(math);
            CHECK(counts.other == 0);
            CHECK(counts.marked >= 25);
            // With the qualifier defined away, none is.
            permutation.defines.push_back("NTC_NO_PRECISE=1");
            const CompileResult bare = Compile(permutation, GetExactSettings());
            REQUIRE_MESSAGE(bare.IsGood(), bare.error);
            CHECK(CountOperations(bare.words).marked == 0);
        }
    }
}

TEST_CASE("SPIR-V: headers that only calculate declare no resource") {
    // The others read latents or weights, which Buffers.h declares.
    const std::set<std::string> calculating = {
        "ColorSpaces.h", "EffectTable.h", "Effects.h",     "InferenceConstants.h", "InputsPosition.h",
        "LatentFetch.h", "MathModes.h",   "Portability.h", "Rounding.h",           "StochasticFiltering.h",
        "Switches.h",    "TexelCoords.h", "WeightFetch.h", "WrapModes.h"};
    // GLSL extensions and shared memory, C++
    const std::set<std::string> notAlone = {"InferenceCoopVec.h", "NetworkCoopMat.h", "NetworkCoopMatTypes.h",
                                            "PortabilityCpp.h"};
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "openntc_headers_alone";
    std::filesystem::create_directories(folder);
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(NTC_SHADER_DIR "/openntc")) {
        const std::string name = entry.path().filename().string();
        if (entry.path().extension() != ".h" || notAlone.count(name) != 0)
            continue;
        CAPTURE(name);
        const std::filesystem::path file = folder / "alone.frag";
        std::ofstream(file)
            << "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"openntc/" << name
            << "\"\nlayout(location = 0) out vec4 color;\nvoid main() { color = vec4(1.0); }\n";
        auto permutation = ListPermutations({{file, "frag", "", {}}}, {}).at(0);
        permutation.defines = {"NETWORK_VERSION=1"};
        const CompileResult result = Compile(permutation, GetExactSettings());
        REQUIRE_MESSAGE(result.IsGood(), result.error);
        int resources = 0;
        ForEachInstruction(result.words, [&](std::uint32_t op, std::span<const std::uint32_t> w) {
            // Uniform, UniformConstant, PushConstant, StorageBuffer
            resources += op == kVariable && (w[3] == 2 || w[3] == 0 || w[3] == 9 || w[3] == 12) ? 1 : 0;
        });
        if (calculating.count(name) != 0) {
            CHECK(resources == 0);
            ++count;
        } else {
            CHECK(resources == 2);
        }
    }
    CHECK(count == calculating.size());
    std::filesystem::remove_all(folder);
}
