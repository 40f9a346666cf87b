// SPDX-License-Identifier: MIT
// The only file that includes Vulkan-Hpp: it takes several seconds to compile.
#include "Vulkan.h"

#define VULKAN_HPP_DISPATCH_LOADER_DYNAMIC 1
#define VULKAN_HPP_ENABLE_DYNAMIC_LOADER_TOOL 0 // its destructor and search order are ours to decide
#define VULKAN_HPP_NO_SPACESHIP_OPERATOR
#include <vulkan/vulkan_raii.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string_view>
#include <type_traits>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace openntc::harness {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

/// The Vulkan loader. It is never closed: drivers leave threads and exit handlers behind in it.
PFN_vkGetInstanceProcAddr OpenLoader(const std::string& library) {
#if defined(_WIN32)
    const HMODULE module = LoadLibraryA(library.empty() ? "vulkan-1.dll" : library.c_str());
    if (module == nullptr)
        return nullptr;
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(
        reinterpret_cast<void*>(GetProcAddress(module, "vkGetInstanceProcAddr")));
#else
    void* module = nullptr;
    if (!library.empty()) {
        module = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    } else {
        for (const char* name : {"libvulkan.so.1", "libvulkan.so"}) {
            if (module == nullptr)
                module = dlopen(name, RTLD_NOW | RTLD_LOCAL);
        }
    }
    if (module == nullptr)
        return nullptr;
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(module, "vkGetInstanceProcAddr"));
#endif
}

VKAPI_ATTR VkBool32 VKAPI_CALL OnMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    ValidationLog& log = *static_cast<ValidationLog*>(user);
    try {
        const std::string text = data->pMessage != nullptr ? data->pMessage : "(no text)";
        if ((severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT) != 0)
            log.errors.push_back(text);
        else
            log.warnings.push_back(text);
    } catch (const std::exception&) {
        std::abort(); // no memory left to keep the message, and it must not be lost
    }
    return VK_FALSE;
}

struct Instance {
    vk::raii::Context context;
    vk::raii::Instance instance = nullptr;
    vk::raii::DebugUtilsMessengerEXT messenger = nullptr;
    std::uint32_t apiVersion;

    explicit Instance(PFN_vkGetInstanceProcAddr loader) : context(loader), apiVersion(VK_API_VERSION_1_0) {}
};

bool HasName(const std::vector<vk::ExtensionProperties>& list, const char* name) {
    return std::any_of(list.begin(), list.end(),
                       [name](const auto& item) { return std::strcmp(item.extensionName, name) == 0; });
}

Expected<std::unique_ptr<Instance>> MakeInstance(const std::string& loaderLibrary, ValidationLog* log) {
    const PFN_vkGetInstanceProcAddr loader = OpenLoader(loaderLibrary);
    if (loader == nullptr) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan loader %s: cannot be opened",
                    loaderLibrary.empty() ? "(system)" : loaderLibrary.c_str());
    }
    auto result = std::make_unique<Instance>(loader);
    result->apiVersion = result->context.enumerateInstanceVersion();
    if (result->apiVersion < VK_API_VERSION_1_1)
        return Fail(Status::Unsupported, "device or feature absent: Vulkan 1.1: the loader offers 1.0 only");

    const vk::ApplicationInfo application("openntc", 1, "openntc", 1,
                                          std::min<std::uint32_t>(result->apiVersion, VK_API_VERSION_1_3));
    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    vk::DebugUtilsMessengerCreateInfoEXT messages(
        {},
        vk::DebugUtilsMessageSeverityFlagBitsEXT::eError | vk::DebugUtilsMessageSeverityFlagBitsEXT::eWarning,
        vk::DebugUtilsMessageTypeFlagBitsEXT::eValidation | vk::DebugUtilsMessageTypeFlagBitsEXT::eGeneral,
        OnMessage, log);
    vk::InstanceCreateInfo info({}, &application);
    if (log != nullptr) {
        const auto available = result->context.enumerateInstanceLayerProperties();
        const bool found = std::any_of(available.begin(), available.end(), [](const auto& layer) {
            return std::strcmp(layer.layerName, kValidationLayer) == 0;
        });
        if (!found)
            return Fail(Status::Unsupported, "device or feature absent: %s: layer not installed",
                        kValidationLayer);
        const std::string layerName = kValidationLayer;
        if (!HasName(result->context.enumerateInstanceExtensionProperties(layerName),
                     VK_EXT_DEBUG_UTILS_EXTENSION_NAME) &&
            !HasName(result->context.enumerateInstanceExtensionProperties(),
                     VK_EXT_DEBUG_UTILS_EXTENSION_NAME))
            return Fail(Status::Unsupported,
                        "device or feature absent: VK_EXT_debug_utils: needed for validation");
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        info.setPNext(&messages);
    }
    info.setPEnabledLayerNames(layers);
    info.setPEnabledExtensionNames(extensions);
    result->instance = vk::raii::Instance(result->context, info);
    if (log != nullptr)
        result->messenger = vk::raii::DebugUtilsMessengerEXT(result->instance, messages);
    return result;
}

std::optional<std::uint32_t> FindComputeQueue(const vk::raii::PhysicalDevice& device) {
    const auto families = device.getQueueFamilyProperties();
    for (std::uint32_t i = 0; i < families.size(); ++i) {
        if (families[i].queueFlags & vk::QueueFlagBits::eCompute)
            return i;
    }
    return std::nullopt;
}

/// Optional features of a device, gathered so that only those it has are asked for.
struct Features {
    bool integerDotProduct = false;
    bool maintenance4 = false;
    bool float16 = false;
    bool bufferDeviceAddress = false;
    bool bufferArrays = false;
    bool nonUniformIndexing = false;

    bool HasCore12() const { return float16 || bufferDeviceAddress || nonUniformIndexing; }
    bool HasCore13() const { return integerDotProduct || maintenance4; }
};

Features GetFeatures(const vk::raii::PhysicalDevice& device) {
    Features features;
    features.bufferArrays = device.getFeatures().shaderStorageBufferArrayDynamicIndexing == VK_TRUE;
    if (device.getProperties().apiVersion >= VK_API_VERSION_1_3) {
        const auto chain =
            device.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                                vk::PhysicalDeviceVulkan13Features>();
        const auto& core12 = chain.get<vk::PhysicalDeviceVulkan12Features>();
        features.float16 = core12.shaderFloat16 == VK_TRUE;
        features.bufferDeviceAddress = core12.bufferDeviceAddress == VK_TRUE;
        features.nonUniformIndexing =
            core12.shaderStorageBufferArrayNonUniformIndexing == VK_TRUE && features.bufferArrays;
        const auto& core = chain.get<vk::PhysicalDeviceVulkan13Features>();
        features.integerDotProduct = core.shaderIntegerDotProduct == VK_TRUE;
        features.maintenance4 = core.maintenance4 == VK_TRUE;
    }
    return features;
}

DeviceInfo Describe(const vk::raii::PhysicalDevice& device, std::uint32_t index) {
    const vk::PhysicalDeviceProperties properties = device.getProperties();
    DeviceInfo info;
    info.index = index;
    info.name = properties.deviceName.data();
    info.apiVersion = properties.apiVersion;
    info.isCpu = properties.deviceType == vk::PhysicalDeviceType::eCpu;
    if (properties.apiVersion >= VK_API_VERSION_1_2) {
        const auto chain =
            device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties,
                                  vk::PhysicalDeviceSubgroupProperties,
                                  vk::PhysicalDeviceFloatControlsProperties>();
        const auto& controls = chain.get<vk::PhysicalDeviceFloatControlsProperties>();
        info.hasDenormPreserve = controls.shaderDenormPreserveFloat32 == VK_TRUE;
        info.hasDenormFlushToZero = controls.shaderDenormFlushToZeroFloat32 == VK_TRUE;
        info.hasSignedZeroInfNanPreserve = controls.shaderSignedZeroInfNanPreserveFloat32 == VK_TRUE;
        info.hasRoundToNearestEven = controls.shaderRoundingModeRTEFloat32 == VK_TRUE;
        info.hasRoundTowardZero = controls.shaderRoundingModeRTZFloat32 == VK_TRUE;
        const auto& subgroups = chain.get<vk::PhysicalDeviceSubgroupProperties>();
        info.subgroupSize = subgroups.subgroupSize;
        info.hasSubgroupShuffle = (subgroups.supportedOperations & vk::SubgroupFeatureFlagBits::eShuffle) &&
                                  (subgroups.supportedStages & vk::ShaderStageFlagBits::eCompute);
        const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
        info.driver = std::string(driver.driverName.data()) + " " + driver.driverInfo.data();
    }
    const Features features = GetFeatures(device);
    info.hasIntegerDotProduct = features.integerDotProduct;
    info.hasFloat16 = features.float16;
    info.hasBufferDeviceAddress = features.bufferDeviceAddress;
    info.hasBufferArrays = features.bufferArrays;
    info.hasNonUniformIndexing = features.nonUniformIndexing;
    if (const auto family = FindComputeQueue(device)) {
        info.timestampValidBits = device.getQueueFamilyProperties()[*family].timestampValidBits;
        info.timestampPeriodNanoseconds = static_cast<double>(properties.limits.timestampPeriod);
        info.hasTimestamps = info.timestampValidBits > 0 && info.timestampPeriodNanoseconds > 0;
    }
    info.maxStorageBufferBytes = properties.limits.maxStorageBufferRange;
    info.maxUniformBufferBytes = properties.limits.maxUniformBufferRange;
    info.maxPushConstantBytes = properties.limits.maxPushConstantsSize;
    std::copy_n(properties.limits.maxComputeWorkGroupCount.begin(), 3, info.maxWorkgroupCount);
    return info;
}

/// Devices of an instance. Having none at all is an empty list, whichever way the driver says it.
std::vector<vk::raii::PhysicalDevice> EnumerateDevices(const vk::raii::Instance& instance) {
    try {
        vk::raii::PhysicalDevices found(instance);
        std::vector<vk::raii::PhysicalDevice> devices;
        for (auto& device : found)
            devices.push_back(std::move(device));
        return devices;
    } catch (const vk::InitializationFailedError&) {
        return {};
    }
}

int GetPreference(vk::PhysicalDeviceType type) {
    switch (type) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
        return 4;
    case vk::PhysicalDeviceType::eIntegratedGpu:
        return 3;
    case vk::PhysicalDeviceType::eVirtualGpu:
        return 2;
    case vk::PhysicalDeviceType::eCpu:
        return 1;
    case vk::PhysicalDeviceType::eOther:
        break;
    }
    return 0;
}

/// Index of the wanted device, by the rules of ContextOptions::device.
std::optional<std::size_t> ChooseDevice(const std::vector<vk::raii::PhysicalDevice>& devices,
                                        const std::string& wanted) {
    std::optional<std::size_t> best;
    if (!wanted.empty() &&
        std::all_of(wanted.begin(), wanted.end(), [](char c) { return c >= '0' && c <= '9'; })) {
        const unsigned long index = std::strtoul(wanted.c_str(), nullptr, 10);
        if (index < devices.size())
            best = index;
        return best;
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const vk::PhysicalDeviceProperties properties = devices[i].getProperties();
        if (!wanted.empty()) {
            if (std::string_view(properties.deviceName.data()).find(wanted) != std::string_view::npos)
                return i;
        } else if (!best || GetPreference(properties.deviceType) >
                                GetPreference(devices[*best].getProperties().deviceType)) {
            best = i;
        }
    }
    return best;
}

std::optional<std::uint32_t> FindMemoryType(const vk::PhysicalDeviceMemoryProperties& memory,
                                            std::uint32_t allowed, vk::MemoryPropertyFlags wanted) {
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        if ((allowed >> i & 1u) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted)
            return i;
    }
    return std::nullopt;
}

vk::DescriptorType GetDescriptorType(BufferKind kind) {
    return kind == BufferKind::Uniform ? vk::DescriptorType::eUniformBuffer
                                       : vk::DescriptorType::eStorageBuffer;
}

} // namespace

struct Buffer::Impl {
    // The memory is declared first, so that the buffer goes before it.
    vk::raii::DeviceMemory memory = nullptr;
    vk::raii::Buffer buffer = nullptr;
    std::uint64_t size = 0;
    std::uint64_t address = 0; // for shaders
    BufferKind kind = BufferKind::Storage;
    std::byte* mapped = nullptr;
};

struct ComputePipeline::Impl {
    std::vector<vk::raii::DescriptorSetLayout> setLayouts;
    vk::raii::PipelineLayout layout = nullptr;
    vk::raii::Pipeline pipeline = nullptr;
    std::vector<std::uint32_t> code;
    std::vector<BufferSlot> slots;
    std::uint32_t pushConstantBytes = 0;
    double creationSeconds = 0;
};

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
    std::vector<std::shared_ptr<const ComputePipeline::Impl>> pipelines;

    std::unique_ptr<Buffer::Impl> MakeBuffer(std::uint64_t bytes, BufferKind kind, vk::BufferUsageFlags usage,
                                             vk::MemoryPropertyFlags wanted);
    template <typename F>
    double Submit(F&& record);
    void Copy(vk::Buffer from, std::uint64_t fromOffset, vk::Buffer to, std::uint64_t toOffset,
              std::uint64_t bytes);
};

Buffer::Buffer() noexcept = default;
Buffer::Buffer(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;
Buffer::~Buffer() = default;
std::uint64_t Buffer::GetSize() const noexcept {
    return impl_ ? impl_->size : 0;
}
std::uint64_t Buffer::GetDeviceAddress() const noexcept {
    return impl_ ? impl_->address : 0;
}

ComputePipeline::ComputePipeline() noexcept = default;
ComputePipeline::ComputePipeline(std::shared_ptr<const Impl> impl) noexcept : impl_(std::move(impl)) {}
double ComputePipeline::GetCreationSeconds() const noexcept {
    return impl_ ? impl_->creationSeconds : 0;
}

Context::Context(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Context::~Context() = default;
const DeviceInfo& Context::GetDevice() const noexcept {
    return impl_->info;
}
const ValidationLog& Context::GetValidationLog() const noexcept {
    return *impl_->log;
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
    } catch (const std::exception& error) {
        return Fail(Status::UnknownError, "%s: Vulkan: %s", what, error.what());
    }
}

Expected<std::vector<DeviceInfo>> Context::ListDevices(const std::string& loaderLibrary) {
    try {
        OPENNTC_ASSIGN(const std::unique_ptr<Instance> instance, MakeInstance(loaderLibrary, nullptr));
        std::vector<DeviceInfo> list;
        for (const vk::raii::PhysicalDevice& device : EnumerateDevices(instance->instance))
            list.push_back(Describe(device, static_cast<std::uint32_t>(list.size())));
        return list;
    } catch (const std::exception& error) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan instance: %s", error.what());
    }
}

Expected<std::unique_ptr<Context>> Context::Create(const ContextOptions& options) {
    try {
        auto impl = std::make_unique<Impl>();
        impl->log = options.log ? options.log : std::make_shared<ValidationLog>();
        impl->validation = options.validation;
        OPENNTC_ASSIGN(impl->instance,
                       MakeInstance(options.loaderLibrary, options.validation ? impl->log.get() : nullptr));

        std::vector<vk::raii::PhysicalDevice> devices = EnumerateDevices(impl->instance->instance);
        const std::optional<std::size_t> chosen = ChooseDevice(devices, options.device);
        if (!chosen) {
            return Fail(Status::Unsupported,
                        "device or feature absent: Vulkan device \"%s\": %zu devices found",
                        options.device.c_str(), devices.size());
        }
        impl->physicalDevice = std::move(devices[*chosen]);
        impl->info = Describe(impl->physicalDevice, static_cast<std::uint32_t>(*chosen));
        impl->memory = impl->physicalDevice.getMemoryProperties();
        if (impl->info.apiVersion < VK_API_VERSION_1_1)
            return Fail(Status::Unsupported, "device or feature absent: Vulkan 1.1: %s",
                        impl->info.name.c_str());
        const std::optional<std::uint32_t> family = FindComputeQueue(impl->physicalDevice);
        if (!family)
            return Fail(Status::Unsupported, "device or feature absent: compute queue: %s",
                        impl->info.name.c_str());
        impl->queueFamily = *family;

        const float priority = 1.0f;
        const vk::DeviceQueueCreateInfo queueInfo({}, *family, 1, &priority);
        const Features features = GetFeatures(impl->physicalDevice);
        vk::PhysicalDeviceVulkan13Features wanted;
        wanted.shaderIntegerDotProduct = features.integerDotProduct;
        wanted.maintenance4 = features.maintenance4;
        vk::PhysicalDeviceVulkan12Features wanted12;
        wanted12.shaderFloat16 = features.float16;
        wanted12.bufferDeviceAddress = features.bufferDeviceAddress;
        wanted12.descriptorIndexing = features.nonUniformIndexing;
        wanted12.shaderStorageBufferArrayNonUniformIndexing = features.nonUniformIndexing;
        wanted.setPNext(&wanted12);
        vk::PhysicalDeviceFeatures wanted10;
        wanted10.shaderStorageBufferArrayDynamicIndexing = features.bufferArrays;
        vk::DeviceCreateInfo deviceInfo({}, queueInfo);
        deviceInfo.setPEnabledFeatures(&wanted10);
        if (features.HasCore12() || features.HasCore13())
            deviceInfo.setPNext(&wanted);
        impl->device = vk::raii::Device(impl->physicalDevice, deviceInfo);
        impl->queue = vk::raii::Queue(impl->device, *family, 0);
        impl->commandPool = vk::raii::CommandPool(
            impl->device,
            vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eResetCommandBuffer, *family));
        vk::raii::CommandBuffers commands(
            impl->device,
            vk::CommandBufferAllocateInfo(*impl->commandPool, vk::CommandBufferLevel::ePrimary, 1));
        impl->commands = std::move(commands.front());
        impl->fence = vk::raii::Fence(impl->device, vk::FenceCreateInfo());
        if (impl->info.hasTimestamps)
            impl->queries =
                vk::raii::QueryPool(impl->device, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, 2));
        const std::vector<vk::DescriptorPoolSize> sizes = {{vk::DescriptorType::eStorageBuffer, 64},
                                                           {vk::DescriptorType::eUniformBuffer, 8}};
        impl->descriptorPool = vk::raii::DescriptorPool(
            impl->device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                                       kMaxDescriptorSets, sizes));
        if (options.validation && !impl->log->errors.empty())
            return Fail(Status::InternalError, "device: validation layer: %s",
                        impl->log->errors.front().c_str());
        return std::unique_ptr<Context>(new Context(std::move(impl)));
    } catch (const std::exception& error) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan device: %s", error.what());
    }
}

std::unique_ptr<Buffer::Impl> Context::Impl::MakeBuffer(std::uint64_t bytes, BufferKind kind,
                                                        vk::BufferUsageFlags usage,
                                                        vk::MemoryPropertyFlags wanted) {
    auto buffer = std::make_unique<Buffer::Impl>();
    buffer->size = bytes;
    buffer->kind = kind;
    buffer->buffer = vk::raii::Buffer(device, vk::BufferCreateInfo({}, bytes, usage));
    const vk::MemoryRequirements needs = buffer->buffer.getMemoryRequirements();
    const auto fallback =
        vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent;
    std::optional<std::uint32_t> type = FindMemoryType(memory, needs.memoryTypeBits, wanted);
    if (!type) // a device must offer host-visible coherent memory for buffers, so this finds one
        type = FindMemoryType(memory, needs.memoryTypeBits, fallback);
    if (!type)
        throw std::runtime_error("no memory type for a buffer");
    const bool isAddressed = static_cast<bool>(usage & vk::BufferUsageFlagBits::eShaderDeviceAddress);
    const vk::MemoryAllocateFlagsInfo flags(vk::MemoryAllocateFlagBits::eDeviceAddress);
    buffer->memory = vk::raii::DeviceMemory(
        device, vk::MemoryAllocateInfo(needs.size, *type, isAddressed ? &flags : nullptr));
    buffer->buffer.bindMemory(*buffer->memory, 0);
    if (isAddressed)
        buffer->address = device.getBufferAddress(vk::BufferDeviceAddressInfo(*buffer->buffer));
    if ((memory.memoryTypes[*type].propertyFlags & fallback) == fallback)
        buffer->mapped = static_cast<std::byte*>(buffer->memory.mapMemory(0, VK_WHOLE_SIZE));
    return buffer;
}

/// Records, submits and waits; returns wall-clock seconds from submission to completion.
template <typename F>
double Context::Impl::Submit(F&& record) {
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

void Context::Impl::Copy(vk::Buffer from, std::uint64_t fromOffset, vk::Buffer to, std::uint64_t toOffset,
                         std::uint64_t bytes) {
    Submit([&](const vk::raii::CommandBuffer& target) {
        const vk::MemoryBarrier before(vk::AccessFlagBits::eMemoryWrite,
                                       vk::AccessFlagBits::eTransferRead |
                                           vk::AccessFlagBits::eTransferWrite);
        target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands, vk::PipelineStageFlagBits::eTransfer,
                               {}, before, {}, {});
        target.copyBuffer(from, to, vk::BufferCopy(fromOffset, toOffset, bytes));
        const vk::MemoryBarrier after(vk::AccessFlagBits::eTransferWrite,
                                      vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eHostRead);
        target.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer,
                               vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost, {},
                               after, {}, {});
    });
}

Expected<Buffer> Context::CreateBuffer(std::uint64_t bytes, BufferKind kind, BufferMemory memory) {
    const std::uint64_t limit =
        kind == BufferKind::Uniform ? impl_->info.maxUniformBufferBytes : impl_->info.maxStorageBufferBytes;
    if (bytes == 0 || bytes > limit) {
        return Fail(
            Status::Unsupported, "device or feature absent: %s buffer of %llu bytes: 1 ... %llu on %s",
            kind == BufferKind::Uniform ? "uniform" : "storage", static_cast<unsigned long long>(bytes),
            static_cast<unsigned long long>(limit), impl_->info.name.c_str());
    }
    return Guard("buffer", [&]() -> Expected<Buffer> {
        vk::BufferUsageFlags usage = (kind == BufferKind::Uniform ? vk::BufferUsageFlagBits::eUniformBuffer
                                                                  : vk::BufferUsageFlagBits::eStorageBuffer) |
                                     vk::BufferUsageFlagBits::eTransferSrc |
                                     vk::BufferUsageFlagBits::eTransferDst;
        if (kind == BufferKind::Storage && impl_->info.hasBufferDeviceAddress)
            usage |= vk::BufferUsageFlagBits::eShaderDeviceAddress;
        vk::MemoryPropertyFlags wanted = vk::MemoryPropertyFlagBits::eDeviceLocal;
        if (memory == BufferMemory::HostVisible) {
            wanted = vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent |
                     vk::MemoryPropertyFlagBits::eHostCached;
        }
        std::unique_ptr<Buffer::Impl> buffer = impl_->MakeBuffer(bytes, kind, usage, wanted);
        if (buffer->mapped != nullptr) {
            std::memset(buffer->mapped, 0, static_cast<std::size_t>(bytes));
        } else {
            impl_->Submit([&](const vk::raii::CommandBuffer& target) {
                target.fillBuffer(*buffer->buffer, 0, VK_WHOLE_SIZE, 0);
            });
        }
        return Buffer(std::move(buffer));
    });
}

Expected<Buffer> Context::CreateBuffer(std::span<const std::byte> contents, BufferKind kind,
                                       BufferMemory memory) {
    // Shaders read whole words.
    const std::uint64_t bytes =
        contents.empty() ? 4 : (static_cast<std::uint64_t>(contents.size()) + 3) / 4 * 4;
    OPENNTC_ASSIGN(Buffer buffer, CreateBuffer(bytes, kind, memory));
    OPENNTC_CHECK(Write(buffer, 0, contents));
    return buffer;
}

namespace {

Expected<void> CheckRange(const Buffer& buffer, std::uint64_t offset, std::size_t bytes) {
    if (offset > buffer.GetSize() || bytes > buffer.GetSize() - offset) {
        return Fail(Status::OutOfRange, "buffer range: %llu + %zu: %llu bytes",
                    static_cast<unsigned long long>(offset), bytes,
                    static_cast<unsigned long long>(buffer.GetSize()));
    }
    return {};
}

} // namespace

Expected<void> Context::Write(const Buffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes) {
    OPENNTC_CHECK(CheckRange(buffer, offset, bytes.size()));
    if (bytes.empty())
        return {};
    Buffer::Impl& target = *buffer.GetImpl();
    return Guard("buffer write", [&]() -> Expected<void> {
        if (target.mapped != nullptr) {
            std::memcpy(target.mapped + offset, bytes.data(), bytes.size());
            return {};
        }
        const auto staging = impl_->MakeBuffer(
            bytes.size(), BufferKind::Storage, vk::BufferUsageFlagBits::eTransferSrc,
            vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        std::memcpy(staging->mapped, bytes.data(), bytes.size());
        impl_->Copy(*staging->buffer, 0, *target.buffer, offset, bytes.size());
        return {};
    });
}

Expected<void> Context::Read(const Buffer& buffer, std::uint64_t offset, std::span<std::byte> bytes) {
    OPENNTC_CHECK(CheckRange(buffer, offset, bytes.size()));
    if (bytes.empty())
        return {};
    const Buffer::Impl& source = *buffer.GetImpl();
    return Guard("buffer read", [&]() -> Expected<void> {
        if (source.mapped != nullptr) {
            std::memcpy(bytes.data(), source.mapped + offset, bytes.size());
            return {};
        }
        const auto staging = impl_->MakeBuffer(
            bytes.size(), BufferKind::Storage, vk::BufferUsageFlagBits::eTransferDst,
            vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        impl_->Copy(*source.buffer, offset, *staging->buffer, 0, bytes.size());
        std::memcpy(bytes.data(), staging->mapped, bytes.size());
        return {};
    });
}

Expected<ComputePipeline> Context::CreateComputePipeline(std::span<const std::uint32_t> spirv,
                                                         std::span<const BufferSlot> slots,
                                                         std::uint32_t pushConstantBytes) {
    if (pushConstantBytes > impl_->info.maxPushConstantBytes) {
        return Fail(Status::Unsupported, "device or feature absent: %u bytes of push constants: %u",
                    pushConstantBytes, impl_->info.maxPushConstantBytes);
    }
    std::uint32_t setCount = 0;
    for (const BufferSlot& slot : slots) {
        if (slot.set >= kMaxDescriptorSets || slot.count < 1)
            return Fail(Status::OutOfRange, "pipeline: set %u, %u buffers: sets 0 ... %u, 1 buffer or more",
                        slot.set, slot.count, kMaxDescriptorSets - 1);
        setCount = std::max(setCount, slot.set + 1);
    }
    for (const std::shared_ptr<const ComputePipeline::Impl>& known : impl_->pipelines) {
        if (known->pushConstantBytes == pushConstantBytes && std::ranges::equal(known->slots, slots) &&
            std::ranges::equal(known->code, spirv))
            return ComputePipeline(known);
    }
    return Guard("pipeline", [&]() -> Expected<ComputePipeline> {
        auto pipeline = std::make_shared<ComputePipeline::Impl>();
        pipeline->code.assign(spirv.begin(), spirv.end());
        pipeline->slots.assign(slots.begin(), slots.end());
        pipeline->pushConstantBytes = pushConstantBytes;
        std::vector<vk::DescriptorSetLayout> setLayouts;
        for (std::uint32_t set = 0; set < setCount; ++set) {
            std::vector<vk::DescriptorSetLayoutBinding> bindings;
            for (const BufferSlot& slot : slots) {
                if (slot.set == set)
                    bindings.emplace_back(slot.binding, GetDescriptorType(slot.kind), slot.count,
                                          vk::ShaderStageFlagBits::eCompute);
            }
            pipeline->setLayouts.emplace_back(impl_->device, vk::DescriptorSetLayoutCreateInfo({}, bindings));
            setLayouts.push_back(*pipeline->setLayouts.back());
        }
        const vk::PushConstantRange range(vk::ShaderStageFlagBits::eCompute, 0, pushConstantBytes);
        vk::PipelineLayoutCreateInfo layoutInfo({}, setLayouts);
        if (pushConstantBytes > 0)
            layoutInfo.setPushConstantRanges(range);
        pipeline->layout = vk::raii::PipelineLayout(impl_->device, layoutInfo);

        vk::ShaderModuleCreateInfo moduleInfo;
        moduleInfo.codeSize = spirv.size_bytes();
        moduleInfo.pCode = spirv.data();
        const vk::raii::ShaderModule module(impl_->device, moduleInfo);
        const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
        const auto start = std::chrono::steady_clock::now();
        pipeline->pipeline = vk::raii::Pipeline(impl_->device, nullptr,
                                                vk::ComputePipelineCreateInfo({}, stage, *pipeline->layout));
        pipeline->creationSeconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        impl_->pipelines.push_back(pipeline);
        return ComputePipeline(std::move(pipeline));
    });
}

Expected<DispatchTiming> Context::Dispatch(const DispatchRequest& request) {
    const ComputePipeline::Impl* pipeline =
        request.pipeline != nullptr ? request.pipeline->GetImpl() : nullptr;
    if (pipeline == nullptr)
        return Fail(Status::InvalidArgument, "dispatch: pipeline: must not be null");
    if (request.pushConstants.size() != pipeline->pushConstantBytes) {
        return Fail(Status::InvalidArgument, "dispatch: %zu bytes of push constants: the pipeline has %u",
                    request.pushConstants.size(), pipeline->pushConstantBytes);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (request.groups[axis] == 0 || request.groups[axis] > impl_->info.maxWorkgroupCount[axis]) {
            return Fail(Status::OutOfRange, "dispatch: %u groups: 1 ... %u", request.groups[axis],
                        impl_->info.maxWorkgroupCount[axis]);
        }
    }
    std::vector<vk::DescriptorBufferInfo> buffers;
    for (const BufferSlot& slot : pipeline->slots) {
        for (std::uint32_t element = 0; element < slot.count; ++element) {
            const auto bound = std::find_if(
                request.buffers.begin(), request.buffers.end(), [&](const BoundBuffer& candidate) {
                    return candidate.binding == slot.binding && candidate.set == slot.set &&
                           candidate.element == element;
                });
            if (bound == request.buffers.end() || bound->buffer == nullptr ||
                bound->buffer->GetImpl() == nullptr || bound->buffer->GetImpl()->kind != slot.kind)
                return Fail(Status::InvalidArgument,
                            "dispatch: set %u, binding %u, element %u: no buffer of its kind given", slot.set,
                            slot.binding, element);
            buffers.emplace_back(*bound->buffer->GetImpl()->buffer, 0, VK_WHOLE_SIZE);
        }
    }

    return Guard("dispatch", [&]() -> Expected<DispatchTiming> {
        std::vector<vk::DescriptorSetLayout> setLayouts;
        for (const vk::raii::DescriptorSetLayout& setLayout : pipeline->setLayouts)
            setLayouts.push_back(*setLayout);
        std::vector<vk::raii::DescriptorSet> sets; // none, if everything is found by address
        if (!setLayouts.empty())
            sets = vk::raii::DescriptorSets(
                impl_->device, vk::DescriptorSetAllocateInfo(*impl_->descriptorPool, setLayouts));
        std::vector<vk::DescriptorSet> handles;
        for (const vk::raii::DescriptorSet& set : sets)
            handles.push_back(*set);
        std::vector<vk::WriteDescriptorSet> writes;
        const vk::DescriptorBufferInfo* next = buffers.data();
        for (const BufferSlot& slot : pipeline->slots) {
            writes.emplace_back(handles[slot.set], slot.binding, 0u, slot.count, GetDescriptorType(slot.kind),
                                nullptr, next);
            next += slot.count;
        }
        impl_->device.updateDescriptorSets(writes, {});

        DispatchTiming timing;
        timing.wallSeconds = impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            target.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline->pipeline);
            if (!handles.empty())
                target.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipeline->layout, 0, handles, {});
            if (!request.pushConstants.empty()) {
                target.pushConstants<std::byte>(
                    *pipeline->layout, vk::ShaderStageFlagBits::eCompute, 0,
                    vk::ArrayProxy<const std::byte>(static_cast<std::uint32_t>(request.pushConstants.size()),
                                                    request.pushConstants.data()));
            }
            if (impl_->info.hasTimestamps) {
                target.resetQueryPool(*impl_->queries, 0, 2);
                target.writeTimestamp(vk::PipelineStageFlagBits::eTopOfPipe, *impl_->queries, 0);
            }
            target.dispatch(request.groups[0], request.groups[1], request.groups[2]);
            if (impl_->info.hasTimestamps)
                target.writeTimestamp(vk::PipelineStageFlagBits::eComputeShader, *impl_->queries, 1);
            const vk::MemoryBarrier after(vk::AccessFlagBits::eShaderWrite,
                                          vk::AccessFlagBits::eHostRead | vk::AccessFlagBits::eMemoryRead);
            target.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader,
                                   vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost,
                                   {}, after, {}, {});
        });
        if (impl_->info.hasTimestamps) {
            const auto [result, ticks] = impl_->queries.getResults<std::uint64_t>(
                0, 2, 2 * sizeof(std::uint64_t), sizeof(std::uint64_t), vk::QueryResultFlagBits::e64);
            if (result == vk::Result::eSuccess) {
                // Only the valid bits count; the difference modulo 2^bits survives one wrap of the counter.
                const std::uint32_t bits = impl_->info.timestampValidBits;
                const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
                const std::uint64_t elapsed = (ticks[1] - ticks[0]) & mask;
                timing.gpuSeconds =
                    static_cast<double>(elapsed) * impl_->info.timestampPeriodNanoseconds * 1e-9;
            }
        }
        return timing;
    });
}

} // namespace openntc::harness
