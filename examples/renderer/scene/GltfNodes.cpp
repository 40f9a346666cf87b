// SPDX-License-Identifier: MIT
#include "renderer/scene/GltfNodes.h"

#include "renderer/scene/GltfFields.h"
#include "renderer/scene/GltfScene.h"

#include "Output.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace openntc::renderer {

namespace {

using Value = tool::GltfFile::Value;

glm::mat4 MakeTransform(glm::vec3 translation, glm::vec4 q, glm::vec3 scale) {
    const float length = glm::length(q);
    q = length > 0.0f ? q / length : glm::vec4(0, 0, 0, 1);
    const glm::vec3 x(1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.z * q.w),
                      2 * (q.x * q.z - q.y * q.w));
    const glm::vec3 y(2 * (q.x * q.y - q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z),
                      2 * (q.y * q.z + q.x * q.w));
    const glm::vec3 z(2 * (q.x * q.z + q.y * q.w), 2 * (q.y * q.z - q.x * q.w),
                      1 - 2 * (q.x * q.x + q.y * q.y));
    return glm::mat4(glm::vec4(x * scale.x, 0), glm::vec4(y * scale.y, 0), glm::vec4(z * scale.z, 0),
                     glm::vec4(translation, 1));
}

/// Rotation and translation of a camera's node: axes made perpendicular, scale left out.
glm::mat4 RemoveScale(const glm::mat4& matrix) {
    const auto unit = [](glm::vec3 v, glm::vec3 fallback) {
        const float length = glm::length(v);
        return length > 1e-20f && std::isfinite(length) ? v / length : fallback;
    };
    const glm::vec3 back = unit(glm::vec3(matrix[2]), {0, 0, 1});
    const glm::vec3 right =
        unit(glm::vec3(matrix[0]) - back * glm::dot(back, glm::vec3(matrix[0])),
             std::fabs(back.x) < 0.9f ? glm::normalize(glm::vec3(1, 0, 0) - back * back.x)
                                      : glm::normalize(glm::vec3(0, 0, 1) - back * back.z));
    return glm::mat4(glm::vec4(right, 0), glm::vec4(glm::cross(back, right), 0), glm::vec4(back, 0),
                     matrix[3]);
}

class NodeReader {
public:
    NodeReader(const tool::GltfFile& file, GltfGeometry& geometry, Scene& scene)
        : file_(file), geometry_(geometry), scene_(scene), nodes_(file.FindArray("nodes")) {
        reached_.resize(nodes_ == nullptr ? 0 : nodes_->Size());
    }

    void Read(int sceneIndex) {
        for (const rapidjson::SizeType root : FindRoots(sceneIndex))
            pending_.push_back({root, glm::mat4(1.0f)});
        std::reverse(pending_.begin(), pending_.end()); // a stack: the first node is drawn first
        while (!pending_.empty()) {
            const Pending next = pending_.back();
            pending_.pop_back();
            Visit(next);
        }
    }

private:
    struct Pending {
        rapidjson::SizeType node;
        glm::mat4 parent;
    };

    std::string GetName(rapidjson::SizeType node) const { return tool::Format("nodes[%u]", node); }

    std::vector<rapidjson::SizeType> GetNodes(const Value& parent, const char* name,
                                              const std::string& where) const {
        std::vector<rapidjson::SizeType> nodes;
        const auto member = parent.FindMember(name);
        if (member == parent.MemberEnd())
            return nodes;
        if (!member->value.IsArray())
            file_.Fail(where + "." + name, "must be an array");
        for (const Value& index : member->value.GetArray()) {
            if (!index.IsUint() || index.GetUint() >= reached_.size())
                file_.Fail(where + "." + name,
                           tool::Format("must be indices below the %zu nodes", reached_.size()));
            nodes.push_back(index.GetUint());
        }
        return nodes;
    }

    std::vector<rapidjson::SizeType> FindRoots(int sceneIndex) {
        const Value* scenes = file_.FindArray("scenes");
        const int count = scenes == nullptr ? 0 : static_cast<int>(scenes->Size());
        int index = sceneIndex;
        if (index < 0)
            index = std::max(ReadIndex(file_, file_.GetRoot(), "scene", "scenes", "glTF"), 0);
        if (sceneIndex >= count && sceneIndex >= 0)
            file_.Fail("scenes", tool::Format("%d: there are %d", sceneIndex, count));
        if (count > 0) {
            const std::string at = tool::Format("scenes[%d]", index);
            const Value& value = (*scenes)[static_cast<rapidjson::SizeType>(index)];
            if (!value.IsObject())
                file_.Fail(at, "must be an object");
            return GetNodes(value, "nodes", at);
        }
        std::vector<bool> isChild(reached_.size());
        for (rapidjson::SizeType i = 0; i < isChild.size(); ++i) {
            for (const rapidjson::SizeType child : GetNodes(GetNode(i), "children", GetName(i)))
                isChild[child] = true;
        }
        std::vector<rapidjson::SizeType> roots;
        for (rapidjson::SizeType i = 0; i < isChild.size(); ++i) {
            if (!isChild[i])
                roots.push_back(i);
        }
        return roots;
    }

    const Value& GetNode(rapidjson::SizeType node) const {
        if (!(*nodes_)[node].IsObject())
            file_.Fail(GetName(node), "must be an object");
        return (*nodes_)[node];
    }

    glm::mat4 ReadTransform(const Value& node, const std::string& where) const {
        float numbers[16];
        if (ReadFloats(file_, node, "matrix", where, numbers)) {
            glm::mat4 matrix;
            for (int i = 0; i < 16; ++i)
                matrix[i / 4][i % 4] = numbers[i];
            if (numbers[3] != 0 || numbers[7] != 0 || numbers[11] != 0 || numbers[15] != 1)
                file_.Fail(where + ".matrix", "the last row must be 0 0 0 1");
            return matrix;
        }
        glm::vec3 translation(0.0f), scale(1.0f);
        glm::vec4 rotation(0, 0, 0, 1);
        ReadFloats(file_, node, "translation", where, {&translation.x, 3});
        ReadFloats(file_, node, "rotation", where, {&rotation.x, 4});
        ReadFloats(file_, node, "scale", where, {&scale.x, 3});
        return MakeTransform(translation, rotation, scale);
    }

    void Visit(const Pending& pending) {
        const std::string where = GetName(pending.node);
        if (reached_[pending.node])
            file_.Fail(where, "reached twice: nodes are trees");
        reached_[pending.node] = true;
        const Value& node = GetNode(pending.node);
        const glm::mat4 toWorld = pending.parent * ReadTransform(node, where);
        for (int i = 0; i < 16; ++i) {
            if (!std::isfinite(toWorld[i / 4][i % 4]))
                file_.Fail(where, "its transform is too large for binary32");
        }
        if (const int mesh = ReadIndex(file_, node, "mesh", "meshes", where); mesh >= 0)
            AddInstances(mesh, toWorld, where);
        if (const int camera = ReadIndex(file_, node, "camera", "cameras", where); camera >= 0)
            AddCamera(camera, toWorld, file_.GetString(node, "name", where));
        const std::vector<rapidjson::SizeType> children = GetNodes(node, "children", where);
        for (auto child = children.rbegin(); child != children.rend(); ++child)
            pending_.push_back({*child, toWorld});
    }

    void AddInstances(int mesh, const glm::mat4& toWorld, const std::string& where) {
        const PrimitiveRange range = geometry_.ReadMesh(mesh);
        for (int i = range.first; i < range.first + range.count; ++i) {
            if (scene_.instances.size() >= kMaxInstances)
                file_.Fail(where, tool::Format("more than %zu primitives are drawn", kMaxInstances));
            scene_.instances.push_back({i, toWorld, glm::determinant(glm::mat3(toWorld)) < 0.0f});
            Extend(geometry_.GetBounds(i), toWorld, where);
        }
    }
    void Extend(const Bounds& own, const glm::mat4& toWorld, const std::string& where) {
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec3 point((corner & 1) != 0 ? own.high.x : own.low.x,
                                  (corner & 2) != 0 ? own.high.y : own.low.y,
                                  (corner & 4) != 0 ? own.high.z : own.low.z);
            const glm::vec3 p(toWorld * glm::vec4(point, 1.0f));
            constexpr float kLargest = 1e18f; // squares of distances stay finite
            if (!(std::fabs(p.x) <= kLargest && std::fabs(p.y) <= kLargest && std::fabs(p.z) <= kLargest))
                file_.Fail(where, tool::Format("its mesh reaches beyond %g", static_cast<double>(kLargest)));
            scene_.bounds.low = isEmpty_ ? p : glm::min(scene_.bounds.low, p);
            scene_.bounds.high = isEmpty_ ? p : glm::max(scene_.bounds.high, p);
            isEmpty_ = false;
        }
    }

    void AddCamera(int index, const glm::mat4& toWorld, const std::string& nodeName) {
        const std::string at = tool::Format("cameras[%d]", index);
        const Value& value = (*file_.FindArray("cameras"))[static_cast<rapidjson::SizeType>(index)];
        Camera camera;
        camera.name = file_.GetString(value, "name", at);
        if (camera.name.empty())
            camera.name = nodeName.empty() ? tool::Format("camera%d", index) : nodeName;
        camera.toWorld = RemoveScale(toWorld);
        const std::string type = file_.GetString(value, "type", at);
        constexpr float kLeast = 1e-6f, kMost = 1e12f;
        if (type == "perspective") {
            const Value& lens = file_.GetObject(value, "perspective", at + ".perspective");
            const std::string where = at + ".perspective";
            if (!lens.HasMember("yfov") || !lens.HasMember("znear"))
                file_.Fail(where, "yfov and znear are needed");
            camera.yfov = ReadFloat(file_, lens, "yfov", where, camera.yfov, {1e-3f, 3.14f});
            camera.aspect = ReadFloat(file_, lens, "aspectRatio", where, 0.0f, {kLeast, 1e6f});
            camera.znear = ReadFloat(file_, lens, "znear", where, camera.znear, {kLeast, kMost});
            camera.zfar = ReadFloat(file_, lens, "zfar", where, 0.0f, {camera.znear * 1.0001f, kMost});
        } else if (type == "orthographic") {
            const Value& lens = file_.GetObject(value, "orthographic", at + ".orthographic");
            const std::string where = at + ".orthographic";
            camera.perspective = false;
            for (const char* name : {"xmag", "ymag", "zfar", "znear"}) {
                if (!lens.HasMember(name))
                    file_.Fail(where + "." + name, "missing");
            }
            camera.xmag = std::fabs(ReadFloat(file_, lens, "xmag", where, 1.0f, {-kMost, kMost}));
            camera.ymag = std::fabs(ReadFloat(file_, lens, "ymag", where, 1.0f, {-kMost, kMost}));
            if (camera.xmag < kLeast || camera.ymag < kLeast)
                file_.Fail(where, "xmag and ymag must not be 0");
            camera.znear = ReadFloat(file_, lens, "znear", where, 0.0f, {0.0f, kMost});
            camera.zfar = ReadFloat(file_, lens, "zfar", where, 1.0f, {camera.znear + kLeast, kMost});
        } else {
            file_.Fail(at + ".type", type + ": perspective or orthographic");
        }
        scene_.cameras.push_back(std::move(camera));
    }

    const tool::GltfFile& file_;
    GltfGeometry& geometry_;
    Scene& scene_;
    const Value* nodes_;
    std::vector<bool> reached_;
    std::vector<Pending> pending_;
    bool isEmpty_ = true;
};

} // namespace

void ReadNodes(const tool::GltfFile& file, int sceneIndex, GltfGeometry& geometry, Scene& scene) {
    NodeReader(file, geometry, scene).Read(sceneIndex);
}

} // namespace openntc::renderer
