// SPDX-License-Identifier: MIT
// `ntc report`: PSNR against seconds of encoding.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <cmath>
#include <string>

using namespace openntc_tests;

TEST_CASE("a small report of encoding: more steps take longer and are better; other materials and a page of "
          "their own") {
    const Folder folder;
    WriteImage(folder / "wave.png", MakeImage(32, 32, 3, [](float u, float v, int c) {
                   return 0.5f + 0.4f * std::sin(19.0f * u + static_cast<float>(c)) * std::cos(13.0f * v);
               }));
    WriteText(folder / "wave.json", R"({"textures":[{"fileName":"wave.png"}]})");
    const ProgramResult made = RunProgram(
        folder, "report --quick --device cpu --cases training --cache cache --training-material wave.json "
                "--training-seconds 0.3 -o out --json");
    INFO(made.errors);
    REQUIRE(made.code == 0);
    const auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    CHECK(report["cases"].Size() == 0);
    CHECK(report["encodings"].Size() == 0); // nothing else is trained for it
    const auto& training = report["training"];
    REQUIRE(training.Size() == 1); // the fastest kernel
    const auto& curve = training[0];
    CHECK(curve["kernel"].GetString() == std::string(report["training"][0]["id"].GetString()).substr(10));
    CHECK(curve["material"].GetString() == std::string("wave"));
    CHECK(curve["width"].GetInt() == 32);
    CHECK(curve["batchTexels"].GetInt() == 4096);
    CHECK(curve["channels"].GetInt() == 3);
    const unsigned points = curve["steps"].Size();
    REQUIRE(points >= 1);
    for (const char* list : {"seconds", "processorSeconds", "psnr"})
        REQUIRE(curve[list].Size() == points);
    for (unsigned i = 1; i < points; ++i) {
        CHECK(curve["steps"][i].GetInt() == 2 * curve["steps"][i - 1].GetInt());
        CHECK(curve["psnr"][i].GetDouble() > curve["psnr"][i - 1].GetDouble());
    }
    // It ends with the first encoding that takes longer.
    for (unsigned i = 0; i + 1 < points; ++i)
        CHECK(curve["processorSeconds"][i].GetDouble() < 0.3);
    CHECK(curve["processorSeconds"][points - 1].GetDouble() >= 0.3);

    const std::string page = ReadText(folder / "out/report.html");
    CHECK(page.find("<h2 id=training>") != std::string::npos);
    CHECK(page.find("Encoding wave, 32 x 32, 3 channels") != std::string::npos); // the chart's title
}
