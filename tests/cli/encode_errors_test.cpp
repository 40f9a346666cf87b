// SPDX-License-Identifier: MIT
// `ntc encode` and `ntc compare` on what they must refuse: exit codes, one line, nothing left behind.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

using namespace openntc_tests;

namespace {

float Ramp(float u, float v, int c) {
    return c == 0 ? u : v;
}

std::size_t CountFiles(const Folder& folder) {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder.GetPath()))
        ++count;
    return count;
}

} // namespace

TEST_CASE("impossible requests are usage errors") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 4, Ramp));
    const std::size_t before = CountFiles(folder);
    for (const std::string arguments :
         {"a.png a.png a.png a.png a.png", "a.png --latent-shape 2,12,8,2,4 --network small",
          "a.png --latent-shape 0,0,0,0,0", "a.png --latent-shape 1,2", "a.png --bits-per-pixel 1000",
          "a.png --bits-per-pixel nan", "a.png --network huge", "a.png --effort none", "a.png --seconds -1",
          "a.png --target-psnr 0", "a.png --mask-channel 9", "a.png --mask-channel x",
          "a.png --discard-masked", "a.png --mips 17", "a.png --threads -1"}) {
        CAPTURE(arguments);
        const ProgramResult result =
            RunProgram(folder, "encode --steps 2 --quiet -o a.ntc " + std::string(arguments));
        CAPTURE(result.errors);
        CheckFails(result, 2);
        CHECK(CountFiles(folder) == before);
    }
}

TEST_CASE("unreadable input: exit 3 naming the file") {
    const Folder folder;
    WriteText(folder / "empty.png", "");
    WriteText(folder / "text.png", "not an image");
    WriteImage(folder / "good.png", MakeImage(16, 16, 3, Ramp));
    const std::string good = ReadText(folder / "good.png");
    WriteText(folder / "cut.png", good.substr(0, good.size() / 2));
    WriteText(folder / "bad.exr", "v/1\x01 nonsense");
    WriteText(folder / "bad.hdr", "#?RADIANCE\n\n-Y 100000 +X 100000\n");
    WriteText(folder / "no-textures.json", "{}");
    WriteText(folder / "broken.json", "{\"textures\":[");
    WriteText(folder / "deep.json", std::string(200000, '['));
    WriteText(folder / "lost.json", R"({"textures":[{"fileName":"nowhere.png"}]})");
    WriteText(folder / "swizzle.json", R"({"textures":[{"fileName":"good.png","channelSwizzle":"RX"}]})");
    WriteText(folder / "alpha.json", R"({"textures":[{"fileName":"good.png","channelSwizzle":"A"}]})");
    WriteText(folder / "mip.json", R"({"textures":[{"fileName":"good.png","mipLevel":3}]})");
    const std::size_t before = CountFiles(folder);
    for (const std::string name : {"missing.png", "empty.png", "text.png", "cut.png", "bad.exr", "bad.hdr",
                                   ".", "missing.json", "no-textures.json", "broken.json", "deep.json",
                                   "lost.json", "swizzle.json", "alpha.json", "mip.json"}) {
        if (name == ".")
            continue; // a folder with broken images, covered by its images
        CAPTURE(name);
        const ProgramResult result = RunProgram(folder, "encode --steps 2 -o a.ntc " + name);
        CAPTURE(result.errors);
        CheckFails(result, 3);
        CheckFails(RunProgram(folder, "compare good.png " + name), 3);
        CHECK(CountFiles(folder) == before);
    }
}

TEST_CASE("sizes that differ: a warning, or refused with --strict") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, Ramp));
    WriteImage(folder / "b.png", MakeImage(8, 16, 1, Ramp));
    const ProgramResult result = RunProgram(folder, "encode --steps 2 a.png b.png -o a.ntc");
    CHECK(result.code == 0);
    CHECK(result.errors.starts_with("ntc: warning: b.png: image: 8 x 16"));
    CheckFails(RunProgram(folder, "encode --steps 2 a.png b.png -o b.ntc --strict"), 1);
    CHECK_FALSE(fs::exists(folder / "b.ntc"));
    CheckFails(RunProgram(folder, "compare a.png b.png"), 1);
    WriteImage(folder / "thin.png", MakeImage(1, 9, 3, Ramp));
    CHECK(RunProgram(folder, "encode --steps 2 thin.png -o thin.ntc").errors.find("a side of 1") !=
          std::string::npos);
}

TEST_CASE("output that cannot be written: exit 1 before training, nothing left") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(16, 16, 3, Ramp));
    const std::size_t before = CountFiles(folder);
    // Without the check these would train for minutes first.
    CheckFails(RunProgram(folder, "encode a.png -o nowhere/a.ntc"), 1);
    CheckFails(RunProgram(folder, "encode a.png -o ."), 1);
    if (fs::exists("/dev/full"))
        CheckFails(RunProgram(folder, "encode a.png -o /dev/full"), 1);
    // A file larger than the limit (blocks of 512 or 1024 bytes): the weights alone have 13 KB.
    const ProgramResult limited = RunProgram(folder, "--version >/dev/null; ulimit -f 4; '" NTC_PROGRAM
                                                     "' encode --steps 2 a.png -o a.ntc --quiet");
    CHECK(limited.code == 1);
    CHECK(limited.output.empty());
    CHECK(limited.errors.starts_with("ntc: warning: a.ntc: --steps 2: "));
    CHECK(limited.errors.find("\nntc: a.ntc: ") != std::string::npos);
    CHECK(CountFiles(folder) == before);
}
