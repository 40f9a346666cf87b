// SPDX-License-Identifier: MIT
#include "renderer/window/Viewer.h"

#include "renderer/gpu/PictureFile.h"

#include "Failure.h"
#include "Interrupt.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace openntc::renderer {

namespace {

using tool::CommandError;
using tool::ExitCode;

constexpr float kDegree = 0.017453293f;
constexpr double kIdleSeconds = 0.1; // between looks at a window where nothing changes

CommandLine Prepare(const Scene& scene, CommandLine line) {
    ChooseMode(scene, line);
    ChooseCamera(scene, line); // a wrong name at once
    return line;
}

} // namespace

Viewer::Viewer(CommandLine line)
    : script_(line.play.empty() ? std::vector<PlayStep>() : ReadPlay(line.play)), scene_(LoadScene(line)),
      textureSets_(scene_.textureSets),
      window_(("ntc-viewer: " + scene_.name).c_str(), line.render.width, line.render.height),
      context_(OpenDevice(line, window_.GetSurfaceExtensions())), shaders_(MakeShaderCache(line)),
      view_(scene_.bounds), last_(std::chrono::steady_clock::now()) {
    line_ = Prepare(scene_, std::move(line));
    presenter_ = RequireDevice(
        context_->CreatePresenter([this](VkInstance_T* instance) { return window_.MakeSurface(instance); }));
    panel_.emplace(*context_, window_.GetHandle());
    facts_.device = context_->GetDevice().name;
    for (const Camera& camera : scene_.cameras)
        facts_.cameras.push_back(camera.name);
    SetCamera();
}

void Viewer::SetCamera() {
    const Camera camera = ChooseCamera(scene_, line_);
    if (line_.camera == "orbit" || (line_.camera.empty() && scene_.cameras.empty()))
        view_.SetOrbit(line_.azimuth * kDegree, line_.elevation * kDegree, line_.distance);
    else
        view_.SetFirstPerson(camera);
    frame_ = 0;
}

void Viewer::SetLine(const CommandLine& line) {
    CommandLine next = line;
    next.choosesMode = false;
    next = Prepare(scene_, std::move(next));
    const bool isMoved = std::tie(next.camera, next.azimuth, next.elevation, next.distance) !=
                         std::tie(line_.camera, line_.azimuth, line_.elevation, line_.distance);
    if (next.samples != line_.samples)
        frame_ = 0;
    line_ = std::move(next);
    if (isMoved)
        SetCamera();
}

void Viewer::RequireFrame() const {
    if (!renderer_ || canvas_.GetWidth() == 0)
        throw CommandError(ExitCode::BadInput, line_.play, "picture: none yet: let frames go by first");
}

void Viewer::TakeStep(const PlayStep& step) {
    switch (step.action) {
    case PlayAction::Options: {
        CommandLine line = line_;
        ApplyOptions(step.text, line);
        const int width = line.render.width, height = line.render.height;
        if (width != line_.render.width || height != line_.render.height)
            window_.SetSize(width * requests_.shrink, height * requests_.shrink);
        SetLine(line);
        break;
    }
    case PlayAction::Frames:
        framesToWait_ = step.frames;
        break;
    case PlayAction::Screenshot:
        WriteScreenshot(step.text);
        break;
    case PlayAction::Capture: {
        RequireFrame();
        std::vector<std::uint8_t> texels(canvas_.GetBytes());
        RequireDevice(context_->Read(canvas_, std::as_writable_bytes(std::span(texels))));
        WritePicture(step.text, texels, static_cast<int>(canvas_.GetWidth()),
                     static_cast<int>(canvas_.GetHeight()));
        break;
    }
    case PlayAction::Minimize:
        window_.Minimize();
        break;
    case PlayAction::Restore:
        window_.Restore();
        break;
    case PlayAction::Quit:
        isDone_ = true;
        break;
    }
}

void Viewer::RunScript() {
    while (framesToWait_ == 0 && nextStep_ < script_.size() && !isDone_)
        TakeStep(script_[nextStep_++]);
    if (framesToWait_ > 0)
        --framesToWait_;
}

bool Viewer::FitSize() {
    const auto width = static_cast<std::uint32_t>(window_.GetWidth()),
               height = static_cast<std::uint32_t>(window_.GetHeight());
    if (isStale_ || width != canvas_.GetWidth() || height != canvas_.GetHeight()) {
        RequireDevice(context_->Resize(presenter_, width, height));
        isStale_ = false;
    }
    if (width == 0 || height == 0)
        return false;
    if (width != canvas_.GetWidth() || height != canvas_.GetHeight())
        canvas_ = RequireDevice(context_->CreateImage(harness::ImageFormat::RGBA8, width, height));
    line_.render.width = std::max(window_.GetWidth() / requests_.shrink, 1);
    line_.render.height = std::max(window_.GetHeight() / requests_.shrink, 1);
    return true;
}

void Viewer::UpdateRenderer() {
    if (renderer_ && renderer_->GetOptions() == line_.render)
        return;
    frame_ = 0;
    if (!renderer_ || !renderer_->Apply(line_.render)) {
        renderer_.reset(); // its memory first
        scene_.textureSets = textureSets_;
        renderer_.emplace(*context_, shaders_, scene_, line_.render);
        if (!working_) // once
            PrintWarnings("ntc-viewer", scene_);
    }
    const auto width = static_cast<std::uint32_t>(line_.render.width),
               height = static_cast<std::uint32_t>(line_.render.height);
    if (picture_.GetWidth() != width || picture_.GetHeight() != height)
        picture_ = RequireDevice(context_->CreateImage(harness::ImageFormat::RGBA8, width, height));
    working_ = line_;
}

/// What people choose and cannot be had is told; what a script or the command line asks for must work.
void Viewer::Recover(const CommandError& error) {
    if (!working_ || nextStep_ < script_.size() || error.GetCode() != ExitCode::BadInput)
        throw error;
    facts_.message = error.GetSubject() + ": " + error.what();
    line_ = *working_;
    renderer_.reset();
}

void Viewer::RenderFrame() {
    if (frame_ >= line_.samples)
        return;
    facts_.seconds = renderer_->Render(view_.Get(), static_cast<std::uint32_t>(frame_), line_.samples > 1);
    frame_ = renderer_->IsSettled() ? frame_ + 1 : 0; // while tiles come, frames are not worth keeping
    if (line_.render.counts)
        facts_.texels = renderer_->TakeCounts();
    RequireDevice(context_->Copy(renderer_->GetPixels(), picture_, 0));
}

void Viewer::WriteScreenshot(const std::string& path) {
    RequireFrame();
    WritePicture(path, renderer_->ReadPicture(), line_.render.width, line_.render.height);
    facts_.message = path + " is written";
}

void Viewer::BuildPanel() {
    const auto now = std::chrono::steady_clock::now();
    const float seconds = std::chrono::duration<float>(now - std::exchange(last_, now)).count();
    facts_.renderer = &*renderer_;
    facts_.frames = frame_;
    facts_.width = line_.render.width;
    facts_.height = line_.render.height;
    requests_.line = line_;
    requests_.camera = -1;
    panel_->Build(facts_, requests_, seconds);
}

void Viewer::Show() {
    RequireDevice(context_->Scale(picture_, canvas_));
    panel_->Draw(canvas_);
    isStale_ = !RequireDevice(context_->Present(presenter_, canvas_));
}

void Viewer::TakeRequests() {
    if (requests_.screenshot)
        WriteScreenshot(line_.output);
    const Camera camera = view_.Get();
    if (requests_.orbit) {
        view_ = ViewCamera(scene_.bounds); // round its middle again
        view_.SetOrbit(line_.azimuth * kDegree, line_.elevation * kDegree, line_.distance);
    } else if (requests_.firstPerson) {
        view_.SetFirstPerson(camera);
    } else if (requests_.camera >= 0) {
        view_.SetFirstPerson(scene_.cameras[static_cast<std::size_t>(requests_.camera)]);
    }
    const bool isMoved = view_.Move(requests_.motion);
    if (isMoved || requests_.orbit || requests_.camera >= 0)
        frame_ = 0;
    try {
        SetLine(requests_.line);
    } catch (const CommandError& error) {
        Recover(error);
    }
}

void Viewer::CheckValidation() const {
    const harness::ValidationLog& log = context_->GetValidationLog();
    if (line_.debug && !log.errors.empty())
        throw CommandError(ExitCode::Failed, "vulkan", "validation layer: " + log.errors.front());
}

void Viewer::Run() {
    while (!window_.IsClosed() && !isDone_) {
        tool::ThrowIfInterrupted();
        const bool isIdle = framesToWait_ == 0 && nextStep_ >= script_.size() &&
                            (window_.GetWidth() == 0 || (renderer_ && frame_ >= line_.samples));
        window_.Poll(isIdle ? kIdleSeconds : 0.0);
        RunScript();
        if (isDone_ || !FitSize())
            continue;
        try {
            UpdateRenderer();
        } catch (const CommandError& error) {
            Recover(error);
            continue;
        }
        RenderFrame();
        BuildPanel();
        Show();
        TakeRequests();
    }
    CheckValidation();
}

} // namespace openntc::renderer
