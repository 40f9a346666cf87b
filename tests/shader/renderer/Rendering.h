// SPDX-License-Identifier: MIT
// Small pictures on the device under test.
#pragma once

#include "../TestDevice.h"

#include "renderer/gpu/Renderer.h"

#include <cstdint>
#include <vector>

namespace openntc_tests {

using Picture = std::vector<std::uint8_t>; ///< RGBA, rows from the top

/// 40 x 28 pixels, bilinear, without block compression, texels counted.
openntc::renderer::RenderOptions MakeSmallOptions(openntc::renderer::Mode mode);

/// Of all tests of the program.
openntc::renderer::ShaderCache& GetShaders();

struct Result {
    Picture picture;
    openntc::renderer::TexelCounts counts;
    std::vector<openntc::renderer::MaterialPlan> plans;
};

/// One frame by the scene's first camera.
Result Render(openntc::harness::Context& context, openntc::renderer::Scene scene,
              const openntc::renderer::RenderOptions& options);

/// The same, for each of the cameras.
std::vector<Picture> RenderAll(openntc::harness::Context& context, openntc::renderer::Scene scene,
                               const openntc::renderer::RenderOptions& options,
                               const std::vector<openntc::renderer::Camera>& cameras);

/// Steps of 255; of pictures of one size.
int GetLargestDifference(const Picture& a, const Picture& b);

} // namespace openntc_tests
