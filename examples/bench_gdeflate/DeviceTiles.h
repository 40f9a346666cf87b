// SPDX-License-Identifier: MIT
// The tiles of a GDeflate stream, decompressed by a Vulkan device. No Vulkan header is needed to include this file.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace openntc::bench {

struct DeviceSeconds {
    double tiles = 0.0; ///< decompression alone, by the device's clock, or by the host's where it has none
    double all = 0.0;   ///< of the host: upload of the stream, decompression, and the wait for both
};

class DeviceTiles {
public:
    /// Null without the device or its feature; `reason` says why.
    static std::unique_ptr<DeviceTiles> Create(const std::string& device, std::string& reason);
    virtual ~DeviceTiles() = default;

    virtual std::string GetName() const = 0;
    /// Makes buffers for a stream that was decompressed on the CPU before. Nothing is timed. False on failure.
    virtual bool Prepare(std::span<const std::byte> stream) = 0;
    /// False on failure.
    virtual bool Decompress(DeviceSeconds& seconds) = 0;
    virtual bool Read(std::span<std::byte> output) = 0;
};

} // namespace openntc::bench
