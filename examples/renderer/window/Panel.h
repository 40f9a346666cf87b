// SPDX-License-Identifier: MIT
// The panel over the picture, by Dear ImGui, and what mouse and keys ask for.
#pragma once

#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/Renderer.h"
#include "renderer/scene/ViewCamera.h"

#include <string>
#include <vector>

struct GLFWwindow;

namespace openntc::renderer {

/// What the panel tells.
struct PanelFacts {
    std::string device;
    std::string message; ///< of the last thing that went wrong or was written; empty: none
    const Renderer* renderer = nullptr;
    PassSeconds seconds{}; ///< of the last frame
    TexelCounts texels;    ///< of the last frame, while they are counted
    int frames = 0;        ///< in the mean
    int width = 0;         ///< of the picture
    int height = 0;
    std::vector<std::string> cameras; ///< of the scene
};

/// What people ask for.
struct PanelRequests {
    CommandLine line; ///< options as they are to be
    int shrink = 1;   ///< pixels of the window for one of the picture, each way
    bool screenshot = false;
    bool orbit = false;       ///< the orbit camera, from the start
    bool firstPerson = false; ///< from where the camera is
    int camera = -1;          ///< of the scene; -1: none is asked for
    ViewMotion motion;
};

/// Dear ImGui on a device. One at a time. The context and the window must outlive it.
class Panel {
public:
    Panel(harness::Context& context, GLFWwindow* window);
    ~Panel();
    Panel(const Panel&) = delete;
    Panel& operator=(const Panel&) = delete;

    /// A frame: shows `facts`, changes `requests`. `seconds`: since the last one.
    void Build(const PanelFacts& facts, PanelRequests& requests, float seconds);
    /// Draws it over an image.
    void Draw(const harness::Image& target);

private:
    harness::Context& context_;
    harness::Overlay overlay_;
    bool isShown_ = true;
};

} // namespace openntc::renderer
