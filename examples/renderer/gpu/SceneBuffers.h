// SPDX-License-Identifier: MIT
// A scene's geometry on the device, and where it is on the screen.
#pragma once

#include "renderer/scene/Scene.h"
#include "renderer/shaders/Constants.h"

#include "vulkan_harness/Vulkan.h"

#include <cstdint>
#include <vector>

namespace openntc::renderer {

/// Tiles of 8 x 4 pixels, of which there is at least one unless `columns` is 0.
struct TileRect {
    std::uint32_t left = 0, top = 0, columns = 0, rows = 0;
};

inline constexpr std::uint32_t kTileWidth = 8, kTileHeight = 4;

class SceneBuffers {
public:
    SceneBuffers(harness::Context& context, const Scene& scene);

    const harness::Buffer& GetVertices() const { return vertices_; }
    const harness::Buffer& GetIndices() const { return indices_; }
    const harness::Buffer& GetInstances() const { return instances_; }
    const harness::Buffer& GetEnvironment() const { return environment_; }
    std::uint64_t GetBytes() const;

    /// The tiles that instances of a material can touch.
    TileRect FindTiles(int material, const glm::mat4& toClip, int width, int height) const;
    /// Indices of instances with AlphaMode::Blend, from the farthest primitive's centre to the nearest; of equal ones the
    /// lower index first.
    std::vector<std::size_t> SortBlended(const glm::mat4& toClip) const;

private:
    const Scene& scene_;
    std::vector<Bounds> bounds_; // of primitives, in their own space
    harness::Buffer vertices_, indices_, instances_, environment_;
};

} // namespace openntc::renderer
