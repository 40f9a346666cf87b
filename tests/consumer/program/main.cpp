// SPDX-License-Identifier: MIT
// What every consumer project builds: loads the set V1 of the format specification (argument 1) and decodes
// one texel. A second translation unit includes the same headers.
#include <openntc/core/FileStream.h>
#include <openntc/decode/ReferenceDecoder.h>
#include <openntc/openntc.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>

int CountMipsInOtherTranslationUnit(const openntc::TextureSetMetadata& metadata);

namespace {

// Texel (13, 7) of mip 0 of V1, float epilogue, as printed in the format specification.
constexpr std::array<std::uint32_t, 16> kExpected = {
    0x3ec6dc00, 0xbce30400, 0x3eb4f0a0, 0xbc7ed400, 0x3e106800, 0xbf77f220, 0x3f6cfa60, 0x3e2cc740,
    0xbe586980, 0x3ec32c40, 0xbf44d880, 0xbf6ec1d0, 0x3fb7e3a0, 0xbe332180, 0xbf1dfe00, 0xbd6fd600};

openntc::Expected<int> CountWrongOutputs(const char* path) {
    OPENNTC_ASSIGN(openntc::FileReader file, openntc::FileReader::Open(path));
    OPENNTC_ASSIGN(openntc::TextureSetMetadata metadata, openntc::TextureSetMetadata::Load(file));
    const int mips = CountMipsInOtherTranslationUnit(metadata);
    OPENNTC_ASSIGN(const openntc::StreamRange range, metadata.GetStreamRangeForLatents(0, mips));
    const auto weightType = openntc::InferenceWeightType::GenericInt8;
    OPENNTC_ASSIGN(const openntc::NtcTextureSetConstants constants,
                   openntc::MakeInferenceData(metadata, range, weightType));
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, metadata.GetInferenceWeights(weightType));

    openntc::Array<std::byte> latents;
    OPENNTC_CHECK(latents.Resize(static_cast<std::size_t>(range.size)));
    if (!file.Seek(range.offset) || !file.Read(latents.data(), latents.size()))
        return openntc::Fail(openntc::Status::IOError, "latents: cannot be read");

    const openntc::DecodeSource source{&constants, latents.AsSpan(), weights, metadata.GetNetworkVersion()};
    std::array<float, 16> outputs{};
    OPENNTC_CHECK(openntc::DecodeReference(source, 0, {13, 7, 1, 1}, {}, outputs));
    int wrong = 0;
    for (std::size_t i = 0; i < outputs.size(); ++i)
        wrong += std::bit_cast<std::uint32_t>(outputs[i]) != kExpected[i] ? 1 : 0;
    return wrong;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2)
        return 2;
    const openntc::Expected<int> wrong = CountWrongOutputs(argv[1]);
    if (!wrong) {
        std::fprintf(stderr, "%s: %s\n", argv[1], wrong.error().GetText());
        return 1;
    }
    std::printf("%d of 16 outputs differ from the specification\n", *wrong);
    return *wrong == 0 ? 0 : 1;
}
