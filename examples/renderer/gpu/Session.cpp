// SPDX-License-Identifier: MIT
#include "renderer/gpu/Session.h"

#include "renderer/gpu/TextureStore.h"
#include "renderer/scene/Cameras.h"
#include "renderer/scene/GltfScene.h"
#include "renderer/scene/SampleScene.h"
#include "renderer/scene/TestScenes.h"

#include "Arguments.h"
#include "Failure.h"
#include "Output.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace openntc::renderer {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;
using tool::FailUsage;

std::string FindSources(const CommandLine& line) {
    if (!line.sources.empty())
        return line.sources;
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    const fs::path installed = program.parent_path().parent_path() / "share" / "openntc";
    return fs::is_directory(installed / "examples" / "renderer", error) ? installed.string()
                                                                        : OPENNTC_SOURCE_DIR;
}

ShaderCache MakeShaderCache(const CommandLine& line) {
    return ShaderCache(FindSources(line), line.glslang);
}

Scene LoadScene(const CommandLine& line) {
    if (!line.testScene.empty()) {
        std::string names;
        for (const TestSceneInfo& info : GetTestScenes()) {
            if (info.name == line.testScene)
                return MakeTestScene(line.testScene);
            names += (names.empty() ? "" : ", ") + std::string(info.name);
        }
        FailUsage("--test-scene", line.testScene + ": one of " + names);
    }
    if (line.model.empty())
        return MakeSampleScene(!line.materialDir.empty() ? line.materialDir
                                                         : FindSources(line) + "/examples/materials/data");
    GltfSceneOptions options;
    options.scene = line.scene;
    options.materialDir = line.materialDir;
    return LoadGltfScene(line.model, options);
}

void ChooseMode(const Scene& scene, CommandLine& line) {
    const bool hasSets = std::any_of(scene.textureSets.begin(), scene.textureSets.end(),
                                     [](const TextureSetFile& file) { return file.error.empty(); });
    if (line.choosesMode && hasSets && line.allowsOnLoad)
        line.render.mode = Mode::OnLoad;
    else if (line.choosesMode && hasSets && line.allowsOnSample)
        line.render.mode = Mode::OnSample;
    else if (line.choosesMode && hasSets && line.allowsOnFeedback)
        line.render.mode = Mode::OnFeedback;
    if (!hasSets && line.render.mode != Mode::Reference)
        throw CommandError(ExitCode::BadInput, scene.name,
                           "texture sets: none: make them with `ntc convert-gltf`, name their folder with "
                           "--material-dir, or take --mode reference");
}

Camera ChooseCamera(const Scene& scene, const CommandLine& line, float turn) {
    if (line.camera == "orbit" || (line.camera.empty() && scene.cameras.empty())) {
        constexpr float kDegree = 0.017453293f;
        return MakeOrbitCamera(scene.bounds, (line.azimuth + turn) * kDegree, line.elevation * kDegree,
                               line.distance);
    }
    if (line.camera.empty())
        return scene.cameras.front();
    std::string names;
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
        if (scene.cameras[i].name == line.camera || std::to_string(i) == line.camera)
            return scene.cameras[i];
        names += ", " + scene.cameras[i].name;
    }
    FailUsage("--camera", line.camera + ": the model has orbit" + names);
}

std::unique_ptr<harness::Context> OpenDevice(const CommandLine& line,
                                             const std::vector<std::string>& surfaceExtensions) {
    harness::ContextOptions options;
    options.device = line.device;
    options.validation = line.debug;
    options.required = {harness::Feature::StorageImages, harness::Feature::DynamicRendering,
                        harness::Feature::FragmentStores};
    if (!line.allowsCoopVec)
        options.withheld = {harness::Feature::CooperativeVectors};
    if (!surfaceExtensions.empty())
        options.required.push_back(harness::Feature::Swapchain);
    options.surfaceExtensions = surfaceExtensions;
    return RequireDevice(harness::Context::Create(options));
}

void PrintWarnings(const char* program, const Scene& scene) {
    const auto warn = [program](const std::string& text) {
        std::fprintf(stderr, "%s: warning: %s\n", program, tool::Printable(text).c_str());
    };
    for (const std::string& warning : scene.warnings)
        warn(warning);
    for (const SourceImage& image : scene.images) {
        if (!image.error.empty())
            warn(image.label + ": " + image.error + ": grey in its place");
    }
    for (const TextureSetFile& file : scene.textureSets) {
        if (!file.error.empty())
            warn(file.path + ": " + file.error + ": its materials show their source images");
    }
}

} // namespace openntc::renderer
