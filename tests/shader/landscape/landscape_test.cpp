// SPDX-License-Identifier: MIT
// examples/streaming as users run it: a small landscape rendered with tiles and with all latents resident, which must
// agree in every bit, with each other and with the C++ decoder.
#include "cli/Program.h"
#include "support/SpecificationVectors.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

constexpr int kNoDevice = 4;
constexpr const char* kSmall =
    " --columns 2 --rows 2 --set-size 1024 --width 96 --height 54 --tile 16 --json -o out ";

/// False, after saying why, without a device.
bool Fly(const Folder& folder, const std::string& options, ProgramResult& result) {
    const char* device = std::getenv("OPENNTC_TEST_DEVICE");
    result = RunProgram(folder, "--device " + std::string(device != nullptr ? device : "llvmpipe") + kSmall +
                                    options);
    if (result.code == kNoDevice)
        MESSAGE("SKIP: " << result.errors);
    return result.code != kNoDevice;
}

} // namespace

TEST_CASE("landscape: streamed, all resident and decoded in C++, the same bits") {
    const Folder folder;
    ProgramResult result;
    if (!Fly(folder, "--frames 8 --compare --verify 1 --budget 0.3", result))
        return;
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const rapidjson::Document report = ParseValid(result.output, "streaming");
    CHECK(report["wrongTexels"].GetUint64() == 0);
    CHECK(report["comparison"]["pixels"].GetUint64() == 8 * 96 * 54);
    CHECK(report["comparison"]["differentPixels"].GetUint64() == 0);
    CHECK(report["checkedTexels"].GetUint64() > 1000); // the camera sees ground
    const auto& memory = report["memory"];
    CHECK(memory["budgetBytes"].GetUint64() <= 320 * 1024);
    CHECK(memory["mostResidentBytes"].GetUint64() <= memory["budgetBytes"].GetUint64());
    CHECK(memory["allResidentBytes"].GetUint64() > memory["budgetBytes"].GetUint64());
    REQUIRE(report["frames"].Size() == 8);
    std::uint64_t loaded = 0, evicted = 0;
    for (const auto& frame : report["frames"].GetArray()) {
        CHECK(frame["complete"].GetBool());
        loaded += frame["loadedTiles"].GetUint64();
        evicted += frame["evictedTiles"].GetUint64();
        CHECK(frame["wantedTiles"].GetUint64() <= frame["residentTiles"].GetUint64());
    }
    CHECK(loaded > 0);
    CHECK(evicted > 0); // or the budget is no test
    CHECK(evicted <= loaded);
    for (const auto& file : report["files"].GetArray())
        CHECK(fs::file_size(folder / ("out/" + std::string(file.GetString()))) > 0);
    ParseValid(ReadText(folder / "out/timeline.json"), "streaming");
}

TEST_CASE("landscape: sets of generation 3, compressed: the same bits") {
    const Folder folder;
    openntc::SynthesisDesc synthesis;
    synthesis.seed = 3;
    synthesis.desc = {256, 256, 8, 9};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = openntc::MakeLayeredShape(3, 12); // 85 latent texels: they wrap inside a tile
    synthesis.compression = {true, false, 1, 2.0f};
    const std::vector<std::byte> file = MakeFile(synthesis);
    WriteText(folder / "set.ntc", {reinterpret_cast<const char*>(file.data()), file.size()});
    ProgramResult result;
    if (!Fly(folder, "--frames 2 --compare --verify 1 --budget 0.5 set.ntc", result))
        return;
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const rapidjson::Document report = ParseValid(result.output, "streaming");
    CHECK(report["wrongTexels"].GetUint64() == 0);
    CHECK(report["comparison"]["pixels"].GetUint64() == 2 * 96 * 54);
    CHECK(report["comparison"]["differentPixels"].GetUint64() == 0);
    CHECK(report["checkedTexels"].GetUint64() > 1000);
    CHECK(report["frames"][1]["residentTiles"].GetUint64() > 4); // more than tails
}

TEST_CASE("landscape: frames that do not wait show coarser mips, and the decoder's bits all the same") {
    const Folder folder;
    ProgramResult result;
    if (!Fly(folder, "--frames 2 --passes 1 --tiles-per-pass 1 --verify 1", result))
        return;
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const rapidjson::Document report = ParseValid(result.output, "streaming");
    CHECK(report["wrongTexels"].GetUint64() == 0);
    CHECK(report["frames"][0]["passes"].GetInt() == 1);
    CHECK_FALSE(report["frames"][0]["complete"].GetBool());
    CHECK(report["frames"][0]["missingTiles"].GetUint64() > 0);
}

TEST_CASE("landscape: bad options and files say what is wrong and leave nothing behind") {
    const Folder folder;
    const ProgramResult size = RunProgram(folder, "-o out --set-size 1000");
    CHECK(size.code == 2);
    CHECK(size.errors == "streaming: --set-size: 1000: must be a power of two\n");
    const ProgramResult missing = RunProgram(folder, "-o out nowhere.ntc");
    CHECK(missing.code == 3);
    CHECK(missing.errors.starts_with("streaming: nowhere.ntc: "));
    ProgramResult budget;
    if (Fly(folder, "--budget 0.01", budget)) {
        CHECK(budget.code == 2);
        CHECK(budget.errors.starts_with("streaming: --budget: "));
    }
    CHECK_FALSE(fs::exists(folder / "out"));
}
