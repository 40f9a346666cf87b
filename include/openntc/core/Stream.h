// SPDX-License-Identifier: MIT
// Stability: stable
// Byte streams: the interface that applications may implement, and the memory implementations.
#pragma once

#include "openntc/core/Allocator.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A seekable byte stream. Transfers are all-or-nothing; a transfer of zero bytes succeeds. Not thread-safe.
class Stream {
public:
    virtual ~Stream() = default;

    /// Reads exactly `bytes` bytes at the current position and advances it; false if fewer are left or on
    /// failure.
    [[nodiscard]] virtual bool Read(void* destination, std::size_t bytes) noexcept = 0;

    /// Writes exactly `bytes` bytes at the current position and advances it; false on failure or a read-only
    /// stream.
    [[nodiscard]] virtual bool Write(const void* source, std::size_t bytes) noexcept = 0;

    /// Reads exactly `bytes` bytes at `offset`, as Seek and Read, for streams that can do it in one call;
    /// false as those. Where the stream is afterwards is not said.
    [[nodiscard]] virtual bool ReadAt(std::uint64_t offset, void* destination, std::size_t bytes) noexcept {
        return Seek(offset) && Read(destination, bytes);
    }

    /// Moves to `offset` bytes from the start, 0 … Size() inclusive; false if the stream cannot be there.
    [[nodiscard]] virtual bool Seek(std::uint64_t offset) noexcept = 0;

    /// The current position in bytes from the start.
    virtual std::uint64_t Tell() noexcept = 0;

    /// The size in bytes, or 0 if it cannot be known.
    virtual std::uint64_t Size() noexcept = 0;

    /// All bytes of the stream, if they lie in memory: readers of many small pieces copy from there, without
    /// calls. Valid until the next write. Empty, as here, if they have to be read.
    virtual std::span<const std::byte> GetMemory() noexcept { return {}; }
};

/// Reads a block of memory that the caller keeps alive.
class ReadOnlyMemoryStream final : public Stream {
public:
    explicit ReadOnlyMemoryStream(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

    bool Read(void* destination, std::size_t bytes) noexcept override {
        if (bytes > bytes_.size() - position_)
            return false;
        if (bytes > 0)
            std::memcpy(destination, bytes_.data() + position_, bytes);
        position_ += bytes;
        return true;
    }
    bool Write(const void*, std::size_t) noexcept override { return false; }
    bool Seek(std::uint64_t offset) noexcept override {
        if (offset > bytes_.size())
            return false;
        position_ = static_cast<std::size_t>(offset);
        return true;
    }
    std::uint64_t Tell() noexcept override { return position_; }
    std::uint64_t Size() noexcept override { return bytes_.size(); }
    std::span<const std::byte> GetMemory() noexcept override { return bytes_; }

private:
    std::span<const std::byte> bytes_;
    std::size_t position_ = 0;
};

/// Owns a block of memory that grows as it is written.
class MemoryStream final : public Stream {
public:
    explicit MemoryStream(Allocator& allocator = GetDefaultAllocator()) noexcept : bytes_(allocator) {}

    bool Read(void* destination, std::size_t bytes) noexcept override {
        if (bytes > bytes_.size() - position_)
            return false;
        if (bytes > 0)
            std::memcpy(destination, bytes_.data() + position_, bytes);
        position_ += bytes;
        return true;
    }
    bool Write(const void* source, std::size_t bytes) noexcept override {
        const std::byte* from = static_cast<const std::byte*>(source);
        const std::size_t left = bytes_.size() - position_;
        const std::size_t replaced = bytes < left ? bytes : left;
        if (!bytes_.Append(std::span(from + replaced, bytes - replaced)))
            return false;
        if (replaced > 0)
            std::memcpy(bytes_.data() + position_, from, replaced);
        position_ += bytes;
        return true;
    }
    bool Seek(std::uint64_t offset) noexcept override {
        if (offset > bytes_.size())
            return false;
        position_ = static_cast<std::size_t>(offset);
        return true;
    }
    std::uint64_t Tell() noexcept override { return position_; }
    std::uint64_t Size() noexcept override { return bytes_.size(); }
    std::span<const std::byte> GetMemory() noexcept override { return GetBytes(); }

    std::span<const std::byte> GetBytes() const noexcept { return bytes_.AsSpan(); }

private:
    Array<std::byte> bytes_;
    std::size_t position_ = 0;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
