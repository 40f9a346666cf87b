// SPDX-License-Identifier: MIT
#include "shader/renderer/Rendering.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace openntc_tests {

using namespace openntc;
using namespace openntc::renderer;

RenderOptions MakeSmallOptions(Mode mode) {
    RenderOptions options;
    options.mode = mode;
    options.filter = TextureFilter::Bilinear;
    options.keepsTexels = true;
    options.counts = true;
    options.width = 40;
    options.height = 28;
    return options;
}

ShaderCache& GetShaders() {
    static ShaderCache shaders(OPENNTC_RENDERER_SOURCES);
    return shaders;
}

Result Render(harness::Context& context, Scene scene, const RenderOptions& options) {
    Renderer renderer(context, GetShaders(), scene, options);
    renderer.Render(scene.cameras.front(), 0, false);
    return {renderer.ReadPicture(), renderer.TakeCounts(), renderer.GetPlans()};
}

std::vector<Picture> RenderAll(harness::Context& context, Scene scene, const RenderOptions& options,
                               const std::vector<Camera>& cameras) {
    Renderer renderer(context, GetShaders(), scene, options);
    std::vector<Picture> pictures;
    for (const Camera& camera : cameras) {
        renderer.Render(camera, 0, false);
        pictures.push_back(renderer.ReadPicture());
    }
    return pictures;
}

int GetLargestDifference(const Picture& a, const Picture& b) {
    int largest = a.size() == b.size() ? 0 : std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
        largest = std::max(largest, std::abs(static_cast<int>(a[i]) - static_cast<int>(b[i])));
    return largest;
}

} // namespace openntc_tests
