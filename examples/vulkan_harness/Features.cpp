// SPDX-License-Identifier: MIT
// The table of optional features.
#include "FeatureChain.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

namespace openntc::harness {

namespace {

using Bit = VkBool32& (*)(FeatureChain&);

struct FeatureRow {
    Feature feature;
    const char* name;
    std::uint32_t version; ///< of Vulkan that has it in its core; 0: any
    const char* extension; ///< that brings it, or null
    std::array<Bit, 2> bits;
};

constexpr Bit kNoBit = nullptr;

const FeatureRow kRows[] = {
    {Feature::BufferArrays,
     "shaderStorageBufferArrayDynamicIndexing",
     0,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core.features.shaderStorageBufferArrayDynamicIndexing; },
      kNoBit}},
    {Feature::Float16,
     "shaderFloat16",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core12.shaderFloat16; }, kNoBit}},
    {Feature::StorageBuffer8Bit,
     "storageBuffer8BitAccess",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core12.storageBuffer8BitAccess; }, kNoBit}},
    {Feature::StorageBuffer16Bit,
     "storageBuffer16BitAccess",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core11.storageBuffer16BitAccess; }, kNoBit}},
    {Feature::Int8,
     "shaderInt8",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core12.shaderInt8; }, kNoBit}},
    {Feature::Int16,
     "shaderInt16",
     0,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core.features.shaderInt16; }, kNoBit}},
    {Feature::MemoryModel,
     "vulkanMemoryModel",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core12.vulkanMemoryModel; },
      [](FeatureChain& c) -> VkBool32& { return c.core12.vulkanMemoryModelDeviceScope; }}},
    {Feature::BufferDeviceAddress,
     "bufferDeviceAddress",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core12.bufferDeviceAddress; }, kNoBit}},
    {Feature::NonUniformIndexing,
     "shaderStorageBufferArrayNonUniformIndexing",
     VK_API_VERSION_1_2,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core12.shaderStorageBufferArrayNonUniformIndexing; },
      [](FeatureChain& c) -> VkBool32& { return c.core12.descriptorIndexing; }}},
    {Feature::IntegerDotProduct,
     "shaderIntegerDotProduct",
     VK_API_VERSION_1_3,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core13.shaderIntegerDotProduct; }, kNoBit}},
    {Feature::Maintenance4,
     "maintenance4",
     VK_API_VERSION_1_3,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core13.maintenance4; }, kNoBit}},
    {Feature::PipelineStatistics,
     "pipelineExecutableInfo",
     0,
     "VK_KHR_pipeline_executable_properties",
     {[](FeatureChain& c) -> VkBool32& { return c.statistics.pipelineExecutableInfo; }, kNoBit}},
    {Feature::CooperativeVectors,
     "cooperativeVector",
     0,
     "VK_NV_cooperative_vector",
     {[](FeatureChain& c) -> VkBool32& { return c.vectors.cooperativeVector; }, kNoBit}},
    {Feature::ReplicatedComposites,
     "shaderReplicatedComposites",
     0,
     "VK_EXT_shader_replicated_composites",
     {[](FeatureChain& c) -> VkBool32& { return c.replicated.shaderReplicatedComposites; }, kNoBit}},
    {Feature::StorageImages,
     "shaderStorageImageWriteWithoutFormat",
     0,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core.features.shaderStorageImageWriteWithoutFormat; },
      kNoBit}},
    {Feature::BlockCompression,
     "textureCompressionBC",
     0,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core.features.textureCompressionBC; }, kNoBit}},
    {Feature::Formats4444,
     "formatA4R4G4B4",
     0,
     "VK_EXT_4444_formats",
     {[](FeatureChain& c) -> VkBool32& { return c.formats4444.formatA4R4G4B4; }, kNoBit}},
    {Feature::CooperativeMatrices,
     "cooperativeMatrix",
     0,
     "VK_KHR_cooperative_matrix",
     {[](FeatureChain& c) -> VkBool32& { return c.matrices.cooperativeMatrix; }, kNoBit}},
    {Feature::FragmentStores,
     "fragmentStoresAndAtomics",
     0,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core.features.fragmentStoresAndAtomics; }, kNoBit}},
    {Feature::DynamicRendering,
     "dynamicRendering",
     VK_API_VERSION_1_3,
     nullptr,
     {[](FeatureChain& c) -> VkBool32& { return c.core13.dynamicRendering; }, kNoBit}},
    {Feature::HostOperations,
     "deferredHostOperations",
     0,
     "VK_KHR_deferred_host_operations",
     {kNoBit, kNoBit}},
    {Feature::AccelerationStructures,
     "accelerationStructure",
     VK_API_VERSION_1_2,
     "VK_KHR_acceleration_structure",
     {[](FeatureChain& c) -> VkBool32& { return c.structures.accelerationStructure; }, kNoBit}},
    {Feature::RayTracing,
     "rayTracingPipeline",
     VK_API_VERSION_1_2,
     "VK_KHR_ray_tracing_pipeline",
     {[](FeatureChain& c) -> VkBool32& { return c.rays.rayTracingPipeline; }, kNoBit}},
    {Feature::MemoryDecompression,
     "memoryDecompression",
     VK_API_VERSION_1_2,
     "VK_NV_memory_decompression",
     {[](FeatureChain& c) -> VkBool32& { return c.decompression.memoryDecompression; }, kNoBit}},
    {Feature::Swapchain, "swapchain", 0, "VK_KHR_swapchain", {kNoBit, kNoBit}},
};
static_assert(std::size(kRows) == kFeatureCount);

std::string DescribeVersion(std::uint32_t version) {
    char text[24];
    std::snprintf(text, sizeof text, "%u.%u", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version));
    return text;
}

bool HasExtension(const std::vector<vk::ExtensionProperties>& extensions, const char* name) {
    return std::any_of(extensions.begin(), extensions.end(),
                       [name](const vk::ExtensionProperties& extension) {
                           return std::strcmp(extension.extensionName, name) == 0;
                       });
}

// Each is there only with those before it, in the caller's choice too.
constexpr std::pair<Feature, Feature> kNeeds[] = {
    {Feature::AccelerationStructures, Feature::HostOperations},
    {Feature::AccelerationStructures, Feature::BufferDeviceAddress},
    {Feature::RayTracing, Feature::AccelerationStructures},
    {Feature::MemoryDecompression, Feature::BufferDeviceAddress}};

} // namespace

void AddNeeds(FeatureSet& set) {
    for (const auto& [feature, needed] : kNeeds) {
        if (set.Has(feature) && !set.Has(needed))
            set.SetAbsence(feature, std::string(GetFeatureName(needed)) + ": " + set.GetAbsence(needed));
    }
}

const char* GetFeatureName(Feature feature) noexcept {
    for (const FeatureRow& row : kRows) {
        if (row.feature == feature)
            return row.name;
    }
    return "?";
}

FeatureChain::FeatureChain(std::uint32_t version, const std::vector<vk::ExtensionProperties>& extensions) {
    void** next = &core.pNext;
    const auto link = [&next](auto& structure) {
        *next = &structure;
        next = &structure.pNext;
    };
    if (version >= VK_API_VERSION_1_2) {
        link(core11);
        link(core12);
    }
    if (version >= VK_API_VERSION_1_3)
        link(core13);
    vectors.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_VECTOR_FEATURES_NV;
    replicated.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_REPLICATED_COMPOSITES_FEATURES_EXT;
    if (HasExtension(extensions, "VK_KHR_pipeline_executable_properties"))
        link(statistics);
    if (HasExtension(extensions, "VK_NV_cooperative_vector"))
        link(vectors);
    matrices.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_MATRIX_FEATURES_KHR;
    if (HasExtension(extensions, "VK_KHR_cooperative_matrix"))
        link(matrices);
    if (HasExtension(extensions, "VK_EXT_4444_formats"))
        link(formats4444);
    if (HasExtension(extensions, "VK_EXT_shader_replicated_composites"))
        link(replicated);
    if (HasExtension(extensions, "VK_KHR_acceleration_structure"))
        link(structures);
    if (HasExtension(extensions, "VK_KHR_ray_tracing_pipeline"))
        link(rays);
    if (HasExtension(extensions, "VK_NV_memory_decompression"))
        link(decompression);
}

namespace {

bool DecompressesGDeflate(const vk::raii::PhysicalDevice& device) {
    vk::PhysicalDeviceMemoryDecompressionPropertiesNV decompression;
    vk::PhysicalDeviceProperties2 properties({}, &decompression);
    device.getDispatcher()->vkGetPhysicalDeviceProperties2(
        static_cast<VkPhysicalDevice>(*device), reinterpret_cast<VkPhysicalDeviceProperties2*>(&properties));
    return static_cast<bool>(decompression.decompressionMethods &
                             vk::MemoryDecompressionMethodFlagBitsNV::eGdeflate10);
}

} // namespace

FeatureSet GetFeatures(const vk::raii::PhysicalDevice& device, std::uint32_t version) {
    const std::vector<vk::ExtensionProperties> extensions = device.enumerateDeviceExtensionProperties();
    FeatureChain chain(version, extensions);
    device.getDispatcher()->vkGetPhysicalDeviceFeatures2(
        static_cast<VkPhysicalDevice>(*device), reinterpret_cast<VkPhysicalDeviceFeatures2*>(&chain.core));
    FeatureSet set;
    for (const FeatureRow& row : kRows) {
        if (row.version > version)
            set.SetAbsence(row.feature, "in Vulkan " + DescribeVersion(row.version) + ": the device has " +
                                            DescribeVersion(version));
        else if (row.extension != nullptr && !HasExtension(extensions, row.extension))
            set.SetAbsence(row.feature, std::string(row.extension) + ": the driver does not have it");
        else if (std::any_of(row.bits.begin(), row.bits.end(),
                             [&](Bit bit) { return bit != kNoBit && bit(chain) != VK_TRUE; }))
            set.SetAbsence(row.feature, "the driver does not offer it");
    }
    if (!set.Has(Feature::BufferArrays) && set.Has(Feature::NonUniformIndexing))
        set.SetAbsence(Feature::NonUniformIndexing, set.GetAbsence(Feature::BufferArrays));
    const auto needs = [&set](Feature feature, Feature needed) {
        if (set.Has(feature) && !set.Has(needed))
            set.SetAbsence(feature, std::string(GetFeatureName(needed)) + ": " + set.GetAbsence(needed));
    };
    // What the shaders of cooperative vectors need beside them.
    needs(Feature::CooperativeVectors, Feature::Float16);
    needs(Feature::CooperativeVectors, Feature::MemoryModel);
    needs(Feature::CooperativeMatrices, Feature::Float16);
    needs(Feature::CooperativeMatrices, Feature::Int8);
    needs(Feature::CooperativeMatrices, Feature::MemoryModel);
    if (set.Has(Feature::MemoryDecompression) && !DecompressesGDeflate(device))
        set.SetAbsence(Feature::MemoryDecompression, "GDeflate 1.0: the driver does not decompress it");
    AddNeeds(set);
    return set;
}

std::vector<const char*> SwitchOn(const FeatureSet& features, FeatureChain& chain) {
    std::vector<const char*> extensions;
    for (const FeatureRow& row : kRows) {
        if (!features.Has(row.feature))
            continue;
        if (row.extension != nullptr)
            extensions.push_back(row.extension);
        for (const Bit bit : row.bits) {
            if (bit != kNoBit)
                bit(chain) = VK_TRUE;
        }
    }
    return extensions;
}

std::vector<vk::ExtensionProperties> ListExtensions(const vk::raii::PhysicalDevice& device,
                                                    const FeatureSet& features) {
    std::vector<vk::ExtensionProperties> extensions = device.enumerateDeviceExtensionProperties();
    std::erase_if(extensions, [&](const vk::ExtensionProperties& extension) {
        return std::none_of(std::begin(kRows), std::end(kRows), [&](const FeatureRow& row) {
            return row.extension != nullptr && features.Has(row.feature) &&
                   std::strcmp(extension.extensionName, row.extension) == 0;
        });
    });
    return extensions;
}

} // namespace openntc::harness
