// SPDX-License-Identifier: MIT
// `ntc help`, `--help` and `--version`: plain words, examples, exit codes.
#include "cli/Program.h"

#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

const std::vector<std::string> kHelpCommands = {"info",
                                                "validate",
                                                "decode",
                                                "sample",
                                                "constants",
                                                "devices",
                                                "encode",
                                                "migrate",
                                                "convert-gltf",
                                                "compare",
                                                "conformance",
                                                "conformance run",
                                                "conformance export",
                                                "bench",
                                                "bench decode",
                                                "bench load",
                                                "bench loader",
                                                "bench slices",
                                                "bench tiles",
                                                "bake",
                                                "bc-test",
                                                "report",
                                                "export",
                                                "help",
                                                "compile-shaders",
                                                "optimize-bc"};

std::string EscapeHyphens(std::string text) {
    for (std::size_t at = text.find('-'); at != std::string::npos; at = text.find('-', at + 2))
        text.insert(at, "\\");
    return text;
}

} // namespace

TEST_CASE("help is the same asked in both ways, and shows nothing of the parser's own words") {
    const Folder folder;
    for (const std::string& command : kHelpCommands) {
        CAPTURE(command);
        const ProgramResult help = RunProgram(folder, "help " + command);
        CHECK(help.code == 0);
        CHECK(help.errors.empty());
        const ProgramResult flag = RunProgram(folder, command + " --help");
        CHECK(flag.code == 0);
        CHECK(help.output == flag.output);
        CHECK(help.output.find("ntc " + command) != std::string::npos);
        for (const char* leak : {"->", " in [", "ENUM", ":INT", ":FLOAT", "TEXT:", "} OR {", "UINT", "0x0"}) {
            CAPTURE(leak);
            CHECK(help.output.find(leak) == std::string::npos);
        }
    }
    const std::string all = RunProgram(folder, "--help").output;
    CHECK(RunProgram(folder, "help").output == all);
    CHECK(all.find("Exit codes: 0 ok, 1 the work failed, 2 usage, 3 bad input file, 4 no device") !=
          std::string::npos);
    CHECK(all.find("Examples:") != std::string::npos);
    const std::string convert = RunProgram(folder, "help convert-gltf").output;
    CHECK(convert.find("ntc convert-gltf model.glb") != std::string::npos);
    CHECK(convert.find("--jobs N (1 to 64)") != std::string::npos);
    CHECK(RunProgram(folder, "help conformance run").output.find("(json, junit, text)") != std::string::npos);
    CheckFails(RunProgram(folder, "help nonsense"), 2);
    CheckFails(RunProgram(folder, "help conformance nonsense"), 2);
}

TEST_CASE("the manual page and the completions have every command and option") {
    const Folder folder;
    const std::string manual = RunProgram(folder, "help --man").output;
    CHECK(manual.starts_with(".TH NTC 1"));
    const std::string bash = RunProgram(folder, "help --completion bash").output;
    const std::string zsh = RunProgram(folder, "help --completion zsh").output;
    const std::string fish = RunProgram(folder, "help --completion fish").output;
    for (const std::string& command : kHelpCommands) {
        CAPTURE(command);
        CHECK(manual.find(".SS \"ntc " + EscapeHyphens(command) + "\"") != std::string::npos);
        CHECK(bash.find("'" + command + "') options=") != std::string::npos);
        CHECK(zsh.find("'" + command + "')") != std::string::npos);
        CHECK(fish.find(" -a " + command.substr(command.find(' ') + 1) + " -d '") != std::string::npos);
    }
    CHECK(manual.find("\\-\\-bits\\-per\\-pixel\n") != std::string::npos);
    CHECK(zsh.find("'*--bits-per-pixel[") != std::string::npos);
    CHECK(fish.find("-l bits-per-pixel -r -d '") != std::string::npos);
    CheckFails(RunProgram(folder, "help --completion tcsh"), 2);
    CheckFails(RunProgram(folder, "help --man --completion bash"), 2);
    CheckFails(RunProgram(folder, "help encode --man"), 2);
}

TEST_CASE("shells complete commands, options and values") {
    const Folder folder;
    WriteText(folder / "ntc.bash", RunProgram(folder, "help --completion bash").output);
    WriteText(folder / "complete.bash", "source ./ntc.bash\n"
                                        "COMP_WORDS=(ntc \"$@\")\n"
                                        "COMP_CWORD=$#\n"
                                        "_ntc\n"
                                        "echo \"${COMPREPLY[*]}\"\n");
    const auto complete = [&](const std::string& words) {
        return RunProgram(folder, "--help >/dev/null; bash complete.bash " + words).output;
    };
    CHECK(complete("enc") == "encode\n");
    CHECK(complete("bench s") == "slices\n");
    CHECK(complete("bench slices --siz") == "--size\n");
    CHECK(complete("encode --bits") == "--bits-per-pixel\n");
    CHECK(complete("conformance run --format j") == "json junit\n");
    CHECK(complete("encode a") == "\n"); // a file: bash's own
    WriteText(folder / "ntc.fish", RunProgram(folder, "help --completion fish").output);
    WriteText(folder / "_ntc", RunProgram(folder, "help --completion zsh").output);
    if (std::system("command -v fish >/dev/null") == 0) {
        const auto ask = [&](const std::string& line) {
            return RunProgram(folder, "--help >/dev/null; HOME=. fish -c 'source ntc.fish; complete -C \"" +
                                          line + "\"'")
                .output;
        };
        CHECK(ask("ntc enc").starts_with("encode\t"));
        CHECK(ask("ntc bench sl").starts_with("slices\t"));
        CHECK(ask("ntc encode --bits").starts_with("--bits-per-pixel\t"));
    } else {
        MESSAGE("SKIP: fish is not installed");
    }
    if (std::system("command -v zsh >/dev/null") == 0) {
        CHECK(RunProgram(folder, "--help >/dev/null; zsh -n _ntc").code == 0);
    } else {
        MESSAGE("SKIP: zsh is not installed");
    }
    if (std::system("command -v mandoc >/dev/null") == 0) {
        CHECK(RunProgram(folder, "help --man | mandoc -T lint -W error").code == 0);
    } else {
        MESSAGE("SKIP: mandoc is not installed");
    }
}

TEST_CASE("the version names the commit, the compiler and the kernels of this machine") {
    const Folder folder;
    const ProgramResult result = RunProgram(folder, "--version");
    CAPTURE(result.output);
    CHECK(result.code == 0);
    CHECK(result.output.starts_with("ntc "));
    for (const char* line :
         {"\ncommit    ", "\ncompiler  ", "\nkernels   ", "\nencoder   ", "\nshaders   ", "\nVulkan    "})
        CHECK(result.output.find(line) != std::string::npos);
    CHECK(result.output.find("portable (of this machine") != std::string::npos);
    const ProgramResult capped =
        RunProgram(folder, "info --help >/dev/null; OPENNTC_SIMD_CAP=none '" NTC_PROGRAM "' --version");
    CHECK(capped.output.find("\nkernels   portable (of this machine") != std::string::npos);
}

TEST_CASE("devices are listed with what they can do, under the indices that --device takes") {
    const Folder folder;
    const ProgramResult result = RunProgram(folder, "devices --json");
    if (result.code == 4) {
        if (result.output.empty())
            CheckFails(result, 4);
        MESSAGE("SKIP: no Vulkan device");
        return;
    }
    REQUIRE(result.code == 0);
    const auto list = ParseValid(result.output, "devices");
    REQUIRE_FALSE(list["devices"].Empty());
    const std::string text = RunProgram(folder, "devices").output;
    for (unsigned i = 0; i < list["devices"].Size(); ++i) {
        const auto& device = list["devices"][i];
        CHECK(device["index"].GetUint() == i);
        CHECK(text.find(std::to_string(i) + "  " + device["name"].GetString() + "\n") != std::string::npos);
        CHECK(device["math"].Size() >= 5);
        for (const auto& feature : device["features"].GetArray())
            CHECK(feature["present"].GetBool() == (feature["reason"].GetStringLength() == 0));
    }
}
