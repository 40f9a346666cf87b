// SPDX-License-Identifier: MIT
// The renderer on a device: small pictures of the sample scene.
#include "../TestDevice.h"

#include "renderer/gpu/Renderer.h"
#include "renderer/scene/SampleScene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::renderer;

using Picture = std::vector<std::uint8_t>;

RenderOptions MakeOptions(Mode mode) {
    RenderOptions options;
    options.mode = mode;
    options.filter = TextureFilter::Bilinear;
    options.keepsTexels = true;
    options.counts = true;
    options.width = 40;
    options.height = 28;
    return options;
}

struct Result {
    Picture picture;
    TexelCounts counts;
    std::vector<MaterialPlan> plans;
};

Result Render(harness::Context& context, Scene scene, const RenderOptions& options) {
    static ShaderCache shaders(OPENNTC_RENDERER_SOURCES);
    Renderer renderer(context, shaders, scene, options);
    renderer.Render(scene.cameras.front(), 0, false);
    return {renderer.ReadPicture(), renderer.TakeCounts(), renderer.GetPlans()};
}

double GetMeanDifference(const Picture& a, const Picture& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += std::abs(static_cast<int>(a[i]) - static_cast<int>(b[i]));
    return sum / static_cast<double>(a.size());
}

bool HasDefine(const std::vector<std::string>& defines, const std::string& text) {
    return std::find(defines.begin(), defines.end(), text) != defines.end();
}

} // namespace

TEST_CASE("renderer: the same bits from run to run, and from compute and fragment shaders") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Scene scene = MakeSampleScene();
    RenderOptions options = MakeOptions(Mode::Reference);
    const Result first = Render(*context, scene, options);
    CHECK(Render(*context, scene, options).picture == first.picture);
    CHECK(first.counts.read > 0);
    CHECK(first.counts.decoded == 0);
    // Not one colour: something is drawn.
    CHECK(std::any_of(first.picture.begin() + 4, first.picture.end(),
                      [&](std::uint8_t byte) { return byte != first.picture[0] && byte != 255; }));
    options.path = ShadingPath::Fragment;
    CHECK(Render(*context, scene, options).picture == first.picture);
}

TEST_CASE("renderer: texture sets that cannot be used leave the picture of the source images") {
    OPENNTC_REQUIRE_DEVICE(context);
    Scene scene = MakeSampleScene();
    const Result reference = Render(*context, scene, MakeOptions(Mode::Reference));
    for (TextureSetFile& file : scene.textureSets)
        file.path = OPENNTC_RENDERER_SOURCES "/CHANGELOG.md"; // no texture set
    const Result broken = Render(*context, scene, MakeOptions(Mode::OnSample));
    CHECK(broken.picture == reference.picture);
    CHECK(broken.counts.decoded == 0);
}

TEST_CASE("renderer: a mask decodes its channel alone, and what a material lacks is not compiled") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Scene scene = MakeSampleScene();
    REQUIRE(scene.materials.size() >= 2);
    const Result loaded = Render(*context, scene, MakeOptions(Mode::OnLoad));
    const Result sampled = Render(*context, scene, MakeOptions(Mode::OnSample));
    CHECK(loaded.counts.decoded == 0);
    CHECK(sampled.counts.decoded == sampled.counts.read);
    CHECK(sampled.counts.read > 0);
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const MaterialPlan& plan = sampled.plans[i];
        const bool emits = scene.materials[i].emissiveFactor != glm::vec3(0.0f);
        CHECK(HasDefine(plan.defines, "NTCR_EMISSION=1") == emits);
        CHECK_FALSE(HasDefine(plan.defines, "NTCR_TRANSMITS=1"));
        if (scene.materials[i].alphaMode == AlphaMode::Mask)
            CHECK(HasDefine(plan.maskDefines, "NTC_OUTPUT_MASK=0x8"));
    }
    // Textures hold 8 bits a channel: half a step of each input. Where that turns a mask's decision a pixel
    // changes whole, which the mean of a picture bears and its largest difference does not.
    const double difference = GetMeanDifference(loaded.picture, sampled.picture);
    MESSAGE("on load and on sample differ by ", difference, " steps of 255 on average");
    CHECK(difference < 2.0);
    CHECK(loaded.picture != sampled.picture);
}
