// SPDX-License-Identifier: MIT
// Stability: stable
// A texture set being put together for writing: the document and the bytes of its views, in the form of
// LibNTC 0.7.2. Call order gives the order of views: networks (Int8, then FP8), textures, latent images.
#pragma once

#include "openntc/container/Writer.h"
#include "openntc/core/Allocator.h"
#include "openntc/texture_set/InferenceWeights.h"
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/MipChain.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

class WritableTextureSet {
public:
    explicit WritableTextureSet(Allocator& allocator = GetDefaultAllocator()) noexcept
        : document_(), bytes_(allocator), views_(allocator) {}

    /// Sizes, shape and channels. Odd channel counts become even, as LibNTC writes them; the channel added is
    /// Linear and belongs to no texture. `channelColorSpaces` holds 2 bits per channel. Errors: OutOfRange.
    Expected<void> SetDescription(const TextureSetDesc& desc, const LatentShape& shape,
                                  std::uint32_t channelColorSpaces) noexcept;

    /// Adds the weights of one storage form; none in `weights` is no error. Errors: InvalidArgument,
    /// OutOfMemory.
    Expected<void> AddNetwork(const InferenceWeights& weights, InferenceWeightType type) noexcept;

    /// Adds a texture with its BC7 statistics. Errors: OutOfMemory.
    Expected<void> AddTexture(const Texture& texture) noexcept;

    /// Adds a latent image; widths and heights of the grids are used, the latents are packed words
    /// (GetLatentGridBytes). Errors: InvalidArgument for data of another size, OutOfMemory.
    Expected<void> AddLatentImage(const LatentImage& image, std::span<const std::byte> highRes,
                                  std::span<const std::byte> lowRes) noexcept;

    /// Adds the next mip. Errors: OutOfMemory.
    Expected<void> AddColorMip(const ColorMip& mip) noexcept;

    /// The document so far; views are laid out when writing.
    container::Document& GetDocument() noexcept { return document_; }

    /// Writes the complete file from position 0 of the stream. Errors: those of container::WriteContainer.
    Expected<void> Write(Stream& destination) noexcept;

private:
    struct Extent {
        std::size_t offset;
        std::size_t size;
    };

    Expected<std::uint32_t> AddView(std::span<const std::byte> data) noexcept;

    container::Document document_;
    Array<std::byte> bytes_; // of all views
    Array<Extent> views_;    // in bytes_
};

inline Expected<std::uint32_t> WritableTextureSet::AddView(std::span<const std::byte> data) noexcept {
    const std::size_t offset = bytes_.size();
    if (data.size() > std::numeric_limits<std::size_t>::max() / 4 - offset)
        return Fail(Status::OutOfMemory, "views: %zu bytes: address space", data.size());
    const std::size_t size = offset + data.size();
    OPENNTC_CHECK(
        bytes_.Reserve(std::max(size, 2 * offset))); // may exceed the need: growth stays linear in total
    OPENNTC_CHECK(bytes_.Resize(size));
    if (!data.empty())
        std::memcpy(bytes_.data() + offset, data.data(), data.size());
    OPENNTC_CHECK(views_.PushBack({offset, data.size()}));
    return static_cast<std::uint32_t>(views_.size() - 1);
}

inline Expected<void> WritableTextureSet::SetDescription(const TextureSetDesc& desc, const LatentShape& shape,
                                                         std::uint32_t channelColorSpaces) noexcept {
    OPENNTC_CHECK(ValidateTextureSetDesc(desc));
    OPENNTC_CHECK(detail::ValidateLatentEncoding(shape, NTC_NETWORK_UNKNOWN));
    document_.width = static_cast<std::uint32_t>(desc.width);
    document_.height = static_cast<std::uint32_t>(desc.height);
    document_.numChannels = static_cast<std::uint32_t>(desc.channels + desc.channels % 2);
    document_.numColorMips = static_cast<std::uint32_t>(desc.mips);
    document_.latentShape = container::LatentShapeRecord{
        static_cast<std::uint32_t>(shape.highResFeatures), static_cast<std::uint32_t>(shape.highResQuantBits),
        static_cast<std::uint32_t>(shape.lowResFeatures), static_cast<std::uint32_t>(shape.lowResQuantBits)};
    document_.channels.clear();
    for (int c = 0; c < static_cast<int>(document_.numChannels); ++c) {
        container::ChannelRecord record;
        const std::uint32_t space = c < desc.channels ? (channelColorSpaces >> (2 * c)) & 3u : 0u;
        if (space > static_cast<std::uint32_t>(ColorSpace::HLG))
            return Fail(Status::OutOfRange, "channels[%d].colorSpace: %u: must be 0 … 2", c, space);
        record.colorSpace = static_cast<ColorSpace>(space);
        OPENNTC_CHECK(document_.channels.PushBack(record));
    }
    return {};
}

inline Expected<void> WritableTextureSet::AddNetwork(const InferenceWeights& weights,
                                                     InferenceWeightType type) noexcept {
    using container::MlpDataType;
    const std::span<const std::byte> buffer = weights.Get(type);
    if (buffer.empty())
        return {};
    const bool isFP8 = type == InferenceWeightType::GenericFP8;
    const NetworkDescription network = GetNetworkDescription(weights.networkVersion);
    if (!IsNetworkVersion(weights.networkVersion) ||
        buffer.size() != static_cast<std::size_t>(isFP8 ? network.fp8Bytes : network.int8Bytes))
        return Fail(Status::InvalidArgument, "weights: %zu bytes: not a %s network", buffer.size(),
                    GetNetworkName(weights.networkVersion));
    const auto addPart = [&](int offset, int bytes) noexcept {
        return AddView(buffer.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes)));
    };
    container::Mlp mlp;
    mlp.activation = container::MlpActivation::HGELUClamp;
    mlp.weightLayout = container::MatrixLayout::RowMajor;
    for (std::size_t i = 0; i < kNetworkLayers; ++i) {
        const bool isE4M3 = isFP8 && i < 3;
        const int outputs = network.outputs[i];
        container::MlpLayer layer;
        layer.inputChannels = static_cast<std::uint32_t>(network.inputs[i]);
        layer.outputChannels = static_cast<std::uint32_t>(outputs);
        layer.weightType = isE4M3 ? MlpDataType::FloatE4M3 : MlpDataType::Int8;
        OPENNTC_ASSIGN(layer.weightView, addPart(network.weightOffsets[i], network.inputs[i] * outputs));
        if (isE4M3) {
            layer.biasType = MlpDataType::Float16;
            OPENNTC_ASSIGN(layer.biasView, addPart(network.fp8BiasOffsets[i], 2 * outputs));
        } else {
            layer.scaleType = MlpDataType::Float32;
            layer.biasType = MlpDataType::Int32;
            const int scales = isFP8 ? network.fp8ScaleOffset : network.int8ScaleOffsets[i];
            const int biases = isFP8 ? network.fp8BiasOffsets[i] : network.int8BiasOffsets[i];
            OPENNTC_ASSIGN(layer.scaleView, addPart(scales, 4 * outputs));
            OPENNTC_ASSIGN(layer.biasView, addPart(biases, 4 * outputs));
        }
        OPENNTC_CHECK(mlp.layers.PushBack(layer));
    }
    // LibNTC puts the Int8 network into the old slot, where its version 0.5 looks for it.
    if (isFP8)
        return document_.mlpVersions.PushBack(std::move(mlp));
    document_.mlp = std::move(mlp);
    return {};
}

inline Expected<void> WritableTextureSet::AddTexture(const Texture& texture) noexcept {
    container::TextureRecord record;
    OPENNTC_CHECK(record.name.Assign(texture.name));
    record.firstChannel = static_cast<std::uint32_t>(texture.firstChannel);
    record.numChannels = static_cast<std::uint32_t>(texture.numChannels);
    record.channelFormat = texture.channelFormat;
    record.rgbColorSpace = texture.rgbColorSpace;
    record.alphaColorSpace = texture.alphaColorSpace;
    record.bcFormat = texture.bcFormat;
    record.bcQuality = static_cast<std::uint32_t>(texture.bcQuality);
    if (!texture.bcModes.empty()) {
        // The struct in memory is the record of the file on little-endian machines.
        static_assert(sizeof(BlockCompressionMode) == 4 && std::endian::native == std::endian::little);
        OPENNTC_ASSIGN(record.bcAccelerationDataView, AddView(std::as_bytes(texture.bcModes)));
    }
    return document_.textures.PushBack(std::move(record));
}

inline Expected<void> WritableTextureSet::AddLatentImage(const LatentImage& image,
                                                         std::span<const std::byte> highRes,
                                                         std::span<const std::byte> lowRes) noexcept {
    if (!document_.latentShape)
        return Fail(Status::InvalidArgument, "latentShape: absent: call SetDescription first");
    const container::LatentShapeRecord& shape = *document_.latentShape;
    const auto isOfSize = [](const LatentGrid& grid, std::uint32_t features, std::uint32_t bits,
                             std::size_t bytes) {
        return bytes == GetLatentGridBytes(grid.width, grid.height, static_cast<int>(features),
                                           static_cast<int>(bits));
    };
    if (!isOfSize(image.highRes, shape.highResFeatures, shape.highResQuantBits, highRes.size()) ||
        !isOfSize(image.lowRes, shape.lowResFeatures, shape.lowResQuantBits, lowRes.size()))
        return Fail(Status::InvalidArgument, "latents[%zu]: %zu and %zu bytes: do not fit the grids",
                    document_.latents.size(), highRes.size(), lowRes.size());
    container::LatentImageRecord record;
    record.highResWidth = static_cast<std::uint32_t>(image.highRes.width);
    record.highResHeight = static_cast<std::uint32_t>(image.highRes.height);
    record.lowResWidth = static_cast<std::uint32_t>(image.lowRes.width);
    record.lowResHeight = static_cast<std::uint32_t>(image.lowRes.height);
    record.highResBitsPerPixel = shape.highResFeatures * shape.highResQuantBits;
    record.lowResBitsPerPixel = shape.lowResFeatures * shape.lowResQuantBits;
    OPENNTC_ASSIGN(record.highResView, AddView(highRes));
    OPENNTC_ASSIGN(record.lowResView, AddView(lowRes));
    return document_.latents.PushBack(record);
}

inline Expected<void> WritableTextureSet::AddColorMip(const ColorMip& mip) noexcept {
    container::ColorMipRecord record;
    record.width = static_cast<std::uint32_t>(mip.width);
    record.height = static_cast<std::uint32_t>(mip.height);
    record.latentMip = static_cast<std::uint32_t>(mip.neuralMip);
    record.positionLod = mip.positionLod;
    record.positionScale = mip.positionScale;
    return document_.colorMips.PushBack(record);
}

inline Expected<void> WritableTextureSet::Write(Stream& destination) noexcept {
    Array<std::span<const std::byte>> viewData(bytes_.GetAllocator());
    OPENNTC_CHECK(viewData.Reserve(views_.size()));
    for (const Extent& view : views_)
        OPENNTC_CHECK(viewData.PushBack(std::as_const(bytes_).AsSpan().subspan(view.offset, view.size)));
    OPENNTC_CHECK(container::LayOutViews(document_, std::as_const(viewData).AsSpan()));
    return container::WriteContainer(destination, {&document_, std::as_const(viewData).AsSpan()},
                                     bytes_.GetAllocator());
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
