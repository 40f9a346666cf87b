// SPDX-License-Identifier: MIT
// Devices: what they are called, what they can do, and which one to open.
#pragma once

#include "vulkan_harness/Features.h"

#include "openntc/core/Expected.h"
#include "openntc/inference/CooperativeVectors.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace openntc::harness {

/// Part of the name of Mesa's CPU implementation, the device of our tests.
inline constexpr const char* kLavapipe = "llvmpipe";

struct DeviceInfo {
    std::uint32_t index = 0; ///< as accepted by ContextOptions::device
    std::string name;
    std::string driver;
    std::uint32_t apiVersion = 0; ///< VK_MAKE_API_VERSION
    bool isCpu = false;
    FeatureSet features; ///< what is there, and why the rest is not
    CoopVecDevice cooperativeVectors;
    bool hasFragmentVectors = false; ///< cooperative vectors in fragment shaders too
    /// Cooperative matrices of signed bytes, 16 x 16 x 32 with sums of 32 bits, at subgroup scope; subgroups have 32 lanes.
    bool hasByteMatrices = false;
    bool hasHalfMatrices = false; ///< of binary16, 16 x 16 x 16 with sums of binary32, otherwise as those
    std::vector<std::string> cooperativeVectorTypes; ///< a line for each combination that the driver lists
    bool hasSubgroupShuffle = false;                 ///< in compute shaders
    std::uint32_t subgroupSize = 0;
    // Float controls of binary32 that a shader may ask for by an execution mode.
    bool hasDenormPreserve = false;
    bool hasDenormFlushToZero = false;
    bool hasSignedZeroInfNanPreserve = false;
    bool hasRoundToNearestEven = false;
    bool hasRoundTowardZero = false;
    bool hasTimestamps = false;            ///< on the compute queue that is used
    std::uint32_t timestampValidBits = 0;  ///< of that queue
    double timestampPeriodNanoseconds = 0; ///< nanoseconds per tick
    std::uint64_t maxStorageBufferBytes = 0;
    std::uint64_t maxUniformBufferBytes = 0;
    std::uint32_t maxPushConstantBytes = 0;
    std::uint32_t subTexelPrecisionBits = 0; ///< of the place between texels, when they are filtered
    std::uint32_t maxWorkgroupCount[3] = {};
    std::uint32_t maxWorkgroupInvocations = 0;
    std::uint32_t maxSharedBytes = 0; ///< of a workgroup
};

/// What the validation layer reported. Shared, so that it can be read after the context has gone.
struct ValidationLog {
    std::vector<std::string> errors;
    std::vector<std::string> warnings;
};

/// Faults of a device that come when they are called, to see what programs make of them.
struct DeviceFaults {
    std::uint64_t bytes =
        ~std::uint64_t{0};           ///< allocated so far and no more: then the device is out of memory
    std::uint32_t submissions = ~0u; ///< so many are carried out: then the device is lost
};

struct ContextOptions {
    std::string device; ///< an index, part of a name (case-sensitive), or empty: a GPU if there is one
    bool validation =
        false; ///< needs VK_LAYER_KHRONOS_validation; its errors make the call that caused them fail
    std::vector<Feature> required; ///< Create fails with the reason where one of them is absent
    std::vector<Feature> withheld; ///< treated as absent, to see what happens on devices without them
    std::vector<std::string> surfaceExtensions; ///< of the instance, for windows; empty: none are opened
    DeviceFaults faults;
    std::string loaderLibrary;          ///< empty: the system's Vulkan loader
    std::shared_ptr<ValidationLog> log; ///< empty: the context makes its own
};

/// The devices that Context::Create can choose from. An empty list is not an error; a missing loader is.
Expected<std::vector<DeviceInfo>> ListDevices(const std::string& loaderLibrary = {});

} // namespace openntc::harness
