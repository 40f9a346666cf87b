// SPDX-License-Identifier: MIT
// The renderer on a device: small pictures of the sample scene.
#include "shader/renderer/Rendering.h"

#include "renderer/scene/SampleScene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

bool HasDefine(const std::vector<std::string>& defines, const std::string& text) {
    return std::find(defines.begin(), defines.end(), text) != defines.end();
}

} // namespace

TEST_CASE("renderer: the same bits from run to run, and from compute and fragment shaders") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Scene scene = MakeSampleScene();
    RenderOptions options = MakeSmallOptions(Mode::Reference);
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
    const Result reference = Render(*context, scene, MakeSmallOptions(Mode::Reference));
    for (TextureSetFile& file : scene.textureSets)
        file.path = OPENNTC_RENDERER_SOURCES "/CHANGELOG.md"; // no texture set
    const Result broken = Render(*context, scene, MakeSmallOptions(Mode::OnSample));
    CHECK(broken.picture == reference.picture);
    CHECK(broken.counts.decoded == 0);
}

TEST_CASE("renderer: a mask decodes its channel alone, and what a material lacks is not compiled") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Scene scene = MakeSampleScene();
    REQUIRE(scene.materials.size() >= 2);
    const Result loaded = Render(*context, scene, MakeSmallOptions(Mode::OnLoad));
    const Result sampled = Render(*context, scene, MakeSmallOptions(Mode::OnSample));
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
    CHECK(loaded.picture != sampled.picture);
}

TEST_CASE("renderer: other options on the same textures, and back, are what a new renderer makes") {
    OPENNTC_REQUIRE_DEVICE(context);
    Scene scene = MakeSampleScene();
    const RenderOptions options = MakeSmallOptions(Mode::OnLoad);
    const Picture expected = Render(*context, scene, options).picture;
    Renderer renderer(*context, GetShaders(), scene, options);
    const std::uint64_t bytes = renderer.GetTextures().GetMemory().decodedTextures;
    const auto render = [&] {
        renderer.Render(scene.cameras.front(), 0, false);
        return renderer.ReadPicture();
    };
    CHECK(render() == expected);
    RenderOptions other = options;
    other.width = 33;
    other.height = 5;
    other.filter = TextureFilter::Nearest;
    CHECK(renderer.Apply(other));
    CHECK(render() == Render(*context, scene, other).picture);
    other.masks = MaskPath::Fragment;
    CHECK(renderer.Apply(other));
    CHECK(render() == Render(*context, scene, other).picture);
    CHECK(renderer.Apply(options));
    CHECK(render() == expected);
    CHECK(renderer.GetTextures().GetMemory().decodedTextures == bytes); // none were decoded again
    other.mode = Mode::Reference;
    CHECK_FALSE(renderer.Apply(other));
    CHECK(render() == expected);
}

TEST_CASE("renderer: a device that runs out of memory or is lost is an error that says so, exit code 4") {
    OPENNTC_REQUIRE_DEVICE(shared);
    const Scene scene = MakeSampleScene();
    const RenderOptions options = MakeSmallOptions(Mode::Reference);
    const auto fail = [&](const harness::DeviceFaults& faults) -> std::string {
        harness::ContextOptions contextOptions;
        contextOptions.device = openntc_tests::GetTestDeviceName();
        contextOptions.faults = faults;
        const auto context = harness::Context::Create(contextOptions);
        REQUIRE(context);
        try {
            Render(**context, scene, options);
        } catch (const tool::CommandError& error) {
            CHECK(error.GetCode() == tool::ExitCode::NoDevice);
            return error.what();
        }
        return "";
    };
    CHECK(fail({}) == "");
    harness::DeviceFaults little;
    little.bytes = 1u << 20; // the textures take more
    CHECK(fail(little).find("device memory") != std::string::npos);
    harness::DeviceFaults lost;
    for (lost.submissions = 0; lost.submissions < 40; lost.submissions += 13) // while it loads, and later
        CHECK(fail(lost).find("the device is lost") != std::string::npos);
}
