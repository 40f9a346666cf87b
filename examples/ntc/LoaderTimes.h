// SPDX-License-Identifier: MIT
// Timing of demand loaders that load all tiles of their textures into memory.
#pragma once

#include "openntc/core/Shared.h"
#include "openntc/streaming/TileSource.h"
#include "openntc/streaming/TiledTexture.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace openntc::tool {

struct LoaderJob {
    std::string name; ///< of the file, for errors
    TileFormat format = TileFormat::TextureSet;
    /// Called before each run: a source for each texture. Textures of one source do not share its tiles.
    std::function<std::vector<Shared<TileSource>>()> open;
    int limit = 256; ///< tiles that are read at a time
};

struct LoaderRun {
    double seconds = 0;
    std::uint64_t tiles = 0;
    std::uint64_t bytes = 0;
    std::uint32_t launches = 0;
    std::uint32_t crc = 0; ///< sum of the CRC-32s of all slots
};

/// Asks for all tiles of all textures until they are there: one run that is not counted and `repeat` that
/// are. Throws CommandError if a tile cannot be read, and if the user interrupts.
std::vector<LoaderRun> TimeLoader(const LoaderJob& job, int threads, int repeat);

} // namespace openntc::tool
