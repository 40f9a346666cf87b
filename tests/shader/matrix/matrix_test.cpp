// SPDX-License-Identifier: MIT
// The compile matrix: GLSL and HLSL, compute and fragment shaders, every maths mode that the compiler can express, and for
// each of these a set of permutations in which every pair of network version and switches occurs. Each is compiled in
// process, accepted by the SPIR-V validator, and reads its constants from where C++ puts them.
#include "shader/ConstantFields.h"
#include "shader/SpirvLayout.h"
#include "shader/matrix/PairwiseCover.h"

#include "shader_compiler/Compiler.h"
#include "shader_compiler/Failure.h"
#include "shader_compiler/Permutations.h"

#include <doctest/doctest.h>

#include <map>
#include <string>
#include <vector>

using namespace openntc::shader_compiler;
using namespace openntc_tests;

namespace {

/// A switch: each value is the defines that it needs.
struct Factor {
    std::string name;
    std::vector<std::vector<std::string>> values;
};

// A macro with the values that it can have, the first one being undefined.
Factor MakeSwitch(const std::string& macro, const std::vector<std::string>& values) {
    Factor factor{macro, {{}}};
    for (const std::string& value : values) {
        std::string define = macro;
        define.append("=").append(value);
        factor.values.push_back({define});
    }
    return factor;
}

constexpr int kInt8 = 1, kInt8Half = 2, kFP16 = 4, kCoopVecInt8 = 6, kCoopVecFP8 = 7;

std::vector<Factor> GetFactors(int math, bool hlsl) {
    // Medium and large differ from small and xlarge in constants only.
    std::vector<Factor> factors = {
        {"NETWORK_VERSION",
         {{"NETWORK_VERSION=1"}, {"NETWORK_VERSION=4"}, {"NETWORK_VERSION=5"}, {"NETWORK_VERSION=6"}}},
        // One output, a few, many, and some with gaps between them.
        MakeSwitch("NTC_OUTPUT_MASK", {"0x1", "0x7", "0x1FF", "0x8421"}),
        MakeSwitch("NTC_LINEARISE", {"0"}),
        MakeSwitch("NTC_SINGLE_MIP", {"1"}),
        MakeSwitch("NTC_LATENT_SLICES", {"0"}),
        MakeSwitch("NTC_CLAMP_TEXELS", {"0"}),
    };
    factors[2].values.push_back({"NTC_LINEARISE=2", "NTC_CHANNEL_COLOR_SPACES=0x80040021"});
    if (math == kInt8 || math == kInt8Half) {
        factors.push_back(MakeSwitch("NTC_TEXELS_PER_INVOCATION", {"2"}));
        factors.push_back(MakeSwitch("NTC_FLOAT_DOT", {"1"}));
        factors.push_back(MakeSwitch("NTC_WIDE_WEIGHT_LOADS", {"1"}));
        if (!hlsl) {
            factors.push_back(MakeSwitch("NTC_DOT4_SPIRV", {"1"}));
            factors.push_back(MakeSwitch("NTC_WEIGHT_FETCH", {"2"}));
            factors.back().values.push_back({"NTC_WEIGHT_FETCH=3", "NTC_SUBGROUP_DECODES_ONE_SET=1"});
        }
    }
    if (math == kFP16 && !hlsl)
        factors.push_back(MakeSwitch("NTC_NATIVE_FLOAT16", {"1"}));
    if (math == kCoopVecInt8)
        factors.push_back(MakeSwitch("NTC_COOPVEC_EXPLICIT", {"1"}));
    return factors;
}

std::vector<Permutation> MakePermutations(const std::string& source, int math,
                                          const std::vector<Factor>& factors, const std::vector<Row>& rows) {
    const auto base = ListPermutations({{std::string(NTC_MATRIX_DIR) + "/" + source, "", "", {}}}, {});
    std::vector<Permutation> permutations;
    for (const Row& row : rows) {
        Permutation permutation = base.at(0);
        permutation.defines = {"NTC_MATH=" + std::to_string(math)};
        for (std::size_t i = 0; i < row.size(); ++i) {
            const auto& defines = factors[i].values[row[i]];
            permutation.defines.insert(permutation.defines.end(), defines.begin(), defines.end());
        }
        permutations.push_back(permutation);
    }
    return permutations;
}

CompileSettings GetSettings() {
    CompileSettings settings;
    settings.includeDirectories = {NTC_SHADER_DIR};
    return settings;
}

void CheckConstants(const Permutation& permutation, const std::vector<std::uint32_t>& words) {
    CAPTURE(permutation.GetKey());
    const SpirvLayout layout(words);
    const auto* block = layout.FindUniformBlock(0, 0);
    REQUIRE(block != nullptr);
    REQUIRE(block->size() == 1);
    CHECK(layout.GetStructName((*block)[0].type) == "NtcTextureSetConstants");
    Fields fields;
    layout.FlattenType((*block)[0].type, "", (*block)[0].offset.value_or(1), fields);
    CHECK(fields == GetCppFields());
}

} // namespace

TEST_CASE("covering sets hold every pair") {
    for (const std::vector<std::size_t>& counts : {std::vector<std::size_t>{2, 2},
                                                   {4, 5, 3, 2, 2, 2},
                                                   {1, 3, 1},
                                                   {3, 3, 3, 3, 3, 3, 3},
                                                   {2, 7, 2, 6}}) {
        const std::vector<Row> rows = MakePairwiseCover(counts);
        CHECK(ListCoveredPairs(rows) == ListPairs(counts));
        std::size_t all = 1;
        for (const std::size_t count : counts)
            all *= count;
        CHECK(rows.size() <= all);
    }
    CHECK(ListPairs({2, 3, 4}).size() == 2 * 3 + 2 * 4 + 3 * 4);
    // Nine rows are the fewest for four factors of three values; a greedy set may be a little larger.
    CHECK(MakePairwiseCover({3, 3, 3, 3}).size() <= 12);
}

TEST_CASE("compile matrix: every permutation compiles, is valid, and finds its constants") {
    std::vector<Permutation> permutations;
    std::size_t pairs = 0, covered = 0;
    for (const char* source : {"Texels.comp", "Texels.frag", "Texels.comp.hlsl", "Texels.frag.hlsl"}) {
        const bool hlsl = std::string(source).ends_with(".hlsl");
        const int last = !hlsl && KnowsCooperativeVectors() ? kCoopVecFP8 : 5;
        for (int math = kInt8; math <= last; ++math) {
            const std::vector<Factor> factors = GetFactors(math, hlsl);
            std::vector<std::size_t> counts;
            counts.reserve(factors.size());
            for (const Factor& factor : factors)
                counts.push_back(factor.values.size());
            const std::vector<Row> rows = MakePairwiseCover(counts);
            pairs += ListPairs(counts).size();
            covered += ListCoveredPairs(rows).size();
            const auto more = MakePermutations(source, math, factors, rows);
            permutations.insert(permutations.end(), more.begin(), more.end());
        }
    }
    CHECK(covered == pairs);
    MESSAGE("compile matrix: " << permutations.size() << " permutations; " << covered << " of " << pairs
                               << " pairs of values covered");
    if (!KnowsCooperativeVectors())
        MESSAGE("SKIP: COOPVEC_INT8 and COOPVEC_FP8 in the compile matrix: this glslang does not know "
                "GL_NV_cooperative_vector");
    std::vector<CompileResult> results;
    try {
        results = CompileAll(permutations, GetSettings());
    } catch (const Failure& failure) {
        FAIL(failure.GetSubject() << ": " << failure.what());
    }
    REQUIRE(results.size() == permutations.size());
    double milliseconds = 0;
    for (std::size_t i = 0; i < results.size(); ++i) {
        CheckConstants(permutations[i], results[i].words);
        milliseconds += results[i].milliseconds;
    }
    MESSAGE("compile matrix: " << milliseconds / 1000
                               << " s of compiling and validating, all threads together");
}

TEST_CASE("compile matrix: a permutation that makes no sense is refused with its macro's name") {
    const std::map<std::string, std::string> refusals = {
        {"NTC_OUTPUT_MASK=0", "NTC_OUTPUT_MASK must be"},
        {"NTC_OUTPUT_MASK=0x10000", "NTC_OUTPUT_MASK must be"},
        {"NTC_LINEARISE=3", "NTC_LINEARISE must be"},
        {"NTC_LINEARISE=2", "NTC_CHANNEL_COLOR_SPACES is not defined"},
        {"NTC_SINGLE_MIP=2", "NTC_SINGLE_MIP must be"},
        {"NTC_LATENT_SLICES=2", "NTC_LATENT_SLICES must be"},
        {"NTC_CLAMP_TEXELS=2", "NTC_CLAMP_TEXELS must be"},
        {"NTC_MATH=99", "NTC_MATH must be"},
        {"NTC_TEXELS_PER_INVOCATION=9", "NTC_TEXELS_PER_INVOCATION must be"},
        {"NTC_WEIGHT_FETCH=4", "NTC_WEIGHT_FETCH must be"},
        {"NETWORK_VERSION=7", "NETWORK_VERSION must be"},
    };
    for (const char* source : {"Texels.comp", "Texels.frag", "Texels.comp.hlsl", "Texels.frag.hlsl"}) {
        for (const auto& [define, message] : refusals) {
            auto permutation =
                ListPermutations({{std::string(NTC_MATRIX_DIR) + "/" + source, "", "", {}}}, {}).at(0);
            permutation.defines = {define};
            if (!define.starts_with("NETWORK_VERSION"))
                permutation.defines.push_back("NETWORK_VERSION=1");
            CAPTURE(permutation.GetKey());
            const CompileResult result = Compile(permutation, GetSettings());
            CHECK_FALSE(result.IsGood());
            CHECK(result.error.find(message) != std::string::npos);
            CHECK(result.error.find("openntc/") != std::string::npos); // where the macro is checked
        }
    }
}
