// SPDX-License-Identifier: MIT
// `ntc-renderer`: a glTF model with neural materials, rendered without a window to a PNG.
#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/Renderer.h"
#include "renderer/gpu/Stats.h"
#include "renderer/scene/Cameras.h"
#include "renderer/scene/GltfScene.h"
#include "renderer/scene/SampleScene.h"
#include "renderer/scene/TestScenes.h"

#include "Arguments.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "Png.h"
#include "Progress.h"
#include "RunMain.h"
#include "encode/StateFile.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>

namespace {

namespace fs = std::filesystem;
using namespace openntc::renderer;
using openntc::tool::CommandError;
using openntc::tool::ExitCode;
using openntc::tool::FailUsage;
using openntc::tool::Printable;

void Warn(const std::string& text) {
    std::fprintf(stderr, "ntc-renderer: warning: %s\n", Printable(text).c_str());
}

/// Where the shaders are: the source that this program was built from, or <prefix>/share/openntc.
std::string FindSources(const CommandLine& line) {
    if (!line.sources.empty())
        return line.sources;
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    const fs::path installed = program.parent_path().parent_path() / "share" / "openntc";
    return fs::is_directory(OPENNTC_SOURCE_DIR, error) || !fs::is_directory(installed, error)
               ? OPENNTC_SOURCE_DIR
               : installed.string();
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
        return MakeSampleScene(line.materialDir);
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
    if (!hasSets && line.render.mode != Mode::Reference)
        throw CommandError(ExitCode::BadInput, scene.name,
                           "texture sets: none: make them with `ntc convert-gltf`, name their folder with "
                           "--material-dir, or take --mode reference");
}

Camera ChooseCamera(const Scene& scene, const CommandLine& line, int picture) {
    if (line.camera == "orbit" || (line.camera.empty() && scene.cameras.empty())) {
        constexpr float kDegree = 0.017453293f;
        const float turn =
            line.azimuth + 360.0f * static_cast<float>(picture) / static_cast<float>(line.frames);
        return MakeOrbitCamera(scene.bounds, turn * kDegree, line.elevation * kDegree, line.distance);
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

void WritePicture(const std::string& path, const std::vector<std::uint8_t>& texels, int width, int height) {
    openntc::tool::PngWriter png(path, path, {width, height, 3, 8});
    std::vector<std::uint16_t> row(3 * static_cast<std::size_t>(width));
    for (int y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
            const std::size_t at = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + x);
            for (std::size_t c = 0; c < 3; ++c)
                row[3 * x + c] = texels[at + c];
        }
        png.WriteRow(row);
    }
    png.Finish();
}

int Run(int argc, char** argv) {
    CommandLine line;
    if (!ParseCommandLine(argc, argv, line))
        return 0;
    Scene scene = LoadScene(line);
    ChooseMode(scene, line);
    ChooseCamera(scene, line, 0); // a wrong name at once

    const auto start = std::chrono::steady_clock::now();
    openntc::harness::ContextOptions contextOptions;
    contextOptions.device = line.device;
    contextOptions.validation = line.debug;
    contextOptions.required = {openntc::harness::Feature::StorageImages,
                               openntc::harness::Feature::DynamicRendering,
                               openntc::harness::Feature::FragmentStores};
    const auto context = RequireDevice(openntc::harness::Context::Create(contextOptions));
    ShaderCache shaders(FindSources(line));
    Renderer renderer(*context, shaders, scene, line.render);
    for (const std::string& warning : scene.warnings)
        Warn(warning);
    for (const SourceImage& image : scene.images) {
        if (!image.error.empty())
            Warn(image.label + ": " + image.error + ": grey in its place");
    }
    for (const TextureSetFile& file : scene.textureSets) {
        if (!file.error.empty())
            Warn(file.path + ": " + file.error + ": its materials show their source images");
    }
    RunRecord run;
    const std::chrono::duration<double> loaded = std::chrono::steady_clock::now() - start;
    run.loadSeconds = loaded.count();
    {
        openntc::tool::Progress progress("render", std::uint64_t(line.frames) * std::uint64_t(line.samples),
                                         false);
        for (int picture = 0; picture < line.frames; ++picture) {
            const Camera camera = ChooseCamera(scene, line, picture);
            for (int sample = 0; sample < line.samples; ++sample) {
                openntc::tool::ThrowIfInterrupted();
                run.frames.push_back(
                    renderer.Render(camera, static_cast<std::uint32_t>(sample), line.samples > 1));
                progress.Advance(1);
            }
        }
    }
    run.texels = renderer.TakeCounts();
    if (!line.output.empty())
        WritePicture(line.output, renderer.ReadPicture(), line.render.width, line.render.height);
    if (!line.stats.empty()) {
        const std::string text = MakeStats(line, scene, context->GetDevice(), renderer, shaders, run);
        openntc::tool::WriteWholeFile(line.stats, {std::as_bytes(std::span(text))});
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return openntc::tool::RunMain("ntc-renderer", [&] { return Run(argc, argv); });
}
