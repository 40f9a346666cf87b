// SPDX-License-Identifier: MIT
// Golden files: small files that this version writes, kept so that later versions prove that they still read
// them. With OPENNTC_WRITE_GOLDEN=1 in the environment the files are made anew instead (for additions; never
// change old ones).
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

#include <string>

using namespace openntc;
using namespace openntc::container;
using namespace openntc::container::test;

namespace {

struct Golden {
    const char* name;
    Document document;
    std::vector<std::vector<std::byte>> data;
};

std::vector<std::byte> MakeBytes(std::size_t size, unsigned first) {
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i)
        bytes[i] = static_cast<std::byte>((first + 7 * i) & 0xFFu);
    return bytes;
}

void AddTexture(Document& document, std::string_view name, std::uint32_t first, std::uint32_t count) {
    TextureRecord texture;
    REQUIRE(texture.name.Assign(name));
    texture.firstChannel = first;
    texture.numChannels = count;
    REQUIRE(document.textures.PushBack(std::move(texture)));
}

Golden MakeMinimal() {
    Golden golden{"container_minimal.ntc", {}, {}};
    golden.document.width = 1;
    golden.document.height = 2;
    golden.document.numChannels = 3;
    return golden;
}

/// Every field of every object, with values that are all different from the defaults.
Golden MakeEveryField() {
    Golden golden{"container_every_field.ntc", {}, {}};
    Document& d = golden.document;
    d.width = 4294967295u;
    d.height = 8;
    d.numChannels = 6;
    d.numColorMips = 2;
    d.latentShape = LatentShapeRecord{4, 2, 8, 1};
    MlpLayer layer{
        48, 64, 0, 1, 2, MlpDataType::Int8, MlpDataType::Int32, MlpDataType::Float32, MlpDataType::Float16};
    MlpLayer other{64, 16, 2, std::nullopt, 1, std::nullopt, std::nullopt, std::nullopt, std::nullopt};
    Mlp& mlp = d.mlp.emplace();
    Fill(mlp.layers, {layer, other});
    mlp.activation = MlpActivation::HGELUClamp;
    mlp.weightLayout = MatrixLayout::ColumnMajor;
    mlp.weightType = MlpDataType::FloatE4M3;
    mlp.scaleBiasType = MlpDataType::FloatE5M2;
    REQUIRE(d.mlpVersions.Resize(2));
    Fill(d.mlpVersions[1].layers, {other});
    AddTexture(d, "base \"colour\" \\ \xC3\xA9\xE2\x82\xAC\n\x01", 0, 4);
    TextureRecord& texture = d.textures[0];
    texture.channelFormat = ChannelFormat::UINT32;
    texture.rgbColorSpace = ColorSpace::sRGB;
    texture.alphaColorSpace = ColorSpace::HLG;
    texture.bcFormat = BlockCompressedFormat::BC7;
    texture.bcQuality = 254;
    texture.bcAccelerationDataView = 3;
    AddTexture(d, "", 5, 1);
    Fill(d.channels,
         {ChannelRecord{0.1f, -0.25f, ColorSpace::HLG}, ChannelRecord{}, ChannelRecord{1.0f, {}, {}}});
    Fill(d.latents, {LatentImageRecord{2, 3, 4, 5, 8, 7, 2, 3}, LatentImageRecord{0, 1, 2, 3, 4, 5, 1, 0}});
    Fill(d.colorMips, {ColorMipRecord{8, 9, 1, 1.0f / 3.0f, 1e-30f}, ColorMipRecord{}});
    golden.data = {MakeBytes(5, 1), MakeBytes(0, 0), MakeBytes(4, 90), MakeBytes(31, 200)};
    REQUIRE(d.views.Resize(4));
    d.views[0].compression = Compression::None;
    d.views[0].uncompressedSize = 18446744073709551615u;
    return golden;
}

/// The way LibNTC 0.5 puts it: types on the network, Float32 biases, scale and bias of channels.
Golden MakeLegacy() {
    Golden golden{"container_legacy_0_5.ntc", {}, {}};
    Document& d = golden.document;
    d.width = 16;
    d.height = 8;
    d.numChannels = 2;
    d.latentShape = LatentShapeRecord{4, 2, 8, 4};
    Mlp& mlp = d.mlp.emplace();
    for (std::uint32_t i = 0; i < 4; ++i)
        REQUIRE(
            mlp.layers.PushBack(MlpLayer{i == 0 ? 48u : 64u, i == 3 ? 16u : 64u, 3 * i, 3 * i + 1, 3 * i + 2,
                                         std::nullopt, std::nullopt, std::nullopt, std::nullopt}));
    mlp.activation = MlpActivation::HGELUClamp;
    mlp.weightLayout = MatrixLayout::RowMajor;
    mlp.weightType = MlpDataType::Int8;
    mlp.scaleBiasType = MlpDataType::Float32;
    AddTexture(d, "Occlusion", 0, 2);
    d.textures[0].channelFormat = ChannelFormat::UNORM8;
    Fill(d.channels,
         {ChannelRecord{0.71392822265625f, 0.078125f, ColorSpace::sRGB}, ChannelRecord{1.0f, 0.0f, {}}});
    Fill(d.latents, {LatentImageRecord{4, 2, 2, 1, 8, 32, 12, 13}});
    Fill(d.colorMips, {ColorMipRecord{16, 8, 0, 0.0f, 1.0f}});
    for (std::size_t i = 0; i < 14; ++i)
        golden.data.push_back(MakeBytes(4 + i, static_cast<unsigned>(11 * i)));
    return golden;
}

std::vector<std::span<const std::byte>> ViewsOf(const Golden& golden) {
    return {golden.data.begin(), golden.data.end()};
}

} // namespace

TEST_CASE("golden files: read as the document they were written from, and written again byte for byte") {
    for (Golden (*const make)() : {&MakeMinimal, &MakeEveryField, &MakeLegacy}) {
        Golden golden = make();
        CAPTURE(golden.name);
        const std::vector<std::span<const std::byte>> views = ViewsOf(golden);
        REQUIRE(LayOutViews(golden.document, views));
        const std::filesystem::path path =
            std::filesystem::path(OPENNTC_TEST_DATA_DIR) / "golden" / golden.name;
        if (std::getenv("OPENNTC_WRITE_GOLDEN") != nullptr)
            REQUIRE(WriteContainerFile(path, {&golden.document, views}));
        const std::string file = ReadWholeFile(path);
        REQUIRE_FALSE(file.empty());
        const Expected<Container> container = ReadBytes(file);
        REQUIRE_MESSAGE(container, std::string(container.error().GetText()));
        CHECK(FormatToString(container->document) == FormatToString(golden.document));
        for (std::size_t i = 0; i < golden.data.size(); ++i) {
            const BufferView& view = container->document.views[i];
            const auto stored = std::as_bytes(std::span(file)).subspan(container->binaryOffset + view.offset);
            CHECK(std::equal(golden.data[i].begin(), golden.data[i].end(), stored.begin()));
        }
        MemoryStream stream;
        REQUIRE(WriteContainer(stream, {&container->document, views}));
        const std::span<const std::byte> again = stream.GetBytes();
        CHECK(std::string(reinterpret_cast<const char*>(again.data()), again.size()) == file);
    }
}

TEST_CASE("golden file of every field: its members, one by one") {
    const Expected<Container> container = ReadBytes(
        ReadWholeFile(std::filesystem::path(OPENNTC_TEST_DATA_DIR) / "golden" / "container_every_field.ntc"));
    REQUIRE(container);
    const Document& d = container->document;
    CHECK(d.width == 4294967295u);
    CHECK(d.numColorMips == 2);
    CHECK(d.latentShape->highResFeatures == 4);
    CHECK(d.latentShape->highResQuantBits == 2);
    CHECK(d.latentShape->lowResFeatures == 8);
    CHECK(d.latentShape->lowResQuantBits == 1);
    REQUIRE(d.mlp->layers.size() == 2);
    CHECK(d.mlp->layers[0].scaleView == 1);
    CHECK(d.mlp->layers[0].biasView == 2);
    CHECK(d.mlp->layers[0].scaleBiasType == MlpDataType::Int32);
    CHECK(d.mlp->layers[0].scaleType == MlpDataType::Float32);
    CHECK(d.mlp->layers[0].biasType == MlpDataType::Float16);
    CHECK_FALSE(d.mlp->layers[1].scaleView);
    CHECK_FALSE(d.mlp->layers[1].weightType);
    CHECK(d.mlp->weightLayout == MatrixLayout::ColumnMajor);
    CHECK(d.mlp->scaleBiasType == MlpDataType::FloatE5M2);
    REQUIRE(d.mlpVersions.size() == 2);
    CHECK(d.mlpVersions[0].layers.empty());
    CHECK(d.mlpVersions[1].layers.size() == 1);
    REQUIRE(d.textures.size() == 2);
    CHECK(d.textures[0].name.View() == "base \"colour\" \\ \xC3\xA9\xE2\x82\xAC\n\x01");
    CHECK(d.textures[0].bcQuality == 254);
    CHECK(d.textures[0].bcAccelerationDataView == 3);
    CHECK(d.textures[1].firstChannel == 5);
    REQUIRE(d.channels.size() == 3);
    CHECK(d.channels[0].scale == 0.1f);
    CHECK(d.channels[0].bias == -0.25f);
    CHECK_FALSE(d.channels[1].scale);
    CHECK(d.latents[0].lowResBitsPerPixel == 7);
    CHECK(d.latents[1].highResView == 1);
    CHECK(d.colorMips[0].positionScale == 1e-30f);
    CHECK_FALSE(d.colorMips[1].latentMip);
    CHECK(d.views[0].compression == Compression::None);
    CHECK(d.views[0].uncompressedSize == 18446744073709551615u);
    CHECK(d.views[3].offset == 12);
    CHECK(d.views[3].storedSize == 31);
}
