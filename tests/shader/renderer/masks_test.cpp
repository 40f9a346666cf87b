// SPDX-License-Identifier: MIT
// Masks that compute shaders decide are those that fragment shaders decide, bit for bit: in many layers, where depths are
// equal, with what is blended before and behind them.
#include "shader/renderer/Prediction.h"

#include "renderer/scene/SampleScene.h"
#include "renderer/scene/SceneBuilder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

Material MakeCard(int image, AlphaMode mode, glm::vec4 color) {
    Material material;
    material.alphaMode = mode;
    material.baseColorFactor = color;
    material.metallicFactor = 0.0f;
    material.doubleSided = true;
    material.textures[static_cast<std::size_t>(TextureSlot::BaseColor)].image = image;
    return material;
}

/// Cards full of holes, one behind the other: of two masked materials in turn, some at one depth with the next or with an
/// opaque one that comes before or after them, and blended ones between.
Scene MakeLayers(int layers) {
    SceneBuilder builder("layers");
    const int holes = builder.AddImage("holes", 16, 16, [](int x, int y) {
        const bool isHole = (x * 7 + y * 11 + x * y) % 5 != 0;
        return 0x00FFFFFFu | (isHole ? 0u : 0xFFu) << 24;
    });
    const int red = builder.AddMaterial(MakeCard(holes, AlphaMode::Mask, {1, 0.2f, 0.1f, 1}));
    const int green = builder.AddMaterial(MakeCard(holes, AlphaMode::Mask, {0.2f, 1, 0.1f, 1}));
    const int solid = builder.AddMaterial(MakeCard(-1, AlphaMode::Opaque, {0.2f, 0.2f, 1, 1}));
    const int glass = builder.AddMaterial(MakeCard(-1, AlphaMode::Blend, {1, 1, 0.2f, 0.5f}));
    for (int i = 0; i < layers; ++i) {
        // Each a little aside, so that holes lie over cards.
        const int pair = i / 2;
        const float aside = 0.03f * static_cast<float>(i % 7), depth = -0.1f * static_cast<float>(pair);
        builder.AddAt(builder.AddQuad(i % 2 == 0 ? red : green, {{1, 0, aside}, {0, 1, 2 * aside}}),
                      {aside, 0, depth});
        if (i % 5 == 2)
            builder.AddAt(builder.AddQuad(glass), {-0.3f, 0.1f, depth + 0.05f}, glm::vec3(0.5f));
    }
    // At the depth of the first two layers after them, at that of the next two before a card more.
    builder.AddAt(builder.AddQuad(solid), {-0.3f, -0.3f, 0}, glm::vec3(0.4f));
    builder.AddAt(builder.AddQuad(solid), {0.3f, 0.3f, -0.1f}, glm::vec3(0.4f));
    builder.AddAt(builder.AddQuad(green), {0.3f, 0.3f, -0.1f}, glm::vec3(0.5f));
    Scene scene = builder.Take();
    scene.cameras = {MakeFrontCamera({0, 0}, 1.0f / 30, 40, 28)};
    return scene;
}

struct Paths {
    Result compute, fragmentMasks, fragment;
};

Paths RenderPaths(harness::Context& context, const Scene& scene, RenderOptions options) {
    Paths paths;
    paths.compute = Render(context, scene, options);
    options.masks = MaskPath::Fragment;
    paths.fragmentMasks = Render(context, scene, options);
    options.path = ShadingPath::Fragment;
    paths.fragment = Render(context, scene, options);
    return paths;
}

} // namespace

TEST_CASE("renderer masks: in compute and in fragment shaders the same bits, whatever lies over what") {
    OPENNTC_REQUIRE_DEVICE(context);
    RenderOptions options = MakeSmallOptions(Mode::Reference);
    options.filter = TextureFilter::Nearest;
    const Scene scene = MakeLayers(14);
    const Paths paths = RenderPaths(*context, scene, options);
    CHECK(paths.compute.picture == paths.fragmentMasks.picture);
    CHECK(paths.compute.picture == paths.fragment.picture);
    // Known without either.
    const Prediction prediction =
        Predict(scene, scene.cameras.front(), options.width, options.height, 1.0f, MakeImageSource(scene));
    CHECK(GetLargestDifference(prediction, paths.compute.picture) <= 1);
    CHECK(prediction.known > 0);
    // What is nearest is decided first, and what it hides is not: fewer texels than with all that is drawn.
    CHECK(paths.compute.counts.read < paths.fragmentMasks.counts.read);
    options.stochastic = Stochastic::OneTap;
    const Picture compute = Render(*context, scene, options).picture;
    options.masks = MaskPath::Fragment;
    CHECK(Render(*context, scene, options).picture == compute);
}

TEST_CASE("renderer masks: more candidates than there was room for are all decided") {
    OPENNTC_REQUIRE_DEVICE(context);
    const RenderOptions options = MakeSmallOptions(Mode::Reference);
    ShaderCache shaders(OPENNTC_RENDERER_SOURCES);
    Scene scene = MakeLayers(14);
    Renderer renderer(*context, shaders, scene, options);
    const std::uint64_t before = renderer.GetTargetBytes();
    renderer.Render(scene.cameras.front(), 0, false);
    CHECK(renderer.GetTargetBytes() > before);
    const Picture first = renderer.ReadPicture();
    renderer.Render(scene.cameras.front(), 0, false); // with room from the beginning
    CHECK(renderer.ReadPicture() == first);
    // A scene without masks has no lists.
    Scene solid = MakeLayers(0);
    solid.instances.pop_back();
    Renderer plain(*context, shaders, solid, options);
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(options.width) * static_cast<std::uint64_t>(options.height);
    CHECK(plain.GetTargetBytes() ==
          pixels * (8 + 4 + 16 + 16 + 4)); // visibility, depth, picture, mean, pixels
}

TEST_CASE("renderer masks: decoded in compute shaders, the sample scene's bits do not change") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Scene scene = MakeSampleScene();
    RenderOptions options = MakeSmallOptions(Mode::OnSample);
    const Result compute = Render(*context, scene, options);
    options.masks = MaskPath::Fragment;
    const Result fragment = Render(*context, scene, options);
    CHECK(compute.picture == fragment.picture);
    CHECK(compute.counts.decoded <= fragment.counts.decoded);
    CHECK(compute.counts.decoded > 0);
}

TEST_CASE(
    "renderer masks: from afar the source images let through what they do from near, in their own colour") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 64, kStep = 8;
    SceneBuilder builder("far");
    // Every alpha another one, few of them high: averages of 64 do not reach the cutoff. What cannot be seen is red.
    const int image = builder.AddImage("leaves", kSide, kSide, [](int x, int y) {
        const auto at = static_cast<std::uint32_t>(y * kSide + x);
        const std::uint32_t alpha = at % 5 == 0 ? 200 + at % 56 : 20 + static_cast<std::uint32_t>(x + y) / 4;
        return alpha << 24 | (alpha >= 128 ? 0x00FF00u : 0x0000FFu);
    });
    Material material = MakeCard(image, AlphaMode::Mask, {1, 1, 1, 1});
    material.keptCoverage = material.alphaCutoff;
    builder.AddAt(builder.AddQuad(builder.AddMaterial(material)), {0, 0, 0});
    Scene scene = builder.Take();
    RenderOptions options;
    options.filter = TextureFilter::Nearest;
    const auto count = [&](int side) {
        options.width = options.height = side;
        const Picture picture =
            RenderAll(*context, scene, options,
                      {MakeFrontCamera({0, 0}, 1.0f / static_cast<float>(side), side, side)})
                .front();
        Scene empty = scene;
        empty.instances.front().toWorld[3].z = 1000.0f; // behind the eye
        const Picture sky = RenderAll(*context, empty, options,
                                      {MakeFrontCamera({0, 0}, 1.0f / static_cast<float>(side), side, side)})
                                .front();
        int shown = 0;
        for (std::size_t i = 0; i < picture.size(); i += 4) {
            if (std::equal(picture.begin() + static_cast<std::ptrdiff_t>(i),
                           picture.begin() + static_cast<std::ptrdiff_t>(i) + 4,
                           sky.begin() + static_cast<std::ptrdiff_t>(i)))
                continue;
            ++shown;
            CHECK(picture[i + 1] > picture[i]);
        }
        return shown;
    };
    const int near = count(kSide);
    CHECK(near == (kSide * kSide + 4) / 5);
    // A texel of mip 3 for each pixel: the nearest count, alphas being different.
    const int far = kSide / kStep;
    CHECK(std::abs(count(far) - near / (kStep * kStep)) <= 1);
    scene.materials.front().keptCoverage = 0.0f;
    CHECK(count(far) == 0);
}
