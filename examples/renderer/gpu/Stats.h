// SPDX-License-Identifier: MIT
// What `--stats` writes.
#pragma once

#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/Renderer.h"

#include <cstdint>
#include <string>
#include <vector>

namespace openntc::renderer {

struct RunRecord {
    std::vector<PassSeconds> frames; ///< the first one contains what the driver compiles then
    TexelCounts texels;              ///< of all frames
    double loadSeconds = 0.0;        ///< until the first frame: textures, shaders, pipelines
};

const char* GetPassName(Pass pass);

struct BytesOfKind {
    const char* name;
    std::uint64_t bytes;
};

/// What a renderer holds on the device; textures by kind, and their sum as "textures".
std::vector<BytesOfKind> ListBytes(const Renderer& renderer);

/// JSON: docs/renderer.md says what is in it.
std::string MakeStats(const CommandLine& line, const Scene& scene, const harness::DeviceInfo& device,
                      const Renderer& renderer, const ShaderCache& shaders, const RunRecord& run);

} // namespace openntc::renderer
