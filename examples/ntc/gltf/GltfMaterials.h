// SPDX-License-Identifier: MIT
// Materials of a glTF 2.0 model as textures at fixed channels.
#pragma once

#include "encode/Manifest.h"
#include "gltf/GltfFile.h"
#include "gltf/TextureAddressing.h"

#include <string>
#include <vector>

namespace openntc::tool {

struct GltfTexture {
    ManifestTexture
        source;        ///< its swizzle has as many letters as the slot has channels, whatever the image has
    std::string slot;  ///< `materials[0].normalTexture`
    std::string image; ///< for messages: the decoded URI, or `images[3]`
    TextureAddressing addressing;
};

/// A texture of the model that no set holds.
struct DroppedTexture {
    std::string slot; ///< `extensions.KHR_materials_clearcoat.clearcoatTexture`, inside the material
    std::string reason;
};

struct GltfMaterial {
    std::string name;                  ///< "material" and its index where the model gives none
    std::string where;                 ///< `materials[0]`
    std::vector<GltfTexture> textures; ///< none: the material has no images
    float keepCoverage = 0.0f; ///< MASK: the cutoff in terms of the texture's alpha, if 0 ... 1; 0: none
    std::vector<DroppedTexture> notConverted;
    std::vector<std::string>
        errors; ///< `materials[0].normalTexture: value: limit`; not empty: not to be encoded
};

/// Reads a .gltf or .glb file. Channels: BaseColor 0 - 3, metalness 4, roughness 5, Normal 8 - 10, Occlusion 11, Emissive
/// 12 - 14, Transmission 15; specular-glossiness: Diffuse 0 - 3, SpecularGlossiness 4 - 7. Alpha is kept for alphaMode
/// BLEND and MASK, in the latter as a mask whose coverage mips keep. Throws CommandError(BadInput) naming the field for what concerns the whole
/// model; what concerns one material stands in its `errors`.
std::vector<GltfMaterial> ReadGltfMaterials(const std::string& path);

/// Of a file that is open; none is no error.
std::vector<GltfMaterial> ReadGltfMaterials(GltfFile& file);

/// Adds a texture to a file of its material.
void AddTexture(Manifest& manifest, const GltfMaterial& material, const GltfTexture& texture);

/// True if the alpha of one of the textures is how much of a texel is seen.
bool HasAlpha(const Manifest& manifest);

/// All textures of a material, whatever their addressing.
Manifest MakeManifest(const GltfMaterial& material);

} // namespace openntc::tool
