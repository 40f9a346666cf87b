// SPDX-License-Identifier: MIT
// The program with a window: a scene, rendered again and again as mouse, panel and script ask.
#pragma once

#include "renderer/gpu/Play.h"
#include "renderer/gpu/Session.h"
#include "renderer/window/Panel.h"
#include "renderer/window/Window.h"

#include "Failure.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace openntc::renderer {

class Viewer {
public:
    /// Opens window, device and panel. Throws CommandError.
    explicit Viewer(CommandLine line);

    /// Until the window is closed or the script says so. Throws CommandError.
    void Run();

private:
    void RunScript();
    void TakeStep(const PlayStep& step);
    void RequireFrame() const;
    void SetLine(const CommandLine& line);
    void SetCamera();
    bool FitSize();
    void UpdateRenderer();
    void Recover(const tool::CommandError& error);
    void RenderFrame();
    void BuildPanel();
    void Show();
    void TakeRequests();
    void WriteScreenshot(const std::string& path);
    void CheckValidation() const;

    CommandLine line_;                   ///< what is asked for
    std::optional<CommandLine> working_; ///< the last of which a renderer could be made
    std::vector<PlayStep> script_;
    std::size_t nextStep_ = 0;
    int framesToWait_ = 0;
    bool isDone_ = false;
    Scene scene_;
    std::vector<TextureSetFile> textureSets_; ///< as they were before any use
    Window window_;
    std::unique_ptr<harness::Context> context_;
    harness::Presenter presenter_;
    ShaderCache shaders_;
    std::optional<Renderer> renderer_;
    std::optional<Panel> panel_;
    ViewCamera view_;
    PanelFacts facts_;
    PanelRequests requests_;
    harness::Image picture_; ///< of the renderer's size
    harness::Image canvas_;  ///< of the window's
    int frame_ = 0;          ///< in the mean so far
    bool isStale_ = true;    ///< the surface has changed
    std::chrono::steady_clock::time_point last_;
};

} // namespace openntc::renderer
