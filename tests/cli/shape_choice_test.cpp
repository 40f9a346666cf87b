// SPDX-License-Identifier: MIT
// Shapes of generation 3 that LibNTC refuses at small sizes: which they are, what is taken instead, and who says so.
#include "Findings.h"
#include "cli/ImageFiles.h"
#include "cli/Program.h"
#include "encode/ShapeChoice.h"

#include "openntc/inference/Synthesis.h"
#include "support/SpecificationVectors.h"

#include <cmath>

using namespace openntc_tests;
using namespace openntc;

namespace {

/// Whether `ntc validate` finds nothing that LibNTC refuses in a set of these latents.
bool IsFileAccepted(const TextureSetDesc& desc, const LatentShape& shape) {
    SynthesisDesc synthesis;
    synthesis.desc = desc;
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = shape;
    const std::vector<std::byte> file = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    const auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE(metadata);
    return tool::FindRefusals(*metadata).empty();
}

float Waves(float u, float v, int c) {
    return 0.5f + 0.4f * std::sin(5.0f * u + static_cast<float>(c)) * std::cos(4.0f * v);
}

/// Numbers of the warnings that `ntc validate` has for a file.
std::string ListWarnings(const Folder& folder, const std::string& file) {
    const auto document = ParseValid(RunProgram(folder, "validate --json " + file).output, "validate");
    std::string list;
    for (const auto& finding : document["files"][0]["findings"].GetArray()) {
        if (finding["severity"].GetString() == std::string("warning"))
            list += std::to_string(finding["number"].GetInt()) + " ";
    }
    return list;
}

} // namespace

TEST_CASE("shapes of generation 3: which ones LibNTC accepts at a size is what validate finds in the file") {
    std::vector<TextureSetDesc> sizes{
        {256, 3, 4, 1}, {3, 256, 4, 9}, {64, 1, 4, 7}, {1, 64, 4, 1}, {250, 33, 4, 8}};
    for (int side = 1; side <= 72; ++side)
        sizes.push_back({side, side, 4, detail::GetBitWidth(side)});
    int refused = 0;
    for (const TextureSetDesc& desc : sizes) {
        for (int i = 0; i < GetKnownLatentShapeCount(NTC_NETWORK_GENERATION_3); ++i) {
            const LatentShape shape = EnumerateKnownLatentShapes(i, NTC_NETWORK_GENERATION_3)->shape;
            CAPTURE(desc.width);
            CAPTURE(desc.height);
            CAPTURE(shape.gridSizeScale);
            const bool isAccepted = IsFileAccepted(desc, shape);
            CHECK(tool::IsShapeAccepted(desc, shape) == isAccepted);
            refused += isAccepted ? 0 : 1;
        }
    }
    CHECK(refused > 100);
    const TextureSetDesc odd{11, 11, 4, 4};
    const LatentShape wanted = MakeLayeredShape(4, 12); // 11 / 2 latents are a scale of 6 again
    REQUIRE_FALSE(tool::IsShapeAccepted(odd, wanted));
    const LatentShape taken = tool::FindAcceptedShape(odd, wanted, 0.0);
    CHECK(taken != wanted);
    CHECK(tool::IsShapeAccepted(odd, taken));
    const LatentShape known = MakeLayeredShape(2, 16);
    CHECK(tool::FindAcceptedShape({64, 64, 4, 7}, known, 0.0) == known);
    CHECK(tool::FindAcceptedShape({1, 64, 4, 7}, wanted, 0.0) == wanted); // none is
}

TEST_CASE(
    "encode and migrate --generation 3: another shape where LibNTC refuses the usual one; a shape that was "
    "asked for is kept, and warned of as validate does") {
    const Folder folder;
    WriteImage(folder / "odd.png", MakeImage(11, 11, 3, Waves));
    WriteImage(folder / "column.png", MakeImage(1, 64, 3, Waves));
    const std::string encode = "encode --generation 3 --steps 5 --quiet ";
    ProgramResult result = RunProgram(folder, encode + "odd.png -o odd.ntc");
    CHECK(result.code == 0);
    CHECK(result.errors.find("LibNTC refuses a set of 11 x 11") != std::string::npos);
    CHECK(ListWarnings(folder, "odd.ntc").empty());
    const auto info = ParseValid(RequireOutput(folder, "info odd.ntc --json"), "info");
    CHECK(info["libntcRefuses"].Empty());
    CHECK(RequireOutput(folder, "info odd.ntc").find("which LibNTC 0.9 reads") != std::string::npos);

    result = RunProgram(folder, encode + "odd.png -o asked.ntc --latent-shape 4,12");
    CHECK(result.code == 0);
    CHECK(ListWarnings(folder, "asked.ntc") == "2008 ");
    CHECK(result.errors.find("asked.ntc: 2008: latents[0]: 2 x 2: LibNTC's CUDA loader accepts 1 x 1") !=
          std::string::npos);
    const auto refused = ParseValid(RequireOutput(folder, "info asked.ntc --json"), "info");
    REQUIRE(refused["libntcRefuses"].Size() == 1);
    CHECK(refused["libntcRefuses"][0].GetString() ==
          std::string("latents[0]: 2 x 2: LibNTC's CUDA loader accepts 1 x 1"));
    const std::string text = RequireOutput(folder, "info asked.ntc");
    CHECK(text.find("which LibNTC 0.9 refuses (ntc validate says why)") != std::string::npos);
    CHECK(text.find("reads") == std::string::npos);

    // No shape is accepted.
    result = RunProgram(folder, encode + "column.png -o column.ntc");
    CHECK(result.code == 0);
    CHECK(result.errors.find("column.ntc: 2008: latents[0]: ") != std::string::npos);

    result = RunProgram(folder, "migrate asked.ntc -o again.ntc --generation 3 --steps 5 --quiet");
    CHECK(result.code == 0);
    CHECK(ListWarnings(folder, "again.ntc").empty());

    // A search tries accepted shapes alone, and of sizes that a wish for bits allows there may be none.
    result = RunProgram(folder, encode + "odd.png -o found.ntc --target-psnr 1");
    CHECK(result.code == 0);
    CHECK(ListWarnings(folder, "found.ntc").empty());
    result = RunProgram(folder, encode + "odd.png -o near.ntc --bits-per-pixel 3.75");
    CHECK(result.code == 0);
    const double bits =
        ParseValid(RequireOutput(folder, "info near.ntc --json"), "info")["bitsPerPixel"].GetDouble();
    CAPTURE(bits);
    CHECK(
        (ListWarnings(folder, "near.ntc").empty() || result.errors.find("near.ntc: 2") != std::string::npos));
}
