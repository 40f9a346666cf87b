// SPDX-License-Identifier: MIT
// The device of the benchmark: plain Vulkan with the loader opened at run time, VK_NV_cooperative_vector where the driver
// has it, and timestamps. Every function throws DeviceFailure when Vulkan fails. `ntc report` times with it too.
#pragma once

#include "openntc/inference/CooperativeVectors.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace openntc::bench {

/// What failed, with Vulkan's number; "device or feature absent: ..." when there is no such device.
class DeviceFailure : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

struct DeviceBuffer {
    std::uint64_t handle = 0;
    std::uint64_t memory = 0;
    std::uint64_t size = 0;
};

struct DeviceFacts {
    std::string name;
    std::string driver;
    bool isCpu = false;
    bool hasIntegerDotProduct = false;
    std::uint32_t subgroupSize = 0;
    std::uint32_t maxUniformBytes = 0;
    CoopVecDevice cooperativeVectors;
    std::vector<std::string> cooperativeVectorTypes; ///< a line for each combination that the driver lists
};

/// A compute pipeline with four buffers (0: constants, uniform; 1: latents; 2: weights; 3: results).
struct Kernel {
    std::uint64_t pipeline = 0;
    std::uint64_t layout = 0;
    std::uint64_t setLayout = 0;
    bool uniformWeights = false;
    double creationSeconds = 0;
    std::string statistics; ///< what the driver says about registers and memory; may be empty
    std::string error;      ///< why there is no pipeline
};

class Device {
public:
    /// `name`: part of the device's name; empty: a GPU if there is one.
    explicit Device(const std::string& name);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceFacts& GetFacts() const noexcept;
    DeviceBuffer CreateBuffer(std::uint64_t size, std::span<const std::byte> contents);
    void DestroyBuffer(DeviceBuffer& buffer);
    std::vector<std::byte> Read(const DeviceBuffer& buffer, std::uint64_t size);

    Kernel CreateKernel(std::span<const std::uint32_t> spirv, bool uniformWeights);
    void DestroyKernel(Kernel& kernel);

    /// Submits the dispatch `repetitions` times, each by itself; milliseconds between the timestamps round each.
    std::vector<double> Run(const Kernel& kernel, std::span<const DeviceBuffer> buffers, std::uint32_t width,
                            std::uint32_t groupsX, std::uint32_t groupsY, int repetitions);

    /// Device weights in the inferencing-optimal layout; the offsets are in `weights` afterwards.
    std::vector<std::byte> ConvertWeights(CoopVecWeights& weights);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace openntc::bench
