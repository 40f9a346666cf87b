// SPDX-License-Identifier: MIT
// The writer: exact text of every kind of field, the format specification's vector V1, layout, and refusals.
#include "openntc/core/Crc32.h"
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>

using namespace openntc;
using namespace openntc::container;
using namespace openntc::container::test;

namespace {

std::string WriteLod(float value) {
    Document document;
    ColorMipRecord mip;
    mip.positionLod = value;
    Fill(document.colorMips, {mip});
    std::string text = FormatToString(document);
    const std::string_view before = "\"positionLod\":";
    const std::size_t at = text.find(before);
    if (at == std::string::npos)
        return text;
    return text.substr(at + before.size(), text.find('}', at) - at - before.size());
}

std::string WriteName(std::string_view name) {
    Document document;
    TextureRecord texture;
    (void)texture.name.Assign(name);
    (void)document.textures.PushBack(std::move(texture));
    const std::string text = FormatToString(document);
    const std::size_t at = text.find("\"name\":");
    return at == std::string::npos ? text : text.substr(at + 7, text.find(",\"firstChannel\"") - at - 7);
}

/// The document of vector V1 of the format specification.
Document MakeV1() {
    Document document;
    document.width = 24;
    document.height = 20;
    document.numChannels = 4;
    document.numColorMips = 4;
    document.latentShape = LatentShapeRecord{4, 2, 8, 4};
    Mlp& mlp = document.mlp.emplace();
    Fill(mlp.layers,
         {MakeLayer(48, 64, 0), MakeLayer(64, 64, 3), MakeLayer(64, 64, 6), MakeLayer(64, 16, 9)});
    mlp.activation = MlpActivation::HGELUClamp;
    mlp.weightLayout = MatrixLayout::RowMajor;
    TextureRecord texture;
    (void)texture.name.Assign("t");
    texture.numChannels = 4;
    (void)document.textures.PushBack(std::move(texture));
    (void)document.channels.Resize(4);
    Fill(document.latents, {LatentImageRecord{6, 5, 3, 2, 8, 32, 12, 13}});
    for (std::uint32_t mip = 0; mip < 4; ++mip)
        (void)document.colorMips.PushBack(ColorMipRecord{
            24u >> mip, 20u >> mip, 0u, static_cast<float>(mip) / 3.0f, static_cast<float>(1u << mip)});
    return document;
}

constexpr std::size_t kV1Sizes[14] = {3072, 256, 256, 4096, 256, 256, 4096, 256, 256, 1024, 64, 64, 32, 24};

} // namespace

TEST_CASE("json text: the vector V1 of the format specification, byte for byte") {
    Document document = MakeV1();
    const std::vector<std::byte> zeros(4096);
    std::vector<std::span<const std::byte>> views;
    for (const std::size_t size : kV1Sizes)
        views.push_back(std::span(zeros).first(size));
    REQUIRE(LayOutViews(document, views));
    const std::string expected =
        R"({"schemaVersion":1,"width":24,"height":20,"numChannels":4,"numColorMips":4,"latentShape":{"highResFeatures":4,"highResQuantBits":2,"lowResFeatures":8,"lowResQuantBits":4},"mlp":{"layers":[{"inputChannels":48,"outputChannels":64,"weightView":0,"scaleView":1,"biasView":2,"weightType":"Int8","scaleType":"Float32","biasType":"Int32"},{"inputChannels":64,"outputChannels":64,"weightView":3,"scaleView":4,"biasView":5,"weightType":"Int8","scaleType":"Float32","biasType":"Int32"},{"inputChannels":64,"outputChannels":64,"weightView":6,"scaleView":7,"biasView":8,"weightType":"Int8","scaleType":"Float32","biasType":"Int32"},{"inputChannels":64,"outputChannels":16,"weightView":9,"scaleView":10,"biasView":11,"weightType":"Int8","scaleType":"Float32","biasType":"Int32"}],"activation":"HGELUClamp","weightLayout":"RowMajor"},"textures":[{"name":"t","firstChannel":0,"numChannels":4}],"channels":[{},{},{},{}],"latents":[{"highResWidth":6,"highResHeight":5,"lowResWidth":3,"lowResHeight":2,"highResBitsPerPixel":8,"lowResBitsPerPixel":32,"highResView":12,"lowResView":13}],"colorMips":[{"width":24,"height":20,"latentMip":0,"positionLod":0.0,"positionScale":1.0},{"width":12,"height":10,"latentMip":0,"positionLod":0.3333333432674408,"positionScale":2.0},{"width":6,"height":5,"latentMip":0,"positionLod":0.6666666865348816,"positionScale":4.0},{"width":3,"height":2,"latentMip":0,"positionLod":1.0,"positionScale":8.0}],"views":[{"offset":0,"storedSize":3072},{"offset":3072,"storedSize":256},{"offset":3328,"storedSize":256},{"offset":3584,"storedSize":4096},{"offset":7680,"storedSize":256},{"offset":7936,"storedSize":256},{"offset":8192,"storedSize":4096},{"offset":12288,"storedSize":256},{"offset":12544,"storedSize":256},{"offset":12800,"storedSize":1024},{"offset":13824,"storedSize":64},{"offset":13888,"storedSize":64},{"offset":13952,"storedSize":32},{"offset":13984,"storedSize":24}]})";
    CHECK(expected.size() == 1891);
    CHECK(FormatToString(document) == expected);
}

TEST_CASE("writer: the complete V1 file has the size and CRC-32 that the format specification states") {
    // The generator of the specification: an LCG whose high half gives weights, scales, biases and latent
    // codes.
    std::uint32_t state = 1;
    const auto next = [&state] {
        state = state * 1664525u + 1013904223u;
        return state >> 16;
    };
    std::vector<std::vector<std::byte>> blobs;
    const auto append = [](std::vector<std::byte>& blob, std::uint32_t value, int bytes) {
        for (int i = 0; i < bytes; ++i)
            blob.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xFFu));
    };
    const std::size_t inputs[] = {48, 64, 64, 64};
    const std::size_t outputs[] = {64, 64, 64, 16};
    for (std::size_t layer = 0; layer < 4; ++layer) {
        std::vector<std::byte> weights, scales, biases;
        std::vector<std::int32_t> sums(outputs[layer], 0);
        for (std::size_t row = 0; row < outputs[layer]; ++row) {
            for (std::size_t column = 0; column < inputs[layer]; ++column) {
                const std::int32_t weight = static_cast<std::int32_t>(next() % 255u) - 127;
                sums[row] += weight;
                append(weights, static_cast<std::uint32_t>(weight), 1);
            }
        }
        for (std::size_t row = 0; row < outputs[layer]; ++row)
            append(scales, std::bit_cast<std::uint32_t>(static_cast<float>(1u + next() % 64u) * 0x1p-20f), 4);
        for (std::size_t row = 0; row < outputs[layer]; ++row)
            append(biases,
                   static_cast<std::uint32_t>(static_cast<std::int32_t>(next() % 8192u) - 4096 +
                                              (layer > 0 ? 113 * sums[row] : 0)),
                   4);
        blobs.push_back(std::move(weights));
        blobs.push_back(std::move(scales));
        blobs.push_back(std::move(biases));
    }
    // Latent codes in element order, packed from the lowest bit on: 2 bits (6 x 5 x 4), then 4 bits (3 x 2 x
    // 8).
    for (const auto& [codes, bits] : {std::pair{120u, 2u}, std::pair{48u, 4u}}) {
        std::vector<std::byte> blob((codes * bits + 7) / 8);
        for (std::uint32_t i = 0; i < codes; ++i)
            blob[i * bits / 8] |= static_cast<std::byte>((next() & ((1u << bits) - 1u)) << (i * bits % 8));
        // The specification's blob pads each view to 4 bytes, and its JSON counts the padding of the first
        // grid.
        blob.resize((blob.size() + 3) & ~std::size_t{3});
        blobs.push_back(std::move(blob));
    }
    std::vector<std::span<const std::byte>> views(blobs.begin(), blobs.end());
    Document document = MakeV1();
    REQUIRE(LayOutViews(document, views));
    MemoryStream stream;
    REQUIRE(WriteContainer(stream, {&document, views}));
    CHECK(stream.GetBytes().size() == 15940);
    CHECK(Crc32(stream.GetBytes().subspan(1932)) == 0xca7124cfu);
    CHECK(Crc32(stream.GetBytes()) == 0xefc1ffbcu);
}

TEST_CASE("json text: reals are the shortest decimal of the widened value, in the notation of the format's "
          "writer") {
    CHECK(WriteLod(0.0f) == "0.0");
    CHECK(WriteLod(-0.0f) == "-0.0");
    CHECK(WriteLod(1.0f) == "1.0");
    CHECK(WriteLod(-12.5f) == "-12.5");
    CHECK(WriteLod(1.0f / 3.0f) == "0.3333333432674408");
    CHECK(WriteLod(0.1f) == "0.10000000149011612");
    CHECK(WriteLod(1024.0f) == "1024.0");
    CHECK(WriteLod(0x1p-20f) == "9.5367431640625e-7");
    CHECK(WriteLod(0x1p-19f) == "0.0000019073486328125");
    CHECK(WriteLod(1e20f) == "100000002004087730000.0");
    CHECK(WriteLod(1e21f) == "1.0000000200408773e21");
    CHECK(WriteLod(std::numeric_limits<float>::max()) == "3.4028234663852886e38");
    CHECK(WriteLod(0x1p100f) == "1.2676506002282294e30");
    CHECK(WriteLod(std::numeric_limits<float>::denorm_min()) == "1.401298464324817e-45");
    CHECK(WriteLod(std::numeric_limits<float>::quiet_NaN()) ==
          "ERROR colorMips[0].positionLod: nan: must be finite");
    CHECK(WriteLod(-std::numeric_limits<float>::infinity()) ==
          "ERROR colorMips[0].positionLod: infinite: must be finite");
}

TEST_CASE("json text: every real that is written is read back with the same bits") {
    std::uint32_t state = 12345;
    for (int i = 0; i < 20000; ++i) {
        state = state * 1664525u + 1013904223u;
        const float value = std::bit_cast<float>(state ^ (state >> 15));
        if (!std::isfinite(value))
            continue;
        float again = 0.0f;
        const std::string text = WriteLod(value);
        REQUIRE(container::detail::ParseReal(text, again));
        REQUIRE(std::bit_cast<std::uint32_t>(again) == std::bit_cast<std::uint32_t>(value));
    }
}

TEST_CASE("json text: names are escaped as JSON asks and stay UTF-8 otherwise") {
    CHECK(WriteName("a/b") == "\"a/b\"");
    CHECK(WriteName("q\"b\\c") == R"("q\"b\\c")");
    CHECK(WriteName("\b\t\n\f\r\x01\x1F\x7F") == "\"\\b\\t\\n\\f\\r\\u0001\\u001F\x7F\"");
    CHECK(WriteName(std::string_view("\0", 1)) == R"("\u0000")");
    CHECK(WriteName("\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80") == "\"\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80\"");
    CHECK(WriteName("\xC3") == "ERROR textures[0].name: bytes that are not UTF-8: cannot be written");
}

TEST_CASE("writer: padding of views and gap, and zero-sized views") {
    Document document;
    document.width = document.height = document.numChannels = 1;
    const std::byte five[5] = {std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}};
    const std::span<const std::byte> views[] = {
        std::span(five), {}, std::span(five).first(4), std::span(five).first(1)};
    REQUIRE(LayOutViews(document, views));
    MemoryStream stream;
    REQUIRE(WriteContainer(stream, {&document, views}));
    const std::string json = FormatToString(document);
    const std::string bytes(reinterpret_cast<const char*>(stream.GetBytes().data()),
                            stream.GetBytes().size());
    const std::size_t chunk = (40 + json.size() + 1 + 3) / 4 * 4;
    REQUIRE(bytes.size() == chunk + 16);
    CHECK(bytes.substr(40, json.size()) == json);
    CHECK(bytes.substr(40 + json.size(), chunk - 40 - json.size()) ==
          std::string(chunk - 40 - json.size(), '\0'));
    CHECK(bytes.substr(chunk) == std::string("\1\2\3\4\5\0\0\0\1\2\3\4\1\0\0\0", 16));
    CHECK(ReadBytes(bytes));
}

TEST_CASE("writer: refuses what a reader would refuse") {
    const auto error = [](const Document& document, std::span<const std::span<const std::byte>> views = {}) {
        MemoryStream stream;
        const Expected<void> written = WriteContainer(stream, {&document, views});
        CHECK(stream.GetBytes().empty());
        return written ? std::string() : std::string(written.error().GetText());
    };
    Document version;
    version.schemaVersion = 4;
    CHECK(error(version) == "schemaVersion: 4: must be 1 to 3");
    Document counts;
    REQUIRE(counts.channels.Resize(17));
    CHECK(error(counts) == "channels: 17 elements: at most 16");
    Document layers;
    REQUIRE(layers.mlpVersions.Resize(2));
    REQUIRE(layers.mlpVersions[1].layers.Resize(5));
    CHECK(error(layers).find("mlpVersions[1].layers") == 0);
    Document index;
    Fill(index.latents, {LatentImageRecord{}});
    CHECK(error(index) == "latents[0].highResView: 0: must be below 0");
    Document view;
    Fill(view.views, {BufferView{}});
    CHECK(error(view) == "views: 1 elements: data is given for 0");
    const std::byte data[8] = {};
    const std::span<const std::byte> views[] = {data};
    CHECK(error(view, views) == "views[0]: 0 bytes at offset 0: must be 8 at offset 0");
    view.views[0].storedSize = 8;
    view.views[0].offset = 4;
    CHECK(error(view, views) == "views[0]: 8 bytes at offset 4: must be 8 at offset 0");
    Document name;
    TextureRecord texture;
    REQUIRE(texture.name.Assign(std::string(kMaxJsonBytes, 'x')));
    REQUIRE(name.textures.PushBack(std::move(texture)));
    CHECK(error(name).find("JSON: ") == 0);
    MemoryStream stream;
    CHECK_FALSE(WriteContainer(stream, {nullptr, {}}));
}

TEST_CASE("writer: files appear complete under their name, and failures leave the old file") {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "openntc_unit_container";
    std::filesystem::create_directories(folder);
    const std::filesystem::path path = folder / "set.ntc";
    Document document;
    document.width = 5;
    REQUIRE(WriteContainerFile(path, {&document, {}}));
    document.schemaVersion = 9;
    CHECK_FALSE(WriteContainerFile(path, {&document, {}}));
    {
        Expected<FileReader> file = FileReader::Open(path);
        REQUIRE(file);
        const Expected<Container> container = ReadContainer(*file);
        REQUIRE(container);
        CHECK(container->document.width == 5);
    } // Windows does not remove open files
    CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 1);
    const Expected<void> missing = WriteContainerFile(folder / "none" / "set.ntc", {&document, {}});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().GetStatus() == Status::FileUnavailable);
    std::filesystem::remove_all(folder);
}
