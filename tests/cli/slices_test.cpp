// SPDX-License-Identifier: MIT
// `ntc constants --rect` and `ntc bench slices`: what the library makes, and on recorded sets what LibNTC made.
#include "cli/Program.h"
#include "support/Files.h"
#include "support/SpecificationVectors.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/PartialInference.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

std::string MakeHex(const NtcTextureSetConstants& constants) {
    std::string hex;
    for (const std::byte b : std::as_bytes(std::span(&constants, 1))) {
        char digits[3];
        std::snprintf(digits, sizeof digits, "%02x", static_cast<unsigned>(b));
        hex += digits;
    }
    return hex;
}

void WriteBytes(const fs::path& path, std::span<const std::byte> bytes) {
    WriteText(path, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

std::string ToOptions(const SliceDesc& slice) {
    return " --rect " + std::to_string(slice.rect.left) + "," + std::to_string(slice.rect.top) + "," +
           std::to_string(slice.rect.width) + "," + std::to_string(slice.rect.height) + " --first-mip " +
           std::to_string(slice.firstMip) + " --mips " + std::to_string(slice.numMips);
}

} // namespace

TEST_CASE("constants --rect: the slice that the library makes, of either coverage") {
    const Folder folder;
    SynthesisDesc synthesis;
    synthesis.seed = 3;
    synthesis.desc = {71, 16, 4, 4}; // sizes that do not halve
    synthesis.shape = {4, 4, 4, 8, 8};
    synthesis.withFP8 = true;
    const std::vector<std::byte> file = MakeFile(synthesis);
    WriteBytes(folder / "odd.ntc", file);
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    std::uint64_t published = 0;
    for (const SliceCoverage coverage : {SliceCoverage::Published, SliceCoverage::Whole}) {
        const SliceDesc slice{0, 4, {64, 0, 7, 16}, coverage};
        const bool isWhole = coverage == SliceCoverage::Whole;
        const std::string command = "constants odd.ntc --json --weights fp8" + ToOptions(slice) +
                                    (isWhole ? " --coverage whole" : "");
        const ProgramResult result = RunProgram(folder, command);
        CAPTURE(result.errors);
        REQUIRE(result.code == 0);
        const auto json = ParseValid(result.output, "constants");
        std::vector<std::byte> latents(static_cast<std::size_t>(*GetPartialLatentBufferSize(*set, slice)));
        const auto data =
            MakePartialInferenceData(*set, stream, slice, InferenceWeightType::GenericFP8, latents);
        REQUIRE(data);
        CHECK(json["status"].GetInt() == 0);
        CHECK(json["latentBytes"].GetUint64() == latents.size());
        CHECK(json["latentCrc32"].GetUint() == Crc32(latents));
        CHECK(json["constants"].GetString() == MakeHex(data->constants));
        CHECK(json["conservativeAlign1"].GetUint64() == *GetConservativeLatentBufferSize(*set, 0, 4, 7, 16));
        CHECK(json["conservativeAlign4"].GetUint64() ==
              *GetConservativeLatentBufferSize(*set, 0, 4, 7, 16, 4));
        CHECK(json["holdsAllTexels"].GetBool() == isWhole);
        CHECK(json["latentOffset"].GetUint64() == set->GetStreamRangeForLatents(0, 4)->offset);
        if (isWhole)
            CHECK(latents.size() > published);
        else
            published = latents.size();
    }
    const ProgramResult text = RunProgram(folder, "constants odd.ntc --rect 0,0,8,8");
    CHECK(text.code == 0);
    CHECK(text.output.find("\nholdsAllTexels yes\n") != std::string::npos);
    CHECK_FALSE(
        ParseValid(RunProgram(folder, "constants odd.ntc --json").output, "constants").HasMember("status"));
}

TEST_CASE("constants --rect: a slice that is refused has a status, an error and an exit code") {
    const Folder folder;
    SynthesisDesc synthesis;
    synthesis.seed = 4;
    synthesis.desc = {24, 16, 4, 3};
    synthesis.shape = {4, 4, 4, 8, 8};
    const std::vector<std::byte> file = MakeFile(synthesis); // no FP8 weights
    WriteBytes(folder / "set.ntc", file);
    WriteBytes(folder / "short.ntc", std::span(file).first(file.size() / 2));
    struct Refusal {
        const char* arguments;
        int code;
        Status status;
        const char* error; ///< its beginning
    };
    const Refusal refusals[] = {
        {"set.ntc --rect 0,9,8,8", 2, Status::OutOfRange,
         "ntc: set.ntc: --rect: height: 8: must be 1 … 7 from top 9 on"},
        {"set.ntc --rect 24,0,1,1", 2, Status::OutOfRange, "ntc: set.ntc: --rect: left: 24: must be 0 … 23"},
        {"set.ntc --rect -1,0,1,1", 2, Status::OutOfRange, "ntc: set.ntc: --rect: left: -1: "},
        {"set.ntc --rect 0,0,0,1", 2, Status::OutOfRange, "ntc: set.ntc: --rect: width: 0: "},
        {"set.ntc --rect 1,0,2147483647,1", 2, Status::OutOfRange, "ntc: set.ntc: --rect: width: "},
        {"set.ntc --rect 0,0,13,8 --first-mip 1 --mips 2", 2, Status::OutOfRange,
         "ntc: set.ntc: --rect: width: 13: must be 1 … 12 from left 0 on"},
        {"set.ntc --rect 0,0,1,1 --first-mip 3", 2, Status::OutOfRange, "ntc: set.ntc: --first-mip: 3: "},
        {"set.ntc --rect 0,0,1,1 --first-mip 1 --mips 3", 2, Status::OutOfRange, "ntc: set.ntc: --mips: 3: "},
        {"set.ntc --rect 0,0,1,1 --weights fp8", 3, Status::Unsupported, "ntc: set.ntc: "},
    };
    for (const Refusal& refusal : refusals) {
        CAPTURE(refusal.arguments);
        const std::string command = "constants " + std::string(refusal.arguments);
        const ProgramResult result = RunProgram(folder, command + " --json");
        CHECK(result.code == refusal.code);
        const auto json = ParseValid(result.output, "constants");
        REQUIRE(json.HasMember("error"));
        CHECK(json["status"].GetUint() == static_cast<unsigned>(refusal.status));
        CHECK(json["error"].GetString() + std::string("\n") == result.errors);
        CHECK(result.errors.find(refusal.error) == 0);
        CheckFails(RunProgram(folder, command), refusal.code); // without --json one line alone
    }
    // A file that is no texture set has no slices to refuse, and a request that cannot be read is none.
    CheckFails(RunProgram(folder, "constants none.ntc --rect 0,0,1,1 --json"), 3);
    CheckFails(RunProgram(folder, "constants short.ntc --rect 0,0,1,1 --json"), 3);
    CheckFails(RunProgram(folder, "constants set.ntc --rect 1,2,3 --json"), 2);
    CheckFails(RunProgram(folder, "constants set.ntc --first-mip 3 --json"), 2); // nor is one without --rect
}

TEST_CASE("constants --rect: what LibNTC recorded") {
    const std::string name = "npot-100x37-large";
    const fs::path path = GetConformanceFolder() / (name + ".ntc");
    if (!fs::exists(path)) {
        MESSAGE("SKIP: no conformance vectors: set OPENNTC_SHARED_DIR");
        return;
    }
    const Folder folder;
    rapidjson::Document expected;
    expected.Parse(ReadText(GetConformanceFolder() / (name + ".expect.json")).c_str());
    REQUIRE(expected.IsObject());
    const auto& slices = expected["slices"];
    for (rapidjson::SizeType i = 0; i < slices.Size(); ++i) {
        CAPTURE(i);
        const auto& slice = slices[i];
        const auto& rect = slice["rect"];
        const SliceDesc desc{slice["firstMip"].GetInt(),
                             slice["numMips"].GetInt(),
                             {rect[0].GetInt(), rect[1].GetInt(), rect[2].GetInt(), rect[3].GetInt()}};
        const ProgramResult result =
            RunProgram(folder, "constants '" + path.string() + "' --weights int8 --json" + ToOptions(desc));
        REQUIRE(result.code == 0);
        const auto json = ParseValid(result.output, "constants");
        CHECK(json["status"].GetInt() == slice["status"].GetInt());
        CHECK(json["latentBytes"].GetUint64() == slice["size"].GetUint64());
        CHECK(json["latentCrc32"].GetUint() == slice["latentCrc32"].GetUint());
        CHECK(json["conservativeAlign1"].GetUint64() == slice["conservativeAlign1"].GetUint64());
        CHECK(json["conservativeAlign4"].GetUint64() == slice["conservativeAlign4"].GetUint64());
        CHECK(std::string(json["constants"].GetString()) == slice["constants"].GetString());
        CHECK(json["holdsAllTexels"].GetBool() == (i != 8)); // LibNTC's mistake where sizes do not halve
    }
}

TEST_CASE("bench slices: rates of slices and of copies") {
    const Folder folder;
    WriteBytes(folder / "v2.ntc", MakeFile(GetV2().synthesis));
    const ProgramResult result =
        RunProgram(folder, "bench slices v2.ntc --size 16 --mips 3 --slices 50 --repeat 3 --json");
    CAPTURE(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "bench-slices");
    CHECK(json["positions"].GetInt() == 2 * 4);
    REQUIRE(json["results"].Size() == 3);
    for (const auto& entry : json["results"].GetArray()) {
        CHECK(entry["slicesPerSecond"]["runs"].GetInt() == 3);
        CHECK(entry["slicesPerSecond"]["median"].GetDouble() > 0);
    }
    CHECK(RunProgram(folder, "bench slices v2.ntc --size 16 --mips 1 --slices 5 --repeat 1").code == 0);
    CheckFails(RunProgram(folder, "bench slices v2.ntc --size 41"), 2);
}

TEST_CASE("bench loader: rates of tiles from file and memory, with the same data") {
    const Folder folder;
    WriteBytes(folder / "v2.ntc", MakeFile(GetV2().synthesis));
    const ProgramResult result = RunProgram(
        folder, "bench loader v2.ntc --tile 4 --textures 3 --threads 0,2 --limit 5 --repeat 2 --json");
    CAPTURE(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "bench-loader");
    CHECK(json["tiles"].GetInt() % 3 == 0);
    REQUIRE(json["results"].Size() == 4);
    for (const auto& entry : json["results"].GetArray()) {
        CHECK(entry["tilesPerSecond"]["runs"].GetInt() == 2);
        CHECK(entry["tilesPerSecond"]["median"].GetDouble() > 0);
        CHECK(entry["launches"].GetInt() > 1);
    }
    CHECK(RunProgram(folder, "bench loader v2.ntc --tile 8 --textures 1 --threads 1 --repeat 1").code == 0);
}
