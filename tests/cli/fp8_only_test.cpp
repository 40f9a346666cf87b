// SPDX-License-Identifier: MIT
// Sets that have FP8 weights alone: every command that decodes takes these, and says so.
#include "cli/Program.h"

#include "openntc/inference/Synthesis.h"
#include "support/SpecificationVectors.h"

#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

void WriteSet(const fs::path& path, int network, bool withInt8) {
    openntc::SynthesisDesc synthesis;
    synthesis.desc = {16, 12, 4, 2};
    synthesis.networkVersion = network;
    synthesis.shape = network == NTC_NETWORK_GENERATION_3 ? openntc::MakeLayeredShape(2, 8)
                                                          : openntc::LatentShape{2, 4, 4, 4, 4};
    synthesis.withInt8 = withInt8;
    synthesis.withFP8 = true;
    std::vector<openntc::Texture> textures(1);
    textures[0].name = "colour";
    textures[0].numChannels = 4;
    textures[0].channelFormat = openntc::ChannelFormat::UNORM8;
    synthesis.textures = textures;
    const std::vector<std::byte> file = MakeFile(synthesis);
    WriteText(path, std::string(reinterpret_cast<const char*>(file.data()), file.size()));
}

} // namespace

TEST_CASE("sets without Int8 weights: what decodes takes FP8 where no mode is asked for, and says so") {
    for (const int network : {NTC_NETWORK_SMALL, NTC_NETWORK_GENERATION_3}) {
        const Folder folder;
        CAPTURE(network);
        WriteSet(folder / "fp8.ntc", network, false);
        WriteSet(folder / "both.ntc", network, true);
        WriteText(folder / "texels", "0 3 5\n1 7 2\n");
        const auto run = [&](const std::string& arguments) {
            const ProgramResult result = RunProgram(folder, arguments);
            INFO(arguments << ": " << result.errors);
            CHECK(result.code == 0);
            CHECK(result.errors.find("fp8.ntc: weights: no Int8 network: decoded with the FP8 network") !=
                  std::string::npos);
            return result.output;
        };
        const std::string values = RequireOutput(folder, "sample both.ntc --texels texels --math fp8");
        CHECK(run("sample fp8.ntc --texels texels") == values);
        CHECK(RequireOutput(folder, "sample both.ntc --texels texels") != values);
        RequireOutput(folder, "decode both.ntc -o a --mips --math fp8");
        run("decode fp8.ntc -o b --mips");
        CHECK(ReadText(folder / "a/colour.png") == ReadText(folder / "b/colour.png"));
        CHECK(ReadText(folder / "a/mips/colour.01.png") == ReadText(folder / "b/mips/colour.01.png"));
        CHECK(ParseValid(run("bench decode fp8.ntc --backend reference --repeat 1 --json"),
                         "bench-decode")["math"]
                  .GetString() == std::string("fp8"));
        CHECK(ParseValid(run("optimize-bc fp8.ntc --bc bc7 --json"), "optimize-bc")["math"].GetString() ==
              std::string("fp8"));
        const auto compared = ParseValid(run("compare --json fp8.ntc b/colour.png"), "compare");
        CHECK(compared["channels"].Size() >= 3);
        run("migrate fp8.ntc -o new.ntc --generation 3 --steps 5 --quiet");
        CHECK(RunProgram(folder, "validate new.ntc").code == 0);

        CheckFails(RunProgram(folder, "decode fp8.ntc -o c --math int8"), 3);
        CheckFails(RunProgram(folder, "sample fp8.ntc --texels texels --math fp16"), 3);
        CHECK_FALSE(fs::exists(folder / "c"));
    }
}
