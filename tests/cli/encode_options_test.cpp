// SPDX-License-Identifier: MIT
// Options of `ntc encode`, and of the other commands where they share them: limits, contradictions, inputs
// that are no files, outputs that are inputs, states.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <cmath>
#include <set>

using namespace openntc_tests;

namespace {

float OptionWave(float u, float v, int c) {
    return 0.5f + 0.4f * std::sin(6.3f * (u + static_cast<float>(c) * 0.3f)) * std::cos(6.3f * v);
}

std::set<std::string> ListFiles(const Folder& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.GetPath()))
        names.insert(entry.path().filename().string());
    return names;
}

} // namespace

TEST_CASE("numbers outside their range: exit 2 naming option, value and limits") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, OptionWave));
    struct NumberOption {
        const char* command;
        const char* option;
        const char* limits;
        std::vector<std::string> refused;
    };
    const std::string huge = "1000000000000000000000";
    const std::vector<std::string> never = {"nan", "x", "1x", " 1", huge};
    const std::vector<NumberOption> options = {
        {"encode a.png -o a.ntc", "--steps", "1 to 1000000000", {"-5", "0", "1.5", "1000000001"}},
        {"encode a.png -o a.ntc", "--seconds", "0.001 to 1000000000", {"-1", "0", "inf"}},
        {"encode a.png -o a.ntc --steps 1", "--bits-per-pixel", "0.01 to 1000", {"-4", "0", "inf"}},
        {"encode a.png -o a.ntc --steps 1", "--target-psnr", "0.001 to 1000", {"-1", "0"}},
        {"encode a.png -o a.ntc --steps 1 --target-psnr 5",
         "--max-bits-per-pixel",
         "0.01 to 1000",
         {"-1", "0"}},
        {"encode a.png -o a.ntc --steps 1", "--seed", "0 to 4294967295", {"-1", "4294967296"}},
        {"encode a.png -o a.ntc --steps 1", "--threads", "0 to 256", {"-1", "257"}},
        {"encode a.png -o a.ntc --steps 1", "--mips", "1 to 16", {"-1", "0", "17"}},
        {"encode a.png -o a.ntc --steps 1", "--save-every", "0 to 1000000000", {"-1"}},
        {"encode a.png -o a.ntc --steps 1", "--keep-coverage", "to 1", {"-1", "0", "1.1"}},
        {"convert-gltf a.gltf -o o", "--steps", "1 to 1000000000", {"-1", "0"}},
        {"convert-gltf a.gltf -o o", "--jobs", "1 to 64", {"-1", "0", "65"}},
        {"convert-gltf a.gltf -o o", "--mips", "1 to 16", {"0"}},
        {"bench decode a.ntc", "--repeat", "1 to 1000", {"-1", "0", "1001"}},
        {"report -o o", "--steps", "1 to 1000000000", {"-1", "0"}},
        {"conformance o", "--timeout", "0.1 to 86400", {"-1", "0"}}};
    const std::set<std::string> before = ListFiles(folder);
    for (const NumberOption& option : options) {
        std::vector<std::string> values = option.refused;
        values.insert(values.end(), never.begin(), never.end());
        for (const std::string& value : values) {
            const std::string arguments =
                std::string(option.command) + " " + option.option + "='" + value + "'";
            CAPTURE(arguments);
            const ProgramResult result = RunProgram(folder, arguments);
            CAPTURE(result.errors);
            CheckFails(result, 2);
            CHECK(result.errors.starts_with("ntc: " + std::string(option.option) + ": " + value +
                                            ": must be "));
            CHECK(result.errors.find(option.limits) != std::string::npos);
        }
    }
    CHECK(ListFiles(folder) == before);
}

TEST_CASE("options that contradict each other are refused by name, and so are values of flags") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, OptionWave));
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"--steps 2 --seconds 1", "--steps"},
        {"--steps 2 --effort fast", "--steps"},
        {"--seconds 1 --effort fast", "--seconds"},
        {"--bits-per-pixel 4 --latent-shape 4,8,8,2,4", "--latent-shape"},
        {"--bits-per-pixel 4 --target-psnr 30", "--target-psnr"},
        {"--max-bits-per-pixel 4", "--max-bits-per-pixel"},
        {"--bits-per-pixel 50", "--bits-per-pixel"},
        {"--latent-shape 2,12,8,2,4 --network small", "--latent-shape"},
        {"--mask-channel 9", "--mask-channel"},
        {"--srgb nobody", "--srgb: nobody"},
        {"--linear nobody", "--linear: nobody"},
        {"--srgb a --linear a", "--linear: a"},
        {"--keep-coverage 0.5", "--keep-coverage"},
        {"--strict=9", "strict"}};
    for (const auto& row : cases) {
        const auto& [arguments, text] = row;
        CAPTURE(row.first);
        const ProgramResult result = RunProgram(folder, "encode a.png -o a.ntc --quiet " + arguments);
        CAPTURE(result.errors);
        CheckFails(result, 2);
        CHECK(result.errors.find(text) != std::string::npos);
    }
    CheckFails(RunProgram(folder, "decode a.ntc -o o --mips=9"), 2);
    CHECK(ListFiles(folder) == std::set<std::string>{"a.png"});
}

TEST_CASE("an output that is an input is refused, by whatever name") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, OptionWave));
    WriteText(folder / "m.json", R"({"textures":[{"fileName":"a.png"}]})");
    fs::create_hard_link(folder / "a.png", folder / "hard.ntc");
    fs::create_symlink("a.png", folder / "soft.ntc");
    const std::string image = ReadText(folder / "a.png"), manifest = ReadText(folder / "m.json");
    for (const std::string arguments : {"a.png -o a.png", "a.png -o ./a.png", "a.png -o hard.ntc",
                                        "a.png -o soft.ntc", "m.json -o a.png", "m.json -o m.json"}) {
        CAPTURE(arguments);
        const ProgramResult result = RunProgram(folder, "encode --steps 2 --quiet " + arguments);
        CheckFails(result, 2);
        CHECK(result.errors.find("is an input") != std::string::npos);
        CHECK(ReadText(folder / "a.png") == image);
        CHECK(ReadText(folder / "m.json") == manifest);
    }
    const ProgramResult other = RunProgram(folder, "encode --steps 2 a.png -o a.bin");
    CHECK(other.code == 0);
    CHECK(other.errors.find("warning: a.bin: name: does not end in .ntc") != std::string::npos);
}

TEST_CASE("pipes and standard input are images like others; standard output is refused") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, OptionWave));
    const std::string options = " --steps 2 --quiet -o ";
    REQUIRE(RunProgram(folder, "encode a.png" + options + "file.ntc --srgb a").code == 0);
    // The names of the textures differ, so the files do; their texels must not.
    REQUIRE(RunProgram(folder, "encode - --srgb stdin" + options + "stdin.ntc < a.png").code == 0);
    REQUIRE(RunProgram(folder, "encode /dev/stdin --srgb stdin" + options + "device.ntc < a.png").code == 0);
    REQUIRE(RunProgram(folder, "--version; mkfifo p; cat a.png > p & '" NTC_PROGRAM "' encode p --srgb p" +
                                   options + "fifo.ntc")
                .code == 0);
    for (const std::string name : {"stdin", "device", "fifo"}) {
        CAPTURE(name);
        const ProgramResult result = RunProgram(folder, "compare --json file.ntc " + name + ".ntc");
        REQUIRE(result.code == 0);
        CHECK(ParseValid(result.output, "compare")["psnr"].GetString() == std::string("inf"));
    }
    // What `compare` looks at to tell files apart must still be there when they are read.
    CHECK(RunProgram(folder, "compare a.png - < a.png").output.starts_with("psnr inf"));
    CHECK(RunProgram(folder, "compare file.ntc - < file.ntc").output.starts_with("psnr inf"));
    CHECK(RunProgram(folder, "compare file.ntc - < a.png").output.starts_with("psnr "));
    CHECK(RunProgram(folder, "compare - a.png < file.ntc").output.starts_with("psnr "));
    // Endless input ends.
    CheckFails(RunProgram(folder, "encode /dev/zero -o z.ntc --steps 2"), 3);
    CheckFails(RunProgram(folder, "info /dev/zero"), 3);
    for (const std::string arguments :
         {"encode a.png -o -", "decode file.ntc -o -", "convert-gltf a.gltf -o -",
          "compare a.png a.png --images -", "report -o -"}) {
        CAPTURE(arguments);
        const ProgramResult result = RunProgram(folder, arguments);
        CheckFails(result, 2);
        CHECK(result.errors.find("standard output") != std::string::npos);
    }
    CHECK_FALSE(fs::exists(folder / "-"));
}

TEST_CASE("what the system refuses has the system's reason") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, OptionWave));
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"encode nowhere.png -o a.ntc", "nowhere.png: cannot be opened for reading: No such file"},
        {"encode nowhere.json -o a.ntc", "nowhere.json: cannot be opened for reading: No such file"},
        {"compare a.png nowhere.ntc", "nowhere.ntc: cannot be opened for reading: No such file"},
        {"info nowhere.ntc", "nowhere.ntc: cannot be opened for reading: No such file"},
        {"encode a.png -o nowhere/a.ntc", "nowhere/a.ntc: cannot be created: No such file"},
        {"encode a.png -o b.ntc --resume", "b.ntc.state: cannot be opened for reading: No such file"}};
    for (const auto& row : cases) {
        const auto& [arguments, text] = row;
        CAPTURE(row.first);
        const ProgramResult result = RunProgram(folder, arguments);
        CAPTURE(result.errors);
        CHECK(result.code != 0);
        CHECK(result.errors.starts_with("ntc: " + text));
    }
}

TEST_CASE("SIGTERM keeps the state as an interrupt does") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, OptionWave));
    const ProgramResult result = RunProgram(
        folder, "--version >/dev/null; " + SignalAfter(2, "TERM") +
                    "'" NTC_PROGRAM "' encode a.png -o a.ntc --steps 1000000000 --bits-per-pixel 1 --quiet");
    CheckFails(result, 1);
    CHECK(result.errors.find("--resume") != std::string::npos);
    CHECK(ListFiles(folder) == std::set<std::string>{"a.png", "a.ntc.state"});
}

TEST_CASE("a killed run goes on from its last state, to the same bytes") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, OptionWave));
    const std::string command = "encode a.png --steps 80 --threads 1 --bits-per-pixel 1 --quiet -o ";
    // Killed as soon as a state is there. A run that ended before says so by its file, and shows less.
    const ProgramResult killed =
        RunProgram(folder, "--version >/dev/null; '" NTC_PROGRAM "' " + command +
                               "a.ntc --save-every 0.05 & p=$!; while kill -0 $p 2>/dev/null && "
                               "[ ! -s a.ntc.state ]; do sleep 0.02; done; kill -KILL $p; wait $p");
    INFO(killed.errors);
    if (fs::exists(folder / "a.ntc")) {
        MESSAGE("SKIP: the run ended before it could be killed");
        return;
    }
    REQUIRE(fs::exists(folder / "a.ntc.state"));
    REQUIRE(RunProgram(folder, command + "a.ntc --resume").code == 0);
    REQUIRE(RunProgram(folder, command + "b.ntc --save-every 0").code == 0);
    CHECK(ReadText(folder / "a.ntc") == ReadText(folder / "b.ntc"));
    CHECK_FALSE(fs::exists(folder / "a.ntc.state"));
}
