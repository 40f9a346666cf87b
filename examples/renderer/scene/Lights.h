// SPDX-License-Identifier: MIT
// The light of every scene.
#pragma once

#include "renderer/shaders/Lighting.h"

#include <glm/geometric.hpp>

namespace openntc::renderer {

/// A light sky over a darker ground, and a sun from the upper left behind the eye of the default camera.
inline shader::NtcrLights MakeLights() {
    const glm::vec3 zenith(0.45f, 0.60f, 0.90f), horizon(0.80f, 0.85f, 0.90f), ground(0.25f, 0.22f, 0.20f);
    shader::NtcrLights lights;
    lights.sunDirection = glm::vec4(glm::normalize(glm::vec3(-0.3f, 0.8f, 0.6f)), 0.0f);
    lights.sunIrradiance = glm::vec4(2.2f, 2.1f, 1.9f, 0.0f);
    lights.skyA = glm::vec4(horizon, 0.0f);
    lights.skyB = glm::vec4(0.5f * (zenith - ground), 0.0f);
    lights.skyC = glm::vec4(0.5f * (zenith + ground) - horizon, 0.0f);
    return lights;
}

} // namespace openntc::renderer
