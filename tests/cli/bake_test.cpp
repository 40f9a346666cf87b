// SPDX-License-Identifier: MIT
// `ntc bake`: what a tree holds, what is made again and why, and what happens to failures.
#include "cli/BakeTree.h"

#include "encode/ContentKey.h"

#include <set>
#include <sstream>

using namespace openntc_tests;
using namespace openntc::tool;

namespace {

const std::string kBake = "bake art -o out --steps 1 --bits-per-pixel 1 --json";

constexpr const char* kLeaf =
    R"({"textures":[{"fileName":"tex/leaf.png","isSRGB":true,"semantics":{"AlphaMask":"A"}}]})";
constexpr const char* kCarModel =
    R"({"asset":{"version":"2.0"},"images":[{"uri":"tex/paint.png"},{"uri":"tex/tire.png"}],
    "textures":[{"source":0},{"source":1}],"materials":[{"name":"Paint","normalTexture":{"index":0}},
    {"name":"Tire","normalTexture":{"index":1}},{"name":"Copy","normalTexture":{"index":0}}]})";

/// A manifest, a model, a folder that is one material, one that holds two, and what is no material.
void WriteTree(const Folder& folder) {
    WriteSource(folder / "art/tex/leaf.png", 1, 8, 4);
    WriteText(folder / "art/leaf.manifest.json", kLeaf);
    WriteSource(folder / "art/tex/paint.png", 2);
    WriteSource(folder / "art/tex/tire.png", 3);
    WriteText(folder / "art/car.gltf", kCarModel);
    WriteSource(folder / "art/props/wall/BaseColor.png", 4);
    WriteSource(folder / "art/props/wall/Normal.png", 5);
    WriteSource(folder / "art/props/wall/mips/Normal.01.png", 5, 4);
    WriteSource(folder / "art/flat/T_Rock_D.png", 6);
    WriteSource(folder / "art/flat/T_Rock_N.png", 7);
    WriteSource(folder / "art/flat/T_Sand_D_02.png", 8);
    WriteText(folder / "art/package.json", R"({"name":"no manifest"})");
    WriteSource(folder / "art/.trash/old.png", 9);
}

/// Material to status and reason.
std::map<std::string, std::string> Bake(const Folder& folder, const std::string& more = "", int code = 0) {
    const ProgramResult result = RunProgram(folder, kBake + " " + more);
    INFO(result.errors);
    REQUIRE(result.code == code);
    std::map<std::string, std::string> materials;
    const auto list = ParseValid(result.output, "bake");
    for (const auto& material : list["materials"].GetArray())
        materials[material["material"].GetString()] =
            std::string(material["status"].GetString()) +
            (material.HasMember("reason") ? std::string(" ") + material["reason"].GetString() : "");
    for (const auto& material : list["vanished"].GetArray())
        materials[material["material"].GetString()] = material["removed"].GetBool() ? "removed" : "vanished";
    return materials;
}

std::set<std::string> ListMade(const std::map<std::string, std::string>& materials) {
    std::set<std::string> made;
    for (const auto& [name, status] : materials) {
        if (status.starts_with("made"))
            made.insert(name);
    }
    return made;
}

} // namespace

TEST_CASE("bake: every material of a tree once, under a name that says where it is from") {
    const Folder folder;
    WriteTree(folder);
    auto materials = Bake(folder, "--jobs 2");
    CHECK(materials == std::map<std::string, std::string>{{"leaf", "made new"},
                                                          {"car/Paint", "made new"},
                                                          {"car/Tire", "made new"},
                                                          {"props/wall", "made new"},
                                                          {"flat/T_Rock", "made new"},
                                                          {"flat/T_Sand_02", "made new"}});
    CHECK(ReadSets(folder / "out").size() == 6);
    const auto wall = ParseValid(RunProgram(folder, "info --json out/props/wall.ntc").output, "info");
    CHECK(wall["textures"].Size() == 2);
    const auto list = ParseValid(ReadText(folder / "out/car/materials.json"), "materials");
    CHECK(list["materials"][2]["textures"][0]["file"].GetString() == std::string("Paint.ntc"));
    CHECK(list["files"].Size() == 2);

    // The bytes are those of `ntc encode`.
    REQUIRE(
        RunProgram(folder, "encode art/leaf.manifest.json -o leaf.ntc --steps 1 --bits-per-pixel 1 --quiet")
            .code == 0);
    CHECK(ReadText(folder / "leaf.ntc") == ReadText(folder / "out/leaf.ntc"));

    // Nothing is touched again: not by a second run, and not by one whose images are newer and the same.
    const auto time = fs::last_write_time(folder / "out/leaf.ntc");
    WriteSource(folder / "art/tex/leaf.png", 1, 8, 4);
    CHECK(ListMade(Bake(folder)).empty());
    CHECK(ListMade(Bake(folder, "--threads 1 --save-every 7")).empty());
    CHECK(fs::last_write_time(folder / "out/leaf.ntc") == time);
}

TEST_CASE("bake: what changed is made again, and why is said") {
    const Folder folder;
    WriteTree(folder);
    Bake(folder);
    WriteSource(folder / "art/tex/paint.png", 20);
    WriteSource(folder / "art/props/wall/mips/Normal.01.png", 21, 4);
    WriteText(folder / "art/leaf.manifest.json", std::string(kLeaf).replace(0, 1, "{\"width\":16,"));
    WriteSource(folder / "art/flat/T_Rock_R.png", 22, 8, 1);
    WriteText(folder / "out/flat/T_Sand_02.ntc", "damaged");
    fs::remove(folder / "out/car/Tire.ntc");
    const std::map<std::string, std::string> due = {
        {"car/Paint", "due changed: art/tex/paint.png"},
        {"car/Tire", "due file missing"},
        {"flat/T_Rock", "due changed: art/flat/T_Rock_R.png"},
        {"flat/T_Sand_02", "due file changed"},
        {"leaf", "due changed: art/leaf.manifest.json"},
        {"props/wall", "due changed: art/props/wall/mips/Normal.01.png"}};
    CHECK(Bake(folder, "--dry-run") == due);
    CHECK(ListMade(Bake(folder)).size() == due.size());
    CHECK(ListMade(Bake(folder)).empty());
    CHECK(Bake(folder, "--seed 2 --dry-run")["leaf"] == "due settings");
    // A record that cannot be read is none.
    WriteText(folder / "out/.bake/leaf.json", "{");
    CHECK(ListMade(Bake(folder)) == std::set<std::string>{"leaf"});
}

TEST_CASE("bake: what vanished is kept unless it is to be pruned, and belongs to its own inputs") {
    const Folder folder;
    WriteTree(folder);
    Bake(folder);
    REQUIRE(RunProgram(folder, "bake art/props -o out --steps 1 --bits-per-pixel 1 --prune --quiet").code ==
            0);
    CHECK(ReadSets(folder / "out").size() == 7); // `wall` of that root; others are none of its business
    fs::remove(folder / "art/car.gltf");
    fs::remove_all(folder / "art/flat");
    WriteText(folder / "art/leaf.manifest.json", std::string(kLeaf) + "broken");
    auto materials = Bake(folder, "", 1);
    CHECK(materials["car/Paint"] == "vanished");
    CHECK(materials["flat/T_Rock"] == "vanished");
    CHECK(ReadSets(folder / "out").size() == 7);
    materials = Bake(folder, "--prune", 1);
    CHECK(materials["car/Tire"] == "removed");
    // A manifest that is broken now has not vanished.
    const std::map<std::string, std::string> left = ReadSets(folder / "out");
    CHECK(left.size() == 3);
    CHECK(left.contains("leaf.ntc"));
    CHECK_FALSE(fs::exists(folder / "out/car"));
    CHECK_FALSE(fs::exists(folder / "out/.bake/car"));
}

TEST_CASE("bake: failures are listed when the others are done") {
    const Folder folder;
    WriteTree(folder);
    WriteText(folder / "art/a_broken.json", "{\"textures\":[{\"fileName\":");
    WriteText(folder / "art/b_missing.json", R"({"textures":[{"fileName":"nope.png"}]})");
    WriteText(folder / "art/z.glb", "no model");
    const ProgramResult result = RunProgram(folder, "bake art -o out --steps 1 --bits-per-pixel 1 --quiet");
    INFO(result.errors);
    CHECK(result.code == 1);
    CHECK(result.output == "9 materials: 0 unchanged, 6 made, 3 failed\n");
    CHECK(ReadSets(folder / "out").size() == 6);
    for (const char* line :
         {"ntc: a_broken: art/a_broken.json: manifest: byte", "ntc: b_missing: ", "ntc: z: art/z.glb: "})
        CHECK(result.errors.find(line) != std::string::npos);

    // With a goal that is missed a file is kept and stays a failure, without being made again.
    const std::string strict =
        "bake art/flat -o goal --steps 1 --target-psnr 90 --max-bits-per-pixel 0.5 --json";
    CHECK(RunProgram(folder, strict).code == 1);
    const ProgramResult again = RunProgram(folder, strict);
    CHECK(again.code == 1);
    const auto list = ParseValid(again.output, "bake");
    CHECK(list["materials"][0]["status"].GetString() == std::string("failed"));
    CHECK(std::string(list["materials"][0]["error"].GetString()).find("the target is 90") !=
          std::string::npos);
    CHECK(again.errors.find("\"due\":0") != std::string::npos);

    CheckFails(RunProgram(folder, "bake nowhere -o out"), 3);
    CheckFails(RunProgram(folder, "bake art/flat/T_Rock_D.png -o out"), 2);
    CheckFails(RunProgram(folder, "bake art -o out --material nope"), 2);
    CheckFails(RunProgram(folder, "bake art -o out --plan make"), 2);
    CheckFails(RunProgram(folder, "bake art -o out --prune --material leaf"), 2);
    fs::create_directories(folder / "empty");
    CheckFails(RunProgram(folder, "bake empty -o out"), 3);
    WriteText(folder / "art/LEAF.json", kLeaf);
    CheckFails(RunProgram(folder, "bake art -o out"), 2); // one file on systems that do not tell cases apart
}

TEST_CASE("bake: events are JSON, one a line") {
    const Folder folder;
    WriteTree(folder);
    const ProgramResult result = RunProgram(folder, kBake);
    REQUIRE(result.code == 0);
    std::istringstream lines(result.errors);
    std::map<std::string, int> events;
    for (std::string line; std::getline(lines, line);)
        ++events[ParseValid(line, "bake-event")["event"].GetString()];
    CHECK(events["plan"] == 1);
    CHECK(events["material"] == 6);
    CHECK(events["progress"] >= 6);
}

TEST_CASE("bake: keys change with everything that changes bytes, and with nothing else") {
    const Folder folder;
    WriteSource(folder / "a.png", 1);
    EncodeJob job;
    ManifestTexture texture;
    texture.path = (folder / "a.png").string();
    texture.name = "a";
    job.inputs.manifest.emplace();
    job.inputs.manifest->textures.push_back(texture);
    const std::string key = MakeContentKey(job);
    const auto differs = [&](auto change) {
        EncodeJob changed;
        changed = job; // clang-tidy takes an initialisation for a copy that nobody changes
        change(changed);
        return MakeContentKey(changed) != key;
    };
    using Job = EncodeJob&;
    CHECK(differs([](Job j) { j.training.encode.seed = 2; }));
    CHECK(differs([](Job j) { j.training.encode.steps = 7; }));
    CHECK(differs([](Job j) { j.training.encode.seconds = 7; }));
    CHECK(differs([](Job j) { j.training.encode.effort = openntc::encode::Effort::Fast; }));
    CHECK(differs([](Job j) { j.training.encode.bitsPerPixel = 3.0f; }));
    CHECK(differs([](Job j) { j.training.encode.latentShape = {4, 8, 8, 4, 4}; }));
    CHECK(differs([](Job j) { j.training.encode.networkVersion = 1; }));
    CHECK(differs([](Job j) { j.training.encode.fp8 = true; }));
    CHECK(differs([](Job j) { j.training.encode.discardMasked = true; }));
    CHECK(differs([](Job j) { j.training.encode.kernel = openntc::encode::KernelChoice::Portable; }));
    CHECK(differs([](Job j) { j.training.encode.batchTexels = 8192; }));
    CHECK(differs([](Job j) { j.training.targetPsnr = 40.0; }));
    CHECK(differs([](Job j) { j.training.textureTargets = {{"a", 40.0}}; }));
    CHECK(differs([](Job j) { j.inputs.manifest->mips.filter = openntc::image::MipFilter::Kaiser; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].normalMap = true; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].targetPsnr = 30.0; }));
    CHECK(differs([](Job j) { j.training.maximumBits = 4.0; }));
    CHECK(differs([](Job j) { j.inputs.mipFilter = openntc::image::MipFilter::Kaiser; }));
    CHECK(differs([](Job j) { j.inputs.mipWrap = openntc::image::MipWrap::Clamp; }));
    CHECK(differs([](Job j) { j.inputs.normalMaps = {"a"}; }));
    CHECK(differs([](Job j) { j.inputs.weights = {{"a", 2.0}}; }));
    CHECK(differs([](Job j) { j.inputs.keepCoverage = 0.5f; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].alphaIsData = true; }));
    CHECK(differs([](Job j) { j.inputs.mips = 2; }));
    CHECK(differs([](Job j) { j.inputs.manifest->width = 16; }));
    CHECK(differs([](Job j) { j.inputs.manifest->keepCoverage = 0.5f; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].name = "b"; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].swizzle = "R"; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].isSrgb = true; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].firstChannel = 3; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].lossScales = {0.5f}; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].verticalFlip = true; }));
    CHECK(differs([](Job j) { j.inputs.manifest->textures[0].maskLetter = 'A'; }));
    WriteSource(folder / "b.png", 2);
    CHECK(differs([&](Job j) { j.inputs.manifest->textures[0].path = (folder / "b.png").string(); }));
    WriteSource(folder / "c.png", 1);
    CHECK_FALSE(differs([&](Job j) { j.inputs.manifest->textures[0].path = (folder / "c.png").string(); }));
    CHECK_FALSE(differs([](Job j) { j.training.encode.threads = 3; }));
    CHECK_FALSE(differs([](Job j) { j.training.device = "0"; }));
    CHECK_FALSE(differs([](Job j) { j.training.encode.saveSeconds = 3.0; }));
    CHECK_FALSE(differs([](Job j) { j.output = "elsewhere"; }));
}
