// SPDX-License-Identifier: MIT
// Read, write, read gives an equal set.
#include "EditedFile.h"
#include "RewrittenFile.h"
#include "conformance/ConformanceFolder.h"

#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

bool AreEqual(std::span<const std::byte> a, std::span<const std::byte> b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
}

void CheckGridsEqual(const LatentGrid& a, const std::vector<std::byte>& fileA, const LatentGrid& b,
                     const std::vector<std::byte>& fileB) {
    CHECK(a.width == b.width);
    CHECK(a.height == b.height);
    CHECK(AreEqual(std::span(fileA).subspan(a.offset, a.size), std::span(fileB).subspan(b.offset, b.size)));
}

void CheckSetsEqual(const std::vector<std::byte>& fileA, const std::vector<std::byte>& fileB) {
    ReadOnlyMemoryStream streamA(fileA);
    ReadOnlyMemoryStream streamB(fileB);
    const auto a = TextureSetMetadata::Load(streamA);
    const auto b = TextureSetMetadata::Load(streamB);
    REQUIRE(a);
    REQUIRE_MESSAGE(b, std::string(b.error().GetText()));
    TextureSetDesc desc = a->GetDesc();
    desc.channels += desc.channels % 2;
    CHECK(b->GetDesc() == desc);
    CHECK(b->GetLatentShape() == a->GetLatentShape());
    CHECK(b->GetNetworkVersion() == a->GetNetworkVersion());
    CHECK(b->GetValidChannelMask() == a->GetValidChannelMask());
    CHECK(b->GetWeights().channelColorSpaces == a->GetWeights().channelColorSpaces);
    CHECK(AreEqual(b->GetWeights().int8.AsSpan(), a->GetWeights().int8.AsSpan()));
    CHECK(AreEqual(b->GetWeights().fp8.AsSpan(), a->GetWeights().fp8.AsSpan()));
    REQUIRE(b->GetTextures().size() == a->GetTextures().size());
    for (std::size_t i = 0; i < a->GetTextures().size(); ++i) {
        const Texture& x = a->GetTextures()[i];
        const Texture& y = b->GetTextures()[i];
        CHECK(x.name == y.name);
        CHECK(x.firstChannel == y.firstChannel);
        CHECK(x.numChannels == y.numChannels);
        CHECK(x.channelFormat == y.channelFormat);
        CHECK(x.rgbColorSpace == y.rgbColorSpace);
        CHECK(x.alphaColorSpace == y.alphaColorSpace);
        CHECK(x.bcFormat == y.bcFormat);
        CHECK(x.bcQuality == y.bcQuality);
        CHECK(AreEqual(std::as_bytes(x.bcModes), std::as_bytes(y.bcModes)));
    }
    REQUIRE(b->GetLatentImages().size() == a->GetLatentImages().size());
    for (std::size_t i = 0; i < a->GetLatentImages().size(); ++i) {
        CheckGridsEqual(a->GetLatentImages()[i].highRes, fileA, b->GetLatentImages()[i].highRes, fileB);
        CheckGridsEqual(a->GetLatentImages()[i].lowRes, fileA, b->GetLatentImages()[i].lowRes, fileB);
    }
    for (std::size_t i = 0; i < a->GetColorMips().size(); ++i) {
        CHECK(a->GetColorMips()[i].neuralMip == b->GetColorMips()[i].neuralMip);
        CHECK(a->GetColorMips()[i].positionLod == b->GetColorMips()[i].positionLod);
        CHECK(a->GetColorMips()[i].positionScale == b->GetColorMips()[i].positionScale);
    }
}

} // namespace

TEST_CASE("V1, V2, FP8, odd and textured sets survive writing; writing again gives the same bytes") {
    SynthesisDesc fp8 = GetV2().synthesis;
    fp8.withFP8 = true;
    fp8.channelColorSpaces = 0x94; // Linear, sRGB, sRGB, HLG
    const BlockCompressionMode modes[] = {{6, 0, 65535}};
    Texture texture;
    texture.name = "Größe";
    texture.firstChannel = 1;
    texture.numChannels = 2;
    texture.channelFormat = ChannelFormat::FLOAT16;
    texture.rgbColorSpace = ColorSpace::sRGB;
    texture.alphaColorSpace = ColorSpace::HLG;
    texture.bcFormat = BlockCompressedFormat::BC7;
    texture.bcQuality = 7;
    texture.bcModes = modes;
    fp8.textures = {&texture, 1};
    // Every channel of a set of 16 has its own colour space, the last one too.
    SynthesisDesc spaces = GetV2().synthesis;
    spaces.desc.channels = 16;
    spaces.channelColorSpaces = 0xA4924924u; // HLG in the highest two bits
    const std::vector<std::byte> odd = EditV1()
                                           .Replace("\"numChannels\":4,", "\"numChannels\":3,")
                                           .Replace("{},{},{},{}", "{},{},{}")
                                           .Build();
    for (const std::vector<std::byte>& file :
         {SynthesizeV1(), SynthesizeV2(), MakeFile(fp8), MakeFile(spaces), odd}) {
        const std::vector<std::byte> written = Rewrite(file);
        CheckSetsEqual(file, written);
        CHECK(Rewrite(written) == written);
    }
    // Against the numbers themselves: both files above are the writer's.
    const std::vector<std::byte> written = Rewrite(MakeFile(spaces));
    ReadOnlyMemoryStream stream(written);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    for (int c = 0; c < 16; ++c) {
        CAPTURE(c);
        CHECK(static_cast<std::uint32_t>(set->GetChannelStorageColorSpace(c)) ==
              (spaces.channelColorSpaces >> (2 * c) & 3u));
    }
}

TEST_CASE("every generation-1 conformance set survives writing") {
    const std::vector<std::string> names = ListGeneration1Sets();
    if (names.empty())
        MESSAGE("SKIP: no conformance vectors: set OPENNTC_SHARED_DIR");
    for (const std::string& name : names) {
        CAPTURE(name);
        const std::vector<std::byte> file = ReadBytes(GetConformanceFolder() / (name + ".ntc"));
        const std::vector<std::byte> written = Rewrite(file);
        CheckSetsEqual(file, written);
        // What LibNTC 0.7.2 wrote comes out as it went in, byte for byte; 0.5 files take the newer form.
        if (!name.starts_with("v050"))
            CHECK(written == file);
    }
}
