// SPDX-License-Identifier: MIT
// `ntc-renderer`: a glTF model with neural materials, rendered without a window to a picture.
#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/PictureFile.h"
#include "renderer/gpu/Renderer.h"
#include "renderer/gpu/Session.h"
#include "renderer/gpu/Stats.h"

#include "Interrupt.h"
#include "Progress.h"
#include "RunMain.h"
#include "encode/StateFile.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using namespace openntc::renderer;
using openntc::tool::CommandError;
using openntc::tool::ExitCode;

constexpr const char* kWindow = "--window";

/// The program with a window, in the place of this one: the same arguments but for --window.
[[noreturn]] void StartViewer(int argc, char** argv) {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path() / "ntc-viewer";
    const std::string name = program.string();
    std::vector<char*> arguments;
    for (int i = 0; i < argc; ++i) {
        if (std::strcmp(argv[i], kWindow) != 0)
            arguments.push_back(argv[i]);
    }
    arguments.push_back(nullptr);
    execv(name.c_str(), arguments.data());
    throw CommandError(ExitCode::NoDevice, kWindow,
                       name + ": cannot be started: it is built where GLFW and Dear ImGui are");
}

/// The first frame again for a while, which changes no picture: a GPU raises its clock when it has something to do. What
/// was counted before.
TexelCounts WarmUp(Renderer& renderer, const Camera& camera, const CommandLine& line) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(line.warmUp);
    const TexelCounts counts = renderer.TakeCounts();
    do {
        openntc::tool::ThrowIfInterrupted();
        renderer.Render(camera, 0, line.samples > 1);
    } while (std::chrono::steady_clock::now() < end);
    renderer.TakeCounts();
    return counts;
}

int Run(int argc, char** argv) {
    if (std::any_of(argv + 1, argv + argc, [](const char* text) { return std::strcmp(text, kWindow) == 0; }))
        StartViewer(argc, argv);
    CommandLine line;
    if (!ParseCommandLine(argc, argv, line))
        return 0;
    Scene scene = LoadScene(line);
    ChooseMode(scene, line);
    ChooseCamera(scene, line); // a wrong name at once

    const auto start = std::chrono::steady_clock::now();
    const auto context = OpenDevice(line);
    ShaderCache shaders = MakeShaderCache(line);
    Renderer renderer(*context, shaders, scene, line.render);
    PrintWarnings("ntc-renderer", scene);
    RunRecord run;
    const std::chrono::duration<double> loaded = std::chrono::steady_clock::now() - start;
    run.loadSeconds = loaded.count();
    {
        openntc::tool::Progress progress("render", std::uint64_t(line.frames) * std::uint64_t(line.samples),
                                         false);
        for (int picture = 0; picture < line.frames; ++picture) {
            const Camera camera = ChooseCamera(
                scene, line, 360.0f * static_cast<float>(picture) / static_cast<float>(line.frames));
            for (int sample = 0; sample < line.samples; ++sample) {
                openntc::tool::ThrowIfInterrupted();
                run.frames.push_back(
                    renderer.Render(camera, static_cast<std::uint32_t>(sample), line.samples > 1));
                if (line.warmUp > 0 && run.frames.size() == 1)
                    run.texels = WarmUp(renderer, camera, line);
                progress.Advance(1);
            }
        }
    }
    const TexelCounts counts = renderer.TakeCounts();
    run.texels.read += counts.read;
    run.texels.decoded += counts.decoded;
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
