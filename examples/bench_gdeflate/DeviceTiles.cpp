// SPDX-License-Identifier: MIT
#include "DeviceTiles.h"

#include "vulkan_harness/LatentDecompression.h"

#include <utility>

namespace openntc::bench {

namespace {

using namespace openntc::harness;

/// Every tile of a stream, straight to its place. The writer's tiles are whole words, and so is what comes before them.
Expected<LatentDecompression> PlanStream(std::span<const std::byte> stream) {
    LatentDecompression plan;
    OPENNTC_ASSIGN(const container::GDeflateHeader header, container::DecodeGDeflateHeader(stream));
    plan.uploadBytes = plan.workBytes = detail::AlignToWord(stream.size()) + detail::kLatentReadAhead;
    plan.latentBytes = detail::AlignToWord(header.GetBytes());
    for (std::uint32_t number = 0; number < header.tiles; ++number) {
        OPENNTC_ASSIGN(const container::GDeflateTileRange range,
                       container::FindGDeflateTile(header, stream, stream.size(), number));
        LatentTile tile;
        tile.source = range.offset;
        tile.sourceBytes = static_cast<std::uint32_t>(range.size);
        tile.destination = number * std::uint64_t{container::kGDeflateTileBytes};
        tile.bytes = static_cast<std::uint32_t>(header.GetTileBytes(number));
        OPENNTC_CHECK(plan.tiles.PushBack(tile));
    }
    return plan;
}

class VulkanTiles final : public DeviceTiles {
public:
    VulkanTiles(std::unique_ptr<Context> context, LatentDecompressor&& decompressor, bool byShader)
        : context_(std::move(context)), decompressor_(std::move(decompressor)), byShader_(byShader) {}

    std::string GetName() const override {
        return context_->GetDevice().name + (byShader_ ? ", by a shader" : ", by itself");
    }

    bool Prepare(std::span<const std::byte> stream) override {
        decompressor_.Clear();
        const Expected<LatentDecompression> plan = PlanStream(stream);
        return plan && Make(work_, plan->workBytes) && Make(output_, plan->latentBytes) &&
               context_->Write(work_, 0, stream) && decompressor_.Add(*plan, work_, output_) &&
               decompressor_.Run(); // memory of the driver's own, clocks
    }

    double Decompress() override { return decompressor_.Run().value_or(-1.0); }

    bool Read(std::span<std::byte> output) override { return context_->Read(output_, 0, output).has_value(); }

private:
    bool Make(Buffer& buffer, std::uint64_t bytes) {
        auto made = context_->CreateBuffer(bytes, BufferKind::Storage, BufferMemory::DeviceLocal);
        if (made)
            buffer = std::move(*made);
        return made.has_value();
    }

    std::unique_ptr<Context> context_;
    Buffer work_, output_;
    LatentDecompressor decompressor_;
    bool byShader_;
};

} // namespace

std::unique_ptr<DeviceTiles> DeviceTiles::Create(const std::string& device, bool byShader,
                                                 std::string& reason) {
    ContextOptions options;
    options.device = device;
    auto context = Context::Create(options);
    if (!context) {
        reason = context.error().GetText();
        return nullptr;
    }
    auto decompressor =
        LatentDecompressor::Create(**context, byShader ? TileDecoder::Shader : TileDecoder::Device);
    if (!decompressor) {
        reason = decompressor.error().GetText();
        return nullptr;
    }
    return std::make_unique<VulkanTiles>(std::move(*context), std::move(*decompressor), byShader);
}

} // namespace openntc::bench
