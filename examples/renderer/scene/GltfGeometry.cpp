// SPDX-License-Identifier: MIT
#include "renderer/scene/GltfGeometry.h"

#include "renderer/scene/GltfFields.h"
#include "renderer/scene/GltfScene.h"
#include "renderer/scene/Tangents.h"

#include "Output.h"

#include <glm/common.hpp>

#include <algorithm>

namespace openntc::renderer {

namespace {

constexpr int kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6;

/// Triangles of a list, strip or fan; those that are lines are left out.
std::vector<std::uint32_t> MakeTriangles(const std::vector<std::uint32_t>& indices, int mode) {
    std::vector<std::uint32_t> triangles;
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
        const std::uint32_t i = indices[a], k = indices[b], l = indices[c];
        if (i != k && k != l && l != i)
            triangles.insert(triangles.end(), {i, k, l});
    };
    const std::size_t step = mode == kTriangles ? 3 : 1;
    triangles.reserve(mode == kTriangles ? indices.size() : 3 * indices.size());
    for (std::size_t i = 0; i + 2 < indices.size(); i += step) {
        if (mode == kTriangleFan)
            add(i + 1, i + 2, 0);
        else if (mode == kTriangleStrip && i % 2 == 1)
            add(i, i + 2, i + 1); // every second one is turned round
        else
            add(i, i + 1, i + 2);
    }
    return triangles;
}

} // namespace

GltfGeometry::GltfGeometry(tool::GltfFile& file, Scene& scene)
    : file_(file), scene_(scene), accessors_(file, kMaxIndices) {
    const Value* meshes = file.FindArray("meshes");
    meshes_.resize(meshes == nullptr ? 0 : meshes->Size(), {0, -1});
}

PrimitiveRange GltfGeometry::ReadMesh(int mesh) {
    PrimitiveRange& range = meshes_[static_cast<std::size_t>(mesh)];
    if (range.count >= 0)
        return range;
    const std::string where = tool::Format("meshes[%d]", mesh);
    const Value& value = (*file_.FindArray("meshes"))[static_cast<rapidjson::SizeType>(mesh)];
    const auto primitives = value.FindMember("primitives");
    if (primitives == value.MemberEnd() || !primitives->value.IsArray())
        file_.Fail(where + ".primitives", "must be an array");
    range.first = static_cast<int>(scene_.primitives.size());
    for (rapidjson::SizeType i = 0; i < primitives->value.Size(); ++i) {
        const std::string at = where + tool::Format(".primitives[%u]", i);
        if (!primitives->value[i].IsObject())
            file_.Fail(at, "must be an object");
        ReadPrimitive(primitives->value[i], at);
    }
    range.count = static_cast<int>(scene_.primitives.size()) - range.first;
    return range;
}

int GltfGeometry::GetMaterial(const Value& primitive, const std::string& where) {
    const int material = ReadIndex(file_, primitive, "material", "materials", where);
    if (material >= 0)
        return material;
    if (defaultMaterial_ < 0) {
        defaultMaterial_ = static_cast<int>(scene_.materials.size());
        scene_.materials.emplace_back().name = "default";
    }
    return defaultMaterial_;
}

std::vector<Vertex> GltfGeometry::ReadVertices(const Value& attributes, const std::string& where,
                                               Primitive& primitive) {
    const std::size_t count = accessors_.GetCount(attributes, "POSITION", where);
    if (count > kMaxVertices - scene_.vertices.size())
        file_.Fail(where + ".POSITION", tool::Format("%zu vertices: with %zu before it, more than %zu", count,
                                                     scene_.vertices.size(), kMaxVertices));
    std::vector<Vertex> vertices(count);
    const auto read = [&](const char* name, int low, int high, const auto& store) {
        if (!attributes.HasMember(name))
            return false;
        if (const std::size_t own = accessors_.GetCount(attributes, name, where); own != count)
            file_.Fail(where + "." + name, tool::Format("%zu elements: POSITION has %zu", own, count));
        const tool::GltfNumbers numbers = accessors_.ReadNumbers(attributes, name, where, low, high);
        const auto components = static_cast<std::size_t>(numbers.components);
        for (std::size_t i = 0; i < count; ++i)
            store(vertices[i], numbers.values.data() + i * components, numbers.components);
        return true;
    };
    read("POSITION", 3, 3, [](Vertex& v, const float* n, int) { v.position = {n[0], n[1], n[2]}; });
    primitive.hasNormals = read("NORMAL", 3, 3, [](Vertex& v, const float* n, int) {
        v.normal = {n[0], n[1], n[2]};
    });
    // Without normals given tangents must be ignored.
    primitive.hasTangents = primitive.hasNormals && read("TANGENT", 4, 4, [](Vertex& v, const float* n, int) {
                                v.tangent = {n[0], n[1], n[2], n[3] < 0.0f ? -1.0f : 1.0f};
                            });
    read("TEXCOORD_0", 2, 2, [](Vertex& v, const float* n, int) { v.uv[0] = {n[0], n[1]}; });
    read("TEXCOORD_1", 2, 2, [](Vertex& v, const float* n, int) { v.uv[1] = {n[0], n[1]}; });
    read("COLOR_0", 3, 4, [](Vertex& v, const float* n, int components) {
        v.color = {n[0], n[1], n[2], components == 4 ? n[3] : 1.0f};
    });
    return vertices;
}

std::vector<std::uint32_t> GltfGeometry::ReadTriangles(const Value& primitive, const std::string& where,
                                                       int mode, std::size_t vertices) {
    std::vector<std::uint32_t> indices;
    if (primitive.HasMember("indices")) {
        indices = accessors_.ReadIndices(primitive, "indices", where, vertices);
    } else {
        indices.resize(vertices);
        for (std::size_t i = 0; i < vertices; ++i)
            indices[i] = static_cast<std::uint32_t>(i);
    }
    const std::size_t count = mode == kTriangles ? indices.size() : 3 * indices.size();
    if (count > kMaxIndices - scene_.indices.size())
        file_.Fail(where, tool::Format("%zu triangles: with those before it, more than %zu", count / 3,
                                       kMaxIndices / 3));
    return MakeTriangles(indices, mode);
}

void GltfGeometry::ReadPrimitive(const Value& value, const std::string& where) {
    constexpr FloatRange kModes{0.0f, 6.0f};
    const int mode = static_cast<int>(ReadFloat(file_, value, "mode", where, kTriangles, kModes));
    const Value& attributes = file_.GetObject(value, "attributes", where + ".attributes");
    if (mode < kTriangles || !attributes.HasMember("POSITION")) {
        scene_.warnings.push_back(where + (mode < kTriangles ? ".mode: points and lines are not drawn"
                                                             : ".attributes: no POSITION: not drawn"));
        return;
    }
    Primitive primitive;
    primitive.material = GetMaterial(value, where);
    std::vector<Vertex> vertices = ReadVertices(attributes, where + ".attributes", primitive);
    std::vector<std::uint32_t> triangles = ReadTriangles(value, where, mode, vertices.size());
    const MaterialTexture& normal = scene_.materials[static_cast<std::size_t>(primitive.material)]
                                        .textures[static_cast<std::size_t>(TextureSlot::Normal)];
    if (normal.image >= 0 && primitive.hasNormals && !primitive.hasTangents) {
        MakeTangents(vertices, triangles, normal.address);
        primitive.hasTangents = true;
    }
    Append(primitive, vertices, triangles, where);
}

void GltfGeometry::Append(Primitive primitive, const std::vector<Vertex>& vertices,
                          const std::vector<std::uint32_t>& indices, const std::string& where) {
    if (indices.empty()) {
        scene_.warnings.push_back(where + ": no triangle");
        return;
    }
    if (vertices.size() > kMaxVertices - scene_.vertices.size())
        file_.Fail(where, tool::Format("%zu vertices with tangents: with those before it, more than %zu",
                                       vertices.size(), kMaxVertices));
    Bounds bounds{vertices[indices[0]].position, vertices[indices[0]].position};
    const auto base = static_cast<std::uint32_t>(scene_.vertices.size());
    primitive.firstIndex = static_cast<std::uint32_t>(scene_.indices.size());
    primitive.indexCount = static_cast<std::uint32_t>(indices.size());
    for (const std::uint32_t index : indices) {
        bounds.low = glm::min(bounds.low, vertices[index].position);
        bounds.high = glm::max(bounds.high, vertices[index].position);
        scene_.indices.push_back(base + index);
    }
    scene_.vertices.insert(scene_.vertices.end(), vertices.begin(), vertices.end());
    primitive.center = 0.5f * bounds.low + 0.5f * bounds.high;
    scene_.primitives.push_back(primitive);
    bounds_.push_back(bounds);
}

} // namespace openntc::renderer
