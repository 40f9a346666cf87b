// SPDX-License-Identifier: MIT
// Recorded scenarios of a tile manager: those of the conformance folder, all of them, and a few of our own
// that need no folder.
#include "TraceReplay.h"

#include "support/Files.h"
#include "support/Vectors.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
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
