// SPDX-License-Identifier: MIT
// `ntc info`, `validate`, `constants` and `export` on sets of generations 2 and 3.
#include "Json.h"
#include "cli/Program.h"
#include "openntc/inference/Synthesis.h"
#include "support/SpecificationVectors.h"

#include <span>
#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

void WriteLayeredSet(const fs::path& path, int network, bool isCompressed, int mips = 3) {
    openntc::SynthesisDesc synthesis;
    synthesis.desc = {320, 320, 4, mips};
    synthesis.networkVersion = network;
    synthesis.shape = openntc::MakeLayeredShape(4, 8);
    synthesis.withFP8 = true;
    synthesis.compression.latents = isCompressed;
    synthesis.compression.largestRatio = 2.0f; // noise does not shrink
    synthesis.compression.level = 1;
    const std::vector<std::byte> file = MakeFile(synthesis);
    WriteText(path, std::string(reinterpret_cast<const char*>(file.data()), file.size()));
}

/// Findings of a file by number: "error 1002", "note 3006".
std::string ListFindings(const Folder& folder, const std::string& file) {
    const auto document = ParseValid(RunProgram(folder, "validate --json " + file).output, "validate");
    std::string list;
    for (const auto& finding : document["files"][0]["findings"].GetArray())
        list += std::string(finding["severity"].GetString()) + " " +
                std::to_string(finding["number"].GetInt()) + ", ";
    return list;
}

/// The first compressed view begins with a block of a kind that there is not.
std::string Corrupt(std::string file) {
    const std::size_t view = file.find("\x04\xFB", file.find('\0', 40));
    REQUIRE(view != std::string::npos);
    REQUIRE(file.substr(view + 2, 2) == std::string("\x01\0", 2)); // one tile: data follow 4 bytes of table
    file[view + 12] = '\xFF';
    return file;
}

} // namespace

TEST_CASE("generations 2 and 3: info says who reads a file, and its latents") {
    const Folder folder;
    WriteLayeredSet(folder / "second.ntc", NTC_NETWORK_GENERATION_2, false);
    WriteLayeredSet(folder / "third.ntc", NTC_NETWORK_GENERATION_3, true);
    const auto second = ParseValid(RunProgram(folder, "info second.ntc --json").output, "info");
    CHECK(second["generation"].GetInt() == 2);
    CHECK(second["libntc"].GetString() == std::string("0.8"));
    CHECK(second["network"]["name"].GetString() == std::string("gen2"));
    CHECK_FALSE(second.HasMember("latentImages"));
    REQUIRE(second["latentMips"].Size() == 2);
    CHECK(second["latentMips"][0]["width"].GetInt() == 80);
    CHECK(second["latentMips"][0]["layers"].Size() == 2);
    CHECK(second["latentMips"][0]["layers"][1]["size"].GetInt() == 12800);
    CHECK_FALSE(second["latentMips"][0]["layers"][1]["compressed"].GetBool());
    const auto third = ParseValid(RunProgram(folder, "info third.ntc --json").output, "info");
    CHECK(third["libntc"].GetString() == std::string("0.9"));
    CHECK(third["latentMips"][1]["layers"][0]["compressed"].GetBool());
    const auto views = third["views"].GetArray();
    CHECK(views[views.Size() - 1]["uncompressedSize"].GetInt() == 3200);
    const std::string text = RunProgram(folder, "info second.ntc third.ntc --verbose").output;
    CAPTURE(text);
    CHECK(text.find("generation 2 (schemaVersion 2), which LibNTC 0.8 reads: gen2 network") !=
          std::string::npos);
    CHECK(text.find("no file of LibNTC 0.8 was at hand") != std::string::npos);
    CHECK(text.find("generation 3 (schemaVersion 3), which LibNTC 0.9 reads: gen3 network") !=
          std::string::npos);
    CHECK(text.find("2.5 bits per pixel: grid scale 4, 2 latent mips of 8 features of 4 bits in 2 layers") !=
          std::string::npos);
    CHECK(text.find("(GDeflate)") != std::string::npos);
}

TEST_CASE("generations 2 and 3: validate knows their rules") {
    const Folder folder;
    WriteLayeredSet(folder / "second.ntc", NTC_NETWORK_GENERATION_2, false);
    WriteLayeredSet(folder / "third.ntc", NTC_NETWORK_GENERATION_3, true);
    CHECK(ListFindings(folder, "second.ntc") == "note 3006, ");
    CHECK(ListFindings(folder, "third.ntc").empty());
    std::string broken = ReadText(folder / "third.ntc");
    const std::size_t latents = broken.find("\x04\xFB", broken.find('\0', 40)); // the first compressed view
    REQUIRE(latents != std::string::npos);
    broken[latents + 200] = static_cast<char>(broken[latents + 200] ^ 1);
    WriteText(folder / "broken.ntc", broken);
    CHECK(ListFindings(folder, "broken.ntc") == "error 1002, ");
    CHECK(RunProgram(folder, "validate broken.ntc").code == 3);
    WriteLayeredSet(folder / "mips.ntc", NTC_NETWORK_GENERATION_2, false, 9);
    std::string mapping = ReadText(folder / "mips.ntc");
    const std::size_t first = mapping.find("\"latentMip\":0");
    REQUIRE(first != std::string::npos);
    mapping[first + 12] = '2';
    WriteText(folder / "mapping.ntc", mapping);
    CHECK(ListFindings(folder, "mapping.ntc") == "note 3006, warning 2009, ");
}

TEST_CASE("generations 2 and 3: constants, of slices too, and exported parts") {
    const Folder folder;
    WriteLayeredSet(folder / "third.ntc", NTC_NETWORK_GENERATION_3, true);
    const auto constants = ParseValid(RunProgram(folder, "constants third.ntc --json").output, "constants");
    CHECK(std::string(constants["textureConstants"].GetString()).size() == 672);
    CHECK(constants["weightBytes"].GetInt() == 9472);
    CHECK(constants["latentBufferBytes"].GetInt() == 2 * 2 * (6400 + 1600));
    CHECK_FALSE(constants.HasMember("latentOffset")); // no bytes of the file are what shaders read
    const auto part = ParseValid(RunProgram(folder, "info third.ntc --json").output, "info");
    CHECK(part["colorMips"][0]["latentBytes"].GetInt() == 2 * 2 * (6400 + 1600));
    const auto slice = ParseValid(
        RunProgram(folder, "constants third.ntc --json --first-mip 0 --rect 8,8,16,16").output, "constants");
    CHECK(slice["holdsAllTexels"].GetBool());
    CHECK(slice["latentBytes"].GetInt() == 2 * 2 * (8 * 8 + 6 * 6));
    CHECK(slice["latentBytes"].GetInt() <= slice["conservativeAlign1"].GetInt());
    const ProgramResult exported = RunProgram(folder, "export third.ntc -o parts --json");
    CAPTURE(exported.errors);
    const auto index = ParseValid(exported.output, "export");
    CHECK(index["latents"]["bytes"].GetInt() == 2 * 2 * (6400 + 1600));
    CHECK(index["network"].GetString() == std::string("gen3"));
    const std::string textureConstants = ReadText(folder / "parts/texture-constants.bin");
    CHECK(index["textureConstants"]["bytes"].GetUint64() == 336);
    CHECK(openntc::tool::ToHex(std::as_bytes(std::span(textureConstants))) ==
          constants["textureConstants"].GetString());
    const auto& texture = index["latentTexture"];
    CHECK(texture["width"].GetInt() == 80);
    CHECK(texture["levels"].GetInt() == 2);
    CHECK(texture["layers"].GetInt() == 2);
    REQUIRE(texture["mips"].Size() == 2);
    CHECK(texture["mips"][1]["level"].GetInt() == 1);
    CHECK(texture["mips"][1]["width"].GetInt() == 40);
    CHECK(texture["mips"][1]["offset"].GetInt() == 2 * 2 * 6400);
}

TEST_CASE("export: latents of a part go to the levels that its mips are sampled from") {
    const Folder folder;
    WriteLayeredSet(folder / "second.ntc", NTC_NETWORK_GENERATION_2, false, 9);
    const auto whole = ParseValid(RunProgram(folder, "export second.ntc -o whole --json").output, "export");
    const auto part = ParseValid(
        RunProgram(folder, "export second.ntc -o part --first-mip 4 --mips 2 --json").output, "export");
    const auto& all = whole["latentTexture"]["mips"];
    const auto& some = part["latentTexture"]["mips"];
    CHECK(part["latentTexture"]["levels"].GetUint() == all.Size());
    REQUIRE(some.Size() > 0);
    REQUIRE(some.Size() < all.Size());
    const std::string latents = ReadText(folder / "whole/latents.bin"),
                      partial = ReadText(folder / "part/latents.bin");
    for (const auto& mip : some.GetArray()) {
        const auto& same = all[mip["level"].GetUint()];
        CHECK(mip["width"].GetInt() == same["width"].GetInt());
        const std::size_t bytes =
            2 * mip["width"].GetUint64() * mip["height"].GetUint64() * mip["layers"].GetUint64();
        CHECK(partial.substr(mip["offset"].GetUint64(), bytes) ==
              latents.substr(same["offset"].GetUint64(), bytes));
    }
}

TEST_CASE("bench slices: sets of generations 2 and 3, stored and compressed; corrupt latents are bad input") {
    const Folder folder;
    WriteLayeredSet(folder / "second.ntc", NTC_NETWORK_GENERATION_2, false);
    WriteLayeredSet(folder / "third.ntc", NTC_NETWORK_GENERATION_3, true);
    for (const std::string file : {"second.ntc", "third.ntc"}) {
        CAPTURE(file);
        const ProgramResult result =
            RunProgram(folder, "bench slices " + file + " --size 64 --mips 3 --slices 5 --repeat 1 --json");
        CAPTURE(result.errors);
        REQUIRE(result.code == 0);
        const auto json = ParseValid(result.output, "bench-slices");
        CHECK(json["positions"].GetInt() == 5 * 5);
        CHECK(json["results"].Size() == 3);
    }
    WriteText(folder / "broken.ntc", Corrupt(ReadText(folder / "third.ntc")));
    const ProgramResult broken = RunProgram(folder, "bench slices broken.ntc --size 64 --mips 3 --slices 5");
    CheckFails(broken, 3);
    CHECK(broken.errors.find("broken.ntc: ") != std::string::npos);
}

TEST_CASE("bench loader: a tile that is corrupt ends it") {
    const Folder folder;
    WriteLayeredSet(folder / "third.ntc", NTC_NETWORK_GENERATION_3, true);
    WriteText(folder / "broken.ntc", Corrupt(ReadText(folder / "third.ntc")));
    for (const char* threads : {"0", "2"}) {
        CAPTURE(threads);
        // A program that waits for ever is stopped.
        const ProgramResult result = RunProgramWith(
            folder, SignalAfter(100, "KILL"),
            std::string("bench loader broken.ntc --tile 16 --textures 2 --repeat 1 --threads ") + threads);
        CheckFails(result, 3);
        CHECK(result.errors.find("broken.ntc: tile ") != std::string::npos);
    }
}
