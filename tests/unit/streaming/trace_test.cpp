// SPDX-License-Identifier: MIT
// Recorded scenarios of a tile manager: those of the conformance folder, all of them, and a few of our own
// that need no folder.
#include "TraceReplay.h"

#include "support/Files.h"
#include "support/Vectors.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

std::filesystem::path GetTraceFolder() {
    return GetConformanceFolder() / "tile-manager";
}

std::string ReadText(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = ReadBytes(path);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

rapidjson::Document ParseTrace(const std::string& text) {
    rapidjson::Document document;
    document.Parse(text.c_str());
    REQUIRE_FALSE(document.HasParseError());
    return document;
}

} // namespace

TEST_CASE("tile manager traces: all recorded ones are replayed") {
    std::vector<std::filesystem::path> files;
    if (std::filesystem::is_directory(GetTraceFolder())) {
        for (const auto& entry : std::filesystem::directory_iterator(GetTraceFolder())) {
            if (entry.path().extension() == ".json" && entry.path().stem() != "undefined")
                files.push_back(entry.path());
        }
    }
    if (files.empty()) {
        MESSAGE("SKIP: no traces of tile managers: set OPENNTC_SHARED_DIR");
        ReportVectors("tile-manager", 0, 1);
        return;
    }
    std::sort(files.begin(), files.end());
    std::size_t comparisons = 0;
    for (const std::filesystem::path& file : files) {
        const rapidjson::Document trace = ParseTrace(ReadText(file));
        TraceReplay replay;
        replay.Run(trace);
        for (const std::string& finding : replay.GetFindings())
            FAIL_CHECK(file.filename().string() << ": " << finding);
        CHECK(replay.GetComparisons() > 0);
        comparisons += replay.GetComparisons();
    }
    MESSAGE("traces: " << files.size() << ", comparisons: " << comparisons);
    ReportVectors("tile-manager", static_cast<int>(files.size()), 0);
}

TEST_CASE("tile manager traces: where behaviour was undefined there is a status, and other textures stay") {
    const std::filesystem::path file = GetTraceFolder() / "undefined.json";
    if (!std::filesystem::exists(file)) {
        MESSAGE("SKIP: no traces of tile managers: set OPENNTC_SHARED_DIR");
        return;
    }
    // The steps that are refused, and how, by what the file says is right in words.
    const std::map<std::string, std::map<std::string, Status>> refused = {
        {"removal-with-waiting-tail", {}},
        {"heap-in-use-removed", {{"removeHeap", Status::InvalidState}}},
        {"no-tail-64-regular-tiles", {}},
        {"width-1", {}},
        {"tail-tiles-without-tail-mips", {{"add", Status::InvalidArgument}}},
        {"heap-of-zero-tiles", {{"manager", Status::OutOfRange}}},
        {"unknown-texture", {{"update", Status::InvalidArgument}}},
        {"feedback-after-removal", {{"update", Status::InvalidArgument}}},
        {"same-heap-twice", {{"addHeap", Status::InvalidArgument}}},
        {"tile-width-not-a-power-of-two", {}},
    };
    const rapidjson::Document document = ParseTrace(ReadText(file));
    std::size_t cases = 0;
    for (const rapidjson::Value& scenario : document["cases"].GetArray()) {
        const std::string name = scenario["name"].GetString();
        CAPTURE(name);
        REQUIRE(refused.count(name) == 1);
        TraceReplay replay;
        std::map<std::string, Status> found;
        for (const rapidjson::Value& step : scenario["steps"].GetArray()) {
            const Status status = replay.RunStep(step);
            if (status != Status::Ok)
                found[step["op"].GetString()] = status;
            if (!replay.HasManager())
                break;
            CHECK(replay.GetManager().CheckInvariants());
        }
        CHECK(found == refused.at(name));
        for (const std::string& finding : replay.GetFindings())
            FAIL_CHECK(finding);
        ++cases;
        if (name == "no-tail-64-regular-tiles") // the level is pinned and asked for by nobody else
            CHECK(replay.GetManager().GetStatistics().requestedTiles == 64);
        if (name == "tile-width-not-a-power-of-two") { // region (1, 0) is over tiles (0, 0) and (1, 0)
            CHECK(*replay.GetManager().GetTileState(replay.GetTexture(0), 0) == ManagedTileState::Mapped);
            CHECK(*replay.GetManager().GetTileState(replay.GetTexture(0), 1) == ManagedTileState::Mapped);
            CHECK(*replay.GetManager().GetTileState(replay.GetTexture(0), 2) == ManagedTileState::Free);
        }
        if (name == "same-heap-twice")
            CHECK(replay.GetManager().GetStatistics().slots == 2);
    }
    CHECK(cases == refused.size());
}
