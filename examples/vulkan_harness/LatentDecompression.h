// SPDX-License-Identifier: MIT
// Latents of a set with compressed layers, decompressed by the device.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include "openntc/inference/LatentDecompression.h"

#include <cstddef>
#include <span>
#include <vector>

namespace openntc::harness {

/// What Context::Decompress is given for a plan. `work` and `latents` have at least workBytes and latentBytes.
struct LatentCommands {
    std::vector<DecompressedTile> tiles;
    std::vector<BufferCopy> copies;
};
void AddLatentCommands(const LatentDecompression& plan, const Buffer& work, const Buffer& latents,
                       LatentCommands& commands);

} // namespace openntc::harness
