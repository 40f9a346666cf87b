// SPDX-License-Identifier: MIT
// Which texture sets the materials of a scene have.
#pragma once

#include "renderer/scene/Scene.h"

#include <string>

namespace openntc::renderer {

/// Looks in `materialDir` (empty: beside the model) for materials.json of `ntc convert-gltf`, which says what
/// is where; for materials that it says nothing of, for NAME.ntc, whose textures are told by their names
/// (BaseColor or Diffuse; MetallicRoughness, or Metalness and Roughness in a row; SpecularGlossiness; Normal;
/// Occlusion; Emissive; Transmission). Of a set only textures that are addressed as its first one are used.
/// What is missing or broken is noted in Scene::textureSets and Scene::warnings, and its materials keep their
/// source images.
void AttachTextureSets(const std::string& modelPath, const std::string& materialDir, Scene& scene);

/// The same for one file and a material of the scene.
void AttachTextureSet(const std::string& path, Material& material, Scene& scene);

} // namespace openntc::renderer
