// SPDX-License-Identifier: MIT
// Buffers of a Context.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace openntc::harness {

/// Kinds of what is bound. Of slots only: Image, a storage image (Images.h), Texture, the same to be sampled, and
/// FilteredTexture, with a sampler that filters bilinearly, repeats and takes the nearest mip.
enum class BufferKind { Storage, Uniform, Image, Texture, FilteredTexture };
enum class BufferMemory {
    HostVisible, ///< mapped; for data that is read back or written often
    DeviceLocal, ///< the device's own memory, through a staging buffer where the host cannot see it
};

/// A buffer of a Context, which must outlive it.
class Buffer {
public:
    struct Impl;
    Buffer() noexcept;
    explicit Buffer(std::unique_ptr<Impl> impl) noexcept;
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) noexcept;
    ~Buffer();

    std::uint64_t GetSize() const noexcept;
    /// Where shaders find it; 0 if it is no storage buffer or the device has no buffer device addresses.
    std::uint64_t GetDeviceAddress() const noexcept;
    Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

/// Bytes for a part of a buffer.
struct BufferWrite {
    const Buffer* buffer = nullptr;
    std::uint64_t offset = 0; ///< in the buffer
    std::span<const std::byte> bytes;
};

/// A GDeflate tile that a device decompresses.
struct DecompressedTile {
    const Buffer* source = nullptr;
    std::uint64_t sourceOffset = 0; ///< a multiple of 4
    std::uint64_t sourceBytes = 0;  ///< compressed
    const Buffer* destination = nullptr;
    std::uint64_t destinationOffset = 0; ///< a multiple of 4
    std::uint64_t bytes = 0;             ///< decompressed, 1 … 65536
};

/// Bytes from one buffer to another one.
struct BufferCopy {
    const Buffer* source = nullptr;
    std::uint64_t sourceOffset = 0;
    const Buffer* destination = nullptr;
    std::uint64_t destinationOffset = 0;
    std::uint64_t bytes = 0; ///< 1 or more
};

} // namespace openntc::harness
