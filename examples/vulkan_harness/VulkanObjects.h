// SPDX-License-Identifier: MIT
// The objects behind Vulkan.h, for the harness's own sources: Vulkan-Hpp takes several seconds to compile.
#pragma once

#include "Vulkan.h"

#define VULKAN_HPP_DISPATCH_LOADER_DYNAMIC 1
#define VULKAN_HPP_ENABLE_DYNAMIC_LOADER_TOOL 0 // its destructor and search order are ours to decide
#define VULKAN_HPP_NO_SPACESHIP_OPERATOR // this one and the next are not used, and take seconds to compile
#define VULKAN_HPP_NO_SMART_HANDLE
#include <vulkan/vulkan_raii.hpp>

#include <chrono>
#include <exception>
#include <optional>

namespace openntc::harness {

struct Instance {
    vk::raii::Context context;
    vk::raii::Instance instance = nullptr;
    vk::raii::DebugUtilsMessengerEXT messenger = nullptr;
    std::uint32_t apiVersion;

    explicit Instance(PFN_vkGetInstanceProcAddr loader) : context(loader), apiVersion(VK_API_VERSION_1_0) {}
};

/// With a log, the validation layer is on and writes into it.
Expected<std::unique_ptr<Instance>> MakeInstance(const std::string& loaderLibrary, ValidationLog* log,
                                                 const std::vector<std::string>& surfaceExtensions = {});

/// The version of Vulkan that a device can be used with: the lower one of its own and the instance's.
std::uint32_t GetUsableVersion(const Instance& instance, const vk::raii::PhysicalDevice& device);
FeatureSet GetFeatures(const vk::raii::PhysicalDevice& device, std::uint32_t version);
vk::DescriptorType GetDescriptorType(BufferKind kind);
vk::Format GetVulkanFormat(ImageFormat format);
vk::ImageAspectFlags GetAspect(ImageFormat format);
Expected<void> CheckRange(const Buffer& buffer, std::uint64_t offset, std::uint64_t bytes);
bool IsOfBlocks(ImageFormat format);
Expected<void> CheckMips(std::uint32_t width, std::uint32_t height, std::uint32_t mips);
/// Fills the members about cooperative vectors.
void DescribeCooperativeVectors(const vk::raii::Instance& instance, const vk::raii::PhysicalDevice& device,
                                DeviceInfo& info);
/// Fills the member about cooperative matrices; the subgroup size is known.
void DescribeCooperativeMatrices(const vk::raii::Instance& instance, const vk::raii::PhysicalDevice& device,
                                 DeviceInfo& info);
std::optional<std::uint32_t> FindComputeQueue(const vk::raii::PhysicalDevice& device);
DeviceInfo Describe(const Instance& instance, const vk::raii::PhysicalDevice& device, std::uint32_t index);

/// Devices of an instance. Having none at all is an empty list, whichever way the driver says it.
std::vector<vk::raii::PhysicalDevice> EnumerateDevices(const vk::raii::Instance& instance);

/// Index of the wanted device, by the rules of ContextOptions::device.
std::optional<std::size_t> ChooseDevice(const std::vector<vk::raii::PhysicalDevice>& devices,
                                        const std::string& wanted);

struct Buffer::Impl {
    // The memory is declared first, so that the buffer goes before it.
    vk::raii::DeviceMemory memory = nullptr;
    vk::raii::Buffer buffer = nullptr;
    std::uint64_t size = 0;
    std::uint64_t address = 0; // for shaders
    BufferKind kind = BufferKind::Storage;
    std::byte* mapped = nullptr;
};

struct Image::Impl {
    vk::raii::DeviceMemory memory = nullptr; // before the image, so that it goes after
    vk::raii::Image image = nullptr;
    vk::raii::ImageView view = nullptr; // of all mips, to be sampled
    std::vector<vk::raii::ImageView> mipViews;
    ImageFormat format = ImageFormat::RGBA8;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t mips = 1;
    std::uint32_t layers = 0; // 0: no array
};

struct ComputePipeline::Impl {
    vk::PipelineBindPoint bindPoint = vk::PipelineBindPoint::eCompute;
    vk::ShaderStageFlags stages = vk::ShaderStageFlagBits::eCompute;
    std::vector<vk::raii::DescriptorSetLayout> setLayouts;
    vk::raii::PipelineLayout layout = nullptr;
    vk::raii::Pipeline pipeline = nullptr;
    std::vector<std::uint32_t> code;
    std::vector<BufferSlot> slots;
    std::uint32_t pushConstantBytes = 0;
    double creationSeconds = 0;
    std::string statistics;
    vk::raii::RenderPass renderPass = nullptr; // of pipelines that draw: without attachments
    bool isRaster = false;
    RasterState raster;                        // of those that draw into images
    std::unique_ptr<Buffer::Impl> shaderTable; // of those that trace rays: one ray-generation shader
    vk::StridedDeviceAddressRegionKHR rayGeneration;
};

inline constexpr std::uint32_t kTimedBatch = 32; // dispatches of one submission

struct Context::Impl {
    std::shared_ptr<ValidationLog> log;
    bool validation = false;
    std::unique_ptr<Instance> instance;
    vk::raii::PhysicalDevice physicalDevice = nullptr;
    vk::PhysicalDeviceMemoryProperties memory;
    DeviceInfo info;
    std::uint32_t queueFamily = 0;
    vk::raii::Device device = nullptr;
    vk::raii::Queue queue = nullptr;
    vk::raii::CommandPool commandPool = nullptr;
    vk::raii::CommandBuffer commands = nullptr;
    vk::raii::Fence fence = nullptr;
    vk::raii::QueryPool queries = nullptr;
    vk::raii::DescriptorPool descriptorPool = nullptr;
    vk::raii::Sampler sampler = nullptr; ///< of filtered textures
    std::vector<std::shared_ptr<const ComputePipeline::Impl>> pipelines;
    std::unique_ptr<Buffer::Impl> staging; ///< of writes; null until the first
    DeviceFaults faults;
    std::uint64_t allocatedBytes = 0; ///< so far, whether or not freed
    std::uint32_t submissions = 0;

    /// Throws what Vulkan throws where memory is short.
    vk::raii::DeviceMemory Allocate(const vk::MemoryAllocateInfo& allocation);

    std::unique_ptr<Buffer::Impl> MakeBuffer(std::uint64_t bytes, BufferKind kind, vk::BufferUsageFlags usage,
                                             vk::MemoryPropertyFlags wanted);
    template <typename F>
    double Submit(F&& record);
    /// The kept pipeline of this code, or null.
    std::shared_ptr<const ComputePipeline::Impl> FindPipeline(vk::PipelineBindPoint bindPoint,
                                                              std::span<const std::uint32_t> code,
                                                              std::span<const BufferSlot> slots,
                                                              std::uint32_t pushConstantBytes) const;
    /// Code, slots and layouts, for the stages that `pipeline` has.
    Expected<void> FillLayout(ComputePipeline::Impl& pipeline, std::span<const std::uint32_t> spirv,
                              std::span<const BufferSlot> slots, std::uint32_t pushConstantBytes) const;
    vk::raii::ShaderModule MakeModule(std::span<const std::uint32_t> spirv) const;
    /// The request fits the pipeline and the device.
    Expected<void> CheckRequest(const DispatchRequest& request) const;
    Expected<void> CheckBindings(const DispatchRequest& request) const;
    Expected<void> CheckRequest(const RasterRequest& request) const;
    /// The device draws into images of such a format, and blends if it must.
    Expected<void> CheckRaster(const RasterState& state) const;
    vk::raii::Pipeline MakeRasterPipeline(const ComputePipeline::Impl& pipeline, vk::ShaderModule vertex,
                                          vk::ShaderModule fragment) const;
    /// Descriptor sets with the request's buffers, which CheckRequest has seen.
    std::vector<vk::raii::DescriptorSet> Bind(const DispatchRequest& request, vk::DescriptorPool pool);
    /// Binds pipeline, descriptors and push constants.
    void RecordState(const vk::raii::CommandBuffer& target, const DispatchRequest& request,
                     const std::vector<vk::raii::DescriptorSet>& sets) const;
    /// Seconds between pairs of timestamps; only the valid bits count.
    std::vector<double> GetSeconds(const vk::raii::QueryPool& pool, std::uint32_t pairs) const;
    /// Seconds between the first two timestamps of `queries`; empty without timestamp support.
    std::optional<double> GetGpuSeconds() const;
    /// As many descriptors as the requests bind.
    vk::raii::DescriptorPool MakePool(std::span<const DispatchRequest> requests) const;
    /// The device has images of the format, of such a size.
    Expected<void> CheckImage(ImageFormat format, std::uint32_t width, std::uint32_t height) const;
    /// Image, memory and views of what width, height, mips and layers say, in the general layout.
    void MakeImage(Image::Impl& image);
    void CopyToImage(vk::Buffer buffer, const Image::Impl& image, std::uint32_t mip);
    void Copy(vk::Buffer from, std::uint64_t fromOffset, vk::Buffer to, std::uint64_t toOffset,
              std::uint64_t bytes);
};

/// Records, submits and waits; returns wall-clock seconds from submission to completion.
template <typename F>
double Context::Impl::Submit(F&& record) {
    if (submissions++ >= faults.submissions)
        throw vk::DeviceLostError("as was asked for");
    commands.reset();
    commands.begin(vk::CommandBufferBeginInfo(vk::CommandBufferUsageFlagBits::eOneTimeSubmit));
    record(commands);
    commands.end();
    const auto start = std::chrono::steady_clock::now();
    const vk::CommandBuffer handle = *commands;
    queue.submit(vk::SubmitInfo({}, {}, handle), *fence);
    while (device.waitForFences(*fence, VK_TRUE, 1'000'000'000) == vk::Result::eTimeout) {
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    device.resetFences(*fence);
    return seconds;
}

/// Runs a function of Vulkan calls: exceptions and messages of the validation layer become its error.
template <typename F>
auto Context::Guard(const char* what, F&& function) -> decltype(function()) {
    const std::size_t before = impl_->log->errors.size();
    try {
        auto result = function();
        if (impl_->validation && impl_->log->errors.size() > before)
            return Fail(Status::InternalError, "%s: validation layer: %s", what,
                        impl_->log->errors[before].c_str());
        return result;
    } catch (const vk::OutOfDeviceMemoryError& error) {
        return Fail(Status::OutOfMemory, "%s: device memory: %s", what, error.what());
    } catch (const vk::OutOfHostMemoryError& error) {
        return Fail(Status::OutOfMemory, "%s: host memory: %s", what, error.what());
    } catch (const vk::DeviceLostError& error) {
        return Fail(Status::Unsupported, "%s: the device is lost: %s", what, error.what());
    } catch (const std::exception& error) {
        return Fail(Status::UnknownError, "%s: Vulkan: %s", what, error.what());
    }
}

/// Copies of buffers and images, after all that was written before and for all that comes after, the host included.
template <typename F>
void RecordCopies(const vk::raii::CommandBuffer& target, F&& record) {
    const vk::MemoryBarrier before(vk::AccessFlagBits::eMemoryWrite,
                                   vk::AccessFlagBits::eTransferRead | vk::AccessFlagBits::eTransferWrite);
    target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands, vk::PipelineStageFlagBits::eTransfer, {},
                           before, {}, {});
    record();
    const vk::MemoryBarrier after(vk::AccessFlagBits::eTransferWrite, vk::AccessFlagBits::eMemoryRead |
                                                                          vk::AccessFlagBits::eMemoryWrite |
                                                                          vk::AccessFlagBits::eHostRead);
    target.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer,
                           vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost, {},
                           after, {}, {});
}

} // namespace openntc::harness
