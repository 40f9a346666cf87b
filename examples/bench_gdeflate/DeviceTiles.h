// SPDX-License-Identifier: MIT
// The tiles of a GDeflate stream, decompressed by a Vulkan device, itself or by a compute pass. No Vulkan header is needed to
// include this file.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace openntc::bench {

class DeviceTiles {
public:
    /// Null without the device, or without VK_NV_memory_decompression unless `byShader`; `reason` says why.
    static std::unique_ptr<DeviceTiles> Create(const std::string& device, bool byShader, std::string& reason);
    virtual ~DeviceTiles() = default;

    virtual std::string GetName() const = 0;
    /// Uploads a stream that was decompressed on the CPU before, and decompresses it once. Nothing is timed. False on
    /// failure.
    virtual bool Prepare(std::span<const std::byte> stream) = 0;
    /// Seconds of the device, or of the host where it has no clock; below 0 on failure.
    virtual double Decompress() = 0;
    virtual bool Read(std::span<std::byte> output) = 0;
};

} // namespace openntc::bench
