// SPDX-License-Identifier: MIT
// Buffers and memory.
#include "VulkanObjects.h"

#include <algorithm>
#include <cstring>

namespace openntc::harness {

Buffer::Buffer() noexcept = default;
Buffer::Buffer(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;
Buffer::~Buffer() = default;
std::uint64_t Buffer::GetSize() const noexcept {
    return impl_ ? impl_->size : 0;
}
std::uint64_t Buffer::GetDeviceAddress() const noexcept {
    return impl_ ? impl_->address : 0;
}

namespace {

std::optional<std::uint32_t> FindMemoryType(const vk::PhysicalDeviceMemoryProperties& memory,
                                            std::uint32_t allowed, vk::MemoryPropertyFlags wanted) {
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        if ((allowed >> i & 1u) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted)
            return i;
    }
    return std::nullopt;
}

} // namespace

vk::raii::DeviceMemory Context::Impl::Allocate(const vk::MemoryAllocateInfo& allocation) {
    if (allocation.allocationSize > faults.bytes - std::min(allocatedBytes, faults.bytes))
        throw vk::OutOfDeviceMemoryError("as was asked for");
    allocatedBytes += allocation.allocationSize;
    return {device, allocation};
}

std::unique_ptr<Buffer::Impl> Context::Impl::MakeBuffer(std::uint64_t bytes, BufferKind kind,
                                                        vk::BufferUsageFlags usage,
                                                        vk::MemoryPropertyFlags wanted) {
    auto buffer = std::make_unique<Buffer::Impl>();
    buffer->size = bytes;
    buffer->kind = kind;
    buffer->buffer = vk::raii::Buffer(device, vk::BufferCreateInfo({}, bytes, usage));
    const vk::MemoryRequirements needs = buffer->buffer.getMemoryRequirements();
    const auto fallback =
        vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent;
    std::optional<std::uint32_t> type = FindMemoryType(memory, needs.memoryTypeBits, wanted);
    if (!type) // a device must offer host-visible coherent memory for buffers, so this finds one
        type = FindMemoryType(memory, needs.memoryTypeBits, fallback);
    if (!type)
        throw std::runtime_error("no memory type for a buffer");
    const bool isAddressed = static_cast<bool>(usage & vk::BufferUsageFlagBits::eShaderDeviceAddress);
    const vk::MemoryAllocateFlagsInfo flags(vk::MemoryAllocateFlagBits::eDeviceAddress);
    buffer->memory = Allocate(vk::MemoryAllocateInfo(needs.size, *type, isAddressed ? &flags : nullptr));
    buffer->buffer.bindMemory(*buffer->memory, 0);
    if (isAddressed)
        buffer->address = device.getBufferAddress(vk::BufferDeviceAddressInfo(*buffer->buffer));
    if ((memory.memoryTypes[*type].propertyFlags & fallback) == fallback)
        buffer->mapped = static_cast<std::byte*>(buffer->memory.mapMemory(0, VK_WHOLE_SIZE));
    return buffer;
}

void Context::Impl::Copy(vk::Buffer from, std::uint64_t fromOffset, vk::Buffer to, std::uint64_t toOffset,
                         std::uint64_t bytes) {
    Submit([&](const vk::raii::CommandBuffer& target) {
        RecordCopies(target,
                     [&] { target.copyBuffer(from, to, vk::BufferCopy(fromOffset, toOffset, bytes)); });
    });
}

Expected<Buffer> Context::CreateBuffer(std::uint64_t bytes, BufferKind kind, BufferMemory memory) {
    const std::uint64_t limit =
        kind == BufferKind::Uniform ? impl_->info.maxUniformBufferBytes : impl_->info.maxStorageBufferBytes;
    if (bytes == 0 || bytes > limit) {
        return Fail(
            Status::Unsupported, "device or feature absent: %s buffer of %llu bytes: 1 ... %llu on %s",
            kind == BufferKind::Uniform ? "uniform" : "storage", static_cast<unsigned long long>(bytes),
            static_cast<unsigned long long>(limit), impl_->info.name.c_str());
    }
    return Guard("buffer", [&]() -> Expected<Buffer> {
        vk::BufferUsageFlags usage = (kind == BufferKind::Uniform ? vk::BufferUsageFlagBits::eUniformBuffer
                                                                  : vk::BufferUsageFlagBits::eStorageBuffer) |
                                     vk::BufferUsageFlagBits::eTransferSrc |
                                     vk::BufferUsageFlagBits::eTransferDst;
        if (kind == BufferKind::Storage && impl_->info.features.Has(Feature::BufferDeviceAddress))
            usage |= vk::BufferUsageFlagBits::eShaderDeviceAddress;
        vk::MemoryPropertyFlags wanted = vk::MemoryPropertyFlagBits::eDeviceLocal;
        if (memory == BufferMemory::HostVisible) {
            wanted = vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent |
                     vk::MemoryPropertyFlagBits::eHostCached;
        }
        std::unique_ptr<Buffer::Impl> buffer = impl_->MakeBuffer(bytes, kind, usage, wanted);
        if (buffer->mapped != nullptr) {
            std::memset(buffer->mapped, 0, static_cast<std::size_t>(bytes));
        } else {
            impl_->Submit([&](const vk::raii::CommandBuffer& target) {
                target.fillBuffer(*buffer->buffer, 0, VK_WHOLE_SIZE, 0);
            });
        }
        return Buffer(std::move(buffer));
    });
}

Expected<Buffer> Context::CreateBuffer(std::span<const std::byte> contents, BufferKind kind,
                                       BufferMemory memory) {
    // Shaders read whole words.
    const std::uint64_t bytes =
        contents.empty() ? 4 : (static_cast<std::uint64_t>(contents.size()) + 3) / 4 * 4;
    OPENNTC_ASSIGN(Buffer buffer, CreateBuffer(bytes, kind, memory));
    OPENNTC_CHECK(Write(buffer, 0, contents));
    return buffer;
}

Expected<void> CheckRange(const Buffer& buffer, std::uint64_t offset, std::uint64_t bytes) {
    if (offset > buffer.GetSize() || bytes > buffer.GetSize() - offset) {
        return Fail(Status::OutOfRange, "buffer range: %llu + %llu: %llu bytes",
                    static_cast<unsigned long long>(offset), static_cast<unsigned long long>(bytes),
                    static_cast<unsigned long long>(buffer.GetSize()));
    }
    return {};
}

Expected<void> Context::Write(const Buffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes) {
    OPENNTC_CHECK(CheckRange(buffer, offset, bytes.size()));
    if (bytes.empty())
        return {};
    if (std::byte* mapped = buffer.GetImpl()->mapped; mapped != nullptr) {
        std::memcpy(mapped + offset, bytes.data(), bytes.size());
        return {};
    }
    const BufferWrite write{&buffer, offset, bytes};
    return Write(std::span(&write, 1));
}

Expected<void> Context::Write(std::span<const BufferWrite> writes) {
    std::uint64_t bytes = 0;
    for (const BufferWrite& write : writes) {
        OPENNTC_CHECK(CheckRange(*write.buffer, write.offset, write.bytes.size()));
        bytes += write.bytes.size();
    }
    if (bytes == 0)
        return {};
    return Guard("buffer write", [&]() -> Expected<void> {
        if (!impl_->staging || impl_->staging->size < bytes) {
            impl_->staging.reset();
            impl_->staging = impl_->MakeBuffer(
                bytes, BufferKind::Storage, vk::BufferUsageFlagBits::eTransferSrc,
                vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        }
        const auto recordAll = [&](const vk::raii::CommandBuffer& target) {
            std::uint64_t at = 0;
            for (const BufferWrite& write : writes) {
                if (write.bytes.empty())
                    continue;
                std::memcpy(impl_->staging->mapped + at, write.bytes.data(), write.bytes.size());
                target.copyBuffer(*impl_->staging->buffer, *write.buffer->GetImpl()->buffer,
                                  vk::BufferCopy(at, write.offset, write.bytes.size()));
                at += write.bytes.size();
            }
        };
        impl_->Submit(
            [&](const vk::raii::CommandBuffer& target) { RecordCopies(target, [&] { recordAll(target); }); });
        return {};
    });
}

Expected<void> Context::Read(const Buffer& buffer, std::uint64_t offset, std::span<std::byte> bytes) {
    OPENNTC_CHECK(CheckRange(buffer, offset, bytes.size()));
    if (bytes.empty())
        return {};
    const Buffer::Impl& source = *buffer.GetImpl();
    return Guard("buffer read", [&]() -> Expected<void> {
        if (source.mapped != nullptr) {
            std::memcpy(bytes.data(), source.mapped + offset, bytes.size());
            return {};
        }
        const auto staging = impl_->MakeBuffer(
            bytes.size(), BufferKind::Storage, vk::BufferUsageFlagBits::eTransferDst,
            vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        impl_->Copy(*source.buffer, offset, *staging->buffer, 0, bytes.size());
        std::memcpy(bytes.data(), staging->mapped, bytes.size());
        return {};
    });
}

} // namespace openntc::harness
