// SPDX-License-Identifier: MIT
#include "renderer/scene/Tangents.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace openntc::renderer {

namespace {

struct Face {
    glm::vec3 tangent{0.0f}; ///< gradient of u, unit vector; 0: none
    bool keepsOrientation = true;
    bool isDegenerate = false;
};

/// What corners share whose frames are averaged: position, normal and texture coordinates, bit for bit.
using WeldKey = std::array<float, 8>;

struct WeldHash {
    std::size_t operator()(const WeldKey& key) const {
        std::size_t hash = 0xcbf29ce484222325u;
        for (const float number : key) {
            std::uint32_t bits = 0;
            std::memcpy(&bits, &number, sizeof bits);
            hash = (hash ^ bits) * 0x100000001b3u;
        }
        return hash;
    }
};

class TangentMaker {
public:
    TangentMaker(std::vector<Vertex>& vertices, std::span<std::uint32_t> triangles,
                 const TextureAddress& address)
        : vertices_(vertices), triangles_(triangles), address_(address), groups_(triangles.size()) {
        std::iota(groups_.begin(), groups_.end(), std::size_t{0});
    }

    void Run() {
        Weld();
        MeasureFaces();
        BorrowOrientations();
        JoinGroups();
        Average();
        Assign();
    }

private:
    /// v rises upwards in MikkTSpace's world.
    glm::vec2 GetUv(const Vertex& vertex) const {
        const glm::vec3 uv(vertex.uv[address_.uvSet], 1.0f);
        return {glm::dot(address_.transform.row0, uv), -glm::dot(address_.transform.row1, uv)};
    }
    const Vertex& GetCorner(std::size_t corner) const { return vertices_[triangles_[corner]]; }
    static std::size_t GetNext(std::size_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
    static std::size_t GetPrevious(std::size_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

    void Weld() {
        std::unordered_map<WeldKey, std::uint32_t, WeldHash> known;
        std::vector<std::uint32_t> ids(vertices_.size());
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const Vertex& v = vertices_[i];
            const glm::vec2 uv = v.uv[address_.uvSet];
            const WeldKey key{v.position.x + 0.0f, v.position.y + 0.0f, v.position.z + 0.0f, // -0 becomes 0
                              v.normal.x + 0.0f,   v.normal.y + 0.0f,   v.normal.z + 0.0f,
                              uv.x + 0.0f,         uv.y + 0.0f};
            ids[i] = known.try_emplace(key, static_cast<std::uint32_t>(i)).first->second;
        }
        welded_.resize(triangles_.size());
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            welded_[i] = ids[triangles_[i]];
    }

    void MeasureFaces() {
        faces_.resize(triangles_.size() / 3);
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const Vertex &a = GetCorner(3 * f), &b = GetCorner(3 * f + 1), &c = GetCorner(3 * f + 2);
            const glm::vec2 d1 = GetUv(b) - GetUv(a), d2 = GetUv(c) - GetUv(a);
            const float area = d1.x * d2.y - d1.y * d2.x;
            const glm::vec3 gradient = d2.y * (b.position - a.position) - d1.y * (c.position - a.position);
            const float length = glm::length(gradient);
            Face& face = faces_[f];
            face.keepsOrientation = area > 0.0f;
            face.isDegenerate = !(std::fabs(area) > 0.0f) || !(length > 0.0f) || !std::isfinite(length);
            if (!face.isDegenerate)
                face.tangent = gradient * ((face.keepsOrientation ? 1.0f : -1.0f) / length);
        }
    }

    /// Triangles without a gradient take the side of one that shares a vertex, and so its frame.
    void BorrowOrientations() {
        std::unordered_map<std::uint32_t, bool> orientations;
        for (std::size_t i = 0; i < welded_.size(); ++i) {
            if (!faces_[i / 3].isDegenerate)
                orientations.try_emplace(welded_[i], faces_[i / 3].keepsOrientation);
        }
        for (std::size_t i = 0; i < welded_.size(); ++i) {
            const auto found = orientations.find(welded_[i]);
            if (faces_[i / 3].isDegenerate && found != orientations.end())
                faces_[i / 3].keepsOrientation = found->second;
        }
    }

    std::size_t FindGroup(std::size_t corner) {
        while (groups_[corner] != corner)
            corner = groups_[corner] = groups_[groups_[corner]];
        return corner;
    }
    void Join(std::size_t a, std::size_t b) {
        const std::size_t first = FindGroup(a), second = FindGroup(b);
        groups_[std::max(first, second)] = std::min(first, second);
    }

    /// Corners of one vertex whose triangles share an edge and an orientation belong together. Degenerate
    /// triangles join what they touch.
    void JoinGroups() {
        struct Edge {
            std::uint32_t low, high;
            std::size_t corner; ///< where it starts
        };
        std::vector<Edge> edges;
        edges.reserve(triangles_.size());
        for (std::size_t i = 0; i < welded_.size(); ++i) {
            const std::uint32_t from = welded_[i], to = welded_[GetNext(i)];
            edges.push_back({std::min(from, to), std::max(from, to), i});
        }
        std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
            return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
        });
        for (std::size_t i = 1; i < edges.size(); ++i) {
            const Edge &a = edges[i - 1], &b = edges[i];
            if (a.low != b.low || a.high != b.high ||
                faces_[a.corner / 3].keepsOrientation != faces_[b.corner / 3].keepsOrientation)
                continue;
            const bool isOpposite = welded_[a.corner] != welded_[b.corner];
            Join(a.corner, isOpposite ? GetNext(b.corner) : b.corner);
            Join(GetNext(a.corner), isOpposite ? b.corner : GetNext(b.corner));
        }
        std::map<std::pair<std::uint32_t, bool>, std::size_t> whole; // a corner of a triangle with a gradient
        for (std::size_t i = 0; i < welded_.size(); ++i) {
            if (!faces_[i / 3].isDegenerate)
                whole.try_emplace({welded_[i], faces_[i / 3].keepsOrientation}, i);
        }
        for (std::size_t i = 0; i < welded_.size(); ++i) {
            const auto found = whole.find({welded_[i], faces_[i / 3].keepsOrientation});
            if (faces_[i / 3].isDegenerate && found != whole.end())
                Join(found->second, i);
        }
    }

    /// Gradients of a group, brought into the plane of its normal, weighted by the angles of the corners
    /// there.
    void Average() {
        sums_.assign(triangles_.size(), glm::vec3(0.0f));
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            const Face& face = faces_[i / 3];
            if (face.isDegenerate)
                continue;
            const Vertex& vertex = GetCorner(i);
            const auto flatten = [&](glm::vec3 v) {
                v -= vertex.normal * glm::dot(vertex.normal, v);
                const float length = glm::length(v);
                return length > 0.0f ? v / length : glm::vec3(0.0f);
            };
            const glm::vec3 next = flatten(GetCorner(GetNext(i)).position - vertex.position);
            const glm::vec3 previous = flatten(GetCorner(GetPrevious(i)).position - vertex.position);
            const float angle = std::acos(std::clamp(glm::dot(next, previous), -1.0f, 1.0f));
            sums_[FindGroup(i)] += flatten(face.tangent) * angle;
        }
    }

    static glm::vec3 MakePerpendicular(glm::vec3 normal) {
        const glm::vec3 axis = std::fabs(normal.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
        const glm::vec3 tangent = axis - normal * glm::dot(normal, axis);
        return tangent / std::max(glm::length(tangent), 1e-20f);
    }

    void Assign() {
        // The vertices that a vertex of the file became: one for every group that uses it.
        std::map<std::pair<std::uint32_t, std::size_t>, std::uint32_t> made;
        std::vector<bool> isTaken(vertices_.size());
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            const std::uint32_t own = triangles_[i];
            const std::size_t group = FindGroup(i);
            const auto [entry, isNew] = made.try_emplace({own, group}, own);
            if (isNew && isTaken[own]) {
                entry->second = static_cast<std::uint32_t>(vertices_.size());
                vertices_.push_back(vertices_[own]);
            }
            if (isNew) {
                isTaken[own] = true;
                Vertex& vertex = vertices_[entry->second];
                const float length = glm::length(sums_[group]);
                vertex.tangent =
                    glm::vec4(length > 0.0f ? sums_[group] / length : MakePerpendicular(vertex.normal),
                              faces_[i / 3].keepsOrientation ? 1.0f : -1.0f);
            }
            triangles_[i] = entry->second;
        }
    }

    std::vector<Vertex>& vertices_;
    std::span<std::uint32_t> triangles_;
    const TextureAddress& address_;
    std::vector<std::uint32_t> welded_; ///< per corner
    std::vector<Face> faces_;
    std::vector<std::size_t> groups_; ///< per corner: another one of its group, or itself
    std::vector<glm::vec3> sums_;     ///< at the first corner of a group
};

} // namespace

void MakeTangents(std::vector<Vertex>& vertices, std::span<std::uint32_t> triangles,
                  const TextureAddress& address) {
    TangentMaker(vertices, triangles, address).Run();
}

} // namespace openntc::renderer
