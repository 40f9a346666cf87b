// SPDX-License-Identifier: MIT
#include "VulkanDecoder.h"

#include "vulkan_harness/GpuDecoder.h"

#include <utility>

namespace openntc::tool {

namespace {

class VulkanBackend final : public Decoder {
public:
    VulkanBackend(std::unique_ptr<harness::Context> context, harness::GpuDecoder&& decoder)
        : context_(std::move(context)), decoder_(std::move(decoder)) {}

    Expected<void> Decode(int mip, Rect rect, const DecodeOptions& options,
                          std::span<float> outputs) override {
        OPENNTC_ASSIGN(const harness::GpuDecodeTiming timing, decoder_.Decode(mip, rect, options, outputs));
        seconds_ = timing.gpuSeconds;
        return {};
    }
    Expected<bool> Rebind(const DecodeData& data) override {
        OPENNTC_CHECK(decoder_.SetSource(data.GetSource()));
        return true;
    }
    int GetTileSize() const override { return 64; } // a dispatch costs more than its texels
    std::optional<double> GetDeviceSeconds() const override { return seconds_; }
    std::string GetDeviceName() const override {
        return context_->GetDevice().name + ", driver " + context_->GetDevice().driver;
    }

private:
    std::unique_ptr<harness::Context> context_; // before the decoder, which needs it to the end
    harness::GpuDecoder decoder_;
    std::optional<double> seconds_;
};

} // namespace

Expected<std::unique_ptr<Decoder>> MakeVulkanDecoder(const DecodeData& data, const std::string& device,
                                                     bool onMatrices) {
    harness::ContextOptions options;
    options.device = device;
    OPENNTC_ASSIGN(std::unique_ptr<harness::Context> context, harness::Context::Create(options));
    harness::GpuDecoderOptions decoderOptions;
    decoderOptions.matrices = onMatrices ? harness::MatrixUse::Required : harness::MatrixUse::None;
    OPENNTC_ASSIGN(harness::GpuDecoder decoder,
                   harness::GpuDecoder::Create(*context, data.GetSource(), decoderOptions));
    return std::make_unique<VulkanBackend>(std::move(context), std::move(decoder));
}

} // namespace openntc::tool
