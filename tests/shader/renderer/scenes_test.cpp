// SPDX-License-Identifier: MIT
// Pictures of the generated scenes, pixel by pixel: each is what the CPU computes of it, and what must look alike does.
#include "shader/renderer/Prediction.h"

#include "renderer/scene/Lights.h"
#include "renderer/scene/TestScenes.h"
#include "renderer/shaders/ToneMap.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

/// Square windows of a scene, seen along -z.
struct Views {
    const char* scene;
    float pixelsPerUnit;
    int side; ///< pixels
    std::vector<glm::vec2> centers;
    float exposure = 1.0f;
};

/// Cells of a row or grid, 1.1 apart, about the origin.
std::vector<glm::vec2> MakeGrid(int columns, int rows, glm::vec2 offset = glm::vec2(0.0f)) {
    std::vector<glm::vec2> centers;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column)
            centers.push_back(
                offset + 1.1f * glm::vec2(static_cast<float>(column) - 0.5f * static_cast<float>(columns - 1),
                                          0.5f * static_cast<float>(rows - 1) - static_cast<float>(row)));
    }
    return centers;
}

std::vector<glm::vec2> Join(std::vector<glm::vec2> a, const std::vector<glm::vec2>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<Camera> MakeCameras(const Views& views) {
    std::vector<Camera> cameras;
    for (const glm::vec2& center : views.centers)
        cameras.push_back(MakeFrontCamera(center, 1.0f / views.pixelsPerUnit, views.side, views.side));
    return cameras;
}

RenderOptions MakeOptions(const Views& views, TextureFilter filter) {
    RenderOptions options;
    options.filter = filter;
    options.width = options.height = views.side;
    options.exposure = views.exposure;
    return options;
}

std::vector<Picture> Render(harness::Context& context, const Views& views, TextureFilter filter) {
    return RenderAll(context, MakeTestScene(views.scene), MakeOptions(views, filter), MakeCameras(views));
}

/// Every picture is what is predicted of it. Returns them.
std::vector<Picture> CheckPrediction(harness::Context& context, const Views& views) {
    INFO(views.scene);
    const Scene scene = MakeTestScene(views.scene);
    const std::vector<Camera> cameras = MakeCameras(views);
    std::vector<Picture> pictures = Render(context, views, TextureFilter::Nearest);
    std::size_t covered = 0, known = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        INFO("view " << i);
        const Prediction prediction =
            Predict(scene, cameras[i], views.side, views.side, views.exposure, MakeImageSource(scene));
        CHECK(GetLargestDifference(prediction, pictures[i]) <= 1);
        covered += prediction.covered;
        known += prediction.known;
    }
    MESSAGE(std::string(views.scene) << ": " << known << " of " << covered
                                     << " covered pixels are predicted");
    CHECK(2 * known >= covered); // else the views are badly chosen
    CHECK(known > 0);
    return pictures;
}

/// All pictures are the first: the same real numbers by other sums, so a step at most.
void CheckAlike(const std::vector<Picture>& pictures) {
    for (const Picture& picture : pictures)
        CHECK(GetLargestDifference(picture, pictures.front()) <= 1);
}

glm::ivec3 GetSkyPixel() {
    const std::uint32_t pixel =
        shader::NtcrMakePixel(shader::NtcrGetSky(MakeLights(), {0, 0, -1}), 1.0f, NTCR_TONE_NONE);
    return {pixel & 255, pixel >> 8 & 255, pixel >> 16 & 255};
}

} // namespace

TEST_CASE("renderer scenes: both workflows make the same spheres, as predicted") {
    OPENNTC_REQUIRE_DEVICE(context);
    // From the middle to the upper right edge of six spheres: each column, each row.
    const std::vector<glm::vec2> all = MakeGrid(6, 4, {0.18f, 0.18f});
    Views views{"spheres", 110, 40, {all[0], all[7], all[14], all[21], all[10], all[17]}};
    const std::vector<Picture> metallic = CheckPrediction(*context, views);
    views.scene = "spheres-glossiness";
    const std::vector<Picture> glossy = CheckPrediction(*context, views);
    for (std::size_t i = 0; i < metallic.size(); ++i)
        CHECK(GetLargestDifference(metallic[i], glossy[i]) <= 1);
    CHECK(GetLargestDifference(metallic[0], metallic[1]) > 1);
}

TEST_CASE(
    "renderer scenes: turned and mirrored coordinates light alike, with tangents and with derivatives") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<Picture> tangents = CheckPrediction(*context, {"turned", 64, 64, MakeGrid(4, 2)});
    CheckAlike(tangents);
    std::vector<Picture> derivatives =
        CheckPrediction(*context, {"turned-derivatives", 64, 64, MakeGrid(4, 2)});
    derivatives.push_back(tangents.front());
    CheckAlike(derivatives);
    // The dome is lit from its upper left: of an upside-down one the lower right would be.
    const auto luminance = [&](int x, int y) {
        return tangents.front()[static_cast<std::size_t>(4 * (64 * y + x) + 1)];
    };
    CHECK(luminance(22, 16) > luminance(41, 47) + 1);
}

TEST_CASE("renderer scenes: emission doubles from quad to quad, above 1 too") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<Picture> row =
        CheckPrediction(*context, {"emission", 32, 32, MakeGrid(5, 1), 1.0f / 32});
    for (std::size_t i = 1; i < row.size(); ++i) {
        std::size_t brighter = 0;
        for (std::size_t k = 0; k < row[i].size(); k += 4)
            brighter += row[i][k] > row[i - 1][k] ? 1 : 0;
        CHECK(brighter == row[i].size() / 4);
    }
}

TEST_CASE(
    "renderer scenes: masks show what reaches their cutoff, from both sides; blended cards lie in order") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<Picture> masks =
        CheckPrediction(*context, {"cards", 64, 64, MakeGrid(4, 1, {0, 0.6f})});
    const Scene scene = MakeTestScene("cards");
    const glm::ivec3 sky = GetSkyPixel();
    for (std::size_t i = 0; i < masks.size(); ++i) {
        const Material& material = scene.materials[i];
        const SourceImage& disc = scene.images[static_cast<std::size_t>(material.textures[0].image)];
        std::ptrdiff_t expected = 0, shown = 0;
        for (std::size_t texel = 0; texel < masks[i].size(); texel += 4) {
            expected += static_cast<float>(disc.texels[texel + 3]) / 255.0f >= material.alphaCutoff ? 1 : 0;
            const glm::ivec3 pixel(masks[i][texel], masks[i][texel + 1], masks[i][texel + 2]);
            shown += pixel != sky ? 1 : 0;
        }
        INFO("cutoff " << material.alphaCutoff);
        CHECK(shown == expected);
        CHECK(expected > 0);
    }
    const std::vector<Picture> blended = CheckPrediction(*context, {"cards", 20, 40, {{0, -0.7f}}});
    // Where all three lie: half red over half green over half blue over the sky; in another order red were not first.
    const std::size_t middle = 4 * (40 * 20 + 20);
    CHECK(blended[0][middle] > blended[0][middle + 1] + 1);
    CHECK(blended[0][middle + 1] > blended[0][middle + 2] + 1);
}

TEST_CASE("renderer scenes: wrap modes, texture sizes and transforms address the texels that they should") {
    OPENNTC_REQUIRE_DEVICE(context);
    // About (0, 0) and (1, 1) in texture coordinates.
    CheckPrediction(*context,
                    {"wraps", 192, 32,
                     Join(MakeGrid(3, 3, {-1.0f / 6, 1.0f / 6}), MakeGrid(3, 3, {1.0f / 6, -1.0f / 6}))});
    CheckPrediction(*context, {"sizes", 128, 48, MakeGrid(4, 1, {0.2f, 0.2f})});
    CheckPrediction(*context, {"sizes", 256, 48, {MakeGrid(4, 1)[3]}});
    const Views transforms{"transforms", 256, 48, MakeGrid(2, 2)};
    CheckPrediction(*context, transforms);
    CheckAlike(Render(*context, transforms, TextureFilter::Bilinear));
    // From afar, where the level of detail hangs on how the transform turns derivatives.
    CheckAlike(Render(*context, {"transforms", 20, 22, MakeGrid(2, 2)}, TextureFilter::Trilinear));
}

TEST_CASE("renderer scenes: a pixel of a whole texture is its mean, whatever its size") {
    OPENNTC_REQUIRE_DEVICE(context);
    Scene scene = MakeTestScene("sizes");
    // Every quad fills a picture of one pixel, so that the smallest mip is read. A white one for its light.
    const Views views{"sizes", 1, 1, MakeGrid(4, 1)};
    const std::vector<Picture> pixels = Render(*context, views, TextureFilter::Trilinear);
    for (std::size_t i = 0; i < 4; ++i) {
        SourceImage& image = scene.images[static_cast<std::size_t>(scene.materials[i].textures[0].image)];
        glm::dvec3 sum(0.0);
        const ReadTexel texels = MakeImageSource(scene);
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x)
                sum += glm::dvec3(texels(static_cast<int>(i), TextureSlot::BaseColor, {x, y}));
        }
        const glm::vec3 mean = sum / (static_cast<double>(image.width) * image.height);
        const ReadTexel ofMean = [mean](int, TextureSlot, glm::ivec2) { return glm::vec4(mean, 1.0f); };
        image.width = image.height = 1; // nothing is minified
        // The middle of the pixel is on the quad's diagonal: what is predicted a little beside it.
        const Camera camera = MakeFrontCamera(views.centers[i] + glm::vec2(0.1f, 0.0f), 0.5f, 1, 1);
        const Prediction prediction = Predict(scene, camera, 1, 1, 1.0f, ofMean);
        REQUIRE(prediction.known == 1);
        // Mips are stored in 8 bits: half a step for each of their roundings, and one of the picture.
        CHECK(GetLargestDifference(prediction, pixels[i]) <= 1 + 1);
    }
}

TEST_CASE("renderer scenes: negative determinants, missing attributes, transmission and occlusion") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Views mirrored{"mirrored", 96, 96, {{-1.2f, 0}, {0, 0}, {1.2f, 0}}};
    CheckPrediction(*context, mirrored);
    std::vector<Picture> sides = Render(*context, mirrored, TextureFilter::Bilinear);
    CHECK(GetLargestDifference(sides[0], sides[1]) > 1);
    sides.erase(sides.begin());
    CheckAlike(sides);
    CheckPrediction(*context, {"bare", 120, 48, MakeGrid(4, 1, {0.1f, 0.1f})});
    const std::vector<Picture> spheres = CheckPrediction(*context, {"transmission", 80, 48, MakeGrid(4, 1)});
    CHECK(GetLargestDifference(spheres[0], spheres[3]) > 1);
}
