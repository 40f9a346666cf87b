// SPDX-License-Identifier: MIT
// `ntc info` and `ntc validate` for people: sizes and ratios, several files, what follows the file, errors said once.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

/// 10 x 6 with 4 mips: 78 texels and 10 blocks a channel or texture. Constant images need no training.
void EncodeSet(const Folder& folder) {
    const auto constant = [](int channels) {
        return MakeImage(10, 6, channels, [](float, float, int) { return 0.5f; });
    };
    WriteImage(folder / "rgb.png", constant(3));
    WriteImage(folder / "gray.png", constant(1));
    WriteText(folder / "set.json", R"({"textures":[{"fileName":"rgb.png","name":"Chosen"},
        {"fileName":"rgb.png","name":"Hint","bcFormat":"BC1"},{"fileName":"gray.png","name":"Gray"},
        {"fileName":"gray16.png","name":"Deep"},{"fileName":"rgb.png","name":"Two","channelSwizzle":"RG"}]})");
    WriteImage(folder / "gray16.png", constant(1), 16);
    const ProgramResult result =
        RunProgram(folder, "encode set.json -o set.ntc --steps 1 --bits-per-pixel 1 --quiet");
    INFO(result.errors);
    REQUIRE(result.code == 0);
}

} // namespace

TEST_CASE("info compares each texture and mip with plain texels and block compression") {
    const Folder folder;
    EncodeSet(folder);
    const auto info = ParseValid(RunProgram(folder, "info set.ntc --json").output, "info");
    struct Expected {
        const char* format;
        std::uint64_t raw, blocks;
    };
    const Expected expected[] = {{"BC7", 3 * 78, 160},
                                 {"BC1", 3 * 78, 80},
                                 {"BC4", 78, 80},
                                 {"BC4", 2 * 78, 80},
                                 {"BC5", 2 * 78, 160}};
    std::uint64_t raw = 0, blocks = 0;
    REQUIRE(info["textures"].Size() == 5);
    for (unsigned i = 0; i < 5; ++i) {
        CAPTURE(i);
        CHECK(info["textures"][i]["comparedBcFormat"].GetString() == std::string(expected[i].format));
        CHECK(info["textures"][i]["rawBytes"].GetUint64() == expected[i].raw);
        CHECK(info["textures"][i]["bcBytes"].GetUint64() == expected[i].blocks);
        raw += expected[i].raw;
        blocks += expected[i].blocks;
    }
    CHECK(info["rawBytes"].GetUint64() == raw);
    CHECK(info["bcBytes"].GetUint64() == blocks);
    const auto size = static_cast<double>(fs::file_size(folder / "set.ntc"));
    CHECK(info["rawRatio"].GetDouble() == doctest::Approx(static_cast<double>(raw) / size));
    CHECK(info["bcRatio"].GetDouble() == doctest::Approx(static_cast<double>(blocks) / size));
    REQUIRE(info["colorMips"].Size() == 4);
    CHECK(info["colorMips"][0]["rawBytes"].GetUint64() == 11 * 60); // 3 + 3 + 1 + 2 + 2 bytes a texel
    CHECK(info["colorMips"][3]["bcBytes"].GetUint64() == 16 + 8 + 8 + 8 + 16);
    // Latents for a mip and all below: all of them for mip 0.
    std::uint64_t latents = 0;
    for (const auto& image : info["latentImages"].GetArray())
        latents += image["highRes"]["size"].GetUint64() + image["lowRes"]["size"].GetUint64();
    CHECK(info["colorMips"][0]["latentBytes"].GetUint64() >= latents);
    CHECK(info["colorMips"][3]["latentBytes"].GetUint64() <= info["colorMips"][0]["latentBytes"].GetUint64());

    const std::string text = RunProgram(folder, "info set.ntc").output;
    CAPTURE(text);
    CHECK(text.find("10 x 6 texels, 10 channels, 4 mips") != std::string::npos);
    CHECK(text.find(" times the file") != std::string::npos);
    CHECK(text.find("BC7*") != std::string::npos); // chosen
    CHECK(text.find("BC1 ") != std::string::npos); // the file's
    CHECK(text.find("view") == std::string::npos);
    CHECK(RunProgram(folder, "info --verbose set.ntc").output.find("  view 0: ") != std::string::npos);
}

TEST_CASE("info of several files: the others are shown when one is bad") {
    const Folder folder;
    EncodeSet(folder);
    fs::copy_file(folder / "set.ntc", folder / "two.ntc");
    WriteText(folder / "bad.ntc", "rubbish");
    const ProgramResult good = RunProgram(folder, "info --json set.ntc two.ntc");
    CHECK(good.code == 0);
    const auto list = ParseValid(good.output, "info");
    REQUIRE(list["files"].Size() == 2);
    CHECK(list["files"][1]["file"].GetString() == std::string("two.ntc"));
    for (const char* json : {"", " --json"}) {
        const ProgramResult mixed =
            RunProgram(folder, std::string("info set.ntc bad.ntc none.ntc two.ntc") + json);
        CHECK(mixed.code == 3);
        CHECK(mixed.output.find("two.ntc") != std::string::npos);
        CHECK(mixed.errors.find("ntc: bad.ntc: ") == 0);
        CHECK(mixed.errors.find("\nntc: none.ntc: ") != std::string::npos);
        if (json[0] != '\0')
            CHECK(ParseValid(mixed.output, "info")["files"].Size() == 2);
    }
    CheckFails(RunProgram(folder, "info - - < set.ntc"), 2);
}

TEST_CASE("validate says an error once, and notes what follows the file") {
    const Folder folder;
    EncodeSet(folder);
    WriteText(folder / "bad.ntc", "rubbish");
    const ProgramResult bad = RunProgram(folder, "validate bad.ntc");
    CHECK(bad.code == 3);
    CHECK(bad.output == "bad.ntc: must not be used\n");
    CHECK(bad.errors.starts_with("ntc: bad.ntc: error 1001: "));
    CHECK(bad.errors.find('\n') == bad.errors.size() - 1);

    const std::string set = ReadText(folder / "set.ntc");
    WriteText(folder / "long.ntc", set + std::string(100, 'x'));
    for (const char* file : {"long.ntc", "- < long.ntc"}) {
        const ProgramResult result = RunProgram(folder, std::string("validate ") + file);
        CHECK(result.code == 0);
        CHECK(result.output.find("note 3005: size: " + std::to_string(set.size() + 100) +
                                 " bytes: the header accounts for " + std::to_string(set.size())) !=
              std::string::npos);
    }
    CHECK(RunProgram(folder, "validate set.ntc").output.find("3005") == std::string::npos);
}

TEST_CASE("an input that never ends is refused: after its signature, or after what its header accounts for") {
    const Folder folder;
    EncodeSet(folder);
    // The writers stay silent after their bytes: a reader that waits for the end is stopped by the time limit.
    const auto read = [&](const std::string& writer, const std::string& command) {
        return RunProgram(folder, "--version >/dev/null; rm -f pipe; mkfifo pipe; { " + writer +
                                      "; exec sleep 60; } >pipe 2>/dev/null & timeout 20 '" NTC_PROGRAM "' " +
                                      command + " pipe; code=$?; kill $! 2>/dev/null; exit $code");
    };
    const ProgramResult zeros = read("head -c 200000 /dev/zero", "info");
    CAPTURE(zeros.errors);
    CheckFails(zeros, 3);
    CHECK(zeros.errors.find("header.signature: ") != std::string::npos);

    // A sound set, and then more than may follow one.
    const std::uintmax_t size = fs::file_size(folder / "set.ntc");
    const ProgramResult endless = read("cat set.ntc; head -c 3000000 /dev/zero", "info");
    CAPTURE(endless.errors);
    CheckFails(endless, 3);
    CHECK(endless.errors == "ntc: pipe: size: more than " + std::to_string(size + (1u << 20)) +
                                " bytes: its header accounts for " + std::to_string(size) + "\n");

    // A header that accounts for more than memory holds: nothing of it is waited for.
    const std::string set = ReadText(folder / "set.ntc");
    std::string huge = set.substr(0, 4096);
    huge[32 + 5] = 1; // binSize + 2^40
    WriteText(folder / "huge.ntc", huge);
    const ProgramResult large = read("cat huge.ntc; head -c 4096 /dev/zero", "decode -o out");
    CAPTURE(large.errors);
    CheckFails(large, 3);
    CHECK(large.errors.starts_with("ntc: pipe: header: accounts for 10995"));
    CHECK(large.errors.find("a pipe may have 4294967296") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "out"));

    // What a pipe may have behind a set is as good as behind one in a file.
    const ProgramResult sound =
        RunProgram(folder, "--version >/dev/null; { cat set.ntc; head -c 1000 /dev/zero; } | '" NTC_PROGRAM
                           "' validate -");
    CHECK(sound.code == 0);
    CHECK(sound.output.find("note 3005: ") != std::string::npos);
}
