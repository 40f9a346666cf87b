// SPDX-License-Identifier: MIT
// `ntc convert-gltf` and `ntc bake`: what options say of mips and of single textures concerns the materials that have them,
// and no others; names that none has are refused.
#include "cli/BakeTree.h"

using namespace openntc_tests;

namespace {

// "Wall" has normals and no alpha, "Leaf" a mask and no normals; "Glass" alpha that is blended.
constexpr const char* kThree = R"({"asset":{"version":"2.0"},
  "images":[{"uri":"color.png"},{"uri":"normal.png"},{"uri":"leaf.png"},{"uri":"glass.png"}],
  "textures":[{"source":0},{"source":1},{"source":2},{"source":3}],
  "materials":[
    {"name":"Wall","pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"normalTexture":{"index":1}},
    {"name":"Leaf","alphaMode":"MASK","pbrMetallicRoughness":{"baseColorTexture":{"index":2}}},
    {"name":"Glass","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":3}}}]})";

const std::string kShort = " --steps 2 --bits-per-pixel 1 --quiet --threads 1 ";

void WriteModel(const Folder& folder) {
    WriteSource(folder / "art/color.png", 1);
    WriteText(folder / "art/model.gltf", kThree);
    WriteSource(folder / "art/normal.png", 2);
    WriteSource(folder / "art/leaf.png", 3, 8, 4);
    WriteSource(folder / "art/glass.png", 4, 8, 4);
}

/// Materials whose files differ from those of `plain`.
std::string ListChanged(const std::map<std::string, std::string>& plain,
                        const std::map<std::string, std::string>& now) {
    std::string changed;
    for (const auto& [name, bytes] : now) {
        if (plain.at(name) != bytes)
            changed += name.substr(0, name.find('.')) + " ";
    }
    return changed;
}

struct OptionCase {
    const char* option;
    const char* changed; ///< materials, by name
};
constexpr OptionCase kOptionCases[] = {{"--mip-filter kaiser", "Glass Leaf Wall "},
                                       {"--mip-filter kaiser --mip-wrap clamp", "Glass Leaf Wall "},
                                       {"--normal-map Normal", "Wall "},
                                       {"--weight Normal=9", "Wall "},
                                       {"--weight Normal=0.1 --weight color.png=9", "Wall "},
                                       {"--keep-coverage 0.8", "Glass Leaf "},
                                       {"--mips 2", "Glass Leaf Wall "}};

} // namespace

TEST_CASE("convert-gltf: options of mips and textures change the materials that they concern, as in encode") {
    const Folder folder;
    WriteModel(folder);
    const std::string convert = "convert-gltf art/model.gltf -o out --keep-manifests" + kShort;
    REQUIRE(RunProgram(folder, convert).code == 0);
    const auto plain = ReadSets(folder / "out");
    REQUIRE(plain.size() == 3);
    for (const OptionCase& c : kOptionCases) {
        CAPTURE(c.option);
        const ProgramResult result = RunProgram(folder, convert + c.option + " --json");
        INFO(result.errors);
        REQUIRE(result.code == 0);
        const auto made = ReadSets(folder / "out");
        CHECK(ListChanged(plain, made) == c.changed);
        // Files that an option says nothing of are kept from the run before.
        const auto list = ParseValid(RunProgram(folder, convert + " --json").output, "materials");
        for (const auto& file : list["files"].GetArray()) {
            const std::string name = file["file"].GetString();
            CHECK(file["kept"].GetBool() == (made.at(name) == plain.at(name)));
        }
        // What concerns a material is said to `ntc encode` in the same words.
        const std::string name(c.changed, std::string(c.changed).find(' '));
        std::string encode = "encode out/" + name;
        encode.append(".manifest.json -o again.ntc").append(kShort).append(c.option);
        REQUIRE(RunProgram(folder, encode).code == 0);
        CHECK(ReadText(folder / "again.ntc") == made.at(name + ".ntc"));
    }
}

TEST_CASE("convert-gltf: a target of one texture is sought where a material has it") {
    const Folder folder;
    WriteModel(folder);
    const ProgramResult result = RunProgram(
        folder, "convert-gltf art/model.gltf -o out --steps 2 --threads 1 --max-bits-per-pixel 1 --json "
                "--target-psnr Normal=90");
    CHECK(result.code == 1);
    CHECK(result.errors.find("Wall.ntc: psnr: Normal: ") != std::string::npos);
    CHECK(result.errors.find("Leaf.ntc: psnr") == std::string::npos);
    CHECK(ReadSets(folder / "out").size() == 3);
}

TEST_CASE("names that no material has are refused with those that there are") {
    const Folder folder;
    WriteModel(folder);
    for (const char* command : {"convert-gltf art/model.gltf -o out", "bake art -o out"}) {
        for (const char* option : {"--weight Bump=2", "--normal-map Bump", "--target-psnr Bump=30",
                                   "--weight Normal=2 --normal-map Bump"}) {
            CAPTURE(command);
            CAPTURE(option);
            const ProgramResult result = RunProgram(folder, std::string(command) + " --steps 2 " + option);
            CheckFails(result, 2);
            CHECK(result.errors.find(": Bump: no texture has this name: BaseColor, Normal\n") !=
                  std::string::npos);
        }
    }
    CheckFails(RunProgram(folder, "encode art/color.png art/leaf.png --weight Bump=2 -o x.ntc"), 2);
    // Nothing has alpha.
    WriteText(folder / "art/model.gltf",
              R"({"asset":{"version":"2.0"},"images":[{"uri":"color.png"}],"textures":[{"source":0}],
                  "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]})");
    const ProgramResult result =
        RunProgram(folder, "convert-gltf art/model.gltf -o out --steps 2 --keep-coverage 0.5");
    CheckFails(result, 2);
    CHECK(result.errors.find("--keep-coverage: no material has alpha") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("bake: options of mips and textures make again the materials that they concern") {
    const Folder folder;
    WriteModel(folder);
    const std::string bake = "bake art -o out" + kShort;
    REQUIRE(RunProgram(folder, bake).code == 0);
    const auto plain = ReadSets(folder / "out/model");
    REQUIRE(plain.size() == 3);
    for (const OptionCase& c : kOptionCases) {
        CAPTURE(c.option);
        const ProgramResult result = RunProgram(folder, bake + c.option);
        INFO(result.errors);
        REQUIRE(result.code == 0);
        CHECK(ListChanged(plain, ReadSets(folder / "out/model")) == c.changed);
    }
    // A broken material may be the one that has the texture: the others are made nevertheless.
    WriteText(folder / "art/broken.json", "{\"textures\":[{\"fileName\":");
    const ProgramResult result = RunProgram(folder, bake + "--weight Bump=2");
    CHECK(result.code == 1);
    CHECK(result.errors.find("--weight: Bump: no texture has this name") != std::string::npos);
    CHECK(ListChanged(plain, ReadSets(folder / "out/model")).empty());
}

TEST_CASE("bake: a plan says options that are repeated as often as the user did") {
    const Folder folder;
    WriteModel(folder);
    const std::string options = kShort + "--weight Normal=4 --weight BaseColor=2 --normal-map Normal ";
    REQUIRE(RunProgram(folder, "bake art -o plan --plan slurm" + options).code == 0);
    REQUIRE(RunProgram(folder, "bake art -o plan --plan ninja" + options).code == 0);
    for (const char* file : {"plan/bake.sbatch", "plan/build.ninja"})
        CHECK(ReadText(folder / file).find("--weight Normal=4 --weight BaseColor=2") != std::string::npos);
}
