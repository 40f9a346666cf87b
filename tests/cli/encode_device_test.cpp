// SPDX-License-Identifier: MIT
// `--device` of encode, bake and convert-gltf on a Vulkan device: the bytes of a run, whatever stops it, and what is said.
#include "cli/BakeTree.h"

#include <sstream>

using namespace openntc_tests;

namespace {

/// The device that tests use, as an option; empty: there is none, which is said.
std::string FindDeviceOption(const Folder& folder) {
    const char* wanted = std::getenv("OPENNTC_TEST_DEVICE");
    const std::string name = wanted != nullptr ? wanted : "llvmpipe";
    const ProgramResult result = RunProgram(folder, "devices --json");
    if (result.code == 0) {
        const auto list = ParseValid(result.output, "devices");
        for (const auto& device : list["devices"].GetArray()) {
            if (std::string(device["name"].GetString()).find(name) != std::string::npos)
                return " --device '" + name + "' ";
        }
    }
    MESSAGE("SKIP: no Vulkan device: " << name);
    return {};
}

// A software driver needs most of a second for a step: few of them.
const std::string kSmall = " --network small --latent-shape 4,4,4,2,4 --batch 1024 --threads 1 ";

/// Sends the signal as soon as the shell's command `until` succeeds.
ProgramResult Interrupt(const Folder& folder, const std::string& arguments, const std::string& until,
                        const std::string& signal) {
    return RunProgram(folder, "--version >/dev/null; '" NTC_PROGRAM "' " + arguments +
                                  " & p=$!; while kill -0 $p 2>/dev/null && ! { " + until +
                                  "; }; do sleep 0.02; done; kill -" + signal + " $p; wait $p");
}

} // namespace

TEST_CASE("encode --device: kernel and expected time are said; equal bytes, also after SIGTERM") {
    const Folder folder;
    const std::string device = FindDeviceOption(folder);
    if (device.empty())
        return;
    WriteSource(folder / "a.png", 1);
    const std::string encode = "encode a.png --steps 2 --save-every 0.01" + kSmall + device;
    const ProgramResult whole = RunProgram(folder, encode + "-o a.ntc --json");
    INFO(whole.errors);
    REQUIRE(whole.code == 0);
    const std::string kernel = ParseValid(whole.output, "encode")["kernel"].GetString();
    CHECK(kernel.starts_with("vulkan"));

    const ProgramResult stopped =
        Interrupt(folder, encode + "-o c.ntc --quiet", "[ -e c.ntc.state ]", "TERM");
    CHECK(stopped.code == 1);
    CHECK(stopped.errors.find("state kept in c.ntc.state: --resume continues") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "c.ntc"));
    // The processor's kernels do not go on from it.
    const ProgramResult refused = RunProgram(
        folder, "encode a.png --steps 2 --network small --latent-shape 4,4,4,2,4 -o c.ntc --resume --quiet");
    CheckFails(refused, 3);
    REQUIRE(RunProgram(folder, encode + "-o c.ntc --quiet --resume").code == 0);
    CHECK(ReadText(folder / "c.ntc") == ReadText(folder / "a.ntc"));
    CHECK_FALSE(fs::exists(folder / "c.ntc.state"));

    const ProgramResult third = RunProgram(
        folder,
        "encode a.png --generation 3 --latent-shape 4,4 --batch 1024 --steps 1 --json -o e.ntc" + device);
    INFO(third.errors);
    REQUIRE(third.code == 0);
    CHECK(ParseValid(third.output, "encode")["kernel"].GetString() == kernel);
    const ProgramResult info = RunProgram(folder, "info e.ntc --json");
    CHECK(ParseValid(info.output, "info")["generation"].GetInt() == 3);
    CHECK(RunProgram(folder, "validate e.ntc").code == 0);

    // A training without end, until its pace is known.
    const ProgramResult endless =
        Interrupt(folder, "encode a.png -o d.ntc --steps 1000000000 --json" + kSmall + device + "2>log",
                  "grep -q estimate log", "TERM");
    CHECK(endless.code == 1);
    std::istringstream lines(ReadText(folder / "log"));
    int estimates = 0;
    for (std::string line; std::getline(lines, line) && line.starts_with("{");) {
        const auto event = ParseValid(line, "encode-event");
        if (event["event"].GetString() != std::string("estimate"))
            continue;
        ++estimates;
        CHECK(event["kernel"].GetString() == kernel);
        CHECK(event["seconds"].GetDouble() > 0.0);
        CHECK(event["steps"].GetInt64() == 1000000000);
    }
    CHECK(estimates == 1);
}

TEST_CASE("a device that is not there: exit 4, named, and nothing written; states and files stay") {
    const Folder folder;
    WriteSource(folder / "art/A_D.png", 1);
    WriteText(folder / "model.gltf", R"({"asset":{"version":"2.0"},"images":[{"uri":"art/A_D.png"}],
        "textures":[{"source":0}],"materials":[{"normalTexture":{"index":0}}]})");
    for (const char* command : {"encode art/A_D.png -o a.ntc", "convert-gltf model.gltf -o out"}) {
        CAPTURE(command);
        const ProgramResult result =
            RunProgram(folder, std::string(command) + " --steps 1 --quiet --device nosuchdevice");
        CHECK(result.code == 4);
        CHECK(result.output.empty());
        CHECK(result.errors.find("nosuchdevice") != std::string::npos);
    }
    // Of many materials each fails with its line.
    const ProgramResult bake = RunProgram(folder, "bake art -o out --steps 1 --quiet --device nosuchdevice");
    CHECK(bake.code == 1);
    CHECK(bake.errors.find("nosuchdevice") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "a.ntc"));
    CHECK(CountFiles(folder / "", ".ntc") == 0);
}

TEST_CASE("bake --device: two at a time, killed and gone on with: the bytes of a bake that was not") {
    const Folder folder;
    const std::string device = FindDeviceOption(folder);
    if (device.empty())
        return;
    for (int i = 0; i < 2; ++i)
        WriteSource(folder / ("art/M" + std::to_string(i) + "_D.png"), i);
    const std::string settings = " --steps 2 --quiet --jobs 2 " + kSmall + device;
    Interrupt(folder, "bake art -o out --save-every 0.01" + settings, "find out -name '*.state' | grep -q .",
              "KILL");
    CHECK(CountFiles(folder / "out", ".state") > 0);
    const ProgramResult again = RunProgram(folder, "bake art -o out" + settings);
    INFO(again.errors);
    REQUIRE(again.code == 0);
    CHECK(again.errors.find("begun again") == std::string::npos);
    CHECK(CountFiles(folder / "out", ".state") == 0);
    REQUIRE(RunProgram(folder, "bake art -o whole" + settings).code == 0);
    const auto sets = ReadSets(folder / "out");
    CHECK(sets.size() == 2);
    CHECK(sets == ReadSets(folder / "whole"));

    // Where a file was made is no reason to make it again; an option that changes what is asked for is.
    const auto describe = [&](const std::string& options) {
        const auto list = ParseValid(
            RunProgram(folder, "bake art -o out --dry-run --json --steps 2 --network small " + options)
                .output,
            "bake");
        const auto& first = list["materials"][0];
        return std::string(first["status"].GetString()) + " " +
               (first.HasMember("reason") ? first["reason"].GetString() : first["kernel"].GetString());
    };
    const std::string shape = "--latent-shape 4,4,4,2,4 ";
    CHECK(describe(shape + "--batch 1024" + device).starts_with("unchanged vulkan"));
    CHECK(describe(shape + "--batch 2048" + device) == "due settings");
}

TEST_CASE("bake: files of another kernel or device are kept, but for --portable, which asks for its bytes") {
    const Folder folder;
    WriteSource(folder / "art/A_D.png", 1);
    const std::string bake = "bake art -o out --steps 4 --bits-per-pixel 1 --json ";
    const auto run = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, bake + options);
        REQUIRE(result.code == 0);
        const auto list = ParseValid(result.output, "bake");
        const auto& material = list["materials"][0];
        return std::string(material["status"].GetString()) + " " +
               (material.HasMember("reason") ? material["reason"].GetString()
                                             : material["kernel"].GetString());
    };
    CHECK(run("") == "made new");
    const std::string kernel = run("--dry-run");
    // Not asked for on any device: nothing is made.
    CHECK(run("--dry-run --device nosuchdevice") == kernel);
    CHECK(run("--portable") == "made settings");
    CHECK(run("--portable --dry-run") == "unchanged portable");
    CHECK(run("--dry-run") == "due settings");
}

TEST_CASE("convert-gltf --device makes the files of encode --device") {
    const Folder folder;
    const std::string device = FindDeviceOption(folder);
    if (device.empty())
        return;
    WriteSource(folder / "n.png", 1);
    WriteText(folder / "model.gltf", R"({"asset":{"version":"2.0"},"images":[{"uri":"n.png"}],
        "textures":[{"source":0}],"materials":[{"name":"M","normalTexture":{"index":0}}]})");
    const std::string settings = " --steps 1 --quiet" + kSmall + device;
    REQUIRE(RunProgram(folder, "convert-gltf model.gltf -o out --keep-manifests" + settings).code == 0);
    REQUIRE(RunProgram(folder, "encode out/M.manifest.json -o m.ntc" + settings).code == 0);
    CHECK(ReadText(folder / "m.ntc") == ReadText(folder / "out/M.ntc"));
    CHECK(RunProgram(folder, "validate m.ntc").code == 0);
}
