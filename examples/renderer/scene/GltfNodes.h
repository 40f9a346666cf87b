// SPDX-License-Identifier: MIT
// The nodes of a glTF scene: instances of meshes, and cameras.
#pragma once

#include "renderer/scene/GltfGeometry.h"
#include "renderer/scene/Scene.h"

#include "gltf/GltfFile.h"

namespace openntc::renderer {

/// Fills instances, cameras and bounds from scene `sceneIndex` (-1: the default one; without any, all nodes
/// that are no one's child). Throws CommandError(BadInput), also for nodes that are reached twice.
void ReadNodes(const tool::GltfFile& file, int sceneIndex, GltfGeometry& geometry, Scene& scene);

} // namespace openntc::renderer
