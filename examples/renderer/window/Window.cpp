// SPDX-License-Identifier: MIT
#include "renderer/window/Window.h"

#include "Failure.h"

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include <chrono>

namespace openntc::renderer {

namespace {

std::string GetReason() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text != nullptr ? text : "no reason given";
}

[[noreturn]] void FailWindow(const std::string& what) {
    const std::string text = what + ": " + GetReason() + ": ntc-renderer needs no window";
    glfwTerminate();
    throw tool::CommandError(tool::ExitCode::NoDevice, "window", text);
}

} // namespace

Window::Window(const char* title, int width, int height) {
    if (glfwInit() == GLFW_FALSE)
        FailWindow("display");
    if (glfwVulkanSupported() == GLFW_FALSE)
        FailWindow("Vulkan's surfaces");
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    window_ = glfwCreateWindow(width, height, title, nullptr, nullptr);
    if (window_ == nullptr)
        FailWindow("window");
    Poll(0.0);
}

Window::~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

std::vector<std::string> Window::GetSurfaceExtensions() const {
    std::uint32_t count = 0;
    const char** const names = glfwGetRequiredInstanceExtensions(&count);
    return {names, names + count};
}

Expected<std::uint64_t> Window::MakeSurface(VkInstance_T* instance) const {
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    if (glfwCreateWindowSurface(instance, window_, nullptr, &surface) != VK_SUCCESS)
        return Fail(Status::Unsupported, "device or feature absent: a surface of the window: %s",
                    GetReason().c_str());
    return (std::uint64_t)surface; // NOLINT: a pointer on some systems and a number on others
}

bool Window::IsClosed() const {
    return glfwWindowShouldClose(window_) != GLFW_FALSE;
}

void Window::Poll(double waitSeconds) {
    if (waitSeconds > 0.0)
        glfwWaitEventsTimeout(waitSeconds);
    else
        glfwPollEvents();
    glfwGetFramebufferSize(window_, &width_, &height_);
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED) != GLFW_FALSE)
        width_ = height_ = 0;
}

void Window::SetSize(int width, int height) {
    float scaleX = 1.0f, scaleY = 1.0f; // pixels of a screen coordinate
    int screenWidth = 0, screenHeight = 0;
    glfwGetWindowSize(window_, &screenWidth, &screenHeight);
    if (screenWidth > 0 && screenHeight > 0 && width_ > 0 && height_ > 0) {
        scaleX = static_cast<float>(width_) / static_cast<float>(screenWidth);
        scaleY = static_cast<float>(height_) / static_cast<float>(screenHeight);
    }
    glfwSetWindowSize(window_, static_cast<int>(static_cast<float>(width) / scaleX),
                      static_cast<int>(static_cast<float>(height) / scaleY));
    // The system does it when it likes, or not at all.
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    while ((width_ != width || height_ != height) && std::chrono::steady_clock::now() < end)
        Poll(0.05);
}

void Window::Minimize() {
    glfwIconifyWindow(window_);
}

void Window::Restore() {
    glfwRestoreWindow(window_);
}

} // namespace openntc::renderer
