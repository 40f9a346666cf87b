// SPDX-License-Identifier: MIT
// Texture sets to textures when a model is loaded: passes/DecompressToTextures for every mip, then passes/CompressBlocks.
#include "Decoder.h"
#include "Failure.h"
#include "renderer/gpu/TextureStore.h"

#include "openntc/bc/CompressionPass.h"
#include "openntc/passes/DecompressionPass.h"

#include <algorithm>
#include <sstream>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

std::vector<std::string> SplitDefines(std::string_view text) {
    std::istringstream words{std::string(text)};
    std::vector<std::string> defines;
    for (std::string word; words >> word;)
        defines.push_back(word);
    return defines;
}

/// How a slot's texture is stored: what a set holds of colours as sRGB codes, all else as it is.
DecompressionOutput MakeOutput(const SlotPlan& slot, bool isColor) {
    DecompressionOutput output;
    output.firstChannel = slot.firstChannel;
    output.numChannels = std::min(slot.channels, 4);
    output.rgbColorSpace = isColor && !slot.isLinear ? ColorSpace::sRGB : ColorSpace::Linear;
    output.unormBits = slot.isLinear ? 0 : 8;
    return output;
}

ImageFormat ToImageFormat(bc::BlockFormat format) {
    return static_cast<ImageFormat>(static_cast<int>(ImageFormat::BC1) + static_cast<int>(format));
}

} // namespace

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
            slot.isLinear ? ImageFormat::RGBA16F : ImageFormat::RGBA8, static_cast<std::uint32_t>(desc.width),
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
        std::vector<std::string> defines = SplitDefines(pass.permutation.key.ToDefines().View());
        if (!pass.convertsColors)
            defines.emplace_back(pass.GetOwnDefines());
        const ComputePipeline pipeline = RequireDevice(
            context_.CreateComputePipeline(shaders_.Get("DecompressToTextures.comp", defines), kSlots, 0));
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
    const std::optional<bc::BlockFormat>& format = slot.block;
    if (!format) {
        for (std::uint32_t mip = 0; mip < image.GetMips(); ++mip)
            memory_.decodedTextures += image.GetBytes(mip);
        return image;
    }
    Image result = RequireDevice(
        context_.CreateImage(ToImageFormat(*format), image.GetWidth(), image.GetHeight(), image.GetMips()));
    for (std::uint32_t mip = 0; mip < image.GetMips(); ++mip) {
        bc::BlockCompressionDesc desc;
        desc.format = *format;
        desc.quality = tool::ToBlockQuality(options_.effort);
        desc.width = desc.sourceWidth = static_cast<std::int32_t>(std::max(image.GetWidth() >> mip, 1u));
        desc.height = desc.sourceHeight = static_cast<std::int32_t>(std::max(image.GetHeight() >> mip, 1u));
        desc.sourceMip = static_cast<std::int32_t>(mip);
        desc.integerDotProduct = features_.integerDotProduct && !features_.isCpu;
        if (*format == bc::BlockFormat::Bc1 && slot.channels == 4)
            desc.alphaThreshold = tool::kBc1OpaqueAlpha - 1;
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
