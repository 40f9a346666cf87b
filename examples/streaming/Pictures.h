// SPDX-License-Identifier: MIT
// Frames and maps as PNG files.
#pragma once

#include "Landscape.h"
#include "Renderer.h"

#include "openntc/streaming/HostPageTable.h"

#include <filesystem>
#include <span>

namespace openntc::landscape {

/// Means of samples x samples colours are the pixels of a picture `width` wide.
void WriteFramePng(const std::filesystem::path& path, const Picture& picture, int width, int height,
                   int samples);

/// All fields from above, a pixel for each tile of the finest level (and `scale` x `scale` of them): how fine
/// what is there is. Dark: the tail alone; from blue over green to yellow: finer levels. `x`, `z`: the
/// camera, in fields.
void WriteResidencyPng(const std::filesystem::path& path, const Landscape& landscape, const PageTable& table,
                       std::span<const std::uint32_t> textureIds, double x, double z);

} // namespace openntc::landscape
