// SPDX-License-Identifier: MIT
// A window by GLFW.
#pragma once

#include "openntc/core/Expected.h"

#include <cstdint>
#include <string>
#include <vector>

struct GLFWwindow;
struct VkInstance_T;

namespace openntc::renderer {

/// The only one of the program. Throws CommandError(NoDevice) where there is no display.
class Window {
public:
    Window(const char* title, int width, int height);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /// Of Vulkan's instance, for a surface.
    std::vector<std::string> GetSurfaceExtensions() const;
    Expected<std::uint64_t> MakeSurface(VkInstance_T* instance) const;

    bool IsClosed() const;
    /// In pixels; 0 while it is minimised.
    int GetWidth() const { return width_; }
    int GetHeight() const { return height_; }
    /// Takes what has happened; waits for something at most so long.
    void Poll(double waitSeconds);
    /// Asks for a size in pixels and waits a while until the window has it.
    void SetSize(int width, int height);
    void Minimize();
    void Restore();

    GLFWwindow* GetHandle() const { return window_; }

private:
    GLFWwindow* window_ = nullptr;
    int width_ = 0, height_ = 0;
};

} // namespace openntc::renderer
