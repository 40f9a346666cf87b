// SPDX-License-Identifier: MIT
// Tangents for normal maps, as MikkTSpace defines them (Mikkelsen 2008): what baking tools use where a model
// has none.
#pragma once

#include "renderer/scene/Scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace openntc::renderer {

/// Gives every vertex of the triangles a tangent for texture coordinates addressed by `address`. Vertices
/// that belong to several smooth groups (mirrored texture coordinates, triangles that touch in a vertex
/// alone) are split: new ones are appended, and `triangles` are changed to use them. glTF's images have their
/// origin at the top: bitangents point to where v falls.
void MakeTangents(std::vector<Vertex>& vertices, std::span<std::uint32_t> triangles,
                  const TextureAddress& address);

} // namespace openntc::renderer
