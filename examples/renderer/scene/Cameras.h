// SPDX-License-Identifier: MIT
// Cameras as matrices for Vulkan: y down, depth 1 at the near plane and 0 far away.
#pragma once

#include "renderer/scene/Scene.h"

namespace openntc::renderer {

/// World to the camera's space: it looks along -Z, +Y up.
glm::mat4 MakeView(const Camera& camera);

/// The camera's space to clip space, for a viewport of width / height = `viewportAspect` (> 0). Where a
/// camera has an aspect of its own, the picture is neither cropped nor stretched: wider viewports keep yfov,
/// narrower ones keep the horizontal field of view.
glm::mat4 MakeProjection(const Camera& camera, float viewportAspect);

/// World to clip space.
glm::mat4 MakeViewProjection(const Camera& camera, float viewportAspect);

/// The same, with the picture moved by `jitter` pixels (GetJitter) of a viewport of `size` pixels.
glm::mat4 MakeJitteredViewProjection(const Camera& camera, glm::vec2 size, glm::vec2 jitter);

/// Where inside a pixel frame `frame` samples, relative to its centre, -0.5 ... 0.5: R2 (Roberts 2018);
/// frame 0 is the centre.
glm::vec2 GetJitter(unsigned frame);

/// A camera on a sphere round the middle of `bounds`, from which they fill the picture: azimuth from +Z
/// towards +X, elevation above the horizon, radians; `distance` 1 is the default one, 1.2 radii over
/// sin(yfov / 2).
Camera MakeOrbitCamera(const Bounds& bounds, float azimuth = 0.52359878f, float elevation = 0.26179939f,
                       float distance = 1.0f);

} // namespace openntc::renderer
