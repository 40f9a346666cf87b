// SPDX-License-Identifier: MIT
// GDeflate tiles that the device decompresses.
#include "VulkanObjects.h"

#include "openntc/container/GDeflate.h"

namespace openntc::harness {

namespace {

Expected<void> CheckTile(const DecompressedTile& tile) {
    if (tile.sourceOffset % 4 != 0 || tile.destinationOffset % 4 != 0 || tile.bytes < 1 ||
        tile.bytes > container::kGDeflateTileBytes || tile.sourceBytes < 1)
        return Fail(Status::OutOfRange,
                    "tile: from %llu to %llu, %llu bytes: multiples of 4, and 1 ... 65536 bytes",
                    static_cast<unsigned long long>(tile.sourceOffset),
                    static_cast<unsigned long long>(tile.destinationOffset),
                    static_cast<unsigned long long>(tile.bytes));
    OPENNTC_CHECK(CheckRange(*tile.source, tile.sourceOffset, tile.sourceBytes));
    return CheckRange(*tile.destination, tile.destinationOffset, tile.bytes);
}

Expected<void> CheckCopy(const BufferCopy& copy) {
    if (copy.bytes < 1)
        return Fail(Status::OutOfRange, "copy: 0 bytes: must be 1 or more");
    OPENNTC_CHECK(CheckRange(*copy.source, copy.sourceOffset, copy.bytes));
    return CheckRange(*copy.destination, copy.destinationOffset, copy.bytes);
}

/// VK_NV_memory_decompression names no stage of its own: all commands, before and after.
void RecordTiles(const vk::raii::CommandBuffer& target,
                 const std::vector<vk::DecompressMemoryRegionNV>& regions) {
    const vk::MemoryBarrier everything(vk::AccessFlagBits::eMemoryWrite,
                                       vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
    const auto wait = [&] {
        target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands,
                               vk::PipelineStageFlagBits::eAllCommands, {}, everything, {}, {});
    };
    wait();
    if (!regions.empty())
        target.decompressMemoryNV(regions);
    wait();
}

} // namespace

Expected<DispatchTiming> Context::Decompress(std::span<const DecompressedTile> tiles,
                                             std::span<const BufferCopy> copies) {
    if (!tiles.empty() && !impl_->info.features.Has(Feature::MemoryDecompression))
        return Fail(Status::Unsupported, "device or feature absent: %s: %s: %s",
                    GetFeatureName(Feature::MemoryDecompression),
                    impl_->info.features.GetAbsence(Feature::MemoryDecompression).c_str(),
                    impl_->info.name.c_str());
    std::vector<vk::DecompressMemoryRegionNV> regions;
    for (const DecompressedTile& tile : tiles) {
        OPENNTC_CHECK(CheckTile(tile));
        regions.emplace_back(tile.source->GetDeviceAddress() + tile.sourceOffset,
                             tile.destination->GetDeviceAddress() + tile.destinationOffset, tile.sourceBytes,
                             tile.bytes, vk::MemoryDecompressionMethodFlagBitsNV::eGdeflate10);
    }
    for (const BufferCopy& copy : copies)
        OPENNTC_CHECK(CheckCopy(copy));
    return Guard("decompression", [&]() -> Expected<DispatchTiming> {
        const bool isTimed = impl_->info.hasTimestamps;
        const auto stamp = [&](const vk::raii::CommandBuffer& target, std::uint32_t query) {
            if (isTimed)
                target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *impl_->queries, query);
        };
        DispatchTiming timing;
        timing.wallSeconds = impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            if (isTimed)
                target.resetQueryPool(*impl_->queries, 0, 2);
            stamp(target, 0);
            RecordTiles(target, regions);
            RecordCopies(target, [&] {
                for (const BufferCopy& copy : copies)
                    target.copyBuffer(*copy.source->GetImpl()->buffer, *copy.destination->GetImpl()->buffer,
                                      vk::BufferCopy(copy.sourceOffset, copy.destinationOffset, copy.bytes));
            });
            stamp(target, 1);
        });
        timing.gpuSeconds = impl_->GetGpuSeconds();
        return timing;
    });
}

} // namespace openntc::harness
