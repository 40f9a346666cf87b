// SPDX-License-Identifier: MIT
// The camera's way: frames, each in passes until nothing is missing, and what is written of them.
#pragma once

#include "Landscape.h"
#include "Timeline.h"

#include <filesystem>
#include <string>

namespace openntc::landscape {

struct SessionOptions {
    LandscapeOptions landscape;
    std::string device; ///< as `ntc --device` takes it
    int width = 320;    ///< pixels of a frame
    int height = 180;
    int samples = 1;       ///< per pixel and axis
    int frames = 48;       ///< along the path
    int passes = 0;        ///< at most, of a frame; 0: until nothing is missing
    double budget = 0;     ///< MiB for tiles; 0: 64, or an eighth of all latents where that is less
    int tilesPerPass = 0;  ///< uploads before a pass, at most; 0: all
    int threads = 2;       ///< that read tiles
    int check = 16;        ///< every so many pixels against the C++ decoder, in the last frame all; 0: none
    bool compares = false; ///< with all latents resident
    bool json = false;
    std::filesystem::path output;
};

/// Renders everything and writes PNG files, timeline.json and timeline.svg to the output folder. Throws
/// CommandError; what was written before it disappears.
Report RunSession(const SessionOptions& options);

} // namespace openntc::landscape
