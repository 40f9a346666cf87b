// SPDX-License-Identifier: MIT
#include "renderer/scene/ViewCamera.h"

#include "renderer/scene/Cameras.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace openntc::renderer {

namespace {

constexpr float kMostElevation = 1.5533430f; // 89 degrees

} // namespace

ViewCamera::ViewCamera(const Bounds& bounds)
    : bounds_(bounds), radius_(std::max(0.5f * glm::length(bounds.high - bounds.low), 1e-6f)) {}

void ViewCamera::SetOrbit(float azimuth, float elevation, float distance) {
    isOrbit_ = true;
    azimuth_ = azimuth;
    elevation_ = std::clamp(elevation, -kMostElevation, kMostElevation);
    distance_ = std::clamp(distance, 0.01f, 100.0f);
}

void ViewCamera::SetFirstPerson(const Camera& camera) {
    isOrbit_ = false;
    camera_ = camera;
    const glm::vec3 back(camera.toWorld[2]);
    azimuth_ = std::atan2(back.x, back.z);
    elevation_ = std::asin(std::clamp(back.y, -1.0f, 1.0f));
}

bool ViewCamera::Move(const ViewMotion& motion) {
    if (motion == ViewMotion())
        return false;
    azimuth_ -= motion.turn.x;
    elevation_ = std::clamp(elevation_ - motion.turn.y, -kMostElevation, kMostElevation);
    const glm::mat3 turned(MakeOrbitCamera(bounds_, azimuth_, elevation_, distance_).toWorld);
    const glm::vec3 step =
        radius_ * (turned * glm::vec3(motion.step.x, motion.step.y, isOrbit_ ? 0.0f : -motion.step.z));
    if (isOrbit_) {
        distance_ = std::clamp(distance_ * std::exp2(-motion.zoom), 0.01f, 100.0f);
        bounds_.low += step;
        bounds_.high += step;
        return true;
    }
    const glm::vec3 place = glm::vec3(camera_.toWorld[3]) + step;
    camera_.toWorld = glm::mat4(turned);
    camera_.toWorld[3] = glm::vec4(place, 1.0f);
    return true;
}

Camera ViewCamera::Get() const {
    return isOrbit_ ? MakeOrbitCamera(bounds_, azimuth_, elevation_, distance_) : camera_;
}

} // namespace openntc::renderer
