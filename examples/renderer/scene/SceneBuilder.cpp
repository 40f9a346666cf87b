// SPDX-License-Identifier: MIT
#include "renderer/scene/SceneBuilder.h"

#include "renderer/scene/Tangents.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>
#include <utility>

namespace openntc::renderer {

namespace {

constexpr float kTwoPi = 6.28318531f;

} // namespace

int SceneBuilder::AddImage(const std::string& label, int width, int height,
                           const std::function<std::uint32_t(int x, int y)>& texel) {
    SourceImage image;
    image.label = label;
    image.width = width;
    image.height = height;
    image.texels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::uint32_t rgba = texel(x, y);
            for (int shift = 0; shift < 32; shift += 8)
                image.texels.push_back(static_cast<std::uint8_t>(rgba >> shift));
        }
    }
    scene_.images.push_back(std::move(image));
    return static_cast<int>(scene_.images.size()) - 1;
}

int SceneBuilder::AddMaterial(Material material) {
    scene_.materials.push_back(std::move(material));
    return static_cast<int>(scene_.materials.size()) - 1;
}

int SceneBuilder::AddSurface(int material, int columns, int rows,
                             const std::function<Point(float u, float v)>& point) {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> triangles;
    Primitive primitive;
    primitive.material = material;
    for (int row = 0; row <= rows; ++row) {
        for (int column = 0; column <= columns; ++column) {
            const Point p = point(static_cast<float>(column) / static_cast<float>(columns),
                                  static_cast<float>(row) / static_cast<float>(rows));
            Vertex vertex;
            vertex.position = p.position;
            vertex.normal = p.normal;
            vertex.uv[0] = vertex.uv[1] = p.uv;
            primitive.hasNormals = primitive.hasNormals || p.normal != glm::vec3(0.0f);
            vertices.push_back(vertex);
        }
    }
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const glm::vec3 front = glm::cross(vertices[b].position - vertices[a].position,
                                           vertices[c].position - vertices[a].position);
        if (glm::length(front) < 1e-12f)
            return; // at a pole
        const float side = glm::dot(front, vertices[a].normal + vertices[b].normal + vertices[c].normal);
        triangles.insert(triangles.end(), {a, side < 0.0f ? c : b, side < 0.0f ? b : c});
    };
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const auto corner = static_cast<std::uint32_t>(row * (columns + 1) + column);
            const std::uint32_t below = corner + static_cast<std::uint32_t>(columns) + 1;
            add(corner, below, corner + 1);
            add(corner + 1, below, below + 1);
        }
    }
    const MaterialTexture& normal = scene_.materials[static_cast<std::size_t>(material)]
                                        .textures[static_cast<std::size_t>(TextureSlot::Normal)];
    if (normal.image >= 0 && primitive.hasNormals) {
        MakeTangents(vertices, triangles, normal.address);
        primitive.hasTangents = true;
    }
    glm::vec3 low = vertices[0].position, high = low;
    const auto base = static_cast<std::uint32_t>(scene_.vertices.size());
    primitive.firstIndex = static_cast<std::uint32_t>(scene_.indices.size());
    primitive.indexCount = static_cast<std::uint32_t>(triangles.size());
    for (const std::uint32_t index : triangles) {
        low = glm::min(low, vertices[index].position);
        high = glm::max(high, vertices[index].position);
        scene_.indices.push_back(base + index);
    }
    primitive.center = 0.5f * (low + high);
    scene_.vertices.insert(scene_.vertices.end(), vertices.begin(), vertices.end());
    scene_.primitives.push_back(primitive);
    return static_cast<int>(scene_.primitives.size()) - 1;
}

int SceneBuilder::AddQuad(int material, const UvTransform& transform, int cells) {
    return AddSurface(material, cells, cells, [&](float u, float v) {
        const glm::vec3 p(u, v, 1.0f);
        return Point{{u - 0.5f, 0.5f - v, 0.0f},
                     {0.0f, 0.0f, 1.0f},
                     {glm::dot(transform.row0, p), glm::dot(transform.row1, p)}};
    });
}

int SceneBuilder::AddSphere(int material, float repeat, int columns, int rows) {
    return AddSurface(material, columns, rows, [repeat](float u, float v) {
        const float around = kTwoPi * u, down = 0.5f * kTwoPi * v, ring = std::sin(down);
        const glm::vec3 n(ring * std::sin(around), std::cos(down), ring * std::cos(around));
        return Point{n, n, {u * repeat, v * repeat * 0.5f}};
    });
}

int SceneBuilder::AddTorus(int material, float major, float minor, glm::vec2 repeat) {
    return AddSurface(material, 64, 24, [=](float u, float v) {
        const float around = kTwoPi * u, across = kTwoPi * v;
        const glm::vec3 out(std::cos(around), std::sin(around), 0.0f);
        const glm::vec3 n = out * std::cos(across) + glm::vec3(0.0f, 0.0f, std::sin(across));
        return Point{out * major + n * minor, n, {u * repeat.x, v * repeat.y}};
    });
}

int SceneBuilder::AddCylinder(int material, glm::vec2 repeat) {
    return AddSurface(material, 48, 1, [=](float u, float v) {
        const glm::vec3 n(std::sin(kTwoPi * u), 0.0f, std::cos(kTwoPi * u));
        return Point{n + glm::vec3(0.0f, 1.0f - v, 0.0f), n, {u * repeat.x, v * repeat.y}};
    });
}

void SceneBuilder::Add(int primitive, const glm::mat4& toWorld) {
    scene_.instances.push_back({primitive, toWorld, glm::determinant(glm::mat3(toWorld)) < 0.0f});
}

void SceneBuilder::AddAt(int primitive, glm::vec3 position, glm::vec3 scale) {
    Add(primitive, MakePlace(position, scale));
}

void SceneBuilder::AddCamera(const std::string& name, glm::vec3 eye, glm::vec3 target, float yfov) {
    const glm::vec3 back = glm::normalize(eye - target);
    const glm::vec3 right = glm::normalize(glm::cross(glm::vec3(0.0f, 1.0f, 0.0f), back));
    Camera camera;
    camera.name = name;
    camera.yfov = yfov;
    camera.toWorld = glm::mat4(glm::vec4(right, 0.0f), glm::vec4(glm::cross(back, right), 0.0f),
                               glm::vec4(back, 0.0f), glm::vec4(eye, 1.0f));
    scene_.cameras.push_back(std::move(camera));
}

Scene SceneBuilder::Take() {
    UpdateBounds(scene_);
    return std::exchange(scene_, Scene{});
}

glm::mat4 MakePlace(glm::vec3 position, glm::vec3 scale) {
    glm::mat4 place(1.0f);
    place[0].x = scale.x;
    place[1].y = scale.y;
    place[2].z = scale.z;
    place[3] = glm::vec4(position, 1.0f);
    return place;
}

glm::mat4 MakeTurn(int axis, float angle) {
    glm::mat4 turn(1.0f);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    turn[a][a] = turn[b][b] = std::cos(angle);
    turn[a][b] = std::sin(angle);
    turn[b][a] = -turn[a][b];
    return turn;
}

void UpdateBounds(Scene& scene) {
    bool isEmpty = true;
    for (const Instance& instance : scene.instances) {
        const Primitive& primitive = scene.primitives[static_cast<std::size_t>(instance.primitive)];
        for (std::uint32_t i = 0; i < primitive.indexCount; ++i) {
            const Vertex& vertex = scene.vertices[scene.indices[primitive.firstIndex + i]];
            const glm::vec3 p(instance.toWorld * glm::vec4(vertex.position, 1.0f));
            scene.bounds.low = isEmpty ? p : glm::min(scene.bounds.low, p);
            scene.bounds.high = isEmpty ? p : glm::max(scene.bounds.high, p);
            isEmpty = false;
        }
    }
}

} // namespace openntc::renderer
