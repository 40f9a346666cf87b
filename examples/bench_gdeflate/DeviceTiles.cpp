// SPDX-License-Identifier: MIT
#include "DeviceTiles.h"

#include "openntc/container/GDeflate.h"
#include "vulkan_harness/Vulkan.h"

#include <chrono>
#include <utility>
#include <vector>

namespace openntc::bench {

namespace {

using namespace openntc::harness;

class VulkanTiles final : public DeviceTiles {
public:
    explicit VulkanTiles(std::unique_ptr<Context> context) : context_(std::move(context)) {}

    std::string GetName() const override {
        return context_->GetDevice().name + ", driver " + context_->GetDevice().driver;
    }

    bool Prepare(std::span<const std::byte> stream) override {
        stream_ = stream;
        tiles_.clear();
        const auto header = container::DecodeGDeflateHeader(stream);
        if (!header || !Make(source_, stream.size() + kReadAhead) ||
            !Make(destination_, static_cast<std::size_t>(header->GetBytes())))
            return false;
        for (std::uint32_t tile = 0; tile < header->tiles; ++tile) {
            const auto range = container::FindGDeflateTile(*header, stream, stream.size(), tile);
            if (!range)
                return false;
            // The writer's tiles are whole words, and so is what comes before them.
            tiles_.push_back({&source_, range->offset, range->size, &destination_,
                              tile * std::uint64_t{container::kGDeflateTileBytes},
                              header->GetTileBytes(tile)});
        }
        DeviceSeconds ignored; // memory of the driver's own, clocks
        return Decompress(ignored);
    }

    bool Decompress(DeviceSeconds& seconds) override {
        const BufferWrite write{&source_, 0, stream_};
        const auto start = std::chrono::steady_clock::now();
        const auto timing = context_->Decompress(std::span(&write, 1), tiles_, {});
        seconds.all = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (timing)
            seconds.tiles = timing->gpuSeconds.value_or(timing->wallSeconds);
        return timing.has_value();
    }

    bool Read(std::span<std::byte> output) override {
        return context_->Read(destination_, 0, output).has_value();
    }

private:
    static constexpr std::size_t kReadAhead = 256; // what lanes may read in advance

    bool Make(Buffer& buffer, std::size_t bytes) {
        auto made =
            context_->CreateBuffer((bytes + 3) / 4 * 4, BufferKind::Storage, BufferMemory::DeviceLocal);
        if (made)
            buffer = std::move(*made);
        return made.has_value();
    }

    std::unique_ptr<Context> context_;
    Buffer source_, destination_;
    std::span<const std::byte> stream_;
    std::vector<DecompressedTile> tiles_;
};

} // namespace

std::unique_ptr<DeviceTiles> DeviceTiles::Create(const std::string& device, std::string& reason) {
    ContextOptions options;
    options.device = device;
    options.required = {Feature::MemoryDecompression};
    auto context = Context::Create(options);
    if (context)
        return std::make_unique<VulkanTiles>(std::move(*context));
    reason = context.error().GetText();
    return nullptr;
}

} // namespace openntc::bench
