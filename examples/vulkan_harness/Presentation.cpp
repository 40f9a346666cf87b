// SPDX-License-Identifier: MIT
// Swapchains without semaphores: the harness waits for everything that it submits.
#include "VulkanObjects.h"

#include <algorithm>
#include <array>
#include <limits>

namespace openntc::harness {

struct Overlay::Impl {
    vk::raii::RenderPass pass = nullptr;
    vk::raii::DescriptorPool descriptors = nullptr;
};

struct Presenter::Impl {
    vk::raii::SurfaceKHR surface = nullptr;
    vk::SurfaceFormatKHR format;
    vk::Extent2D size; // of the swapchain; 0: there is none
    vk::raii::SwapchainKHR swapchain = nullptr;
    std::vector<vk::Image> images;
};

Overlay::Overlay() noexcept = default;
Overlay::Overlay(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Overlay::Overlay(Overlay&&) noexcept = default;
Overlay& Overlay::operator=(Overlay&&) noexcept = default;
Overlay::~Overlay() = default;
Presenter::Presenter() noexcept = default;
Presenter::Presenter(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Presenter::Presenter(Presenter&&) noexcept = default;
Presenter& Presenter::operator=(Presenter&&) noexcept = default;
Presenter::~Presenter() = default;

namespace {

/// A handle that is a pointer on some systems and a number on others.
template <typename Handle>
std::uint64_t ToNumber(Handle handle) {
    return (std::uint64_t)(static_cast<typename Handle::CType>(handle)); // NOLINT: whichever it is
}

const vk::ImageSubresourceRange kWholeColor(vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1);

/// What was written before is seen by what follows.
void Order(const vk::raii::CommandBuffer& commands) {
    const vk::MemoryBarrier order(vk::AccessFlagBits::eMemoryWrite,
                                  vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
    commands.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands, vk::PipelineStageFlagBits::eAllCommands,
                             {}, order, {}, {});
}

void Turn(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageLayout from,
          vk::ImageLayout to) {
    const vk::ImageMemoryBarrier barrier(
        vk::AccessFlagBits::eMemoryWrite, vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite,
        from, to, VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED, image, kWholeColor);
    commands.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands, vk::PipelineStageFlagBits::eAllCommands,
                             {}, {}, {}, barrier);
}

void Blit(const vk::raii::CommandBuffer& commands, const Image::Impl& from, vk::Image to, vk::Extent2D size,
          vk::ImageLayout layout) {
    const vk::ImageSubresourceLayers layers(vk::ImageAspectFlagBits::eColor, 0, 0, 1);
    const auto corner = [](std::uint32_t width, std::uint32_t height) {
        return vk::Offset3D(static_cast<std::int32_t>(width), static_cast<std::int32_t>(height), 1);
    };
    const bool isSame = from.width == size.width && from.height == size.height;
    const vk::ImageBlit blit(layers, {vk::Offset3D(), corner(from.width, from.height)}, layers,
                             {vk::Offset3D(), corner(size.width, size.height)});
    commands.blitImage(*from.image, vk::ImageLayout::eGeneral, to, layout, blit,
                       isSame ? vk::Filter::eNearest : vk::Filter::eLinear);
}

} // namespace

std::uint64_t Overlay::GetRenderPass() const noexcept {
    return ToNumber(*impl_->pass);
}
std::uint64_t Overlay::GetDescriptorPool() const noexcept {
    return ToNumber(*impl_->descriptors);
}

NativeHandles Context::GetHandles() const noexcept {
    return {static_cast<VkInstance>(*impl_->instance->instance),
            static_cast<VkPhysicalDevice>(*impl_->physicalDevice), static_cast<VkDevice>(*impl_->device),
            static_cast<VkQueue>(*impl_->queue), impl_->queueFamily};
}

Expected<void> Context::Record(const RecordCommands& record) {
    return Guard("commands", [&]() -> Expected<void> {
        impl_->Submit([&](const vk::raii::CommandBuffer& commands) {
            record(static_cast<VkCommandBuffer>(*commands));
        });
        return {};
    });
}

Expected<Overlay> Context::CreateOverlay() {
    RasterState state;
    state.color = ImageFormat::RGBA8;
    state.blends = true;
    OPENNTC_CHECK(impl_->CheckRaster(state));
    return Guard("overlay", [&]() -> Expected<Overlay> {
        auto overlay = std::make_unique<Overlay::Impl>();
        const vk::AttachmentDescription color(
            {}, GetVulkanFormat(ImageFormat::RGBA8), vk::SampleCountFlagBits::e1, vk::AttachmentLoadOp::eLoad,
            vk::AttachmentStoreOp::eStore, vk::AttachmentLoadOp::eDontCare, vk::AttachmentStoreOp::eDontCare,
            vk::ImageLayout::eGeneral, vk::ImageLayout::eGeneral);
        const vk::AttachmentReference reference(0, vk::ImageLayout::eGeneral);
        const vk::SubpassDescription subpass({}, vk::PipelineBindPoint::eGraphics, {}, reference);
        overlay->pass = vk::raii::RenderPass(impl_->device, vk::RenderPassCreateInfo({}, color, subpass));
        const vk::DescriptorPoolSize size(vk::DescriptorType::eCombinedImageSampler, 16);
        overlay->descriptors = vk::raii::DescriptorPool(
            impl_->device,
            vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 16, size));
        return Overlay(std::move(overlay));
    });
}

Expected<void> Context::Draw(const Overlay& overlay, const Image& target, const RecordCommands& record) {
    if (overlay.GetImpl() == nullptr || target.GetImpl() == nullptr ||
        target.GetImpl()->format != ImageFormat::RGBA8)
        return Fail(Status::InvalidArgument, "overlay: image: must be of format RGBA8");
    return Guard("overlay", [&]() -> Expected<void> {
        const vk::ImageView view = *target.GetImpl()->mipViews.front();
        const vk::raii::Framebuffer frame(
            impl_->device, vk::FramebufferCreateInfo({}, *overlay.GetImpl()->pass, view, target.GetWidth(),
                                                     target.GetHeight(), 1));
        impl_->Submit([&](const vk::raii::CommandBuffer& commands) {
            Order(commands);
            commands.beginRenderPass(
                vk::RenderPassBeginInfo(*overlay.GetImpl()->pass, *frame,
                                        vk::Rect2D({0, 0}, {target.GetWidth(), target.GetHeight()})),
                vk::SubpassContents::eInline);
            record(static_cast<VkCommandBuffer>(*commands));
            commands.endRenderPass();
            Order(commands);
        });
        return {};
    });
}

Expected<void> Context::Scale(const Image& from, const Image& to) {
    if (from.GetImpl() == nullptr || to.GetImpl() == nullptr)
        return Fail(Status::InvalidArgument, "scale: images: none");
    return Guard("scale", [&]() -> Expected<void> {
        impl_->Submit([&](const vk::raii::CommandBuffer& commands) {
            Order(commands);
            Blit(commands, *from.GetImpl(), *to.GetImpl()->image, {to.GetWidth(), to.GetHeight()},
                 vk::ImageLayout::eGeneral);
            Order(commands);
        });
        return {};
    });
}

Expected<Presenter> Context::CreatePresenter(const MakeSurface& makeSurface) {
    const FeatureSet& features = impl_->info.features;
    if (!features.Has(Feature::Swapchain))
        return Fail(Status::Unsupported, "device or feature absent: %s: %s",
                    GetFeatureName(Feature::Swapchain), features.GetAbsence(Feature::Swapchain).c_str());
    OPENNTC_ASSIGN(const std::uint64_t surface,
                   makeSurface(static_cast<VkInstance>(*impl_->instance->instance)));
    return Guard("window", [&]() -> Expected<Presenter> {
        auto presenter = std::make_unique<Presenter::Impl>();
        presenter->surface =
            vk::raii::SurfaceKHR(impl_->instance->instance, (VkSurfaceKHR)surface); // NOLINT: as ToNumber
        if (!impl_->physicalDevice.getSurfaceSupportKHR(impl_->queueFamily, *presenter->surface))
            return Fail(Status::Unsupported, "device or feature absent: a queue that presents: %s",
                        impl_->info.name.c_str());
        for (const vk::SurfaceFormatKHR& format :
             impl_->physicalDevice.getSurfaceFormatsKHR(*presenter->surface)) {
            // What is copied is encoded already.
            if (format.format != vk::Format::eB8G8R8A8Unorm && format.format != vk::Format::eR8G8B8A8Unorm)
                continue;
            presenter->format = format;
            return Presenter(std::move(presenter));
        }
        return Fail(Status::Unsupported, "device or feature absent: surfaces of 8 bits a channel: %s",
                    impl_->info.name.c_str());
    });
}

Expected<void> Context::Resize(Presenter& presenter, std::uint32_t width, std::uint32_t height) {
    return Guard("window", [&]() -> Expected<void> {
        Presenter::Impl& impl = *presenter.GetImpl();
        const vk::SurfaceCapabilitiesKHR can = impl_->physicalDevice.getSurfaceCapabilitiesKHR(*impl.surface);
        constexpr std::uint32_t kAny = std::numeric_limits<std::uint32_t>::max();
        impl.size = can.currentExtent.width != kAny
                        ? can.currentExtent
                        : vk::Extent2D(std::min(width, can.maxImageExtent.width),
                                       std::min(height, can.maxImageExtent.height));
        impl.images.clear();
        if (width == 0 || height == 0 || impl.size.width == 0 || impl.size.height == 0) {
            impl.size = vk::Extent2D();
            impl.swapchain = nullptr;
            return {};
        }
        if (!(can.supportedUsageFlags & vk::ImageUsageFlagBits::eTransferDst))
            return Fail(Status::Unsupported, "device or feature absent: surfaces that are copied to: %s",
                        impl_->info.name.c_str());
        vk::SwapchainCreateInfoKHR create;
        create.surface = *impl.surface;
        create.minImageCount = std::max(can.minImageCount, 2u);
        if (can.maxImageCount != 0)
            create.minImageCount = std::min(create.minImageCount, can.maxImageCount);
        create.imageFormat = impl.format.format;
        create.imageColorSpace = impl.format.colorSpace;
        create.imageExtent = impl.size;
        create.imageArrayLayers = 1;
        create.imageUsage = vk::ImageUsageFlagBits::eTransferDst;
        create.preTransform = can.currentTransform;
        create.compositeAlpha = can.supportedCompositeAlpha & vk::CompositeAlphaFlagBitsKHR::eOpaque
                                    ? vk::CompositeAlphaFlagBitsKHR::eOpaque
                                    : vk::CompositeAlphaFlagBitsKHR::eInherit;
        create.presentMode = vk::PresentModeKHR::eFifo; // what every device has
        create.clipped = VK_TRUE;
        const vk::raii::SwapchainKHR old = std::move(impl.swapchain);
        create.oldSwapchain = *old;
        impl_->device.waitIdle(); // what is still being shown of the old one
        impl.swapchain = vk::raii::SwapchainKHR(impl_->device, create);
        for (const auto image : impl.swapchain.getImages())
            impl.images.emplace_back(image);
        return {};
    });
}

Expected<bool> Context::Present(Presenter& presenter, const Image& image) {
    Presenter::Impl& impl = *presenter.GetImpl();
    if (impl.size.width == 0 || image.GetImpl() == nullptr)
        return false;
    return Guard("window", [&]() -> Expected<bool> {
        try {
            const auto [acquired, index] = impl.swapchain.acquireNextImage(
                std::numeric_limits<std::uint64_t>::max(), vk::Semaphore(), *impl_->fence);
            while (impl_->device.waitForFences(*impl_->fence, VK_TRUE, 1'000'000'000) ==
                   vk::Result::eTimeout) {
            }
            impl_->device.resetFences(*impl_->fence);
            const vk::Image target = impl.images[index];
            impl_->Submit([&](const vk::raii::CommandBuffer& commands) {
                Order(commands);
                Turn(commands, target, vk::ImageLayout::eUndefined, vk::ImageLayout::eTransferDstOptimal);
                Blit(commands, *image.GetImpl(), target, impl.size, vk::ImageLayout::eTransferDstOptimal);
                Turn(commands, target, vk::ImageLayout::eTransferDstOptimal, vk::ImageLayout::ePresentSrcKHR);
            });
            const vk::SwapchainKHR swapchain = *impl.swapchain;
            const vk::Result presented = impl_->queue.presentKHR(vk::PresentInfoKHR({}, swapchain, index));
            return acquired == vk::Result::eSuccess && presented == vk::Result::eSuccess;
        } catch (const vk::OutOfDateKHRError&) {
            return false;
        }
    });
}

} // namespace openntc::harness
