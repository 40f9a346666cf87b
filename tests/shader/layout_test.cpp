// SPDX-License-Identifier: MIT
// The constant buffer that every compiled permutation reads has the byte offsets of the C++ struct.
#include "shader/SpirvLayout.h"

#include "openntc/InferenceConstants.h"

#include "decode_shaders.h"
#include "function_shaders.h"

#include <doctest/doctest.h>

using namespace openntc;

namespace {

using Fields = std::map<std::string, std::uint32_t>;

#define ADD_FIELD(fields, prefix, base, type, member)                                                        \
    (fields)[(prefix) + #member] = static_cast<std::uint32_t>((base) + offsetof(type, member))

void AddEncoding(Fields& fields, const std::string& prefix, std::size_t base) {
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, numFeatures);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, quantBits);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, logElementsPerUint);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, padding0);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, addressMask);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, dataMask);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, quantizedScale);
    ADD_FIELD(fields, prefix, base, NtcLatentEncodingConstants, quantizedBias);
}

void AddNeuralMips(Fields& fields, const std::string& name, std::size_t base) {
    for (std::size_t i = 0; i < NTC_MAX_NEURAL_MIPS; ++i) {
        const std::string prefix = name + "[" + std::to_string(i) + "].";
        const std::size_t at = base + i * sizeof(NtcNeuralMipConstants);
        ADD_FIELD(fields, prefix, at, NtcNeuralMipConstants, dataOffset);
        ADD_FIELD(fields, prefix, at, NtcNeuralMipConstants, imageWidthHeight);
        ADD_FIELD(fields, prefix, at, NtcNeuralMipConstants, sliceLeftTop);
        ADD_FIELD(fields, prefix, at, NtcNeuralMipConstants, sliceWidthHeight);
    }
}

Fields GetCppFields() {
    Fields fields;
    AddEncoding(fields, "highResEncoding.", offsetof(NtcTextureSetConstants, highResEncoding));
    AddEncoding(fields, "lowResEncoding.", offsetof(NtcTextureSetConstants, lowResEncoding));
    AddNeuralMips(fields, "highResNeuralMips", offsetof(NtcTextureSetConstants, highResNeuralMips));
    AddNeuralMips(fields, "lowResNeuralMips", offsetof(NtcTextureSetConstants, lowResNeuralMips));
    for (std::size_t i = 0; i < NTC_MAX_MIPS; ++i) {
        const std::string prefix = "colorMips[" + std::to_string(i) + "].";
        const std::size_t at = offsetof(NtcTextureSetConstants, colorMips) + i * sizeof(NtcColorMipConstants);
        ADD_FIELD(fields, prefix, at, NtcColorMipConstants, neuralMip);
        ADD_FIELD(fields, prefix, at, NtcColorMipConstants, positionLod);
        ADD_FIELD(fields, prefix, at, NtcColorMipConstants, positionScale);
        ADD_FIELD(fields, prefix, at, NtcColorMipConstants, padding0);
    }
    const std::string none;
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, networkWeightOffset0);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, networkWeightOffset1);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, networkWeightOffset2);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, networkWeightOffset3);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, imageWidth);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, imageHeight);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, imageMips);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, networkScaleBiasOffset);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, validChannelMask);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, channelColorSpaces);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, padding0);
    ADD_FIELD(fields, none, 0, NtcTextureSetConstants, padding1);
    return fields;
}

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
    // 4 networks, 5 maths modes, 2 forms of the dot product.
    CHECK(CheckPermutations(decode_shaders::GetShaders()) == 4 * 5 * 2);
    CHECK(CheckPermutations(function_shaders::GetShaders()) == 2);
}
