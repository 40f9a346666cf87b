// SPDX-License-Identifier: MIT
// Covering permutations: the rule of each effect, reading definitions back, the cheapest of many, and errors.
#include "openntc/permutation/PermutationCover.h"

#include <doctest/doctest.h>

#include <random>
#include <string>
#include <string_view>
#include <vector>

using namespace openntc;

namespace {

PermutationKey Read(std::string_view defines, ShaderLanguage language = ShaderLanguage::Glsl) {
    PermutationKey key;
    REQUIRE_MESSAGE(ReadDefines(defines, "", language, key), std::string(defines));
    return key;
}

bool Covers(std::string_view compiled, std::string_view wanted) {
    const std::string common = "NETWORK_VERSION=2 NTC_MATH=1 ";
    return openntc::Covers(Read(common + std::string(compiled)), Read(common + std::string(wanted)));
}

using Index = std::vector<ShaderKey>;

Expected<CoverMatch> Find(const Index& index, std::string_view wanted, std::string_view own = "",
                          std::string_view leftOut = "", ShaderLanguage language = ShaderLanguage::Glsl) {
    return FindCover("a.comp", Read(wanted, language), own, leftOut, index.size(),
                     [&](std::size_t i) { return index[i]; });
}

std::string FindDefines(const Index& index, std::string_view wanted, std::string_view own = "",
                        ShaderLanguage language = ShaderLanguage::Glsl) {
    const auto found = Find(index, wanted, own, "", language);
    return found ? std::string(index[found->index].defines) : "none";
}

} // namespace

TEST_CASE("what a compiled effect serves, rule by rule") {
    // Compiled, wanted, served? From the meaning of the switches in openntc/Effects.h.
    struct Row {
        const char* compiled;
        const char* wanted;
        bool covers;
    };
    constexpr Row kRows[] = {
        {"", "NTC_OUTPUT_MASK=0x7", true},
        {"NTC_OUTPUT_MASK=0xF", "NTC_OUTPUT_MASK=0x7", true},
        {"NTC_OUTPUT_MASK=0x7", "NTC_OUTPUT_MASK=0x7", true},
        {"NTC_OUTPUT_MASK=0xB", "NTC_OUTPUT_MASK=0x7", false},
        {"NTC_OUTPUT_MASK=0x7", "", false},
        {"", "NTC_LINEARISE=0", true},
        {"NTC_LINEARISE=0", "", false},
        {"NTC_LINEARISE=0", "NTC_LINEARISE=0", true},
        {"", "NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15", true},
        {"NTC_LINEARISE=0", "NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x0", false},
        {"NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15", "", false},
        {"NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15", "NTC_LINEARISE=0", true},
        {"NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15", "NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15",
         true},
        {"NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15", "NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x5",
         false},
        // Spaces of channels that neither evaluates do not matter.
        {"NTC_OUTPUT_MASK=0x3 NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15",
         "NTC_OUTPUT_MASK=0x3 NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x5", true},
        // The shader would refuse constants with another space in channel 2, of which the key says nothing.
        {"NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x5",
         "NTC_OUTPUT_MASK=0x3 NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x5", false},
        {"", "NTC_SINGLE_MIP=1", true},
        {"NTC_SINGLE_MIP=1", "", false},
        {"", "NTC_LATENT_SLICES=0", true},
        {"NTC_LATENT_SLICES=0", "", false},
        {"", "NTC_CLAMP_TEXELS=0", true},
        {"NTC_CLAMP_TEXELS=0", "", false},
        // How weights are read: the plain way serves, what the device or host did not promise does not.
        {"", "NTC_DOT4_SPIRV=1", true},
        {"NTC_DOT4_SPIRV=1", "", false},
        {"", "NTC_WIDE_WEIGHT_LOADS=1", true},
        {"NTC_WIDE_WEIGHT_LOADS=1", "", false},
        {"", "NTC_FLOAT_DOT=1", true},
        {"NTC_FLOAT_DOT=1", "", false},
        {"", "NTC_NATIVE_FLOAT16=1", true},
        {"NTC_NATIVE_FLOAT16", "", false},
        {"", "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1", true},
        {"NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1", "", false},
        {"", "NTC_WEIGHT_FETCH=2", false},
        {"NTC_WEIGHT_FETCH=2", "", false},
        {"", "NTC_TEXELS_PER_INVOCATION=2", false},
        {"NTC_TEXELS_PER_INVOCATION=2", "", false},
    };
    for (const Row& row : kRows) {
        CAPTURE(std::string(row.compiled));
        CAPTURE(std::string(row.wanted));
        CHECK(Covers(row.compiled, row.wanted) == row.covers);
    }
    CHECK_FALSE(openntc::Covers(Read("NETWORK_VERSION=1 NTC_MATH=1"), Read("NETWORK_VERSION=2 NTC_MATH=1")));
    CHECK_FALSE(openntc::Covers(Read("NETWORK_VERSION=1 NTC_MATH=1"), Read("NETWORK_VERSION=1 NTC_MATH=2")));
    CHECK_FALSE(openntc::Covers(Read("NETWORK_VERSION=1", ShaderLanguage::Hlsl), Read("NETWORK_VERSION=1")));
}

TEST_CASE("definitions are read back as the key that wrote them") {
    std::mt19937 random(1);
    const auto pick = [&](std::uint32_t count) { return static_cast<std::uint32_t>(random() % count); };
    for (int i = 0; i < 2000; ++i) {
        PermutationKey key;
        key.language = pick(2) != 0 ? ShaderLanguage::Hlsl : ShaderLanguage::Glsl;
        key.networkVersion = static_cast<int>(1 + pick(4));
        key.math = static_cast<int>(1 + pick(7));
        key.weightFetch = static_cast<int>(1 + pick(3));
        key.texelsPerInvocation = static_cast<int>(1 + pick(8));
        key.wideWeightLoads = pick(2) != 0;
        key.floatDot = pick(2) != 0;
        key.integerDotProduct = pick(2) != 0;
        key.nativeFloat16 = pick(2) != 0;
        key.effects = {1 + pick(0xFFFF), pick(3), pick(0xFFFFFFFFu), pick(2), pick(2), pick(2)};
        const std::string defines(key.ToDefines().View());
        CAPTURE(defines);
        PermutationKey read;
        REQUIRE(ReadDefines(defines, "", key.language, read));
        CHECK(read == key);
        CHECK(openntc::Covers(read, key));
    }
    PermutationKey key;
    CHECK(Read("NTC_LINEARISE=NTC_LINEARISE_NONE NETWORK_VERSION=NTC_NETWORK_LARGE NTC_MATH=NTC_MATH_FP8")
              .ToDefines()
              .View() == "NETWORK_VERSION=3 NTC_MATH=3 NTC_LINEARISE=0");
    CHECK(Read("NTC_OUTPUT_MASK=0Xff NTC_SINGLE_MIP").ToDefines().View() ==
          "NETWORK_VERSION=0 NTC_MATH=1 NTC_OUTPUT_MASK=0xFF NTC_SINGLE_MIP=1");
    for (const char* damaged : {"NTC_MATH=", "NTC_MATH=0x", "NTC_MATH=7u", "NTC_OUTPUT_MASK=0x100000000",
                                "NTC_SINGLE_MIP=yes", "NETWORK_VERSION=a"})
        CHECK_FALSE(ReadDefines(damaged, "", ShaderLanguage::Glsl, key));
    // Macros that are not the key's are the engine's: the same ones, no more and no fewer.
    CHECK(ReadDefines("SHADOWS=1 NTC_MATH=2 FOG=0", "FOG=0 SHADOWS=1", ShaderLanguage::Glsl, key));
    CHECK(key.math == NTC_MATH_INT8_HALF);
    CHECK_FALSE(ReadDefines("SHADOWS=1 FOG=0", "SHADOWS=1", ShaderLanguage::Glsl, key));
    CHECK_FALSE(ReadDefines("SHADOWS=1", "SHADOWS=1 FOG=0", ShaderLanguage::Glsl, key));
    CHECK_FALSE(ReadDefines("SHADOWS=1", "SHADOWS=2", ShaderLanguage::Glsl, key));
    // The other language's dot product is not this one's.
    CHECK_FALSE(ReadDefines("NTC_DOT4_SPIRV=1", "", ShaderLanguage::Hlsl, key));
    CHECK_FALSE(ReadDefines("NTC_DOT4_SM64=1", "", ShaderLanguage::Glsl, key));
}

TEST_CASE("the cheapest permutation that covers is found, and the exact one before others") {
    // What the documentation compiles.
    const Index index = {
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1"},
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0xFFF"},
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7"},
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0 NTC_LATENT_SLICES=0"},
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 NTC_SINGLE_MIP=1"},
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_DOT4_SPIRV=1"},
        {"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x1 SHADOWS=1"},
        {"b.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x3"},
    };
    const std::string network = "NETWORK_VERSION=1 NTC_MATH=1 ";
    const auto find = [&](const char* wanted, const char* own = "") {
        const std::string found = FindDefines(index, network + wanted, own);
        return found.starts_with(network) ? found.substr(network.size()) : found;
    };
    // SceneNeeds{} of the sample bricks.
    CHECK(find("NTC_OUTPUT_MASK=0xF3F NTC_LINEARISE=0 NTC_LATENT_SLICES=0") == "NTC_OUTPUT_MASK=0xFFF");
    CHECK(find("NTC_OUTPUT_MASK=0x3 NTC_LINEARISE=0 NTC_LATENT_SLICES=0") ==
          "NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0 NTC_LATENT_SLICES=0");
    CHECK(find("NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x15") == "NTC_OUTPUT_MASK=0x7");
    CHECK(find("NTC_OUTPUT_MASK=0x7 NTC_SINGLE_MIP=1") == "NTC_OUTPUT_MASK=0x7 NTC_SINGLE_MIP=1");
    CHECK(find("NTC_OUTPUT_MASK=0x8000") == FindDefines(index, network));
    // Dot products spare more than outputs.
    CHECK(find("NTC_DOT4_SPIRV=1 NTC_WIDE_WEIGHT_LOADS=1 NTC_OUTPUT_MASK=0x7") == "NTC_DOT4_SPIRV=1");
    CHECK(find("NTC_OUTPUT_MASK=0x1", "SHADOWS=1") == "NTC_OUTPUT_MASK=0x1 SHADOWS=1");
    CHECK(find("NTC_OUTPUT_MASK=0x3", "SHADOWS=1") == "none");
    CHECK(FindDefines(index, "NETWORK_VERSION=2 NTC_MATH=1") == "none");
    // HLSL that no compiler of shader model 6.4 has seen serves a device with dot products.
    CHECK(FindDefines(index, network + "NTC_DOT4_SM64=1 NTC_OUTPUT_MASK=0x3", "", ShaderLanguage::Hlsl) ==
          network + "NTC_OUTPUT_MASK=0x7");
    for (const ShaderKey& name : index) {
        if (name.source == "a.comp" && name.defines.find("SHADOWS") == std::string_view::npos) {
            CHECK(FindDefines(index, name.defines) == name.defines);
            CHECK(GetCoverCost(Read(name.defines), Read(name.defines)) < 1u << 16);
        }
    }
}

TEST_CASE("a scene that nothing covers: the error names what to compile") {
    const Index index = {{"a.comp", "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7"}};
    auto found = Find(index, "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0xF NTC_DOT4_SPIRV=1");
    REQUIRE_FALSE(found);
    CHECK(found.error().GetStatus() == Status::ShaderUnavailable);
    CHECK(std::string(found.error().GetText()) ==
          "shader: a.comp: none of 1 permutations covers the scene: add NETWORK_VERSION=1 NTC_MATH=1 "
          "NTC_DOT4_SPIRV=1 NTC_OUTPUT_MASK=0xF, or, for every scene, NETWORK_VERSION=1 NTC_MATH=1");
    found = Find(index, "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7", "SHADOWS=1");
    REQUIRE_FALSE(found);
    CHECK(std::string(found.error().GetText())
              .find("add NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 SHADOWS=1, or") !=
          std::string::npos);
    found = Find(index, "NETWORK_VERSION=1 NTC_MATH=6", "", "NTC_MATH=6 NTC_MATH=7");
    REQUIRE_FALSE(found);
    CHECK(std::string(found.error().GetText()).find("left out: cooperative vectors and matrices need") !=
          std::string::npos);
    found = Find({}, "NETWORK_VERSION=1");
    REQUIRE_FALSE(found);
    CHECK(std::string(found.error().GetText()).find("a.comp: no such source") != std::string::npos);
}
