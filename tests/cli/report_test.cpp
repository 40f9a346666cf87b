// SPDX-License-Identifier: MIT
// `ntc report`: a small one on the CPU, its page, comparing two, and what is refused.
#include "cli/Program.h"

#include <rapidjson/prettywriter.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

/// Training of 40 steps makes bad textures, quickly.
constexpr const char* kSmallest = "report -o out --quick --device cpu --steps 40 --cache cache --json "
                                  "--cases 'bricks-medium-4bpp int8 9 outputs stored'";

std::string ToText(const rapidjson::Document& document) {
    rapidjson::StringBuffer buffer;
    rapidjson::PrettyWriter<rapidjson::StringBuffer> writer(buffer);
    document.Accept(writer);
    return {buffer.GetString(), buffer.GetSize()};
}

std::size_t Count(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

/// Times of a case: median and how far the repeats lie around it.
void SetTimes(rapidjson::Value& measured, double median, double spread) {
    rapidjson::Value& times = measured["nanosecondsPerTexel"];
    times["median"].SetDouble(median);
    times["minimum"].SetDouble(median - spread);
    times["maximum"].SetDouble(median + spread);
}

void SetQuartiles(rapidjson::Value& measured, double lower, double median, double upper) {
    rapidjson::Value& times = measured["nanosecondsPerTexel"];
    times["lowerQuartile"].SetDouble(lower);
    times["median"].SetDouble(median);
    times["upperQuartile"].SetDouble(upper);
    times["repeats"].SetInt(7);
}

/// The text of a chart's labels, legend and title.
std::string FindChart(const std::string& page, const std::string& title) {
    const std::size_t at = page.find("<title>" + title);
    if (at == std::string::npos)
        return {};
    return page.substr(at, page.find("</svg>", at) - at);
}

} // namespace

TEST_CASE("a small report: measured, drawn, drawn again, compared") {
    const Folder folder;
    const ProgramResult made = RunProgram(folder, kSmallest);
    INFO(made.errors);
    REQUIRE(made.code == 0);
    const auto output = ParseValid(made.output, "report-output");
    CHECK(output["measured"].GetInt() == 1);
    CHECK(output["cacheFilled"].GetInt() == 1);
    std::istringstream events(made.errors);
    for (std::string line; std::getline(events, line);)
        ParseValid(line, "progress");

    auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    auto& cases = report["cases"];
    rapidjson::SizeType at = 0;
    while (at < cases.Size() && cases[at]["skipped"].GetStringLength() > 0)
        ++at;
    REQUIRE(at < cases.Size());
    const auto& measured = cases[at];
    const double median = measured["nanosecondsPerTexel"]["median"].GetDouble();
    CHECK(median > 0);
    CHECK(measured["extrapolated1080pMilliseconds"].GetDouble() ==
          doctest::Approx(median * 1920 * 1080 * 1e-6));
    const auto& accuracy = measured["accuracy"];
    CHECK(accuracy["values"].GetInt() == 256 * 256 * 9);
    CHECK(accuracy["differentFromReference"].GetInt() == 0); // the fast decoder and the reference
    CHECK(accuracy["psnrSource"].GetDouble() > 10);
    // A worst error of e and an error of e everywhere: PSNR is at least that of the latter.
    const double worst = accuracy["worstLsbFp32"].GetDouble() / 255;
    CHECK(worst > 0);
    CHECK(accuracy["psnrFp32"].GetDouble() >= -20 * std::log10(worst));

    const std::string page = ReadText(folder / "out/report.html");
    CHECK(Count(page, "<svg") >= 3); // accuracy, arithmetic error, effects, quality
    CHECK(page.find("Pareto front") != std::string::npos);
    CHECK(page.find("I can afford X ms") != std::string::npos);
    CHECK(page.find("extrapolated") != std::string::npos);
    CHECK(Count(page, "data:image/png;base64,") >= 3);
    CHECK(page.find("http-equiv") == std::string::npos);
    CHECK(page.find("src=\"http") == std::string::npos); // self-contained

    WriteText(folder / "hard.json",
              "[{\"name\": \"made-up\", \"worst\": 2, \"bound\": 1, \"note\": \"<b>\"}]");
    const ProgramResult again =
        RunProgram(folder, "report -o again --from out/report.json --compare out/report.json "
                           "--hard-cases hard.json --chart chart.svg --json");
    INFO(again.errors);
    REQUIRE(again.code == 0);
    CHECK(ParseValid(again.output, "report-output")["timesChanged"].GetInt() == 0);
    const std::string second = ReadText(folder / "again/report.html");
    CHECK(second.find("EXCEEDED") != std::string::npos);
    CHECK(second.find("&lt;b&gt;") != std::string::npos);
    CHECK(ReadText(folder / "chart.svg").find("<svg") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "again/.charts"));

    // The sample material has a chart to itself: published figures are of other materials.
    CHECK(page.find("Produced by GNUPLOT") == std::string::npos);
    const std::string quality = FindChart(page, "Quality against bits per pixel: sample bricks");
    CHECK_FALSE(quality.empty());
    CHECK(quality.find("LibNTC") == std::string::npos);
    CHECK(page.find("8 : one") != std::string::npos); // divergence at a glance

    // Load above the threads: said in red and in the JSON; not otherwise, whatever the file says.
    for (const bool isOver : {true, false}) {
        CAPTURE(isOver);
        report["cores"].SetInt(2);
        report["load"].SetDouble(isOver ? 2.1 : 2.0);
        report["loadExceedsThreads"].SetBool(!isOver);
        WriteText(folder / "load.json", ToText(report));
        REQUIRE(RunProgram(folder, "report -o load --from load.json").code == 0);
        const std::string loaded = ReadText(folder / "load/report.html");
        CHECK((loaded.find("<p class=warning>Load 2.1 on 2 hardware threads") != std::string::npos) ==
              isOver);
        CHECK((loaded.find("Load 2.1 on 2 threads: times include waiting") != std::string::npos) == isOver);
        CHECK(ParseValid(ReadText(folder / "load/report.json"), "report")["loadExceedsThreads"].GetBool() ==
              isOver);
    }

    // A second network with a lower PSNR and a lower median: faster only if the quartiles are apart.
    rapidjson::Value other(measured, report.GetAllocator());
    other["id"].SetString("other", 5);
    other["network"].SetString("small", 5);
    other["encoding"].SetString("bricks-small-4bpp", 17);
    other["accuracy"]["psnrSource"].SetDouble(accuracy["psnrSource"].GetDouble() - 0.5);
    rapidjson::Document two;
    two.CopyFrom(report, two.GetAllocator());
    two["cases"].PushBack(rapidjson::Value(other, two.GetAllocator()), two.GetAllocator());
    for (const bool isNoise : {true, false}) {
        CAPTURE(isNoise);
        SetQuartiles(two["cases"][at], 90, 100, 110);
        SetQuartiles(two["cases"][two["cases"].Size() - 1], 80, 85, isNoise ? 90.5 : 89.5);
        WriteText(folder / "two.json", ToText(two));
        REQUIRE(RunProgram(folder, "report -o two --from two.json").code == 0);
        const std::string tables = ReadText(folder / "two/report.html");
        const std::string best = tables.substr(tables.find("I can afford X ms"));
        const std::string rows = best.substr(0, best.find("</table>"));
        // Noise: one row, the more accurate one, with the other as equally fast. Apart: two rows.
        CHECK(Count(rows, "<tr>") == (isNoise ? 2u : 3u));
        CHECK((rows.find("<td class=note>int8, small, 4 bpp") != std::string::npos) == isNoise);
        CHECK((rows.find("<td class=text>int8, small, 4 bpp") != std::string::npos) != isNoise);
        const std::string need = best.substr(best.find("I need Y dB"));
        CHECK((need.substr(0, need.find("</table>")).find(" bpp; int8, ") != std::string::npos) == isNoise);
    }

    // Ranges that overlap are noise; ranges apart and more than 5 % are a change.
    SetTimes(cases[at], 100, 3);
    WriteText(folder / "old.json", ToText(report));
    const std::pair<double, int> kChanges[] = {{104.9, 0}, {106.1, 1}, {93.9, 1}};
    for (const std::pair<double, int>& change : kChanges) {
        CAPTURE(change.first);
        SetTimes(cases[at], change.first, 3);
        WriteText(folder / "new.json", ToText(report));
        const ProgramResult result =
            RunProgram(folder, "report -o new --from new.json --compare old.json --json");
        CHECK(ParseValid(result.output, "report-output")["timesChanged"].GetInt() == change.second);
    }
    cases[at]["accuracy"]["psnrSource"].SetDouble(12.5);
    WriteText(folder / "worse.json", ToText(report));
    const ProgramResult worse = RunProgram(folder, "report -o worse --from worse.json --compare new.json");
    CHECK(worse.output.find("1 cases, 0 times changed, accuracy of 1 changed") != std::string::npos);

    const std::string path = std::getenv("PATH");
    setenv("PATH", "/nonexistent", 1); // no gnuplot
    const ProgramResult numbers = RunProgram(folder, "report -o numbers --from out/report.json");
    setenv("PATH", path.c_str(), 1);
    CheckFails(numbers, 4);
    CHECK(numbers.errors.find("gnuplot-nox") != std::string::npos);
    CHECK(fs::exists(folder / "numbers/report.json"));
    CHECK_FALSE(fs::exists(folder / "numbers/report.html"));
}

TEST_CASE("a small report of generations: compared in turns with generation 1, at equal bits per pixel") {
    const Folder folder;
    const ProgramResult made =
        RunProgram(folder, "report --quick --device cpu --steps 40 --cache cache --cases 5bpp -o out --json");
    INFO(made.errors);
    REQUIRE(made.code == 0);
    auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    std::map<std::string, double> psnr; // of the network
    std::map<std::string, int> ways;    // to decode it: the fastest, and each instruction set
    for (const auto& c : report["cases"].GetArray()) {
        const std::string id = c["id"].GetString();
        CAPTURE(id);
        if (c["skipped"].GetStringLength() > 0) {
            const bool isOfShaders = c["latents"].GetString() == std::string("texture");
            CHECK((c["instructions"].GetStringLength() > 0 || isOfShaders)); // or of another processor
            continue;
        }
        const std::string network = c["network"].GetString();
        ++ways[network];
        psnr[network] = c["accuracy"]["psnrSource"].GetDouble();
        CHECK(c["accuracy"]["differentFromReference"].GetInt() == 0);
        const auto& ratio = c["againstGeneration1"];
        CHECK(ratio["repeats"].GetInt() == (network == "medium" ? 0 : 5));
        CHECK((ratio["minimum"].GetDouble() > 0) == (network != "medium"));
    }
    REQUIRE(ways.size() == 3);
    CHECK(ways["medium"] >= 2);
    CHECK(ways["gen2"] == ways["medium"]);
    CHECK(ways["gen3"] == ways["medium"]);
    for (const auto& encoding : report["encodings"].GetArray())
        CHECK(encoding["trueBitsPerPixel"].GetDouble() > 5); // mip 0 has 5
    // One network for both: their inputs and activations differ by a step or two of a byte.
    CHECK(std::fabs(psnr["gen2"] - psnr["gen3"]) < 0.5);

    const std::string page = ReadText(folder / "out/report.html");
    CHECK_FALSE(FindChart(page, "Generations of files: ").empty());
    CHECK(page.find("Generations of files at equal bits per pixel") != std::string::npos);
    for (auto& c : report["cases"].GetArray()) { // files of before
        c.RemoveMember("instructions");
        c.RemoveMember("latents");
        c.RemoveMember("againstGeneration1");
    }
    WriteText(folder / "older.json", ToText(report));
    CHECK(RunProgram(folder, "report -o older --from older.json").code == 0);
}

TEST_CASE("reports that are refused") {
    const Folder folder;
    WriteText(folder / "text.json", "{\"version\": 1,");
    WriteText(folder / "other.json", "[1, 2]");
    WriteText(folder / "later.json", "{\"version\": 2}");
    WriteText(folder / "part.json", "{\"version\": 1, \"tool\": 5}");
    for (const char* file : {"missing.json", "text.json", "other.json", "later.json", "part.json"}) {
        CAPTURE(file);
        CheckFails(RunProgram(folder, std::string("report -o out --from ") + file), 3);
        CheckFails(RunProgram(folder, std::string("report -o out --device cpu --compare ") + file), 3);
        CHECK_FALSE(fs::exists(folder / "out"));
    }
    CHECK(RunProgram(folder, "report -o out --from part.json").errors.find("tool: must be a string") !=
          std::string::npos);
    CheckFails(RunProgram(folder, "report"), 2);
    CheckFails(RunProgram(folder, "report -o out --cache cache --cases nothing-like-this"), 2);
    CheckFails(RunProgram(folder, "report -o out --cache cache --model missing"), 3);
    CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE(
    "a small report of streaming: less memory costs accuracy, and only the times differ from run to run") {
    const Folder folder;
    const std::string command = "report --quick --device cpu --steps 40 --cache cache --cases streaming -o ";
    const ProgramResult made = RunProgram(folder, command + "out --json");
    INFO(made.errors);
    REQUIRE(made.code == 0);
    auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    CHECK(report["cases"].Size() == 0);
    const auto& streaming = report["streaming"];
    REQUIRE(streaming.Size() == 4); // all, 1/4, 1/16, all with 8 tiles a frame
    for (const auto& entry : streaming.GetArray()) {
        CHECK(entry["millisecondsAFrame"]["repeats"].GetInt() == entry["frames"].GetInt());
        CHECK(entry["millisecondsAFrame"]["minimum"].GetDouble() > 0);
        CHECK(entry["wantedShare"].GetDouble() < 1); // a moving camera is always a frame late somewhere
        CHECK(entry["mipDeficit"].GetDouble() > 0);
        CHECK(entry["tilesLoaded"].GetDouble() > 0);
        CHECK(entry["bytesLoaded"].GetDouble() > entry["tilesLoaded"].GetDouble());
    }
    const auto get = [&](rapidjson::SizeType i, const char* member) {
        return streaming[i][member].GetDouble();
    };
    CHECK(get(0, "budgetTiles") == get(0, "allTiles"));
    CHECK(get(2, "budgetTiles") == std::floor(get(2, "allTiles") / 16));
    for (const rapidjson::SizeType worse : {1u, 2u}) {
        CHECK(get(worse, "wantedShare") <= get(worse - 1, "wantedShare"));
        CHECK(get(worse, "mipDeficit") >= get(worse - 1, "mipDeficit"));
        CHECK(get(worse, "psnr") <= get(worse - 1, "psnr"));
    }
    CHECK(get(2, "psnr") < get(0, "psnr") - 1);
    CHECK(get(3, "tilesAFrameLimit") == 8);
    CHECK(get(3, "tilesLoaded") <= 8 + 1e-9);
    CHECK(get(3, "mipDeficit") > get(0, "mipDeficit"));

    REQUIRE(RunProgram(folder, command + "again").code == 0);
    auto again = ParseValid(ReadText(folder / "again/report.json"), "report");
    for (rapidjson::SizeType i = 0; i < streaming.Size(); ++i) {
        for (rapidjson::Document* one : {&report, &again})
            (*one)["streaming"][i].RemoveMember("millisecondsAFrame");
    }
    CHECK(again["streaming"] == report["streaming"]);

    const std::string page = ReadText(folder / "out/report.html");
    CHECK(page.find("<h2 id=streaming>") != std::string::npos);
    CHECK(page.find("streaming budget 1/16") != std::string::npos);
    CHECK_FALSE(FindChart(page, "Streaming: how close the pictures are").empty());
    // Files of before have no such list.
    report.RemoveMember("streaming");
    WriteText(folder / "older.json", ToText(report));
    CHECK(RunProgram(folder, "report -o older --from older.json").code == 0);
    CHECK(ReadText(folder / "older/report.html").find("id=streaming") == std::string::npos);
}

TEST_CASE(
    "a small report of block compression: more time never costs accuracy, and threads change no block") {
    const Folder folder;
    const ProgramResult made = RunProgram(
        folder, "report --quick --device cpu --steps 40 --cache cache --cases blocks -o out --json");
    INFO(made.errors);
    REQUIRE(made.code == 0);
    auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    CHECK(report["cases"].Size() == 0);
    CHECK(report["streaming"].Size() == 0);
    const auto& blocks = report["blocks"];
    const bool hasSeveral = report["cores"].GetInt() > 1;
    REQUIRE(blocks.Size() ==
            (hasSeveral ? 20 : 10));      // three formats, three levels, BC7 with hints; one thread, and all
    std::map<std::string, double> before; // PSNR of the level below
    std::map<std::string, std::vector<double>> psnrs;
    for (const auto& entry : blocks.GetArray()) {
        const std::string id = entry["id"].GetString(), format = entry["format"].GetString();
        CAPTURE(id);
        std::string level = entry["level"].GetString();
        if (level == "best, hints")
            level = "best hints";
        CHECK(id == std::string("blocks ").append(format).append(" ").append(level));
        CHECK(entry["skipped"].GetStringLength() == 0);
        CHECK(entry["nanosecondsPerTexel"]["repeats"].GetInt() == 5);
        CHECK(entry["nanosecondsPerTexel"]["minimum"].GetDouble() > 0);
        // 8 or 16 bytes for 4 x 4 texels of two or three channels.
        const int texels = 256 * 256;
        CHECK(entry["blockBytes"].GetInt() == texels / 16 * (format == "bc1" ? 8 : 16));
        CHECK(entry["rawBytes"].GetInt() == texels * (format == "bc5" ? 2 : 3));
        CHECK(entry["comparedWithReference"].GetInt() == texels / 16);
        CHECK(entry["differentFromReference"].GetInt() == 0);
        psnrs[id].push_back(entry["psnrDecoded"].GetDouble());
        CHECK(psnrs[id].front() == psnrs[id].back());
        CHECK(entry["psnrDecoded"].GetDouble() >= before[format]);
        before[format] = entry["psnrDecoded"].GetDouble();
        CHECK(before[format] > 30);
        // Forty steps of training: the set is what is bad, and blocks add little to that.
        CHECK(entry["psnrSource"].GetDouble() < entry["psnrDecoded"].GetDouble());
        CHECK(std::abs(entry["psnrSource"].GetDouble() - entry["psnrSourceBefore"].GetDouble()) < 1);
    }
    CHECK(before["bc7"] > before["bc1"]);
    REQUIRE(report["blockSizes"].Size() == 1);
    const auto& sizes = report["blockSizes"][0];
    CHECK(sizes["formats"].Size() == 6);
    CHECK(sizes["blockBytes"].GetInt() * 2 < sizes["rawBytes"].GetInt()); // BC7 of three channels: a third
    CHECK(sizes["memoryBytes"].GetInt() < sizes["blockBytes"].GetInt());

    const std::string page = ReadText(folder / "out/report.html");
    CHECK(page.find("<h2 id=blocks>") != std::string::npos);
    CHECK(page.find(hasSeveral ? "0 of 81920 blocks differ" : "0 of 40960 blocks differ") !=
          std::string::npos);
    CHECK_FALSE(FindChart(page, "Block compression on load").empty());
    CHECK(Count(page, "<title>Block compression on load") == (hasSeveral ? 2 : 1));
    // What was not measured is listed, and blocks that differ are said in red.
    report["blocks"][0]["differentFromReference"].SetInt(3);
    rapidjson::Value skipped(report["blocks"][1], report.GetAllocator());
    skipped["skipped"].SetString("no <glslang>");
    report["blocks"].PushBack(skipped, report.GetAllocator());
    WriteText(folder / "other.json", ToText(report));
    REQUIRE(RunProgram(folder, "report -o other --from other.json").code == 0);
    const std::string other = ReadText(folder / "other/report.html");
    CHECK(other.find("<p class=warning>3 of ") != std::string::npos);
    CHECK(other.find("no &lt;glslang&gt;") != std::string::npos);
    // Files of before have neither list.
    report.RemoveMember("blocks");
    report.RemoveMember("blockSizes");
    WriteText(folder / "older.json", ToText(report));
    CHECK(RunProgram(folder, "report -o older --from older.json").code == 0);
    CHECK(ReadText(folder / "older/report.html").find("id=blocks") == std::string::npos);
}

TEST_CASE(
    "a small report of filtering: what is exact is exact, errors fall with frames, sharing stays biased") {
    const Folder folder;
    const ProgramResult made = RunProgram(
        folder, "report --quick --device cpu --steps 40 --cache cache --cases filtering -o out --json");
    INFO(made.errors);
    REQUIRE(made.code == 0);
    auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    CHECK(report["cases"].Size() == 0);
    CHECK(report["blocks"].Size() == 0);
    const auto& filtering = report["filtering"];
    REQUIRE(filtering.Size() == 8); // two filters, four numbers of texels
    std::map<std::string, const rapidjson::Value*> records;
    for (const auto& entry : filtering.GetArray()) {
        const std::string id = entry["id"].GetString();
        CAPTURE(id);
        records[id] = &entry;
        CHECK(entry["nanosecondsPerSample"]["repeats"].GetInt() == 7);
        CHECK(entry["nanosecondsPerSample"]["minimum"].GetDouble() > 0);
        REQUIRE(entry["rmse"].Size() == 4);
        CHECK(entry["frames"][3].GetInt() == 64);
        const std::string texels = entry["texels"].GetString();
        if (texels == "all texels")
            CHECK(entry["rmse"][0].GetDouble() == 0);
        if (texels == "one texel" || texels == "2 x 2 share")
            CHECK(entry["texelsPerSample"].GetDouble() == 1);
        if (texels == "one texel") // R2 is between 1 / sqrt(64) and 1 / 64
            CHECK(entry["rmse"][3].GetDouble() < entry["rmse"][0].GetDouble() / 6);
    }
    const auto get = [&](const char* id, const char* key) { return (*records.at(id))[key].GetDouble(); };
    CHECK(get("filtering trilinear: all texels", "texelsPerSample") == 4); // magnified: one mip
    CHECK(get("filtering trilinear: waves collaborate", "texelsPerSample") < 1);
    CHECK((*records.at("filtering trilinear: waves collaborate"))["rmse"][0].GetDouble() == 0);
    CHECK(get("filtering anisotropic, floor: all texels", "texelsPerSample") > 8);
    const auto& shared = (*records.at("filtering trilinear: 2 x 2 share"))["rmse"];
    const auto& one = (*records.at("filtering trilinear: one texel"))["rmse"];
    CHECK(shared[0].GetDouble() < one[0].GetDouble());
    CHECK(shared[3].GetDouble() > one[3].GetDouble());

    const std::string page = ReadText(folder / "out/report.html");
    CHECK(page.find("<h2 id=filtering>") != std::string::npos);
    CHECK_FALSE(FindChart(page, "Filtering: ").empty());
    // Files of before have no such list.
    report.RemoveMember("filtering");
    WriteText(folder / "older.json", ToText(report));
    CHECK(RunProgram(folder, "report -o older --from older.json").code == 0);
    CHECK(ReadText(folder / "older/report.html").find("id=filtering") == std::string::npos);
}
