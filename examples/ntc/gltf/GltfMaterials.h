// SPDX-License-Identifier: MIT
// Materials of a glTF 2.0 model as lists of images at fixed channels.
#pragma once

#include "encode/Manifest.h"

#include <string>
#include <vector>

namespace openntc::tool {

struct GltfMaterial {
    std::string name;  ///< "material" and its index where the model gives none
    Manifest manifest; ///< no textures: the material has no images
};

/// Reads a .gltf file. Channels: BaseColor 0 - 3, metalness 4, roughness 5, Normal 8 - 10, Occlusion 11, Emissive
/// 12 - 14, Transmission 15; specular-glossiness: Diffuse 0 - 3, SpecularGlossiness 4 - 7. Alpha is kept for alphaMode
/// BLEND and MASK, in the latter as a mask. Throws CommandError(BadInput) naming the field.
std::vector<GltfMaterial> ReadGltfMaterials(const std::string& path);

} // namespace openntc::tool
