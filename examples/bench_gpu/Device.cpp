// SPDX-License-Identifier: MIT
// Buffers, memory and the conversion of weights.
#include "DeviceObjects.h"

#include <cstring>

namespace openntc::bench {

DeviceBuffer Device::Impl::Allocate(std::uint64_t size, VkMemoryPropertyFlags wanted) {
    VkBufferCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    Check(vkCreateBuffer(device, &info, nullptr, &buffer), "vkCreateBuffer");
    VkMemoryRequirements needs = {};
    vkGetBufferMemoryRequirements(device, buffer, &needs);
    std::uint32_t type = 0;
    while (type < memory.memoryTypeCount && ((needs.memoryTypeBits >> type & 1u) == 0 ||
                                             (memory.memoryTypes[type].propertyFlags & wanted) != wanted))
        ++type;
    VkMemoryAllocateInfo allocation = {};
    allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = type;
    VkDeviceMemory block = VK_NULL_HANDLE;
    Check(vkAllocateMemory(device, &allocation, nullptr, &block), "vkAllocateMemory");
    Check(vkBindBufferMemory(device, buffer, block, 0), "vkBindBufferMemory");
    return {ToNumber(buffer), ToNumber(block), size};
}

void Device::Impl::Begin() {
    VkCommandBufferBeginInfo begin = {};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    Check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
}

void Device::Impl::EndAndWait() {
    Check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit = {};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    Check(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    Check(vkQueueWaitIdle(queue), "vkQueueWaitIdle");
}

void Device::Impl::Copy(std::uint64_t from, std::uint64_t to, std::uint64_t size) {
    Begin();
    const VkBufferCopy region = {0, 0, size};
    vkCmdCopyBuffer(commands, FromNumber<VkBuffer>(from), FromNumber<VkBuffer>(to), 1, &region);
    EndAndWait();
}

namespace {
constexpr VkMemoryPropertyFlags kStaging =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
}

DeviceBuffer Device::CreateBuffer(std::uint64_t size, std::span<const std::byte> contents) {
    DeviceBuffer buffer = impl_->Allocate(size, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (!contents.empty()) {
        DeviceBuffer staging = impl_->Allocate(contents.size(), kStaging);
        void* mapped = nullptr;
        Check(impl_->vkMapMemory(impl_->device, FromNumber<VkDeviceMemory>(staging.memory), 0, VK_WHOLE_SIZE,
                                 0, &mapped),
              "vkMapMemory");
        std::memcpy(mapped, contents.data(), contents.size());
        impl_->Copy(staging.handle, buffer.handle, contents.size());
        DestroyBuffer(staging);
    }
    return buffer;
}

void Device::DestroyBuffer(DeviceBuffer& buffer) {
    impl_->vkDestroyBuffer(impl_->device, FromNumber<VkBuffer>(buffer.handle), nullptr);
    impl_->vkFreeMemory(impl_->device, FromNumber<VkDeviceMemory>(buffer.memory), nullptr);
    buffer = {};
}

std::vector<std::byte> Device::Read(const DeviceBuffer& buffer, std::uint64_t size) {
    DeviceBuffer staging = impl_->Allocate(size, kStaging);
    impl_->Copy(buffer.handle, staging.handle, size);
    void* mapped = nullptr;
    Check(impl_->vkMapMemory(impl_->device, FromNumber<VkDeviceMemory>(staging.memory), 0, VK_WHOLE_SIZE, 0,
                             &mapped),
          "vkMapMemory");
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    std::memcpy(bytes.data(), mapped, bytes.size());
    DestroyBuffer(staging);
    return bytes;
}

std::vector<std::byte> Device::ConvertWeights(CoopVecWeights& weights) {
    const auto convert = [&](CoopVecMatrix& matrix, void* destination) {
        VkConvertCooperativeVectorMatrixInfoNV info = {};
        info.sType = VK_STRUCTURE_TYPE_CONVERT_COOPERATIVE_VECTOR_MATRIX_INFO_NV;
        FillCoopVecConversion(matrix, info);
        info.srcData.hostAddress = weights.matrices.data() + matrix.sourceOffset;
        info.dstData.hostAddress = destination;
        Check(impl_->convert(impl_->device, &info), "vkConvertCooperativeVectorMatrixNV");
    };
    for (CoopVecMatrix& matrix : weights.layers)
        convert(matrix, nullptr);
    if (const Expected<void> done = LayOutCoopVecWeights(weights); !done)
        throw DeviceFailure(done.error().GetText());
    std::vector<std::byte> bytes(weights.size);
    for (CoopVecMatrix& matrix : weights.layers)
        convert(matrix, bytes.data() + matrix.destinationOffset);
    std::memcpy(bytes.data() + weights.tailOffset, weights.tail.data(), weights.tail.size());
    return bytes;
}

} // namespace openntc::bench
