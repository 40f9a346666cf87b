// SPDX-License-Identifier: MIT
// A camera that people move: round the middle of a scene, or through it.
#pragma once

#include "renderer/scene/Scene.h"

namespace openntc::renderer {

/// What moves a camera. Angles in radians; distances in radii of the scene's bounds.
struct ViewMotion {
    glm::vec2 turn{0.0f}; ///< of the direction of view, to the right and up
    glm::vec3 step{0.0f}; ///< to the right, up, forward as the camera sees it
    float zoom = 0.0f;    ///< of the orbit: so often twice as near

    bool operator==(const ViewMotion&) const = default;
};

class ViewCamera {
public:
    explicit ViewCamera(const Bounds& bounds);

    /// Angles as of MakeOrbitCamera; elevation is held within 89 degrees.
    void SetOrbit(float azimuth, float elevation, float distance);
    /// From there through the scene; what leans to a side is put upright by the first motion.
    void SetFirstPerson(const Camera& camera);
    bool IsOrbit() const { return isOrbit_; }

    /// Of the orbit `step` moves the middle, to the right and up. False: nothing has moved.
    bool Move(const ViewMotion& motion);
    Camera Get() const;

private:
    Bounds bounds_;
    float radius_;
    bool isOrbit_ = true;
    float azimuth_ = 0.0f, elevation_ = 0.0f, distance_ = 1.0f;
    Camera camera_; // of first person
};

} // namespace openntc::renderer
