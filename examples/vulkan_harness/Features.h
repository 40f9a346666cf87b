// SPDX-License-Identifier: MIT
// Optional features of a device: what the harness can ask for, and why a device has it not.
//
// A new feature is a row of the table in Features.cpp: its name, the version or extension that brings it, and its bit.
// Everything a device has is switched on; ContextOptions says what must be there and what is to be left off.
#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace openntc::harness {

enum class Feature {
    BufferArrays,        ///< arrays of storage buffers, indices uniform over a draw or dispatch
    Float16,             ///< arithmetic in 16-bit floats
    StorageBuffer8Bit,   ///< 8-bit numbers in storage buffers
    StorageBuffer16Bit,  ///< 16-bit numbers in storage buffers
    Int8,                ///< arithmetic in 8-bit integers
    Int16,               ///< arithmetic in 16-bit integers
    MemoryModel,         ///< Vulkan's memory model, at device scope too
    BufferDeviceAddress, ///< buffers found by address
    NonUniformIndexing,  ///< arrays of storage buffers, indices that differ between invocations
    IntegerDotProduct,
    Maintenance4,
    PipelineStatistics,   ///< what drivers say about registers and memory of a pipeline
    CooperativeVectors,   ///< VK_NV_cooperative_vector; DeviceInfo::cooperativeVectors says of which types
    ReplicatedComposites, ///< constants of cooperative vectors, as glslang writes them
    StorageImages,        ///< written without a format in the shader
    BlockCompression,     ///< BC1 to BC7 to be sampled
    Formats4444,          ///< VK_EXT_4444_formats: four bits a channel, alpha in the highest ones
    CooperativeMatrices,  ///< VK_KHR_cooperative_matrix, and what its shaders need beside it
    FragmentStores,       ///< fragment shaders write buffers
    DynamicRendering,     ///< drawing into images without a render pass
    HostOperations,       ///< VK_KHR_deferred_host_operations, which the next one asks for
    AccelerationStructures,
    RayTracing,          ///< VK_KHR_ray_tracing_pipeline, with what it needs
    MemoryDecompression, ///< VK_NV_memory_decompression, with GDeflate 1.0
    Swapchain,           ///< VK_KHR_swapchain, where ContextOptions::surfaceExtensions has what windows need
    Count,
};

inline constexpr std::size_t kFeatureCount = static_cast<std::size_t>(Feature::Count);

/// Vulkan's name of the feature.
const char* GetFeatureName(Feature feature) noexcept;

/// For each feature why it is absent; empty if it is there.
class FeatureSet {
public:
    bool Has(Feature feature) const noexcept { return GetAbsence(feature).empty(); }
    const std::string& GetAbsence(Feature feature) const noexcept {
        return absences_[static_cast<std::size_t>(feature)];
    }
    void SetAbsence(Feature feature, std::string reason) {
        absences_[static_cast<std::size_t>(feature)] = std::move(reason);
    }

private:
    std::array<std::string, kFeatureCount> absences_;
};

} // namespace openntc::harness
