// SPDX-License-Identifier: MIT
// Pictures whose texels come from texture sets: with every maths mode, on load and on sample, each is what the CPU computes
// of the texels that the reference decoders give. And filters over a floor at a grazing angle.
#include "shader/renderer/Prediction.h"

#include "renderer/scene/Cameras.h"
#include "renderer/scene/EnvironmentTable.h"
#include "renderer/scene/Lights.h"
#include "renderer/scene/SampleScene.h"
#include "renderer/scene/SceneBuilder.h"
#include "renderer/scene/TestScenes.h"
#include "renderer/scene/TextureSetLookup.h"
#include "renderer/shaders/ToneMap.h"
#include "support/Files.h"

#include "openntc/MathModes.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

RenderOptions MakeOptions(Mode mode, int side, int math = NTC_MATH_INT8) {
    RenderOptions options;
    options.mode = mode;
    options.filter = TextureFilter::Nearest;
    options.keepsTexels = true;
    options.counts = true; // as other tests here, which have the same shaders then
    options.width = options.height = side;
    options.math = math;
    return options;
}

/// Every picture is what is predicted of `texels`. Returns them.
std::vector<Picture> CheckTexels(harness::Context& context, const Scene& scene, const RenderOptions& options,
                                 const std::vector<Camera>& cameras, const ReadTexel& texels) {
    std::vector<Picture> pictures = RenderAll(context, scene, options, cameras);
    std::size_t covered = 0, known = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        INFO("view " << i);
        const Prediction prediction =
            Predict(scene, cameras[i], options.width, options.height, options.exposure, texels);
        CHECK(GetLargestDifference(prediction, pictures[i]) <= 1);
        covered += prediction.covered;
        known += prediction.known;
    }
    CHECK(2 * known >= covered);
    return pictures;
}

} // namespace

TEST_CASE(
    "renderer: on load and on sample, every maths mode shows the texels that decoders on the CPU give") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Scene scene = MakeSampleScene();
    constexpr int kSide = 32;
    // A free piece of the wall; the gate, through whose holes the wall shows.
    const std::vector<Camera> cameras = {MakeFrontCamera({3.5f, 2.4f}, 1.0f / 160, kSide, kSide),
                                         MakeFrontCamera({0.8f, 0.7f}, 1.0f / 300, kSide, kSide)};
    const std::vector<Picture> loaded = CheckTexels(*context, scene, MakeOptions(Mode::OnLoad, kSide),
                                                    cameras, MakeSetSource(scene, DecodeMath::Int8, true));
    const std::vector<Picture> sampled = CheckTexels(*context, scene, MakeOptions(Mode::OnSample, kSide),
                                                     cameras, MakeSetSource(scene, DecodeMath::Int8, false));
    CHECK(sampled != loaded);
    // The other modes with the wall alone: every shader more takes a second to compile.
    Scene wall = scene;
    wall.instances = {scene.instances[1]};
    std::vector<Picture> walls = {sampled.front()};
    for (const std::pair<int, DecodeMath>& mode :
         {std::pair(NTC_MATH_INT8_HALF, DecodeMath::Int8Half), std::pair(NTC_MATH_FP16, DecodeMath::FP16),
          std::pair(NTC_MATH_FP32, DecodeMath::FP32)}) {
        INFO("maths mode " << mode.first);
        walls.push_back(CheckTexels(*context, wall, MakeOptions(Mode::OnSample, kSide, mode.first),
                                    {cameras.front()}, MakeSetSource(wall, mode.second, false))
                            .front());
    }
    // Without quantised activations other texels come out.
    CHECK(walls.front() != walls.back());
}

TEST_CASE("renderer: FP8 weights of a set that has both are what an FP8 picture shows") {
    OPENNTC_REQUIRE_DEVICE(context);
    const auto path = GetConformanceFolder() / "helmet-leather-medium.ntc";
    if (!std::filesystem::exists(path)) {
        MESSAGE("SKIP: no texture set with FP8 weights: set OPENNTC_SHARED_DIR");
        return;
    }
    SceneBuilder builder("leather");
    Material material;
    for (const TextureSlot slot : {TextureSlot::BaseColor, TextureSlot::MetallicRoughness,
                                   TextureSlot::Normal, TextureSlot::Occlusion})
        material.textures[static_cast<std::size_t>(slot)].image = 0;
    builder.AddImage("gray", 512, 512, [](int, int) { return 0xFF808080u; }); // of the set's size
    const int index = builder.AddMaterial(material);
    AttachTextureSet(path.string(), builder.GetScene().materials[static_cast<std::size_t>(index)],
                     builder.GetScene());
    builder.AddAt(builder.AddQuad(index), {0, 0, 0});
    const Scene scene = builder.Take();
    constexpr int kSide = 32;
    const std::vector<Camera> cameras = {MakeFrontCamera({0.1f, 0.2f}, 1.0f / 512, kSide, kSide)};
    const std::vector<Picture> fp8 =
        CheckTexels(*context, scene, MakeOptions(Mode::OnSample, kSide, NTC_MATH_FP8), cameras,
                    MakeSetSource(scene, DecodeMath::FP8, false));
    const std::vector<Picture> int8 = CheckTexels(*context, scene, MakeOptions(Mode::OnSample, kSide),
                                                  cameras, MakeSetSource(scene, DecodeMath::Int8, false));
    CHECK(fp8 != int8);
}

namespace {

/// Texture coordinates of the floor at a pixel, and the direction to the eye.
struct FloorPoint {
    glm::vec2 uv{0.0f};
    glm::vec3 toEye{0.0f};
    bool isInside = false;
};

FloorPoint FindFloor(const Camera& camera, glm::vec2 pixel, int width, int height) {
    const glm::vec2 size(width, height);
    const glm::vec2 at = 2.0f * pixel / size - 1.0f;
    const glm::mat4 toWorld = glm::inverse(MakeViewProjection(camera, size.x / size.y));
    const glm::vec4 far = toWorld * glm::vec4(at, 1e-3f, 1.0f);
    const glm::vec3 eye(camera.toWorld[3]), direction = glm::normalize(glm::vec3(far) / far.w - eye);
    FloorPoint point;
    point.toEye = -direction;
    const glm::vec3 place = eye + direction * (-eye.y / direction.y);
    // 8 x 200 units, 4 x 100 repeats; v grows towards the eye.
    point.uv = {(place.x + 4.0f) * 0.5f, (place.z + 100.0f) * 0.5f};
    point.isInside = direction.y < 0.0f && std::fabs(place.x) < 3.9f && place.z > -99.0f;
    return point;
}

glm::ivec3 ShadeFloor(glm::vec3 color, glm::vec3 toEye, const Material& material) {
    const glm::vec3 up(0, 1, 0);
    const shader::NtcrSurface surface =
        shader::NtcrMakeMetallicRoughness(color, material.metallicFactor, material.roughnessFactor);
    const shader::NtcrEnvironmentTaps taps =
        shader::NtcrGetEnvironmentTaps(surface.roughness, glm::dot(up, toEye));
    const glm::vec2* cells = GetEnvironmentTable().data() + taps.first;
    const glm::vec2 environment = shader::NtcrMixEnvironment(
        taps, cells[0], cells[1], cells[NTCR_ENVIRONMENT_SIZE], cells[NTCR_ENVIRONMENT_SIZE + 1]);
    const std::uint32_t pixel =
        shader::NtcrMakePixel(shader::NtcrGetRadiance(shader::NtcrReflectLights(MakeLights(), surface, up,
                                                                                toEye, environment, 1, 1)),
                              1.0f, NTCR_TONE_NONE);
    return {pixel & 255, pixel >> 8 & 255, pixel >> 16 & 255};
}

} // namespace

TEST_CASE(
    "renderer: far away the trilinear filter leaves the mean of stripes, the anisotropic one the stripes") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kWidth = 128, kHeight = 80;
    Scene scene = MakeTestScene("floor");
    SourceImage& image = scene.images.front();
    for (std::size_t i = 0; i < image.texels.size(); ++i) // stripes towards the horizon
        image.texels[i] = i % 4 == 3 ? 255 : i / 4 % 64 < 32 ? 225 : 30;
    const auto decode = [](float code) { return shader::NtcDecodeSrgb(code / 255.0f); };
    const glm::vec3 light(decode(225)), dark(decode(30)), mean = 0.5f * (light + dark);
    RenderOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.filter = TextureFilter::Trilinear;
    const Picture blurred = Render(*context, scene, options).picture;
    options.filter = TextureFilter::Anisotropic;
    const Picture sharp = Render(*context, scene, options).picture;
    const Camera& camera = scene.cameras.front();
    int means = 0, lights = 0, darks = 0;
    for (int y = 1; y + 1 < kHeight; ++y) {
        for (int x = 0; x + 1 < kWidth; ++x) {
            const glm::vec2 center(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
            const auto find = [&](float dx, float dy) {
                return FindFloor(camera, center + glm::vec2(dx, dy), kWidth, kHeight);
            };
            const FloorPoint here = find(0, 0), right = find(1, 0), above = find(0, -1), below = find(0, 1);
            // The derivative along the floor lies between the steps to the rows below and above.
            const float least = glm::length(below.uv - here.uv), most = glm::length(above.uv - here.uv),
                        across = glm::length(right.uv - here.uv);
            if (!here.isInside || !right.isInside || !above.isInside || least < 1.0f)
                continue; // else a whole texture a pixel and more: the smallest mip, one texel
            const auto differ = [&](const Picture& picture, glm::vec3 color) {
                const glm::ivec3 expected = ShadeFloor(color, here.toEye, scene.materials.front());
                int largest = 0;
                for (int c = 0; c < 3; ++c)
                    largest = std::max(
                        largest,
                        std::abs(expected[c] - picture[static_cast<std::size_t>(4 * (y * kWidth + x) + c)]));
                return largest;
            };
            // A step for the mean's storage in 8 bits, one for the picture's.
            CHECK(differ(blurred, mean) <= 2);
            ++means;
            // 16 taps, each as wide as the longer of a 16th of the way along and the way across; of the two mips
            // the coarser has texels of twice that at most, and a bilinear tap reaches one of them.
            const float reach = 2.0f * std::max(most / 16.0f, across), u = here.uv.x - std::floor(here.uv.x);
            const float fromEdge = 0.25f - std::fabs(std::fabs(u - 0.5f) - 0.25f);
            if (fromEdge <= reach)
                continue;
            CHECK(differ(sharp, u < 0.5f ? light : dark) <= 1);
            ++(u < 0.5f ? lights : darks);
        }
    }
    MESSAGE(means << " pixels are the mean; of " << lights << " light and " << darks
                  << " dark ones the stripes stay");
    CHECK(means > 0);
    CHECK(lights > 0);
    CHECK(darks > 0);
}
