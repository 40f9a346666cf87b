// SPDX-License-Identifier: MIT
#include "renderer/gpu/SceneBuffers.h"

#include "renderer/gpu/TextureStore.h"
#include "renderer/scene/EnvironmentTable.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

template <typename T>
Buffer Upload(Context& context, const std::vector<T>& items) {
    return RequireDevice(context.CreateBuffer(std::as_bytes(std::span(items)), BufferKind::Storage,
                                              BufferMemory::DeviceLocal));
}

std::vector<shader::NtcrVertex> ConvertVertices(const Scene& scene) {
    std::vector<shader::NtcrVertex> vertices;
    vertices.reserve(scene.vertices.size());
    for (const Vertex& vertex : scene.vertices)
        vertices.push_back({glm::vec4(vertex.position, vertex.uv[0].x),
                            glm::vec4(vertex.normal, vertex.uv[0].y), vertex.tangent, vertex.color,
                            glm::vec4(vertex.uv[1], 0.0f, 0.0f)});
    return vertices;
}

std::vector<shader::NtcrInstance> ConvertInstances(const Scene& scene) {
    std::vector<shader::NtcrInstance> instances;
    for (const Instance& instance : scene.instances) {
        const Primitive& primitive = scene.primitives[static_cast<std::size_t>(instance.primitive)];
        const std::uint32_t flags = (instance.flipped ? NTCR_FLIPPED : 0u) |
                                    (primitive.hasTangents && primitive.hasNormals ? NTCR_TANGENTS : 0u) |
                                    (primitive.hasNormals ? NTCR_NORMALS : 0u);
        instances.push_back({instance.toWorld, primitive.firstIndex, flags,
                             static_cast<std::uint32_t>(primitive.material), 0});
    }
    return instances;
}

Bounds FindBounds(const Scene& scene, const Primitive& primitive) {
    constexpr float kFar = std::numeric_limits<float>::max();
    Bounds bounds{glm::vec3(kFar), glm::vec3(-kFar)};
    for (std::uint32_t i = 0; i < primitive.indexCount; ++i) {
        const glm::vec3& position = scene.vertices[scene.indices[primitive.firstIndex + i]].position;
        bounds.low = glm::min(bounds.low, position);
        bounds.high = glm::max(bounds.high, position);
    }
    return bounds;
}

/// Clip space's x and y of a box, -1 … 1; all of it where a corner is behind the eye.
struct ScreenRect {
    float left = 1.0f, top = 1.0f, right = -1.0f, bottom = -1.0f;

    void Add(const Bounds& box, const glm::mat4& toClip) {
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec4 clip = toClip * glm::vec4((corner & 1) != 0 ? box.high.x : box.low.x,
                                                      (corner & 2) != 0 ? box.high.y : box.low.y,
                                                      (corner & 4) != 0 ? box.high.z : box.low.z, 1.0f);
            if (clip.w <= 1e-6f) {
                left = top = -1.0f;
                right = bottom = 1.0f;
                return;
            }
            left = std::min(left, clip.x / clip.w);
            right = std::max(right, clip.x / clip.w);
            top = std::min(top, clip.y / clip.w);
            bottom = std::max(bottom, clip.y / clip.w);
        }
    }
};

/// First and last tile of a range of clip space, a pixel wider on both sides.
std::pair<std::int64_t, std::int64_t> FindTileRange(float low, float high, int size, std::uint32_t tile) {
    const auto toPixel = [size](float at) {
        return std::clamp(0.5 * (static_cast<double>(at) + 1.0), 0.0, 1.0) * size;
    };
    const auto first = static_cast<std::int64_t>(std::floor(toPixel(low) - 1.0));
    const auto last = static_cast<std::int64_t>(std::floor(toPixel(high) + 1.0));
    return {std::max<std::int64_t>(first, 0) / tile, std::min<std::int64_t>(last, size - 1) / tile};
}

} // namespace

SceneBuffers::SceneBuffers(Context& context, const Scene& scene)
    : scene_(scene), vertices_(Upload(context, ConvertVertices(scene))),
      indices_(Upload(context, scene.indices)), instances_(Upload(context, ConvertInstances(scene))),
      environment_(Upload(context, GetEnvironmentTable())) {
    for (const Primitive& primitive : scene.primitives)
        bounds_.push_back(FindBounds(scene, primitive));
}

std::uint64_t SceneBuffers::GetBytes() const {
    return vertices_.GetSize() + indices_.GetSize() + instances_.GetSize() + environment_.GetSize();
}

TileRect SceneBuffers::FindTiles(int material, const glm::mat4& toClip, int width, int height) const {
    ScreenRect rect;
    for (const Instance& instance : scene_.instances) {
        const auto primitive = static_cast<std::size_t>(instance.primitive);
        if (scene_.primitives[primitive].material == material && scene_.primitives[primitive].indexCount > 0)
            rect.Add(bounds_[primitive], toClip * instance.toWorld);
    }
    if (!(rect.left <= rect.right) || rect.left > 1.0f || rect.right < -1.0f || rect.top > 1.0f ||
        rect.bottom < -1.0f)
        return {};
    const auto [left, right] = FindTileRange(rect.left, rect.right, width, kTileWidth);
    const auto [top, bottom] = FindTileRange(rect.top, rect.bottom, height, kTileHeight);
    return {static_cast<std::uint32_t>(left), static_cast<std::uint32_t>(top),
            static_cast<std::uint32_t>(right - left + 1), static_cast<std::uint32_t>(bottom - top + 1)};
}

std::vector<std::size_t> SceneBuffers::SortBlended(const glm::mat4& toClip) const {
    std::vector<std::pair<float, std::size_t>> order; // depth grows towards the eye
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        const Instance& instance = scene_.instances[i];
        const Primitive& primitive = scene_.primitives[static_cast<std::size_t>(instance.primitive)];
        if (scene_.materials[static_cast<std::size_t>(primitive.material)].alphaMode != AlphaMode::Blend)
            continue;
        const glm::vec4 clip = toClip * (instance.toWorld * glm::vec4(primitive.center, 1.0f));
        order.emplace_back(clip.w > 0.0f ? clip.z / clip.w : std::numeric_limits<float>::max(), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::size_t> result;
    for (const auto& [depth, index] : order)
        result.push_back(index);
    return result;
}

} // namespace openntc::renderer
