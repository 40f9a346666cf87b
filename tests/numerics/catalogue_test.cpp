// SPDX-License-Identifier: MIT
// Runs the catalogue, and keeps docs/hard-cases.md equal to it.
#include "BlockMistakes.h"
#include "Decoders.h"
#include "HardCases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace numerics {

std::vector<HardCase> ListHardCases() {
    std::vector<HardCase> cases;
    for (const std::span<const HardCase> part :
         {ListGeometryCases(), ListSliceCases(), ListTileCases(), ListFilterCases(), ListBlockCases(),
          ListWeightCases(), ListActivationCases(), ListFormatCases(), ListColorCases(),
          ListDeterminismCases(), ListEncoderCases()})
        cases.insert(cases.end(), part.begin(), part.end());
    return cases;
}

namespace {

std::string FormatBound(double bound) {
    if (bound == 0)
        return "0 (bit for bit)";
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", bound);
    return text;
}

std::string Quote(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            quoted += '\\';
        quoted += c;
    }
    return quoted + '"';
}

/// The parts of a list joined by ", ".
std::vector<std::string> Split(const std::string& text) {
    std::vector<std::string> parts;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(", ", at), text.size());
        parts.push_back(text.substr(at, end - at));
        at = end + 2;
    }
    return parts;
}

std::string MakeDocument() {
    std::string text =
        "<!-- SPDX-License-Identifier: MIT -->\n# Hard cases\n\n"
        "Made from the tables in `tests/numerics/*Cases.cpp` by\n"
        "`OPENNTC_WRITE_HARD_CASES=docs/hard-cases.md build/dev/bin/numerics -tc=\"the document*\"`; a test "
        "keeps it\n"
        "current. Every case of decoders runs on the C++ reference, the fast decoder and lavapipe, or the "
        "GPU that\n"
        "`OPENNTC_TEST_DEVICE` names, and is compared with an independent model in integers and double "
        "precision\n"
        "(`examples/ntc/conformance/Model.h`). `build/dev/bin/numerics` prints each case's worst error;\n"
        "`OPENNTC_HARD_CASES_JSON=FILE` writes them to a file (`schemas/hard-cases.schema.json`).\n";
    text +=
        "\n## What is covered by what\n\nEvery hard case that the requirements and the format specification "
        "name. Cases are sections of this page, tests\nfiles in `tests/`.\n\n| hard case | cases | further "
        "tests |\n|---|---|---|\n";
    for (const AuditRow& row : ListAudit())
        text += std::string("| ") + row.what + " | " + row.cases + " | " + row.tests + " |\n";
    for (const HardCase& hardCase : ListHardCases())
        text += std::string("\n## ") + hardCase.name + "\n\n" + hardCase.breaks +
                "\n\n- In whom: " + hardCase.whom + "\n- Why not here: " + hardCase.why +
                "\n- Bound: " + FormatBound(hardCase.bound) + "\n";
    return text;
}

} // namespace

TEST_CASE("hard cases stay within their bounds") {
    std::set<std::string> names;
    std::string json;
    const char* named = std::getenv("OPENNTC_TEST_DEVICE");
    const std::string device = named != nullptr ? named : "llvmpipe";
    const bool trains = std::getenv("OPENNTC_HARD_CASES_WITHOUT_TRAINING") == nullptr;
    std::set<std::string> trainings;
    for (const HardCase& hardCase : ListEncoderCases())
        trainings.insert(hardCase.name);
    for (const HardCase& hardCase : ListHardCases()) {
        CAPTURE(hardCase.name);
        CHECK(names.insert(hardCase.name).second);
        if (!trains && trainings.count(hardCase.name) != 0) {
            MESSAGE("SKIP: " << std::string(hardCase.name)
                             << ": trains, and OPENNTC_HARD_CASES_WITHOUT_TRAINING is set");
            continue;
        }
        const Measurement measurement = hardCase.measure();
        CHECK_FALSE(std::isnan(measurement.worst));
        CHECK(measurement.worst <= hardCase.bound);
        std::printf("HARDCASE %s: worst %.3g, bound %.3g%s%s\n", hardCase.name, measurement.worst,
                    hardCase.bound, measurement.note.empty() ? "" : "; ", measurement.note.c_str());
        char numbers[128];
        std::snprintf(numbers, sizeof numbers, "\"worst\": %.9g, \"bound\": %.9g",
                      std::isfinite(measurement.worst) ? measurement.worst : 1e308, hardCase.bound);
        json += std::string(json.empty() ? "" : ",\n") + "  {\"name\": " + Quote(hardCase.name) +
                ", \"breaks\": " + Quote(hardCase.breaks) + ", \"whom\": " + Quote(hardCase.whom) +
                ", \"why\": " + Quote(hardCase.why) + ", " + numbers +
                ", \"note\": " + Quote(measurement.note) + ", \"device\": " + Quote(device) + "}";
    }
    if (const char* path = std::getenv("OPENNTC_HARD_CASES_JSON"))
        std::ofstream(path) << "[\n" << json << "\n]\n";
}

TEST_CASE("hard cases notice the mistakes that they are about") {
    using openntc::conformance::Mistake;
    const std::pair<std::string, Mistake> kMistakes[] = {{"texels-on-latents", Mistake::ReorderedCoordinates},
                                                         {"clamped-taps", Mistake::WrappedTaps},
                                                         {"tail-mips", Mistake::MissingLodClamp},
                                                         {"large-coordinates", Mistake::ReorderedCoordinates},
                                                         {"bilinear-weight-sums", Mistake::RoundedWeights},
                                                         {"latent-codes", Mistake::SaturatedLatents},
                                                         {"extreme-weights", Mistake::SwappedCorners},
                                                         {"accumulators", Mistake::NarrowAccumulator},
                                                         {"scales", Mistake::HalfInfinity},
                                                         {"infinite-activations", Mistake::HalfInfinity},
                                                         {"fp8-network", Mistake::FP8SaturationMissing},
                                                         {"fp16-network", Mistake::SwappedCorners},
                                                         {"fp32-network", Mistake::Contraction},
                                                         {"random-sets", Mistake::HalfAwayTies}};
    for (const HardCase& hardCase : ListHardCases()) {
        for (const auto& entry : kMistakes) {
            if (entry.first != hardCase.name)
                continue;
            CAPTURE(entry.first);
            const PlantedMistake planted(entry.second);
            CHECK(hardCase.measure().worst > hardCase.bound);
        }
    }
}

TEST_CASE(
    "hard cases of block compression notice the mistakes that they are about, and every mistake is noticed") {
    const std::pair<std::string, BlockMistake> kMistakes[] = {
        {"blocks-one-colour", BlockMistake::TruncatedColors},
        {"blocks-two-colours", BlockMistake::InsetEndpoints},
        {"blocks-ramps", BlockMistake::ExtremesOnly},
        {"blocks-alpha-ends", BlockMistake::RoundedAlpha},
        {"blocks-alpha-threshold", BlockMistake::ThresholdOpaque},
        {"blocks-half-numbers", BlockMistake::NanIsLargest},
        {"blocks-half-numbers", BlockMistake::SignDropped},
        {"blocks-signed", BlockMistake::SignDropped},
        {"blocks-signed", BlockMistake::OffsetBinary},
        {"blocks-edges", BlockMistake::ZeroBeyondEdge},
        {"blocks-edges", BlockMistake::PaddedRows},
        {"blocks-degenerate-codes", BlockMistake::ReservedCodeMode0},
        {"blocks-determinism", BlockMistake::LevelIgnored}};
    std::set<BlockMistake> planted;
    for (const HardCase& hardCase : ListBlockCases()) {
        bool isNoticed = false;
        for (const auto& entry : kMistakes) {
            if (entry.first != hardCase.name)
                continue;
            CAPTURE(entry.first);
            CAPTURE(static_cast<int>(entry.second));
            const PlantedBlockMistake mistake(entry.second);
            planted.insert(entry.second);
            isNoticed = hardCase.measure().worst > hardCase.bound;
            CHECK(isNoticed);
        }
        CHECK_MESSAGE(isNoticed, hardCase.name); // each case has a mistake of its own
    }
    CHECK(planted.size() == static_cast<std::size_t>(BlockMistake::Last));
}

TEST_CASE("what covers a hard case exists, and every case covers one") {
    std::set<std::string> names;
    for (const HardCase& hardCase : ListHardCases())
        names.insert(hardCase.name);
    std::set<std::string> named;
    for (const AuditRow& row : ListAudit()) {
        CAPTURE(row.what);
        CHECK((*row.cases != '\0' || *row.tests != '\0'));
        for (const std::string& name : Split(row.cases)) {
            CAPTURE(name);
            CHECK(names.count(name) == 1);
            named.insert(name);
        }
        for (const std::string& file : Split(row.tests)) {
            CAPTURE(file);
            CHECK(std::filesystem::exists(std::string(OPENNTC_DOCS_DIR) + "/../tests/" + file));
        }
    }
    CHECK(named == names);
}

TEST_CASE("the document of hard cases is current") {
    const std::string document = MakeDocument();
    if (const char* path = std::getenv("OPENNTC_WRITE_HARD_CASES"))
        std::ofstream(path, std::ios::binary) << document;
    std::ifstream file(OPENNTC_DOCS_DIR "/hard-cases.md", std::ios::binary);
    const std::string current{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const bool isCurrent = current == document; // not shown in full when it is not
    CHECK(isCurrent);
}

} // namespace numerics
