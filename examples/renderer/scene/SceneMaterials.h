// SPDX-License-Identifier: MIT
// Materials of a glTF model: factors, textures and how they are addressed.
#pragma once

#include "renderer/scene/Scene.h"
#include "renderer/scene/SceneImages.h"

#include "gltf/GltfFile.h"

namespace openntc::renderer {

/// Fills Scene::materials in the order of the file, and Scene::images (names, no texels). Throws
/// CommandError(BadInput) for fields that are malformed; a texture that cannot be found is left out with a
/// warning.
void ReadSceneMaterials(tool::GltfFile& file, Scene& scene, ImageSources& images);

/// The slot of a texture by its name in a texture set that `ntc convert-gltf` made; Count for others.
TextureSlot FindTextureSlot(std::string_view name);

} // namespace openntc::renderer
