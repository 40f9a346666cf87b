// SPDX-License-Identifier: MIT
// How much of a uniform environment a surface reflects: scale A on f0 and bias B, by roughness and angle.
#pragma once

#include <glm/vec2.hpp>

#include <vector>

namespace openntc::renderer {

/// A and B of one roughness (perceptual, 0 ... 1) and cosine (0 ... 1) as the mean of samples² microfacets.
glm::vec2 IntegrateEnvironment(float roughness, float nDotV, int samples);

/// NTCR_ENVIRONMENT_SIZE rows of as many columns, as NtcrGetEnvironmentTaps (shaders/Lighting.h) reads them.
std::vector<glm::vec2> MakeEnvironmentTable();
/// The same, made once.
const std::vector<glm::vec2>& GetEnvironmentTable();

} // namespace openntc::renderer
