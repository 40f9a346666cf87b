// SPDX-License-Identifier: MIT
// `ntc encode --generation 3` and `ntc migrate`: what the files hold, what migration costs, and what is refused.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <cmath>

using namespace openntc_tests;

namespace {

float MigrationWave(float u, float v, int c) {
    return 0.5f + 0.4f * std::sin(6.3f * (u + static_cast<float>(c) * 0.3f)) * std::cos(6.3f * v);
}

double Compare(const Folder& folder, const std::string& files) {
    const ProgramResult result = RunProgram(folder, "compare --json " + files);
    INFO(result.errors);
    REQUIRE(result.code == 0);
    return ParseValid(result.output, "compare")["psnr"].GetDouble();
}

void WriteImages(const Folder& folder) {
    WriteImage(folder / "base_color.png", MakeImage(48, 32, 3, MigrationWave));
    WriteImage(folder / "height.png", MakeImage(48, 32, 1, MigrationWave), 16);
    WriteImage(folder / "glow.hdr", MakeImage(48, 32, 3, MigrationWave));
}

} // namespace

TEST_CASE("encode --generation 3: its shapes, both networks, the reported PSNR; an interrupted run goes on "
          "to the same bytes") {
    const Folder folder;
    WriteImages(folder);
    const std::string command =
        "encode base_color.png height.png glow.hdr --generation 3 --steps 150 --quiet --json";
    const ProgramResult result = RunProgram(folder, command + " -o a.ntc --threads 1");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto encoded = ParseValid(result.output, "encode");
    CHECK(encoded["network"].GetInt() == 6);
    CHECK(encoded["bitsPerPixel"].GetDouble() == 3.75); // nearest to 4
    CHECK(encoded["latentShape"][1].GetInt() == 12);
    CHECK(encoded.HasMember("fp8Psnr"));
    CHECK(RunProgram(folder, "validate a.ntc").code == 0);
    // 0.05 dB is the project's promise.
    CHECK(std::fabs(Compare(folder, "base_color.png a.ntc") - encoded["textures"][0]["psnr"].GetDouble()) <
          0.05);

    REQUIRE(RunProgram(folder, command + " -o b.ntc --threads 2 --latent-shape 4,12").code == 0);
    CHECK(ReadText(folder / "a.ntc") == ReadText(folder / "b.ntc"));
    const ProgramResult searched =
        RunProgram(folder, "encode height.png --generation 3 --steps 20 --quiet --json -o c.ntc "
                           "--target-psnr 5 --max-bits-per-pixel 2");
    INFO(searched.errors);
    REQUIRE(searched.code == 0);
    CHECK(ParseValid(searched.output, "encode")["bitsPerPixel"].GetDouble() < 2.0);
}

TEST_CASE("migrate: another generation from a set's own texels, its metadata, and what it costs") {
    const Folder folder;
    WriteImages(folder);
    REQUIRE(RunProgram(folder, "encode base_color.png height.png glow.hdr -o old.ntc --network small "
                               "--bits-per-pixel 2 --steps 150 --quiet --mips 4")
                .code == 0);
    const ProgramResult forth =
        RunProgram(folder, "migrate old.ntc -o new.ntc --generation 3 --steps 150 --json --quiet");
    INFO(forth.errors);
    REQUIRE(forth.code == 0);
    CHECK(forth.errors.find("decoded") != std::string::npos);
    const auto json = ParseValid(forth.output, "migrate");
    CHECK(json["generation"].GetInt() == 3);
    CHECK(json["bitsPerPixel"].GetDouble() ==
          doctest::Approx(60.0 / 36.0)); // of 1.67 and 2.5 the nearer in proportion
    CHECK(json["old"]["generation"].GetInt() == 1);
    CHECK(json["old"]["bitsPerPixel"].GetDouble() == 2.0);
    CHECK(json["old"]["bytes"].GetUint64() == fs::file_size(folder / "old.ntc"));
    CHECK(json["bytes"].GetUint64() == fs::file_size(folder / "new.ntc"));
    // UNORM texels are compared within 0 ... 1, which `compare` does not know.
    CHECK(std::fabs(Compare(folder, "old.ntc new.ntc") - json["psnr"].GetDouble()) < 0.3);
    CHECK(RunProgram(folder, "validate new.ntc").code == 0);

    const ProgramResult back =
        RunProgram(folder, "migrate new.ntc -o back.ntc --generation 1 --network small --steps 20 --quiet");
    INFO(back.errors);
    REQUIRE(back.code == 0);
    CHECK(back.output.find("against the old file: ") != std::string::npos);
    const auto before = ParseValid(RunProgram(folder, "info --json old.ntc").output, "info");
    const auto after = ParseValid(RunProgram(folder, "info --json back.ntc").output, "info");
    CHECK(after["mips"] == before["mips"]);
    REQUIRE(after["textures"].Size() == 3);
    for (rapidjson::SizeType i = 0; i < 3; ++i) {
        for (const char* key : {"name", "firstChannel", "numChannels", "channelFormat", "rgbColorSpace",
                                "alphaColorSpace", "bcFormat"}) {
            CAPTURE(key);
            CHECK(after["textures"][i][key] == before["textures"][i][key]);
        }
    }
    // HDR texels stay HLG-encoded in the file.
    CHECK(after["channelColorSpaces"] == before["channelColorSpaces"]);
    CHECK(after["channelColorSpaces"][before["textures"][2]["firstChannel"].GetUint()].GetString() ==
          std::string("HLG"));
}

TEST_CASE("encode and migrate --bc7-modes: the set keeps how its blocks are coded best") {
    const Folder folder;
    WriteImages(folder);
    const auto run = [&](const std::string& arguments) { return RequireOutput(folder, arguments); };
    const auto decode = [&](const std::string& arguments) {
        run("decode --format dds --bc bc7 --quality best -o out " + arguments);
        std::string blocks = ReadText(folder / "out/base_color.dds");
        fs::remove_all(folder / "out");
        return blocks;
    };
    const std::string encode = "encode base_color.png height.png --generation 3 --steps 60 --seed 5 --quiet ";
    run(encode + "-o plain.ntc");
    run(encode + "--bc7-modes -o modes.ntc");
    const auto info = ParseValid(run("info modes.ntc --json"), "info");
    CHECK(info["textures"][0]["bcModeBuffers"].GetInt() == 6); // all mips of 48 x 32
    CHECK(info["textures"][1]["bcModeBuffers"].GetInt() == 0); // one channel is for BC4
    run("validate modes.ntc");
    CHECK(decode("modes.ntc --set-modes") == decode("plain.ntc"));
    const auto migrated = ParseValid(
        run("migrate modes.ntc -o again.ntc --generation 3 --steps 30 --quiet --json --bc7-modes --compress"),
        "migrate");
    CHECK(migrated["bytes"].GetUint64() == fs::file_size(folder / "again.ntc"));
    CHECK(ParseValid(run("info again.ntc --json"), "info")["textures"][0]["bcModeBuffers"].GetInt() == 6);
    CHECK(decode("again.ntc --set-modes") == decode("again.ntc --no-hints"));
    // Whoever writes modes declares what they are for: "as the file says" makes BC7 of these textures.
    const auto checkDeclared = [&](const std::string& file) {
        CAPTURE(file);
        const auto textures = ParseValid(run("info --json " + file), "info");
        CHECK(textures["textures"][0]["bcModeBuffers"].GetInt() > 0);
        CHECK(textures["textures"][0]["bcFormat"].GetString() == std::string("BC7"));
        run("optimize-bc -o any.bcmodes --quality fast " + file);
    };
    run("decode modes.ntc --format dds --bc auto --quality best --set-modes -o auto");
    CHECK(ReadText(folder / "auto/base_color.dds") == decode("modes.ntc --set-modes"));
    CHECK(info["textures"][1]["bcFormat"].GetString() == std::string("None"));
    checkDeclared("modes.ntc");
    checkDeclared("again.ntc");
    run("optimize-bc plain.ntc --in-set --bc bc7 --quality fast -o set.ntc");
    checkDeclared("set.ntc");
    fs::create_directories(folder / "art/wall");
    fs::copy_file(folder / "base_color.png", folder / "art/wall/base_color.png");
    run("bake art -o baked --generation 3 --steps 5 --bc7-modes --quiet");
    checkDeclared("baked/wall.ntc");
    WriteText(folder / "model.gltf",
              R"({"asset":{"version":"2.0"},"images":[{"uri":"base_color.png"}],"textures":[{"source":0}],
                "materials":[{"name":"m","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]})");
    run("convert-gltf model.gltf -o model --generation 3 --steps 5 --bc7-modes --quiet");
    checkDeclared("model/m.ntc");
    const ProgramResult unused =
        RunProgram(folder, "decode modes.ntc --format dds --bc bc1 --set-modes -o bc1");
    CHECK(unused.code == 0);
    CHECK(unused.errors.find("modes.ntc: --set-modes: no texture is written as BC7") != std::string::npos);

    // Old modes: what replaces them is said, or that they are.
    const auto migrate = [&](const std::string& arguments) {
        return RunProgram(folder, "migrate modes.ntc -o next.ntc --steps 3 --quiet " + arguments).errors;
    };
    CHECK(migrate("--generation 3").find("--bc7-modes, or ntc optimize-bc --in-set, makes new ones") !=
          std::string::npos);
    CHECK(migrate("--generation 1").find("(ntc optimize-bc makes new ones)") != std::string::npos);
    CHECK(migrate("--generation 3 --bc7-modes").find("not kept") == std::string::npos);
    const ProgramResult none =
        RunProgram(folder, "encode height.png --generation 3 --steps 3 --quiet --bc7-modes -o height.ntc");
    CHECK(none.code == 0);
    CHECK(none.errors.find("no texture is for BC7") != std::string::npos);
}

TEST_CASE("migrate: targets and weights of textures by name; names that no texture has are refused") {
    const Folder folder;
    WriteImages(folder);
    REQUIRE(RunProgram(folder,
                       "encode base_color.png height.png -o old.ntc --bits-per-pixel 2 --steps 100 --quiet")
                .code == 0);
    const std::string migrate = "migrate old.ntc -o new.ntc --generation 3 --steps 30 --quiet --json ";
    const auto run = [&](const std::string& arguments) {
        return ParseValid(RequireOutput(folder, migrate + arguments), "migrate");
    };
    // One decibel is reached by the smallest shape; no target takes the old size.
    const double smallest = run("--target-psnr height=1")["bitsPerPixel"].GetDouble();
    CHECK(smallest < 1.2);
    CHECK(run("")["bitsPerPixel"].GetDouble() > smallest);
    const ProgramResult missed =
        RunProgram(folder, migrate + "--target-psnr 1 --target-psnr base_color=90 --max-bits-per-pixel 1.2");
    CHECK(missed.code == 1);
    CHECK(missed.errors.find("base_color: ") != std::string::npos);
    CHECK(missed.errors.find("the target is 90.00") != std::string::npos);
    const auto weighted = run("--weight base_color=0.001 --latent-shape 4,12");
    const auto even = run("--latent-shape 4,12");
    CHECK(weighted["textures"][0]["psnr"].GetDouble() < even["textures"][0]["psnr"].GetDouble() - 3.0);

    fs::remove(folder / "new.ntc");
    for (const char* arguments :
         {"--target-psnr nope=60", "--weight nope=2", "--target-psnr 14 --target-psnr nope=1"}) {
        CAPTURE(arguments);
        const ProgramResult unknown = RunProgram(folder, migrate + arguments);
        CheckFails(unknown, 2);
        CHECK(unknown.errors.find("nope: no texture has this name: base_color, height") != std::string::npos);
    }
    CHECK_FALSE(fs::exists(folder / "new.ntc"));
    const std::string help = RequireOutput(folder, "migrate --help");
    CHECK(help.find("1 (default)") == std::string::npos);
    const ProgramResult second = RunProgram(folder, "migrate old.ntc -o new.ntc --generation 2");
    CheckFails(second, 2);
    CHECK(second.errors.find("read, not written") != std::string::npos);
}

TEST_CASE("generations: what is refused") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, MigrationWave));
    REQUIRE(RunProgram(folder, "encode a.png -o a.ntc --steps 3 --quiet").code == 0);
    for (const char* arguments :
         {"encode a.png -o b.ntc --generation 2", "encode a.png -o b.ntc --generation 3 --network large",
          "encode a.png -o b.ntc --compress", "encode a.png -o b.ntc --bc7-modes",
          "encode a.png -o b.ntc --generation 3 --bits-per-pixel 0.5",
          "encode a.png -o b.ntc --generation 3 --latent-shape 7,8", "migrate a.ntc -o b.ntc",
          "migrate a.ntc -o a.ntc --generation 3"}) {
        CAPTURE(arguments);
        CheckFails(RunProgram(folder, arguments), 2);
    }
    CheckFails(RunProgram(folder, "migrate a.png -o b.ntc --generation 3"), 3);
    CHECK_FALSE(fs::exists(folder / "b.ntc"));
}
