// SPDX-License-Identifier: MIT
// glTF geometry: every type of number, sparse and strided accessors, triangle lists, strips and fans, and
// what hostile files say of them.
#include "TestModel.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

const std::vector<float> kCorners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};

std::string MeshNode(const std::string& primitive) {
    return R"("meshes":[{"primitives":[)" + primitive +
           R"(]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}])";
}

std::string Attribute(const char* name, int accessor) {
    return std::string("\"") + name + "\":" + std::to_string(accessor);
}

} // namespace

TEST_CASE("renderer models: integers of every type, normalised and not") {
    ModelData data;
    // Positions of KHR_mesh_quantization, with a stride; every other attribute in another type.
    const int position =
        data.AddAccessor(data.AddView(std::vector<std::int16_t>{0, 0, 0, -32767, 32767, 0, 5, 6, 7}, 3, 2),
                         5122, "VEC3", 3, ",\"normalized\":true");
    const int normal =
        data.AddAccessor(data.AddView(std::vector<std::int8_t>{0, 0, 127, -128, 0, 0, 0, 127, 0}, 3, 1), 5120,
                         "VEC3", 3, ",\"normalized\":true");
    const int uv0 = data.AddAccessor(data.AddView(std::vector<std::uint8_t>{0, 255, 51, 0, 0, 0}, 2, 2), 5121,
                                     "VEC2", 3, ",\"normalized\":true");
    const int uv1 =
        data.AddAccessor(data.AddView(std::vector<std::uint16_t>{0, 65535, 3, 4, 5, 6}), 5123, "VEC2", 3);
    const int color =
        data.AddAccessor(data.AddView(std::vector<std::uint16_t>{65535, 0, 13107, 1, 2, 3, 4, 5, 6}, 3, 2),
                         5123, "VEC3", 3, ",\"normalized\":true");
    const Scene scene = LoadModel(data.MakeGlb(
        R"("extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"],)" +
        MeshNode(R"({"attributes":{)" + Attribute("POSITION", position) + "," + Attribute("NORMAL", normal) +
                 "," + Attribute("TEXCOORD_0", uv0) + "," + Attribute("TEXCOORD_1", uv1) + "," +
                 Attribute("COLOR_0", color) + "}}")));
    REQUIRE(scene.vertices.size() == 3);
    const Vertex &a = scene.vertices[0], &b = scene.vertices[1];
    CHECK(b.position == glm::vec3(-1, 1, 0));
    CHECK(a.normal == glm::vec3(0, 0, 1));
    CHECK(b.normal == glm::vec3(-1, 0, 0)); // -128 is -1 too
    CHECK(a.uv[0] == glm::vec2(0, 1));
    CHECK(b.uv[0].x == 0.2f);
    CHECK(a.uv[1] == glm::vec2(0, 65535));
    CHECK(a.color == glm::vec4(1, 0, 0.2f, 1));
    CHECK(scene.primitives[0].hasNormals);
    CHECK(!scene.primitives[0].hasTangents);
    CHECK(scene.bounds.low == glm::vec3(-1, 0, 0));
    CHECK(scene.primitives[0].material == 0);
    CHECK(scene.materials[0].name == "default");
}

TEST_CASE("renderer models: sparse accessors replace zeros and stored numbers") {
    ModelData data;
    const int values = data.AddView(std::vector<float>{7, 8, 9, -1, -2, -3});
    const int places = data.AddView(std::vector<std::uint8_t>{1, 3});
    const std::string sparse =
        ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":" + std::to_string(places) +
        ",\"componentType\":5121},\"values\":{\"bufferView\":" + std::to_string(values) + "}}";
    const int zeros = data.AddAccessor(-1, 5126, "VEC3", 4, sparse);
    const int stored = data.AddAccessor(data.AddView(kCorners), 5126, "VEC3", 4, sparse);
    const auto load = [&](int accessor) {
        return LoadModel(
            data.MakeGlb(MeshNode("{\"mode\":5,\"attributes\":{" + Attribute("POSITION", accessor) + "}}")));
    };
    const Scene first = load(zeros), second = load(stored);
    CHECK(first.vertices[0].position == glm::vec3(0));
    CHECK(first.vertices[1].position == glm::vec3(7, 8, 9));
    CHECK(first.vertices[3].position == glm::vec3(-1, -2, -3));
    CHECK(second.vertices[2].position == glm::vec3(0, 1, 0));
    CHECK(second.vertices[3].position == glm::vec3(-1, -2, -3));
}

TEST_CASE("renderer models: lists, strips and fans, with indices of every width and none") {
    ModelData data;
    const int position = data.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 2, 0}, 3);
    const int u8 = data.AddAccessor(data.AddView(std::vector<std::uint8_t>{0, 1, 2, 3}), 5121, "SCALAR", 4);
    const int u16 =
        data.AddAccessor(data.AddView(std::vector<std::uint16_t>{4, 1, 2, 2, 3}), 5123, "SCALAR", 5);
    const int u32 =
        data.AddAccessor(data.AddView(std::vector<std::uint32_t>{2, 1, 0, 3, 1}), 5125, "SCALAR", 5);
    const auto load = [&](const std::string& more) {
        const Scene scene = LoadModel(
            data.MakeGlb(MeshNode("{\"attributes\":{" + Attribute("POSITION", position) + "}" + more + "}")));
        return scene.indices;
    };
    const auto index = [](int accessor) { return ",\"indices\":" + std::to_string(accessor); };
    using Indices = std::vector<std::uint32_t>;
    CHECK(load("") == Indices{0, 1, 2});         // two vertices are left over
    CHECK(load(index(u32)) == Indices{2, 1, 0}); // and so here
    CHECK(load(",\"mode\":5" + index(u8)) == Indices{0, 1, 2, 1, 3, 2});
    CHECK(load(",\"mode\":6" + index(u8)) == Indices{1, 2, 0, 2, 3, 0});
    CHECK(load(",\"mode\":5" + index(u16)) == Indices{4, 1, 2}); // lines between strips are left out
    CHECK(load(",\"mode\":5") == Indices{0, 1, 2, 1, 3, 2, 2, 3, 4});
    const Scene lines = LoadModel(
        data.MakeGlb(MeshNode("{\"mode\":1,\"attributes\":{" + Attribute("POSITION", position) + "}}")));
    CHECK(lines.primitives.empty());
    REQUIRE(lines.warnings.size() == 2);
    CHECK(lines.warnings[0] == "meshes[0].primitives[0].mode: points and lines are not drawn");
}

TEST_CASE("renderer models: a mesh that two nodes draw is stored once") {
    ModelData data;
    const int position = data.AddFloats(kCorners, 3);
    const std::string mesh = R"("meshes":[{"primitives":[{"attributes":{)" + Attribute("POSITION", position) +
                             R"(}}]}],"nodes":[{"mesh":0},{"mesh":0,"translation":[10,0,0]}])";
    const Scene scene = LoadModel(data.MakeGlb(mesh));
    CHECK(scene.vertices.size() == 4);
    CHECK(scene.primitives.size() == 1);
    REQUIRE(scene.instances.size() == 2);
    CHECK(scene.instances[1].toWorld[3] == glm::vec4(10, 0, 0, 1));
    CHECK(scene.bounds.high == glm::vec3(11, 1, 0));
    CHECK(scene.primitives[0].center ==
          glm::vec3(0.5f, 0.5f, 0)); // only what the triangle uses: vertices 0 to 2
}

TEST_CASE("renderer models: hostile geometry ends in a line that names field, value and limit") {
    struct Case {
        std::string error;
        std::string primitive;
    };
    ModelData data;
    const int position = data.AddFloats(kCorners, 3);
    const int view = data.AddView(std::vector<std::uint8_t>{0, 1, 9, 2, 1, 0, 0, 0});
    const int nan = data.AddFloats({0, 0, 0, 1, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 0}, 3);
    const auto accessor = [&](int type, const char* shape, std::size_t count, const std::string& more = "") {
        return std::to_string(data.AddAccessor(view, type, shape, count, more));
    };
    const std::string p = std::to_string(position);
    const auto at = [](const std::string& index, const std::string& text) {
        return "accessors[" + index + "]" + text;
    };
    std::vector<Case> cases;
    const auto indices = [&](const std::string& index, const std::string& text) {
        cases.push_back(
            {at(index, text), "{\"attributes\":{\"POSITION\":" + p + "},\"indices\":" + index + "}"});
    };
    const auto attribute = [&](const char* name, const std::string& index, const std::string& text) {
        cases.push_back({text, "{\"attributes\":{\"POSITION\":" + p + ",\"" + name + "\":" + index + "}}"});
    };
    indices(accessor(5121, "SCALAR", 3), ": index 9: there are 4 vertices");
    indices(accessor(5126, "SCALAR", 2), ".componentType: 5126: indices are 5121, 5123 or 5125");
    indices(accessor(5121, "VEC2", 2), ".type: indices are SCALAR");
    std::string bad = accessor(5125, "SCALAR", 3);
    indices(bad, ".count: 3 elements of 4 bytes, 4 apart, at 0: the view has 8 bytes");
    bad = accessor(5121, "SCALAR", 4, ",\"byteOffset\":5");
    indices(bad, ".count: 4 elements of 1 bytes, 1 apart, at 5: the view has 8 bytes");
    bad = accessor(5121, "SCALAR", 4, ",\"byteOffset\":9");
    indices(bad, ".byteOffset: 9: at most 8");
    bad = accessor(5121, "SCALAR", 0);
    indices(bad, ".count: 0: at least 1");
    bad = accessor(5121, "SCALAR", 4000000000);
    indices(bad, ".count: 4000000000: at most " + std::to_string(kMaxIndices));
    bad = accessor(5124, "SCALAR", 1);
    indices(bad, ".componentType: 5124: no such type");
    bad = accessor(5121, "MAT4", 1);
    indices(bad, ".type: MAT4: SCALAR, VEC2, VEC3 or VEC4 is needed");
    bad = accessor(5121, "SCALAR", 1, ",\"normalized\":1");
    indices(bad, ".normalized: must be true or false");
    bad = accessor(5121, "SCALAR", 3, ",\"sparse\":{\"count\":4}");
    indices(bad, ".sparse.count: 4: at most 3");
    const std::string values = ",\"values\":{\"bufferView\":" + std::to_string(view) + "}}";
    bad = accessor(5121, "SCALAR", 3,
                   ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":" + std::to_string(view) +
                       ",\"byteOffset\":3,\"componentType\":5121}" + values);
    indices(bad, ".sparse.indices: 1: must rise, and be below 3");
    bad = accessor(5121, "SCALAR", 3,
                   ",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":" + std::to_string(view) +
                       ",\"byteOffset\":2,\"componentType\":5121}" + values);
    indices(bad, ".sparse.indices: 9: must rise, and be below 3");
    bad = accessor(5121, "VEC3", 2);
    attribute("NORMAL", bad, "meshes[0].primitives[0].attributes.NORMAL: 2 elements: POSITION has 4");
    bad = accessor(5121, "VEC2", 4);
    attribute("NORMAL", bad,
              at(bad, ".type: 2 components: meshes[0].primitives[0].attributes.NORMAL has 3 to 3"));
    attribute("NORMAL", "999", "meshes[0].primitives[0].attributes.NORMAL: must be an index below the ");
    cases.push_back({at(std::to_string(nan), ": element 1 is not finite"),
                     "{\"attributes\":{\"POSITION\":" + std::to_string(nan) + "}}"});
    cases.push_back(
        {at(std::to_string(nan + 1), ".type: 1 components"), "{\"attributes\":{\"POSITION\":2}}"});
    cases.back().error =
        "accessors[2].type: 1 components: meshes[0].primitives[0].attributes.POSITION has 3 to 3";
    cases.push_back({"meshes[0].primitives[0].mode: 7: 0 to 6", "{\"mode\":7,\"attributes\":{}}"});
    cases.push_back({"meshes[0].primitives[0]: must be an object", "3"});
    // Zeros that no byte of the file stands for, many times over.
    const std::string large = std::to_string(data.AddAccessor(-1, 5126, "VEC3", kMaxVertices + 1));
    cases.push_back(
        {"meshes[0].primitives[0].attributes.POSITION: 8388609 vertices: with 0 before it, more than 8388608",
         "{\"attributes\":{\"POSITION\":" + large + "}}"});
    for (const Case& hostile : cases) {
        const std::string error = GetModelError(data.MakeGlb(MeshNode(hostile.primitive)));
        CHECK_MESSAGE(error.compare(0, hostile.error.size(), hostile.error) == 0,
                      error << " | " << hostile.error);
    }
    // Every prefix of a good file is an error or a model, never a crash.
    const std::string good = data.MakeGlb(MeshNode("{\"attributes\":{\"POSITION\":" + p + "}}"));
    REQUIRE(GetModelError(good).empty());
    for (std::size_t size = 0; size < good.size(); size += 7)
        CHECK(!GetModelError(good.substr(0, size)).empty());
}
