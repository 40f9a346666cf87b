// SPDX-License-Identifier: MIT
// `ntc convert-gltf`: which channels a texture gets follows its slot, whatever components its image has.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include "encode/EncodeInputs.h"
#include "gltf/GltfMaterials.h"

#include "openntc/image/MipGeneration.h"

#include <png.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

using namespace openntc_tests;
using openntc::tool::GltfMaterial;

namespace {

constexpr float kGray = 191.0f / 255.0f, kAlpha = 146.0f / 255.0f;

// 16 x 16, every sample 191: baseline, one component.
constexpr unsigned char kGrayJpeg[] = {
    0xff, 0xd8, 0xff, 0xdb, 0x00, 0x43, 0x00, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08,
    0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08,
    0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08,
    0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08,
    0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0x08, 0xff, 0xc0, 0x00, 0x0b, 0x08, 0x00, 0x10, 0x00, 0x10,
    0x01, 0x01, 0x11, 0x00, 0xff, 0xc4, 0x00, 0x15, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x06, 0xff, 0xc4, 0x00, 0x14, 0x10,
    0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0xff, 0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x3f, 0x00, 0xbf, 0x01, 0xff, 0xd9};

/// One colour index, (191, 100, 7).
void WritePalettePng(const fs::path& path) {
    png_image png = {};
    png.version = PNG_IMAGE_VERSION;
    png.width = png.height = 16;
    png.format = PNG_FORMAT_RGB_COLORMAP;
    png.colormap_entries = 2;
    const unsigned char map[] = {191, 100, 7, 0, 0, 0};
    const std::vector<unsigned char> indices(256, 0);
    REQUIRE(png_image_write_to_file(&png, path.string().c_str(), 0, indices.data(), 16, map) != 0);
}

struct ImageKind {
    const char* file;
    float rgb[3];
    float alpha; ///< 1: the image has none
};

// Channel c of a colour image is 191 - 91 c.
float GetColor(int c) {
    return c == 3 ? kAlpha : (191.0f - 91.0f * static_cast<float>(c)) / 255.0f;
}

std::vector<ImageKind> WriteImageKinds(const Folder& folder) {
    const auto constant = [](int channels) {
        return MakeImage(16, 16, channels, [channels](float, float, int c) {
            return channels <= 2 ? (c == 0 ? kGray : kAlpha) : GetColor(c);
        });
    };
    WriteImage(folder / "gray.png", constant(1));
    WriteImage(folder / "gray_alpha.png", constant(2));
    WriteImage(folder / "gray16.png", constant(1), 16);
    WriteImage(folder / "gray_alpha16.png", constant(2), 16);
    WriteImage(folder / "rgb.png", constant(3));
    WriteImage(folder / "rgba.png", constant(4));
    WriteImage(folder / "rgba16.png", constant(4), 16);
    WritePalettePng(folder / "palette.png");
    WriteText(folder / "gray.jpg", std::string(reinterpret_cast<const char*>(kGrayJpeg), sizeof(kGrayJpeg)));
    const float red = GetColor(0), green = GetColor(1), blue = GetColor(2);
    return {{"gray.png", {kGray, kGray, kGray}, 1.0f},
            {"gray_alpha.png", {kGray, kGray, kGray}, kAlpha},
            {"gray16.png", {kGray, kGray, kGray}, 1.0f},
            {"gray_alpha16.png", {kGray, kGray, kGray}, kAlpha},
            {"rgb.png", {red, green, blue}, 1.0f},
            {"rgba.png", {red, green, blue}, kAlpha},
            {"rgba16.png", {red, green, blue}, kAlpha},
            {"palette.png", {red, 100.0f / 255.0f, 7.0f / 255.0f}, 1.0f},
            {"gray.jpg", {kGray, kGray, kGray}, 1.0f}};
}

std::string MakeOneImageModel(const std::string& image, const std::string& material) {
    return R"({"asset":{"version":"2.0"},"images":[{"uri":")" + image +
           R"("}],"textures":[{"source":0}],"materials":[{)" + material + "}]}";
}

/// The material that is encoded for the only material of a model.
openntc::tool::EncodeInputs LoadOneMaterial(const Folder& folder, const std::string& model) {
    WriteText(folder / "model.gltf", model);
    const std::vector<GltfMaterial> materials =
        openntc::tool::ReadGltfMaterials((folder / "model.gltf").string());
    REQUIRE(materials.size() == 1);
    REQUIRE(materials[0].errors.empty());
    openntc::tool::InputOptions options;
    options.paths = {"model"};
    options.manifest = MakeManifest(materials[0]);
    return LoadInputs(options);
}

/// Samples that are constant over the image are equal everywhere, so one says all.
void CheckConstant(const openntc::encode::Material& material, int channel, float expected) {
    CAPTURE(channel);
    REQUIRE(channel < material.GetChannelCount());
    for (const float texel : material.GetPlane(0, channel))
        REQUIRE(std::abs(texel - expected) <= 0.5f / 65535.0f);
}

} // namespace

TEST_CASE("base colour is three channels when opaque and four with alpha, from any kind of image") {
    const Folder folder;
    for (const ImageKind& image : WriteImageKinds(folder)) {
        for (const char* mode : {"OPAQUE", "BLEND", "MASK"}) {
            CAPTURE(image.file);
            CAPTURE(mode);
            const bool hasAlpha = mode != std::string("OPAQUE");
            const auto inputs =
                LoadOneMaterial(folder, MakeOneImageModel(image.file, "\"alphaMode\":\"" + std::string(mode) +
                                                                          R"(","pbrMetallicRoughness":
                                                   {"baseColorTexture":{"index":0}})"));
            REQUIRE(inputs.material.GetTextures().size() == 1);
            const auto& texture = inputs.material.GetTextures()[0];
            CHECK(texture.firstChannel == 0);
            CHECK(texture.channels == (hasAlpha ? 4 : 3));
            CHECK(inputs.material.GetDeclaredChannels() == (hasAlpha ? 0xfu : 0x7u));
            CHECK(inputs.maskChannel == (mode == std::string("MASK") ? 3 : -1));
            for (int c = 0; c < 3; ++c)
                CheckConstant(inputs.material, c, image.rgb[c]);
            if (hasAlpha)
                CheckConstant(inputs.material, 3, image.alpha);
        }
    }
}

TEST_CASE("mips of a mask keep the share of texels that the model's alpha test lets through") {
    const Folder folder;
    // 1 texel in 7 of alpha 1, in no blocks: averages of four hardly reach a half.
    WriteImage(folder / "holes.png", MakeImage(32, 32, 4, [](float x, float y, int c) {
                   return c == 3 ? ((static_cast<int>(x * 32) + 3 * static_cast<int>(y * 32)) % 7 == 0 ? 1.0f
                                                                                                       : 0.1f)
                                 : 0.5f;
               }));
    struct Row {
        const char *mode, *factor;
        float threshold; ///< 0: coverage is not kept
    };
    for (const Row& row : {Row{R"("MASK")", "1", 0.5f}, Row{R"("MASK","alphaCutoff":0.25)", "0.5", 0.5f},
                           Row{R"("MASK","alphaCutoff":0.75)", "0.5", 0.0f}, Row{R"("BLEND")", "1", 0.0f}}) {
        CAPTURE(row.mode);
        const auto inputs = LoadOneMaterial(
            folder,
            MakeOneImageModel("holes.png", std::string(R"("alphaMode":)") + row.mode +
                                               R"(,"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,)" +
                                               row.factor + R"(],"baseColorTexture":{"index":0}})"));
        const auto& material = inputs.material;
        REQUIRE(material.GetMipCount() > 2);
        const double wanted = openntc::image::MeasureCoverage(material.GetPlane(0, 3), 0.5f);
        const double kept = openntc::image::MeasureCoverage(material.GetPlane(2, 3), 0.5f);
        CHECK(wanted > 0.1);
        // How near, Material's own tests say: here, that the model's numbers arrive.
        CHECK((kept > 0.0) == (row.threshold > 0.0f));
    }
}

TEST_CASE("every slot has its channels and block format, from any kind of image") {
    struct Place {
        const char* json;
        int first, channels;
        openntc::BlockCompressedFormat format;
        int components[4]; ///< of the image: 0 - 2 colours, 3 alpha
    };
    using Format = openntc::BlockCompressedFormat;
    const std::vector<Place> places = {
        {R"("pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}})", 4, 2, Format::BC5, {2, 1}},
        {R"("normalTexture":{"index":0})", 8, 3, Format::BC7, {0, 1, 2}},
        {R"("occlusionTexture":{"index":0})", 11, 1, Format::BC4, {0}},
        {R"("emissiveTexture":{"index":0})", 12, 3, Format::BC7, {0, 1, 2}},
        {R"("extensions":{"KHR_materials_transmission":{"transmissionTexture":{"index":0}}})",
         15,
         1,
         Format::BC4,
         {0}},
        {R"("extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseTexture":{"index":0}}})",
         0,
         3,
         Format::BC7,
         {0, 1, 2}},
        {R"("extensions":{"KHR_materials_pbrSpecularGlossiness":{"specularGlossinessTexture":{"index":0}}})",
         4,
         4,
         Format::BC7,
         {0, 1, 2, 3}}};
    const Folder folder;
    for (const ImageKind& image : WriteImageKinds(folder)) {
        for (const Place& place : places) {
            CAPTURE(image.file);
            CAPTURE(place.json);
            const auto inputs = LoadOneMaterial(folder, MakeOneImageModel(image.file, place.json));
            REQUIRE(inputs.material.GetTextures().size() == 1);
            const auto& texture = inputs.material.GetTextures()[0];
            CHECK(texture.firstChannel == place.first);
            CHECK(texture.channels == place.channels);
            CHECK(texture.bcFormat == place.format);
            for (int c = 0; c < place.channels; ++c) {
                const int component = place.components[c];
                CheckConstant(inputs.material, place.first + c,
                              component == 3 ? image.alpha : image.rgb[component]);
            }
        }
    }
}

TEST_CASE("glossiness is data: it neither weighs the mips of specular colours nor is it an alpha test's") {
    const Folder folder;
    // Left half 0.2 and without gloss, right half 0.8 and glossy: as alpha it would hide the left half.
    WriteImage(folder / "a.png", MakeImage(2, 2, 4, [](float u, float, int c) {
                   return c == 3 ? (u < 0.5f ? 0.0f : 1.0f) : u < 0.5f ? 0.2f : 0.8f;
               }));
    const auto inputs = LoadOneMaterial(
        folder, MakeOneImageModel("a.png", R"("extensions":{"KHR_materials_pbrSpecularGlossiness":
                                               {"specularGlossinessTexture":{"index":0}}})"));
    using openntc::ColorSpace;
    const float dark = openntc::image::DecodeColor(ColorSpace::sRGB, 0.2f),
                bright = openntc::image::DecodeColor(ColorSpace::sRGB, 0.8f);
    REQUIRE(inputs.material.GetMipCount() == 2);
    // Stored values of mip 0 are within half a step of 8 bits of the halves.
    CHECK(std::abs(inputs.material.GetPlane(1, 4)[0] -
                   openntc::image::EncodeColor(ColorSpace::sRGB, 0.5f * (dark + bright))) < 1.0f / 255.0f);
    CHECK(std::abs(inputs.material.GetPlane(1, 7)[0] - 0.5f) < 1e-6f);
}

TEST_CASE("alpha beside gray is resampled as alpha, not as a colour") {
    const Folder folder;
    WriteImage(folder / "la.png",
               MakeImage(2, 2, 2, [](float u, float, int c) { return c == 0 || u >= 0.5f ? 1.0f : 0.0f; }));
    WriteImage(folder / "normal.png", MakeImage(4, 4, 3, [](float, float, int) { return 0.5f; }));
    const auto inputs = LoadOneMaterial(
        folder, R"({"asset":{"version":"2.0"},"images":[{"uri":"la.png"},{"uri":"normal.png"}],
        "textures":[{"source":0},{"source":1}],"materials":[{"alphaMode":"BLEND",
        "pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"normalTexture":{"index":1}}]})");
    REQUIRE(inputs.material.GetWidth() == 4);
    const auto alpha = inputs.material.GetPlane(0, 3);
    CHECK(alpha[0] == doctest::Approx(0.0));
    CHECK(alpha[1] == doctest::Approx(0.25)); // through sRGB it would be 0.54
    CHECK(alpha[2] == doctest::Approx(0.75));
    CHECK(alpha[3] == doctest::Approx(1.0));
}

TEST_CASE("gray and alpha arrive as a colour and alpha in the decoded image; the list tells the channels") {
    const Folder folder;
    WriteImageKinds(folder);
    WriteText(
        folder / "model.gltf",
        MakeOneImageModel(
            "gray_alpha.png",
            R"("name":"m","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":0}})"));
    const ProgramResult result = RunProgram(
        folder, "convert-gltf model.gltf -o out --steps 2 --bits-per-pixel 1 --mips 1 --json --quiet");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto list = ParseValid(result.output, "materials");
    const auto& texture = list["materials"][0]["textures"][0];
    CHECK(texture["file"].GetString() == std::string("m.ntc"));
    CHECK(texture["channels"].GetInt() == 4);
    const auto info = ParseValid(RunProgram(folder, "info out/m.ntc --json").output, "info");
    CHECK(info["textures"][0]["numChannels"].GetInt() == 4);
    CHECK(info["textures"][0]["bcFormat"].GetString() == std::string("BC7"));
    REQUIRE(RunProgram(folder, "decode out/m.ntc -o decoded").code == 0);
    const TestImage image = ReadPngImage(folder / "decoded/BaseColor.png");
    REQUIRE(image.channels == 4);
    for (std::size_t i = 0; i < image.samples.size(); ++i) {
        const float expected = i % 4 == 3 ? kAlpha : kGray;
        REQUIRE(std::abs(image.samples[i] - expected) <=
                1.5f / 255.0f); // constant channels: the network's rounding
    }
}
