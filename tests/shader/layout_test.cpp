// SPDX-License-Identifier: MIT
// The constant buffer that every compiled permutation reads has the byte offsets of the C++ struct.
#include "shader/ConstantFields.h"
#include "shader/SpirvLayout.h"

#include "openntc/InferenceConstants.h"
#include "openntc/passes/PassConstants.h"

#include "decode_shaders.h"
#include "function_shaders.h"
#include "hlsl_shaders.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc_tests;

namespace {

template <typename ShaderList>
int CheckPermutations(const ShaderList& shaders) {
    const Fields expected = GetCppFields();
    REQUIRE(expected.size() * 4 == sizeof(NtcTextureSetConstants)); // every word has a name
    int checked = 0;
    for (const auto& item : shaders) {
        CAPTURE(std::string(item.defines));
        const openntc_tests::SpirvLayout layout(item.words);
        const auto* members = layout.FindStruct("NtcTextureSetConstants");
        REQUIRE(members != nullptr);
        Fields fields;
        layout.Flatten(*members, "", 0, fields);
        CHECK(fields == expected);
        ++checked;
    }
    return checked;
}

} // namespace

TEST_CASE("constant buffer of every permutation: the offsets of C++") {
    // 6 networks, 5 maths modes, 2 forms of the dot product.
    CHECK(CheckPermutations(decode_shaders::GetShaders()) == 6 * 5 * 2);
    CHECK(CheckPermutations(function_shaders::GetShaders()) == 2);
}

namespace {

/// In GLSL a member of the block, in HLSL the block itself.
template <typename ShaderList>
int CheckPushConstants(const ShaderList& shaders, const std::string& prefix, const Fields& expected) {
    int checked = 0;
    for (const auto& item : shaders) {
        CAPTURE(std::string(item.defines));
        const openntc_tests::SpirvLayout layout(item.words);
        const auto* members = layout.FindPushConstants();
        REQUIRE(members != nullptr);
        Fields fields, named;
        layout.Flatten(*members, "", 0, fields);
        for (const auto& [name, offset] : expected)
            named[prefix + name] = offset;
        CHECK(fields == named);
        ++checked;
    }
    return checked;
}

} // namespace

TEST_CASE("push constants of DecodeTexels, GLSL and HLSL: the offsets of C++") {
    const Fields expected = {
        {"left", offsetof(NtcDecodeTexelsConstants, left)},
        {"top", offsetof(NtcDecodeTexelsConstants, top)},
        {"width", offsetof(NtcDecodeTexelsConstants, width)},
        {"height", offsetof(NtcDecodeTexelsConstants, height)},
        {"mipLevel", offsetof(NtcDecodeTexelsConstants, mipLevel)},
        {"convertToLinear", offsetof(NtcDecodeTexelsConstants, convertToLinear)},
    };
    REQUIRE(expected.size() * 4 == sizeof(NtcDecodeTexelsConstants)); // every word has a name
    CHECK(CheckPushConstants(decode_shaders::GetShaders(), "gPush.", expected) == 6 * 5 * 2);
    CHECK(CheckPushConstants(hlsl_shaders::GetShaders(), "", expected) > 0);
}
