// SPDX-License-Identifier: MIT
// The structures in which Vulkan reports optional features and takes them, one after the other.
#pragma once

#include "CooperativeMatrixTypes.h"
#include "CooperativeVectorTypes.h"
#include "VulkanObjects.h"

#include <array>
#include <vector>

namespace openntc::harness {

/// Linked as far as the device's version and extensions know them. Not copied: the structures point at one another.
struct FeatureChain {
    vk::PhysicalDeviceFeatures2 core;
    vk::PhysicalDeviceVulkan11Features core11;
    vk::PhysicalDeviceVulkan12Features core12;
    vk::PhysicalDeviceVulkan13Features core13;
    vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR statistics;
    VkPhysicalDeviceCooperativeVectorFeaturesNV vectors = {};
    VkPhysicalDeviceShaderReplicatedCompositesFeaturesEXT replicated = {};
    VkPhysicalDeviceCooperativeMatrixFeaturesKHR matrices = {};
    vk::PhysicalDevice4444FormatsFeaturesEXT formats4444;
    vk::PhysicalDeviceAccelerationStructureFeaturesKHR structures;
    vk::PhysicalDeviceRayTracingPipelineFeaturesKHR rays;
    vk::PhysicalDeviceMemoryDecompressionFeaturesNV decompression;

    FeatureChain(std::uint32_t version, const std::vector<vk::ExtensionProperties>& extensions);
    FeatureChain(const FeatureChain&) = delete;
    FeatureChain& operator=(const FeatureChain&) = delete;
};

/// Sets the bits of all features of the set; returns the extensions to enable.
std::vector<const char*> SwitchOn(const FeatureSet& features, FeatureChain& chain);
/// Takes off features that lack what they need, where that may be the caller's choice.
void AddNeeds(FeatureSet& set);
/// The device's extensions that bring features of the set.
std::vector<vk::ExtensionProperties> ListExtensions(const vk::raii::PhysicalDevice& device,
                                                    const FeatureSet& features);

} // namespace openntc::harness
