// SPDX-License-Identifier: MIT
// The triangles of a glTF model, mesh by mesh as nodes ask for them.
#pragma once

#include "renderer/scene/Scene.h"

#include "gltf/GltfAccessor.h"
#include "gltf/GltfFile.h"

#include <string>
#include <vector>

namespace openntc::renderer {

struct PrimitiveRange {
    int first = 0, count = 0;
};

/// Appends to vertices, indices and primitives of a scene whose materials are there already.
class GltfGeometry {
public:
    GltfGeometry(tool::GltfFile& file, Scene& scene);

    /// The primitives of a mesh, which is read once. Throws CommandError(BadInput).
    PrimitiveRange ReadMesh(int mesh);

    /// In the mesh's space.
    const Bounds& GetBounds(int primitive) const { return bounds_[static_cast<std::size_t>(primitive)]; }

private:
    using Value = tool::GltfFile::Value;

    void ReadPrimitive(const Value& primitive, const std::string& where);
    std::vector<Vertex> ReadVertices(const Value& attributes, const std::string& where, Primitive& primitive);
    std::vector<std::uint32_t> ReadTriangles(const Value& primitive, const std::string& where, int mode,
                                             std::size_t vertices);
    int GetMaterial(const Value& primitive, const std::string& where);
    void Append(Primitive primitive, const std::vector<Vertex>& vertices,
                const std::vector<std::uint32_t>& indices, const std::string& where);

    tool::GltfFile& file_;
    Scene& scene_;
    tool::GltfAccessorReader accessors_;
    std::vector<PrimitiveRange> meshes_; ///< count -1: not read
    std::vector<Bounds> bounds_;         ///< of primitives
    int defaultMaterial_ = -1;
};

} // namespace openntc::renderer
