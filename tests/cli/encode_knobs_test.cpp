// SPDX-License-Identifier: MIT
// What artists set of quality: weights, filters of mips, normal maps, targets of single textures; and what encode says of its
// time.
#include "cli/ImageFiles.h"
#include "cli/Program.h"
#include "encode/TrainingProgress.h"

#include <cmath>
#include <sstream>

using namespace openntc_tests;

namespace {

float Hills(float u, float v, int c) {
    return 0.5f + 0.3f * std::sin(25.1f * (u + static_cast<float>(c) * 0.3f)) * std::cos(18.8f * v);
}

/// Texture `index`'s member of the result of `encode --json`.
double GetPsnr(const rapidjson::Value& encoded, unsigned index) {
    const rapidjson::Value& value = encoded["textures"][index]["psnr"];
    return value.IsString() ? std::strtod(value.GetString(), nullptr) : value.GetDouble();
}

void WriteTwo(const Folder& folder) {
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, Hills));
    WriteImage(folder / "n.png",
               MakeImage(32, 32, 3, [](float u, float v, int c) { return Hills(v, u, c + 1); }));
}

} // namespace

TEST_CASE(
    "knobs of mips and weights: a manifest and the command line say the same, and each changes the file") {
    const Folder folder;
    WriteTwo(folder);
    const auto write = [&](const std::string& root, const std::string& a, const std::string& n) {
        WriteText(folder / "m.json", "{" + root + "\"textures\":[{\"fileName\":\"a.png\",\"isSRGB\":true" +
                                         a + "},{\"fileName\":\"n.png\"" + n + "}]}");
    };
    const std::string end = " --steps 2 --quiet --threads 1 -o ";
    write("", "", "");
    REQUIRE(RunProgram(folder, "encode m.json" + end + "plain.ntc").code == 0);
    struct Knob {
        const char *option, *root, *a, *n;
    };
    for (const Knob& knob :
         {Knob{"--mip-filter kaiser", R"("mipFilter":"kaiser",)", "", ""},
          Knob{"--mip-filter kaiser --mip-wrap clamp", R"("mipFilter":"kaiser","mipWrap":"clamp",)", "", ""},
          Knob{"--normal-map n", "", "", R"(,"normalMap":true)"},
          Knob{"--weight a.png=2.5", "", R"(,"lossFunctionScale":2.5)", ""}}) {
        CAPTURE(knob.option);
        write("", "", "");
        REQUIRE(RunProgram(folder, "encode m.json " + std::string(knob.option) + end + "option.ntc").code ==
                0);
        write(knob.root, knob.a, knob.n);
        REQUIRE(RunProgram(folder, "encode m.json" + end + "manifest.ntc").code == 0);
        CHECK(ReadText(folder / "option.ntc") == ReadText(folder / "manifest.ntc"));
        CHECK(ReadText(folder / "option.ntc") != ReadText(folder / "plain.ntc"));
    }
    // A texture's own filter is neither the manifest's nor the option's.
    write(R"("mipFilter":"kaiser",)", R"(,"mipFilter":"box")", R"(,"mipFilter":"box")");
    REQUIRE(RunProgram(folder, "encode m.json --mip-filter kaiser" + end + "own.ntc").code == 0);
    CHECK(ReadText(folder / "own.ntc") == ReadText(folder / "plain.ntc"));
}

TEST_CASE("knobs that make no sense are refused by name") {
    const Folder folder;
    WriteTwo(folder);
    WriteImage(folder / "gray.png", MakeImage(32, 32, 1, Hills));
    const std::pair<const char*, const char*> options[] = {
        {"--mip-filter lanczos", "--mip-filter: lanczos: box, kaiser"},
        {"--mip-wrap mirror", "--mip-wrap: mirror: wrap, clamp"},
        {"--normal-map nobody", "--normal-map: nobody: no texture"},
        {"--weight a", "--weight: a: NAME=NUMBER"},
        {"--weight =2", "--weight: =2: NAME=NUMBER"},
        {"--weight a=-1", "--weight: -1: must be"},
        {"--weight nobody=1", "--weight: nobody: no texture"},
        {"--weight a=0 --weight n=0", "weight: 0 for every texture: one must be above 0"},
        {"--target-psnr nobody=30", "--target-psnr: nobody: no texture"},
        {"--target-psnr a=x", "--target-psnr: x: must be"}};
    for (const auto& row : options) {
        const auto& [option, text] = row;
        CAPTURE(row.first);
        const ProgramResult result =
            RunProgram(folder, "encode a.png n.png --steps 2 -o x.ntc " + std::string(option));
        CAPTURE(result.errors);
        CheckFails(result, 2);
        CHECK(result.errors.find(text) != std::string::npos);
    }
    const std::pair<const char*, const char*> manifests[] = {
        {R"({"mipFilter":"x","textures":[{"fileName":"a.png"}]})", "mipFilter: x: box or kaiser"},
        {R"({"mipWrap":1,"textures":[{"fileName":"a.png"}]})", "mipWrap: must be a string"},
        {R"({"textures":[{"fileName":"a.png","targetPsnr":0}]})",
         "textures[0].targetPsnr: must be a number above 0"},
        {R"({"textures":[{"fileName":"a.png","normalMap":1}]})",
         "textures[0].normalMap: must be true or false"},
        {R"({"textures":[{"fileName":"a.png","isSRGB":true,"normalMap":true}]})", "normalMap: an sRGB image"},
        {R"({"textures":[{"fileName":"gray.png","normalMap":true}]})", "normalMap: 1 channel"}};
    for (const auto& row : manifests) {
        const auto& [manifest, text] = row;
        CAPTURE(row.first);
        WriteText(folder / "m.json", manifest);
        const ProgramResult result = RunProgram(folder, "encode m.json --steps 2 -o x.ntc");
        CAPTURE(result.errors);
        CheckFails(result, 3);
        CHECK(result.errors.find(text) != std::string::npos);
    }
    CHECK_FALSE(fs::exists(folder / "x.ntc"));
}

TEST_CASE("a weight moves quality from the other textures to its own") {
    const Folder folder;
    WriteTwo(folder);
    const std::string command = "encode a.png n.png -o x.ntc --json --quiet --steps 120 --bits-per-pixel 2";
    const auto plain = ParseValid(RunProgram(folder, command).output, "encode");
    const auto weighed = ParseValid(RunProgram(folder, command + " --weight a=16").output, "encode");
    CHECK(GetPsnr(weighed, 0) > GetPsnr(plain, 0));
    CHECK(GetPsnr(weighed, 1) < GetPsnr(plain, 1));
}

TEST_CASE("targets of single textures: the smallest shape that reaches each") {
    const Folder folder;
    WriteTwo(folder);
    const std::string command =
        "encode a.png n.png -o x.ntc --json --quiet --steps 60 --max-bits-per-pixel 8";
    // What a few bits reach is what more bits reach too; the texture with the higher target decides.
    const auto small = ParseValid(
        RunProgram(folder, "encode a.png n.png -o s.ntc --json --quiet --steps 60 --bits-per-pixel 2").output,
        "encode");
    const double a = GetPsnr(small, 0) - 1.0, n = GetPsnr(small, 1) - 0.5;
    const std::string targets =
        " --target-psnr a=" + std::to_string(a) + " --target-psnr n.png=" + std::to_string(n);
    ProgramResult result = RunProgram(folder, command + targets);
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto found = ParseValid(result.output, "encode");
    CHECK(GetPsnr(found, 0) >= a);
    CHECK(GetPsnr(found, 1) >= n);
    // The file holds what was said of it: 0.05 dB is what 16 bits of the references leave open.
    WriteText(folder / "m.json", R"({"textures":[{"fileName":"a.png"},{"fileName":"n.png"}]})");
    const auto compared = ParseValid(RunProgram(folder, "compare --json m.json x.ntc").output, "compare");
    for (unsigned i = 0; i < 2; ++i)
        CHECK(std::fabs(compared["textures"][i]["psnr"].GetDouble() - GetPsnr(found, i)) < 0.05);
    // One that nothing reaches is named; with a size of its own a manifest's targets are only checked.
    result = RunProgram(folder, command + " --target-psnr a=5 --target-psnr n=90");
    CHECK(result.code == 1);
    CHECK(result.errors.find("n: ") != std::string::npos);
    CHECK(result.errors.find("the target is 90.00; the best file was kept") != std::string::npos);
    CHECK(result.errors.find("the target is 5") == std::string::npos);
    WriteText(folder / "m.json",
              R"({"textures":[{"fileName":"a.png","targetPsnr":5},{"fileName":"n.png","targetPsnr":91}]})");
    result = RunProgram(folder, "encode m.json -o x.ntc --json --quiet --steps 2 --bits-per-pixel 1");
    CHECK(result.code == 1);
    CHECK(result.errors.find("\"trial\"") == std::string::npos);
    CHECK(result.errors.find("the target is 91.00") != std::string::npos);
}

TEST_CASE("encode says at the start what it takes, with which kernel, and names budgets that are too small") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, Hills));
    // Stopped when the pace is known.
    const ProgramResult result =
        RunProgram(folder, "--version >/dev/null; " + SignalAfter(4, "TERM") +
                               "'" NTC_PROGRAM "' encode a.png -o a.ntc --effort best --json --threads 2");
    CHECK(result.code == 1);
    std::istringstream lines(result.errors);
    int estimates = 0;
    std::string kernel;
    for (std::string line; std::getline(lines, line) && line.starts_with("{");) {
        const auto event = ParseValid(line, "encode-event");
        if (event["event"].GetString() != std::string("estimate"))
            continue;
        ++estimates;
        CHECK(event["threads"].GetInt() == 2);
        CHECK(event["steps"].GetInt() > 30000);
        CHECK(event["steps"].GetInt() < 33000); // 32 x 32, however good
        CHECK(event["seconds"].GetDouble() > 1.0);
        kernel = event["kernel"].GetString();
    }
    CHECK(estimates == 1);
    const ProgramResult few = RunProgram(folder, "encode a.png -o b.ntc --steps 2 --json --quiet");
    CHECK(few.code == 0);
    CHECK(ParseValid(few.output, "encode")["kernel"].GetString() == kernel);
    CHECK(few.errors.find("b.ntc: --steps 2: too few for this quality: a useful result needs 1000") !=
          std::string::npos);
}

TEST_CASE("share of the processor: work in eight slices keeps no more threads busy than they are dealt to") {
    using openntc::tool::GetProcessorShare;
    CHECK(GetProcessorShare(1.0, 1.0, 1) == 1.0);
    CHECK(GetProcessorShare(1.0, 1.0, 2) == 0.5);
    CHECK(GetProcessorShare(2.0, 1.0, 3) == doctest::Approx(2.0 / (8.0 / 3.0)));
    CHECK(GetProcessorShare(4.0, 1.0, 7) == 1.0); // two rounds of at most seven slices
    CHECK(GetProcessorShare(8.0, 2.0, 64) == 0.5);
    CHECK(GetProcessorShare(9.0, 1.0, 2) == 1.0);
    CHECK(GetProcessorShare(0.0, 0.0, 2) == 0.0);
#if !defined(_WIN32)
    CHECK(openntc::tool::GetProcessorSeconds() > 0.0);
#endif
}
