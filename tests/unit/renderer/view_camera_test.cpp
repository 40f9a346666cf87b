// SPDX-License-Identifier: MIT
// Cameras that people move.
#include "renderer/scene/Cameras.h"
#include "renderer/scene/ViewCamera.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>

#include <cmath>

using namespace openntc::renderer;

namespace {

constexpr float kTolerance = 1e-5f; // sines and cosines of binary32 angles below 4

Bounds MakeBounds() {
    return {{-1.0f, -2.0f, -2.0f}, {3.0f, 2.0f, 2.0f}}; // radius sqrt(4 + 4 + 4)
}

const float kRadius = std::sqrt(12.0f);

glm::vec3 GetForward(const Camera& camera) {
    return -glm::vec3(camera.toWorld[2]);
}

glm::vec3 GetPlace(const Camera& camera) {
    return glm::vec3(camera.toWorld[3]);
}

void CheckNear(glm::vec3 value, glm::vec3 expected) {
    CHECK(glm::length(value - expected) <= kTolerance * (1.0f + glm::length(expected)));
}

} // namespace

TEST_CASE("renderer view: the orbit looks at the middle whatever it does, and never turns over") {
    ViewCamera view(MakeBounds());
    view.SetOrbit(0.0f, 0.0f, 1.0f);
    CheckNear(GetForward(view.Get()), {0, 0, -1});
    CHECK_FALSE(view.Move({}));
    CHECK(view.Move(
        {{0.5f, 0.25f}, {}, 0.0f})); // the view turns to the right and up: the camera goes left and down
    CHECK(GetPlace(view.Get()).x < 1.0f);
    CHECK(GetPlace(view.Get()).y < 0.0f);
    const glm::vec3 middle(1, 0, 0);
    CheckNear(glm::normalize(middle - GetPlace(view.Get())), GetForward(view.Get()));
    const float before = glm::length(middle - GetPlace(view.Get()));
    view.Move({{}, {}, 1.0f}); // twice as near
    CHECK(glm::length(middle - GetPlace(view.Get())) == doctest::Approx(0.5 * before));
    view.Move({{0.0f, 100.0f}, {}, 0.0f});
    CHECK(view.Get().toWorld[1].y > 0.0f); // up is up
    view.SetOrbit(0.0f, 0.0f, 1.0f);
    view.Move({{}, {0.5f, 0.25f, 9.0f}, 0.0f}); // pans; forward is the zoom's
    CheckNear(GetPlace(view.Get()) - GetPlace(MakeOrbitCamera(MakeBounds(), 0.0f, 0.0f, 1.0f)),
              {0.5f * kRadius, 0.25f * kRadius, 0.0f});
}

TEST_CASE("renderer view: first person starts where a camera is, turns and walks as it looks") {
    ViewCamera view(MakeBounds());
    Camera start = MakeOrbitCamera(MakeBounds(), 0.3f, -0.2f, 0.5f);
    start.yfov = 1.1f;
    view.SetFirstPerson(start);
    CHECK_FALSE(view.IsOrbit());
    CHECK(view.Get().toWorld == start.toWorld);
    view.Move({{}, {0, 0, 2}, 0.0f});
    CheckNear(GetPlace(view.Get()), GetPlace(start) + 2.0f * kRadius * GetForward(start));
    CheckNear(GetForward(view.Get()), GetForward(start));
    CHECK(view.Get().yfov == start.yfov);
    const glm::vec3 right(start.toWorld[0]);
    view.Move({{0.1f, 0.0f}, {}, 0.0f});
    CHECK(glm::dot(GetForward(view.Get()), right) > 0.09f);
    view.Move({{0.0f, 0.1f}, {}, 0.0f});
    CHECK(GetForward(view.Get()).y > GetForward(start).y);
}
