// SPDX-License-Identifier: MIT
// Frames of a tile manager over many textures with random feedback, timed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

inline constexpr std::size_t kTilePhases = 7;
inline constexpr std::array<const char*, kTilePhases> kTilePhaseNames = {
    "update", "desiredHeaps", "trim", "allocate", "fetch", "confirm", "residency"};

struct TileFramesOptions {
    char variant =
        'A'; ///< A: every texture is updated; B: those with a changed region; C: whole textures change
    int textures = 0;
    double changePercent = 0; ///< of all regions, drawn with repetition; in C of the textures
    int frames = 0;           ///< of a run, after 12 that are not counted
    int repeat = 0;           ///< runs, each from new textures
    bool isEach = false;      ///< one call for each texture that is updated instead of one for all
};

struct Spread {
    double median = 0;
    double lower = 0; ///< quartiles
    double upper = 0;
};

/// CPU milliseconds of the thread per frame, over all frames of all runs; orders per frame, on average.
struct TileFramesResult {
    char variant = 'A';
    int textures = 0;
    double changePercent = 0;
    int changedRegions = 0;
    Spread total;
    std::array<double, kTilePhases> phases = {}; ///< medians
    double mapOrders = 0;
    double unmapOrders = 0;
    std::uint64_t usedSlots = 0; ///< at the end
    std::uint64_t heaps = 0;
};

/// Textures of 2048² in tiles of 256² (86 tiles, 64 regions), heaps of 256 tiles, 1000 in standby, a timeout
/// of 4
/// frames. Regions want mips 0 … 4 or nothing, each as often. Throws CommandError if the user interrupts.
TileFramesResult RunTileFrames(const TileFramesOptions& options);

/// Medians against the number of textures, a line per variant and share of change, both axes logarithmic.
/// Throws CommandError if the file cannot be written.
void WriteTileChart(std::span<const TileFramesResult> results, const std::string& path);

} // namespace openntc::tool
