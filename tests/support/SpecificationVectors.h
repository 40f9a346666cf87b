// SPDX-License-Identifier: MIT
// The two texture sets of the format specification's test vectors, made by the project's own generator and
// writer.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/inference/Synthesis.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace openntc_tests {

/// One of the two sets: what to synthesise, and CRC-32s that the specification gives.
struct SpecificationVector {
    const char* name;
    openntc::SynthesisDesc synthesis;
    std::uint32_t fileBytes;
    std::uint32_t fileCrc;
    std::uint32_t blobBytes;
    std::uint32_t blobCrc;
    std::uint32_t constantsCrc; ///< whole file as latent buffer (range offset 0), GenericInt8
    std::uint32_t weightsCrc;   ///< generic Int8 buffer
};

/// 24 x 20, 4 mips, small network, 2- and 4-bit latents.
inline SpecificationVector GetV1() {
    openntc::SynthesisDesc synthesis;
    synthesis.seed = 1;
    synthesis.desc = {24, 20, 4, 4};
    synthesis.networkVersion = NTC_NETWORK_SMALL;
    synthesis.shape = {4, 4, 8, 2, 4};
    return {"V1", synthesis, 15940, 0xefc1ffbc, 14008, 0xca7124cf, 0x10fdc566, 0x2c7b7511};
}

/// 40 x 64, 6 mips, large network, 4- and 8-bit latents.
inline SpecificationVector GetV2() {
    openntc::SynthesisDesc synthesis;
    synthesis.seed = 2;
    synthesis.desc = {40, 64, 4, 6};
    synthesis.networkVersion = NTC_NETWORK_LARGE;
    synthesis.shape = {2, 12, 16, 4, 8};
    return {"V2", synthesis, 25116, 0xc1fa848c, 22768, 0xa69fc2c0, 0xa13a0af0, 0x442613aa};
}

/// The bytes of a synthesised file. A description that cannot be synthesised is a bug of the test: it ends
/// the process.
inline std::vector<std::byte> MakeFile(const openntc::SynthesisDesc& synthesis) {
    openntc::MemoryStream stream;
    const auto written = openntc::SynthesizeTextureSet(stream, synthesis);
    if (!written) {
        std::fprintf(stderr, "MakeFile: %s\n", written.error().GetText());
        std::abort();
    }
    return {stream.GetBytes().begin(), stream.GetBytes().end()};
}

inline std::vector<std::byte> SynthesizeV1() {
    return MakeFile(GetV1().synthesis);
}
inline std::vector<std::byte> SynthesizeV2() {
    return MakeFile(GetV2().synthesis);
}

} // namespace openntc_tests
