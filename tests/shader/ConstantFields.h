// SPDX-License-Identifier: MIT
// The byte offsets that C++ gives the fields of NtcTextureSetConstants, by the names that SPIR-V has for them.
#pragma once

#include "openntc/InferenceConstants.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace openntc_tests {

using Fields = std::map<std::string, std::uint32_t>;

#define ADD_FIELD(fields, prefix, base, type, member)                                                        \
    (fields)[(prefix) + #member] = static_cast<std::uint32_t>((base) + offsetof(type, member))

inline void AddEncoding(Fields& fields, const std::string& prefix, std::size_t base) {
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, numFeatures);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, quantBits);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, logElementsPerUint);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, padding0);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, addressMask);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, dataMask);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, quantizedScale);
    ADD_FIELD(fields, prefix, base, openntc::NtcLatentEncodingConstants, quantizedBias);
}

inline void AddNeuralMips(Fields& fields, const std::string& name, std::size_t base) {
    for (std::size_t i = 0; i < NTC_MAX_NEURAL_MIPS; ++i) {
        const std::string prefix = name + "[" + std::to_string(i) + "].";
        const std::size_t at = base + i * sizeof(openntc::NtcNeuralMipConstants);
        ADD_FIELD(fields, prefix, at, openntc::NtcNeuralMipConstants, dataOffset);
        ADD_FIELD(fields, prefix, at, openntc::NtcNeuralMipConstants, imageWidthHeight);
        ADD_FIELD(fields, prefix, at, openntc::NtcNeuralMipConstants, sliceLeftTop);
        ADD_FIELD(fields, prefix, at, openntc::NtcNeuralMipConstants, sliceWidthHeight);
    }
}

/// Every scalar of the struct.
inline Fields GetCppFields() {
    Fields fields;
    AddEncoding(fields, "highResEncoding.", offsetof(openntc::NtcTextureSetConstants, highResEncoding));
    AddEncoding(fields, "lowResEncoding.", offsetof(openntc::NtcTextureSetConstants, lowResEncoding));
    AddNeuralMips(fields, "highResNeuralMips", offsetof(openntc::NtcTextureSetConstants, highResNeuralMips));
    AddNeuralMips(fields, "lowResNeuralMips", offsetof(openntc::NtcTextureSetConstants, lowResNeuralMips));
    for (std::size_t i = 0; i < NTC_MAX_MIPS; ++i) {
        const std::string prefix = "colorMips[" + std::to_string(i) + "].";
        const std::size_t at =
            offsetof(openntc::NtcTextureSetConstants, colorMips) + i * sizeof(openntc::NtcColorMipConstants);
        ADD_FIELD(fields, prefix, at, openntc::NtcColorMipConstants, neuralMip);
        ADD_FIELD(fields, prefix, at, openntc::NtcColorMipConstants, positionLod);
        ADD_FIELD(fields, prefix, at, openntc::NtcColorMipConstants, positionScale);
        ADD_FIELD(fields, prefix, at, openntc::NtcColorMipConstants, padding0);
    }
    const std::string none;
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, networkWeightOffset0);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, networkWeightOffset1);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, networkWeightOffset2);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, networkWeightOffset3);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, imageWidth);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, imageHeight);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, imageMips);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, networkScaleBiasOffset);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, validChannelMask);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, channelColorSpaces);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, padding0);
    ADD_FIELD(fields, none, 0, openntc::NtcTextureSetConstants, padding1);
    return fields;
}

#undef ADD_FIELD

} // namespace openntc_tests
