// SPDX-License-Identifier: MIT
// FlightHelmet's leather and glass with LibNTC's texture sets: how near pictures of each mode are.
#include "shader/renderer/Rendering.h"

#include "Flip.h"
#include "renderer/scene/Cameras.h"
#include "renderer/scene/GltfScene.h"
#include "support/Files.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 64, kHeight = 64;

/// Texture sets under the names that the model's materials look for.
class SetFolder {
public:
    SetFolder(const fs::path& sets, const std::string& leather, const std::string& glass)
        : path_(fs::temp_directory_path() / ("openntc-helmet-" + std::to_string(std::random_device()()))) {
        fs::create_directories(path_);
        fs::copy_file(sets / leather, path_ / "LeatherPartsMat.ntc");
        fs::copy_file(sets / glass, path_ / "GlassPlasticMat.ntc");
    }
    ~SetFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    SetFolder(const SetFolder&) = delete;
    SetFolder& operator=(const SetFolder&) = delete;
    std::string GetPath() const { return path_.string(); }

private:
    fs::path path_;
};

/// The helmet's parts of these two materials alone.
Scene LoadHelmet(const fs::path& model, const std::string& materialDir) {
    GltfSceneOptions options;
    options.materialDir = materialDir;
    Scene scene = LoadGltfScene(model.string(), options);
    std::erase_if(scene.instances, [&](const Instance& instance) {
        const Primitive& primitive = scene.primitives[static_cast<std::size_t>(instance.primitive)];
        const std::string& name = scene.materials[static_cast<std::size_t>(primitive.material)].name;
        return name != "LeatherPartsMat" && name != "GlassPlasticMat";
    });
    scene.cameras = {MakeOrbitCamera(scene.bounds, 0.5f, 0.25f, 0.6f)};
    return scene;
}

std::vector<float> ToFloats(const Picture& picture) {
    std::vector<float> floats;
    for (std::size_t i = 0; i < picture.size(); ++i) {
        if (i % 4 != 3)
            floats.push_back(static_cast<float>(picture[i]) / 255.0f);
    }
    return floats;
}

struct Distance {
    double psnr, flip;
};

Distance Measure(const Picture& reference, const Picture& picture) {
    const std::vector<float> a = ToFloats(reference), b = ToFloats(picture);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += static_cast<double>((a[i] - b[i]) * (a[i] - b[i]));
    return {-10.0 * std::log10(sum / static_cast<double>(a.size()) + 1e-12),
            tool::ComputeFlip(a, b, kWidth, kHeight, 1).mean};
}

} // namespace

TEST_CASE("renderer: LibNTC's sets of the helmet on load and on sample, against its source images") {
    OPENNTC_REQUIRE_DEVICE(context);
    const fs::path sets = GetConformanceFolder();
    const fs::path model = sets.parent_path() / "assets/FlightHelmet/FlightHelmet.gltf";
    const std::string leather = "helmet-leather-medium.ntc", glass = "helmet-glassplastic-medium.ntc";
    if (!fs::exists(model) || !fs::exists(sets / leather) || !fs::exists(sets / glass)) {
        MESSAGE("SKIP: no FlightHelmet and its texture sets: set OPENNTC_SHARED_DIR");
        return;
    }
    const SetFolder folder(sets, leather, glass);
    const Scene scene = LoadHelmet(model, folder.GetPath());
    REQUIRE(scene.textureSets.size() == 2);
    REQUIRE(scene.instances.size() == 2);
    RenderOptions options = MakeSmallOptions(Mode::Reference);
    options.width = kWidth;
    options.height = kHeight;
    options.filter = TextureFilter::Trilinear;
    const Picture reference = Render(*context, scene, options).picture;
    options.mode = Mode::OnLoad;
    const Picture loaded = Render(*context, scene, options).picture;
    options.mode = Mode::OnSample;
    const Picture sampled = Render(*context, scene, options).picture;
    Scene swapped = scene;
    std::swap(swapped.textureSets[0].path, swapped.textureSets[1].path);
    const Picture mistaken = Render(*context, swapped, options).picture;
    const Distance ofLoaded = Measure(reference, loaded), ofSampled = Measure(reference, sampled),
                   between = Measure(loaded, sampled), ofMistaken = Measure(reference, mistaken);
    const auto report = [](const char* what, const Distance& distance) {
        MESSAGE(std::string(what) << ": " << distance.psnr << " dB, FLIP " << distance.flip);
    };
    report("on load against the source images", ofLoaded);
    report("on sample against the source images", ofSampled);
    report("on load against on sample", between);
    report("the sets of one material on the other", ofMistaken);
    // Rounding texels to bytes is less than encoding them, and that less than taking the wrong ones.
    for (const Distance& own : {ofLoaded, ofSampled}) {
        CHECK(between.psnr > own.psnr);
        CHECK(between.flip < own.flip);
        CHECK(own.psnr > ofMistaken.psnr);
        CHECK(own.flip < ofMistaken.flip);
    }
}
