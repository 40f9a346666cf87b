// SPDX-License-Identifier: MIT
// Texture sets to textures when a model is loaded: passes/DecompressToTextures for every mip, then passes/CompressBlocks.
#include "Decoder.h"
#include "Failure.h"
#include "renderer/gpu/SetDecoding.h"
#include "renderer/gpu/TextureStore.h"

#include <algorithm>

namespace openntc::renderer {

using namespace openntc::harness;

void TextureStore::DecodeSet(int set, const std::vector<std::pair<Key, SlotPlan>>& textures) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {0, BufferKind::Image, 1, NTC_DECOMPRESS_OUTPUTS}};
    tool::TextureSet& file = *files_[static_cast<std::size_t>(set)];
    const tool::DecodeData data = tool::LoadDecodeData(file);
    const Buffer latents =
        RequireDevice(context_.CreateBuffer(data.latents, BufferKind::Storage, BufferMemory::DeviceLocal));
    const Buffer weights =
        RequireDevice(context_.CreateBuffer(data.weights, BufferKind::Storage, BufferMemory::DeviceLocal));
    std::vector<DecompressionOutput> outputs;
    std::vector<Image> images;
    const TextureSetDesc& desc = file.metadata.GetDesc();
    for (const auto& [key, slot] : textures) {
        outputs.push_back(MakeOutput(slot, std::get<4>(key)));
        images.push_back(RequireDevice(context_.CreateImage(
            GetTexelFormat(slot), static_cast<std::uint32_t>(desc.width),
            static_cast<std::uint32_t>(desc.height), static_cast<std::uint32_t>(desc.mips))));
    }
    SceneNeeds needs;
    needs.device = features_;
    for (int mip = 0; mip < desc.mips; ++mip) {
        DecompressionRequest request;
        request.mip = mip;
        request.outputs = outputs;
        const DecompressionPass pass =
            RequireDevice(MakeDecompressionPass(file.metadata, data.constants, request, needs));
        const ComputePipeline pipeline = RequireDevice(context_.CreateComputePipeline(
            shaders_.Get("DecompressToTextures.comp", ListDefines(pass)), kSlots, 0));
        const Buffer constants = RequireDevice(context_.CreateBuffer(
            std::as_bytes(std::span(&pass.constants, 1)), BufferKind::Uniform, BufferMemory::DeviceLocal));
        const BoundBuffer buffers[] = {{0, &constants}, {1, &latents}, {2, &weights}};
        std::vector<BoundImage> bound;
        for (std::uint32_t i = 0; i < NTC_DECOMPRESS_OUTPUTS; ++i) // an array without holes
            bound.push_back({0, &images[i < images.size() ? i : 0], 1, i, static_cast<std::uint32_t>(mip)});
        DispatchRequest dispatch;
        dispatch.pipeline = &pipeline;
        dispatch.buffers = buffers;
        dispatch.images = bound;
        std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(dispatch.groups));
        const DispatchTiming timing = RequireDevice(context_.Dispatch(dispatch));
        decodeSeconds_ += timing.gpuSeconds.value_or(timing.wallSeconds);
    }
    for (std::size_t i = 0; i < textures.size(); ++i)
        images_.emplace(textures[i].first, Compress(std::move(images[i]), textures[i].second));
}

Image TextureStore::Compress(Image image, const SlotPlan& slot) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Texture}, {1, BufferKind::Storage}};
    if (!slot.block) {
        for (std::uint32_t mip = 0; mip < image.GetMips(); ++mip)
            memory_.decodedTextures += image.GetBytes(mip);
        return image;
    }
    Image result = RequireDevice(
        context_.CreateImage(GetStoredFormat(slot), image.GetWidth(), image.GetHeight(), image.GetMips()));
    for (std::uint32_t mip = 0; mip < image.GetMips(); ++mip) {
        bc::BlockCompressionDesc desc = MakeBlockDesc(slot, options_.effort, features_);
        desc.width = desc.sourceWidth = static_cast<std::int32_t>(std::max(image.GetWidth() >> mip, 1u));
        desc.height = desc.sourceHeight = static_cast<std::int32_t>(std::max(image.GetHeight() >> mip, 1u));
        desc.sourceMip = static_cast<std::int32_t>(mip);
        const bc::BlockCompressionPass pass = RequireDevice(bc::MakeBlockCompressionPass(desc));
        const ComputePipeline pipeline = RequireDevice(context_.CreateComputePipeline(
            shaders_.Get("CompressBlocks.comp", SplitDefines(pass.defines.View())), kSlots,
            sizeof pass.constants));
        const Buffer blocks = RequireDevice(
            context_.CreateBuffer(pass.destinationWords * 4, BufferKind::Storage, BufferMemory::DeviceLocal));
        const BoundBuffer buffers[] = {{1, &blocks}};
        const BoundImage images[] = {{0, &image}};
        DispatchRequest dispatch;
        dispatch.pipeline = &pipeline;
        dispatch.buffers = buffers;
        dispatch.images = images;
        dispatch.pushConstants = std::as_bytes(std::span(&pass.constants, 1));
        std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(dispatch.groups));
        const DispatchTiming timing = RequireDevice(context_.Dispatch(dispatch));
        transcodeSeconds_ += timing.gpuSeconds.value_or(timing.wallSeconds);
        RequireDevice(context_.Copy(blocks, result, mip));
        memory_.blockTextures += result.GetBytes(mip);
    }
    return result;
}

} // namespace openntc::renderer
