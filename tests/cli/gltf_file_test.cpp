// SPDX-License-Identifier: MIT
// `ntc convert-gltf`: versions and extensions that a model insists on, .glb, embedded images, one bad material among good
// ones, what is not converted, and hostile containers.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include "gltf/Uri.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

using namespace openntc_tests;

namespace {

const std::string kFileOptions = " -o out --steps 1 --bits-per-pixel 1 --mips 1 --json --quiet";
const std::string kConvertFile = "convert-gltf model.gltf" + kFileOptions;

constexpr const char* kOneMaterial =
    R"("textures":[{"source":0}],"materials":[{"name":"m","normalTexture":{"index":0}}])";

std::string MakeFileModel(const std::string& asset, const std::string& more = "") {
    return R"({"asset":)" + asset + R"(,"images":[{"uri":"a.png"}],)" + more + kOneMaterial + "}";
}

void WriteConstant(const fs::path& path, float value = 0.25f) {
    WriteImage(path, MakeImage(8, 8, 3, [value](float, float, int) { return value; }));
}

std::string Word(std::uint32_t value) {
    std::string text;
    for (int i = 0; i < 4; ++i)
        text += static_cast<char>(value >> (8 * i) & 0xffu);
    return text;
}

std::string GlbChunk(const std::string& type, std::string content, char padding) {
    content.append((4 - content.size() % 4) % 4, padding);
    return Word(static_cast<std::uint32_t>(content.size())) + type + content;
}

std::string MakeGlb(const std::string& json, const std::string& binary, std::uint32_t version = 2) {
    std::string chunks = GlbChunk("JSON", json, ' ');
    if (!binary.empty())
        chunks += GlbChunk(std::string("BIN\0", 4), binary, '\0');
    return "glTF" + Word(version) + Word(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

std::string EncodeBase64(const std::string& bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63u] : '=';
    }
    return text;
}

} // namespace

TEST_CASE("a model says which version and which extensions its readers need") {
    const Folder folder;
    WriteConstant(folder / "a.png");
    struct Case {
        std::string model;
        const char* error; ///< empty: it is read
    };
    const char* plain = R"({"version":"2.0"})";
    const auto insistOn = [&](const std::string& names) {
        return MakeFileModel(plain, R"("extensionsRequired":[)" + names + "],");
    };
    const std::vector<Case> cases = {
        {MakeFileModel(plain), ""},
        {MakeFileModel(R"({"version":"2.1"})"),
         ""}, // minor versions are compatible unless minVersion says otherwise
        {MakeFileModel(R"({"version":"2.1","minVersion":"2.0"})"), ""},
        {MakeFileModel(R"({"version":"2.1","minVersion":"2.1"})"),
         "asset.minVersion: 2.1: 2.0 is what is read"},
        {MakeFileModel(R"({"version":"3.0","minVersion":"2.0"})"), "asset.version: 3.0: 2.x is needed"},
        {MakeFileModel(R"({"version":"3.0","minVersion":"3.0"})"), "asset.minVersion: 3.0"},
        {MakeFileModel(R"({"version":"2.0","minVersion":2})"), "asset.minVersion: must be a string"},
        {MakeFileModel(R"({"version":"2.0","minVersion":""})"), "asset.minVersion: : must be MAJOR.MINOR"},
        {MakeFileModel(R"({"version":"1.0"})"), "asset.version: 1.0: 2.x is needed"},
        {MakeFileModel(R"({"version":"2"})"), "asset.version: 2: 2.x is needed"},
        {MakeFileModel(R"({"version":2.0})"), "asset.version: must be a string"},
        {MakeFileModel("{}"), "asset.version: missing"},
        {R"({"images":[{"uri":"a.png"}],)" + std::string(kOneMaterial) + "}", "asset: missing"},
        {insistOn(R"("KHR_draco_mesh_compression","EXT_meshopt_compression","KHR_mesh_quantization")"), ""},
        {insistOn(R"("KHR_texture_transform","KHR_materials_unlit","KHR_texture_basisu")"), ""},
        {insistOn(""), ""},
        {insistOn(R"("XYZ_unknown")"), "extensionsRequired: XYZ_unknown: not supported"},
        {insistOn(R"("XYZ_a","KHR_mesh_quantization","XYZ_b")"),
         "extensionsRequired: XYZ_a, XYZ_b: not supported"},
        {insistOn("3"), "extensionsRequired[0]: must be a string"},
        {MakeFileModel(plain, R"("extensionsRequired":"XYZ",)"), "extensionsRequired: must be an array"},
        {MakeFileModel(plain, R"("extensionsUsed":["XYZ_unknown"],)"), ""},
    };
    for (const Case& c : cases) {
        CAPTURE(c.model);
        WriteText(folder / "model.gltf", c.model);
        const ProgramResult result = RunProgram(folder, kConvertFile);
        CAPTURE(result.errors);
        if (c.error[0] == '\0') {
            CHECK(result.code == 0);
            continue;
        }
        CheckFails(result, 3);
        CHECK(result.errors.find(std::string("ntc: model.gltf: ") + c.error) == 0);
    }
}

TEST_CASE("one bad material does not stop the others, and is named with its slot") {
    const Folder folder;
    WriteConstant(folder / "a.png");
    WriteConstant(folder / "b.png", 0.75f);
    WriteText(folder / "broken.png", "\x89PNG\r\n\x1a\nrubbish");
    WriteText(folder / "model.gltf", R"({"asset":{"version":"2.0"},
        "images":[{"uri":"a.png"},{"uri":"nope.png"},{"uri":"broken.png"},{"uri":"b.png"}],
        "textures":[{"source":0},{"source":1},{"source":2},{"source":3},{"extensions":{"EXT_texture_webp":{"source":0}}}],
        "materials":[{"name":"good","normalTexture":{"index":0}},
        {"name":"missing","pbrMetallicRoughness":{"baseColorTexture":{"index":1}},"normalTexture":{"index":1}},
        {"name":"broken","emissiveTexture":{"index":2}},{"name":"shape","normalTexture":3},
        {"name":"webp","occlusionTexture":{"index":4}},{"name":"fine","normalTexture":{"index":3}}]})");
    const ProgramResult result = RunProgram(folder, kConvertFile);
    INFO(result.errors);
    CHECK(result.code == 3);
    const auto list = ParseValid(result.output, "materials");
    CHECK(list["materials"][0]["textures"][0]["file"].GetString() == std::string("good.ntc"));
    CHECK(list["materials"][5]["textures"][0]["file"].GetString() == std::string("fine.ntc"));
    CHECK(list["files"].Size() == 2);
    CHECK(RunProgram(folder, "validate out/good.ntc out/fine.ntc").code == 0);
    const std::vector<std::pair<unsigned, std::string>> expected = {
        {1, "materials[1].baseColorTexture: nope.png: "},
        {1, "materials[1].normalTexture: nope.png: "},
        {2, "materials[2].emissiveTexture: broken.png: image: "},
        {3, "materials[3].normalTexture: must be an object"},
        {4, "materials[4].occlusionTexture: EXT_texture_webp: not read; add a PNG or JPEG fallback"}};
    for (const auto& row : expected) {
        const auto& [material, text] = row;
        CAPTURE(row.second);
        CHECK(result.errors.find("ntc: model.gltf: " + text) != std::string::npos);
        bool isListed = false;
        for (const auto& error : list["materials"][material]["errors"].GetArray())
            isListed = isListed || std::string(error.GetString()).starts_with(text);
        CHECK(isListed);
    }
    CHECK(list["materials"][0]["errors"].Empty());
    // A second run keeps what is good and reports the rest again.
    const ProgramResult again = RunProgram(folder, kConvertFile);
    CHECK(again.code == 3);
    CHECK(ParseValid(again.output, "materials")["files"][1]["kept"].GetBool());
}

TEST_CASE("textures that no set holds are listed and warned of") {
    const Folder folder;
    WriteConstant(folder / "a.png");
    WriteText(folder / "model.gltf",
              R"({"asset":{"version":"2.0"},"images":[{"uri":"a.png"}],"textures":[{"source":0}],
        "materials":[{"normalTexture":{"index":0},"extras":{"someTexture":{"index":0}},
        "extensions":{"KHR_materials_clearcoat":{"clearcoatTexture":{"index":0},"clearcoatNormalTexture":{"index":0}},
        "KHR_materials_volume":{"thicknessTexture":{"index":0}},"XYZ_toon":{"deep":{"shadeTexture":{"index":0}}},
        "KHR_materials_transmission":{"transmissionTexture":{"index":0}}}},
        {"pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"extensions":{"KHR_materials_pbrSpecularGlossiness":
        {"diffuseTexture":{"index":0}}}}]})");
    const ProgramResult result = RunProgram(folder, kConvertFile);
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto list = ParseValid(result.output, "materials");
    const auto& dropped = list["materials"][0]["notConverted"];
    const std::vector<std::string> expected = {"extensions.KHR_materials_clearcoat.clearcoatTexture",
                                               "extensions.KHR_materials_clearcoat.clearcoatNormalTexture",
                                               "extensions.KHR_materials_volume.thicknessTexture",
                                               "extensions.XYZ_toon.deep.shadeTexture"};
    REQUIRE(dropped.Size() == expected.size());
    for (unsigned i = 0; i < expected.size(); ++i) {
        CHECK(dropped[i]["slot"].GetString() == expected[i]);
        CHECK(result.errors.find("materials[0]." + expected[i] + ": not converted") != std::string::npos);
    }
    REQUIRE(list["materials"][1]["notConverted"].Size() == 1);
    CHECK(list["materials"][1]["notConverted"][0]["slot"].GetString() ==
          std::string("pbrMetallicRoughness.baseColorTexture"));
    std::istringstream lines(result.errors);
    for (std::string line; std::getline(lines, line);)
        ParseValid(line, "encode-event");
}

TEST_CASE("images in buffers, data URIs, .glb and separate files give the same texture set") {
    const Folder folder;
    WriteConstant(folder / "a.png");
    const std::string png = ReadText(folder / "a.png");
    const std::string base64 = EncodeBase64(png);
    fs::create_directories(folder / "sub dir");
    WriteText(folder / "sub dir/b.bin", "##" + png);
    const std::string head = R"({"asset":{"version":"2.0"},)";
    const std::string view = R"("bufferViews":[{"buffer":0,"byteOffset":2,"byteLength":)" +
                             std::to_string(png.size()) +
                             R"(}],"images":[{"bufferView":0,"mimeType":"image/png"}],)";
    const std::string length = std::to_string(png.size() + 2);
    std::string escaped = base64;
    for (std::size_t at = 0; (at = escaped.find('+', at)) != std::string::npos;)
        escaped.replace(at, 1, "%2B");
    const std::vector<std::pair<std::string, std::string>> models = {
        {"separate.gltf", head + R"("images":[{"uri":"a.png"}],)" + kOneMaterial + "}"},
        {"data.gltf",
         head + R"("images":[{"uri":"data:image/png;base64,)" + base64 + R"("}],)" + kOneMaterial + "}"},
        {"plain.gltf",
         head + R"("images":[{"uri":"DATA:;base64,)" + escaped + R"("}],)" + kOneMaterial + "}"},
        {"file.gltf", head + R"("buffers":[{"uri":"sub%20dir/b.bin","byteLength":)" + length + "}]," + view +
                          kOneMaterial + "}"},
        {"buffer.gltf", head + R"("buffers":[{"uri":"data:application/octet-stream;base64,)" +
                            EncodeBase64("##" + png) + R"(","byteLength":)" + length + "}]," + view +
                            kOneMaterial + "}"},
        {"all.glb",
         MakeGlb(head + R"("buffers":[{"byteLength":)" + length + "}]," + view + kOneMaterial + "}",
                 "##" + png)},
        {"outside.glb", MakeGlb(head + R"("images":[{"uri":"a.png"}],)" + kOneMaterial + "}", "")}};
    std::string first;
    for (const auto& row : models) {
        const auto& [name, model] = row;
        CAPTURE(row.first);
        WriteText(folder / name, model);
        fs::remove_all(folder / "out");
        const ProgramResult result =
            RunProgram(folder, "convert-gltf " + name + kFileOptions + " --keep-manifests");
        CAPTURE(result.errors);
        REQUIRE(result.code == 0);
        const auto list = ParseValid(result.output, "materials");
        CHECK(list["model"].GetString() == "../" + name);
        const std::string bytes = ReadText(folder / "out/m.ntc");
        REQUIRE_FALSE(bytes.empty());
        if (first.empty())
            first = bytes;
        CHECK(bytes == first);
        // The manifest makes the same file, from the image beside it where the model's was embedded.
        REQUIRE(RunProgram(
                    folder,
                    "encode out/m.manifest.json -o again.ntc --steps 1 --bits-per-pixel 1 --mips 1 --quiet")
                    .code == 0);
        CHECK(ReadText(folder / "again.ntc") == first);
    }
    CHECK(ReadText(folder / "out/m.manifest.json").find("../a.png") != std::string::npos);
}

TEST_CASE("the list does not depend on where the command was called; the model is found from its folder") {
    const Folder folder;
    fs::create_directories(folder / "in");
    WriteConstant(folder / "in/a.png");
    WriteText(folder / "in/model.gltf", MakeFileModel(R"({"version":"2.0"})"));
    const ProgramResult absolute =
        RunProgram(folder, "convert-gltf '" + (folder / "in/model.gltf").string() + "'" + kFileOptions);
    REQUIRE(absolute.code == 0);
    CHECK(ParseValid(absolute.output, "materials")["model"].GetString() == std::string("../in/model.gltf"));
    CHECK(absolute.output.find(folder.GetPath().string()) == std::string::npos);
}

TEST_CASE("hostile containers: exit 3, one line, nothing written") {
    const Folder folder;
    WriteConstant(folder / "a.png");
    const std::string png = ReadText(folder / "a.png");
    const std::string head = R"({"asset":{"version":"2.0"},)";
    const auto embedded = [&](const std::string& buffer, const std::string& view, const std::string& image) {
        return head + R"("buffers":[)" + buffer + R"(],"bufferViews":[)" + view + R"(],"images":[)" + image +
               "]," + kOneMaterial + "}";
    };
    const std::string image = R"({"bufferView":0})",
                      buffer = R"({"byteLength":)" + std::to_string(png.size()) + "}";
    const std::string good =
        embedded(buffer, R"({"buffer":0,"byteLength":)" + std::to_string(png.size()) + "}", image);
    const std::string glb = MakeGlb(good, png);
    std::string longChunk = glb, wrongType = glb;
    longChunk.replace(12, 4, Word(0xfffffff0u));
    wrongType.replace(16, 4, "BIN!");
    std::string longFile = glb;
    longFile.replace(8, 4, Word(static_cast<std::uint32_t>(glb.size() + 4)));
    std::vector<std::pair<std::string, std::string>> cases = {
        {glb.substr(0, 10), "glb: 10 bytes"},
        {glb.substr(0, glb.size() - 4), "glb.length: "},
        {MakeGlb(good, png, 1), "glb.version: 1: 2 is needed"},
        {longFile, "glb.length: "},
        {longChunk, "glb.chunks[0].length: 4294967280: "},
        {wrongType, "glb.chunks[0].type: 0x"},
        {MakeGlb("{", ""), "glTF: byte 2"},
        {MakeGlb(good, ""), "buffers[0].byteLength: "},
        {good, "buffers[0].uri: missing"},
        {MakeGlb(embedded(buffer,
                          R"({"buffer":0,"byteOffset":1,"byteLength":)" + std::to_string(png.size()) + "}",
                          image),
                 png),
         "bufferViews[0]: "},
        {MakeGlb(embedded(buffer, R"({"buffer":0,"byteOffset":18446744073709551615,"byteLength":2})", image),
                 png),
         "bufferViews[0]: 2 bytes at 18446744073709551615"},
        {MakeGlb(embedded(buffer, R"({"buffer":0,"byteLength":-1})", image), png),
         "bufferViews[0].byteLength: "},
        {MakeGlb(embedded(buffer, R"({"buffer":0})", image), png), "bufferViews[0].byteLength: missing"},
        {MakeGlb(embedded(buffer, R"({"buffer":0,"byteLength":0})", image), png), "images[0]: 0 bytes"},
        {MakeGlb(embedded(buffer, R"({"buffer":0,"byteLength":9})", image), png), "images[0]: image: "},
        {MakeGlb(embedded(buffer, R"({"buffer":7,"byteLength":9})", image), png), "bufferViews[0].buffer: "},
        {MakeGlb(embedded(buffer, "", R"({"bufferView":3})"), png), "images[0].bufferView: "},
        {MakeGlb(embedded(R"({"byteLength":1e99})", R"({"buffer":0,"byteLength":9})", image), png),
         "buffers[0].byteLength: must be a number of bytes"},
        {embedded(R"({"uri":"lost.bin","byteLength":9})", R"({"buffer":0,"byteLength":9})", image),
         "lost.bin: "},
        {embedded(R"({"uri":"../../../../../../../../dev/zero","byteLength":9})",
                  R"({"buffer":0,"byteLength":9})", image),
         "not a regular file"},
        {embedded("", "", R"({"uri":"../../../../../../../../dev/zero"})"), "not a regular file"},
        {embedded("", "", R"({"uri":"."})"), "not a regular file"},
        {embedded("", "", R"({"uri":"data:image/png,rubbish"})"), "data URI: not base64"},
        {embedded("", "", R"({"uri":"data:image/png;base64"})"), "data URI: no comma"},
        {embedded("", "", R"({"uri":"data:image/png;base64,AA*A"})"), "base64: character 2: byte 0x2a"},
        {embedded("", "", R"({"uri":"data:image/png;base64,AAAAA"})"), "base64: 5 characters"},
        {embedded("", "", R"({"uri":"data:image/webp;base64,AAAA"})"), "image/webp: not read"},
        {embedded("", "", R"({"uri":"data:image/png;base64,"})"), "images[0]: 0 bytes"},
        {embedded("", "", R"({"uri":"tex\\base.png"})"), "separated by /, not by a backslash"},
        {embedded("", "", R"({"uri":"tex%5Cbase.png"})"), "separated by /, not by a backslash"},
    };
    for (const auto& row : cases) {
        const auto& [model, error] = row;
        CAPTURE(row.second);
        WriteText(folder / "model.gltf", model);
        const ProgramResult result = RunProgram(folder, kConvertFile);
        CAPTURE(result.errors);
        CheckFails(result, 3);
        CHECK(result.errors.find(error) != std::string::npos);
        CHECK_FALSE(fs::exists(folder / "out"));
    }
    // Every prefix of a sound file, and every byte of its header and chunk headers.
    for (std::size_t size = 0; size < 40; ++size) {
        WriteText(folder / "model.gltf", glb.substr(0, size));
        CheckFails(RunProgram(folder, kConvertFile), 3);
    }
}

TEST_CASE("base64 of every length, and what is not base64") {
    std::string bytes, error;
    for (int length = 0; length < 9; ++length) {
        CAPTURE(length);
        const std::string text = EncodeBase64(bytes);
        for (const std::string& form : {text, text.substr(0, text.find('='))}) {
            const auto data = openntc::tool::ParseDataUri("data:Image/PNG;name=x;base64," + form, error);
            REQUIRE(data.has_value());
            CHECK(data->mediaType == "image/png");
            CHECK(std::string(reinterpret_cast<const char*>(data->bytes.data()), data->bytes.size()) ==
                  bytes);
        }
        bytes += static_cast<char>(0xf1 + 37 * length);
    }
    for (const char* bad : {"data:;base64,A", "data:;base64,A===", "data:;base64,AAA=A", "data:;base64,AA A",
                            "data:;base64,AA-_", "data:base64,AAAA", "data:"}) {
        CAPTURE(bad);
        CHECK_FALSE(openntc::tool::ParseDataUri(bad, error).has_value());
    }
    CHECK(openntc::tool::UnescapeUri("a%20b%2Fc%zz%4") == "a b/c%zz%4");
}
