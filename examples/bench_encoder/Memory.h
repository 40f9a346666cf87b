// SPDX-License-Identifier: MIT
// What memory an encoding takes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace openntc::bench {

struct MemoryRequest {
    int size = 512; ///< width and height; 16 channels, all mips
    float bitsPerPixel = 4.0f;
    std::uint64_t steps = 10;          ///< memory does not depend on it
    std::optional<std::string> device; ///< Vulkan device that trains; none: the processor
};

struct MemoryUse {
    std::uint64_t hostBytes = 0;   ///< resident set at most, images and evaluation in it
    std::uint64_t deviceBytes = 0; ///< of all buffers; 0 without a device
    double seconds = 0.0;
};

/// Encodes synthetic images as `ntc encode` does, in a process of its own. Throws CommandError: Failed, and NoDevice for what
/// the device lacks.
MemoryUse MeasureMemory(const MemoryRequest& request);

} // namespace openntc::bench
