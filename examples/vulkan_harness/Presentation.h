// SPDX-License-Identifier: MIT
// Windows: images shown on a surface, and other libraries that draw over them with commands of their own.
#pragma once

#include "openntc/core/Expected.h"

#include <cstdint>
#include <functional>
#include <memory>

// Vulkan's own handles, without its headers.
struct VkInstance_T;
struct VkPhysicalDevice_T;
struct VkDevice_T;
struct VkQueue_T;
struct VkCommandBuffer_T;

namespace openntc::harness {

/// What other libraries need to make objects on a context's device. Handles that are no pointers on some systems are numbers.
struct NativeHandles {
    VkInstance_T* instance = nullptr;
    VkPhysicalDevice_T* physicalDevice = nullptr;
    VkDevice_T* device = nullptr;
    VkQueue_T* queue = nullptr;
    std::uint32_t queueFamily = 0;
};

using RecordCommands = std::function<void(VkCommandBuffer_T*)>;

/// A render pass for what is drawn over images of format RGBA8, with descriptors for it. The context must outlive it.
class Overlay {
public:
    struct Impl;
    Overlay() noexcept;
    explicit Overlay(std::unique_ptr<Impl> impl) noexcept;
    Overlay(Overlay&&) noexcept;
    Overlay& operator=(Overlay&&) noexcept;
    ~Overlay();

    std::uint64_t GetRenderPass() const noexcept;     ///< VkRenderPass; one subpass
    std::uint64_t GetDescriptorPool() const noexcept; ///< VkDescriptorPool of 16 combined image samplers
    const Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

/// Makes a VkSurfaceKHR for an instance.
using MakeSurface = std::function<Expected<std::uint64_t>(VkInstance_T*)>;

/// A window's surface with its images. The context must outlive it.
class Presenter {
public:
    struct Impl;
    Presenter() noexcept;
    explicit Presenter(std::unique_ptr<Impl> impl) noexcept;
    Presenter(Presenter&&) noexcept;
    Presenter& operator=(Presenter&&) noexcept;
    ~Presenter();

    Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

} // namespace openntc::harness
