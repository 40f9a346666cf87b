// SPDX-License-Identifier: MIT
// Cameras: where points of the specification's section 2 come out.
#include "renderer/scene/Cameras.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>

using namespace openntc::renderer;

namespace {

glm::vec3 ProjectPoint(const glm::mat4& matrix, glm::vec3 point) {
    const glm::vec4 clip = matrix * glm::vec4(point, 1.0f);
    return glm::vec3(clip) / clip.w;
}

void CheckPoint(glm::vec3 value, glm::vec3 expected, float tolerance = 2e-6f) {
    CHECK(std::fabs(value.x - expected.x) <= tolerance);
    CHECK(std::fabs(value.y - expected.y) <= tolerance);
    CHECK(std::fabs(value.z - expected.z) <= tolerance);
}

} // namespace

TEST_CASE("renderer cameras: perspective, reversed depth, y down") {
    Camera camera;
    camera.yfov = 1.0f;
    camera.znear = 0.5f;
    const float t = std::tan(0.5f);
    const glm::mat4 infinite = MakeViewProjection(camera, 2.0f);
    CheckPoint(ProjectPoint(infinite, {0, 0, -0.5f}), {0, 0, 1});
    CheckPoint(ProjectPoint(infinite, {4 * t * 2, 4 * t, -4}), {1, -1, 0.125f});
    CheckPoint(ProjectPoint(infinite, {0, 0, -1e6f}), {0, 0, 5e-7f});
    camera.zfar = 8.0f;
    const glm::mat4 finite = MakeViewProjection(camera, 2.0f);
    CheckPoint(ProjectPoint(finite, {0, 0, -0.5f}), {0, 0, 1});
    CheckPoint(ProjectPoint(finite, {-8 * t * 2, 0, -8}), {-1, 0, 0});
    // (n·Z + n·f) / (f - n) / -Z at Z = -2.
    CheckPoint(ProjectPoint(finite, {0, 0, -2}), {0, 0, 3.0f / 7.5f / 2});
}

TEST_CASE("renderer cameras: a picture of another aspect is neither cropped nor stretched") {
    Camera camera;
    camera.yfov = 1.0f;
    camera.aspect = 1.5f;
    const float t = std::tan(0.5f);
    // Wider: what filled the height still does. Narrower: what filled the width still does.
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 3.0f), {1.5f * t, t, -1}), {0.5f, -1, 0.01f});
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 0.75f), {1.5f * t, t, -1}), {1, -0.5f, 0.01f});
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 1.5f), {1.5f * t, t, -1}), {1, -1, 0.01f});
    camera.perspective = false;
    camera.xmag = 3;
    camera.ymag = 2;
    camera.znear = 1;
    camera.zfar = 5;
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 1.5f), {3, 2, -1}), {1, -1, 1});
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 1.5f), {3, 2, -5}), {1, -1, 0});
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 3.0f), {3, 2, -3}), {0.5f, -1, 0.5f});
    CheckPoint(ProjectPoint(MakeViewProjection(camera, 0.75f), {3, 2, -3}), {1, -0.5f, 0.5f});
}

TEST_CASE("renderer cameras: the view is the inverse of where the camera stands") {
    Camera camera;
    const float c = std::cos(0.4f), s = std::sin(0.4f);
    camera.toWorld = glm::mat4(glm::vec4(c, 0, -s, 0), glm::vec4(0, 1, 0, 0), glm::vec4(s, 0, c, 0),
                               glm::vec4(1, 2, 3, 1));
    const glm::mat4 same = MakeView(camera) * camera.toWorld;
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 4; ++k)
            CHECK(std::fabs(same[i][k] - (i == k ? 1.0f : 0.0f)) <= 1e-6f);
    }
}

TEST_CASE("renderer cameras: the orbit's sees all of the bounds from where it was asked to stand") {
    const Bounds bounds{{-1, 2, -3}, {5, 3, 1}};
    const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
    const Camera camera = MakeOrbitCamera(bounds);
    const glm::mat4 matrix = MakeViewProjection(camera, 1.0f);
    CHECK(std::fabs(ProjectPoint(matrix, middle).x) <= 1e-5f);
    CHECK(std::fabs(ProjectPoint(matrix, middle).y) <= 1e-5f);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 point((corner & 1 ? bounds.high : bounds.low).x,
                              (corner & 2 ? bounds.high : bounds.low).y,
                              (corner & 4 ? bounds.high : bounds.low).z);
        const glm::vec3 seen = ProjectPoint(matrix, point);
        CHECK((std::fabs(seen.x) < 1 && std::fabs(seen.y) < 1 && seen.z > 0 && seen.z < 1));
    }
    const glm::vec3 eye(camera.toWorld[3]);
    const float radius = 0.5f * glm::length(bounds.high - bounds.low);
    CHECK(std::fabs(glm::length(eye - middle) - 1.2f * radius / std::sin(0.35f)) <= 1e-4f);
    const glm::vec3 back = glm::normalize(eye - middle);
    CHECK(std::fabs(back.y - std::sin(0.26179939f)) <= 1e-6f);           // 15° up
    CHECK(std::fabs(std::atan2(back.x, back.z) - 0.52359878f) <= 1e-6f); // 30° to the right
    CHECK(std::fabs(glm::determinant(camera.toWorld) - 1.0f) <= 1e-5f);
    const Camera point = MakeOrbitCamera({});
    CHECK(std::isfinite(MakeViewProjection(point, 1.0f)[3].x));
}

TEST_CASE("renderer cameras: jitter is centred, even, and moves pictures by what it says") {
    CHECK(GetJitter(0) == glm::vec2(0));
    glm::vec2 sum(0);
    int quadrants[4] = {};
    constexpr int kFrames = 256;
    for (unsigned frame = 0; frame < kFrames; ++frame) {
        const glm::vec2 jitter = GetJitter(frame);
        CHECK((jitter.x >= -0.5f && jitter.x < 0.5f && jitter.y >= -0.5f && jitter.y < 0.5f));
        sum += jitter;
        ++quadrants[(jitter.x < 0 ? 0 : 1) + (jitter.y < 0 ? 0 : 2)];
    }
    // An additive sequence's discrepancy is some log(n) / n; hashed numbers would miss by 1 / sqrt(n).
    CHECK(std::fabs(sum.x) / kFrames <= 0.01f);
    CHECK(std::fabs(sum.y) / kFrames <= 0.01f);
    for (const int count : quadrants)
        CHECK(std::abs(count - kFrames / 4) <= 4);
    const Camera camera;
    const glm::vec3 straight = ProjectPoint(MakeViewProjection(camera, 2.0f), {0.1f, 0.2f, -3});
    const glm::vec3 moved =
        ProjectPoint(MakeJitteredViewProjection(camera, {200, 100}, {0.25f, -0.5f}), {0.1f, 0.2f, -3});
    CheckPoint(moved, {straight.x - 0.25f * 2 / 200, straight.y + 0.5f * 2 / 100, straight.z});
}
