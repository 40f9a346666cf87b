// SPDX-License-Identifier: MIT
// glTF 2.0 models as scenes.
#pragma once

#include "renderer/scene/Scene.h"

#include <string>

namespace openntc::renderer {

struct GltfSceneOptions {
    int scene = -1; ///< index of the scene to draw; -1: the file's default
    std::string
        materialDir; ///< where texture sets are looked for (TextureSetLookup.h); empty: beside the model
    bool readImages = true; ///< false: images stay without texels (width and height 0)
};

// What one scene may hold at most.
inline constexpr std::size_t kMaxVertices = std::size_t{1} << 23;
inline constexpr std::size_t kMaxIndices = std::size_t{1} << 26;
inline constexpr std::size_t kMaxInstances = std::size_t{1} << 20;
inline constexpr std::size_t kMaxImageTexels = std::size_t{1} << 29; ///< of all images

/// Reads a .gltf or .glb file with its buffers and images. Drawn are triangles, strips and fans;
/// metallic-roughness and specular-glossiness materials; two sets of texture coordinates. Skins, morph
/// targets and animations are left as they stand in the file. Tangents are computed (Tangents.h) where a
/// primitive with a normal map has none; tangents without normals are ignored. Throws
/// tool::CommandError(BadInput), `field: value: limit`, for a file that is malformed or insists on an
/// extension that is not drawn; an image or a texture set that cannot be read is noted in the scene.
Scene LoadGltfScene(const std::string& path, const GltfSceneOptions& options = {});

} // namespace openntc::renderer
