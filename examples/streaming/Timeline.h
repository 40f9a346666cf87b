// SPDX-License-Identifier: MIT
// What happened along the path: numbers of each frame, as JSON, as text and as a plot.
#pragma once

#include "Landscape.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace openntc::landscape {

struct FrameRecord {
    int passes = 0;
    bool isComplete = false;     ///< the last pass missed nothing
    std::uint32_t wanted = 0;    ///< tiles that the last pass read, and those that it missed
    std::uint32_t missing = 0;   ///< of those: not there
    std::uint32_t resident = 0;  ///< tiles, when the frame was done
    std::uint64_t loaded = 0;    ///< tiles uploaded for this frame
    std::uint64_t evicted = 0;   ///< tiles whose slots were taken for this frame
    std::uint64_t requested = 0; ///< entries of the request queue
    std::uint64_t residentBytes = 0;
    double milliseconds = 0;       ///< the whole frame, its checks and files not counted
    double passMilliseconds = 0;   ///< of that: passes on the device
    double loaderMilliseconds = 0; ///< LaunchPrepare with its uploads, and ProcessRequests
    double waitMilliseconds = 0;   ///< for tiles to be read
    std::uint64_t checkedTexels = 0;
    std::uint64_t wrongTexels = 0;
};

/// Complete frames beside the same rendered with all latents there.
struct Comparison {
    std::uint64_t pixels = 0;
    std::uint64_t differentPixels = 0;
};

struct Report {
    std::string device;
    std::string driver;
    LandscapeOptions landscape;
    int width = 0;
    int height = 0;
    std::uint64_t texels = 0; ///< of mip 0
    std::uint32_t tiles = 0;
    std::uint32_t slotBytes = 0;
    std::uint32_t slots = 0;
    std::uint64_t budgetBytes = 0;
    std::uint64_t tableBytes = 0; ///< page table and launch state
    std::uint64_t allResidentBytes = 0;
    std::uint64_t blockCompressedBytes = 0;
    std::vector<FrameRecord> frames;
    std::optional<Comparison> comparison;
    double seconds = 0;
    std::vector<std::string> files;

    std::uint64_t GetWrongTexels() const noexcept;
    std::uint64_t GetCheckedTexels() const noexcept;
};

/// The output of `--json` (schemas/streaming.schema.json).
std::string MakeJson(const Report& report);
/// For people, a dozen lines.
std::string MakeText(const Report& report);

/// The plot as SVG, drawn in a folder for scratch. Throws CommandError(NoDevice) without gnuplot.
std::string DrawTimeline(const Report& report, const std::filesystem::path& folder);

} // namespace openntc::landscape
