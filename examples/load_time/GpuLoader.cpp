// SPDX-License-Identifier: MIT
#include "GpuLoader.h"

#include "load_time_shaders.h"

#include "Failure.h"

#include "openntc/bc/CompressionPass.h"
#include "openntc/passes/DecompressionPass.h"
#include "vulkan_harness/LatentDecompression.h"
#include "vulkan_harness/MatrixProbe.h"
#include "vulkan_harness/Vulkan.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>
#include <utility>

namespace openntc::load_time {

namespace {

using namespace openntc::harness;
using tool::ExitCode;

constexpr const char* kSubject = "vulkan";

template <typename T>
T Require(Expected<T>&& value) {
    const bool isAbsent = !value && value.error().GetStatus() == Status::Unsupported;
    return tool::Require(std::move(value), isAbsent ? ExitCode::NoDevice : ExitCode::Failed, kSubject);
}

/// Of four channels, because every device stores to these.
ImageFormat GetImageFormat(const tool::TextureFormat& format) {
    switch (format.number) {
    case tool::TexelNumber::Unorm16:
        return ImageFormat::RGBA16;
    case tool::TexelNumber::Half:
        return ImageFormat::RGBA16F;
    case tool::TexelNumber::Float:
        return ImageFormat::RGBA32F;
    case tool::TexelNumber::Unorm8:
    case tool::TexelNumber::Snorm8:
        break;
    }
    return ImageFormat::RGBA8;
}

int GetUnormBits(const tool::TextureFormat& format) {
    switch (GetImageFormat(format)) {
    case ImageFormat::RGBA8:
        return 8;
    case ImageFormat::RGBA16:
        return 16;
    default:
        return 0;
    }
}

bc::BlockCompressionDesc MakeBlockDesc(const tool::TextureFormat& format, tool::BlockEffort effort,
                                       const ColorMip& size) {
    bc::BlockCompressionDesc desc;
    desc.format = *format.block;
    desc.quality = tool::ToBlockQuality(effort);
    desc.width = desc.sourceWidth = size.width;
    desc.height = desc.sourceHeight = size.height;
    desc.source = bc::PassMemory::Image;
    desc.destination = bc::PassMemory::Buffer;
    if (desc.format == bc::BlockFormat::Bc1 && format.hasAlpha)
        desc.alphaThreshold = tool::kBc1OpaqueAlpha - 1;
    return desc;
}

bc::BlockRect CoverMip(const ColorMip& size) {
    return {0, 0, bc::CountBlocks(static_cast<std::uint32_t>(size.width)),
            bc::CountBlocks(static_cast<std::uint32_t>(size.height))};
}

/// A dispatch with what it refers to. Kept in a deque, so that addresses stay.
struct Work {
    ComputePipeline pipeline;
    Buffer constants;
    NtcDecompressConstants constantValues{};
    std::vector<std::byte> pushConstants;
    std::vector<BoundBuffer> buffers;
    std::vector<BoundImage> images;
    std::uint32_t groups[3] = {1, 1, 1};
};

/// What a batch keeps on the device.
struct Batch {
    std::deque<Buffer> inputs; // latents, weights and hints
    std::deque<std::vector<std::int32_t>> hints;
    std::deque<Array<std::byte>> weights; // of cooperative matrices
    std::vector<BufferWrite> writes;
    std::deque<Image> images;
    std::deque<Buffer> blocks;
    std::vector<std::uint64_t> blockBytes; // of `blocks`
    std::deque<Work> decodings, transcodings;
};

class VulkanLoader final : public GpuLoader {
public:
    explicit VulkanLoader(std::unique_ptr<Context> context) : context_(std::move(context)) {
        const DeviceInfo& device = context_->GetDevice();
        needs_.device.integerDotProduct = device.features.Has(Feature::IntegerDotProduct);
        needs_.device.subgroupShuffle = device.hasSubgroupShuffle && device.subgroupSize >= 8;
        needs_.device.isCpu = device.isCpu;
        // Fastest: matrices where a device has them, with the texels of INT8.
        const auto layout = ProbeCoopMat(*context_);
        needs_.preference =
            DescribeMatrices(layout, needs_.device) ? MathPreference::Fastest : MathPreference::Exact;
        layout_ = layout ? *layout : std::nullopt;
        if (!load_time_shaders::FindShader("DecompressToTextures.comp",
                                           "NETWORK_VERSION=1 NTC_MATH=8 NTC_COOPMAT_LANES=1"))
            needs_.preference = MathPreference::Exact; // built without them
    }

    std::string GetDeviceName() const override {
        return context_->GetDevice().name + ", driver " + context_->GetDevice().driver;
    }

    void UseDecompressor(Decompressor decompressor) override {
        if (decompressor != Decompressor::Cpu)
            decompressor_ = tool::Require(
                LatentDecompressor::Create(
                    *context_, decompressor == Decompressor::Gpu ? TileDecoder::Device : TileDecoder::Shader),
                ExitCode::NoDevice, "--decompress");
    }

    bool HasShader(bc::BlockFormat format, tool::BlockEffort effort) const override {
        tool::TextureFormat texture;
        texture.block = format;
        ColorMip size;
        size.width = size.height = 4;
        const auto pass = bc::MakeBlockCompressionPass(MakeBlockDesc(texture, effort, size));
        return pass && load_time_shaders::FindShader("CompressBlocks.comp", pass->defines.View()).has_value();
    }

    GpuTimes Load(std::span<const GpuSet> sets, tool::BlockEffort effort) override {
        batch_ = Batch();
        if (decompressor_)
            decompressor_->Clear();
        for (const GpuSet& set : sets)
            AddSet(set, effort);
        // All decoding, and when it has ended all transcoding: none of either waits for another of its kind.
        std::vector<DispatchRequest> requests;
        for (const std::deque<Work>* kind : {&batch_.decodings, &batch_.transcodings}) {
            bool overlaps = false;
            for (const Work& work : *kind) {
                DispatchRequest request;
                request.pipeline = &work.pipeline;
                request.buffers = work.buffers;
                request.images = work.images;
                request.pushConstants = work.pushConstants;
                request.overlapsPrevious = std::exchange(overlaps, true);
                std::copy(std::begin(work.groups), std::end(work.groups), std::begin(request.groups));
                requests.push_back(request);
            }
        }
        if (!context_->GetDevice().isCpu) { // a GPU's clocks have fallen by now
            Require(context_->Write(batch_.writes));
            Decompress();
            Require(context_->DispatchBatch(requests));
        }
        const auto start = std::chrono::steady_clock::now();
        Require(context_->Write(batch_.writes));
        const std::chrono::duration<double, std::milli> upload = std::chrono::steady_clock::now() - start;
        GpuTimes times;
        times.upload = upload.count();
        times.decompress = Decompress();
        const BatchTiming timing = Require(context_->DispatchBatch(requests));
        if (timing.gpuSeconds.empty()) {
            times.decode = timing.wallSeconds * 1e3; // a device without a clock tells only the sum
            return times;
        }
        times.decode = timing.gpuSeconds.front() * 1e3;
        if (!batch_.transcodings.empty())
            times.transcode = timing.gpuSeconds.back() * 1e3;
        return times;
    }

    std::vector<std::vector<std::byte>> ReadBlocks() override {
        std::vector<std::vector<std::byte>> all;
        for (std::size_t i = 0; i < batch_.blocks.size(); ++i) {
            std::vector<std::byte>& bytes = all.emplace_back(static_cast<std::size_t>(batch_.blockBytes[i]));
            Require(context_->Read(batch_.blocks[i], 0, bytes));
        }
        return all;
    }

private:
    /// Milliseconds.
    double Decompress() {
        return decompressor_ && !decompressor_->IsEmpty() ? Require(decompressor_->Run()) * 1e3 : 0.0;
    }

    /// Latents as decoding reads them.
    const Buffer& AddLatents(const GpuSet& set) {
        if (set.compressed == nullptr)
            return AddInput(set.data->latents);
        const LatentDecompression& plan = set.compressed->plan;
        const Buffer& work = AddBuffer(plan.workBytes);
        const Buffer& latents = AddBuffer(plan.latentBytes);
        batch_.writes.push_back({&work, 0, set.compressed->upload});
        Require(decompressor_->Add(plan, work, latents));
        return latents;
    }

    void AddSet(const GpuSet& set, tool::BlockEffort effort) {
        const Buffer& latents = AddLatents(set);
        const Buffer& weights = AddInput(GetPassWeights(set));
        for (int mip = 0; mip < set.metadata->GetDesc().mips; ++mip) {
            const std::size_t firstImage = batch_.images.size();
            AddDecoding(set, mip, latents, weights);
            const ColorMip& size = set.metadata->GetColorMips()[static_cast<std::size_t>(mip)];
            for (std::size_t i = 0; i < set.textures.size(); ++i) {
                if (!set.formats[i].block)
                    continue;
                std::vector<std::int32_t>& hints = batch_.hints.emplace_back();
                set.hints[i].Get(static_cast<std::uint32_t>(mip), CoverMip(size), hints);
                AddTranscoding(MakeBlockDesc(set.formats[i], effort, size), batch_.images[firstImage + i],
                               hints);
            }
        }
    }

    /// The weights of the set's decompression passes: they are all of one form.
    std::span<const std::byte> GetPassWeights(const GpuSet& set) {
        const DecompressionOutput any;
        DecompressionRequest request;
        request.outputs = std::span(&any, 1);
        const DecompressionPass pass =
            Require(MakeDecompressionPass(*set.metadata, set.data->constants, request, needs_));
        if (pass.permutation.weightType != InferenceWeightType::CoopMatInt8)
            return set.data->weights;
        return batch_.weights
            .emplace_back(Require(MakeCoopMatWeights(set.metadata->GetNetworkVersion(), set.data->weights,
                                                     pass.permutation.key.matrixLanes ? &*layout_ : nullptr)))
            .AsSpan();
    }

    const Buffer& AddBuffer(std::uint64_t bytes) {
        return batch_.inputs.emplace_back(
            Require(context_->CreateBuffer(bytes, BufferKind::Storage, BufferMemory::DeviceLocal)));
    }

    /// A buffer for what is uploaded when time runs. `bytes` must stay until then.
    const Buffer& AddInput(std::span<const std::byte> bytes) {
        const std::uint64_t words = std::max<std::uint64_t>((bytes.size() + 3) / 4, 1); // shaders read words
        const Buffer& buffer = AddBuffer(4 * words);
        batch_.writes.push_back({&buffer, 0, bytes});
        return buffer;
    }

    void AddDecoding(const GpuSet& set, int mip, const Buffer& latents, const Buffer& weights) {
        static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                                {1, BufferKind::Storage},
                                                {2, BufferKind::Storage},
                                                {0, BufferKind::Image, 1, NTC_DECOMPRESS_OUTPUTS}};
        const ColorMip& size = set.metadata->GetColorMips()[static_cast<std::size_t>(mip)];
        const std::size_t firstImage = batch_.images.size();
        std::vector<DecompressionOutput> outputs;
        for (std::size_t i = 0; i < set.textures.size(); ++i) {
            const tool::TextureFormat& format = set.formats[i];
            DecompressionOutput output;
            output.firstChannel = set.textures[i]->firstChannel;
            output.numChannels = std::min(set.textures[i]->numChannels, format.channels);
            output.rgbColorSpace = format.srgb ? ColorSpace::sRGB : ColorSpace::Linear;
            output.unormBits = GetUnormBits(format);
            outputs.push_back(output);
            batch_.images.push_back(
                Require(context_->CreateImage(GetImageFormat(format), static_cast<std::uint32_t>(size.width),
                                              static_cast<std::uint32_t>(size.height))));
        }
        DecompressionRequest request;
        request.mip = mip;
        request.outputs = outputs;
        for (int batches = 1; request.batch < batches; ++request.batch) {
            const DecompressionPass pass =
                Require(MakeDecompressionPass(*set.metadata, set.data->constants, request, needs_));
            batches = pass.batchCount;
            const auto shader = Require(load_time_shaders::FindCoveringShader(
                "DecompressToTextures.comp", pass.permutation.key, pass.GetOwnDefines()));
            Work& work = batch_.decodings.emplace_back();
            work.pipeline = Require(context_->CreateComputePipeline(shader.words, kSlots, 0));
            work.constantValues = pass.constants;
            work.constants = Require(context_->CreateBuffer(sizeof pass.constants, BufferKind::Uniform,
                                                            BufferMemory::DeviceLocal));
            batch_.writes.push_back({&work.constants, 0, std::as_bytes(std::span(&work.constantValues, 1))});
            work.buffers = {{0, &work.constants}, {1, &latents}, {2, &weights}};
            const std::size_t first = static_cast<std::size_t>(request.batch) * NTC_DECOMPRESS_OUTPUTS;
            for (std::uint32_t i = 0; i < NTC_DECOMPRESS_OUTPUTS; ++i) // an array without holes
                work.images.push_back(
                    {0, &batch_.images[firstImage + (first + i < outputs.size() ? first + i : 0)], 1, i});
            std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(work.groups));
        }
    }

    /// `hints`: one a block, or none. They must stay.
    void AddTranscoding(bc::BlockCompressionDesc desc, const Image& image,
                        std::span<const std::int32_t> hints) {
        static constexpr BufferSlot kSlots[] = {
            {0, BufferKind::Texture}, {1, BufferKind::Storage}, {2, BufferKind::Storage}};
        desc.hasHints = !hints.empty();
        // Drivers on the CPU have it too, and gain nothing.
        desc.integerDotProduct = needs_.device.integerDotProduct && !needs_.device.isCpu;
        const bc::BlockCompressionPass pass = Require(bc::MakeBlockCompressionPass(desc));
        const std::span<const std::uint32_t> spirv =
            Require(load_time_shaders::FindShader("CompressBlocks.comp", pass.defines.View()));
        Work& work = batch_.transcodings.emplace_back();
        work.pipeline = Require(context_->CreateComputePipeline(
            spirv, std::span(kSlots).first(desc.hasHints ? 3 : 2), sizeof pass.constants));
        const auto constants = std::as_bytes(std::span(&pass.constants, 1));
        work.pushConstants.assign(constants.begin(), constants.end());
        batch_.blocks.push_back(Require(context_->CreateBuffer(pass.destinationWords * 4, BufferKind::Storage,
                                                               BufferMemory::DeviceLocal)));
        batch_.blockBytes.push_back(pass.destinationWords * 4);
        work.buffers = {{1, &batch_.blocks.back()}};
        if (desc.hasHints)
            work.buffers.push_back({2, &AddInput(std::as_bytes(hints))});
        work.images = {{0, &image}};
        std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(work.groups));
    }

    std::unique_ptr<Context> context_;
    SceneNeeds needs_;
    std::optional<CoopMatLayout> layout_;
    std::optional<LatentDecompressor> decompressor_; // none: the CPU
    Batch batch_;
};

} // namespace

std::unique_ptr<GpuLoader> GpuLoader::Create(const std::string& device) {
    ContextOptions options;
    options.device = device;
    options.required = {Feature::StorageImages};
    return std::make_unique<VulkanLoader>(Require(Context::Create(options)));
}

} // namespace openntc::load_time
